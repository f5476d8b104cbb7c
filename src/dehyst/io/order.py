"""Time stamps out of order: repeated, swapped, stray, restarting. Every cure is a finding."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from dehyst.errors import TimeError
from dehyst.findings import Finding
from dehyst.io.clean import Context, Samples
from dehyst.io.table import Array, list_rows

MAX_RESTARTS = 50


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
