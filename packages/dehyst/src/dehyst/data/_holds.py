"""Holds of a signal: where it stays for a while, however noisy it is."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array
from dehyst.data._policy import POLICY

SLACK = 1e-9  # what lies just at a limit is within it, however it is rounded
ARRIVED = 0.05  # of the band: so near its level a signal has arrived at it
MIDDLE_HALF = (25.0, 75.0)  # percentiles between which half of the samples lie


class Hold(NamedTuple):
    """A stretch of a signal that stays at a level: first sample, and the one behind the last."""

    begin: int
    end: int
    level: float


def holds_of(values: Array, time: Array, least: float, band: float) -> list[Hold]:
    """Return the stretches in which a signal stays within a band for some time.

    A turn without a hold stays within the band for a while too, but fills it; in a hold half of the samples lie close
    together.

    Parameters
    ----------
    values, time
        Signal and its clock, (T,).
    least
        Shortest time that is a hold. [unit of time]
    band
        Widest range of a hold, its noise included. [unit of values]

    Examples
    --------
    >>> way = np.concatenate([np.linspace(0.0, 1.0, 50), np.full(30, 1.0), np.linspace(1.0, 0.0, 50)])
    >>> [(hold.begin, hold.end, hold.level) for hold in holds_of(way, np.arange(130.0), 10.0, 0.01)]
    [(49, 81, 1.0)]
    """
    if values.size < POLICY.least_rest:
        return []
    # From each sample to the first one that is so much later.
    stop = np.searchsorted(time, time + (1.0 - SLACK) * least, side="left") + 1
    inside = stop <= values.size
    stop = np.minimum(stop, values.size)
    # In a log of changes no sample may lie in such a stretch: nothing is known of it.
    quiet = inside & (stop - np.arange(values.size) >= POLICY.least_rest)
    quiet &= _swings(values, stop) <= (1.0 + SLACK) * band
    # Links between a sample and the next one that lie in such a stretch: one level jumps to the next in a single link.
    covered = np.zeros(values.size, dtype=np.int64)
    np.add.at(covered, np.flatnonzero(quiet), 1)
    np.add.at(covered, stop[quiet] - 1, -1)
    linked = np.cumsum(covered)[:-1] > 0
    edges = np.flatnonzero(np.diff(linked.astype(np.int64), prepend=0, append=0))
    holds = []
    for begin, last_link in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True):
        stretch = values[begin : last_link + 1]
        lower, level, upper = np.percentile(
            stretch, [MIDDLE_HALF[0], 50.0, MIDDLE_HALF[1]]
        ).tolist()
        if upper - lower > POLICY.hold_flat * band:
            continue
        # The last piece of the way to the level lies within the band, and is no rest.
        reach = (1.0 + SLACK) * max(ARRIVED * band, upper - lower)
        near = np.flatnonzero(np.abs(stretch - level) <= reach)
        first, last = int(near[0]), int(near[-1]) + 1
        holds.append(Hold(begin + first, begin + last, level))
    return holds


def _swings(values: Array, stop: npt.NDArray[np.int64]) -> Array:
    """Largest less least value from every sample on, up to its own stop: by tables of powers of two."""
    start = np.arange(values.size)
    length = np.maximum(stop - start, 1)
    power = np.floor(np.log2(length)).astype(np.int64)
    swings = np.zeros(values.size)
    low = high = values
    for exponent in range(int(power.max()) + 1):
        reach = 1 << exponent
        here = np.flatnonzero(power == exponent)
        second = start[here] + length[here] - reach
        top = np.maximum(high[here], high[second])
        swings[here] = top - np.minimum(low[here], low[second])
        high = np.maximum(high[:-reach], high[reach:])
        low = np.minimum(low[:-reach], low[reach:])
    return swings
