"""Detects outliers: spikes, short false runs, and error codes of a failed sensor.

One of them is enough to spoil a fit, because a play operator remembers the extreme for ever.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array, Mask
from dehyst.data._policy import POLICY

Run = tuple[int, int, float]  # samples [begin, end) and the smaller of the jumps at its ends

CHUNK = 1 << 15  # steps that are looked at together
_CODES = [
    999.0,
    9999.0,
    99999.0,
    999999.0,
    9999999.0,
    1e6,
    1e7,
    1e9,
    1e10,
    1e20,
    1e30,
    1e37,
    1e38,
    8191.0,
    32767.0,
]
_CODES += [
    32768.0,
    65535.0,
    8388607.0,
    8388608.0,
    2147483647.0,
    2147483648.0,
    4294967295.0,
    999.9,
    9999.9,
]
CODES = np.array(sorted({*_CODES, *(-code for code in _CODES)}))
LEAST_CODE = min(_CODES)
SAME_VALUES = 8  # that are looked at


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
    outliers = np.zeros(values.size, dtype=bool)
    if values.size < POLICY.judged_from or _is_smooth(values):
        return outliers
    for _ in range(4):  # what one pass takes away may have hidden smaller ones
        index = np.flatnonzero(~outliers)
        if index.size < POLICY.judged_from:
            break
        for search in (_codes, _same_again, _runs, _spikes):
            fresh = search(values[index])
            if fresh.any():
                outliers[index[fresh]] = True
                break
        else:
            break
    return outliers


def _is_smooth(v: Array) -> bool:
    """Whether steps are so small that nothing can be an outlier; a cacheful at a time, as most logs end here."""
    largest, low, high = 0.0, float(v.min()), float(v.max())
    if max(-low, high) >= LEAST_CODE:
        return False
    least = 0.99 * POLICY.run_jump * _certain_range(v)
    for begin in range(0, v.size - 1, CHUNK):
        part = np.diff(v[begin : begin + CHUNK + 1])
        largest = max(largest, float(part.max()), -float(part.min()))
        if largest > least:
            return False
    return True


def _codes(v: Array) -> Mask:
    nothing = np.zeros(v.size, dtype=bool)
    if max(-float(v.min()), float(v.max())) < LEAST_CODE:
        return nothing
    codes = np.isin(v, CODES)
    if not codes.any() or codes.mean() > POLICY.code_share:
        return nothing
    rest_of_values = v[~codes]
    low, high = float(rest_of_values.min()), float(rest_of_values.max())
    if (
        rest_of_values.size < POLICY.judged_from or np.unique(rest_of_values).size < POLICY.levels
    ):  # a staircase of a few levels has no range to leave
        return nothing
    away = POLICY.code_distance * (high - low)
    return np.asarray(codes & ((v > high + away) | (v < low - away)))


def _spikes(v: Array) -> Mask:
    flagged: Mask = np.zeros(v.size, dtype=bool)
    steps = np.diff(v)
    largest = max(
        float(steps.max()), -float(steps.min())
    )  # no excursion is larger than the step into it
    if largest <= 0.99 * 0.8 * POLICY.spike_range * _certain_range(v):
        return flagged
    low, high = np.percentile(v, [2, 98])
    least = 0.8 * POLICY.spike_range * (high - low)
    if largest <= least:
        return flagged
    jump = _excursions(v)
    flagged = np.asarray(jump > least, dtype=bool)
    # A signal that has to do without some of its samples is judged again until what remains agrees with the rest.
    while flagged.any():
        if flagged.sum() > max(POLICY.spike_length, POLICY.rare * v.size):
            return np.zeros(v.size, dtype=bool)
        unflagged = v[~flagged]
        span = float(np.ptp(unflagged))
        if np.unique(unflagged).size < POLICY.levels or span == 0.0:
            return np.zeros(v.size, dtype=bool)
        bend = float(np.quantile(np.abs(np.diff(unflagged, 2)), 0.999))
        step = float(np.max(np.abs(np.diff(unflagged))))
        limit = np.full(
            v.size,
            max(POLICY.spike_range * span, POLICY.spike_curvature * bend, POLICY.spike_step * step),
        )
        limit[: POLICY.spike_length] = np.maximum(
            limit[: POLICY.spike_length], POLICY.end_range * span
        )
        limit[-POLICY.spike_length :] = np.maximum(
            limit[-POLICY.spike_length :], POLICY.end_range * span
        )
        spikes = flagged & (jump > limit)
        if np.array_equal(spikes, flagged):
            break
        flagged = spikes
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
    for length in range(1, POLICY.spike_length + 1):
        if length > 1:
            top, bottom = (
                np.maximum(top[:-1], v[length - 1 :]),
                np.minimum(bottom[:-1], v[length - 1 :]),
            )
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
    steps = np.diff(v)
    if max(float(steps.max()), -float(steps.min())) <= 0.99 * POLICY.run_jump * _certain_range(v):
        return flagged
    low, high = np.percentile(v, [2, 98])
    most = max(POLICY.run_most, int(POLICY.rare * v.size))
    jumps = np.flatnonzero(np.abs(steps) > POLICY.run_jump * (high - low))
    if not 0 < jumps.size <= min(POLICY.jumps_most, 4 * most):
        return flagged
    runs = _between(v, jumps, most, low, high)
    while runs:
        flagged[:] = False
        for begin, end, _ in runs:
            flagged[begin:end] = True
        unflagged = v[~flagged]
        if (
            flagged.sum() > most
            or unflagged.size < POLICY.judged_from
            or np.unique(unflagged).size < POLICY.levels
        ):
            runs = []
            break
        span = float(np.ptp(unflagged))
        step = float(np.max(np.abs(steps[~(flagged[1:] | flagged[:-1])])))
        if step * POLICY.run_smooth > span:
            runs = []
            break
        least = max(POLICY.run_jump * span, POLICY.run_step * step)
        long_runs = [run for run in runs if run[2] > least]
        if len(long_runs) == len(runs):
            break
        runs = long_runs
    long = [run for run in runs if run[1] - run[0] > POLICY.spike_length]
    if not runs or len(long) > POLICY.runs_most:
        flagged[:] = False
    return flagged


def _same_again(v: Array) -> Mask:
    """Short runs of one exact value that a smooth signal jumps to again and again."""
    flagged: Mask = np.zeros(v.size, dtype=bool)
    steps = np.abs(np.diff(v))
    if float(steps.max()) <= 0.99 * POLICY.run_jump * _certain_range(v):
        return flagged
    low, high = np.percentile(v, [2, 98])
    jumps = np.flatnonzero(steps > POLICY.run_jump * (high - low))
    if not POLICY.same_runs <= jumps.size <= 2.0 * POLICY.same_share * v.size:
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
    at_value = v == value
    edges = np.flatnonzero(np.diff(at_value.astype(np.int64), prepend=0, append=0))
    begins, ends = edges[::2], edges[1::2]
    inner = (begins > 0) & (ends < v.size) & (ends - begins <= POLICY.same_length)
    begins, ends = begins[inner], ends[inner]
    elsewhere = v[~at_value]
    if begins.size < POLICY.same_runs or elsewhere.size < POLICY.judged_from:
        return flagged
    before, after = v[begins - 1], v[np.minimum(ends, v.size - 1)]
    jump = np.minimum(np.abs(before - value), np.abs(after - value))
    back = np.abs(after - before) <= POLICY.run_return * jump
    span = float(np.ptp(elsewhere))
    step = float(np.max(steps[~(at_value[1:] | at_value[:-1])], initial=0.0))
    clear = back & (jump > max(POLICY.run_jump * span, POLICY.run_step * step))
    if (
        step * POLICY.run_smooth > span
        or np.count_nonzero(clear) < POLICY.same_runs
        or np.unique(elsewhere).size < POLICY.levels
    ):
        return flagged
    moving = v[np.maximum(begins - 1 - POLICY.same_length, 0)] != before
    if (
        float(np.ptp(before[clear])) < POLICY.same_spread * span
        or np.mean(moving[clear]) < POLICY.same_moving
    ):
        return flagged
    for begin, end in zip(
        begins[jump > POLICY.same_near * step], ends[jump > POLICY.same_near * step], strict=True
    ):
        flagged[begin:end] = True
    if not np.mean(flagged) <= POLICY.same_share:
        flagged[:] = False
    return flagged


def _between(
    v: Array, jumps: npt.NDArray[np.int64], most: int, low: float, high: float
) -> list[Run]:
    """Runs from one jump to the first that leads back, and those at an end of the log that lie beyond the range."""
    size, slack = np.abs(np.diff(v)[jumps]), POLICY.run_beyond * (high - low)
    runs: list[Run] = []

    def beyond(part: Array) -> bool:
        return bool(part.min() > high + slack or part.max() < low - slack)

    k = last = 0
    for m in np.flatnonzero(jumps < POLICY.run_most).tolist():
        if beyond(v[: jumps[m] + 1]):
            runs, k = [(0, int(jumps[m]) + 1, float(size[m]))], m + 1
    end = jumps.size
    for m in np.flatnonzero(jumps >= v.size - 1 - POLICY.run_most)[::-1].tolist():
        if m >= k and beyond(v[jumps[m] + 1 :]):
            end = m
    while k < end:
        first = jumps[k]
        last = int(np.searchsorted(jumps, first + most, side="right"))
        neighbours = np.arange(k + 1, min(last, end))
        smaller = np.minimum(size[k], size[neighbours])
        back = neighbours[
            np.abs(v[jumps[neighbours] + 1] - v[first]) <= POLICY.run_return * smaller
        ]
        if back.size:
            runs.append(
                (int(first) + 1, int(jumps[back[0]]) + 1, float(min(size[k], size[back[0]])))
            )
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
