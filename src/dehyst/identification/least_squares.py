"""Bounded least squares: QR reduction, an active set, then a solution on the positive weights.

    minimise |F a + P w - b|^2   subject to   w >= lower,   a free

QR keeps the conditioning of the regressors (normal equations would square it), and an active set method
returns exact zeros, which interior-point and first-order solvers do not. The set of normal equations is taken if the
solution on it is optimal; SciPy's method, whose import takes longer than all that, is there for where it is not.
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


@dataclass(frozen=True, slots=True)
class Solution:
    """Minimiser and its proof."""

    free: Array  # a, the unbounded unknowns
    bounded: Array  # w, (n,), exactly at its lower bound where the bound is active
    kkt_residual: float  # Largest violation of the optimality conditions, relative to |column| |b|


def triangle(rows: Array) -> Array:
    """Triangular factor R (m, m) of rows (T, m): the same least-squares problem in m equations."""
    kept = rows[:ROWS]
    for begin in range(ROWS, rows.shape[0], ROWS):
        kept = np.vstack([np.linalg.qr(kept, mode="r"), rows[begin : begin + ROWS]])
    return np.asarray(np.linalg.qr(kept, mode="r"), dtype=np.float64)


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
    r = system if reduced else triangle(system)  # below the free unknowns' own rows nothing of them may be left
    n = lower.size
    if r.shape[0] < system.shape[1]:  # fewer equations than unknowns: the missing rows are zero
        r = np.vstack([r, np.zeros((system.shape[1] - r.shape[0], system.shape[1]))])
    if free:
        r = _held(r, free)
    inner, target = r[free:, free : free + n], r[free:, -1]
    shifted = target - inner @ lower
    # Columns of like length make the active set's choices independent of units. What is left of a column that the
    # free ones explain is rounding: it says nothing, and its weight stays at the bound.
    lengths = np.linalg.norm(inner, axis=0)
    inner = np.where(lengths > NOTHING_LEFT * np.linalg.norm(r[:, free : free + n], axis=0), inner, 0.0)
    scale = np.where(lengths > 0, lengths, 1.0)
    w = lower + _polish(inner, shifted, _active(inner / scale, shifted) / scale)
    if not _kkt_residual(inner, target, w, lower) <= OPTIMAL:
        w = lower + _polish(inner, shifted, _nonnegative(inner / scale, shifted) / scale)
    right = r[:free, -1] - r[:free, free : free + n] @ w
    a = np.asarray(np.linalg.solve(r[:free, :free], right)) if free else right
    return Solution(a, w, _kkt_residual(inner, target, w, lower))


def _active(columns: Array, target: Array) -> Array:
    """Weights >= 0 by normal equations: enough to know which of them are not 0."""
    lower, norm = np.zeros(columns.shape[1]), max(float(np.linalg.norm(target)), 1e-150)
    return _native.solve_bounded(
        columns.T @ columns, columns.T @ target, lower, 0, 0, _native.WEIGHTS, target_norm=norm
    )[0]


def _nonnegative(columns: Array, target: Array) -> Array:
    """Weights >= 0 by orthogonal factors."""
    from scipy.optimize import nnls

    n = columns.shape[1]
    try:
        weights: Array = nnls(columns, target, maxiter=30 * n + 100)[0]
    except RuntimeError as fault:
        raise unsolved(n, f" ({fault})") from None
    return weights


def unsolved(n: int, why: str = "") -> IdentificationError:
    """Return the error that says that an active set did not end."""
    return IdentificationError(
        f"the quadratic program with {n} weights did not reach its optimum{why}. The operators are too alike for this "
        f"data: identify fewer (--n {max(2, n // 2)}), or give thresholds that lie further apart.",
        operators=n,
    )


def _held(r: Array, free: int) -> Array:
    """The same equations, with rows that hold the free unknowns if these are not determined: a constant twice, say."""
    longest = float(np.max(np.linalg.norm(r[:, :free], axis=0)))
    if np.abs(np.diag(r)[:free]).min() > DEPENDENT * longest:
        return r
    rows = np.zeros((free, r.shape[1]))
    rows[:, :free] = np.eye(free) * (HELD * longest if longest > 0.0 else 1.0)
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
    return better if np.all(better[support] > 0) else v


def _kkt_residual(inner: Array, target: Array, w: Array, lower: Array) -> float:
    gradient = inner.T @ (inner @ w - target)
    scale = np.linalg.norm(inner, axis=0) * max(float(np.linalg.norm(target)), 1e-300)
    relative = np.where(scale > 0, gradient / np.where(scale > 0, scale, 1.0), 0.0)
    violation = np.where(w > lower, np.abs(relative), np.maximum(-relative, 0.0))
    return float(np.max(violation, initial=0.0))
