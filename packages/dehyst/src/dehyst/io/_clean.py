"""Cleans logs: rows without measurements, false values, wrapped angles, gaps; reports every change.

A false value is a number that was not measured: a spike, or the code of a failed sensor. One of them is enough to spoil
a fit, because a play operator remembers the extreme for ever.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array, Mask, Rows
from dehyst.data import POLICY as DATA_POLICY
from dehyst.data import find_outliers, gap_limit, is_even, memory_lost, turning_points
from dehyst.errors import RecordingError
from dehyst.findings import Finding
from dehyst.io._policy import POLICY
from dehyst.io._table import finite, list_rows, number_of
from dehyst.units import canonical

TURN = {"deg": 360.0, "rad": 2 * math.pi}


@dataclass(frozen=True, eq=False)
class Samples:
    """Signals on one clock, on their way to a recording."""

    time: Array | None  # (T,) [s]
    values: tuple[Array, ...]  # (T,) each; the first is the input
    rows: Rows  # row of each sample in the file, (T,)
    breaks: tuple[int, ...] = ()  # indices before which the memory is lost
    # rows of the file at which the clock was set, and by how much [s]
    jumps: tuple[tuple[int, float], ...] = ()

    def take(self, index: npt.NDArray[np.int64] | npt.NDArray[np.bool_]) -> Samples:
        """Samples at `index`, which must come before any break is known."""
        time = self.time
        if time is not None:
            time = time[index]
        values = tuple(v[index] for v in self.values)
        return replace(self, time=time, values=values, rows=self.rows[index])


@dataclass(frozen=True, slots=True)
class Context:
    """What messages need: the log's name, the columns in use, what rows are called, units; and where findings go."""

    log: str
    columns: tuple[str, ...]
    word: str = "row"
    units: tuple[str, ...] = ()
    findings: list[Finding] = field(default_factory=list)

    def say(self, code: str, message: str) -> None:
        """Add a finding."""
        self.findings.append(Finding(code, message))

    def say_once(self, finding: Finding) -> None:
        """Add a finding, unless it is there already."""
        if finding not in self.findings:
            self.findings.append(finding)


def drop_unmeasured(samples: Samples, about: Context) -> Samples:
    """Drop rows in which a signal or the time is empty, not finite or not a number."""
    signals = list(samples.values)
    if samples.time is not None:
        signals.append(samples.time)
    good = np.logical_and.reduce(list(map(finite, signals)))
    if good.all() and good.size:
        return samples
    if not good.any():
        raise RecordingError(
            f"{about.log} has no {about.word} in which {' and '.join(about.columns)} are both numbers, out of "
            f"{good.size}. Check the columns with: dehyst inspect LOG",
            columns=about.columns,
            rows=good.size,
        )
    bad = samples.rows[~good]
    about.say(
        "non-finite",
        f"{bad.size} of {good.size} rows of {about.log} were left out because a cell of {', '.join(about.columns)} "
        f"is empty, infinite or not a number: {list_rows(bad, about.word)}. Nothing to do if the sensor is known "
        f"to drop out; otherwise check its cable.",
    )
    return samples.take(good)


def hold_unmeasured(samples: Samples, about: Context) -> Samples:
    """Hold the last value where a signal has none; rows without time are dropped.

    A command signal is played back sample by sample: a row left out would shift everything after it. Where more than
    half of the rows are empty, the signal was logged in turns with others, and nothing is held.
    """
    bad = [~finite(v) for v in samples.values]
    missing = np.logical_or.reduce(bad)
    if not missing.any() or missing.mean() > POLICY.held_most:
        return drop_unmeasured(samples, about)
    filled_values = tuple(map(hold_last, samples.values, bad))
    rows = samples.rows[missing]
    verb = "has" if rows.size == 1 else "have"
    about.say(
        "held-reference",
        f"{rows.size} of {missing.size} rows of {about.log} {verb} no number in "
        f"{', '.join(about.columns)} ({list_rows(rows, about.word)}); the last value was held there, so that every "
        f"row still has its sample. Fill these cells, if the motion should go on in them.",
    )
    return drop_unmeasured(replace(samples, values=filled_values), about)


def hold_last(values: Array, bad: npt.NDArray[np.bool_]) -> Array:
    """Put the last good value where there is none; before the first good one, the first."""
    good = np.flatnonzero(~bad)
    last = np.searchsorted(good, np.arange(values.size), side="right") - 1
    return np.asarray(values[good[np.maximum(last, 0)]])


def drop_outliers(samples: Samples, about: Context, hold: bool = False) -> Samples:
    """Unwrap angles; leave out rows with an outlier, or hold the value before it: a signal is played row by row."""
    samples, wrapped = _unwrap(samples, about, set())
    masks = list(map(find_outliers, samples.values))
    bad = np.logical_or.reduce(masks)
    if not bad.any():
        return samples
    examples: list[str] = []
    for v, mask, name in zip(samples.values, masks, about.columns, strict=True):
        if mask.any():
            examples.append(_named(samples, v, mask, name, about))
    if hold:
        remedy = "the value before each was held"
        cleaned = replace(samples, values=tuple(map(hold_last, samples.values, masks)))
    else:
        remedy = "their rows were left out"
        cleaned = samples.take(~bad)
    about.say(
        "outlier",
        f"{int(bad.sum())} of {bad.size} rows of {about.log} hold a value far from those beside it "
        f"({'; '.join(examples)}); {remedy}. A single one would spoil the fit, because the model remembers extremes. "
        f"Check the sensor and its wiring; if the values are real, log faster so that they are more than a spike.",
    )
    return _unwrap(cleaned, about, wrapped)[0]


def _named(samples: Samples, v: Array, mask: Mask, name: str, about: Context) -> str:
    rows = samples.rows[mask]
    shown = ", ".join(f"{value:.6g}" for value in dict.fromkeys(v[mask][:4].tolist()))
    return f"'{name}' is {shown} in {list_rows(rows, about.word)}"


def _unwrap(samples: Samples, about: Context, unwrapped: set[int]) -> tuple[Samples, set[int]]:
    values = list(samples.values)
    for k, (v, unit) in enumerate(zip(samples.values, about.units, strict=False)):
        turn = TURN.get(canonical(unit) or "")
        if turn is None or k in unwrapped:
            continue
        jumps = wraps(v, turn)
        if jumps.size == 0:
            continue
        unwrapped = unwrapped | {k}
        count = np.zeros(v.size)
        count[jumps] = -np.sign(v[jumps] - v[jumps - 1])
        values[k] = v + turn * np.cumsum(count)
        about.say(
            "angle-wrap",
            f"'{about.columns[k]}' of {about.log} jumps by a full turn {number_of(jumps.size, 'time')}, at "
            f"{list_rows(samples.rows[jumps], about.word)}: the angle wraps around. It was unwrapped and now runs from "
            f"{values[k].min():.6g} to {values[k].max():.6g} {unit}. Nothing to do; the model knows the unwrapped "
            f"angle.",
        )
    return replace(samples, values=tuple(values)), unwrapped


def wraps(v: Array, turn: float) -> npt.NDArray[np.int64]:
    """Samples at which an angle jumps by a full turn, and would be smooth if it did not.

    Examples
    --------
    >>> wraps(np.arange(100.0) * 7 % 360, 360.0).tolist()
    [52]
    """
    nothing = np.zeros(0, dtype=np.int64)
    if v.size < DATA_POLICY.judged_from or float(np.ptp(v)) > 1.001 * turn:
        return nothing
    low, high = float(v.min()), float(v.max())
    slack = 1e-3 * turn
    circle = (low >= -slack and high <= turn + slack) or (
        low >= -turn / 2 - slack and high <= turn / 2 + slack
    )
    step = np.diff(v)
    jump = np.abs(step) > POLICY.wrapped * turn
    if not circle or not jump.any() or jump.all():
        return nothing
    usual = float(np.max(np.abs(step[~jump])))
    left = np.abs(np.abs(step[jump]) - turn)
    # A square wave between the ends of the circle does not become smooth.
    if float(np.max(left)) > POLICY.unwrapped_step * usual:
        return nothing
    return np.flatnonzero(jump) + 1


def _within(broken: int, gaps: int) -> str:
    if gaps == 1:
        return "In it"
    if broken == gaps:
        return "In all of them"
    return f"In {broken} of them"


def find_gaps(samples: Samples, about: Context) -> Samples:
    """Find gaps; break the recording where the input may have moved unseen.

    A gap breaks the memory if the input differs by more than 5 % of its range across it, or if it is longer
    than half a loop, so that the input may have gone and come back. Without time, rows are counted instead. Rows that
    were left out are no news unless they break it.
    """
    t, unit = samples.time, "s"
    if t is None:
        # Without time a stretch of dropped rows is the gap; after sorting, rows need not increase.
        t, unit = samples.rows.astype(np.float64), "rows"
    if t.size < 3:
        return samples
    step = np.diff(t)
    if 0.0 < float(step.max()) <= DATA_POLICY.gap_samples * float(step.min()):
        return samples  # the limit is more than that many of the shortest steps
    limit = gap_limit(step)
    gaps = np.flatnonzero(step > limit) + 1
    gaps = np.setdiff1d(gaps, np.array(samples.breaks, dtype=np.int64))
    if gaps.size == 0:
        return samples
    x = samples.values[0]
    moved = np.abs(x[gaps] - x[gaps - 1])
    measured = float(np.sum(np.clip(step, 0.0, limit)))
    swings = turning_points(x).size - 1
    broken = gaps[memory_lost(step[gaps - 1], moved, float(np.ptp(x)), measured, swings)]
    # Rows that were left out, in which nothing was lost, were said where they were left out.
    usual = float(np.median(step))
    reported = step[gaps - 1] <= (np.abs(np.diff(samples.rows))[gaps - 1] + 0.5) * usual
    if broken.size == 0 and reported.all():
        return samples
    longest = int(gaps[np.argmax(step[gaps - 1])])
    message = (
        f"{about.log} has {number_of(gaps.size, 'gap')}, before {list_rows(samples.rows[gaps], about.word)}; the "
        f"longest, {step[longest - 1]:.4g} {unit} from {t[longest - 1]:.6g} to {t[longest]:.6g} {unit}, against "
        f"{usual:.3g} {unit} usually."
    )
    if samples.time is not None and not reported.all():
        if is_even(step):
            message += " Rows are missing there, or the clock was set."
        else:
            message += " Rows of this log come at uneven times, so nothing may be missing there."
    if broken.size:
        message += (
            f" {_within(broken.size, gaps.size)} the input may have turned unseen, so the memory of the actuator is "
            f"taken as unknown after it. Keep one side of it, with --from or --to, if that is enough."
        )
    else:
        message += " The input hardly moved across them, so the recording goes on. Nothing to do."
    about.say("gap", message)
    return replace(samples, breaks=tuple(sorted({*samples.breaks, *broken.tolist()})))
