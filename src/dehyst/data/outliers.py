"""Detects outliers: spikes, short false runs, and error codes of a failed sensor.

One of them is enough to spoil a fit, because a play operator remembers the extreme for ever.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array, Mask

Run = tuple[int, int, float]  # samples [begin, end) and the smaller of the jumps at its ends

SPIKE_LENGTH = 3  # samples: a longer excursion may be real
SPIKE_RANGE = 0.5  # of the range of the others: the least jump of a spike ...
SPIKE_CURVATURE = 10.0  # ... in units of the 99.9 % quantile of the second differences of the others ...
SPIKE_STEP = 2.0  # ... and of their largest step
END_RANGE = 10.0  # of the range: at the ends of a log there is only one neighbour to judge by
RARE = 0.01  # of the samples: more spikes than this are a signal, not a fault
CHUNK = 1 << 15  # steps that are looked at together
FEWEST = 32  # samples below which nothing is judged ...
LEVELS = 8  # ... and different values among the others
CODE_DISTANCE = 3.0  # ranges of the others between them and a code
CODE_SHARE = 0.5
_CODES = [999.0, 9999.0, 99999.0, 999999.0, 9999999.0, 1e6, 1e7, 1e9, 1e10, 1e20, 1e30, 1e37, 1e38, 8191.0, 32767.0]
_CODES += [32768.0, 65535.0, 8388607.0, 8388608.0, 2147483647.0, 2147483648.0, 4294967295.0, 999.9, 9999.9]
CODES = np.array(sorted({*_CODES, *(-code for code in _CODES)}))
LEAST_CODE = min(_CODES)
# Longer runs are told only in a signal that moves in small steps: false values jump in and out, and it goes on.
RUN_JUMP = 0.1  # of the range of the others: the least jump of a run ...
RUN_STEP = 4.0  # ... in units of their largest step ...
RUN_SMOOTH = 5.0  # ... which fits into their range so many times
RUN_RETURN = 0.5  # of the smaller jump: how far from where it left a signal may come back
RUN_MOST = 5  # samples of a run that a short log may have, or at its ends any log; elsewhere RARE of them ...
RUNS_MOST = 5  # ... and so many runs that are longer than a spike: more are pulses, a signal
RUN_BEYOND = 0.3  # of the range of the others: how far beyond it a run at an end of the log lies
# One value that comes again and again, such as 0 of a lost packet, is told by its runs, however many: each jumps there
# from wherever a smooth signal is, and back. A signal passes its values, or rests at them; pulses start from a rest.
SAME_RUNS = 3  # of them, at least ...
SAME_LENGTH = 8  # ... of so many samples each, at most: a longer one may be a rest ...
SAME_SHARE = 0.03  # ... and together this share of the samples
SAME_SPREAD = 0.15  # of the range of the others: over so much of it they begin
SAME_MOVING = 0.2  # of them begin while the signal moves
SAME_NEAR = 1.5  # of the largest other step: a run that jumps further is false too, once the value is known to be
SAME_VALUES = 8  # that are looked at
JUMPS_MOST = 1000  # more are a signal in any case


def find_outliers(values: Array) -> Mask:
    """Which samples are isolated spikes or codes of a failed sensor.

    A spike is an excursion of at most 3 samples that leaves both neighbours, in one direction, by more than half the
    range of the other samples, 10 times their curvature and twice their largest step. A run is longer, up to 1 % of
    the samples: it begins and ends with a jump of more than a tenth of that range and 4 of those steps, in a signal
    that moves smoothly otherwise and goes on near where it was left; 5 such runs at most, but any number up to 3 % of
    the samples where all of them are one value and begin at different ones. A code is a number such as
    -9999, 32767 or 1e6, repeated exactly, more than 3 ranges away from everything else.

    Parameters
    ----------
    values
        Signal in the order of the log, (T,), finite.

    Examples
    --------
    >>> x = np.sin(np.arange(200) / 10)
    >>> x[50] = 100.0
    >>> np.flatnonzero(find_outliers(x)).tolist()
    [50]
    """
    found = np.zeros(values.size, dtype=bool)
    if values.size < FEWEST or _is_smooth(values):
        return found
    for _ in range(4):  # what one pass takes away may have hidden smaller ones
        index = np.flatnonzero(~found)
        fresh = _codes(values[index])
        if not fresh.any():
            fresh = _same_again(values[index])
        if not fresh.any():
            fresh = _runs(values[index])
        if not fresh.any():
            fresh = _spikes(values[index])
        if not fresh.any():
            break
        found[index[fresh]] = True
    return found


def _is_smooth(v: Array) -> bool:
    """Whether steps are so small that nothing can be an outlier; a cacheful at a time, as most logs end here."""
    largest, low, high = 0.0, float(v.min()), float(v.max())
    if max(-low, high) >= LEAST_CODE:
        return False
    least = 0.99 * RUN_JUMP * _certain_range(v)
    for begin in range(0, v.size - 1, CHUNK):
        part = np.diff(v[begin : begin + CHUNK + 1])
        largest = max(largest, float(part.max()), -float(part.min()))
        if largest > least:
            return False
    return True


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


def _runs(v: Array) -> Mask:
    """Samples between a jump and another one that takes it back, in a signal that moves smoothly otherwise."""
    flagged: Mask = np.zeros(v.size, dtype=bool)
    if v.size < FEWEST:
        return flagged
    steps = np.diff(v)
    if max(float(steps.max()), -float(steps.min())) <= 0.99 * RUN_JUMP * _certain_range(v):
        return flagged
    low, high = np.percentile(v, [2, 98])
    most = max(RUN_MOST, int(RARE * v.size))
    jumps = np.flatnonzero(np.abs(steps) > RUN_JUMP * (high - low))
    if not 0 < jumps.size <= min(JUMPS_MOST, 4 * most):
        return flagged
    runs = _between(v, jumps, most, low, high)
    while runs:
        flagged[:] = False
        for begin, end, _ in runs:
            flagged[begin:end] = True
        others = v[~flagged]
        if flagged.sum() > most or others.size < FEWEST or np.unique(others).size < LEVELS:
            runs = []
            break
        span = float(np.ptp(others))
        step = float(np.max(np.abs(steps[~(flagged[1:] | flagged[:-1])])))
        if step * RUN_SMOOTH > span:
            runs = []
            break
        least = max(RUN_JUMP * span, RUN_STEP * step)
        kept = [run for run in runs if run[2] > least]
        if len(kept) == len(runs):
            break
        runs = kept
    long = [run for run in runs if run[1] - run[0] > SPIKE_LENGTH]
    return flagged if runs and len(long) <= RUNS_MOST else np.zeros(v.size, dtype=bool)


def _same_again(v: Array) -> Mask:
    """Short runs of one exact value that a smooth signal jumps to again and again."""
    flagged: Mask = np.zeros(v.size, dtype=bool)
    if v.size < FEWEST:
        return flagged
    steps = np.abs(np.diff(v))
    if float(steps.max()) <= 0.99 * RUN_JUMP * _certain_range(v):
        return flagged
    low, high = np.percentile(v, [2, 98])
    jumps = np.flatnonzero(steps > RUN_JUMP * (high - low))
    if not SAME_RUNS <= jumps.size <= 2.0 * SAME_SHARE * v.size:
        return flagged
    values, counts = np.unique(v[jumps + 1], return_counts=True)
    for value in values[np.argsort(-counts)][:SAME_VALUES].tolist():
        flagged = _runs_at(v, value, steps)
        if flagged.any():
            return flagged
    return flagged


def _runs_at(v: Array, value: float, steps: Array) -> Mask:
    """Short runs of a value that are false; none where it may be one of the signal."""
    flagged: Mask = np.zeros(v.size, dtype=bool)
    there = v == value
    edges = np.flatnonzero(np.diff(there.astype(np.int64), prepend=0, append=0))
    begins, ends = edges[::2], edges[1::2]
    inner = (begins > 0) & (ends < v.size) & (ends - begins <= SAME_LENGTH)
    begins, ends = begins[inner], ends[inner]
    others = v[~there]
    if begins.size < SAME_RUNS or others.size < FEWEST:
        return flagged
    before, after = v[begins - 1], v[np.minimum(ends, v.size - 1)]
    jump = np.minimum(np.abs(before - value), np.abs(after - value))
    back = np.abs(after - before) <= RUN_RETURN * jump
    span = float(np.ptp(others))
    step = float(np.max(steps[~(there[1:] | there[:-1])], initial=0.0))
    clear = back & (jump > max(RUN_JUMP * span, RUN_STEP * step))
    if step * RUN_SMOOTH > span or np.count_nonzero(clear) < SAME_RUNS or np.unique(others).size < LEVELS:
        return flagged
    moving = v[np.maximum(begins - 1 - SAME_LENGTH, 0)] != before
    if float(np.ptp(before[clear])) < SAME_SPREAD * span or np.mean(moving[clear]) < SAME_MOVING:
        return flagged
    for begin, end in zip(begins[jump > SAME_NEAR * step], ends[jump > SAME_NEAR * step], strict=True):
        flagged[begin:end] = True
    return flagged if np.mean(flagged) <= SAME_SHARE else np.zeros(v.size, dtype=bool)


def _between(v: Array, jumps: npt.NDArray[np.int64], most: int, low: float, high: float) -> list[Run]:
    """Runs from one jump to the first that leads back, and those at an end of the log that lie beyond the range."""
    size, slack = np.abs(np.diff(v)[jumps]), RUN_BEYOND * (high - low)
    runs: list[Run] = []

    def beyond(part: Array) -> bool:
        return bool(part.min() > high + slack or part.max() < low - slack)

    k = last = 0
    for m in np.flatnonzero(jumps < RUN_MOST).tolist():
        if beyond(v[: jumps[m] + 1]):
            runs, k = [(0, int(jumps[m]) + 1, float(size[m]))], m + 1
    end = jumps.size
    for m in np.flatnonzero(jumps >= v.size - 1 - RUN_MOST)[::-1].tolist():
        if m >= k and beyond(v[jumps[m] + 1 :]):
            end = m
    while k < end:
        first = jumps[k]
        last = int(np.searchsorted(jumps, first + most, side="right"))
        others = np.arange(k + 1, min(last, end))
        smaller = np.minimum(size[k], size[others])
        back = others[np.abs(v[jumps[others] + 1] - v[first]) <= RUN_RETURN * smaller]
        if back.size:
            runs.append((int(first) + 1, int(jumps[back[0]]) + 1, float(min(size[k], size[back[0]]))))
            k = int(back[0])
        k += 1
    if end < jumps.size:
        runs.append((int(jumps[end]) + 1, v.size, float(size[end])))
    return runs


def bridged(values: Array, bad: Mask) -> Array:
    """Put a straight line through the good samples in the place of bad ones; the nearest good one at the ends.

    Examples
    --------
    >>> bridged(np.array([9.0, 1.0, 9.0, 2.0]), np.array([True, False, True, False])).tolist()
    [1.0, 1.0, 1.5, 2.0]
    """
    good = np.flatnonzero(~bad)
    filled: Array = values.copy()
    filled[bad] = np.interp(np.flatnonzero(bad), good, values[good])
    return filled
