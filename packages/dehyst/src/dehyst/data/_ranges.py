"""The range of a signal (100 % of every error in percent), robust to a few extreme samples."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from dehyst.arrays import Array
from dehyst.data._policy import POLICY

CACHED = 1 << 15  # samples that stay in the cache


def robust_range(parts: Sequence[Array]) -> float:
    """Range of a signal: largest less least value; what less than 1 % of the samples make does not count.

    Where the 0.5 % of the samples at either end of the range make more than a fifth of it, they count only as far as
    6 of them follow each other: the range of a signal that rests for most of the time is that of its motion, and a
    false value, or five in a row, make none.

    Parameters
    ----------
    parts
        Samples, (T,) each, not all of them empty. [unit]

    Returns
    -------
    range : float
        0 for a signal that stays where it is. [unit]

    Examples
    --------
    >>> y = np.sin(np.linspace(0.0, 60.0, 2001))
    >>> clean, y[1000] = robust_range([y]), 1000.0
    >>> round(clean, 3), round(robust_range([y]), 3)
    (2.0, 2.0)
    """
    filled = [part for part in parts if part.size]
    low, high = range_over(filled)
    # How many samples lie in the fifth of the range that is at its ends: those of a motion are many.
    near = 0.5 * POLICY.extremes_range * (high - low)
    count = at_top = at_bottom = 0
    for part in filled:
        count += part.size
        at_top += int(np.count_nonzero(part >= high - near))
        at_bottom += int(np.count_nonzero(part <= low + near))
    few = max(1, int(POLICY.few_extremes * count))
    if count < POLICY.extremes_from or (at_top > few and at_bottom > few):
        return high - low
    values = np.concatenate(filled)
    least, most = np.partition(values, [few, count - 1 - few])[[few, count - 1 - few]].tolist()
    if most - least >= (1.0 - POLICY.extremes_range) * (high - low):
        return high - low
    # Few samples count all the same, where enough of them follow each other.
    bottom, top = least, most
    for part in filled:
        if part.size >= POLICY.in_a_row:
            lowest, highest = _reached(part)
            bottom, top = min(bottom, lowest), max(top, highest)
    inner = float(top - bottom)
    if inner > 1e-9 * (high - low):
        return inner
    return high - low  # a signal that is nothing but its spikes


def _reached(values: Array) -> tuple[float, float]:
    """Least and largest value that 6 samples in a row reach."""
    windows = np.lib.stride_tricks.sliding_window_view(values, POLICY.in_a_row)
    return float(windows.max(axis=1).min()), float(windows.min(axis=1).max())


def range_over(parts: Sequence[Array]) -> tuple[float, float]:
    """Least and largest value of several arrays, some of which may be empty."""
    low, high = np.inf, -np.inf
    for part in parts:
        if part.size:
            least, most = range_of(part)
            low, high = min(low, least), max(high, most)
    return low, high


def range_of(values: Array) -> tuple[float, float]:
    """Least and largest of values that are not empty; each is fetched from memory once."""
    low, high = np.inf, -np.inf
    for begin in range(0, values.size, CACHED):
        inside = values[begin : begin + CACHED]
        low, high = min(low, float(inside.min())), max(high, float(inside.max()))
    return low, high
