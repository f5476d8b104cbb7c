"""The range of a signal (100 % of every error in percent), robust to a few extreme samples."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from dehyst.arrays import Array

FEW = 0.005  # of the samples, at either end ...
MAKE = 0.2  # ... that make more than this share of the whole range do not count ...
IN_A_ROW = 6  # ... unless so many of them follow each other
FEWEST = 32  # samples below which all count


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
    there = [part for part in parts if part.size]
    low, high = min(float(part.min()) for part in there), max(float(part.max()) for part in there)
    count = sum(part.size for part in there)
    few = max(1, int(FEW * count))
    near = 0.5 * MAKE * (high - low)
    if count < FEWEST or all(
        sum(int(np.count_nonzero(inside)) for inside in ends) > few
        for ends in ([part >= high - near for part in there], [part <= low + near for part in there])
    ):
        return high - low
    values = np.concatenate(there)
    least, most = np.partition(values, [few, count - 1 - few])[[few, count - 1 - few]].tolist()
    if most - least >= (1.0 - MAKE) * (high - low):
        return high - low
    held = [_held(part) for part in there if part.size >= IN_A_ROW]
    inner = float(max([most, *(top for _, top in held)]) - min([least, *(bottom for bottom, _ in held)]))
    return inner if inner > 1e-9 * (high - low) else high - low  # a signal that is nothing but its spikes


def _held(values: Array) -> tuple[float, float]:
    """Least and largest value that 6 samples in a row reach."""
    windows = np.lib.stride_tricks.sliding_window_view(values, IN_A_ROW)
    return float(windows.max(axis=1).min()), float(windows.min(axis=1).max())
