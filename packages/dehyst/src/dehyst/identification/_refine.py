"""Iterative refinement of a solution of the normal equations: restores digits lost in long sums.

`refine`, on the data, for families without an output map:

    r_k = y_k - c - sum_i w_i z_i[k]         by the model itself, sample by sample
    g = sum_k c_k r_k                        over the columns [1 | cells]
    G_P d = g_P                              on the slopes that are free, those between two operators with weight

The gradient of small residuals has an error in proportion to them, not to y. The step is kept if the sum of squares on
the data is no larger after it, but for rounding, and the KKT residual on the data, which is the certificate's, is no
larger either or as small as rounding allows.

`polish`, on the sums, for the modified model: the row that fixes the mean slope of the map weighs a million times as
much as a sample, and its square hides six digits of the rest. The gradient is formed from the row itself.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from dehyst._native import SLOPES, STOPS, WEIGHTS, Evaluator, Gram
from dehyst.arrays import Array
from dehyst.identification._data import DataSet, chunks
from dehyst.identification._families import (
    BASIS,
    NORMAL,
    NORMALISATION,
    Estimate,
    QuadraticProgram,
    Regularisation,
    estimate_of,
    lower_bounds,
    program,
)
from dehyst.identification._regressors import TRACE, NormalEquations, PlayBank

Marks = npt.NDArray[np.bool_]


ROUNDING = 1e-12
PROVEN = 1e-13
ROUNDS = 8


@dataclass(frozen=True)
class Gradient:
    """Of the sum of squares at an estimate."""

    cells: Array  # Sums of [1 | cells] times the residual, (1 + n,)
    square: float  # Sum of squared residuals


def gradient_of(data: DataSet, bank: PlayBank, estimate: Estimate) -> Gradient:
    """Residuals of an estimate without output map over the fitted samples, summed against the columns."""
    total, square = np.zeros(1 + bank.thresholds.size), 0.0
    for piece, state in zip(data.pieces, bank.states, strict=True):
        span = piece.fitted(bank.initial_state)
        if span.stop <= span.start:
            continue
        model = Evaluator(bank.thresholds, estimate.weights, 0.0, estimate.offset, state)
        level = piece.unknown_level(bank.initial_state) is not None
        gram = Gram(bank.thresholds, state, 1 + level)
        gram.only_targets(True)
        for part in chunks(slice(0, span.start)):
            model.run(piece.x[part])
            gram.skip(piece.x[part])
        for part in chunks(span):
            x = piece.x[part]
            residual = piece.y[part] - model.run(x)
            weight = None if piece.weight is None else piece.weight[part]
            targets = np.vstack([np.ones(x.size), residual]) if level else residual[None, :]
            gram.add(x, targets, weight)
            square += float(residual @ (residual if weight is None else weight * residual))
        sums = gram.take()
        total += sums[: 1 + bank.thresholds.size, -1]
        if level and sums[0, -2] > 0.0:
            mean = (1.0 - TRACE) * sums[0, -1] / sums[0, -2]
            total -= mean * sums[: 1 + bank.thresholds.size, -2]
            square -= mean * float(sums[0, -1])
    return Gradient(total, square)


def refine(
    data: DataSet, bank: PlayBank, sums: NormalEquations, eps: float, estimate: Estimate
) -> Estimate:
    """Return the estimate, refined on the data where that improves it, with the KKT residual of the data."""
    if estimate.slopes is not None or estimate.passive is None or estimate.route != NORMAL:
        return estimate
    before = gradient_of(data, bank, estimate)
    checked = replace(
        estimate, kkt_residual=kkt_residual(sums, estimate.family, estimate.passive, before)
    )
    better = _step(sums, eps, estimate, before)
    if better is None:
        return checked
    after = gradient_of(data, bank, better)
    if better.passive is None:
        return checked
    better = replace(better, kkt_residual=kkt_residual(sums, better.family, better.passive, after))
    improved = after.square <= before.square * (1.0 + ROUNDING)
    return (
        better if improved and better.kkt_residual <= max(checked.kkt_residual, PROVEN) else checked
    )


def _step(
    sums: NormalEquations, eps: float, estimate: Estimate, gradient: Gradient
) -> Estimate | None:
    """Solve G_P d = g_P; weights that would leave their bound are set to it first. None if that does not end."""
    n = sums.operators
    if estimate.passive is None:
        return None
    lower = np.concatenate([[-np.inf], lower_bounds(estimate.family, n, eps)])
    passive, u, slope = estimate.passive.copy(), estimate.parameters.copy(), gradient.cells.copy()
    passive[0] = True
    for _ in range(ROUNDS):
        step = _solved(sums, estimate.family, passive[1 : 1 + n], slope)
        if step is None:
            return None
        out = passive & (u + step <= lower)
        if not out.any():
            passive[0] = estimate.passive[0]
            return estimate_of(
                estimate.family, n, u + step, 0.0, estimate.route, estimate.condition, passive
            )
        back = np.where(out, lower - u, 0.0)
        u[out], passive[out] = lower[out], False
        slope -= sums.matrix[: 1 + n, : 1 + n] @ np.concatenate(
            [[0.0], slopes_of(estimate.family, back[1:])]
        )
    return None


def _solved(sums: NormalEquations, family: str, passive: Marks, gradient: Array) -> Array | None:
    """Step of [c | parameters of the plays] that makes the gradient vanish on the free slopes."""
    n = sums.operators
    starts, free = _groups(family, passive)
    edges = np.concatenate([[0], 1 + starts])
    chosen = np.concatenate([[True], free])
    matrix = sums.matrix[: 1 + n, : 1 + n]
    block = np.add.reduceat(np.add.reduceat(matrix, edges, axis=0), edges, axis=1)[
        np.ix_(chosen, chosen)
    ]
    right = np.add.reduceat(gradient, edges)[chosen]
    scale = 1.0 / np.sqrt(np.maximum(np.diag(block), 1e-300))
    try:
        step = scale * np.linalg.solve(block * scale[:, None] * scale, scale * right)
    except np.linalg.LinAlgError:
        return None
    slopes = np.zeros(free.size)
    slopes[free] = step[1:]
    change = np.repeat(slopes, np.diff(np.append(starts, n)))
    return np.concatenate([step[:1], _from_slopes(family, change)])


def _groups(family: str, passive: Marks) -> tuple[npt.NDArray[np.int64], Marks]:
    """First cell of each group of cells with one slope, and whether that slope is free."""
    if BASIS[family] == SLOPES:
        return np.arange(passive.size), passive
    inner = 1 + np.flatnonzero(passive[1:])
    starts = np.concatenate([[0], inner])
    free = np.ones(starts.size, dtype=np.bool_)
    free[-1 if BASIS[family] == STOPS else 0] = passive[0]
    return starts, free


def _from_slopes(family: str, change: Array) -> Array:
    """Parameters u of the plays from their slopes v = T u."""
    if BASIS[family] == SLOPES:
        return change
    if BASIS[family] == STOPS:
        return np.concatenate([change[-1:], change[:-1] - change[1:]])
    return np.diff(change, prepend=0.0)


def slopes_of(family: str, plays: Array) -> Array:
    """Slopes v = T u of the cells."""
    if BASIS[family] == SLOPES:
        return plays
    if BASIS[family] == STOPS:
        return np.asarray(
            plays[0] + np.append(np.cumsum(plays[:0:-1])[::-1], 0.0), dtype=np.float64
        )
    return np.asarray(np.cumsum(plays), dtype=np.float64)


def kkt_residual(sums: NormalEquations, family: str, passive: Marks, gradient: Gradient) -> float:
    """Largest violation of the optimality conditions, relative to |column| |y|, both as the offset leaves them."""
    n, matrix = sums.operators, sums.matrix
    slope = transposed(family, gradient.cells[1:])
    means = transposed(family, matrix[0, 1 : 1 + n])
    level = float(matrix[0, 0])
    length = np.sqrt(np.maximum(_squares(sums, family) - means**2 / level, 0.0))
    target = np.sqrt(max(float(matrix[-1, -1]) - float(matrix[0, -1]) ** 2 / level, 1e-300))
    # A column that the offset explains says nothing: what is left of it is rounding.
    certain = length > 1e-7 * np.sqrt(sums.samples)
    relative = np.where(certain, slope, 0.0) / (np.where(certain, length, 1.0) * target)
    violation = np.where(passive[1 : 1 + n], np.abs(relative), np.maximum(relative, 0.0))
    offset = abs(float(gradient.cells[0])) / (np.sqrt(level) * target)
    return max(float(np.max(violation)), float(offset))


def transposed(family: str, cells: Array) -> Array:
    """T' g: sums over the columns of the parameters from those over cells."""
    if BASIS[family] == SLOPES:
        return cells
    if BASIS[family] == STOPS:
        return np.concatenate([[np.sum(cells)], np.cumsum(cells)[:-1]])
    return np.cumsum(cells[::-1])[::-1]


def _squares(sums: NormalEquations, family: str) -> Array:
    """Squared lengths of the columns of the parameters, (n,): sums over squares of G's corner."""
    n, size = sums.operators, sums.matrix.shape[0]
    diagonal = np.diag(sums.matrix)[1 : 1 + n]
    if BASIS[family] == SLOPES:
        return diagonal
    row = np.arange(1, 1 + n)
    upper = np.zeros(n)
    if n > 1:
        ends = np.column_stack([row * size + row + 1, row * size + 1 + n])[:-1]  # G[i, i + 1:]
        upper[:-1] = np.add.reduceat(sums.matrix.reshape(-1), ends.reshape(-1))[::2]
    tails = np.cumsum((diagonal + 2.0 * upper)[::-1])[::-1]
    if BASIS[family] == WEIGHTS:
        return tails
    lower = np.zeros(n)
    if n > 1:
        ends = np.column_stack([row * size + 1, row * size + row])[1:]  # G[i, :i]
        lower[1:] = np.add.reduceat(sums.matrix.reshape(-1), ends.reshape(-1))[::2]
    return np.concatenate([tails[:1], np.cumsum(diagonal + 2.0 * lower)[:-1]])


STEPS = 2


def polish(
    sums: NormalEquations,
    eps: float,
    knots: Array,
    regularisation: Regularisation,
    estimate: Estimate,
) -> Estimate:
    """Return the estimate after two steps of refinement on its support, if they stay above the bounds."""
    passive = estimate.passive
    if passive is None or estimate.route != NORMAL:
        return estimate
    problem = program("modified-pi", sums, eps, knots, regularisation)
    on = passive.copy()
    on[0] = True
    square = _in_weights(problem, sums.operators)[np.ix_(on, on)]
    scale = 1.0 / np.sqrt(np.diag(square))
    square *= scale[:, None] * scale
    u = estimate.parameters.copy()
    for _ in range(STEPS):
        slope = _gradient(problem, sums, np.diff(knots), regularisation, u)[on]
        try:
            u[on] -= scale * np.linalg.solve(square, scale * slope)
        except np.linalg.LinAlgError:
            return estimate
    if not np.all(u[passive] > problem.lower[passive]) or not np.all(np.isfinite(u)):
        return estimate
    return estimate_of(
        estimate.family,
        sums.operators,
        u,
        estimate.kkt_residual,
        NORMAL,
        estimate.condition,
        passive,
    )


def _in_weights(problem: QuadraticProgram, n: int) -> Array:
    """T'G T + E, (N, N)."""
    square = problem.gram.copy()
    square[1 : 1 + n] = np.cumsum(square[n:0:-1], axis=0)[::-1]
    square[:, 1 : 1 + n] = np.cumsum(square[:, n:0:-1], axis=1)[:, ::-1]
    return square if problem.extra is None else square + problem.extra


def _gradient(
    problem: QuadraticProgram,
    sums: NormalEquations,
    widths: Array,
    regularisation: Regularisation,
    u: Array,
) -> Array:
    """T'(G T u) + E u - h, the last two from the rows that make them."""
    n = sums.operators
    v = u.copy()
    v[1 : 1 + n] = np.cumsum(u[1 : 1 + n])
    slope: Array = problem.gram @ v
    slope[1 : 1 + n] = np.cumsum(slope[n:0:-1])[::-1]
    weights, slopes = u[1 : 1 + n], u[1 + n :]
    bend = np.diff(slopes)
    slope[1 : 1 + n] += sums.samples * regularisation.ridge**2 * weights
    rough = np.zeros_like(slopes)
    rough[1:] += bend
    rough[:-1] -= bend
    slope[1 + n :] += sums.samples * (
        regularisation.smoothing**2 * rough
        + NORMALISATION**2 * float(widths @ (slopes - 1.0)) * widths
    )
    return slope
