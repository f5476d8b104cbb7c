"""Turning points and loops of a signal, robust to noise."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

import dehyst._native as _native
from dehyst.arrays import Array

# A swing counts as a turn when it exceeds this share of the signal's range: above sensor noise, below any
# loop that an identification would use.
TURN_FRACTION = 0.05


def turning_points(signal: npt.ArrayLike, swing: float | None = None) -> npt.NDArray[np.int64]:
    """Indices where a signal turns by more than `swing`.

    Parameters
    ----------
    signal
        Values x, (T,), finite.
    swing
        Smallest swing that counts, > 0. [unit of x] By default 5 % of the range of x.

    Returns
    -------
    indices : (m,)
        First sample, every extreme between two swings larger than `swing`, last sample.

    Examples
    --------
    >>> turning_points([0.0, 1.0, 0.99, 1.0, -1.0, 0.0], swing=0.5).tolist()
    [0, 1, 4, 5]
    """
    x = np.asarray(signal, dtype=np.float64)
    if x.size == 0:
        return np.zeros(0, dtype=np.int64)
    if swing is None:
        swing = TURN_FRACTION * float(x.max() - x.min())
    return _native.turning_points(np.ascontiguousarray(x), swing)


@dataclass(frozen=True, slots=True)
class LoopSummary:
    """How often and how far a signal went back and forth.

    Attributes
    ----------
    turns
        Number of inner turning points.
    loops
        Back-and-forth cycles, two swings each, ``(turns + 1) // 2``.
    swings
        Distances between successive turning points, (turns + 1,). [unit of x]
    """

    turns: int
    loops: int
    swings: Array


def summarise_loops(signal: npt.ArrayLike, swing: float | None = None) -> LoopSummary:
    """Count the loops of a signal and measure their swings.

    Examples
    --------
    >>> import numpy as np
    >>> summarise_loops(np.sin(np.linspace(0.0, 6 * np.pi, 301))).loops
    3
    """
    x = np.asarray(signal, dtype=np.float64)
    points = turning_points(x, swing)
    swings = np.abs(np.diff(x[points]))
    turns = max(0, points.size - 2)
    return LoopSummary(turns=turns, loops=(turns + 1) // 2, swings=swings)
