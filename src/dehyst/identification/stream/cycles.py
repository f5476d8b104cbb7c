"""Drift of residuals from cycle to cycle of the input, in one pass."""

from __future__ import annotations

import numpy as np

from dehyst.arrays import Array
from dehyst.identification.stream.zigzag import PLACE, TAGS, Zigzag


class Cycles:
    """Mean residuals of the cycles of an input, and the line through them; as `facts.drift` for a whole recording.

    Parameters
    ----------
    swing
        Swings of the input that count. [input]
    residuals
        How many residuals there are.
    """

    def __init__(self, swing: float, residuals: int) -> None:
        self._zigzag = Zigzag(swing, residuals)
        self._totals = np.zeros((residuals, 1))
        self._begin = np.zeros((0, TAGS + residuals))  # of the present cycle
        self._skip = 0  # turning points before that of the next cycle: every other one begins a cycle
        self._count = 0
        self._sums = np.zeros((3, residuals))  # m, k m, m^2 over cycles k with mean m

    def add(self, begin: int, x: Array, residuals: Array) -> None:
        """Add samples from number `begin` on, with residuals (residuals, K)."""
        running = self._totals + np.cumsum(residuals, axis=1)
        self._totals = running[:, -1:]
        points = self._zigzag.add(begin, x, running - residuals)
        begins = np.concatenate([self._begin, points[self._skip :: 2]])
        self._skip = (self._skip + points.shape[0]) % 2
        self._begin = begins[-1:]
        means = np.diff(begins[:, TAGS:], axis=0) / np.diff(begins[:, PLACE])[:, None]
        k = self._count + np.arange(means.shape[0])
        self._sums += np.array([means.sum(axis=0), k @ means, (means**2).sum(axis=0)])
        self._count += means.shape[0]

    def drift(self, which: int) -> tuple[float, float]:
        """Change of a residual from the first to the last cycle, and its standard error; (0, 0) below four cycles."""
        count, (m, km, mm) = self._count, self._sums[:, which].tolist()
        if count < 4:
            return 0.0, 0.0
        spread = count * (count**2 - 1) / 12.0
        slope = (km - 0.5 * (count - 1) * m) / spread
        rest = max(mm - m * m / count - slope**2 * spread, 0.0)
        return slope * (count - 1), float(np.sqrt(rest / (count - 2) / spread)) * (count - 1)
