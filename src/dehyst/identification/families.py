"""The four families as constrained least squares on one reduced system [1 | plays | ramps | y].

Each family is a linear change of the play columns:

    pi              y = c + sum w_i z_i,                    w_1 >= eps, w_i >= 0
    pi-cumulative   y = c + sum S_i (z_i - z_{i+1}),        S_i = w_1 + ... + w_i >= eps
    stop            y = c + k x + sum_{i>=2} s_i (x - z_i), k >= eps, s_i >= 0
    modified-pi     T(y) = c + sum w_i z_i,                 w as in pi, T rising piecewise linear

Scaled units throughout: input and output span [-1, 1] over the training part, so eps is relative to the ratio
of the ranges.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from dehyst.identification.least_squares import Solution, solve_bounded

Array = npt.NDArray[np.float64]

FAMILIES = ("pi", "pi-cumulative", "modified-pi", "stop")

# Output map of the modified model. Slopes below 0.05 would let the inverse's gain explode where the loop
# saturates; 20 pieces resolve every measured saturation; the mean slope is 1, which fixes the scale of w.
MAP_PIECES = 20
SMALLEST_SLOPE = 0.05
# Weight of the normalisation row against the rms of a sample's residual: the scale is met to 1e-6.
NORMALISATION = 1e3
# Beyond the data the map continues at this slope at most: a saturated end must not explode when extrapolated.
OUTSIDE_SLOPE = 0.5


@dataclass(frozen=True, slots=True)
class Regularisation:
    """How strongly the modified model is smoothed, relative to the rms of the scaled output.

    Attributes
    ----------
    smoothing
        Weight of differences of successive slopes of the map.
    ridge
        Weight of each play weight.
    """

    smoothing: float
    ridge: float


@dataclass(frozen=True)
class Estimate:
    """Parameters of one fitted family in scaled units.

    Attributes
    ----------
    family
        Which family.
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
    """

    family: str
    offset: float
    weights: Array
    slopes: Array | None
    stop_weights: Array | None
    stop_slope: float | None
    kkt_residual: float


def fit_family(
    family: str,
    system: Array,
    operators: int,
    eps: float,
    knots: Array | None = None,
    regularisation: Regularisation | None = None,
) -> Estimate:
    """Solve one family's quadratic program.

    Parameters
    ----------
    family
        One of `FAMILIES`.
    system
        Triangular factor of [1 | plays | ramps | y]; the ramps only for "modified-pi".
    operators
        n, number of play columns.
    eps
        Smallest slope right after a reversal, scaled.
    knots
        Knots of the output map, (p + 1,), for "modified-pi".
    regularisation
        For "modified-pi".
    """
    one, plays, y = system[:, :1], system[:, 1 : 1 + operators], system[:, -1:]
    if family == "pi":
        solution = solve_bounded(np.hstack([one, plays, y]), 1, _first(operators, eps))
        return _estimate(family, solution, solution.bounded)
    if family == "pi-cumulative":
        differences = plays.copy()
        differences[:, :-1] -= plays[:, 1:]
        solution = solve_bounded(np.hstack([one, differences, y]), 1, np.full(operators, eps))
        return _estimate(family, solution, np.diff(solution.bounded, prepend=0.0))
    if family == "stop":
        stops = plays[:, :1] - plays
        stops[:, 0] = plays[:, 0]
        solution = solve_bounded(np.hstack([one, stops, y]), 1, _first(operators, eps))
        return _stop_estimate(solution)
    if knots is None or regularisation is None:
        raise AssertionError("the modified model needs knots and a regularisation")  # the caller gives them
    return _fit_modified(system, operators, eps, knots, regularisation)


def _first(operators: int, eps: float) -> Array:
    lower = np.zeros(operators)
    lower[0] = eps
    return lower


def _estimate(family: str, solution: Solution, weights: Array, slopes: Array | None = None) -> Estimate:
    return Estimate(family, float(solution.free[0]), weights, slopes, None, None, solution.kkt_residual)


def _stop_estimate(solution: Solution) -> Estimate:
    slope = float(solution.bounded[0])
    s = solution.bounded.copy()
    s[0] = 0.0
    weights = -s
    weights[0] = slope + float(np.sum(s))
    return Estimate("stop", float(solution.free[0]), weights, None, s, slope, solution.kkt_residual)


def _fit_modified(system: Array, operators: int, eps: float, knots: Array, regularisation: Regularisation) -> Estimate:
    """minimise |c + H w - T(y)|^2 + smoothing + ridge, T's mean slope 1.

    The residual stands in the operator's output, where it is linear in all unknowns: a quadratic program.
    """
    pieces = knots.size - 1
    widths = np.diff(knots)
    n = operators + pieces
    one, plays, ramp = system[:, :1], system[:, 1 : 1 + operators], system[:, 1 + operators : 1 + n]
    samples = float(np.linalg.norm(one))  # sqrt of the number of rows: QR keeps column lengths
    zero = np.zeros((system.shape[0], 1))
    extra = np.zeros((1 + (pieces - 1) + operators, 1 + n + 1))
    extra[0, 1 + operators : 1 + n] = NORMALISATION * samples * widths
    extra[0, -1] = NORMALISATION * samples * float(np.sum(widths))
    rows = 1 + np.arange(pieces - 1)
    first = 1 + operators + np.arange(pieces - 1)
    extra[rows, first] = -regularisation.smoothing * samples
    extra[rows, first + 1] = regularisation.smoothing * samples
    diagonal = np.arange(operators)
    extra[pieces + diagonal, 1 + diagonal] = regularisation.ridge * samples
    whole = np.vstack([np.hstack([one, plays, -ramp, zero]), extra])
    lower = np.concatenate([_first(operators, eps), np.full(pieces, SMALLEST_SLOPE)])
    solution = solve_bounded(whole, 1, lower)
    return _estimate("modified-pi", solution, solution.bounded[:operators], solution.bounded[operators:])


def residual_norm(estimate: Estimate, system: Array) -> float:
    """Norm of what is left of the reduced system, in the coordinates of the program."""
    n = estimate.weights.size
    left: Array = estimate.offset * system[:, 0] + system[:, 1 : 1 + n] @ estimate.weights
    if estimate.slopes is None:
        left = left - system[:, -1]
    else:
        left = left - system[:, 1 + n : 1 + n + estimate.slopes.size] @ estimate.slopes
    return float(np.linalg.norm(left))


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


def predict(estimate: Estimate, plays: Array, knots: Array | None) -> Array:
    """Scaled output for play outputs (m, n)."""
    u: Array = estimate.offset + plays @ estimate.weights
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
