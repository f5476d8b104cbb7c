"""Turning points of a signal that comes in blocks, the same as `dehyst.data.loops.turning_points` finds in the whole.

Only the last turning point and the extremes since then decide what follows, so that little is carried over. A block is
reduced to its own turning points and the extremes before the first and after the last of them.
"""

from __future__ import annotations

import numpy as np

from dehyst.arrays import Array, Rows
from dehyst.data.loops import turning_points

# Columns of what is kept of a sample: its number, its value, and from there on what the caller attached to it.
PLACE, VALUE, TAGS = range(3)


class Zigzag:
    """Turning points by swings larger than `swing`.

    Parameters
    ----------
    swing
        Smallest swing that counts, > 0.
    tags
        Number of values that are attached to each sample.

    Attributes
    ----------
    inner
        Number of turning points found so far, the first and the last sample not among them.

    Examples
    --------
    >>> zigzag = Zigzag(0.5)
    >>> [zigzag.add(0, np.array([0.0, 1.0, 0.0])).tolist(), zigzag.add(3, np.array([0.2, 1.0])).tolist()]
    [[[1.0, 1.0]], [[2.0, 0.0]]]
    """

    inner: int = 0

    def __init__(self, swing: float, tags: int = 0) -> None:
        self._swing = swing
        self._carry = np.zeros((0, TAGS + tags))

    def add(self, begin: int, x: Array, tags: Array | None = None) -> Array:
        """Add the samples from number `begin` on, with their tags, (tags, K).

        Returns the inner turning points that are certain now, (m, 2 + tags).
        """
        kept = self._candidates(x)
        rows = np.empty((kept.size, self._carry.shape[1]))
        rows[:, PLACE], rows[:, VALUE] = begin + kept, x[kept]
        if tags is not None:
            rows[:, TAGS:] = tags[:, kept].T
        rows = np.concatenate([self._carry, rows])
        points = turning_points(rows[:, VALUE], self._swing)[1:-1]
        self.inner += points.size
        open_end = rows[points[-1] if points.size else 0 :]
        values = open_end[:, VALUE]
        self._carry = open_end[np.unique([0, values.argmin(), values.argmax(), values.size - 1])]
        return rows[points]

    def _candidates(self, x: Array) -> Rows:
        points = turning_points(x, self._swing)
        if points.size < 2:
            return points
        found = [points]
        for begin, end in {(0, int(points[1])), (int(points[-2]), x.size - 1)}:
            part = x[begin : end + 1]
            found.append(np.array([begin + part.argmin(), begin + part.argmax()]))
        return np.unique(np.concatenate(found))
