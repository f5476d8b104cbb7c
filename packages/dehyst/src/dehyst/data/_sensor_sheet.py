"""What is told of a sensor: the figures of its data sheet, what they are called, and where they are measured."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from dehyst.arrays import Array
from dehyst.data._loop_numbers import LoopEstimate, labelled
from dehyst.data._plotted import Plotted
from dehyst.data._policy import POLICY
from dehyst.data._straight_lines import StraightLine

# Names of the lines that deviations are measured from, and what they are.
LINES = {
    "terminal": "through the readings at both ends",
    "best": "of the least largest deviation",
    "zero": "through the reading at the lower end, of the least largest deviation",
    "ideal": "reading = quantity, as a corrected reading should be",
}


LABELS = {
    "zero": "reading at the lower end",
    "output": "full-scale output, FS",
    "sensitivity": "sensitivity",
    "terminal": "non-linearity, terminal",
    "best": "non-linearity, best",
    "through_zero": "non-linearity, zero-based",
    "hysteresis": "hysteresis",
    "repeatability": "repeatability",
    "zero_return": "zero return",
    "creep_upper": "creep at the upper end",
    "creep_lower": "creep at the lower end",
    "combined": "combined error",
    "rms": "rms error",
}
NEAR_ZERO = 5e-4  # a place so near zero is called zero, share of the range
SHORT = {"zero": "zero", "output": "FS"}


@dataclass(frozen=True, slots=True)
class SheetFigure:
    """A figure of the data sheet.

    Attributes
    ----------
    value
        Of the mean of all cycles, with its interval of 95 %. NaN where it could not be measured.
    worst
        Largest in size of a single cycle, or hold. NaN where there are no single ones.
    cycle
        Number of that cycle, from 1; 0 where there are no single ones.
    place
        Quantity at which it is measured; NaN for a figure of the whole range. [quantity]
    direction
        "rising" or "falling" for a figure of one direction, else "".
    seconds
        Length of the hold of a creep, else NaN. [s]
    count
        Cycles, or holds, that it is the mean of.
    why
        Why there is none, and what to log; "" where there is one.
    """

    value: LoopEstimate
    worst: float = math.nan
    cycle: int = 0
    place: float = math.nan
    direction: str = ""
    seconds: float = math.nan
    count: int = 0
    why: str = ""

    def as_dict(self) -> dict[str, Any]:
        """Return the figure as plain values."""
        return asdict(self)


@dataclass(frozen=True, eq=False)
class DataSheet(Plotted):
    """The figures of a sensor, as data sheets define them.

    Attributes
    ----------
    figures
        Name -> figure: "zero", "output", "sensitivity", "terminal", "best", "through_zero", "hysteresis",
        "repeatability", "zero_return", "creep_upper", "creep_lower", "combined", "rms", and for every signal of the
        recordings "zero with NAME" and "output with NAME".
    line_name, line
        Which straight line sensitivity, combined error and rms are measured from, and its slope [reading/quantity] and
        level [reading].
    places
        Quantities at which curves are read, (m,). [quantity]
    rising, falling
        Reading of every full stroke at these places, (strokes, m). [reading]
    mean
        Mean of the cycles, rising and falling, (2, m); NaN where the log has no stroke of a direction. [reading]
    cycles
        Pairs of numbers of strokes, (cycles, 2): a rising one and a falling one next to each other.
    low, high
        The range of the quantity. [quantity]
    full_scale
        Size of the full-scale output, 100 % FS. [reading]
    stepped
        Whether the log goes in steps with rests: then curves are read at the end of each rest.
    holds
        Level and deviation from the line at begin and end of the holds that creep is measured on, (holds, 3).
        [quantity], [% FS]
    notes
        What to know about the figures, in sentences.
    units
        Of "reading", "quantity", "slope" and "percent".
    name
        Of the first recording.
    reading_name, quantity_name
        Names of the two signals.
    """

    figures: Mapping[str, SheetFigure]
    line_name: str
    line: StraightLine
    places: Array
    rising: Array
    falling: Array
    mean: Array
    cycles: tuple[tuple[int, int], ...]
    low: float
    high: float
    full_scale: float
    stepped: bool
    holds: Array
    notes: tuple[str, ...]
    units: Mapping[str, str]
    name: str
    reading_name: str
    quantity_name: str

    @property
    def quantity_label(self) -> str:
        """Axis label of the quantity, ``name [unit]``."""
        return labelled(self.quantity_name, self.units["quantity"])

    @property
    def reading_label(self) -> str:
        """Axis label of the reading, ``name [unit]``."""
        return labelled(self.reading_name, self.units["reading"])

    def deviation(self, curves: Array) -> Array:
        """Return readings at the places less the line, (n, m) -> (n, m). [% FS]"""
        return np.asarray(100.0 * (curves - self.line.at(self.places)) / self.full_scale)

    @property
    def caption(self) -> str:
        """How many strokes the figures are of, and how they were read."""
        rising, falling = len(self.rising), len(self.falling)
        cycles = len(self.cycles)
        plural = "s"
        if cycles == 1:
            plural = ""
        words = f"{rising} rising and {falling} falling strokes, {cycles} cycle{plural}"
        if self.stepped:
            words += f", read at the end of {len(self.places)} steps"
        return words

    @property
    def words(self) -> str:
        """Non-linearity, hysteresis, repeatability and combined error in one line, percent of full scale."""
        parts = []
        for name in ("terminal", "best", "hysteresis", "repeatability", "combined"):
            figure = self.figures[name]
            if not figure.why:
                parts.append(f"{label_of(name)} {figure.value}")
        return "; ".join(parts)

    @property
    def rows(self) -> list[tuple[str, str, str, str]]:
        """Label, value with its interval, worst single cycle, and where it is measured, of every figure."""
        rows = []
        for name, figure in self.figures.items():
            if figure.why:
                rows.append((label_of(name), "unknown", "", ""))
            else:
                rows.append(
                    (label_of(name), str(figure.value), self._worst(figure), self._where(figure))
                )
        return rows

    @property
    def basis(self) -> str:
        """What the figures refer to, and what their intervals are made of."""
        unit = self.units["quantity"]
        high = with_its_unit(self._rounded(self.high), unit)
        span = f"{self._rounded(self.low):.4g} to {high}"
        full_scale = with_its_unit(self.full_scale, self.units["reading"])
        count = self.figures["output"].count
        intervals = "the noise of the samples, as far as they show it"
        if count >= POLICY.fewest_scatter:
            intervals = f"the scatter of {count} cycles"
        line = f"{self.line_name} line, {LINES[self.line_name]}"
        return (
            f"100 % are the full scale, {full_scale} over {span}; errors from the {line}; "
            f"intervals of 95 %: {intervals}"
        )

    @property
    def lacking(self) -> list[str]:
        """What could not be measured, and what to log, in sentences."""
        labels: dict[str, list[str]] = {}
        for name, figure in self.figures.items():
            if figure.why:
                labels.setdefault(figure.why, []).append(label_of(name))
        return [f"{', '.join(names)}: {why}" for why, names in labels.items()]

    def _worst(self, figure: SheetFigure) -> str:
        if not math.isfinite(figure.worst):
            return ""
        words = f"{figure.worst:.3g}"
        if figure.cycle:
            words += f" ({figure.cycle})"
        return words

    def _rounded(self, place: float) -> float:
        """A quantity without what is nothing beside the range: the zero of a reference is never quite zero."""
        if abs(place) < NEAR_ZERO * (self.high - self.low):
            return 0.0
        return place

    def _where(self, figure: SheetFigure) -> str:
        """Where a figure is measured."""
        parts = []
        if math.isfinite(figure.seconds):
            parts.append(f"in {figure.seconds:.4g} s")
        if math.isfinite(figure.place):
            place = self._rounded(figure.place)
            parts.append(f"at {with_its_unit(place, self.units['quantity'])}")
        if figure.direction:
            parts.append(figure.direction)
        return " ".join(parts)

    def as_dict(self) -> dict[str, Any]:
        """Return all figures as plain values, the content of ``dehyst sensor --json``."""
        return {
            "reading": self.reading_name,
            "quantity": self.quantity_name,
            "units": dict(self.units),
            "range": [self.low, self.high],
            "full_scale": self.full_scale,
            "line": {"name": self.line_name, "slope": self.line.slope, "level": self.line.level},
            "cycles": len(self.cycles),
            "rising": len(self.rising),
            "falling": len(self.falling),
            "stepped": self.stepped,
            "figures": {name: figure.as_dict() for name, figure in self.figures.items()},
            "curves": {
                "places": self.places.tolist(),
                "rising": self.rising.tolist(),
                "falling": self.falling.tolist(),
            },
            "notes": list(self.notes),
        }


def label_of(name: str) -> str:
    """What a figure is called; those of another signal have its name."""
    figure, _, signal = name.partition(" with ")
    if signal:
        return f"{SHORT[figure]} with {signal}"
    return LABELS[name]


def with_its_unit(value: float, unit: str) -> str:
    """Return a number with its unit, if it has one."""
    return f"{value:.4g} {unit}".rstrip()
