"""One family fitted to sums over samples: the program, the route by which it is solved, parameters and predictions.

Two routes lead to the same optimum. Normal equations of the cells (`programs`) need sums only, whatever the number of
samples. Orthogonal factors (`orthogonal`) keep the condition number of the plays where normal equations would square
it; they are taken where the printed condition number exceeds `LARGEST_CONDITION`, or where a pivot vanishes.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

import dehyst._native as _native
from dehyst.arrays import Array
from dehyst.errors import IdentificationError
from dehyst.identification.programs import FAMILIES, MAP_PIECES, Regularisation, program
from dehyst.identification.sums import NormalEquations

__all__ = [
    "FAMILIES",
    "LARGEST_CONDITION",
    "MAP_PIECES",
    "NORMAL",
    "ORTHOGONAL",
    "STATIC",
    "Estimate",
    "Regularisation",
    "fit_family",
    "gain_of",
    "is_high",
    "map_points",
    "mapped",
]

Marks = npt.NDArray[np.bool_]

# The family without memory.
STATIC = "static"
NORMAL, ORTHOGONAL = "normal equations", "orthogonal factors"
# Condition number of the scaled cells beyond which normal equations lose the digits that are promised.
LARGEST_CONDITION = 1e6
# An inverse that amplifies by more than so many times the ratio of the ranges turns noise into steps.
HIGH_GAIN = 20.0
ROUNDING = 1e-9
# Beyond the data the map continues at this slope at most: a saturated end must not explode when extrapolated.
OUTSIDE_SLOPE = 0.5


@dataclass(frozen=True)
class Estimate:
    """Parameters of one fitted family in scaled units.

    Attributes
    ----------
    family
        Which family.
    parameters
        u = [c | parameters of the plays | slopes of the map] of the program.
    offset
        c.
    weights
        Play weights w, (n,), for every family.
    slopes
        Slopes of the output map, (p,), or None.
    stop_weights, stop_slope
        s (n,) and k of the stop form, or None.
    kkt_residual
        Of the quadratic program.
    route, condition
        How it was solved, and the condition number of the scaled cells that carry weight.
    passive
        Which unknowns of the program are off their bound, (N,): where a similar program starts. None by the other
        route.
    """

    family: str
    parameters: Array
    offset: float
    weights: Array
    slopes: Array | None
    stop_weights: Array | None
    stop_slope: float | None
    kkt_residual: float
    route: str = NORMAL
    condition: float = 1.0
    passive: Marks | None = None


def fit_family(
    family: str,
    sums: NormalEquations,
    eps: float,
    knots: Array | None = None,
    regularisation: Regularisation | None = None,
    *,
    fold_ridge: float = 0.0,
    warm: Marks | None = None,
    triangle: Callable[[], Array] | None = None,
) -> Estimate:
    """Solve one family's quadratic program.

    Parameters
    ----------
    family
        One of `FAMILIES`.
    sums
        Sums of [1 | cells | ramps | y]; the ramps only for "modified-pi".
    eps
        Smallest slope right after a reversal, scaled.
    knots
        Knots of the output map, (p + 1,), for "modified-pi".
    regularisation
        For "modified-pi".
    fold_ridge
        Square of the weight of each w_i, over all samples.
    warm
        Unknowns that are expected off their bound, (N,).
    triangle
        Makes the triangular factor of [1 | plays | ramps | y] for the other route; None: there is no other route.
    """
    problem = program(family, sums, eps, knots, regularisation, fold_ridge)
    u, passive, kkt, condition, _, status = _native.solve_bounded(
        problem.gram, problem.rhs, problem.lower, 1, sums.operators, problem.basis,
        problem.extra, problem.extra_rhs, warm, problem.target,
    )  # fmt: skip
    if status == 0 and condition <= LARGEST_CONDITION:
        return estimate_of(family, sums.operators, u, kkt, NORMAL, condition, passive)
    if triangle is None:
        raise _unsolved(sums.operators)
    from dehyst.identification.orthogonal import solve_family  # scipy.optimize takes a third of a second to import

    u, kkt = solve_family(family, triangle(), sums.operators, eps, knots, regularisation, fold_ridge, sums.counted)
    return estimate_of(family, sums.operators, u, kkt, ORTHOGONAL, condition, None)


def _unsolved(operators: int) -> IdentificationError:
    return IdentificationError(
        f"the quadratic program with {operators} weights did not reach its optimum. The operators are too alike "
        f"for this data: identify fewer (--n {max(2, operators // 2)}), or give thresholds that lie further apart.",
        operators=operators,
    )


def estimate_of(
    family: str, n: int, u: Array, kkt: float, route: str, condition: float, passive: Marks | None
) -> Estimate:
    """Parameters of a family from the solution u = [c | plays | slopes of the map] of its program."""
    offset, plays, slopes = float(u[0]), u[1 : 1 + n], u[1 + n :]
    if family == "stop":
        s = plays.copy()
        s[0] = 0.0
        weights = -s
        weights[0] = plays[0] + float(np.sum(s))
        return Estimate(family, u, offset, weights, None, s, float(plays[0]), kkt, route, condition, passive)
    weights = np.diff(plays, prepend=0.0) if family == "pi-cumulative" else plays
    return Estimate(
        family, u, offset, weights, slopes if slopes.size else None, None, None, kkt, route, condition, passive
    )


def gain_of(estimate: Estimate) -> float:
    """Largest slope of the inverse, scaled: ratios of the ranges."""
    if estimate.family == STATIC:
        return 1.0 / float(np.min(estimate.parameters[1:]))
    steepest = 1.0 if estimate.slopes is None else max(float(np.max(estimate.slopes)), OUTSIDE_SLOPE)
    return steepest / max(float(np.min(np.cumsum(estimate.weights))), 1e-300)


def is_high(gain: float) -> bool:
    """Whether an inverse amplifies too much, in ratios of the ranges."""
    return gain > HIGH_GAIN * (1.0 + ROUNDING)


def map_points(knots: Array, slopes: Array) -> tuple[Array, Array]:
    """Breakpoints u = T(y) and values y of the output map, one range beyond the data at each end.

    Examples
    --------
    >>> u, y = map_points(np.array([-1.0, 0.0, 1.0]), np.array([1.0, 1.0]))
    >>> u.tolist()
    [-3.0, -1.0, 0.0, 1.0, 3.0]
    """
    # T is normalised like y: its first knot stands for y's, since the offset is free.
    u = knots[0] + np.concatenate([[0.0], np.cumsum(slopes * np.diff(knots))])
    span = float(knots[-1] - knots[0])
    below = u[0] - span * max(float(slopes[0]), OUTSIDE_SLOPE)
    above = u[-1] + span * max(float(slopes[-1]), OUTSIDE_SLOPE)
    return (
        np.concatenate([[below], u, [above]]),
        np.concatenate([[knots[0] - span], knots, [knots[-1] + span]]),
    )


def mapped(estimate: Estimate, u: Array, knots: Array | None) -> Array:
    """Scaled output for outputs u = c + sum w_i z_i of the operators, (m,)."""
    if estimate.slopes is None or knots is None:
        return u
    points, values = map_points(knots, estimate.slopes)
    # T(y) was fitted from its first knot on: c + H w = T(y) - T(k_0); shift to the breakpoints' origin.
    return continued(u + knots[0], points, values)


def continued(u: Array, points: Array, values: Array) -> Array:
    """Piecewise linear interpolation, continued along the end segments."""
    inside = np.interp(u, points, values)
    low = values[0] + (u - points[0]) * (values[1] - values[0]) / (points[1] - points[0])
    high = values[-1] + (u - points[-1]) * (values[-1] - values[-2]) / (points[-1] - points[-2])
    result: Array = np.where(u < points[0], low, np.where(u > points[-1], high, inside))
    return result
