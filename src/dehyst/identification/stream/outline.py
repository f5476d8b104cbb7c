"""Reduces a log of any length to some ten thousand rows: extremes, sums and turning points.

A bucket is a run of `size` samples. Whenever there are more than `MOST` buckets, neighbours are joined, so the memory
stays the same and the extremes stay exact. `Zigzag` finds the turning points that `dehyst.data.loops.turning_points`
finds in the whole: only the last one and the extremes since then decide what follows, so little is carried over.
"""

from __future__ import annotations

import numpy as np

from dehyst.arrays import Array, Rows
from dehyst.data.loops import turning_points

MOST = 1 << 15
# Rows that stand for a bucket: its first sample and those with the least and largest x and y.
FIRST, LEAST_X, MOST_X, LEAST_Y, MOST_Y = range(5)
# What is known of a row.
PLACE, X, Y, TIME = range(4)
# Sums over a bucket, of values less those of the very first sample.
SUMS = 6  # count, x, y, xx, yy, xy


class Outline:
    """Buckets of one log."""

    samples: int = 0  # Samples added
    size: int = 1  # Samples of a bucket; the last one may hold fewer
    origin: tuple[float, float] = (0.0, 0.0)  # x and y of the first sample, which sums are taken from

    def __init__(self, most: int = MOST) -> None:
        self._most = most
        self._rows = np.zeros((0, 5, 4))
        self._sums = np.zeros((0, SUMS))
        self._new: list[tuple[Array, Array]] = []
        self._count = 0
        self._tail: list[tuple[Array, Array]] = []  # parts of a bucket that is larger than a block
        self._filled = 0
        self._last = np.zeros(4)
        self._whole: tuple[int, tuple[Array, Array]] | None = None

    def add(self, time: Array | None, x: Array, y: Array) -> None:
        """Add samples; all calls but the last one with the same number, a power of two."""
        if self.samples == 0:
            self.origin = float(x[0]), float(y[0])
        begin, self.samples = self.samples, self.samples + x.size
        clock = np.full(1, np.nan) if time is None else time
        self._last = np.array([begin + x.size - 1, x[-1], y[-1], clock[-1]])
        step = min(self.size, x.size)
        whole = x.size // step * step
        self._put(*self._buckets(begin, time, x[:whole], y[:whole], step), step)
        if whole < x.size:
            rest = slice(whole, None)
            self._put(*self._buckets(begin + whole, time, x[rest], y[rest], x.size - whole, whole), x.size - whole)

    def _put(self, rows: Array, sums: Array, step: int) -> None:
        if step < self.size:  # part of a bucket: a block of a larger one, or what is left at the end
            self._tail.append((rows, sums))
            self._filled += step * rows.shape[0]
            if self._filled < self.size:
                return
            rows, sums = _joined(*_stacked(self._tail), len(self._tail))
            self._tail, self._filled = [], 0
        self._new.append((rows, sums))
        self._count += rows.shape[0]
        while self._count > self._most and self._count % 2 == 0:
            self._rows, self._sums = _joined(*_stacked([(self._rows, self._sums), *self._new]), 2)
            self._new, self._count, self.size = [], self._rows.shape[0], 2 * self.size

    def _buckets(
        self, begin: int, time: Array | None, x: Array, y: Array, step: int, offset: int = 0
    ) -> tuple[Array, Array]:
        count = x.size // step
        base = np.arange(count) * step
        xs, ys = x.reshape(count, step), y.reshape(count, step)
        if step == 1:
            places = np.repeat(base[:, None], 5, axis=1)
        else:
            found = (xs.argmin(axis=1), xs.argmax(axis=1), ys.argmin(axis=1), ys.argmax(axis=1))
            places = np.column_stack([base, *(base + k for k in found)])
        rows = np.empty((count, 5, 4))
        rows[:, :, PLACE] = begin + places
        rows[:, :, X], rows[:, :, Y] = x[places], y[places]
        rows[:, :, TIME] = np.nan if time is None else time[offset + places]
        dx, dy = xs - self.origin[0], ys - self.origin[1]
        sums = np.empty((count, SUMS))
        sums[:, 0] = step
        sums[:, 1], sums[:, 2] = dx.sum(axis=1), dy.sum(axis=1)
        for column, (a, b) in enumerate(((dx, dx), (dy, dy), (dx, dy)), 3):
            sums[:, column] = np.einsum("ij,ij->i", a, b)
        return rows, sums

    def _all(self) -> tuple[Array, Array]:
        """Rows and sums of all buckets, the unfinished one among them."""
        if self._whole is None or self._whole[0] != self.samples:
            parts = [(self._rows, self._sums), *self._new]
            if self._tail:
                parts.append(_joined(*_stacked(self._tail), len(self._tail)))
            self._whole = self.samples, _stacked(parts)
        return self._whole[1]

    def rows(self) -> Array:
        """The rows that stand for all, (m, 4): place, x, y and time, in order; the last sample is among them."""
        rows = np.concatenate([self._all()[0].reshape(-1, 4), self._last[None, :]])
        _, first = np.unique(rows[:, PLACE], return_index=True)
        return rows[first]

    def extremes(self, start: int, stop: int, signal: int) -> tuple[float, float, int, int]:
        """Least and largest x (0) or y (1) of the whole buckets between two samples, and where these begin and end."""
        rows, sums = self._all()
        ends = np.cumsum(sums[:, 0]).astype(np.int64)
        begins = ends - sums[:, 0].astype(np.int64)
        first, last = int(np.searchsorted(begins, start)), int(np.searchsorted(ends, stop, side="right"))
        if first >= last:
            return float("inf"), float("-inf"), stop, start
        least, most, column = ((LEAST_X, MOST_X, X), (LEAST_Y, MOST_Y, Y))[signal]
        part = rows[first:last]
        low, high = float(part[:, least, column].min()), float(part[:, most, column].max())
        return low, high, int(begins[first]), int(ends[last - 1])

    def moments(self, stop: int) -> tuple[Array, tuple[float, float], int]:
        """Sums over the buckets that end by `stop`, (6,), the origin they refer to, and where the last of them ends."""
        sums = self._all()[1]
        ends = np.cumsum(sums[:, 0])
        count = int(np.searchsorted(ends, stop, side="right"))
        return sums[:count].sum(axis=0), self.origin, int(ends[count - 1]) if count else 0

    def first_beyond(self, bound: float, below: bool, start: int) -> int:
        """Begin of the first bucket that ends after sample `start` and reaches a bound of x; `samples` if none does."""
        rows, sums = self._all()
        ends = np.cumsum(sums[:, 0])
        reached = rows[:, LEAST_X, X] <= bound if below else rows[:, MOST_X, X] >= bound
        found = np.flatnonzero(reached & (ends > start))
        return self.samples if found.size == 0 else int(ends[found[0]] - sums[found[0], 0])


def _stacked(parts: list[tuple[Array, Array]]) -> tuple[Array, Array]:
    return np.concatenate([rows for rows, _ in parts]), np.concatenate([sums for _, sums in parts])


def _joined(rows: Array, sums: Array, group: int) -> tuple[Array, Array]:
    """Join every `group` neighbouring buckets; the first of equal extremes counts."""
    rows = rows.reshape(-1, group, 5, 4)
    each = np.arange(rows.shape[0])
    picked = np.empty((rows.shape[0], 5, 4))
    picked[:, FIRST] = rows[:, 0, FIRST]
    for kind, column, least in ((LEAST_X, X, True), (MOST_X, X, False), (LEAST_Y, Y, True), (MOST_Y, Y, False)):
        values = rows[:, :, kind, column]
        picked[:, kind] = rows[each, values.argmin(axis=1) if least else values.argmax(axis=1), kind]
    return picked, sums.reshape(-1, group, SUMS).sum(axis=1)


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
