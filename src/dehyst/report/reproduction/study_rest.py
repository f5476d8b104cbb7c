"""At rest: what the integrator holds and how it drifts, without and with compensator."""

from __future__ import annotations

import math

import numpy as np

from dehyst.arrays import Array
from dehyst.experiments.results import Reproduction
from dehyst.report.figures.panel import says
from dehyst.report.reproduction.lines import Line, over_time
from dehyst.report.reproduction.picture import Picture, Plate
from dehyst.report.reproduction.studies import REST, Study, column, nothing_to_study, subject_words
from dehyst.report.reproduction.trials import OFF_LABEL, ON_LABEL
from dehyst.report.tables import Table
from dehyst.report.text import number
from dehyst.report.theme import TEST, TRAIN

# Two drifts are called equal when they differ by less than this share of the larger one.
EQUAL = 0.2


def rest_study(result: Reproduction) -> Study | None:
    """Return "At rest: integrator and compensator", or None if it was not measured."""
    columns = result.studies.get(REST)
    if columns is None or nothing_to_study(result):
        return None
    t, off, on = (column(columns, REST, name) for name in ("time_s", "integrator_off_Nm", "integrator_on_Nm"))
    levels = [float(np.mean(torque)) for torque in (off, on)]
    slopes = [float(np.polyfit(t - t[0], torque, 1)[0]) for torque in (off, on)]
    pair = (Line(off, TEST, OFF_LABEL, 1.5), Line(on, TRAIN, ON_LABEL, 1.5))
    moved = tuple(Line(line.y - line.y[0], line.token, line.label, line.width) for line in pair)
    apart, torque = abs(levels[0] - levels[1]), "integrator [Nm]"
    plate = Plate(
        "rest",
        "At rest: integrator and compensator",
        f"{subject_words(result)} The joint has stopped on a loop and stands still; the integrator holds its angle. "
        "Both runs are the same but for the compensator.".strip(),
        (
            Picture(
                "Torque of the integrator",
                (over_time(t, pair, "time at rest [s]", torque),),
                says(f"Levels {number(apart)} Nm apart."),
            ),
            Picture(
                "Its change since the stop",
                (over_time(t, moved, "time at rest [s]", "change [Nm]"),),
                says(f"Drifts {number(slopes[0])} and {number(slopes[1])} Nm/s."),
            ),
        ),
    )
    words = (
        f"Level: {number(levels[0])} Nm without and {number(levels[1])} Nm with compensator, {number(apart)} Nm apart. "
        "The difference is the torque that the compensator adds there, and the integrator therefore need not.",
        f"{_drift(*slopes)}{_slowing(t, off)}",
    )
    rows = tuple(
        (label, number(level), number(slope), number(float(np.ptp(torque_))))
        for label, level, slope, torque_ in zip((OFF_LABEL, ON_LABEL), levels, slopes, (off, on), strict=True)
    )
    return Study(plate, words, Table("At rest", ("", "mean [Nm]", "drift [Nm/s]", "range [Nm]"), rows))


def _slowing(t: Array, torque: Array) -> str:
    """Whether the drift of the first half is faster than that of the second, as that of creep is."""
    half = t.size // 2
    early, late = (float(np.polyfit(t[part], torque[part], 1)[0]) for part in (slice(0, half), slice(half, None)))
    if abs(late) >= 0.8 * abs(early) or early * late < 0.0:
        return ""
    return (
        f" It slows down, from {number(early)} Nm/s in the first {number(float(t[half] - t[0]), 2)} s to "
        f"{number(late)} Nm/s after them (without compensator), as creep does."
    )


def _drift(off: float, on: float) -> str:
    text = f"Drift: {number(off)} Nm/s without and {number(on)} Nm/s with compensator"
    if abs(off - on) <= EQUAL * max(abs(off), abs(on)):
        within = max(1, math.ceil(100 * abs(off - on) / max(abs(off), abs(on), 1e-300)))
        return (
            f"{text}, equal to within {within} %. The angle stands still, so a model without time stands still, and a "
            "compensator cannot drift: it is the muscles that creep, and the integrator follows them in both cases."
        )
    return f"{text}: not equal, so more than the creep of the muscles is at work."
