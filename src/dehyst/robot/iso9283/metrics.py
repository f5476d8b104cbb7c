"""Path figures of ISO 9283:1998, corners among them, and tracking errors. SI units; what cannot be given is NaN."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array
from dehyst.errors import ParameterError, RecordingError
from dehyst.robot.iso9283.paths import Figure
from dehyst.robot.iso9283.sections import Sections, check_run, crossings


class VelocityFigures(NamedTuple):
    """Path velocity figures: accuracy AV [%], repeatability RV [%], fluctuation FV [m/s]."""

    accuracy_percent: float
    repeatability_percent: float
    fluctuation: float


class ErrorSummary(NamedTuple):
    """Root mean square, largest and 95th percentile of absolute errors, in the errors' unit."""

    rms: float
    max: float
    p95: float


def path_accuracy(sections: Sections) -> float:
    """Return the path accuracy AT = max_i |mean_j x_ij - x_ci|. [m]

    A section counts with the cycles that reached it, NaN if none was reached.

    References
    ----------
    ISO 9283:1998, 8.2.

    Examples
    --------
    Two cycles, 3 mm and 5 mm beside the path: the mean is 4 mm beside it.

    >>> x = np.array([[[0.0, 3.0, 0.0]], [[0.0, 5.0, 0.0]]])
    >>> path_accuracy(Sections(np.zeros(1), np.zeros((1, 3)), x, np.ones((2, 1))))
    4.0
    """
    kept, reached = _reached(sections, 1)
    if not kept.any():
        return float("nan")
    mean = np.nansum(sections.attained[:, kept], axis=0) / reached[kept, None]
    return float(np.linalg.norm(mean - sections.command[kept], axis=1).max())


def path_repeatability(sections: Sections) -> float:
    """Return the path repeatability RT = max_i (mean_j l_ij + 3 S_i), l_ij = |x_ij - mean_j x_ij|. [m]

    S_i is the standard deviation of l_ij over the cycles (n - 1). NaN if no section was reached by two cycles.

    References
    ----------
    ISO 9283:1998, 8.3.

    Examples
    --------
    Two cycles 2 mm apart: both are 1 mm from their mean, and S is zero.

    >>> x = np.array([[[0.0, 3.0, 0.0]], [[0.0, 5.0, 0.0]]])
    >>> path_repeatability(Sections(np.zeros(1), np.zeros((1, 3)), x, np.ones((2, 1))))
    1.0
    """
    kept, reached = _reached(sections, 2)
    if not kept.any():
        return float("nan")
    x, n = sections.attained[:, kept], reached[kept]
    distance = np.linalg.norm(x - np.nansum(x, axis=0) / n[:, None], axis=2)
    mean = np.nansum(distance, axis=0) / n
    deviation = np.sqrt(np.nansum((distance - mean) ** 2, axis=0) / (n - 1))
    return float((mean + 3.0 * deviation).max())


def _reached(sections: Sections, least: int) -> tuple[npt.NDArray[np.bool_], npt.NDArray[np.int64]]:
    """Return which sections at least so many cycles reached, (m,), and how many did, (m,)."""
    reached = np.isfinite(sections.speed).sum(axis=0)
    return reached >= least, reached


def path_velocity(
    sections: Sections, command_speed: float, steady: Sequence[tuple[float, float]] | None = None
) -> VelocityFigures:
    """Return the path velocity figures, of the sections where the command runs at its command speed.

    With v_j = mean_i v_ij: AV = 100 (mean_j v_j - v_c)/v_c, RV = 100 (3 S_v)/v_c with S_v the standard deviation of the
    v_j (n - 1), FV = max_j (max_i v_ij - min_i v_ij).

    Parameters
    ----------
    sections
        Of one figure.
    command_speed
        v_c. [m/s]
    steady
        Ranges of the figure's arc length to measure in; None for all of it. [m]

    Returns
    -------
    VelocityFigures
        NaN where there is nothing to measure; RV needs two cycles.

    References
    ----------
    ISO 9283:1998, 8.6.

    Examples
    --------
    >>> speed = np.array([[0.9, 1.1], [1.0, 1.2]])  # mean speeds 1.0 and 1.1, S_v = 0.1/sqrt(2)
    >>> run = Sections(np.arange(2.0), np.zeros((2, 3)), np.zeros((2, 2, 3)), speed)
    >>> [round(figure, 6) for figure in path_velocity(run, 1.0)]
    [5.0, 21.213203, 0.2]
    """
    if not command_speed > 0:
        raise ParameterError(f"command_speed = {command_speed} m/s; pass the positive speed that was commanded.")
    inside = np.ones(sections.s.size, dtype=np.bool_)
    if steady is not None:
        inside = np.any([(sections.s >= low) & (sections.s <= high) for low, high in steady], axis=0)
    speed = sections.speed[:, inside]
    speed = speed[np.isfinite(speed).any(axis=1)] if speed.size else speed[:0]
    if not speed.size:
        return VelocityFigures(*3 * [float("nan")])
    mean = np.nanmean(speed, axis=1)
    return VelocityFigures(
        100.0 * float(mean.mean() - command_speed) / command_speed,
        300.0 * float(mean.std(ddof=1)) / command_speed if mean.size > 1 else float("nan"),
        float((np.nanmax(speed, axis=1) - np.nanmin(speed, axis=1)).max()),
    )


def tracking_error(command: npt.ArrayLike, attained: npt.ArrayLike) -> Array:
    """Return the distance (T,) of the attained points (T, 3) from the points commanded at the same time. [m]

    Not an ISO figure: a run that lags behind on the path has no path error, but a tracking error.

    Examples
    --------
    >>> tracking_error([[0.0, 0.0, 0.0]], [[3.0, 4.0, 0.0]]).tolist()
    [5.0]
    """
    c, x = np.asarray(command, dtype=np.float64), np.asarray(attained, dtype=np.float64)
    if c.shape != x.shape or c.ndim != 2:
        raise RecordingError(f"command {c.shape} and attained {x.shape} must have the same shape (T, 3).")
    return np.asarray(np.linalg.norm(x - c, axis=1))


def error_summary(error: npt.ArrayLike) -> ErrorSummary:
    """Return rms, maximum and 95th percentile of the absolute value of errors (T,), in their unit.

    Examples
    --------
    >>> error_summary([3.0, -4.0, 0.0, 0.0])._replace(p95=0.0)
    ErrorSummary(rms=2.5, max=4.0, p95=0.0)
    """
    e = np.abs(np.asarray(error, dtype=np.float64)).ravel()
    if e.size == 0 or not np.isfinite(e).all():
        raise RecordingError(
            f"{int((~np.isfinite(e)).sum())} of {e.size} errors are not finite: a summary would hide a broken run. "
            f"Find out why it broke off, and pass what is whole."
        )
    return ErrorSummary(float(np.sqrt(np.mean(e**2))), float(e.max()), float(np.percentile(e, 95)))


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
    >>> from dehyst.robot.iso9283.cube import TestCube, rectangle
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
