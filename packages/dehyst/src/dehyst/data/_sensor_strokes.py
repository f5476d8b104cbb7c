"""Strokes of a sensor over the whole range of its quantity: where they are in a log, and how they are read."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array
from dehyst.data._holds import Hold
from dehyst.data._policy import POLICY
from dehyst.data._recording import Recording, counted_rows

FITTED = 3  # samples that make a line; fewer are shifted to the place along the whole line
NARROW = 0.1  # samples within this share of the reach make no line
STEP_END = 0.2  # share of a step whose mean is its reading


class SensorPart(NamedTuple):
    """Samples that count and follow each other."""

    quantity: Array
    reading: Array
    time: Array  # [s], or numbers of samples
    signals: Mapping[str, Array]  # such as the temperature


class StrokeSamples(NamedTuple):
    """A stroke as it is read, sorted by the quantity, (n,) each."""

    quantity: Array
    reading: Array
    places: npt.NDArray[np.int64]  # in its part


@dataclass(frozen=True, eq=False)
class Stroke:
    """A way over the whole range, in one direction."""

    part: SensorPart
    begin: int
    end: int  # behind the last sample
    rising: bool
    holds: tuple[Hold, ...]

    @property
    def inner_holds(self) -> list[Hold]:
        """Holds that begin and end within the stroke."""
        return [hold for hold in self.holds if self.begin < hold.begin and hold.end < self.end]

    @property
    def duration(self) -> float:
        """Time that the whole range would take at the pace between its ends. [unit of time]"""
        quantity = self.part.quantity[self.begin : self.end]
        low, high = float(np.min(quantity)), float(np.max(quantity))
        within = np.flatnonzero(np.abs(quantity - 0.5 * (low + high)) <= 0.4 * (high - low))
        if within.size < 2:
            return 0.0
        time = self.part.time[self.begin : self.end]
        return float(time[within[-1]] - time[within[0]]) / 0.8

    def samples(self, stepped: bool, near: float) -> StrokeSamples:
        """Quantity and reading along it, sorted by the quantity: at the ends of its steps if it has some."""
        if stepped:
            points = self._steps(0.5 * near)
            quantity = [float(np.mean(self.part.quantity[point])) for point in points]
            reading = [float(np.mean(self.part.reading[point])) for point in points]
            unsorted = StrokeSamples(
                np.array(quantity),
                np.array(reading),
                np.array([point.stop - 1 for point in points]),
            )
        else:
            places = self._moving(near)
            unsorted = StrokeSamples(self.part.quantity[places], self.part.reading[places], places)
        order = np.argsort(unsorted.quantity, kind="stable")
        return StrokeSamples(
            unsorted.quantity[order], unsorted.reading[order], unsorted.places[order]
        )

    def _moving(self, near: float) -> npt.NDArray[np.int64]:
        """All samples between the rests at its ends, in which readings creep."""
        begin, end = self.begin, self.end
        first, last = self.part.quantity[[begin, end - 1]].tolist()
        for hold in self._overlapping:
            if abs(hold.level - first) <= near:
                begin = max(begin, hold.end - 1)
            elif abs(hold.level - last) <= near:
                end = min(end, hold.begin + 1)
        return np.arange(begin, end)

    def _steps(self, near: float) -> list[slice]:
        """Ends of its steps, where they are read."""
        usual = int(np.median([hold.end - hold.begin for hold in self.inner_holds]))
        points = []
        ends = {self.begin, self.end - 1}
        first, final = self.part.quantity[[self.begin, self.end - 1]].tolist()
        for hold in self._overlapping:
            last = hold.end
            if abs(hold.level - first) <= near:
                ends.discard(self.begin)
            elif abs(hold.level - final) <= near:
                # At the far end the sensor may be held for long to see its creep, which is no part of the curve.
                last = min(hold.end, hold.begin + usual)
                ends.discard(self.end - 1)
            size = max(1, round(STEP_END * min(usual, last - hold.begin)))
            points.append(slice(last - size, last))
        # Where it does not rest at an end, the turn itself is read.
        for place in sorted(ends):
            points.append(slice(place, place + 1))
        return points

    @property
    def _overlapping(self) -> list[Hold]:
        return [hold for hold in self.holds if hold.begin < self.end and hold.end > self.begin]


def paired(strokes: Sequence[Stroke], rising: bool, span: float) -> list[tuple[int, int]]:
    """Numbers of strokes of which the first one rises, or falls, and the second one leads back from where it ended."""
    pairs = []
    for k in range(1, len(strokes)):
        before, after = strokes[k - 1], strokes[k]
        if before.part is not after.part or before.rising != rising or after.rising == rising:
            continue
        # Behind the first one only noise, or what follows a rest, may lie.
        between = before.part.quantity[before.end - 1 : after.begin + 1]
        if float(np.ptp(between)) <= (1.0 - POLICY.full_stroke) * span:
            pairs.append((k - 1, k))
    return pairs


def sensor_parts(records: Sequence[Recording]) -> list[SensorPart]:
    """Samples that count, piece by piece."""
    parts = []
    for record in records:
        for rows, time in counted_rows(record):
            signals = {name: values[rows] for name, values in record.schedules.items()}
            parts.append(SensorPart(record.output[rows], record.input[rows], time, signals))
    return parts


def read_at(
    samples: StrokeSamples, places: Array, reach: float, slope: float
) -> tuple[Array, Array]:
    """Readings of a stroke at places, and their standard errors, (m,) each.

    Read is a line through the samples near a place; between those beside it where none is near. What the samples
    scatter about the line makes the error; it is not known, NaN, where there are too few of them.
    """
    quantity, reading, _ = samples
    values = np.interp(places, quantity, reading)
    errors = np.full(places.size, np.nan)
    for k, place in enumerate(places.tolist()):
        first = int(np.searchsorted(quantity, place - reach, "left"))
        last = int(np.searchsorted(quantity, place + reach, "right"))
        near, at = (quantity[first:last] - place) / reach, reading[first:last]
        if near.size >= FITTED and float(np.ptp(near)) > NARROW:
            shift, middle = float(np.mean(near)), float(np.mean(at))
            along, beside = near - shift, at - middle
            spread = float(along @ along)
            tilt = float(along @ beside) / spread
            values[k] = middle - tilt * shift
            if near.size > FITTED:
                scatter = float(np.linalg.norm(beside - tilt * along)) / math.sqrt(near.size - 2)
                errors[k] = scatter * math.sqrt(1.0 / near.size + shift * shift / spread)
        elif near.size:
            values[k] = float(np.mean(at - slope * reach * near))
    return values, errors
