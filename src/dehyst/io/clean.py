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
from dehyst.data.loops import GAP_SAMPLES, gap_limit, is_even, memory_lost, turning_points
from dehyst.data.outliers import FEWEST, find_outliers
from dehyst.errors import RecordingError
from dehyst.findings import Finding
from dehyst.io.table import finite, list_rows
from dehyst.units import canonical

HELD_MOST = 0.5  # of the rows of a reference may be empty and held
TURN = {"deg": 360.0, "rad": 2 * math.pi}
WRAPPED = 0.8  # of a turn: a jump from one end of the circle to the other
SMOOTH = 3.0  # largest other steps: what may remain of such a jump once it is unwrapped


@dataclass(frozen=True, eq=False)
class Samples:
    """Signals on one clock, on their way to a recording."""

    time: Array | None  # (T,) [s]
    values: tuple[Array, ...]  # (T,) each; the first is the input
    rows: Rows  # row of each sample in the file, (T,)
    breaks: tuple[int, ...] = ()  # indices before which the memory is lost
    jumps: tuple[tuple[int, float], ...] = ()  # rows of the file at which the clock was set, and by how much [s]

    def take(self, index: npt.NDArray[np.int64] | npt.NDArray[np.bool_]) -> Samples:
        """Samples at `index`, which must come before any break is known."""
        time = None if self.time is None else self.time[index]
        return replace(self, time=time, values=tuple(v[index] for v in self.values), rows=self.rows[index])


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


def drop_unmeasured(samples: Samples, about: Context) -> Samples:
    """Drop rows in which a signal or the time is empty, not finite or not a number."""
    parts = samples.values if samples.time is None else (*samples.values, samples.time)
    good = np.logical_and.reduce([finite(part) for part in parts])
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
    if not missing.any() or missing.mean() > HELD_MOST:
        return drop_unmeasured(samples, about)
    held = tuple(hold_last(v, mask) for v, mask in zip(samples.values, bad, strict=True))
    rows = samples.rows[missing]
    many = rows.size > 1
    about.say(
        "held-reference",
        f"{rows.size} of {missing.size} rows of {about.log} {'have' if many else 'has'} no number in "
        f"{', '.join(about.columns)} ({list_rows(rows, about.word)}); the last value was held there, so that every "
        f"row still has its sample. Fill these cells, if the motion should go on in them.",
    )
    return drop_unmeasured(replace(samples, values=held), about)


def hold_last(values: Array, bad: npt.NDArray[np.bool_]) -> Array:
    """Put the last good value where there is none; before the first good one, the first."""
    good = np.flatnonzero(~bad)
    last = np.searchsorted(good, np.arange(values.size), side="right") - 1
    return np.asarray(values[good[np.maximum(last, 0)]])


def drop_outliers(samples: Samples, about: Context, hold: bool = False) -> Samples:
    """Unwrap angles; leave out rows with an outlier, or hold the value before it: a signal is played row by row."""
    samples, wrapped = _unwrap(samples, about, set())
    masks = [find_outliers(v) for v in samples.values]
    bad = np.logical_or.reduce(masks)
    if not bad.any():
        return samples
    what = "; ".join(
        _named(samples, v, mask, name, about)
        for v, mask, name in zip(samples.values, masks, about.columns, strict=True)
        if mask.any()
    )
    done = "the value before each was held" if hold else "their rows were left out"
    about.say(
        "outlier",
        f"{int(bad.sum())} of {bad.size} rows of {about.log} hold a value far from those beside it ({what}); {done}. A "
        f"single one would spoil the fit, because the model remembers extremes. Check the sensor and its wiring; "
        f"if the values are real, log faster so that they are more than a spike.",
    )
    if hold:
        samples = replace(
            samples, values=tuple(hold_last(v, mask) for v, mask in zip(samples.values, masks, strict=True))
        )
    else:
        samples = samples.take(~bad)
    return _unwrap(samples, about, wrapped)[0]


def _named(samples: Samples, v: Array, mask: Mask, name: str, about: Context) -> str:
    rows = samples.rows[mask]
    shown = ", ".join(f"{value:.6g}" for value in dict.fromkeys(v[mask][:4].tolist()))
    return f"'{name}' is {shown} in {list_rows(rows, about.word)}"


def _unwrap(samples: Samples, about: Context, done: set[int]) -> tuple[Samples, set[int]]:
    values = list(samples.values)
    for k, (v, unit) in enumerate(zip(samples.values, about.units, strict=False)):
        turn = TURN.get(canonical(unit) or "")
        jumps = np.zeros(0, dtype=np.int64) if turn is None or k in done else wraps(v, turn)
        if turn is None or jumps.size == 0:
            continue
        done = done | {k}
        count = np.zeros(v.size)
        count[jumps] = -np.sign(v[jumps] - v[jumps - 1])
        values[k] = v + turn * np.cumsum(count)
        about.say(
            "angle-wrap",
            f"'{about.columns[k]}' of {about.log} jumps by a full turn {jumps.size} "
            f"{'times' if jumps.size > 1 else 'time'}, at {list_rows(samples.rows[jumps], about.word)}: the angle "
            f"wraps around. It was unwrapped and now runs from {values[k].min():.6g} to {values[k].max():.6g} "
            f"{unit}. Nothing to do; the model knows the unwrapped angle.",
        )
    return replace(samples, values=tuple(values)), done


def wraps(v: Array, turn: float) -> npt.NDArray[np.int64]:
    """Samples at which an angle jumps by a full turn, and would be smooth if it did not.

    Examples
    --------
    >>> wraps(np.arange(100.0) * 7 % 360, 360.0).tolist()
    [52]
    """
    nothing = np.zeros(0, dtype=np.int64)
    if v.size < FEWEST or float(np.ptp(v)) > 1.001 * turn:
        return nothing
    low, high = float(v.min()), float(v.max())
    slack = 1e-3 * turn
    circle = (low >= -slack and high <= turn + slack) or (low >= -turn / 2 - slack and high <= turn / 2 + slack)
    step = np.diff(v)
    jump = np.abs(step) > WRAPPED * turn
    if not circle or not jump.any() or jump.all():
        return nothing
    usual = float(np.max(np.abs(step[~jump])))
    left = np.abs(np.abs(step[jump]) - turn)
    # A square wave between the ends of the circle does not become smooth.
    return nothing if float(np.max(left)) > SMOOTH * usual else np.flatnonzero(jump) + 1


def _within(broken: int, gaps: int) -> str:
    return f"In {'all' if broken == gaps else broken} of them" if gaps > 1 else "In it"


_UNEVEN = " Rows of this log come at uneven times, so nothing may be missing there."


def find_gaps(samples: Samples, about: Context) -> Samples:
    """Find gaps; break the recording where the input may have moved unseen.

    A gap breaks the memory if the input differs by more than 5 % of its range across it, or if it is longer
    than half a loop, so that the input may have gone and come back. Without time, rows are counted instead. Rows that
    were left out are no news unless they break it.
    """
    # Without time a stretch of dropped rows is the gap; after sorting, rows need not increase.
    t = samples.time if samples.time is not None else samples.rows.astype(np.float64)
    if t.size < 3:
        return samples
    step = np.diff(t)
    if 0.0 < float(step.max()) <= GAP_SAMPLES * float(step.min()):
        return samples  # the limit is more than that many of the shortest steps
    limit = gap_limit(step)
    found = np.flatnonzero(step > limit) + 1
    found = np.setdiff1d(found, np.array(samples.breaks, dtype=np.int64))
    if found.size == 0:
        return samples
    x = samples.values[0]
    moved = np.abs(x[found] - x[found - 1])
    measured = float(np.sum(np.clip(step, 0.0, limit)))
    broken = found[memory_lost(step[found - 1], moved, float(np.ptp(x)), measured, turning_points(x).size - 1)]
    # Rows that were left out, in which nothing was lost, were said where they were left out.
    told = step[found - 1] <= (np.abs(np.diff(samples.rows))[found - 1] + 0.5) * float(np.median(step))
    if broken.size == 0 and told.all():
        return samples
    unit = "s" if samples.time is not None else "rows"
    longest = int(found[np.argmax(step[found - 1])])
    what = (
        f"{about.log} has {found.size} gap{'s' if found.size > 1 else ''}, before "
        f"{list_rows(samples.rows[found], about.word)}; the longest, {step[longest - 1]:.4g} {unit} from "
        f"{t[longest - 1]:.6g} to {t[longest]:.6g} {unit}, against {float(np.median(step)):.3g} {unit} usually."
    )
    if samples.time is not None and not told.all():
        what += " Rows are missing there, or the clock was set." if is_even(step) else _UNEVEN
    cure = (
        f" {_within(broken.size, found.size)} the input may have turned unseen, so the memory of the actuator is taken "
        f"as unknown after it. Keep one side of it, with --from or --to, if that is enough."
        if broken.size
        else " The input hardly moved across them, so the recording goes on. Nothing to do."
    )
    about.say("gap", what + cure)
    return replace(samples, breaks=tuple(sorted({*samples.breaks, *(int(k) for k in broken)})))
