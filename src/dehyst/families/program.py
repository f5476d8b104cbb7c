r"""Convex program of every sum of elements: normal equations by block, solved with an active set.

    minimise  sum over rows of (c + A w - T(y))^2 / T'(y)^2  +  n (lam^2 |differences of neighbours|^2 + ridge^2 |w|^2)
    subject to  w >= 0,  w >= 0.02 for ramps of x,  T' >= 0.05,  T of mean slope 1

T is the identity, or piecewise linear and identified too, in two passes: the second knows T' and so counts errors of y.
Sums of blocks add up to those of every choice of blocks, so leaving blocks out costs no pass over the data.
"""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

import dehyst._native as _native
from dehyst.arrays import Array
from dehyst.errors import IdentificationError

Numbers = npt.NDArray[np.int64]
Marks = npt.NDArray[np.bool_]
Found = tuple[Array, Marks, float]  # unknowns, those off their bound, violation

PIECES = 10
BLOCKS = 5
LEAST = 0.02  # slope of the sum right after a reversal: the gain of its inverse is at most 50
LEAST_OF_MAP = 0.05
SMOOTH_MAP = 0.03
MEAN_SLOPE = 1e3  # weight of the row that keeps it
PROVEN = 1e-6  # violation of the optimality conditions, relative


@dataclass(frozen=True)
class Regularisation:
    """`lam` of differences between neighbouring ramps, `ridge` of weights, both over the rms of one row."""

    lam: float
    ridge: float


@dataclass(frozen=True, eq=False)
class Weights:
    """What the program finds.

    Attributes
    ----------
    offset, weight
        c and w (p,), of the columns that take part.
    inner, outer
        T(y) and y at the breakpoints of T, increasing; empty for the identity.
    passive
        Unknowns off their bound, for the next start.
    kkt
        Largest violation of the optimality conditions, relative to |column| |y|.
    """

    offset: float
    weight: Array
    inner: Array
    outer: Array
    passive: Marks
    kkt: float

    def outputs(self, summed: Array) -> Array:
        """Outputs (T,) for sums A w."""
        u = self.offset + summed
        return _native.map_values(self.inner, self.outer, u) if self.inner.size else np.asarray(u)


@dataclass(frozen=True, eq=False)
class Sums:
    """Normal equations of [1 | columns | pieces of y] by block and piece of y.

    Attributes
    ----------
    gram, rhs
        (blocks, pieces, N, N) and (blocks, pieces, N).
    counted, square
        Rows and squares of y, (blocks, pieces).
    knots
        Of the pieces, (pieces + 1,).
    least
        Lower bounds of the columns, (p,).
    neighbours
        Pairs of columns, (q, 2).
    """

    gram: Array
    rhs: Array
    counted: Array
    square: Array
    knots: Array
    least: Array
    neighbours: Numbers

    @property
    def pieces(self) -> int:
        """Of the output map."""
        return self.knots.size - 1

    @cached_property
    def of_blocks(self) -> tuple[Array, Array]:
        """Sums over the pieces, (blocks, N, N) and (blocks, N)."""
        return self.gram.sum(1), self.rhs.sum(1)

    @cached_property
    def penalty(self) -> tuple[Array, Array]:
        """Of differences between neighbours, (p, p), and of the slopes of the map, (pieces, pieces)."""
        pairs = np.stack([np.arange(self.pieces - 1), np.arange(1, self.pieces)], axis=1)
        return _differences(self.least.size, self.neighbours), _differences(self.pieces, pairs)


def sums_of(columns: Array, y: Array, block: Numbers, least: Array, neighbours: Numbers, pieces: int) -> Sums:
    """Add up rows: columns (T, p), outputs and blocks (T,)."""
    knots = np.linspace(float(y.min()), float(y.max()), pieces + 1)
    place = np.clip(np.searchsorted(knots, y, side="right") - 1, 0, pieces - 1)
    low, high = knots[:-1].copy(), knots[1:].copy()
    low[0], high[-1] = -np.inf, np.inf
    ramps = np.clip(y[:, None], low, high) - knots[:-1]
    rows = np.hstack([np.ones((y.size, 1)), columns, -ramps])
    n = rows.shape[1]
    gram, rhs = np.empty((BLOCKS, pieces, n, n)), np.zeros((BLOCKS, pieces, n))
    counted, square = np.zeros((BLOCKS, pieces)), np.zeros((BLOCKS, pieces))
    order = np.lexsort((place, block))
    bounds = np.searchsorted(block[order] * pieces + place[order], np.arange(BLOCKS * pieces + 1))
    for k in range(BLOCKS * pieces):
        part = order[bounds[k] : bounds[k + 1]]
        b, m, own = k // pieces, k % pieces, rows[part]
        np.matmul(own.T, own, out=gram[b, m])
        rhs[b, m] = own.T @ y[part]
        counted[b, m], square[b, m] = part.size, y[part] @ y[part]
    return Sums(gram, rhs, counted, square, knots, least, neighbours)


class Program:
    """The program of some of the columns, with or without a map; solved from any of the blocks."""

    def __init__(self, sums: Sums, columns: Numbers, mapped: bool) -> None:
        self._sums, self._mapped, self._size = sums, mapped, 1 + columns.size
        first = 1 + sums.least.size
        own = np.concatenate([[0], 1 + columns, np.arange(first, first + sums.pieces) if mapped else []]).astype(
            np.int64
        )
        pairs = (own[:, None] * sums.gram.shape[-1] + own).ravel()  # one index is ten times as fast as two
        gram, rhs = sums.of_blocks
        self._of_blocks = gram.reshape(BLOCKS, -1).take(pairs, axis=1), rhs.take(own, axis=1)
        if mapped:
            self._gram = sums.gram.reshape(BLOCKS * sums.pieces, -1).take(pairs, axis=1)
            self._rhs = sums.rhs.reshape(BLOCKS * sums.pieces, -1).take(own, axis=1)
        self._chains = sums.penalty[0][np.ix_(columns, columns)]
        slopes = [LEAST_OF_MAP - 1.0] * (sums.pieces if mapped else 0)  # counted from 1 on
        self._lower = np.concatenate([[0.0], sums.least[columns], slopes])

    def with_least(self, least: Array) -> Program:
        """The same program with other least weights (p,); its sums are shared."""
        firmer = copy(self)
        firmer._lower = np.concatenate([[0.0], least, self._lower[self._size :]])
        return firmer

    def solve(self, blocks: tuple[int, ...], regularisation: Regularisation, warm: Marks | None = None) -> Weights:
        """Return the weights from some blocks.

        Raises
        ------
        IdentificationError
            If the optimum was not reached.
        """
        return self.solve_each((blocks,), regularisation, warm)[0]

    def solve_each(
        self, choices: Sequence[tuple[int, ...]], regularisation: Regularisation, warm: Marks | None = None
    ) -> list[Weights]:
        """Return the weights from each choice of blocks; those of the first are where the others begin."""
        sums, size, n_own = self._sums, self._size, self._lower.size
        seen = np.array([[float(block in blocks) for block in range(BLOCKS)] for blocks in choices])
        samples, norms = seen @ sums.counted.sum(1), np.sqrt(seen @ sums.square.sum(1))
        extra = self._extra(regularisation)

        def solved(weights: Array, sums_of: tuple[Array, Array], norms: Array, warm: list[Marks | None]) -> list[Found]:
            grams, sides = (weights @ each for each in sums_of)  # one product reads the sums once
            found: list[Found] = []
            for k, (gram, side, norm) in enumerate(zip(grams, sides, norms.tolist(), strict=True)):
                begin = warm[k] if k < len(warm) else found[0][1]
                found.append(_solved(gram.reshape(n_own, n_own) + samples[k] * extra, side, self._lower, norm, begin))
            return found

        first = solved(seen, self._of_blocks, norms, [warm])
        if not self._mapped:
            return [Weights(float(u[0]), u[1:], np.zeros(0), np.zeros(0), off, kkt) for u, off, kkt in first]
        gains = [1.0 / np.maximum(1.0 + u[size:], 2.0 * LEAST_OF_MAP) ** 2 for u, *_ in first]
        each = np.stack([np.outer(own, gain).ravel() for own, gain in zip(seen, gains, strict=True)])
        begun: list[Marks | None] = [passive for _, passive, _ in first]
        final = solved(each, (self._gram, self._rhs), np.sqrt(each @ sums.square.ravel()), begun)
        return [Weights(float(u[0]), u[1:size], self._inner(u[size:]), sums.knots, off, kkt) for u, off, kkt in final]

    def _inner(self, slopes: Array) -> Array:
        """T at the knots, from its slopes less 1."""
        rises = (1.0 + slopes) * np.diff(self._sums.knots)
        return np.asarray(self._sums.knots[0] + np.concatenate([[0.0], np.cumsum(rises)]))

    def _extra(self, regularisation: Regularisation) -> Array:
        """What a sample adds to the normal equations beside itself."""
        size, sums = self._size, self._sums
        extra = np.zeros((self._lower.size, self._lower.size))
        extra[1:size, 1:size] = regularisation.lam**2 * self._chains
        extra[np.arange(1, size), np.arange(1, size)] += regularisation.ridge**2
        if self._mapped:
            share = np.diff(sums.knots) / np.ptp(sums.knots)
            extra[size:, size:] = MEAN_SLOPE * np.outer(share, share) + SMOOTH_MAP**2 * sums.penalty[1]
        return extra


def _solved(system: Array, rhs: Array, lower: Array, norm: float, warm: Marks | None) -> Found:
    u, passive, kkt, *_ = _native.solve_bounded(
        system, rhs, lower, 1, 0, _native.WEIGHTS, None, None, warm, max(norm, 1e-150)
    )
    if not kkt <= PROVEN:
        raise IdentificationError(
            f"the weights of {lower.size} columns did not reach their optimum (violation {kkt:.1g}). Give more of the "
            f"log, or take a smaller row, such as play-sum."
        )
    return u, passive, kkt


def _differences(size: int, pairs: Numbers) -> Array:
    found = np.zeros((size, size))
    np.add.at(found, (pairs[:, 0], pairs[:, 0]), 1.0)
    np.add.at(found, (pairs[:, 1], pairs[:, 1]), 1.0)
    np.add.at(found, (pairs[:, 0], pairs[:, 1]), -1.0)
    np.add.at(found, (pairs[:, 1], pairs[:, 0]), -1.0)
    return found
