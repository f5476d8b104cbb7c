"""Samples that stand apart from those before and after them: told from a gap, and from a clock that starts anew."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from statistics import median

import numpy as np

from dehyst.arrays import Array, Mask

# So many steps without a gap are no strays: a clock has started anew, or the signal has moved far.
ISLAND = 8
GAP = 20.0  # median steps without a sample: what happened in between is not known
# That are followed at once, so that strays between them do not hide the right one; a longer one passes.
MOST_CHAINS = 32


@dataclass(eq=False)
class _Chain:
    """Samples that follow each other and wait until it is clear that they go on."""

    rows: list[Array]
    near: bool
    steady: int = 0  # steps without a gap

    @property
    def last(self) -> float:
        return float(self.rows[-1][0])

    def step_to(self, time: float) -> float:
        """Time from the last sample on; endless for one before it."""
        step = time - self.last
        return step if step >= 0.0 else math.inf

    def longest(self, limit: float) -> float:
        """Return the longest step that is no gap: by its own steps where nothing else tells."""
        steps = [float(b[0] - a[0]) for a, b in pairwise(self.rows)]
        return limit if math.isfinite(limit) or not any(steps) else GAP * median(steps)


class Strays:
    """Lets samples pass that follow those that passed before; others wait, and are left out if those go on.

    A sample follows if it comes within `limit` and lies as near to the model's range as those before. If what waits
    becomes longer than a few samples it passes, all of it.

    Examples
    --------
    >>> strays = Strays()
    >>> rows = np.column_stack([[*range(12), 1e9, 12, 13], np.zeros(15), np.zeros(15)]).astype(float)
    >>> strays.following(rows, np.ones(15, dtype=bool), 20.0)[:, 0].astype(int).tolist(), strays.count
    ([0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13], 1)
    """

    def __init__(self, last: float = math.nan) -> None:
        self.count = 0  # of those that were left out
        self._last, self._near = last, True  # of what passed; NaN: nothing has
        self._chains: list[_Chain] = []
        self._limit = math.inf  # by the chain that passed last, where nothing else tells

    def following(self, rows: Array, near: Mask, limit: float) -> Array:
        """Return the samples that pass; `near` says which lie near the range, `limit` what is no gap. [s]"""
        if not len(rows):
            return rows
        with np.errstate(over="ignore", invalid="ignore"):  # times may be anything
            steps = np.diff(rows[:, 0], prepend=self._last)
        if (
            not self._chains
            and self._near
            and near.all()
            and np.all((steps >= 0.0) & (steps <= limit))
        ):
            self._last = float(rows[-1, 0])
            return rows
        passed: list[Array] = []
        for row, is_near in zip(rows, near.tolist(), strict=True):
            passed += self._take(row, is_near, limit if math.isfinite(limit) else self._limit)
        return np.array(passed, dtype=np.float64).reshape(-1, rows.shape[1])

    def _take(self, row: Array, is_near: bool, limit: float) -> list[Array]:
        """Return what passes now that this sample is here."""
        if is_near == self._near and 0.0 <= float(row[0]) - self._last <= limit:
            self.count += self._waiting()
            self._chains, self._last = [], float(row[0])
            return [row]
        chain = self._extended(row, is_near, limit)
        if chain.steady < ISLAND and len(chain.rows) < MOST_CHAINS:  # many gaps are no gaps
            return []
        self.count += self._waiting() - len(chain.rows)
        self._limit = chain.longest(math.inf)
        self._chains, self._last, self._near = [], chain.last, chain.near
        return chain.rows

    def _waiting(self) -> int:
        """Return how many samples wait."""
        # Branches share the samples before their gap: each counts once.
        samples: set[int] = set()
        for chain in self._chains:
            samples.update(map(id, chain.rows))
        return len(samples)

    def _extended(self, row: Array, is_near: bool, limit: float) -> _Chain:
        """Return the chain that ends in a sample now: one that it follows, a branch behind a gap, or a new one."""
        time = float(row[0])
        alike = [
            chain
            for chain in self._chains
            if chain.near == is_near and chain.step_to(time) < math.inf
        ]
        before = min(alike, key=lambda chain: chain.step_to(time), default=None)
        if before is None:
            before = _Chain([row], is_near)
        elif before.step_to(time) <= before.longest(limit):
            before.rows.append(row)
            before.steady += 1
            self._chains.remove(before)  # to become the last one
        else:  # a sample behind it may still be one without a gap
            before = _Chain([*before.rows, row], is_near, before.steady)
        self._chains = [*self._chains, before][-MOST_CHAINS:]
        return before
