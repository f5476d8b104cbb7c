"""Path figures of ISO 9283:1998 (AT, RT, CR, CO, AV, RV, FV) and tracking errors of a run along a test path.

Each function takes and returns SI units, and NaN for a figure that cannot be computed. `iso9283` returns all figures in
mm and percent.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array, Mask, Rows
from dehyst.errors import ParameterError, RecordingError
from dehyst_robot.iso9283._paths import Figure
from dehyst_robot.iso9283._sections import Sections, check_run, crossings
from dehyst_robot.iso9283._sections import sections as crossed_sections
from dehyst_robot.iso9283._timing import Timed

WORST = ("AT_mm", "RT_mm", "CR_mm", "CO_mm", "AV_percent", "RV_percent", "FV_mm_s")
_NOT_REACHED = "no section of the figure was reached"
_ONE_CYCLE = "needs two cycles or more"
_NO_CORNERS = "the figure has no corners, or none was rounded"
# Reasons of figures that need more than sections that were reached.
_REASONS = {
    "RT_mm": _ONE_CYCLE,
    "RV_percent": _ONE_CYCLE,
    "CR_mm": _NO_CORNERS,
    "CO_mm": _NO_CORNERS,
}


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
    """Return the path accuracy AT = max_i |mean_j x_ij - x_ci| (ISO 9283:1998, 8.2). [m]

    A section counts with the cycles that reached it, NaN if none was reached.

    Examples
    --------
    Two cycles, 3 mm and 5 mm beside the path: the mean is 4 mm beside it.

    >>> x = np.array([[[0.0, 3.0, 0.0]], [[0.0, 5.0, 0.0]]])
    >>> path_accuracy(Sections(np.zeros(1), np.zeros((1, 3)), x, np.ones((2, 1))))
    4.0
    """
    usable, cycles = _reached(sections, 1)
    if not usable.any():
        return math.nan
    mean = np.nansum(sections.attained[:, usable], axis=0) / cycles[usable, None]
    return float(np.linalg.norm(mean - sections.command[usable], axis=1).max())


def path_repeatability(sections: Sections) -> float:
    """Return the path repeatability RT = max_i (mean_j l_ij + 3 S_i) (ISO 9283:1998, 8.3). [m]

    l_ij = |x_ij - mean_j x_ij|, and S_i is their standard deviation over the cycles (n - 1). NaN if no section was
    reached by two cycles.

    Examples
    --------
    Two cycles 2 mm apart: both are 1 mm from their mean, and S is zero.

    >>> x = np.array([[[0.0, 3.0, 0.0]], [[0.0, 5.0, 0.0]]])
    >>> path_repeatability(Sections(np.zeros(1), np.zeros((1, 3)), x, np.ones((2, 1))))
    1.0
    """
    usable, cycles = _reached(sections, 2)
    if not usable.any():
        return math.nan
    x = sections.attained[:, usable]
    n = cycles[usable]
    # A cycle that missed a section is nan there, and n counts the others.
    distance = np.linalg.norm(x - np.nansum(x, axis=0) / n[:, None], axis=2)
    mean = np.nansum(distance, axis=0) / n
    deviation = np.sqrt(np.nansum((distance - mean) ** 2, axis=0) / (n - 1))
    return float((mean + 3.0 * deviation).max())


def _reached(sections: Sections, least: int) -> tuple[Mask, Rows]:
    """Return which sections at least `least` cycles reached, (m,), and how many cycles did, (m,)."""
    cycles = np.isfinite(sections.speed).sum(axis=0)
    return cycles >= least, cycles


def path_velocity(
    sections: Sections, command_speed: float, steady: Sequence[tuple[float, float]] | None = None
) -> VelocityFigures:
    """Return the path velocity figures, of the sections where the command runs at its command speed (ISO 9283, 8.6).

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

    Examples
    --------
    >>> speed = np.array([[0.9, 1.1], [1.0, 1.2]])  # mean speeds 1.0 and 1.1, S_v = 0.1/sqrt(2)
    >>> run = Sections(np.arange(2.0), np.zeros((2, 3)), np.zeros((2, 2, 3)), speed)
    >>> [round(figure, 6) for figure in path_velocity(run, 1.0)]
    [5.0, 21.213203, 0.2]
    """
    if not command_speed > 0:
        raise ParameterError(
            f"command_speed = {command_speed} m/s; pass the positive speed that was commanded."
        )
    inside = np.ones(sections.s.size, dtype=np.bool_)
    if steady is not None:
        inside[:] = False
        for low, high in steady:
            inside |= (sections.s >= low) & (sections.s <= high)
    # Only cycles that reached one of these sections have a mean.
    speed = sections.speed[:, inside]
    speed = speed[np.isfinite(speed).any(axis=1)]
    if not speed.size:
        return VelocityFigures(math.nan, math.nan, math.nan)
    mean = np.nanmean(speed, axis=1)
    accuracy = 100.0 * float(mean.mean() - command_speed) / command_speed
    repeatability = math.nan
    if mean.size > 1:
        repeatability = 300.0 * float(mean.std(ddof=1)) / command_speed
    fluctuation = float((np.nanmax(speed, axis=1) - np.nanmin(speed, axis=1)).max())
    return VelocityFigures(accuracy, repeatability, fluctuation)


def tracking_error(command: npt.ArrayLike, attained: npt.ArrayLike) -> Array:
    """Return the distance (T,) of the attained points (T, 3) from the points commanded at the same time. [m]

    Not an ISO figure: a run that lags behind on the path has no path error, but a tracking error.

    Examples
    --------
    >>> tracking_error([[0.0, 0.0, 0.0]], [[3.0, 4.0, 0.0]]).tolist()
    [5.0]
    """
    c = np.asarray(command, dtype=np.float64)
    x = np.asarray(attained, dtype=np.float64)
    if c.shape != x.shape or c.ndim != 2:
        raise RecordingError(
            f"command {c.shape} and attained {x.shape} must have the same shape (T, 3)."
        )
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
    """Return the cornering deviations against the ideal sharp corners (ISO 9283:1998, 8.5).

    For a corner c between a leg along u_1 and a leg along u_2, and the part of the run from a section on the one to a
    section on the other (their middles; half way to the corner on the first and the last leg):

    - rounding error CR = min_t |x(t) - c|: the command path itself, whose corners are rounded, has one;
    - overshoot CO = max_t of the distance from the second leg's line where the run is past it, (x - c) u_1 > 0; zero if
      it never is.

    Mean over the cycles that reached both sections (the standard speaks of three cycles; all are used), then the worst
    corner. NaN for a figure without corners, or if none was rounded.

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

    Examples
    --------
    >>> from dehyst_robot.iso9283 import TestCube, rectangle
    >>> figure = rectangle(TestCube(0.4, [0.0, 0.0, 0.0]), 0.03)
    >>> x = figure.position(np.linspace(0.0, figure.length, 2001))
    >>> deviation = cornering_deviation(figure, np.arange(2001.0), x, np.zeros(2001))
    >>> round(deviation.rounding_error, 4), deviation.overshoot < 1e-12
    (0.0096, True)
    """
    _, x, n = check_run(time, position, cycle)
    none = CorneringFigures(math.nan, math.nan)
    if not len(figure.corners):
        return none
    # Each corner has a window of its own, from the middle of the leg before it to the middle of the leg after it.
    bounds = _windows(figure)
    tangent = figure.tangent(bounds)
    numbers = np.unique(n)
    rounding, overshoot = np.full((2, numbers.size, len(figure.corners)), np.nan)
    for row, number in enumerate(numbers):
        points = x[n == number]
        index = crossings(figure, bounds, points)
        for k, corner in enumerate(figure.corners):
            if np.isnan(index[k : k + 2]).any():
                continue
            near = points[int(index[k]) : int(index[k + 1]) + 2] - corner
            rounding[row, k] = _distance_from_origin(near)
            overshoot[row, k] = _overshoot(near, tangent[k], tangent[k + 1])
    rounded = np.isfinite(rounding).any(axis=0)
    if not rounded.any():
        return none
    worst_rounding = float(np.nanmean(rounding[:, rounded], axis=0).max())
    worst_overshoot = float(np.nanmean(overshoot[:, rounded], axis=0).max())
    return CorneringFigures(worst_rounding, worst_overshoot)


def _windows(figure: Figure) -> Array:
    """Return the arc lengths of the sections before, between and after the corners, (K + 1,)."""
    s = np.linspace(0.0, figure.length, 4001)
    points = figure.position(s)
    # The arc length at which the path, whose corners are rounded, is nearest to each sharp one.
    distances = np.linalg.norm(points[:, None] - figure.corners[None], axis=2)
    at = s[np.argmin(distances, axis=0)]
    return np.concatenate(
        ([0.5 * at[0]], 0.5 * (at[1:] + at[:-1]), [0.5 * (at[-1] + figure.length)])
    )


def _distance_from_origin(points: Array) -> float:
    """Return the smallest distance of the polygon through points (N, 3), N >= 2, from zero."""
    a = points[:-1]
    step = np.diff(points, axis=0)
    # The foot of the perpendicular on each piece, or its nearer end; a piece may have no length.
    squared = np.einsum("ij,ij->i", step, step)
    w = np.clip(-np.einsum("ij,ij->i", a, step) / np.where(squared > 0, squared, 1.0), 0.0, 1.0)
    return float(np.linalg.norm(a + w[:, None] * step, axis=1).min())


def _overshoot(points: Array, into: Array, out: Array) -> float:
    past = points[points @ into > 0.0]
    if not len(past):
        return 0.0
    # Distance from the line along the second leg.
    return float(np.linalg.norm(past - (past @ out)[:, None] * out, axis=1).max())


def iso9283(
    timing: Timed,
    time: npt.ArrayLike,
    position: npt.ArrayLike,
    cycle: npt.ArrayLike | None = None,
    figure: npt.ArrayLike | None = None,
) -> dict[str, Any]:
    """Evaluate a run along a timed test path by ISO 9283:1998, 8.2 to 8.6.

    Parameters
    ----------
    timing
        The command.
    time
        (T,) from the start of the first cycle, increasing. [s]
    position
        (T, 3) attained points. [m]
    cycle, figure
        (T,) number of the cycle and index of the figure (-1 on a transfer); None to take them from the timing.

    Returns
    -------
    dict
        ``AT_mm``, ``RT_mm``, ``CR_mm``, ``CO_mm``, ``AV_percent``, ``RV_percent``, ``FV_mm_s``: of the worst figure
        (AV: the one farthest from zero). ``tracking_rms_mm``, ``tracking_max_mm``, ``tracking_p95_mm``: time-matched,
        over the whole run, transfers and rests included. ``cycles``; ``sections_missed``, the share of crossings that
        did not happen. ``figures``: the same for each figure by its name, with its ``command_speed_mm_s`` and
        ``share_at_command_speed``. A figure that cannot be computed is None, and ``reasons`` says why.

    Examples
    --------
    >>> from dehyst_robot.iso9283 import TestCube, test_path
    >>> from dehyst_robot.iso9283 import timed
    >>> motion = timed(test_path(TestCube(0.4, [0.6, 0.0, 0.9]), 0.03), 0.25, 2.0, 40.0, rest=1.0)
    >>> t = np.arange(0.0, 2.0 * motion.duration, 0.01)
    >>> late = motion.position(t - 0.1)  # on the path, but a tenth of a second late
    >>> figures = iso9283(motion, t, late)
    >>> figures["AT_mm"] < 0.1, round(figures["tracking_max_mm"], 6)
    (True, 25.0)
    """
    try:
        t, x, _ = check_run(time, position, np.zeros(np.shape(time), dtype=np.int64))
        cycles = timing.cycle(t)
        if cycle is not None:
            cycles = np.asarray(cycle, dtype=np.int64)
        index = timing.figure(t)
        if figure is not None:
            index = np.asarray(figure, dtype=np.int64)
    except RecordingError:  # which is a ValueError, too
        raise
    except (TypeError, ValueError) as fault:
        raise RecordingError(
            f"time, position, cycle and figure must be arrays of numbers ({fault})."
        ) from None
    check_run(t, x, cycles)
    if index.shape != t.shape:
        raise RecordingError(
            f"figure has shape {index.shape}, time {t.shape}; pass one index a sample."
        )
    error = tracking_error(timing.position(t), x)
    by_name = {}
    for number, path_figure in enumerate(timing.path.figures):
        here = index == number
        by_name[path_figure.name] = _one_figure(timing, number, t, x, cycles, error, here)
    values: dict[str, Any] = {}
    reasons = {}
    for key in WORST:
        values[key] = _worst([one_figure[key] for one_figure in by_name.values()])
        if values[key] is None:
            reasons[key] = _all_reasons(by_name, key)
    values |= _tracking(error)
    values["cycles"] = int(np.unique(cycles[index >= 0]).size)
    missed = [one_figure["sections_missed"] for one_figure in by_name.values()]
    values["sections_missed"] = float(np.mean(missed))
    values["reasons"] = reasons
    values["figures"] = by_name
    return values


def _all_reasons(by_name: dict[str, dict[str, Any]], key: str) -> str:
    reasons = set()
    for one_figure in by_name.values():
        if key in one_figure["reasons"]:
            reasons.add(one_figure["reasons"][key])
    return "; ".join(sorted(reasons))


def _one_figure(
    timing: Timed, number: int, t: Array, x: Array, cycle: Rows, error: Array, here: Mask
) -> dict[str, Any]:
    """Return the figures of one figure of the path; None for those that cannot be computed, with the reasons."""
    figure = timing.path.figures[number]
    speed = timing.command_speed(number)
    values: dict[str, Any] = dict.fromkeys(WORST) | dict.fromkeys(_tracking(np.zeros(1)))
    values |= {
        "command_speed_mm_s": 1e3 * speed,
        "share_at_command_speed": timing.share_at_command_speed(number),
        "sections_missed": 1.0,
        "reasons": dict.fromkeys(WORST, _NOT_REACHED),
    }
    # Two samples at least make a way that can cross a section.
    if here.sum() < 2:
        return values
    run = (t[here], x[here], cycle[here])
    crossed = crossed_sections(figure, *run)
    velocity = path_velocity(crossed, speed, timing.steady_ranges(number))
    corner = cornering_deviation(figure, *run)
    measured = (
        1e3 * path_accuracy(crossed),
        1e3 * path_repeatability(crossed),
        1e3 * corner.rounding_error,
        1e3 * corner.overshoot,
        velocity.accuracy_percent,
        velocity.repeatability_percent,
        1e3 * velocity.fluctuation,
    )
    values |= _tracking(error[here])
    values["sections_missed"] = crossed.missed / crossed.speed.size
    values["reasons"] = {}
    for key, value in zip(WORST, measured, strict=True):
        values[key] = value
        # JSON knows no nan.
        if math.isnan(value):
            values[key] = None
            values["reasons"][key] = _NOT_REACHED
            if crossed.missed < crossed.speed.size:
                values["reasons"][key] = _REASONS.get(key, _NOT_REACHED)
    return values


def _tracking(error: Array) -> dict[str, float]:
    rms, largest, p95 = error_summary(error)
    return {
        "tracking_rms_mm": 1e3 * rms,
        "tracking_max_mm": 1e3 * largest,
        "tracking_p95_mm": 1e3 * p95,
    }


def tracking_figures(desired: Array, attained: Array) -> dict[str, float]:
    """Return rms, largest and 95 % distance of points (T, 3) [m] from those of the same time, keys as in `iso9283`.

    Examples
    --------
    >>> tracking_figures(np.zeros((2, 3)), np.full((2, 3), 0.001))["tracking_max_mm"].__round__(3)
    1.732
    """
    return _tracking(tracking_error(desired, attained))


def _worst(values: list[float | None]) -> float | None:
    """Return the value farthest from zero, None if there is none."""
    return max((value for value in values if value is not None), key=abs, default=None)
