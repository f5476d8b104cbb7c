"""What is told of the loops of a log: numbers with their intervals, what they are called, their main words."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any, NamedTuple

from dehyst.arrays import Array
from dehyst.data._closed_path import ClosedPath
from dehyst.data._plotted import Plotted

LARGE = 1e7  # a number with its interval from here on is written with an exponent
MOST_DECIMALS = 5  # of a number with its interval; smaller ones are written with an exponent


@dataclass(frozen=True, slots=True)
class LoopEstimate:
    """A number with its interval of 95 %, NaN where it could not be measured.

    Attributes
    ----------
    value, low, high
        [unit]
    unit
        "" where the units of the log are not known.
    """

    value: float
    low: float
    high: float
    unit: str = ""

    def __str__(self) -> str:
        """Return the number with half of its interval, as many digits as that has, and its unit."""
        half = 0.5 * (self.high - self.low)
        if not math.isfinite(self.value):
            return "unknown"
        unit = ""
        if self.unit:
            unit = f" {self.unit}"
        if not 1e-4 * abs(self.value) < half < math.inf:
            return f"{self.value:.4g}{unit}"
        decimals = max(0, 1 - math.floor(math.log10(half)))
        if decimals > MOST_DECIMALS or abs(self.value) >= LARGE:
            digits = 3
            if self.value:
                digits = max(3, 2 + math.floor(math.log10(abs(self.value) / half)))
            # Zeros at the end count: 0.004000 +- 0.000005.
            number = f"{self.value:#.{digits}g}".rstrip(".")
            if not self.value:
                number = "0"
            return f"{number} +- {half:.2g}{unit}"
        return f"{self.value:.{decimals}f} +- {half:.{decimals}f}{unit}"

    @property
    def is_change(self) -> bool:
        """Whether the interval leaves zero out."""
        return self.low > 0.0 or self.high < 0.0


@dataclass(frozen=True, slots=True, eq=False)
class MeasuredLoop:
    """One loop of a log; numbers are NaN where they could not be measured.

    Attributes
    ----------
    number
        From 1, in the order of time.
    recording
        Name of its recording.
    start, end
        [s], or numbers of samples where there are no time stamps.
    input_low, input_high, output_low, output_high
        Range of both signals. [input], [output]
    width
        Distance of the branches over the middle of the input's range. [output]
    width_input
        Distance of the branches beside the middle of the output's range. [input]
    opening_percent
        Largest distance of the branches, percent of the output's range in the whole log.
    area
        Enclosed area: work or loss of one cycle where the units make one. [work_unit]
    coercivity
        Half the distance of the two places where the output passes its reference (`Loops.output_reference`); of a
        butterfly, where it turns. [input]
    remanence
        Half the distance of the outputs where the input passes its reference (`Loops.input_reference`). [output]
    saturation_low, saturation_high
        Output at the lower and at the upper turn of the input. [output]
    slope_to_high, slope_from_high, slope_to_low, slope_from_low
        Slope over the last tenth of the way to a turn, and over the first tenth from it. [output/input]
    gap_percent
        Output at the end less that at the begin, at the same input; percent of the output's range in the whole log.
    closes
        Whether that is less than 2 %, than the noise makes, or than the output jumps while the input turns.
    orientation
        As it is drawn, output over input: "counter-clockwise", "clockwise", "mixed" (it crosses itself), "butterfly"
        (so does it, and the output turns on both ways) or "none" (it is narrower than 1 % of the output's range).
    completed
        Whether half of it was made by odd symmetry.
    wings
        Areas of a butterfly that are run through counter-clockwise and clockwise; `area` is their difference. None for
        other loops. [work_unit]
    errors
        Standard errors of the numbers that the noise of the samples makes.
    path
        Samples of input and output, (2, n); (2, 0) where only the largest loops were asked for.
    """

    number: int
    recording: str
    start: float
    end: float
    input_low: float
    input_high: float
    output_low: float
    output_high: float
    width: float
    width_input: float
    opening_percent: float
    area: float
    coercivity: float
    remanence: float
    saturation_low: float
    saturation_high: float
    slope_to_high: float
    slope_from_high: float
    slope_to_low: float
    slope_from_low: float
    gap_percent: float
    closes: bool
    orientation: str
    completed: bool
    wings: tuple[float, float] | None
    errors: Mapping[str, float]
    path: Array

    @property
    def depth(self) -> float:
        """How far the input goes. [input]"""
        return self.input_high - self.input_low

    def outputs_at(self, place: float) -> tuple[float, float]:
        """Return the output on the rising and on the falling branch at an input. [output]"""
        rising, falling = ClosedPath(*self.path).by_input()
        return rising.at(place).value, falling.at(place).value

    def inputs_at(self, place: float) -> tuple[float, float]:
        """Return the input where the output passes a value, rising and falling; of a butterfly, turns. [input]"""
        path = ClosedPath(*self.path)
        if self.orientation == "butterfly":
            up, down = path.turned_at()
            return up.value, down.value
        rising, falling = path.by_output()
        return rising.at(place).value, falling.at(place).value

    def as_dict(self) -> dict[str, Any]:
        """Return the numbers as plain values."""
        numbers = {name: getattr(self, name) for name in self.__slots__}
        del numbers["path"]
        return numbers | {"errors": dict(self.errors)}


class LoopNumber(NamedTuple):
    """What a number of a loop is called, a word of `Loops.units`, and where it is measured."""

    label: str
    unit: str
    where: str


NUMBERS = {
    "width": LoopNumber("width", "output", "between branches, at the middle of the input"),
    "width_input": LoopNumber(
        "width across", "input", "between branches, at the middle of the output"
    ),
    "opening_percent": LoopNumber("opening", "percent", "largest width, of the output's range"),
    "area": LoopNumber("area", "work", "enclosed by one cycle"),
    "coercivity": LoopNumber(
        "coercivity", "input", "half the distance of inputs at output {output}"
    ),
    "remanence": LoopNumber("remanence", "output", "half the distance of outputs at input {input}"),
    "saturation_high": LoopNumber("saturation, high", "output", "output at the upper turn"),
    "saturation_low": LoopNumber("saturation, low", "output", "output at the lower turn"),
    "slope_to_high": LoopNumber("slope to upper turn", "slope", "last tenth of the way"),
    "slope_from_high": LoopNumber("slope from upper turn", "slope", "first tenth of the way"),
    "slope_to_low": LoopNumber("slope to lower turn", "slope", "last tenth of the way"),
    "slope_from_low": LoopNumber("slope from lower turn", "slope", "first tenth of the way"),
    "gap_percent": LoopNumber("gap", "percent", "output at the end less that at the begin"),
}


@dataclass(frozen=True, eq=False)
class Loops(Plotted):
    """The numbers of all loops of a log.

    Attributes
    ----------
    loops
        Each of them, in the order of the recordings and of time.
    largest
        The largest ones: those whose input goes at least nine tenths as far as that of the largest loop, and that
        close, if half of them do; the largest one alone if they are fewer than three.
    estimates
        Name of a number -> its mean over the largest loops, with its interval.
    basis
        What the intervals are made of: ``"scatter of 11 loops"`` from three loops on, or ``"noise of the samples of
        loop 2"``.
    trends
        Change of width, area and gain from one of the largest loops to the next, with their intervals. [%/cycle]
        Empty with fewer than four.
    units
        Of "input", "output", "work", "slope" and "percent".
    input_reference, output_reference
        Where remanence and coercivity are measured: at ``"zero"``, where that lies well inside the range of the largest
        loops, or in the ``"middle"`` of the range.
    output_range
        Range of the output in the whole log, 100 % of every percentage. [output]
    count
        Loops of the log; more than 1000 are measured in part.
    name
        Of the first recording.
    input_name, output_name
        Names of the two signals.
    """

    loops: tuple[MeasuredLoop, ...]
    largest: tuple[MeasuredLoop, ...]
    estimates: Mapping[str, LoopEstimate]
    basis: str
    trends: Mapping[str, LoopEstimate]
    units: Mapping[str, str]
    input_reference: str
    output_reference: str
    output_range: float
    count: int
    name: str
    input_name: str
    output_name: str

    @property
    def input_label(self) -> str:
        """Axis label of the input, ``name [unit]``."""
        return labelled(self.input_name, self.units["input"])

    @property
    def output_label(self) -> str:
        """Axis label of the output, ``name [unit]``."""
        return labelled(self.output_name, self.units["output"])

    @property
    def orientation(self) -> str:
        """Of most of the largest loops."""
        names = [loop.orientation for loop in self.largest]
        return max(sorted(set(names)), key=names.count)

    @property
    def area_word(self) -> str:
        """What the enclosed area is: a "loss" per cycle where the units make a work, else an "area"."""
        if "J" in self.units["work"]:
            return "loss"
        return "area"

    @property
    def opening_words(self) -> str:
        """Direction and largest opening of the largest loops."""
        # Two digits without an exponent: 100, never 1e+02.
        percent = float(f"{self.estimates['opening_percent'].value:.2g}")
        if self.orientation == "butterfly":
            return f"butterfly loop, opening {percent:g} % of range"
        if self.orientation == "none":
            return f"no loop (branches at most {percent:g} % of range apart)"
        return f"loop {self.orientation}, opening {percent:g} % of range"

    @property
    def wing_words(self) -> str:
        """What the numbers of a butterfly mean; empty for other loops."""
        wings = [loop.wings for loop in self.largest if loop.wings is not None]
        if self.orientation != "butterfly" or not wings:
            return ""
        lags, leads = (sum(areas) / len(wings) for areas in zip(*wings, strict=True))
        return (
            f"the loop crosses itself: its {self.area_word} is that of the counter-clockwise wing, {lags:.3g}, less "
            f"that of the clockwise one, {leads:.3g}"
        )

    @property
    def words(self) -> str:
        """Width, area and coercivity of the largest loops in one line."""
        numbers = self.estimates
        per_cycle = ""
        if self.area_word == "loss":
            per_cycle = " per cycle"
        parts = (
            f"width {numbers['width']} at the middle",
            f"{self.area_word} {numbers['area']}{per_cycle}",
            f"coercivity {numbers['coercivity']}",
        )
        return ", ".join(parts)

    @property
    def rows(self) -> list[tuple[str, str, str]]:
        """What each number of the largest loops is called, the number with its interval, and where it is measured."""
        places = {"input": self.input_reference, "output": self.output_reference}
        rows = []
        for name, kind in NUMBERS.items():
            label = kind.label
            where = kind.where.format(**places)
            if name == "area":
                label = self.area_word
            elif name == "coercivity" and self.orientation == "butterfly":
                where = "half the distance of inputs at which the output turns"
            rows.append((label, str(self.estimates[name]), where))
        return rows

    @property
    def summary(self) -> dict[str, Any]:
        """Numbers of the largest loops as plain values."""
        return {
            "count": len(self.largest),
            "orientation": self.orientation,
            "basis": self.basis,
            "input_reference": self.input_reference,
            "output_reference": self.output_reference,
            "estimates": {name: asdict(value) for name, value in self.estimates.items()},
        }

    def as_dict(self) -> dict[str, Any]:
        """Return all numbers as plain values, the content of ``dehyst loops --json``."""
        return {
            "input": self.input_name,
            "output": self.output_name,
            "count": self.count,
            "units": dict(self.units),
            "output_range": self.output_range,
            "largest": self.summary | {"numbers": [loop.number for loop in self.largest]},
            "trends": {name: asdict(value) for name, value in self.trends.items()},
            "loops": [loop.as_dict() for loop in self.loops],
        }


def labelled(name: str, unit: str) -> str:
    """Return ``name [unit]``, or the name alone."""
    if unit:
        return f"{name} [{unit}]"
    return name
