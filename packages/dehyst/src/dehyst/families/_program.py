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
from dehyst.data import kit as data_kit
from dehyst.errors import IdentificationError

Numbers = npt.NDArray[np.int64]
Marks = npt.NDArray[np.bool_]
# Unknowns, which of them are off their bound, violation of the optimality conditions.
Solution = tuple[Array, Marks, float]

PIECES = 10
BLOCKS = data_kit.FOLDS
LEAST = 0.02  # slope of the sum right after a reversal: the gain of its inverse is at most 50
LEAST_OF_MAP = 0.05
SMOOTH_MAP = 0.03
MEAN_SLOPE = 1e3  # weight of the row that keeps it
PROVEN = 1e-6  # violation of the optimality conditions, relative


@dataclass(frozen=True)
class RampRegularisation:
    """`lam` of differences between neighbouring ramps, `ridge` of weights, both over the rms of one row."""

    lam: float
    ridge: float


@dataclass(frozen=True, eq=False)
class Weights:
    """The solution of the program.

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

    def map_rows(self, y: Array) -> tuple[Array, Array, Array]:
        """By how much T(y) grows with each slope of T, (T, pieces), with y, (T,), and these slopes, (pieces,)."""
        if not self.outer.size:
            return np.zeros((y.size, 0)), np.ones(y.size), np.zeros(0)
        slopes = np.diff(self.inner) / np.diff(self.outer)
        place, ramps = _ramps(y, self.outer)
        return ramps, slopes[place], slopes


@dataclass(frozen=True, eq=False)
class Sums:
    """Normal equations of [1 | columns | pieces of y] by block and piece of y.

    Attributes
    ----------
    gram
        Lower triangles of the symmetric matrices, row by row: (blocks, pieces, N (N + 1) / 2).
    rhs
        (blocks, pieces, N).
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
        """Sums by block alone, (blocks, N (N + 1) / 2) and (blocks, N)."""
        return self.gram.sum(1), self.rhs.sum(1)

    @cached_property
    def of_parts(self) -> tuple[Array, Array]:
        """Sums by block and piece in one row, (blocks pieces, N (N + 1) / 2) and (blocks pieces, N)."""
        parts = BLOCKS * self.pieces
        return self.gram.reshape(parts, -1), self.rhs.reshape(parts, -1)

    @cached_property
    def penalty(self) -> tuple[Array, Array]:
        """Of differences between neighbours, (p, p), and of the slopes of the map, (pieces, pieces)."""
        return _differences(self.least.size, self.neighbours), _chain(self.pieces)


def blocks_used(choices: Sequence[tuple[int, ...]]) -> Array:
    """1 for each block that is in a choice, else 0; (choices, blocks)."""
    used = np.zeros((len(choices), BLOCKS))
    for k, blocks in enumerate(choices):
        used[k, list(blocks)] = 1.0
    return used


def block_sums(
    columns: Array,
    y: Array,
    block: Numbers,
    least: Array,
    neighbours: Numbers,
    pieces: int,
    weight: Array,
) -> Sums:
    """Add up rows: columns (T, p), outputs, blocks and weights (T,)."""
    knots = np.linspace(float(y.min()), float(y.max()), pieces + 1)
    place, ramps = _ramps(y, knots)
    order = np.lexsort((place, block))
    bounds = np.searchsorted(block[order] * pieces + place[order], np.arange(BLOCKS * pieces + 1))
    # Rows times the roots of their weights: a product of one matrix with itself takes half of what that of two takes.
    root = np.sqrt(weight)
    target = root * y
    size = 1 + columns.shape[1]
    n = size + pieces
    rows = np.empty((int(np.diff(bounds).max()), n))  # of one part after the other
    gram, rhs = np.zeros((BLOCKS, pieces, n * (n + 1) // 2)), np.zeros((BLOCKS, pieces, n))
    square_matrix = np.empty((n, n))
    counted, square = np.zeros((BLOCKS, pieces)), np.zeros((BLOCKS, pieces))
    for k in range(BLOCKS * pieces):
        b, m = divmod(k, pieces)
        part = order[bounds[k] : bounds[k + 1]]
        if not part.size:
            continue
        # What is in one part alone is in order, and need not be gathered.
        alone = part.size == y.size
        part_rows, part_root = rows[: part.size], root[part, None]
        part_rows[:, :1] = part_root
        np.multiply(
            columns if alone else columns.take(part, axis=0), part_root, out=part_rows[:, 1:size]
        )
        np.multiply(ramps[part], -part_root, out=part_rows[:, size:])
        np.matmul(part_rows.T, part_rows, out=square_matrix)
        _native.triangle(square_matrix, gram[b, m])
        rhs[b, m] = part_rows.T @ target[part]
        counted[b, m] = weight[part].sum()
        square[b, m] = target[part] @ target[part]
    return Sums(gram, rhs, counted, square, knots, least, neighbours)


def _ramps(y: Array, knots: Array) -> tuple[Numbers, Array]:
    """In which piece each y lies, (T,), and how far it is along each of them, (T, pieces); the outer ones go on."""
    place = np.clip(np.searchsorted(knots, y, side="right") - 1, 0, knots.size - 2)
    low, high = knots[:-1].copy(), knots[1:].copy()
    low[0], high[-1] = -np.inf, np.inf
    return place, np.clip(y[:, None], low, high) - knots[:-1]


class Program:
    """The program of some of the columns, with or without a map; solved from any of the blocks."""

    def __init__(self, sums: Sums, columns: Numbers, mapped: bool) -> None:
        self._sums, self._mapped, self._size = sums, mapped, 1 + columns.size
        pieces = sums.pieces if mapped else 0
        first = 1 + sums.least.size
        # Which unknowns take part: the offset, weights of the columns, slopes of the map.
        unknowns = np.concatenate([[0], 1 + columns, np.arange(first, first + pieces)])
        self._unknowns = unknowns.astype(np.int64)
        self._chains = sums.penalty[0][np.ix_(columns, columns)]
        # The unknowns of the map are its slopes less 1.
        slopes = np.full(pieces, LEAST_OF_MAP - 1.0)
        self._lower = np.concatenate([[0.0], sums.least[columns], slopes])

    def with_least(self, least: Array) -> Program:
        """The same program with other least weights (p,); its sums are shared."""
        firmer = copy(self)
        firmer._lower = np.concatenate([[0.0], least, self._lower[self._size :]])
        return firmer

    def solve(
        self, blocks: tuple[int, ...], regularisation: RampRegularisation, warm: Marks | None = None
    ) -> Weights:
        """Return the weights from some blocks.

        Raises
        ------
        IdentificationError
            If the optimum was not reached.
        """
        return self.solve_each((blocks,), regularisation, warm)[0]

    def solve_each(
        self,
        choices: Sequence[tuple[int, ...]],
        regularisation: RampRegularisation,
        warm: Marks | None = None,
    ) -> list[Weights]:
        """Return the weights from each choice of blocks; the others begin with those of the first."""
        sums, size = self._sums, self._size
        used = blocks_used(choices)
        samples = used @ sums.counted.sum(1)
        norms = np.sqrt(used @ sums.square.sum(1))
        extra = self._extra(regularisation)
        rows, places = np.nonzero(extra)  # few

        def solved(
            parts: tuple[Array, Array], factors: Array, norms: Array, warm: list[Marks | None]
        ) -> list[Solution]:
            solutions: list[Solution] = []
            grams = _native.sums_of_triangles(parts[0], factors, self._unknowns)
            grams[:, rows, places] += np.outer(samples, extra[rows, places])
            sides = (factors @ parts[1]).take(self._unknowns, axis=1)
            for k, (gram, side, norm) in enumerate(zip(grams, sides, norms.tolist(), strict=True)):
                begin = warm[k] if k < len(warm) else solutions[0][1]
                solutions.append(_solved(gram, side, self._lower, norm, begin))
            return solutions

        first = solved(sums.of_blocks, used, norms, [warm])
        results = []
        if not self._mapped:
            identity = np.zeros(0)
            for u, off_bound, kkt in first:
                results.append(Weights(float(u[0]), u[1:], identity, identity, off_bound, kkt))
            return results
        # The second pass knows the slope of the map, and so weighs each piece by errors of the output.
        factors = np.zeros((len(choices), BLOCKS * sums.pieces))
        begun: list[Marks | None] = []
        for k, (u, off_bound, _) in enumerate(first):
            gain = 1.0 / np.maximum(1.0 + u[size:], 2.0 * LEAST_OF_MAP) ** 2
            factors[k] = np.outer(used[k], gain).ravel()
            begun.append(off_bound)
        norms = np.sqrt(factors @ sums.square.ravel())
        for u, off_bound, kkt in solved(sums.of_parts, factors, norms, begun):
            inner = self._inner(u[size:])
            results.append(Weights(float(u[0]), u[1:size], inner, sums.knots, off_bound, kkt))
        return results

    def _inner(self, slopes: Array) -> Array:
        """T at the knots, from its slopes less 1."""
        rises = (1.0 + slopes) * np.diff(self._sums.knots)
        return np.asarray(self._sums.knots[0] + np.concatenate([[0.0], np.cumsum(rises)]))

    def _extra(self, regularisation: RampRegularisation) -> Array:
        """What a sample adds to the normal equations beside itself."""
        knots = self._sums.knots if self._mapped else np.zeros(0)
        return _penalty(regularisation, self._chains, self._sums.penalty[1], knots)


def penalty_of(
    regularisation: RampRegularisation, neighbours: Numbers, size: int, knots: Array
) -> Array:
    """Return what a sample adds to the normal equations of `size` columns and a map between knots, if there are any."""
    return _penalty(
        regularisation, _differences(size, neighbours), _chain(max(knots.size - 1, 0)), knots
    )


def _penalty(
    regularisation: RampRegularisation, chains: Array, of_map: Array, knots: Array
) -> Array:
    size = 1 + len(chains)
    pieces = max(knots.size - 1, 0)
    extra = np.zeros((size + pieces, size + pieces))
    extra[1:size, 1:size] = regularisation.lam**2 * chains
    extra[np.arange(1, size), np.arange(1, size)] += regularisation.ridge**2
    if pieces:
        share = np.diff(knots) / np.ptp(knots)
        extra[size:, size:] = MEAN_SLOPE * np.outer(share, share) + SMOOTH_MAP**2 * of_map
    return extra


def _chain(size: int) -> Array:
    """Return the matrix of the sum of squared differences of successive ones."""
    pairs = np.stack([np.arange(max(size - 1, 0)), np.arange(1, max(size, 1))], axis=1)
    return _differences(size, pairs)


def _solved(system: Array, rhs: Array, lower: Array, norm: float, warm: Marks | None) -> Solution:
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
    """Return the matrix (size, size) of the sum of squared differences of pairs."""
    left, right = pairs[:, 0], pairs[:, 1]
    matrix = np.zeros((size, size))
    np.add.at(matrix, (left, left), 1.0)
    np.add.at(matrix, (right, right), 1.0)
    np.add.at(matrix, (left, right), -1.0)
    np.add.at(matrix, (right, left), -1.0)
    return matrix
