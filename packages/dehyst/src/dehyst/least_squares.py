"""Bounded least squares: QR reduction, an active set, then a solution on the positive weights.

    minimise |F a + P w - b|^2   subject to   w >= lower,   a free

QR keeps the conditioning of the regressors (normal equations would square it), and an active set method
returns exact zeros, which interior-point and first-order solvers do not. The set of normal equations is taken if the
solution on it is optimal; Lawson and Hanson's method on orthogonal factors is there for where it is not.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import dehyst._native as _native
from dehyst.arrays import Array
from dehyst.errors import IdentificationError

NOTHING_LEFT = 1e-10
NO_EFFECT = 1e-12
# Free columns are dependent where less than this share of the longest is left of one; they are then held, at no price
# that could be measured, by rows of this share of it.
DEPENDENT, HELD = 1e-10, 1e-7
ROWS = 8192  # that are reduced at a time: they stay in the cache
OPTIMAL = 1e-13  # violation of the conditions, relative, that rounding leaves
# A column whose slope is less than this share of |column| |target| does not join: only rounding tells it from zero.
NO_SLOPE = 1e-15
# Most exchanges: 30 for each column, as others take, and some for few columns. Real programs need about one or two.
EXCHANGES, EXCHANGES_AT_LEAST = 30, 100
SMALLEST = 1e-300  # that a share is divided by, where a weight stands still at zero


@dataclass(frozen=True, slots=True)
class Solution:
    """Minimiser and its proof."""

    free: Array  # a, the unbounded unknowns
    bounded: Array  # w, (n,), exactly at its lower bound where the bound is active
    kkt_residual: float  # Largest violation of the optimality conditions, relative to |column| |b|


def triangle(rows: Array) -> Array:
    """Triangular factor R (m, m) of rows (T, m): the same least-squares problem in m equations."""
    reduced = rows[:ROWS]
    for begin in range(ROWS, rows.shape[0], ROWS):
        reduced = np.vstack([np.linalg.qr(reduced, mode="r"), rows[begin : begin + ROWS]])
    return np.asarray(np.linalg.qr(reduced, mode="r"), dtype=np.float64)


def solve_bounded(system: Array, free: int, lower: Array) -> Solution:
    """Solve the problem for `system` = [F | P | b] with `free` columns in F.

    Parameters
    ----------
    system
        Rows or their triangular factor, (T, free + n + 1).
    free
        Number of unbounded unknowns, whose columns come first. Of dependent ones the smallest solution is taken.
    lower
        Lower bounds of w, (n,).

    Examples
    --------
    >>> rows = np.array([[1.0, 0.0, 1.0], [0.0, 1.0, -1.0]])
    >>> solve_bounded(rows, 0, np.zeros(2)).bounded.tolist()
    [1.0, 0.0]
    """
    reduced = system.shape[0] <= system.shape[1] and not np.any(np.tril(system[:, :free], -1))
    # The free unknowns are eliminated by rows of their own: nothing of them may be left below these.
    r = system
    if not reduced:
        r = triangle(system)
    n = lower.size
    # With fewer equations than unknowns the missing rows are zero.
    if r.shape[0] < system.shape[1]:
        r = np.vstack([r, np.zeros((system.shape[1] - r.shape[0], system.shape[1]))])
    if free:
        r = _held(r, free)
    inner, target = r[free:, free : free + n], r[free:, -1]
    shifted = target - inner @ lower
    # Columns of like length make the active set's choices independent of units. What is left of a column that the
    # free ones explain is rounding: it says nothing, and its weight stays at the bound.
    lengths = np.linalg.norm(inner, axis=0)
    inner = np.where(
        lengths > NOTHING_LEFT * np.linalg.norm(r[:, free : free + n], axis=0), inner, 0.0
    )
    scale = np.where(lengths > 0, lengths, 1.0)
    w = lower + _polish(inner, shifted, _active(inner / scale, shifted) / scale)
    if not _kkt_residual(inner, target, w, lower) <= OPTIMAL:
        w = lower + _polish(inner, shifted, _nonnegative(inner / scale, shifted) / scale)
    right = r[:free, -1] - r[:free, free : free + n] @ w
    a = right
    if free:
        a = np.asarray(np.linalg.solve(r[:free, :free], right))
    return Solution(a, w, _kkt_residual(inner, target, w, lower))


def _active(columns: Array, target: Array) -> Array:
    """Weights >= 0 by normal equations: enough to know which of them are not 0."""
    lower, norm = np.zeros(columns.shape[1]), max(float(np.linalg.norm(target)), 1e-150)
    return _native.solve_bounded(
        columns.T @ columns, columns.T @ target, lower, 0, 0, _native.WEIGHTS, target_norm=norm
    )[0]


def _nonnegative(columns: Array, target: Array) -> Array:
    """Weights >= 0 by orthogonal factors."""
    weights = lawson_hanson(columns, target)
    if weights is None:
        raise unsolved(columns.shape[1])
    return weights


def lawson_hanson(columns: Array, target: Array) -> Array | None:
    """Weights >= 0 that minimise ``|columns @ w - target|``, by orthogonal factors; None if the exchanges do not end.

    In each exchange the column that reduces the error fastest gets a positive weight, and columns whose weights would
    become negative get 0: C. L. Lawson, R. J. Hanson, "Solving Least Squares Problems", 1974, chapter 23.

    Examples
    --------
    >>> lawson_hanson(np.array([[1.0, 1.0], [0.0, 1.0]]), np.array([2.0, -1.0])).tolist()
    [2.0, 0.0]
    """
    size = columns.shape[1]
    rounding = NO_SLOPE * np.linalg.norm(columns, axis=0) * float(np.linalg.norm(target))
    weights = np.zeros(size)
    positive: list[int] = []
    for _ in range(EXCHANGES * size + EXCHANGES_AT_LEAST):
        slope = columns.T @ (target - columns @ weights) - rounding
        slope[positive] = 0.0
        steepest_first = np.argsort(-slope)[: int(np.count_nonzero(slope > 0.0))].tolist()
        joining = next((k for k in steepest_first if _joins(columns, target, [*positive, k])), None)
        if joining is None:
            return weights
        positive.append(joining)
        weights = _without_negative(columns, target, weights, positive)
    return None


def _joins(columns: Array, target: Array, positive: list[int]) -> bool:
    """Whether the last of these columns adds to the others, and its weight would be above zero."""
    last = columns[:, positive[-1]]
    if len(positive) > columns.shape[0]:
        return False
    q, r = np.linalg.qr(columns[:, positive])
    new = float(r[-1, -1])
    return (
        abs(new) > NOTHING_LEFT * float(np.linalg.norm(last))
        and float(q[:, -1] @ target) / new > 0.0
    )


def _without_negative(columns: Array, target: Array, weights: Array, positive: list[int]) -> Array:
    """Weights of the least squares on the positive columns; on the way there those that reach zero leave the list."""
    weights = weights.copy()
    while positive:
        q, r = np.linalg.qr(columns[:, positive])
        goal = np.linalg.solve(r, q.T @ target)
        if np.all(goal > 0.0):
            weights[positive] = goal
            break
        before = weights[positive]
        way = np.where(goal > 0.0, np.inf, before / np.maximum(before - goal, SMALLEST))
        first = int(np.argmin(way))
        weights[positive] = before + way[first] * (goal - before)
        weights[positive[first]] = 0.0
        del positive[first]
    return weights


def unsolved(n: int) -> IdentificationError:
    """Return the error that says that an active set did not end."""
    return IdentificationError(
        f"the quadratic program with {n} weights did not reach its optimum. The operators are too alike for this "
        f"data: identify fewer (--n {max(2, n // 2)}), or give thresholds that lie further apart.",
        operators=n,
    )


def _held(r: Array, free: int) -> Array:
    """The same equations, with rows that hold the free unknowns if these are not determined: a constant twice, say."""
    longest = float(np.max(np.linalg.norm(r[:, :free], axis=0)))
    if np.abs(np.diag(r)[:free]).min() > DEPENDENT * longest:
        return r
    # Columns of nothing but zeros have no length that could scale the new rows.
    weight = 1.0
    if longest > 0.0:
        weight = HELD * longest
    rows = np.zeros((free, r.shape[1]))
    rows[:, :free] = np.eye(free) * weight
    return triangle(np.vstack([r, rows]))


def _polish(inner: Array, target: Array, v: Array) -> Array:
    """Solve once more on the support by orthogonal factorisation; keep it if it stays feasible.

    Weights that change nothing above rounding leave the support: they are zeros that rounding has hidden.
    """
    effect = v * np.linalg.norm(inner, axis=0)
    support = np.flatnonzero(effect > NO_EFFECT * np.linalg.norm(target))
    if support.size == 0:
        return v
    q, r = np.linalg.qr(inner[:, support])
    diagonal = np.abs(np.diag(r))
    if diagonal.min() <= 1e-13 * diagonal.max():
        return v
    better = np.zeros_like(v)
    better[support] = np.linalg.solve(r, q.T @ target)
    if np.all(better[support] > 0):
        return better
    return v


def _kkt_residual(inner: Array, target: Array, w: Array, lower: Array) -> float:
    gradient = inner.T @ (inner @ w - target)
    scale = np.linalg.norm(inner, axis=0) * max(float(np.linalg.norm(target)), 1e-300)
    relative = np.where(scale > 0, gradient / np.where(scale > 0, scale, 1.0), 0.0)
    violation = np.where(w > lower, np.abs(relative), np.maximum(-relative, 0.0))
    return float(np.max(violation, initial=0.0))
