"""Cycles of a driving signal, and groups of cycles that say about equally much."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array
from dehyst.data.loops import turning_points
from dehyst.identification.memory import known_from

# A swing begins or ends a cycle when it exceeds this share of the range; smaller ones are tried while the cycles are
# fewer than enough: small loops inside a large one belong to it.
SWINGS = (0.3, 0.15, 0.05)
ENOUGH_CYCLES = 8
# The memory counts as known once the signal came this close to both ends of its range: cycles are never quite alike.
NEAR_END = 0.1


@dataclass(frozen=True, slots=True)
class Cycle:
    """From one lower turning point of the driving signal to the next.

    Attributes
    ----------
    begin, end
        Samples, `end` excluded.
    path
        Sum of its squared swings, as a share of the squared range: how much it says.
    """

    begin: int
    end: int
    path: float


def cycles_of(x: Array, pieces: Sequence[slice], low: float, high: float) -> tuple[Cycle, ...]:
    """Return the complete cycles of a signal whose memory is known, in order.

    Parameters
    ----------
    x
        Driving signal, (T,).
    pieces
        Spans without a gap; the memory is unknown at the begin of each.
    low, high
        Range of the signal.

    Examples
    --------
    >>> x = np.tile([0.0, 1.0, 2.0, 1.0], 12)
    >>> found = cycles_of(x, [slice(0, x.size)], 0.0, 2.0)
    >>> len(found), found[0].begin, found[0].end
    (10, 4, 8)
    """
    best: tuple[Cycle, ...] = ()
    for share in SWINGS:
        found = tuple(cycle for piece in pieces for cycle in _of_piece(x, piece, low, high, share))
        best = found if len(found) > len(best) else best
        if len(best) >= ENOUGH_CYCLES:
            break
    return best


def _of_piece(x: Array, piece: slice, low: float, high: float, share: float) -> list[Cycle]:
    span, part = high - low, np.ascontiguousarray(x[piece])
    if not span > 0.0 or part.size < 3:
        return []
    known = known_from(part, low + NEAR_END * span, high - NEAR_END * span)
    turns = turning_points(part, share * span)
    values = part[turns]
    lower = [k for k in range(1, turns.size - 1) if values[k] < values[k - 1] and turns[k] >= known]
    found = []
    for first, last in itertools.pairwise(lower):
        path = float(np.sum(np.diff(values[first : last + 1]) ** 2)) / span**2
        found.append(Cycle(piece.start + int(turns[first]), piece.start + int(turns[last]), path))
    return found


def groups_of(cycles: Sequence[Cycle], most: int) -> list[tuple[Cycle, ...]]:
    """Cut cycles into at most so many consecutive groups of about equal squared path.

    Examples
    --------
    >>> [len(group) for group in groups_of([Cycle(k, k + 1, 1.0) for k in range(10)], 4)]
    [2, 3, 2, 3]
    """
    if len(cycles) <= most:
        return [(cycle,) for cycle in cycles]
    path = np.array([cycle.path for cycle in cycles])
    before = np.cumsum(path) - 0.5 * path
    number = np.minimum((most * before / np.sum(path)).astype(np.int64), most - 1)
    return [tuple(cycles[int(k)] for k in np.flatnonzero(number == n)) for n in np.unique(number)]


def samples_of(group: Sequence[Cycle]) -> npt.NDArray[np.int64]:
    """Indices of the samples of a group."""
    return np.concatenate([np.arange(cycle.begin, cycle.end) for cycle in group])
