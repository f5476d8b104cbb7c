"""Geometry of a closed loop: area, opening, and what its branches read at a place."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from dehyst.arrays import Array
from dehyst.data._policy import POLICY

CELLS = 24  # along the input, between which the opening is measured
ENDS = 0.05  # of the input's range at either end, where cells would not be full
TRIMMED = 0.95  # share of the second differences that are noise and no bend
TRIMMED_SHARE = 0.76  # of the variance of a normal variable, which the largest 5 % leave


class ReadValue(NamedTuple):
    """What a branch reads at a place, and its standard error from the noise of the samples."""

    value: float
    error: float


UNREAD = ReadValue(float("nan"), float("nan"))


@dataclass(frozen=True, eq=False)
class Branch:
    """One way of a signal u, from one end of its range to the other, and the other signal v along it, (n,)."""

    u: Array
    v: Array
    noise: tuple[float, float]  # Standard deviations of u and of v
    span: float  # Range of u

    def at(self, place: float) -> ReadValue:
        """Read v where u is at a place: by a parabola through the samples near it, or between the two beside it.

        As many samples as the noise asks for: a corner near the place would bend a longer parabola.
        """
        if not self.span > 0.0:
            return UNREAD
        reach = POLICY.reading_reach * self.span
        near = np.flatnonzero(np.abs(self.u - place) <= reach)
        wanted = self._enough()
        if near.size > wanted:
            away = np.abs(self.u[near] - place)
            near = near[np.argpartition(away, wanted - 1)[:wanted]]
        distance = self.u[near] - place
        few = distance.size < POLICY.reading_samples
        if few or not (np.min(distance) < 0.0 < np.max(distance)):
            return self._between(place)
        reach = float(np.max(np.abs(distance)))
        return self._fitted(distance / reach, self.v[near], reach, 2)

    def _enough(self) -> int:
        """Samples of a parabola whose middle, of 9/4 times the variance of a mean, has the error that is asked for."""
        height = float(np.ptp(self.v))
        noise = float(np.hypot(self.noise[1], self.noise[0] * height / self.span))
        wanted = 0.0
        if height > 0.0:
            # A product of floats that is too large is infinite, their power is an error.
            ratio = noise / (POLICY.reading_error * height)
            wanted = 2.25 * (ratio * ratio)
        return max(POLICY.reading_samples, int(np.ceil(min(wanted, 1e9))))

    def near_end(self, end: float) -> tuple[ReadValue, ReadValue]:
        """Read v and its slope at an end of the way, over a tenth of it."""
        reach = POLICY.turn_reach * self.span
        inside = np.abs(self.u - end) <= reach
        distance = (self.u[inside] - end) / reach
        v = self.v[inside]
        if distance.size < 2 or not float(np.ptp(distance)) > 0.0:
            return UNREAD, UNREAD
        slope = self._slope(distance, v, reach)
        if distance.size < POLICY.reading_samples:
            nearest = int(np.argmin(np.abs(distance)))
            return ReadValue(float(v[nearest]), self.noise[1]), slope
        return self._fitted(distance, v, reach, 2), slope

    def turn(self, sign: float) -> ReadValue:
        """Read u where sign v is least: the vertex of a parabola over a twentieth of the way to either side.

        Of few samples it takes the nearest ones, as far as a tenth of the way.
        """
        lowest = float(self.u[int(np.argmin(sign * self.v))])
        away = np.abs(self.u - lowest) / (POLICY.turn_reach * self.span)
        enough = min(POLICY.reading_samples, away.size) - 1
        share = max(0.5, float(np.partition(away, enough)[enough]))
        if share > 1.0:
            return UNREAD
        reach = share * POLICY.turn_reach * self.span
        distance = (self.u - lowest) / reach
        near = np.abs(distance) <= 1.0
        basis = np.vander(distance[near], 3, increasing=True)
        solved = np.linalg.lstsq(basis, self.v[near], rcond=None)[0]
        bend = 2.0 * float(solved[2])
        if not sign * bend > 0.0:
            return UNREAD
        covariance = self.noise[1] ** 2 * np.linalg.pinv(basis.T @ basis)
        error = reach * float(np.sqrt(covariance[1, 1])) / abs(bend)
        vertex = float(np.clip(-float(solved[1]) / bend, -1.0, 1.0))
        return ReadValue(lowest + reach * vertex, error)

    def _fitted(self, distance: Array, v: Array, reach: float, degree: int) -> ReadValue:
        basis = np.vander(distance, degree + 1, increasing=True)
        middle = float(np.mean(v))
        solved, _, rank, _ = np.linalg.lstsq(basis, v - middle, rcond=None)
        if rank <= degree:
            return ReadValue(middle, self.noise[1])
        covariance = np.linalg.pinv(basis.T @ basis)
        noise = float(np.hypot(self.noise[1], float(solved[1]) / reach * self.noise[0]))
        return ReadValue(middle + float(solved[0]), noise * float(np.sqrt(covariance[0, 0])))

    def _slope(self, distance: Array, v: Array, reach: float) -> ReadValue:
        centred = distance - np.mean(distance)
        spread = float(centred @ centred)
        slope = float(centred @ v) / spread
        noise = float(np.hypot(self.noise[1], slope / reach * self.noise[0]))
        return ReadValue(slope / reach, noise / float(np.sqrt(spread)) / reach)

    def _between(self, place: float) -> ReadValue:
        """Between the samples where u first passes a place."""
        side = self.u >= place
        passed = np.flatnonzero(side[1:] != side[:-1])
        if not passed.size:
            return UNREAD
        k = int(passed[0])
        step = float(self.u[k + 1] - self.u[k])
        rise = float(self.v[k + 1] - self.v[k])
        value = float(self.v[k]) + (place - float(self.u[k])) / step * rise
        return ReadValue(value, float(np.hypot(self.noise[1], rise / step * self.noise[0])))


class ClosedPath:
    """A loop of two signals that is closed by a straight line where it is open.

    Parameters
    ----------
    x, y
        Input and output, (n,), in the order of time.
    """

    def __init__(self, x: Array, y: Array) -> None:
        self.x = x
        self.y = y
        self.noise = (noise_of(x), noise_of(y))

    @property
    def area(self) -> ReadValue:
        """Area, positive where the loop runs counter-clockwise, and its standard error.

        The error is that of the noise, and of the straight lines between samples: a third of what every second sample
        changes.
        """
        x = self.x - np.mean(self.x)
        y = self.y - np.mean(self.y)
        area = _enclosed(x, y)
        across = 0.5 * (np.roll(x, -1) - np.roll(x, 1))
        up = 0.5 * (np.roll(y, -1) - np.roll(y, 1))
        noise = np.hypot(self.noise[1] * np.linalg.norm(across), self.noise[0] * np.linalg.norm(up))
        coarse = (area - _enclosed(x[::2], y[::2])) / 3.0
        return ReadValue(area, float(np.hypot(noise, coarse)))

    def openings(self, ends: float = ENDS) -> Array:
        """Mean distance of the falling branch above the rising one in cells along the input but for its ends, (24,)."""
        low, high = float(np.min(self.x)), float(np.max(self.x))
        ends *= high - low
        edges = np.linspace(low + ends, high - ends, CELLS + 1)
        x, y = _split_at(edges, np.append(self.x, self.x[0]), np.append(self.y, self.y[0]))
        step = np.diff(x)
        cell = np.searchsorted(edges, 0.5 * (x[1:] + x[:-1]), side="right") - 1
        inside = (cell >= 0) & (cell < CELLS)
        below = (0.5 * (y[1:] + y[:-1]) * step)[inside]
        # Along the whole loop the integral of y dx over a cell is that of the rising less that of the falling branch.
        return -np.bincount(cell[inside], below, CELLS) / np.diff(edges)

    @property
    def bend(self) -> float:
        """1 for a butterfly with two valleys, -1 for one with two peaks, 0 for any other loop.

        Both branches go below their ends, and not above them, by a tenth of the output's range.
        """
        least = POLICY.turn_reach * float(np.ptp(self.y))
        for sign in (1.0, -1.0):
            depths, heights = [], []
            for branch in self.by_input():
                v = sign * branch.v
                depths.append(min(v[0], v[-1]) - v.min())
                heights.append(v.max() - max(v[0], v[-1]))
            if min(depths) > least > max(heights):
                return sign
        return 0.0

    def turned_at(self) -> tuple[ReadValue, ReadValue]:
        """Inputs at which the output of a butterfly turns, rising and falling."""
        rising, falling = self.by_input()
        return rising.turn(self.bend), falling.turn(self.bend)

    def by_input(self) -> tuple[Branch, Branch]:
        """The branches on which the input rises and falls."""
        return _branches(self.x, self.y, self.noise)

    def by_output(self) -> tuple[Branch, Branch]:
        """The ways on which the output rises and falls, with the input along them."""
        return _branches(self.y, self.x, self.noise[::-1])


def _branches(u: Array, v: Array, noise: tuple[float, float]) -> tuple[Branch, Branch]:
    lowest = int(np.argmin(u))
    u, v = np.roll(u, -lowest), np.roll(v, -lowest)
    highest = int(np.argmax(u))
    span = float(u[highest] - u[0])
    rising = Branch(u[: highest + 1], v[: highest + 1], noise, span)
    # The falling branch ends where the rising one begins.
    falling = Branch(np.append(u[highest:], u[0]), np.append(v[highest:], v[0]), noise, span)
    return rising, falling


def _enclosed(x: Array, y: Array) -> float:
    return 0.5 * float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))


def noise_of(values: Array) -> float:
    """Standard deviation of what is added to a smooth signal, from its second differences; bends do not count.

    Examples
    --------
    >>> rng = np.random.default_rng(1)
    >>> round(noise_of(np.sin(np.linspace(0.0, 6.0, 4000)) + 0.01 * rng.normal(size=4000)), 3)
    0.01
    """
    if values.size < 8:
        return 0.0
    bends = np.sort(np.diff(values, 2) ** 2)
    bends = bends[: int(TRIMMED * bends.size)]
    return float(np.sqrt(np.mean(bends) / (6.0 * TRIMMED_SHARE)))


def _split_at(edges: Array, x: Array, y: Array) -> tuple[Array, Array]:
    """Add a sample to a path wherever it crosses an edge."""
    place = np.searchsorted(edges, x)
    crossed = np.abs(np.diff(place))
    line = np.repeat(np.arange(crossed.size), crossed)
    # Number of the crossing on its line, and with it the edge: lines go up or down.
    number = np.arange(line.size) - np.repeat(np.cumsum(crossed) - crossed, crossed)
    edge = edges[np.minimum(place[:-1], place[1:])[line] + number]
    at = line + (edge - x[line]) / (x[line + 1] - x[line])
    every = np.sort(np.concatenate([np.arange(x.size, dtype=np.float64), at]))
    samples = np.arange(x.size)
    return np.interp(every, samples, x), np.interp(every, samples, y)
