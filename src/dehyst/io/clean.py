"""Cleaning: rows that hold no measurement, time stamps out of order, gaps. Every cure is a finding."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from dehyst.errors import RecordingError, TimeError
from dehyst.findings import Finding
from dehyst.io.table import Array, Rows, finite, list_rows
from dehyst.loops import turning_points

GAP_MEDIANS = 5.0  # a step this many times the median is a gap ...
GAP_SAMPLES = 3.0  # ... if it also misses this many samples at the usual rate
MOVED = 0.05  # of the input's range: more than this across a gap, and the memory is unknown
MAX_RESTARTS = 50


@dataclass(frozen=True, eq=False)
class Samples:
    """Signals on one clock, on their way to a recording.

    Attributes
    ----------
    time
        Stamps, (T,), or None. [s]
    values
        Signals, each (T,); the first is the input.
    rows
        Row of each sample in the file, (T,).
    breaks
        Indices before which the memory is lost.
    """

    time: Array | None
    values: tuple[Array, ...]
    rows: Rows
    breaks: tuple[int, ...] = ()

    def take(self, index: npt.NDArray[np.int64] | npt.NDArray[np.bool_]) -> Samples:
        """Samples at `index`, which must come before any break is known."""
        time = None if self.time is None else self.time[index]
        return replace(self, time=time, values=tuple(v[index] for v in self.values), rows=self.rows[index])


@dataclass(frozen=True, slots=True)
class Context:
    """What messages need: the log's name, the columns in use, and what rows are called."""

    log: str
    columns: tuple[str, ...]
    word: str = "row"


def drop_unmeasured(samples: Samples, about: Context, findings: list[Finding]) -> Samples:
    """Drop rows in which a signal or the time is empty, not finite or not a number.

    Raises
    ------
    RecordingError
        If no row is left.
    """
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
    findings.append(
        Finding(
            "non-finite",
            f"{bad.size} of {good.size} rows of {about.log} were left out because a cell of {', '.join(about.columns)} "
            f"is empty, infinite or not a number: {list_rows(bad, about.word)}. Nothing to do if the sensor is known "
            f"to drop out; otherwise check its cable.",
        )
    )
    return samples.take(good)


def order_time(samples: Samples, about: Context, findings: list[Finding]) -> Samples:
    """Make time increase: keep the first of repeated stamps, sort swapped pairs, break where the clock restarts.

    Raises
    ------
    TimeError
        If the stamps are in no order at all.
    """
    if samples.time is None or samples.time.size < 2:
        return samples
    if np.all(np.diff(samples.time) > 0):
        return samples
    samples = _turn_around(samples, about, findings)
    samples = _sort_swapped(samples, about, findings)
    samples = _drop_stray(samples, about, findings)
    samples = _drop_repeated(samples, about, findings)
    time = samples.time
    assert time is not None
    restarts = np.flatnonzero(np.diff(time) < 0) + 1
    if restarts.size == 0:
        return samples
    if restarts.size > MAX_RESTARTS and restarts.size > 0.01 * time.size:
        raise TimeError(
            f"time stamps of {about.log} run backward {restarts.size} times in {time.size} rows, first at "
            f"{list_rows(samples.rows[restarts], about.word)}. The order of the samples is the memory of the actuator, "
            f"so it is not guessed. Sort the log by time, or name another time column with --time.",
            rows=samples.rows[restarts],
        )
    findings.append(
        Finding(
            "clock-restart",
            f"the clock of {about.log} jumps back at {list_rows(samples.rows[restarts], about.word)}: several "
            f"recordings follow each other. Each is treated as a piece of its own, with unknown memory at its start. "
            f"Better split the log, or add a column run.",
        )
    )
    return replace(samples, breaks=tuple(int(k) for k in restarts))


def _turn_around(samples: Samples, about: Context, findings: list[Finding]) -> Samples:
    step = np.diff(samples.time if samples.time is not None else np.zeros(0))
    if step.size < 3 or not np.mean(step < 0) > 0.95:
        return samples
    findings.append(
        Finding("reversed-time", f"{about.log} is written newest row first; it was turned around. Nothing to do.")
    )
    return samples.take(np.arange(samples.rows.size - 1, -1, -1))


def _sort_swapped(samples: Samples, about: Context, findings: list[Finding]) -> Samples:
    t = samples.time
    assert t is not None
    order = np.arange(t.size)
    swapped: list[int] = []
    for k in (np.flatnonzero(np.diff(t) < 0) + 1).tolist():
        before = t[k - 2] if k >= 2 else -np.inf
        after = t[k + 1] if k + 1 < t.size else np.inf
        if before < t[k] and t[k - 1] < after and not (k >= 2 and order[k - 1] != k - 1):
            order[k - 1], order[k] = k, k - 1
            swapped.append(k)
    # At the very ends a pair cannot be told from a restart of the clock by order alone; its size tells.
    typical = _typical_step(t)
    far = [k for k in swapped if t[k - 1] - t[k] > 10 * typical]
    for k in far:
        order[k - 1], order[k] = k - 1, k
    swapped = [k for k in swapped if k not in set(far)]
    if not swapped:
        return samples
    rows = samples.rows[np.array(swapped)]
    findings.append(
        Finding(
            "swapped-rows",
            f"{len(swapped)} rows of {about.log} stand after the row that follows them in time "
            f"({list_rows(rows, about.word)}); they were put in order. Nothing to do.",
        )
    )
    return samples.take(order)


def _drop_stray(samples: Samples, about: Context, findings: list[Finding]) -> Samples:
    """Drop single stamps that fit neither before nor after while their neighbours fit each other."""
    t = samples.time
    assert t is not None
    typical = _typical_step(t)
    stray: set[int] = set()
    for k in (np.flatnonzero(np.diff(t) < 0) + 1).tolist():
        if k >= 2 and 0 < t[k] - t[k - 2] <= 4 * typical:
            stray.add(k - 1)  # one stamp too high
        elif k + 1 < t.size and 0 < t[k + 1] - t[k - 1] <= 4 * typical:
            stray.add(k)  # one stamp too low
    if not stray:
        return samples
    index = np.array(sorted(stray))
    findings.append(
        Finding(
            "stray-time",
            f"{index.size} time stamps of {about.log} fit neither the one before nor the one after "
            f"({list_rows(samples.rows[index], about.word)}); these rows were left out. Check the logger if there are "
            f"many.",
        )
    )
    return samples.take(np.delete(np.arange(t.size), index))


def _drop_repeated(samples: Samples, about: Context, findings: list[Finding]) -> Samples:
    t = samples.time
    assert t is not None
    repeated = np.concatenate(([False], np.diff(t) == 0))
    if not repeated.any():
        return samples
    again = np.flatnonzero(repeated)
    differ = sum(np.any(v[again] != v[again - 1]) for v in samples.values) > 0
    advice = (
        "The values differ, so the clock is coarser than the sampling: log it with more digits."
        if differ
        else "The values agree, so nothing is lost."
    )
    findings.append(
        Finding(
            "repeated-time",
            f"{again.size} of {t.size} rows of {about.log} repeat the time stamp before them "
            f"({list_rows(samples.rows[again], about.word)}); the first of each was kept. {advice}",
        )
    )
    return samples.take(~repeated)


def _typical_step(t: Array) -> float:
    step = np.diff(t)
    step = step[step > 0]
    return float(np.median(step)) if step.size else 0.0


def gap_limit(t: Array) -> float:
    """Smallest step between samples that counts as a gap: 5 medians and 3 usual steps. [s]

    The usual step is the mean of the shortest 95 %. Where more than one step in twenty would be a gap, samples come
    in bursts, and only what is 5 times longer than the pauses between bursts counts.
    """
    step = np.diff(t)
    step = np.sort(step[step > 0])
    if step.size == 0:
        return float("inf")
    usual = float(np.mean(step[: max(1, int(0.95 * step.size))]))
    limit = max(GAP_MEDIANS * float(np.median(step)), GAP_SAMPLES * usual)
    if np.mean(step > limit) > 0.05:
        limit = GAP_MEDIANS * float(np.percentile(step, 95))
    return limit


def find_gaps(samples: Samples, about: Context, findings: list[Finding]) -> Samples:
    """Find gaps; break the recording where the input may have moved unseen.

    A gap breaks the memory if the input differs by more than 5 % of its range across it, or if it is longer
    than half a loop, so that the input may have gone and come back. Without time, rows are counted instead.
    """
    # Without time a stretch of dropped rows is the gap; after sorting, rows need not increase.
    t = samples.time if samples.time is not None else samples.rows.astype(np.float64)
    if t.size < 3:
        return samples
    step = np.diff(t)
    found = np.flatnonzero(step > gap_limit(t)) + 1
    found = np.setdiff1d(found, np.array(samples.breaks, dtype=np.int64))
    if found.size == 0:
        return samples
    x = samples.values[0]
    moved = np.abs(x[found] - x[found - 1])
    turns = turning_points(x)
    measured = float(np.sum(np.clip(step, 0.0, gap_limit(t))))
    half_loop = measured / max(1, turns.size - 1)
    broken = found[(moved > MOVED * float(np.ptp(x))) | (step[found - 1] > half_loop)]
    unit = "s" if samples.time is not None else "rows"
    longest = int(found[np.argmax(step[found - 1])])
    what = (
        f"{about.log} has {found.size} gap{'s' if found.size > 1 else ''}, before "
        f"{list_rows(samples.rows[found], about.word)}; the longest, {step[longest - 1]:.4g} {unit} from "
        f"{t[longest - 1]:.6g} to {t[longest]:.6g} {unit}, against {float(np.median(step)):.3g} {unit} usually."
    )
    cure = (
        f" At {broken.size} of them the input may have turned unseen, so the memory of the actuator is taken as "
        f"unknown after it. Cut them away with --from and --to if one side is enough."
        if broken.size
        else " The input hardly moved across them, so the recording goes on. Nothing to do."
    )
    findings.append(Finding("gap", what + cure))
    return replace(samples, breaks=tuple(sorted({*samples.breaks, *(int(k) for k in broken)})))
