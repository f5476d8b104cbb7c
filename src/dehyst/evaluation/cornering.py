"""Cornering deviations of ISO 9283: how a run rounds the corners of its path, and how far it shoots past them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array
from dehyst.evaluation.paths import Figure
from dehyst.evaluation.sections import check_run, crossings


class CorneringFigures(NamedTuple):
    """Rounding error CR [m] and overshoot CO [m] of the worst corner."""

    rounding_error: float
    overshoot: float


def cornering_deviation(
    figure: Figure, time: npt.ArrayLike, position: npt.ArrayLike, cycle: npt.ArrayLike
) -> CorneringFigures:
    """Return the cornering deviations against the ideal sharp corners.

    For a corner c between a leg along u_1 and a leg along u_2, and the part of the run from a section on the one to a
    section on the other (their middles; half way to the corner on the first and the last leg):

    - rounding error CR = min_t |x(t) - c|: the command path itself, whose corners are rounded, has one;
    - overshoot CO = max_t of the distance from the second leg's line where the run is past it, (x - c) u_1 > 0; zero if
      it never is.

    Mean over the cycles that reached both sections, then the worst corner. NaN for a figure without corners, or if
    none was rounded.

    Parameters
    ----------
    figure
        Command path, with its `corners`.
    time
        (T,) increasing. [s]
    position
        (T, 3) attained points, of this figure only. [m]
    cycle
        (T,) number of the cycle.

    References
    ----------
    ISO 9283:1998, 8.5. That clause speaks of three cycles; all are used here.

    Examples
    --------
    >>> from dehyst.evaluation.cube import TestCube, rectangle
    >>> figure = rectangle(TestCube(0.4, [0.0, 0.0, 0.0]), 0.03)
    >>> x = figure.position(np.linspace(0.0, figure.length, 2001))
    >>> found = cornering_deviation(figure, np.arange(2001.0), x, np.zeros(2001))
    >>> round(found.rounding_error, 4), found.overshoot < 1e-12
    (0.0096, True)
    """
    t, x, n = check_run(time, position, cycle)
    del t
    if not len(figure.corners):
        return CorneringFigures(float("nan"), float("nan"))
    bounds = _windows(figure)
    tangent = figure.tangent(bounds)
    numbers = np.unique(n)
    rounding, overshoot = np.full((2, numbers.size, len(figure.corners)), np.nan)
    for row, number in enumerate(numbers):
        one = x[n == number]
        index = crossings(figure, bounds, one)
        for k, corner in enumerate(figure.corners):
            if np.isnan(index[k : k + 2]).any():
                continue
            near = one[int(index[k]) : int(index[k + 1]) + 2] - corner
            rounding[row, k] = _distance_from_origin(near)
            overshoot[row, k] = _overshoot(near, tangent[k], tangent[k + 1])
    rounded = np.isfinite(rounding).any(axis=0)
    if not rounded.any():
        return CorneringFigures(float("nan"), float("nan"))
    worst = [float(np.nanmean(values[:, rounded], axis=0).max()) for values in (rounding, overshoot)]
    return CorneringFigures(*worst)


def _windows(figure: Figure) -> Array:
    """Return the arc lengths of the sections before, between and after the corners, (K + 1,)."""
    s = np.linspace(0.0, figure.length, 4001)
    points = figure.position(s)
    at = s[[int(np.argmin(np.linalg.norm(points - corner, axis=1))) for corner in figure.corners]]
    return np.concatenate(([0.5 * at[0]], 0.5 * (at[1:] + at[:-1]), [0.5 * (at[-1] + figure.length)]))


def _distance_from_origin(points: Array) -> float:
    """Return the smallest distance of the polygon through points (N, 3), N >= 2, from zero."""
    a, step = points[:-1], np.diff(points, axis=0)
    squared = np.einsum("ij,ij->i", step, step)
    w = np.clip(-np.einsum("ij,ij->i", a, step) / np.where(squared > 0, squared, 1.0), 0.0, 1.0)
    return float(np.linalg.norm(a + w[:, None] * step, axis=1).min())


def _overshoot(points: Array, into: Array, out: Array) -> float:
    past = points[points @ into > 0.0]
    if not len(past):
        return 0.0
    return float(np.linalg.norm(past - (past @ out)[:, None] * out, axis=1).max())
