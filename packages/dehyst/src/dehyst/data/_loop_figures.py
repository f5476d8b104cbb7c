"""The numbers of every loop of a log: width, opening, area, coercivity, remanence, slopes, and how they change."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any, NamedTuple

import numpy as np

from dehyst.arrays import Array, Mask
from dehyst.data._closed_path import Branch, ClosedPath, ReadValue
from dehyst.data._cycles import LoopPath, half_loop, loop_paths, values_at
from dehyst.data._loops import turning_points
from dehyst.data._policy import POLICY
from dehyst.data._ranges import range_over, robust_range
from dehyst.data._recording import Recording, require_recordings
from dehyst.errors import ExcitationError
from dehyst.student import quantile
from dehyst.units import work_unit

CONFIDENCE = 0.95
MOST_DECIMALS = 5  # of a number with its interval; smaller ones are written with an exponent
NORMAL = 1_000_000  # degrees of freedom of an interval that the noise of many samples makes


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
        if not half > 1e-4 * abs(self.value):
            return f"{self.value:.4g}{unit}"
        if not half > 0.0:
            return f"0{unit}"
        decimals = max(0, 1 - math.floor(math.log10(half)))
        if decimals > MOST_DECIMALS:
            return f"{self.value:.3g} +- {half:.2g}{unit}"
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
        Half the distance of the two places where the output passes its reference (`Loops.output_reference`). [input]
    remanence
        Half the distance of the outputs where the input passes its reference (`Loops.input_reference`). [output]
    saturation_low, saturation_high
        Output at the lower and at the upper turn of the input. [output]
    slope_to_high, slope_from_high, slope_to_low, slope_from_low
        Slope over the last tenth of the way to a turn, and over the first tenth from it. [output/input]
    gap_percent
        Output at the end less that at the begin, at the same input; percent of the output's range in the whole log.
    closes
        Whether that is less than 2 %, or than the noise makes.
    orientation
        As it is drawn, output over input: "counter-clockwise", "clockwise", "mixed" (it crosses itself) or "none" (it
        is narrower than 1 % of the output's range).
    completed
        Whether half of it was made by odd symmetry.
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
        """Return the input where the output passes a value, rising and falling. [input]"""
        rising, falling = ClosedPath(*self.path).by_output()
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
    "opening_percent": LoopNumber(
        "opening", "percent", "largest width, of the output's range"
    ),
    "area": LoopNumber("area", "work", "enclosed by one cycle"),
    "coercivity": LoopNumber(
        "coercivity", "input", "half the distance of inputs at output {output}"
    ),
    "remanence": LoopNumber(
        "remanence", "output", "half the distance of outputs at input {input}"
    ),
    "saturation_high": LoopNumber("saturation, high", "output", "output at the upper turn"),
    "saturation_low": LoopNumber("saturation, low", "output", "output at the lower turn"),
    "slope_to_high": LoopNumber("slope to upper turn", "slope", "last tenth of the way"),
    "slope_from_high": LoopNumber("slope from upper turn", "slope", "first tenth of the way"),
    "slope_to_low": LoopNumber("slope to lower turn", "slope", "last tenth of the way"),
    "slope_from_low": LoopNumber("slope from lower turn", "slope", "first tenth of the way"),
    "gap_percent": LoopNumber(
        "gap", "percent", "output at the end less that at the begin"
    ),
}


@dataclass(frozen=True, eq=False)
class Loops:
    """The numbers of all loops of a log.

    Attributes
    ----------
    loops
        Each of them, in the order of the recordings and of time.
    largest
        The largest ones: those whose input goes at least nine tenths as far as that of the largest loop, and that
        close, if any do; the largest one alone if they are fewer than three.
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
        percent = self.estimates["opening_percent"].value
        if self.orientation == "none":
            return f"no loop (branches at most {percent:.2g} % of range apart)"
        return f"loop {self.orientation}, opening {percent:.2g} % of range"

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
            if name == "area":
                label = self.area_word
            rows.append((label, str(self.estimates[name]), kind.where.format(**places)))
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
            "count": self.count,
            "units": dict(self.units),
            "output_range": self.output_range,
            "largest": self.summary | {"numbers": [loop.number for loop in self.largest]},
            "trends": {name: asdict(value) for name, value in self.trends.items()},
            "loops": [loop.as_dict() for loop in self.loops],
        }


class _Spot(NamedTuple):
    """A loop before it is measured."""

    recording: Recording
    rows: Array  # samples that count, as numbers of the recording
    path: LoopPath
    completed: bool


def loops(recordings: Recording | Sequence[Recording], *, symmetric: bool = False) -> Loops:
    """Measure every closed loop of a log.

    A loop begins where the input turns and ends where it comes back to that value, after swings of more than 5 % of
    its range; small loops inside a large one are loops of their own.

    Parameters
    ----------
    recordings
        One, or several of one actuator.
    symmetric
        Whether half a loop, where there is no whole one, is completed by odd symmetry about its centre: the other
        branch is -y(-x). Only who knows the actuator can tell that it is so.

    Raises
    ------
    ExcitationError
        If there is no closed loop.

    Examples
    --------
    A play of half width 0.5 and weight 2: its branches are 2 (0.5) 2 apart.

    >>> import dehyst
    >>> x = 3.0 * np.sin(np.linspace(0.0, 8.0 * np.pi, 2001))
    >>> y = dehyst.PrandtlIshlinskii([0.5], [2.0]).simulate(x)
    >>> measured = loops(Recording(x, y, input_unit="mm", output_unit="N"))
    >>> largest = measured.largest[0]
    >>> round(largest.width, 6), round(largest.coercivity, 6), largest.orientation
    (2.0, 0.5, 'counter-clockwise')
    >>> f"{measured.estimates['area'].value:.3f} {measured.estimates['area'].unit}"
    '10.000 mJ'
    """
    records = require_recordings(recordings)
    measured = measured_loops(records, symmetric=symmetric)
    if measured is None:
        raise _no_loop(records, symmetric)
    return measured


def measured_loops(
    recordings: Sequence[Recording], *, symmetric: bool = False, largest_only: bool = False
) -> Loops | None:
    """Return the loops, or None where there is none; with `largest_only` no others are measured, which is faster."""
    spots = _spots(recordings, symmetric)
    if not spots:
        return None
    count = len(spots)
    deepest = max(spot.path.depth for spot in spots)
    large = [spot for spot in spots if spot.path.depth >= POLICY.loops_large * deepest]
    most = POLICY.most_loops
    if largest_only:
        spots, most = large, POLICY.most_largest
    numbers = np.arange(len(spots))
    if numbers.size > most:
        numbers = np.unique(np.linspace(0, numbers.size - 1, most).astype(np.int64))
    output_range = robust_range([record.output for record in recordings])
    references = _references(large[: POLICY.most_largest])
    first = recordings[0]
    factor, unit = work_unit(first.input_unit, first.output_unit)
    scale = _Measures(output_range, factor, references, not largest_only)
    measured = [scale.loop(spots[k], int(k) + 1) for k in numbers.tolist()]
    chosen = [loop for loop in measured if loop.depth >= POLICY.loops_large * deepest]
    # One that does not close is no cycle of the steady state, unless all are like that.
    if any(loop.closes for loop in chosen):
        chosen = [loop for loop in chosen if loop.closes]
    # Of so few loops of several sizes a mean has no interval that is true: the largest one stands for itself.
    basis = f"scatter of {len(chosen)} loops"
    if len(chosen) < POLICY.fewest_scatter:
        chosen = [max(chosen, key=lambda loop: loop.depth)]
        basis = f"noise of the samples of loop {chosen[0].number}"
    slope = ""
    if first.input_unit and first.output_unit:
        divisor = first.input_unit
        if "/" in divisor:
            divisor = f"({divisor})"
        slope = f"{first.output_unit}/{divisor}"
    units = {
        "input": first.input_unit,
        "output": first.output_unit,
        "work": unit,
        "slope": slope,
        "percent": "%",
    }
    estimates = {}
    for name, kind in NUMBERS.items():
        estimates[name] = _estimate(chosen, name, units[kind.unit])
    names = ["zero" if reference is not None else "middle" for reference in references]
    return Loops(
        tuple(measured),
        tuple(chosen),
        estimates,
        basis,
        _trends(chosen),
        units,
        names[0],
        names[1],
        output_range,
        count,
    )


def _spots(recordings: Sequence[Recording], symmetric: bool) -> list[_Spot]:
    """All loops; half a loop where that is asked for and there is no whole one."""
    low, high = range_over([record.input for record in recordings])
    swing = POLICY.turn_fraction * (high - low)
    whole: list[_Spot] = []
    halves: list[_Spot] = []
    if not swing > 0.0:
        return []
    for record in recordings:
        counts: Mask = np.ones(len(record), dtype=np.bool_)
        counts[list(record.left_out)] = False
        for piece in record.pieces:
            rows = piece.start + np.flatnonzero(counts[piece])
            x = record.input[rows]
            for path in loop_paths(x, swing):
                whole.append(_Spot(record, rows, path, False))
            half = half_loop(x, swing)
            if half is not None:
                halves.append(_Spot(record, rows, half, True))
    if whole or not symmetric or not halves:
        return whole
    return [max(halves, key=lambda spot: spot.path.depth)]


def _references(spots: Sequence[_Spot]) -> tuple[float | None, float | None]:
    """Zero of input and of output, where it lies well inside the range of the largest loops; else None."""
    references: list[float | None] = []
    for signal in ("input", "output"):
        parts = []
        for spot in spots:
            parts.append(values_at(getattr(spot.recording, signal)[spot.rows], spot.path.places))
        low, high = range_over(parts)
        inside = POLICY.zero_inside * (high - low)
        references.append(0.0 if low + inside <= 0.0 <= high - inside else None)
    return references[0], references[1]


@dataclass(frozen=True)
class _Measures:
    """What the numbers of a loop refer to."""

    output_range: float
    factor: float  # Of the area, from the units of the log
    references: tuple[float | None, float | None]
    with_path: bool  # Whether loops keep their samples, which for long logs are many

    def loop(self, spot: _Spot, number: int) -> MeasuredLoop:
        """Measure a loop."""
        places = spot.path.places
        x = values_at(spot.recording.input[spot.rows], places)
        y = values_at(spot.recording.output[spot.rows], places)
        rows = values_at(spot.rows.astype(np.float64), places)
        time = rows
        if spot.recording.time is not None:
            time = values_at(spot.recording.time, rows)
        if spot.completed:
            x, y = _completed(x, y)
        path = ClosedPath(x, y)
        readings = self._readings(path)
        openings = path.openings()
        gap = 100.0 * float(y[-1] - y[0]) / self.output_range
        noise = 100.0 * math.sqrt(2.0) * path.noise[1] / self.output_range
        closed_within = max(100.0 * POLICY.loop_closed, POLICY.closed_errors * noise)
        drawn = np.array([x, y])
        if not self.with_path:
            drawn = drawn[:, :0]
        if spot.completed:
            gap = 0.0
        values = {name: reading.value for name, reading in readings.items()}
        # A cell is as wide as a twenty-fourth of the loop, where the middle is read at one place.
        widest = max(float(np.max(np.abs(openings))), np.nan_to_num(readings["width"].value))
        opening = 100.0 * widest / self.output_range
        errors = {name: reading.error for name, reading in readings.items()}
        # A cell has a twenty-fourth of the samples of either branch.
        samples = max(1.0, x.size / (2.0 * openings.size))
        errors["opening_percent"] = noise / math.sqrt(samples)
        errors["gap_percent"] = noise
        return MeasuredLoop(
            number=number,
            recording=spot.recording.name,
            start=float(np.min(time)),
            end=float(np.max(time)),
            input_low=float(np.min(x)),
            input_high=float(np.max(x)),
            output_low=float(np.min(y)),
            output_high=float(np.max(y)),
            opening_percent=opening,
            gap_percent=gap,
            closes=abs(gap) <= closed_within,
            orientation=self._orientation(openings),
            completed=spot.completed,
            errors=errors,
            path=drawn,
            **values,
        )

    def _readings(self, path: ClosedPath) -> dict[str, ReadValue]:
        """Read everything that is read at one place of the loop."""
        by_input, by_output = path.by_input(), path.by_output()
        x_middle, y_middle = _middle(path.x), _middle(path.y)
        x_reference, y_reference = self.references
        if x_reference is None:
            x_reference = x_middle
        if y_reference is None:
            y_reference = y_middle
        rising, falling = by_input
        high, low = float(np.max(path.x)), float(np.min(path.x))
        saturation_high, slope_to_high = rising.near_end(high)
        saturation_low, slope_to_low = falling.near_end(low)
        area = path.area
        return {
            "area": ReadValue(self.factor * abs(area.value), self.factor * area.error),
            "width": _apart(by_input, x_middle, 1.0),
            "width_input": _apart(by_output, y_middle, 1.0),
            "remanence": _apart(by_input, x_reference, 0.5),
            "coercivity": _apart(by_output, y_reference, 0.5),
            "saturation_high": saturation_high,
            "saturation_low": saturation_low,
            "slope_to_high": slope_to_high,
            "slope_to_low": slope_to_low,
            "slope_from_high": falling.near_end(high)[1],
            "slope_from_low": rising.near_end(low)[1],
        }

    def _orientation(self, openings: Array) -> str:
        """The output is lower while the input rises: the loop runs counter-clockwise."""
        lag = float(np.sum(openings[openings > 0.0]))
        lead = float(-np.sum(openings[openings < 0.0]))
        if lag + lead < POLICY.loop_narrow * self.output_range * openings.size:
            return "none"
        if min(lag, lead) > POLICY.loop_mixed * max(lag, lead):
            return "mixed"
        if lag > lead:
            return "counter-clockwise"
        return "clockwise"


def _apart(branches: tuple[Branch, Branch], place: float, share: float) -> ReadValue:
    """Distance of two branches at a place."""
    first, second = (branch.at(place) for branch in branches)
    error = share * math.hypot(first.error, second.error)
    return ReadValue(share * abs(first.value - second.value), error)


def _middle(values: Array) -> float:
    return 0.5 * (float(np.min(values)) + float(np.max(values)))


def _completed(x: Array, y: Array) -> tuple[Array, Array]:
    """A branch, and behind it the same turned about the middle between its ends, so that the loop closes."""
    ends = x[0] + x[-1], y[0] + y[-1]
    return np.append(x, ends[0] - x[1:]), np.append(y, ends[1] - y[1:])


def _estimate(chosen: Sequence[MeasuredLoop], name: str, unit: str) -> LoopEstimate:
    """Mean over loops, with the interval of their scatter, or of the noise of so few that they have none."""
    values = np.array([getattr(loop, name) for loop in chosen])
    errors = np.array([loop.errors[name] for loop in chosen])
    count = values.size
    mean = float(np.mean(values))
    # Samples that lie alike in every cycle scatter less than they err.
    reach = quantile(CONFIDENCE, NORMAL) * float(np.linalg.norm(errors)) / count
    if count >= POLICY.fewest_scatter:
        scatter = float(np.std(values, ddof=1)) / math.sqrt(count)
        reach = max(reach, quantile(CONFIDENCE, count - 1) * scatter)
    return LoopEstimate(mean, mean - reach, mean + reach, unit)


def _trends(chosen: Sequence[MeasuredLoop]) -> dict[str, LoopEstimate]:
    """Change from cycle to cycle: a line through the numbers of the largest loops, in percent of their mean."""
    count = len(chosen)
    if count < POLICY.fewest_trend:
        return {}
    numbers = {
        "width": [loop.width for loop in chosen],
        "area": [loop.area for loop in chosen],
        "gain": [_gain(loop) for loop in chosen],
    }
    trends = {}
    place = np.arange(count) - 0.5 * (count - 1)
    spread = float(place @ place)
    for name, series in numbers.items():
        values = np.array(series)
        mean = float(np.mean(values))
        if not abs(mean) > 0.0:
            continue
        slope = float(place @ values) / spread
        left = values - mean - slope * place
        error = math.sqrt(float(left @ left) / (count - 2) / spread)
        reach = quantile(CONFIDENCE, count - 2) * error
        percent = 100.0 / abs(mean)
        trends[name] = LoopEstimate(
            percent * slope, percent * (slope - reach), percent * (slope + reach), "%/cycle"
        )
    return trends


def _gain(loop: MeasuredLoop) -> float:
    """Output over input from turn to turn. [output/input]"""
    return (loop.saturation_high - loop.saturation_low) / loop.depth


def _no_loop(records: Sequence[Recording], symmetric: bool) -> ExcitationError:
    """What to log, or to type, where the input never comes back."""
    turns = 0
    half = 0.0
    low, high = range_over([record.input for record in records])
    for record in records:
        for piece in record.pieces:
            x = record.input[piece]
            swing = POLICY.turn_fraction * (high - low)
            if swing > 0.0:
                turns += max(0, turning_points(x, swing).size - 2)
                half = max(half, float(np.ptp(x)))
    cure = ""
    if half > 0.0 and not symmetric:
        cure = (
            ", or, if you know that the other half is the same turned about the centre, complete it: --symmetric "
            "(in Python symmetric=True)"
        )
    return ExcitationError(
        f"the log holds no closed loop: its input turns {turns} times by more than "
        f"{100 * POLICY.turn_fraction:g} % of its range ({low:.4g} to {high:.4g}) and never comes back to where it was, "
        f"so no loop has an area or a width. Log at least one whole cycle, there and back{cure}.",
        turns=turns,
    )
