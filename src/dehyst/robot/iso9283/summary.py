"""All path figures of a run along a timed test path, in the units that people read."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array
from dehyst.errors import RecordingError
from dehyst.robot.iso9283.metrics import (
    cornering_deviation,
    error_summary,
    path_accuracy,
    path_repeatability,
    path_velocity,
    tracking_error,
)
from dehyst.robot.iso9283.sections import Indices, check_run, sections
from dehyst.robot.iso9283.timing import Timed

WORST = ("AT_mm", "RT_mm", "CR_mm", "CO_mm", "AV_percent", "RV_percent", "FV_mm_s")
_NOT_REACHED = "no section of the figure was reached"
_ONE_CYCLE = "needs two cycles or more"
_NO_CORNERS = "the figure has no corners, or none was rounded"


def iso9283(
    timing: Timed,
    time: npt.ArrayLike,
    position: npt.ArrayLike,
    cycle: npt.ArrayLike | None = None,
    figure: npt.ArrayLike | None = None,
) -> dict[str, Any]:
    """Evaluate a run along a timed test path by ISO 9283.

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
        ``share_at_command_speed``. What cannot be given is None, and ``reasons`` says why.

    References
    ----------
    ISO 9283:1998, 8.2 to 8.6.

    Examples
    --------
    >>> from dehyst.robot.iso9283.cube import TestCube, test_path
    >>> from dehyst.robot.iso9283.timing import timed
    >>> motion = timed(test_path(TestCube(0.4, [0.6, 0.0, 0.9]), 0.03), 0.25, 2.0, 40.0, rest=1.0)
    >>> t = np.arange(0.0, 2.0 * motion.duration, 0.01)
    >>> late = motion.position(t - 0.1)  # on the path, but a tenth of a second late
    >>> found = iso9283(motion, t, late)
    >>> found["AT_mm"] < 0.1, round(found["tracking_max_mm"], 6)
    (True, 25.0)
    """
    try:
        t, x, _ = check_run(time, position, np.zeros(np.shape(time), dtype=np.int64))
        cycles = timing.cycle(t) if cycle is None else np.asarray(cycle, dtype=np.int64)
        index = timing.figure(t) if figure is None else np.asarray(figure, dtype=np.int64)
    except (TypeError, ValueError) as fault:
        if isinstance(fault, RecordingError):
            raise
        raise RecordingError(f"time, position, cycle and figure must be arrays of numbers ({fault}).") from None
    check_run(t, x, cycles)
    if index.shape != t.shape:
        raise RecordingError(f"figure has shape {index.shape}, time {t.shape}; pass one index a sample.")
    error = tracking_error(timing.position(t), x)
    each = {
        path_figure.name: _one_figure(timing, number, t, x, cycles, error, index == number)
        for number, path_figure in enumerate(timing.path.figures)
    }
    found: dict[str, Any] = {key: _worst([values[key] for values in each.values()]) for key in WORST}
    found |= _tracking(error)
    found["cycles"] = int(np.unique(cycles[index >= 0]).size)
    found["sections_missed"] = float(np.mean([values["sections_missed"] for values in each.values()]))
    found["reasons"] = {
        key: "; ".join(sorted({values["reasons"][key] for values in each.values() if key in values["reasons"]}))
        for key in WORST
        if found[key] is None
    }
    found["figures"] = each
    return found


def _one_figure(
    timing: Timed, number: int, t: Array, x: Array, cycle: Indices, error: Array, here: npt.NDArray[np.bool_]
) -> dict[str, Any]:
    figure = timing.path.figures[number]
    speed = timing.command_speed(number)
    values: dict[str, Any] = dict.fromkeys(WORST)
    values |= {"tracking_rms_mm": None, "tracking_max_mm": None, "tracking_p95_mm": None}
    values |= {
        "command_speed_mm_s": 1e3 * speed,
        "share_at_command_speed": timing.share_at_command_speed(number),
        "sections_missed": 1.0,
        "reasons": dict.fromkeys(WORST, _NOT_REACHED),
    }
    if here.sum() < 2:
        return values
    run = (t[here], x[here], cycle[here])
    crossed = sections(figure, *run)
    velocity = path_velocity(crossed, speed, timing.steady_ranges(number))
    corner = cornering_deviation(figure, *run)
    measured = {
        "AT_mm": 1e3 * path_accuracy(crossed),
        "RT_mm": 1e3 * path_repeatability(crossed),
        "CR_mm": 1e3 * corner.rounding_error,
        "CO_mm": 1e3 * corner.overshoot,
        "AV_percent": velocity.accuracy_percent,
        "RV_percent": velocity.repeatability_percent,
        "FV_mm_s": 1e3 * velocity.fluctuation,
    }
    values |= {key: None if math.isnan(value) else value for key, value in measured.items()}
    values |= _tracking(error[here])
    values["sections_missed"] = crossed.missed / crossed.speed.size
    why = {"RT_mm": _ONE_CYCLE, "RV_percent": _ONE_CYCLE, "CR_mm": _NO_CORNERS, "CO_mm": _NO_CORNERS}
    nothing = crossed.missed == crossed.speed.size
    values["reasons"] = {
        key: _NOT_REACHED if nothing else why.get(key, _NOT_REACHED) for key in WORST if values[key] is None
    }
    return values


def _tracking(error: Array) -> dict[str, float]:
    summary = error_summary(error)
    return {f"tracking_{name}_mm": 1e3 * value for name, value in summary._asdict().items()}


def _worst(values: list[float | None]) -> float | None:
    """Return the value farthest from zero, None if there is none."""
    return max((value for value in values if value is not None), key=abs, default=None)
