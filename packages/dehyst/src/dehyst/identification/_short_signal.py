"""Replaces a long log by a short signal that leads to the same play states at chosen samples.

The state of a play at a sample depends on the input up to it only by its extremes that nothing wiped out. So a few
thousand rows of a log of millions, together with those extremes between them, are an exact stand-in: every start, grid
and family is compared on it.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

import dehyst._native as _native
from dehyst.arrays import Array, Mask, Rows
from dehyst.data import kit as data_kit
from dehyst.identification._data import DataSet
from dehyst.identification._regressors import without_level

PieceSums = dict[int, Array]  # number of a piece -> sums over its rows


@dataclass(frozen=True)
class ShortPiece:
    """Rows of one piece."""

    x: Array  # Input at the rows and at the extremes between them, (m,), scaled
    rows: Rows  # Indices of the rows in the piece, (k,)
    place: Rows  # Where the rows stand in x, (k,)
    y: Array  # Output at the rows, (k,)
    weight: Array  # How much each row counts, (k,)
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
    def weight(self) -> Array:
        """Weights of the rows, (k,)."""
        return np.concatenate([piece.weight for piece in self.pieces])

    @cached_property
    def folds(self) -> list[Rows]:
        """Rows of each spread fold, then of each fold in one piece; ten in all, some of them may have no row."""
        folds = []
        for fold in data_kit.folds_of(self.weight):
            for number in range(data_kit.FOLDS):
                folds.append(np.flatnonzero(fold == number))
        return folds

    def plays(self, thresholds: Array, states: tuple[Array, ...]) -> Array:
        """Play outputs at the rows, (k, n)."""
        parts = []
        for piece, state in zip(self.pieces, states, strict=True):
            if piece.y.size:
                parts.append(_native.play_bank(piece.x, thresholds, state, piece.place)[0])
        return np.concatenate(parts)

    def outputs(
        self, thresholds: Array, states: tuple[Array, ...], weights: Array, offset: float
    ) -> Array:
        """Outputs of a weighted sum of plays at the rows, (k,)."""
        parts = []
        for piece, state in zip(self.pieces, states, strict=True):
            if piece.y.size:
                evaluator = _native.Evaluator(thresholds, weights, 0.0, offset, state)
                parts.append(evaluator.run(piece.x)[piece.place])
        return np.concatenate(parts)

    def levelled(self, rows: Array, fitted: Mask) -> Array:
        """Rows, (k,) or (k, m), less the mean of the fitted ones in each piece whose level is unknown.

        A piece with no fitted row stays as it is: nothing is known of its level.
        """
        levelled = rows.copy()
        end = 0
        for piece in self.pieces:
            begin, end = end, end + piece.y.size
            if not piece.own_level:
                continue
            inside = begin + np.flatnonzero(fitted[begin:end])
            if inside.size:
                weight = piece.weight[inside - begin]
                levelled[begin:end] -= np.average(rows[inside], axis=0, weights=weight)
        return levelled

    def sums(
        self, thresholds: Array, states: tuple[Array, ...], targets: Array, blocks: list[slice]
    ) -> list[PieceSums]:
        """Sums of [1 | cells | targets] over each block of the rows; targets (m, k), blocks one after the other.

        Those of each piece stand by themselves. The extremes between the rows have no weight.
        """
        sums: list[PieceSums] = [{} for _ in blocks]
        begin = 0
        for number, (piece, state) in enumerate(zip(self.pieces, states, strict=True)):
            end = begin + piece.y.size
            gram = _native.Gram(thresholds, state, targets.shape[0])
            walked = 0
            for block, of_block in zip(blocks, sums, strict=True):
                low, high = max(block.start, begin), min(block.stop, end)
                if low >= high:
                    continue
                place = piece.place[low - begin : high - begin]
                stop = int(place[-1]) + 1
                # The extremes between the rows move the plays and count nothing.
                weight = np.zeros(stop - walked)
                columns = np.zeros((targets.shape[0], stop - walked))
                weight[place - walked] = piece.weight[low - begin : high - begin]
                columns[:, place - walked] = targets[:, low:high]
                gram.add(piece.x[walked:stop], columns, weight)
                of_block[number] = gram.take()
                walked = stop
            begin = end
        return sums

    def together(self, blocks: Iterable[PieceSums]) -> Array:
        """Sums of some blocks together; of a piece whose level is unknown less the level of all its samples in them."""
        by_piece: PieceSums = {}
        for block in blocks:
            for number, products in block.items():
                by_piece[number] = by_piece[number] + products if number in by_piece else products
        total: Array = np.zeros(())
        for number, products in by_piece.items():
            own_level = self.pieces[number].own_level
            total = total + (without_level(products) if own_level else products)
        return total


def shorten(data: DataSet, initial_state: str, most: int) -> ShortSignal:
    """Fitted samples of each piece, spread by way, such that no more than about `most` remain; each signal once."""
    key = (initial_state, most)
    if key not in data.short_signals:
        data.short_signals[key] = _shortened(data, initial_state, most)
    short: ShortSignal = data.short_signals[key]
    return short


def _shortened(data: DataSet, initial_state: str, most: int) -> ShortSignal:
    signals, counts = [], []
    for piece in data.pieces:
        fitted = np.zeros(piece.x.size, dtype=np.bool_)
        fitted[piece.fitted(initial_state)] = True
        if piece.weight is not None:
            fitted &= piece.weight > 0.0
        signals.append(piece.x)
        counts.append(fitted)
    pieces = []
    spread = data_kit.spread_rows(signals, counts, most)
    for piece, (rows, weight) in zip(data.pieces, spread, strict=True):
        essential, place = _native.essential(piece.x, rows)
        if piece.weight is not None:
            weight = weight * piece.weight[rows]
        own_level = piece.unknown_level(initial_state) is not None
        pieces.append(ShortPiece(piece.x[essential], rows, place, piece.y[rows], weight, own_level))
    return ShortSignal(tuple(pieces))
