"""A long log as a short signal that gives every play the same state at the samples that are looked at.

The state of a play at a sample depends on the input up to it only by its extremes that nothing wiped out. So a few
thousand rows of a log of millions, together with those extremes between them, are an exact stand-in: every start, grid
and family is compared on it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from dehyst import _native
from dehyst.identification.data import DataSet

Array = npt.NDArray[np.float64]
Rows = npt.NDArray[np.int64]


@dataclass(frozen=True)
class ShortPiece:
    """Rows of one piece.

    Attributes
    ----------
    x
        Input at the rows and at the extremes between them, (m,), scaled.
    place
        Where the rows stand in x, (k,).
    y, weight
        Output and weight at the rows, (k,); no weight where all count alike.
    """

    x: Array
    place: Rows
    y: Array
    weight: Array | None


@dataclass(frozen=True)
class ShortSignal:
    """Rows of all pieces, (k,) together."""

    pieces: tuple[ShortPiece, ...]

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


def shorten(data: DataSet, initial_state: str, most: int) -> ShortSignal:
    """Every k-th fitted sample of each piece, k such that no more than about `most` remain."""
    chosen = []
    for piece in data.pieces:
        span = piece.fitted(initial_state)
        rows = np.arange(span.start, span.stop, dtype=np.int64)
        if piece.weight is not None:
            rows = rows[piece.weight[span] > 0.0]
        chosen.append(rows)
    stride = max(1, -(-sum(rows.size for rows in chosen) // most))
    pieces = []
    for piece, every in zip(data.pieces, chosen, strict=True):
        rows = every[::stride]
        kept, place = _native.essential(piece.x, rows)
        weight = None if piece.weight is None else piece.weight[rows]
        pieces.append(ShortPiece(piece.x[kept], place, piece.y[rows], weight))
    return ShortSignal(tuple(pieces))
