"""Time stamps out of order: repeated, swapped, stray, restarting. Every cure is a finding."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array
from dehyst.errors import TimeError
from dehyst.findings import Finding
from dehyst.io.clean import Context, Samples
from dehyst.io.jumps import mend_jumps
from dehyst.io.table import list_rows

MAX_RESTARTS = 50
FEW = 0.01  # of the rows: this many may stand out of order, and this far from their place
NEAREST = 10  # rows from its place that a row may stand in a short log
COARSE_SHARE = 0.5  # of the rows repeat a stamp: the clock is coarse, and even equal rows are samples


def order_time(samples: Samples, about: Context, findings: list[Finding]) -> Samples:
    """Make time increase: sort the few rows out of order, take out jumps, spread repeated stamps, break at restarts.

    Raises
    ------
    TimeError
        If the stamps are in no order at all.
    """
    if samples.time is None or samples.time.size < 2:
        return samples
    if np.all(np.diff(samples.time) > 0):
        return mend_jumps(samples, about, findings)
    samples = _turn_around(samples, about, findings)
    samples = _sort_few(samples, about, findings)
    samples = _sort_swapped(samples, about, findings)
    samples = _drop_stray(samples, about, findings)
    samples = mend_jumps(samples, about, findings)
    samples = _drop_doubled(samples, about, findings)
    samples = _spread_repeated(samples, about, findings)
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


def _sort_few(samples: Samples, about: Context, findings: list[Finding]) -> Samples:
    """Sort if few rows stand out of order, near their place, and leave no hole where they belong.

    A clock that restarts, or a stamp that is simply wrong, does not fit between other stamps in this way.
    """
    t = samples.time
    assert t is not None
    late = np.flatnonzero(t < np.maximum.accumulate(t))
    if late.size == 0 or late.size > max(1, FEW * t.size):
        return samples
    order = np.argsort(t, kind="stable")
    moved = np.abs(order - np.arange(t.size))
    if moved.max() > max(NEAREST, FEW * t.size):
        return samples
    step = np.diff(t[order])
    typical = float(np.median(step))
    touched = step[(moved[1:] > 0) | (moved[:-1] > 0)]
    # Two recordings laid into each other have steps of half the usual size, or less.
    if touched.min() < 0.6 * typical or touched.max() > 4.0 * typical:
        return samples
    findings.append(_put_in_order(samples, late, about))
    return samples.take(order)


def _put_in_order(samples: Samples, late: npt.NDArray[np.int64], about: Context) -> Finding:
    many = late.size > 1
    return Finding(
        "swapped-rows",
        f"{late.size} row{'s' if many else ''} of {about.log} {'stand' if many else 'stands'} after rows that follow "
        f"{'them' if many else 'it'} in time ({list_rows(samples.rows[late], about.word)}); they were put in order. "
        f"Nothing to do.",
    )


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
    findings.append(_put_in_order(samples, np.array(swapped, dtype=np.int64), about))
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


def _drop_doubled(samples: Samples, about: Context, findings: list[Finding]) -> Samples:
    """Drop rows that repeat stamp and values of the row before them, unless the clock is coarse."""
    t = samples.time
    assert t is not None
    repeated = np.concatenate(([False], np.diff(t) == 0))
    same = np.logical_and.reduce([np.concatenate(([False], np.diff(v) == 0)) for v in samples.values])
    doubled = repeated & same
    # With a coarse clock, equal rows are a signal at rest.
    coarse = repeated.sum() >= COARSE_SHARE * t.size and doubled.sum() < 0.9 * repeated.sum()
    if not doubled.any() or coarse:
        return samples
    findings.append(
        Finding(
            "repeated-time",
            f"{int(doubled.sum())} of {t.size} rows of {about.log} repeat the time stamp and the values before them "
            f"({list_rows(samples.rows[doubled], about.word)}); the first of each was kept. Nothing is lost.",
        )
    )
    return samples.take(~doubled)


def _spread_repeated(samples: Samples, about: Context, findings: list[Finding]) -> Samples:
    """Spread the rows that share a stamp evenly over the time to the next stamp.

    A group of n rows at stamp t, followed by the stamp t', gets t + k (t' - t) / n, k = 0..n-1. Before a gap the
    usual step between stamps takes the place of t' - t. Where most stamps are shared, the first group may
    have begun before the log did; it then ends where the second begins, at the usual pace.
    """
    t = samples.time
    assert t is not None
    starts = np.concatenate(([0], np.flatnonzero(np.diff(t) != 0) + 1))
    if starts.size == t.size or starts.size < 2:
        return samples
    counts = np.diff(np.concatenate((starts, [t.size])))
    usual, many = _typical_step(t), float(np.median(counts))
    width = np.append(np.diff(t[starts]), usual)
    width = np.where((width <= 0) | (width > usual), usual, width)
    width[-1] = usual * min(1.0, counts[-1] / many)  # the log may end within a group
    place = np.arange(t.size) - np.repeat(starts, counts)
    begin = t[starts].copy()
    if many > 1 and counts[0] < many:
        begin[0] += usual * (1.0 - counts[0] / many)
        width[0] = usual * counts[0] / many
    spread = np.repeat(begin, counts) + place * np.repeat(width / counts, counts)
    shared = int(t.size - starts.size)
    findings.append(
        Finding(
            "coarse-time",
            f"{shared} of {t.size} rows of {about.log} share the time stamp of the row before them, in groups of up to "
            f"{int(counts.max())} (first at {list_rows(samples.rows[starts[counts > 1]], about.word)}): the clock is "
            f"coarser than the sampling, {usual:.4g} s against about {_typical_step(spread):.3g} s. The rows of each "
            f"group were spread evenly over its time. Rates are only as good as that; log time with more digits.",
        )
    )
    return replace(samples, time=spread)


def _typical_step(t: Array) -> float:
    step = np.diff(t)
    step = step[step > 0]
    return float(np.median(step)) if step.size else 0.0
