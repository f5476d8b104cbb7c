"""Gaps in time: when a step is one, and when the memory of the actuator is lost across it."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array

GAP_MEDIANS = 5.0  # a step this many times the median is a gap ...
GAP_SAMPLES = 3.0  # ... if it also misses this many samples at the usual rate
MOVED = 0.05  # of the input's range: more than this across a gap, and the memory is unknown

BACK_SAMPLES = 50  # within so many samples ...
BACK_SHARE = 0.01  # ... or this share of the log a jump of the clock is taken back
LIKE = 0.02  # of a jump: how far the one that takes it back may differ


def gap_limit(step: npt.ArrayLike) -> float:
    """Smallest step between samples that counts as a gap: 5 medians and 3 usual steps. [s]

    The usual step is the mean of the shortest 95 %. Where more than one step in twenty would be a gap, samples come
    in bursts, and only what is 5 times longer than the pauses between bursts counts.

    Parameters
    ----------
    step
        Steps of time, (T - 1,); those that are not positive do not count. [s]

    Examples
    --------
    >>> gap_limit([1.0] * 30 + [9.0])
    5.0
    """
    steps = np.asarray(step, dtype=np.float64)
    steps = np.sort(steps[steps > 0])
    if steps.size == 0:
        return float("inf")
    usual = float(np.mean(steps[: max(1, int(0.95 * steps.size))]))
    limit = max(GAP_MEDIANS * float(np.median(steps)), GAP_SAMPLES * usual)
    if np.mean(steps > limit) > 0.05:
        limit = GAP_MEDIANS * float(np.percentile(steps, 95))
    return float(limit)


def memory_lost(step: Array, moved: Array, span: float, measured: float, swings: int) -> npt.NDArray[np.bool_]:
    """Whether the input may have turned unseen within each gap.

    It may if it differs by more than 5 % of its range across the gap, or if the gap is longer than half a loop.

    Parameters
    ----------
    step, moved
        Length of each gap [s] and |dx| across it, (m,). [input]
    span
        Range of the input. [input]
    measured
        Time that was measured, gaps left out. [s]
    swings
        Number of swings of the input.
    """
    lost: npt.NDArray[np.bool_] = (moved > MOVED * span) | (step > measured / max(1, swings))
    return lost


def taken_back(places: npt.NDArray[np.int64], size: Array, samples: int) -> list[tuple[int, int]]:
    """Jumps of a clock that the next one takes back soon, as pairs of their numbers; of a log of so many samples.

    Examples
    --------
    >>> taken_back(np.array([10, 14, 400, 900]), np.array([1.0, -1.0, 1.0, -1.0]), 1000)
    [(0, 1)]
    """
    near = max(BACK_SAMPLES, int(BACK_SHARE * samples))
    found, k = [], 0
    while k + 1 < places.size:
        cancels = abs(size[k] + size[k + 1]) <= LIKE * abs(size[k])
        if cancels and places[k + 1] - places[k] <= near:
            found.append((k, k + 1))
            k += 1
        k += 1
    return found
