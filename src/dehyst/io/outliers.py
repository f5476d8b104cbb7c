"""Cells that are no measurement although they are numbers: spikes, codes of a failed sensor, wrapped angles.

One of them is enough to spoil a fit, because a play operator remembers the extreme for ever.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from dehyst.findings import Finding
from dehyst.io.clean import Context, Samples, hold_last
from dehyst.io.table import Array, list_rows
from dehyst.units import canonical

Mask = npt.NDArray[np.bool_]

SPIKE_LENGTH = 3  # samples: a longer excursion may be real
SPIKE_RANGE = 0.5  # of the range of the others: the least jump of a spike ...
SPIKE_CURVATURE = 10.0  # ... in units of the 99.9 % quantile of the second differences of the others ...
SPIKE_STEP = 2.0  # ... and of their largest step
END_RANGE = 10.0  # of the range: at the ends of a log there is only one neighbour to judge by
RARE = 0.01  # of the samples: more spikes than this are a signal, not a fault
FEWEST = 32  # samples below which nothing is judged ...
LEVELS = 8  # ... and different values among the others
CODE_DISTANCE = 3.0  # ranges of the others between them and a code
CODE_SHARE = 0.5
_CODES = [999.0, 9999.0, 99999.0, 999999.0, 9999999.0, 1e6, 1e7, 1e9, 1e10, 1e20, 1e30, 1e37, 1e38, 8191.0, 32767.0]
_CODES += [32768.0, 65535.0, 8388607.0, 8388608.0, 2147483647.0, 2147483648.0, 4294967295.0, 999.9, 9999.9]
CODES = np.array(sorted({*_CODES, *(-code for code in _CODES)}))
LEAST_CODE = min(_CODES)
TURN = {"deg": 360.0, "rad": 2 * math.pi}
WRAPPED = 0.8  # of a turn: a jump from one end of the circle to the other
SMOOTH = 3.0  # largest other steps: what may remain of such a jump once it is unwrapped


def find_outliers(values: Array) -> Mask:
    """Which samples are isolated spikes or codes of a failed sensor.

    A spike is an excursion of at most 3 samples that leaves both neighbours, in one direction, by more than half the
    range of the other samples, 10 times their curvature and twice their largest step. A code is a number such as
    -9999, 32767 or 1e6, repeated exactly, more than 3 ranges away from everything else.

    Parameters
    ----------
    values
        Signal in the order of the log, (T,), finite.

    Returns
    -------
    outliers : (T,)

    Examples
    --------
    >>> x = np.sin(np.arange(200) / 10)
    >>> x[50] = 100.0
    >>> np.flatnonzero(find_outliers(x)).tolist()
    [50]
    """
    found = np.zeros(values.size, dtype=bool)
    for _ in range(4):  # what one pass takes away may have hidden smaller ones
        index = np.flatnonzero(~found)
        fresh = _codes(values[index])
        if not fresh.any():
            fresh = _spikes(values[index])
        if not fresh.any():
            break
        found[index[fresh]] = True
    return found


def _codes(v: Array) -> Mask:
    nothing = np.zeros(v.size, dtype=bool)
    if v.size < FEWEST or max(-float(v.min()), float(v.max())) < LEAST_CODE:
        return nothing
    codes = np.isin(v, CODES)
    if not codes.any() or codes.mean() > CODE_SHARE:
        return nothing
    others = v[~codes]
    low, high = float(others.min()), float(others.max())
    if others.size < FEWEST or np.unique(others).size < LEVELS:  # a staircase of a few levels has no range to leave
        return nothing
    away = CODE_DISTANCE * (high - low)
    return np.asarray(codes & ((v > high + away) | (v < low - away)))


def _spikes(v: Array) -> Mask:
    flagged: Mask = np.zeros(v.size, dtype=bool)
    if v.size < FEWEST:
        return flagged
    steps = np.diff(v)
    largest = max(float(steps.max()), -float(steps.min()))  # no excursion is larger than the step into it
    if largest <= 0.99 * 0.8 * SPIKE_RANGE * _certain_range(v):
        return flagged
    low, high = np.percentile(v, [2, 98])
    least = 0.8 * SPIKE_RANGE * (high - low)
    if largest <= least:
        return flagged
    jump = _excursions(v)
    flagged = np.asarray(jump > least, dtype=bool)
    # A signal that has to do without some of its samples is judged again until what remains agrees with the rest.
    while flagged.any():
        if flagged.sum() > max(SPIKE_LENGTH, RARE * v.size):
            return np.zeros(v.size, dtype=bool)
        others = v[~flagged]
        span = float(np.ptp(others))
        if np.unique(others).size < LEVELS or span == 0.0:
            return np.zeros(v.size, dtype=bool)
        bend = float(np.quantile(np.abs(np.diff(others, 2)), 0.999))
        step = float(np.max(np.abs(np.diff(others))))
        limit = np.full(v.size, max(SPIKE_RANGE * span, SPIKE_CURVATURE * bend, SPIKE_STEP * step))
        limit[:SPIKE_LENGTH] = np.maximum(limit[:SPIKE_LENGTH], END_RANGE * span)
        limit[-SPIKE_LENGTH:] = np.maximum(limit[-SPIKE_LENGTH:], END_RANGE * span)
        kept = flagged & (jump > limit)
        if np.array_equal(kept, flagged):
            break
        flagged = kept
    return flagged


def _certain_range(v: Array) -> float:
    """A distance that the 2 % and 98 % quantiles are apart at least, found by counting; 0 if they may be closer."""
    bottom, top = float(v.min()), float(v.max())
    low, high = bottom + 0.25 * (top - bottom), top - 0.25 * (top - bottom)
    enough = 0.02 * v.size + 1
    if np.count_nonzero(v <= low) > enough and np.count_nonzero(v >= high) > enough:
        return high - low
    return 0.0


def _excursions(v: Array) -> Array:
    """How far each sample, with at most 2 others beside it, stands off from both neighbours, (T,); 0 if it does not."""
    jump = np.zeros(v.size)
    top = bottom = v
    for length in range(1, SPIKE_LENGTH + 1):
        if length > 1:
            top, bottom = np.maximum(top[:-1], v[length - 1 :]), np.minimum(bottom[:-1], v[length - 1 :])
        # At the ends the only neighbour counts for both sides.
        before = np.concatenate((v[length : length + 1], v[: v.size - length]))
        after = np.concatenate((v[length:], v[v.size - length - 1 : v.size - length]))
        above = bottom - np.maximum(before, after)
        below = np.minimum(before, after) - top
        off = np.maximum(above, below)
        off[np.abs(before - after) > 0.5 * off] = 0.0
        for k in range(length):
            part = jump[k : k + off.size]
            np.maximum(part, off, out=part)
    return jump


def drop_outliers(samples: Samples, about: Context, findings: list[Finding], hold: bool = False) -> Samples:
    """Unwrap angles; leave out rows with an outlier, or hold the value before it.

    Parameters
    ----------
    samples
        Finite samples in the order of the log, without breaks.
    about
        Log, columns and units.
    findings
        Grows by ``"angle-wrap"`` and ``"outlier"``.
    hold
        Keep the rows, with the last good value: for signals that are played back sample by sample.
    """
    samples, wrapped = _unwrap(samples, about, findings, set())
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
    findings.append(
        Finding(
            "outlier",
            f"{int(bad.sum())} of {bad.size} rows of {about.log} hold a value far from all others ({what}); {done}. A "
            f"single one would spoil the fit, because the model remembers extremes. Check the sensor and its wiring; "
            f"if the values are real, log faster so that they are more than a spike.",
        )
    )
    if hold:
        samples = replace(
            samples, values=tuple(hold_last(v, mask) for v, mask in zip(samples.values, masks, strict=True))
        )
    else:
        samples = samples.take(~bad)
    return _unwrap(samples, about, findings, wrapped)[0]


def _named(samples: Samples, v: Array, mask: Mask, name: str, about: Context) -> str:
    rows = samples.rows[mask]
    shown = ", ".join(f"{value:.6g}" for value in dict.fromkeys(v[mask][:4].tolist()))
    return f"'{name}' is {shown} in {list_rows(rows, about.word)}"


def _unwrap(samples: Samples, about: Context, findings: list[Finding], done: set[int]) -> tuple[Samples, set[int]]:
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
        findings.append(
            Finding(
                "angle-wrap",
                f"'{about.columns[k]}' of {about.log} jumps by a full turn {jumps.size} "
                f"{'times' if jumps.size > 1 else 'time'}, at {list_rows(samples.rows[jumps], about.word)}: the angle "
                f"wraps around. It was unwrapped and now runs from {values[k].min():.6g} to {values[k].max():.6g} "
                f"{unit}. Nothing to do; the model knows the unwrapped angle.",
            )
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
