"""Warnings about input and output: constant, saturated, quantised, too few loops, columns swapped."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from dehyst.arrays import Array
from dehyst.data import about_clipping, rests, summarise_loops
from dehyst.errors import ExcitationError, RecordingError
from dehyst.findings import Finding
from dehyst.io._clean import Samples
from dehyst.io._policy import POLICY
from dehyst.io._table import LogTable
from dehyst.units import dimension, parse_unit, words

Signals = Sequence[tuple[str, str, Array]]  # role, column, values

FIRST_VALUES = 4096  # of a signal: where these are many, there is no need to sort the others
COMMAND_WORDS = frozenset(
    words("cmd command commanded ref reference setpoint desired target soll des demand")
)
BETWEEN_WORDS = frozenset(words("interp interpolated resampled filtered smooth smoothed"))
DRIVES = ("pressure", "voltage", "current")
MOTIONS = ("angle", "length")


def is_constant(values: Array) -> bool:
    """Whether a signal does not move beyond rounding."""
    if values.size == 0:
        return True
    low, high = float(values.min()), float(values.max())
    return high - low <= 1e-12 * max(-low, high)


def _still(values: Array) -> str:
    """How still a signal is that does not move beyond rounding."""
    span = float(np.ptp(values))
    if span == 0.0:
        return f"is {values[0]:.6g} in all {values.size} rows"
    return f"moves by {span:.3g} only on an offset of {values[0]:.6g}, which is rounding, in {values.size} rows"


def hold_length(values: Array) -> float:
    """Mean number of samples a sampled-and-held signal stays at each value; 1 if it is not held.

    Held means: most samples repeat the one before, and the steps between are of many sizes. Steps of one
    size are those of a coarse converter instead; a few long rests are those of a commanded staircase.
    """
    step = np.diff(values)
    count = np.count_nonzero(step)
    if step.size < 20 or count < 8 or count > (1 - POLICY.held_share) * step.size:
        return 1.0
    moves = np.abs(step[step != 0])
    runs = np.diff(np.flatnonzero(step != 0))
    typical = float(np.median(runs))
    smallest = float(np.min(moves))
    # Rests of a staircase or a plateau are few and long; then most of the time passes in rests far above the median.
    if (
        typical < 3
        or float(np.median(moves)) < 3 * smallest
        or np.unique(np.round(moves / smallest)).size < 6
    ):
        return 1.0
    return typical


def stuck_share(x: Array, y: Array) -> tuple[float, float]:
    """Largest share of samples at which the output sits at an extreme while the input pushes outward, and that extreme.

    A play stands still after the input has turned; a saturated sensor stands still before. Only the latter counts.
    """
    top, bottom = float(y.max()), float(y.min())
    extremes = ((top, rests(y, top)), (bottom, rests(y, bottom)))
    worst = (0.0, top)
    if not extremes[0][1] and not extremes[1][1]:
        return worst
    centred = x - x.mean()
    sign = np.sign(float(np.dot(centred, y - y.mean()))) or 1.0
    span = float(np.ptp(x))
    for (level, stretches), outward in zip(extremes, (sign, -sign), strict=True):
        total = 0
        for first, last in stretches:
            push = outward * (x[first:last] - x[first])
            if float(push.max()) > 0.05 * span:
                total += last - first
        if total / y.size > worst[0]:
            worst = (total / y.size, level)
    return worst


def levels(values: Array) -> int:
    """Number of different values; where they are many, only so many that `coarse_levels` are exceeded."""
    some = int(np.unique(values[:FIRST_VALUES]).size)
    if some > POLICY.coarse_levels:
        return some
    return int(np.unique(values).size)


def check_pair(table: LogTable, columns: Sequence[str], samples: Samples) -> list[Finding]:
    """Findings about input and output together; signals that stand still are refused."""
    x_name, y_name = columns
    x, y = samples.values
    if is_constant(x):
        raise ExcitationError(
            f"input '{x_name}' of {table.name} {_still(x)}: nothing can be learned about how the output depends on "
            f"it. Name another input column, run or window.",
            column=x_name,
        )
    if is_constant(y):
        raise RecordingError(
            f"output '{y_name}' of {table.name} {_still(y)} although the input moves: the sensor is not connected, or "
            f"it is the wrong column. Name another output column, run or window.",
            column=y_name,
        )
    signals = (("input", x_name, x), ("output", y_name, y))
    return [
        *_held(table, signals, samples.time),
        *_stuck(table, y_name, x, y),
        *_clipped(table, x_name, x, y),
        *_coarse(table, signals),
        *_few_loops(table, x_name, x),
        *_swapped(table, x_name, y_name),
    ]


def _held(table: LogTable, signals: Signals, time: Array | None) -> list[Finding]:
    findings = []
    for role, name, values in signals:
        hold = hold_length(values)
        if hold == 1.0:
            continue
        rate = ""
        if time is not None:
            step = float(np.median(np.diff(time)))
            rate = f", about {1 / (hold * step):.2g} Hz" if step > 0 else ""
        better = _between(table, name)
        cure = (
            f"Column '{better}' looks like the same signal between its updates: use that one."
            if better
            else "Log it faster, or interpolate between its updates."
        )
        findings.append(
            Finding(
                f"held-{role}",
                f"{role} '{name}' of {table.name} changes only every {hold:.0f} samples{rate} and is held in between. "
                f"The steps look like hysteresis and the delay like a lag. {cure}",
            )
        )
    return findings


def _between(table: LogTable, name: str) -> str | None:
    mine = set(words(parse_unit(name)[0]))
    for candidate in table.columns:
        theirs = set(words(parse_unit(candidate)[0]))
        if (
            candidate != name
            and theirs & BETWEEN_WORDS
            and mine <= theirs
            and table.units.get(candidate) == table.units[name]
        ):
            return candidate
    return None


def _stuck(table: LogTable, y_name: str, x: Array, y: Array) -> list[Finding]:
    share, level = stuck_share(x, y)
    if (
        share <= POLICY.stuck_share or levels(y) <= POLICY.coarse_levels
    ):  # a coarse converter rests at its top level as well
        return []
    level_text = f"{level:.6g} {table.units.get(y_name, '')}".rstrip()
    return [
        Finding(
            "saturated-output",
            f"output '{y_name}' of {table.name} sits exactly at {level_text} in {100 * share:.2g} % "
            "of the samples while "
            f"the input still pushes on: sensor or converter is at the end of its range, or the actuator at a stop. "
            f"What happens beyond cannot be learned or inverted. Reduce the input's range, or cut it away.",
        )
    ]


def _clipped(table: LogTable, x_name: str, x: Array, y: Array) -> list[Finding]:
    if (
        levels(x) <= POLICY.coarse_levels
    ):  # a coarse converter stands at its top level while the input turns there
        return []
    return about_clipping(x_name, table.name, x, y, table.units.get(x_name, ""))


def _coarse(table: LogTable, signals: Signals) -> list[Finding]:
    findings = []
    for role, name, values in signals:
        count = levels(values)
        if count <= POLICY.coarse_levels and values.size >= 8 * count:
            findings.append(
                Finding(
                    f"quantised-{role}",
                    f"{role} '{name}' of {table.name} takes only {count} different values in {values.size} rows; no "
                    f"model can be better than {50 / max(1, count - 1):.2g} % of the range. Log it with more digits.",
                )
            )
    return findings


def _few_loops(table: LogTable, x_name: str, x: Array) -> list[Finding]:
    # Swings, not turns: noise at the very start is a turning point, but no way out and back.
    smallest = POLICY.loop_share * float(np.ptp(x))
    turns = int(np.sum(summarise_loops(x, smallest).swings > smallest)) - 1
    if turns >= 2:
        return []
    once = f"turns only once by more than {100 * POLICY.loop_share:g} % of its range: there is one such loop"
    movement = "never turns: it moves one way only" if turns <= 0 else once
    cure = (
        "Hysteresis cannot be seen without a way back: log at least one full loop, better two."
        if turns <= 0
        else "A half of the log holds one branch only: fit all of it (--train-fraction 1), and log a second loop "
        "for a test."
    )
    return [Finding("few-loops", f"input '{x_name}' of {table.name} {movement}. {cure}")]


def _swapped(table: LogTable, x_name: str, y_name: str) -> list[Finding]:
    """Names only, and only where both speak: a displacement that drives a force is no mistake."""
    x_dimension, y_dimension = (dimension(table.units.get(name, "")) for name in (x_name, y_name))
    x_command, y_command = (bool(COMMAND_WORDS & set(words(name))) for name in (x_name, y_name))
    by_unit = y_dimension in DRIVES and x_dimension in MOTIONS
    by_name = y_command and not x_command and x_dimension not in DRIVES
    if not (by_unit or by_name):
        return []
    reason = f"{_a(y_dimension)} drives, {_a(x_dimension)} follows ('{y_name}' is the output here)"
    return [
        Finding(
            "swapped-columns",
            f"input and output of {table.name} look swapped: "
            f"{reason if by_unit else f'the output {y_name} is named like a command'}. If so, type: "
            f"--input {y_name} --output {x_name}",
        )
    ]


def _a(noun: str) -> str:
    return f"an {noun}" if noun[:1] in "aeiou" else f"a {noun}"
