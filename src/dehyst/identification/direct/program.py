"""The convex program of a direct inverse: rising polynomials, everything else non-negative, a trace of ridge."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from dehyst.arrays import Array
from dehyst.identification.direct.columns import Layout, Shape, by_output, powers_of, rising_powers, set_shares
from dehyst.identification.direct.data import DirectPiece
from dehyst.identification.least_squares import solve_bounded, triangle

# Square of the weight of each non-negative unknown, whose column is scaled to rms 1, relative to a sample. It keeps
# terms that are nearly alike from trading weight; it costs nothing that could be measured.
RIDGE = 1e-6
# Smallest slope of the polynomial, of input range over output range: the input rises with the output, whatever the
# past.
SMALLEST_SLOPE = 0.05


@dataclass(frozen=True)
class DirectEstimate:
    """Solution of one shape, scaled.

    Attributes
    ----------
    unknowns
        As in the program: constants, slopes, weights.
    polynomials
        (parts, degree + 1), powers of y.
    weights
        (sets, terms) of the shape.
    kkt_residual
        Largest violation of the optimality conditions.
    """

    shape: Shape
    unknowns: Array
    polynomials: Array
    weights: Array
    kkt_residual: float


def solve_shape(layout: Layout, shape: Shape, system: Array, samples: int, ridge: float = RIDGE) -> DirectEstimate:
    """Solve the program of a shape for its rows, or triangles of them stacked, that stand for `samples` samples."""
    free = len(layout.constants)
    slopes = layout.parts * shape.degree
    terms = system.shape[1] - 1 - free - slopes
    rms = np.sqrt(np.sum(system[:, free + slopes : -1] ** 2, axis=0) / max(samples, 1))
    penalty = np.zeros((terms, system.shape[1]))
    penalty[:, free + slopes : -1] = np.diag(np.sqrt(ridge * samples) * rms)
    # Parts of several given schedules are summed: each gives its share of the slope.
    lower = np.concatenate([np.full(slopes, SMALLEST_SLOPE / max(1, layout.given)), np.zeros(terms)])
    solution = solve_bounded(np.vstack([system, penalty]), free, lower)
    polynomials = solution.bounded[:slopes].reshape(layout.parts, shape.degree) @ rising_powers(shape.degree).T
    polynomials[layout.constants, 0] += solution.free
    unknowns = np.concatenate([solution.free, solution.bounded])
    weights = solution.bounded[slopes:].reshape(len(layout.sets_of(shape)), layout.terms_of(shape).size)
    return DirectEstimate(shape, unknowns, polynomials, weights, solution.kkt_residual)


def rms_on(layout: Layout, estimate: DirectEstimate, reduced: Array, samples: int) -> float:
    """RMS of the residual of an estimate on rows, or on the triangle of rows, that stand for `samples` samples."""
    left = layout.select(estimate.shape, reduced) @ np.append(estimate.unknowns, -1.0)
    return float(np.sqrt(left @ left / max(samples, 1)))


@dataclass(frozen=True)
class Block:
    """Consecutive fitted rows, or their triangle, and the number of samples they stand for."""

    rows: Array
    samples: int


def blocks_of(parts: Iterable[Array], samples: int, blocks: int) -> list[Block]:
    """Cut `samples` rows, which come in parts, into consecutive blocks, each reduced to its triangle."""
    edges = np.linspace(0, samples, blocks + 1).round().astype(int).tolist()
    found: list[Block] = []
    kept, place = np.zeros((0, 0)), 0
    for part in parts:
        while part.shape[0]:
            taken = min(part.shape[0], edges[len(found) + 1] - place)
            kept = _reduced(np.vstack([kept, part[:taken]]) if kept.size else part[:taken])
            part, place = part[taken:], place + taken
            if place == edges[len(found) + 1]:
                found.append(Block(kept, edges[len(found) + 1] - edges[len(found)]))
                kept = np.zeros((0, 0))
    return found


def _reduced(rows: Array) -> Array:
    return triangle(rows) if rows.shape[0] > rows.shape[1] else rows


def merged(blocks: list[Block], together: int) -> list[Block]:
    """Fewer and larger blocks: always so many of them together."""
    return [
        Block(
            np.concatenate([b.rows for b in blocks[k : k + together]]), sum(b.samples for b in blocks[k : k + together])
        )
        for k in range(0, len(blocks), together)
    ]


def without(blocks: list[Block], left_out: int) -> tuple[Array, int]:
    """Rows of all blocks but one, and their number of samples."""
    others = [block for k, block in enumerate(blocks) if k != left_out]
    return np.concatenate([block.rows for block in others]), sum(block.samples for block in others)


def held_out(layout: Layout, shape: Shape, blocks: list[Block]) -> Array:
    """RMS on every block of the fit to the others, scaled, (blocks,)."""
    errors = []
    for k, block in enumerate(blocks):
        rows, samples = without(blocks, k)
        estimate = solve_shape(layout, shape, layout.select(shape, rows), samples)
        errors.append(rms_on(layout, estimate, block.rows, block.samples))
    return np.array(errors)


def predict(layout: Layout, estimate: DirectEstimate, piece: DirectPiece, terms: Array, at: slice) -> Array:
    """Scaled input that an estimate asks for at some samples of a piece, (m,), from the terms there."""
    y, given = piece.y[at], tuple(xi[at] for xi in piece.given)
    powers, chosen = powers_of(y, estimate.shape.degree + 1), terms[:, layout.terms_of(estimate.shape)]
    stored = set_shares((by_output(y), *given))
    sets = (np.sum([stored[k] for k in parts], axis=0) for parts in layout.sets_of(estimate.shape))
    curves = zip(set_shares(given) or [np.ones(y.size)], (powers @ estimate.polynomials.T).T, strict=True)
    weighted = zip(sets, (chosen @ estimate.weights.T).T, strict=True)
    asked: Array = np.sum([share * values for share, values in (*curves, *weighted)], axis=0)
    return asked
