"""Straight lines that a data sheet measures from: through both ends, with the least largest deviation, through zero."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from dehyst.arrays import Array


class StraightLine(NamedTuple):
    """A straight line y = slope x + level."""

    slope: float
    level: float

    def at(self, x: Array) -> Array:
        """Return the line at places, (m,)."""
        return np.asarray(self.slope * x + self.level)


IDEAL = StraightLine(1.0, 0.0)


def terminal_line(x: Array, y: Array) -> StraightLine:
    """Return the line through the first and the last point.

    Examples
    --------
    >>> terminal_line(np.array([0.0, 1.0, 2.0]), np.array([1.0, 5.0, 5.0]))
    StraightLine(slope=2.0, level=1.0)
    """
    slope = float(y[-1] - y[0]) / float(x[-1] - x[0])
    return StraightLine(slope, float(y[0]) - slope * float(x[0]))


def best_line(x: Array, y: Array) -> StraightLine:
    """Return the line whose largest deviation is the least: half of the narrowest upright strip that holds all points.

    An edge of the strip passes through two points, so its slope is one of theirs.

    Examples
    --------
    >>> line = best_line(np.array([0.0, 1.0, 2.0]), np.array([0.0, 1.0, 0.0]))
    >>> line
    StraightLine(slope=0.0, level=0.5)
    """
    first, second = np.triu_indices(x.size, 1)
    slopes = (y[second] - y[first]) / (x[second] - x[first])
    left = y[:, None] - slopes * x[:, None]
    best = int(np.argmin(np.ptp(left, axis=0)))
    return StraightLine(
        float(slopes[best]), 0.5 * float(np.max(left[:, best]) + np.min(left[:, best]))
    )


def zero_line(x: Array, y: Array) -> StraightLine:
    """Return the line through the first point whose largest deviation is the least.

    It is least where two points deviate alike, one to either side.

    Examples
    --------
    >>> line = zero_line(np.array([0.0, 1.0, 2.0]), np.array([0.0, 2.0, 2.0]))
    >>> round(line.slope, 6), line.level
    (1.333333, 0.0)
    """
    way, rise = x[1:] - x[0], y[1:] - y[0]
    first, second = np.triu_indices(way.size)
    slopes = (rise[first] + rise[second]) / (way[first] + way[second])
    left = np.max(np.abs(rise[:, None] - slopes * way[:, None]), axis=0)
    slope = float(slopes[int(np.argmin(left))])
    return StraightLine(slope, float(y[0]) - slope * float(x[0]))
