"""Refinement of the modified model on its normal equations.

The row that fixes the mean slope of the map weighs a million times as much as a sample, and its square hides six digits
of the rest. Here the gradient is formed from the row itself, whose residual is small, so that they come back.
"""

from __future__ import annotations

import numpy as np

from dehyst.arrays import Array
from dehyst.identification.families import NORMAL, Estimate, estimate_of
from dehyst.identification.programs import NORMALISATION, Program, Regularisation, program
from dehyst.identification.sums import NormalEquations

STEPS = 2


def polish(
    sums: NormalEquations, eps: float, knots: Array, regularisation: Regularisation, estimate: Estimate
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
    return estimate_of(estimate.family, sums.operators, u, estimate.kkt_residual, NORMAL, estimate.condition, passive)


def _in_weights(problem: Program, n: int) -> Array:
    """T'G T + E, (N, N)."""
    square = problem.gram.copy()
    square[1 : 1 + n] = np.cumsum(square[n:0:-1], axis=0)[::-1]
    square[:, 1 : 1 + n] = np.cumsum(square[:, n:0:-1], axis=1)[:, ::-1]
    return square if problem.extra is None else square + problem.extra


def _gradient(
    problem: Program, sums: NormalEquations, widths: Array, regularisation: Regularisation, u: Array
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
        regularisation.smoothing**2 * rough + NORMALISATION**2 * float(widths @ (slopes - 1.0)) * widths
    )
    return slope
