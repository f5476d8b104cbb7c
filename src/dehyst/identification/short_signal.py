"""Replaces a long log by a short signal that leads to the same play states at chosen samples.

The state of a play at a sample depends on the input up to it only by its extremes that nothing wiped out. So a few
thousand rows of a log of millions, together with those extremes between them, are an exact stand-in: every start, grid
and family is compared on it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import dehyst._native as _native
from dehyst.arrays import Array, Rows
from dehyst.identification.data import DataSet, Piece, chunks
from dehyst.identification.regressors import fitted_samples, without_level

# Parts of a long signal after which what they left is looked through again.
OFTEN = 256


@dataclass(frozen=True)
class ShortPiece:
    """Rows of one piece."""

    x: Array  # Input at the rows and at the extremes between them, (m,), scaled
    rows: Rows  # Indices of the rows in the piece, (k,)
    place: Rows  # Where the rows stand in x, (k,)
    # y, weight: Output and weight at the rows, (k,); no weight where all count alike
    y: Array
    weight: Array | None
    own_level: bool  # Whether an unknown constant is in y


@dataclass(frozen=True)
class ShortSignal:
    """Rows of all pieces, (k,) together."""

    pieces: tuple[ShortPiece, ...]  # Those of the data set

    @property
    def rows(self) -> int:
        """Number of rows."""
        return sum(piece.y.size for piece in self.pieces)

    @property
    def y(self) -> Array:
        """Scaled output at the rows, (k,)."""
        return np.concatenate([piece.y for piece in self.pieces])

    @property
    def weight(self) -> Array | None:
        """Weights of the rows, (k,), or None."""
        parts = [piece.weight for piece in self.pieces]
        if all(part is None for part in parts):
            return None
        return np.concatenate(
            [np.ones(piece.y.size) if w is None else w for piece, w in zip(self.pieces, parts, strict=True)]
        )

    def plays(self, thresholds: Array, states: tuple[Array, ...]) -> Array:
        """Play outputs at the rows, (k, n)."""
        parts = [
            _native.play_bank(piece.x, thresholds, state, piece.place)[0]
            for piece, state in zip(self.pieces, states, strict=True)
            if piece.y.size
        ]
        return np.concatenate(parts)

    def outputs(self, thresholds: Array, states: tuple[Array, ...], weights: Array, offset: float) -> Array:
        """Outputs of a weighted sum of plays at the rows, (k,)."""
        parts = [
            _native.Evaluator(thresholds, weights, 0.0, offset, state).run(piece.x)[piece.place]
            for piece, state in zip(self.pieces, states, strict=True)
            if piece.y.size
        ]
        return np.concatenate(parts)

    def levelled(self, rows: Array, block: slice, alone: bool = True) -> Array:
        """Rows of a block, (k,) or (k, m), less their weighted means in each piece whose level is unknown.

        Where the block stands `alone` and no piece outside it has a known level, its own says nothing either.
        """
        ends = np.cumsum([piece.y.size for piece in self.pieces]).tolist()
        places = [
            (slice(max(end - piece.y.size, block.start) - block.start, min(end, block.stop) - block.start), piece)
            for end, piece in zip(ends, self.pieces, strict=True)
        ]
        known = sum(p.y.size - max(s.stop - s.start, 0) for s, p in places if not p.own_level)
        every = alone and not known and any(piece.own_level for piece in self.pieces)
        weight, left = self.weight, rows
        for inside, piece in places:
            if (piece.own_level or every) and inside.start < inside.stop:
                left = rows.copy() if left is rows else left
                counts = None if weight is None else weight[block][inside]
                if counts is None or np.any(counts > 0.0):
                    left[inside] -= np.average(rows[inside], axis=0, weights=counts)
        return left

    def sums(self, thresholds: Array, states: tuple[Array, ...], targets: Array, blocks: list[slice]) -> list[Array]:
        """Sums of [1 | cells | targets] over each block of the rows; targets (m, k), blocks one after the other.

        The extremes between the rows have no weight.
        """
        sums = [np.zeros(0)] * len(blocks)
        begin = 0
        for piece, state in zip(self.pieces, states, strict=True):
            end = begin + piece.y.size
            gram = _native.Gram(thresholds, state, targets.shape[0])
            done = 0
            for number, block in enumerate(blocks):
                low, high = max(block.start, begin), min(block.stop, end)
                if low >= high:
                    continue
                place = piece.place[low - begin : high - begin]
                stop = int(place[-1]) + 1
                weight, columns = np.zeros(stop - done), np.zeros((targets.shape[0], stop - done))
                weight[place - done] = 1.0 if piece.weight is None else piece.weight[low - begin : high - begin]
                columns[:, place - done] = targets[:, low:high]
                gram.add(piece.x[done:stop], columns, weight)
                found = without_level(gram.take()) if piece.own_level else gram.take()
                sums[number] = found if sums[number].size == 0 else sums[number] + found
                done = stop
            begin = end
        return sums


def shorten(data: DataSet, initial_state: str, most: int) -> ShortSignal:
    """Every k-th fitted sample of each piece, k such that no more than about `most` remain."""
    stride = max(1, -(-fitted_samples(data, initial_state) // most))
    pieces = []
    for piece in data.pieces:
        span = piece.fitted(initial_state)
        if piece.weight is None:
            rows = np.arange(span.start, span.stop, stride, dtype=np.int64)
        else:
            rows = span.start + np.flatnonzero(piece.weight[span])[::stride]
        x, place, y = _essential(piece, rows)
        weight = None if piece.weight is None else piece.weight[rows]
        pieces.append(ShortPiece(x, rows, place, y, weight, piece.unknown_level(initial_state) is not None))
    return ShortSignal(tuple(pieces))


def _essential(piece: Piece, rows: Rows) -> tuple[Array, Rows, Array]:
    """Input at the rows and the extremes between them, where the rows stand in it, and the output at the rows.

    A log that is not in memory is read part by part. What decides the states at the end of each part decides, with
    what comes then, those at every later row.
    """
    if isinstance(piece.x, np.ndarray):
        kept, place = _native.essential(piece.x, rows)
        return piece.x[kept], place, piece.y[rows]
    x, places, y = np.zeros(0), np.zeros(0, dtype=np.int64), np.empty(rows.size)
    new: list[Array] = []
    for part in chunks(slice(0, int(rows[-1]) + 1)) if rows.size else ():
        low, high = np.searchsorted(rows, [part.start, part.stop])
        inside = rows[low:high] - part.start
        signal = piece.x[part]
        kept, place = _native.essential(signal, _with_last(inside, signal.size))
        places = np.append(places, x.size + sum(one.size for one in new) + place[: inside.size])
        new.append(signal[kept])
        y[low:high] = piece.y[part][inside]
        if len(new) == OFTEN:
            x = np.concatenate([x, *new])
            kept, place = _native.essential(x, _with_last(places, x.size))
            x, places, new = x[kept], place[: places.size], []
    x = np.concatenate([x, *new])
    kept, place = _native.essential(x, places)
    return x[kept], place, y


def _with_last(rows: Rows, size: int) -> Rows:
    """Rows and the last of `size` samples."""
    return rows if rows.size and rows[-1] == size - 1 else np.append(rows, size - 1)
