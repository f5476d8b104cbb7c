"""Splits a signal into its closed loops: those inside others are taken out of them, as a rainflow count does."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from dehyst.arrays import Array
from dehyst.data._loops import turning_points
from dehyst.data._policy import POLICY

Stretch = tuple[
    float, float
]  # from one place of a signal to another one, in samples; places lie between samples too
Leg = list[Stretch]  # from one turn to the next, less the loops that were taken out of it


@dataclass(frozen=True, slots=True)
class LoopPath:
    """Where a loop runs: from a level of the input to a turn and back to that level.

    Attributes
    ----------
    stretches
        Parts of the signal, one after the other. [samples]
    depth
        How far the input goes. [unit of x]
    """

    stretches: tuple[Stretch, ...]
    depth: float

    @property
    def places(self) -> Array:
        """Ends of the stretches and every sample between, (n,). [samples]"""
        places = np.concatenate([_places(stretch) for stretch in self.stretches])
        # A stretch begins where the one before ends, at a turn.
        return np.asarray(places[np.append(True, np.diff(places) != 0.0)])


def loop_paths(signal: Array, swing: float) -> list[LoopPath]:
    """Return the loops of a signal, in the order of their begin.

    Of four turns a, b, c, d the loop b, c is closed if it is no longer than a, b and c, d: it ends where the input
    comes back to b, and is taken out. What is left grows and then dies away; of that, two swings of one size count.

    Parameters
    ----------
    signal
        Input x, (T,).
    swing
        Smallest swing that counts. [unit of x]

    Examples
    --------
    >>> x = np.array([0.0, 2.0, -2.0, 1.0, 0.0, 1.5, -2.5, 2.0])
    >>> [path.depth for path in loop_paths(x, 0.5)]  # loops within others
    [4.5, 3.5, 1.0]
    """
    split = _Splitter(signal)
    for place in turning_points(signal, swing).tolist():
        split.push(place)
    paths = split.paths or _around(split)
    deepest = max((path.depth for path in paths), default=0.0)
    # What runs through the whole log is no cycle, unless nothing that closes is as large.
    paths = paths + [path for path in _unpaired(split) if path.depth > deepest]
    return sorted(paths, key=lambda path: path.stretches[0])


def half_loop(signal: Array, swing: float) -> LoopPath | None:
    """Return the longest way between two turns; None if the signal stands still."""
    places = turning_points(signal, swing)
    ways = np.abs(np.diff(signal[places]))
    if not ways.size or not float(np.max(ways)) > 0.0:
        return None
    longest = int(np.argmax(ways))
    stretch = (float(places[longest]), float(places[longest + 1]))
    return LoopPath((stretch,), float(ways[longest]))


class _Splitter:
    """Turns that are not yet part of a loop, and the ways between them."""

    def __init__(self, signal: Array) -> None:
        self.signal = signal
        self.turns: list[int] = []
        self.legs: list[Leg] = []
        self.paths: list[LoopPath] = []

    def push(self, place: int) -> None:
        """Add a turn, and take out every loop that it closes."""
        if self.turns:
            self.legs.append([(float(self.turns[-1]), float(place))])
        self.turns.append(place)
        while len(self.turns) >= 4 and self._closes():
            self._take_out()

    def values(self, turns: Sequence[int]) -> list[float]:
        """The signal at some of the turns."""
        return [float(self.signal[turn]) for turn in turns]

    def _closes(self) -> bool:
        a, b, c, d = self.values(self.turns[-4:])
        longest = (1.0 - POLICY.cycle_alike) * abs(c - b)
        return longest <= abs(b - a) and longest <= abs(d - c)

    def _take_out(self) -> None:
        before, out, back = self.legs[-3:]
        b, c, d = self.values(self.turns[-3:])
        path, head, tail = loop_between(self.signal, out, back, (b, c, d))
        self.paths.append(path)
        # In place: a way from which very many small loops were taken out would else be copied with each of them.
        before += head
        before += tail
        del self.legs[-2:]
        del self.turns[-3:-1]


def loop_between(
    signal: Array, out: Leg, back: Leg, turns: tuple[float, float, float]
) -> tuple[LoopPath, Leg, Leg]:
    """Return the loop of two ways, cut where the longer one is as far as the shorter one goes, and what is cut off."""
    b, c, d = turns
    head: Leg = []
    tail: Leg = []
    if abs(d - c) >= abs(b - c):
        back, tail = _cut(signal, back, b, d > c)
        level = b
    else:
        head, out = _cut(signal, out, d, c > b)
        level = d
    return LoopPath(tuple(out + back), abs(c - level)), head, tail


def _unpaired(split: _Splitter) -> list[LoopPath]:
    """Loops of what no closed one explains: the largest first, no part of the signal twice."""
    candidates = []
    for k in range(len(split.turns) - 2):
        b, c, d = split.values(split.turns[k : k + 3])
        shorter, longer = sorted((abs(c - b), abs(d - c)))
        if shorter >= POLICY.cycle_whole * longer and shorter > 0.0:
            candidates.append((-shorter, k))
    chosen: list[int] = []
    paths = []
    for _, k in sorted(candidates):
        if all(abs(k - other) >= 2 for other in chosen):
            chosen.append(k)
            b, c, d = split.values(split.turns[k : k + 3])
            path, _, _ = loop_between(split.signal, split.legs[k], split.legs[k + 1], (b, c, d))
            paths.append(path)
    return paths


def _around(split: _Splitter) -> list[LoopPath]:
    """A single period that begins and ends between its turns, from its first turn on."""
    if len(split.turns) != 4:
        return []
    first, *inner, last = split.values(split.turns)
    depth = abs(inner[1] - inner[0])
    if abs(last - first) > POLICY.cycle_alike * depth:
        return []
    begin, middle, end = split.legs
    return [LoopPath((*middle, *end, *begin), depth)]


def _cut(signal: Array, leg: Leg, level: float, rises: bool) -> tuple[Leg, Leg]:
    """Return a way until the signal first reaches a level, and what comes behind."""
    for k, (start, stop) in enumerate(leg):
        places = _places((start, stop))
        ahead = values_at(signal, places) - level
        if not rises:
            ahead = -ahead
        reached = np.flatnonzero(ahead >= 0.0)
        if not reached.size:
            continue
        place = float(places[reached[0]])
        if reached[0] > 0:
            before, at = float(ahead[reached[0] - 1]), float(ahead[reached[0]])
            earlier = float(places[reached[0] - 1])
            place = earlier + (place - earlier) * -before / (at - before)
        return [*leg[:k], (start, place)], [(place, stop), *leg[k + 1 :]]
    return list(leg), []


def values_at(signal: Array, places: Array) -> Array:
    """Return a signal at places between its samples, by straight lines."""
    before = np.minimum(places.astype(np.int64), signal.size - 1)
    after = np.minimum(before + 1, signal.size - 1)
    return np.asarray(signal[before] + (places - before) * (signal[after] - signal[before]))


def _places(stretch: Stretch) -> Array:
    """Both ends of a stretch and the samples between."""
    start, stop = stretch
    inside = np.arange(np.floor(start) + 1.0, np.ceil(stop))
    return np.concatenate([[start], inside, [stop]])
