"""Families of play operators as quadratic programs on their normal equations.

    minimise 1/2 v'G v - g'v + 1/2 u'E u - h'u,   v = T u,   u_i >= lower_i

with u the parameters of the family and v what multiplies the columns [1 | cells | -ramps]:

    pi              y = c + sum w_i z_i,                    w_1 >= eps, w_i >= 0
    pi-cumulative   y = c + sum S_i (z_i - z_{i+1}),        S_i = w_1 + ... + w_i >= eps
    stop            y = c + k x + sum_{i>=2} s_i (x - z_i), k >= eps, s_i >= 0
    modified-pi     T(y) = c + sum w_i z_i,                 w as in pi, T rising piecewise linear

Scaled units throughout: input and output span [-1, 1] over the training part, so eps is relative to the ratio
of the ranges.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import numpy.typing as npt

import dehyst._native as _native
from dehyst.arrays import Array
from dehyst.identification._data import DataSet, Piece
from dehyst.identification._regressors import TRACE, NormalEquations, PlayBank, blocks, ramp_columns
from dehyst.least_squares import solve_bounded, triangle, unsolved
from dehyst.models import (
    HysteresisModel,
    ModelCard,
    ModifiedPrandtlIshlinskii,
    MonotoneMap,
    PrandtlIshlinskii,
    StopOperatorModel,
)
from dehyst.models import kit as models_kit

FAMILIES = ("pi", "pi-cumulative", "modified-pi", "stop")
BASIS = {
    "pi": _native.WEIGHTS,
    "pi-cumulative": _native.SLOPES,
    "modified-pi": _native.WEIGHTS,
    "stop": _native.STOPS,
}

# Output map of the modified model. Slopes below 0.05 would let the inverse's gain explode where the loop
# saturates; 20 pieces resolve every measured saturation; the mean slope is 1, which fixes the scale of w.
MAP_PIECES = 20
SMALLEST_SLOPE = 0.05
# Weight of the normalisation row against the rms of a sample's residual: the scale is met to 1e-6.
NORMALISATION = 1e3


@dataclass(frozen=True, slots=True)
class Regularisation:
    """How strongly the modified model is smoothed, relative to the rms of the scaled output."""

    smoothing: float  # Weight of differences of successive slopes of the map
    ridge: float  # Weight of each play weight


@dataclass(frozen=True)
class QuadraticProgram:
    """One quadratic program, ready for the engine."""

    basis: int  # What the unknowns of the plays are: slopes, weights or stops
    # gram, rhs: G (N, N) and g (N,) of the columns [1 | cells | -ramps]
    gram: Array
    rhs: Array
    lower: Array  # Bounds (N,); that of the offset, which comes first, is ignored
    # extra, extra_rhs: E (N, N) and h (N,), or None
    extra: Array | None
    extra_rhs: Array | None
    target: float  # |y| of the least squares behind it


def lower_bounds(family: str, operators: int, eps: float, pieces: int = 0) -> Array:
    """Bounds of the parameters without the offset: plays, then slopes of the output map."""
    lower = np.zeros(operators + pieces)
    lower[:operators] = eps if family == "pi-cumulative" else 0.0
    lower[0] = eps
    lower[operators:] = SMALLEST_SLOPE
    return lower


def program(
    family: str,
    sums: NormalEquations,
    eps: float,
    knots: Array | None = None,
    regularisation: Regularisation | None = None,
    fold_ridge: float = 0.0,
) -> QuadraticProgram:
    """State one family's program; `fold_ridge`: weight of each w_i, squared and times the number of samples."""
    n, matrix = sums.operators, sums.matrix
    if family != "modified-pi":
        rhs, target = matrix[: 1 + n, -1].copy(), float(np.sqrt(matrix[-1, -1]))
        lower = np.concatenate([[0.0], lower_bounds(family, n, eps)])
        extra = fold_ridge * unit_ridge(family, n) if fold_ridge else None
        gram = np.ascontiguousarray(matrix[: 1 + n, : 1 + n])
        return QuadraticProgram(BASIS[family], gram, rhs, lower, extra, None, target)
    if knots is None or regularisation is None:
        raise AssertionError(
            "the modified model needs knots and a regularisation"
        )  # the caller gives them
    widths = np.diff(knots)
    size = 1 + n + widths.size
    gram = np.array(matrix[:size, :size])
    gram[1 + n :, : 1 + n] *= -1.0
    gram[: 1 + n, 1 + n :] *= -1.0
    extra = sums.samples * _smoothing(regularisation, n, tuple(widths.tolist()))
    extra[1 : 1 + n, 1 : 1 + n] += fold_ridge * np.eye(n)
    extra_rhs = np.zeros(size)
    extra_rhs[1 + n :] = NORMALISATION**2 * sums.samples * float(np.sum(widths)) * widths
    target = NORMALISATION * float(np.sqrt(sums.samples) * np.sum(widths))
    lower = np.concatenate([[0.0], lower_bounds(family, n, eps, widths.size)])
    return QuadraticProgram(BASIS[family], gram, np.zeros(size), lower, extra, extra_rhs, target)


def smoothing_rows(regularisation: Regularisation, n: int, widths: Array) -> tuple[Array, Array]:
    """Rows (p + n, 1 + n + p) and right-hand sides beside one sample: mean slope 1, differences of slopes, weights."""
    pieces = widths.size
    rows, rhs = np.zeros((pieces + n, 1 + n + pieces)), np.zeros(pieces + n)
    rows[0, 1 + n :] = NORMALISATION * widths
    rhs[0] = NORMALISATION * float(np.sum(widths))
    k = np.arange(pieces - 1)
    rows[1 + k, 1 + n + k] = -regularisation.smoothing
    rows[1 + k, 2 + n + k] = regularisation.smoothing
    diagonal = np.arange(n)
    rows[pieces + diagonal, 1 + diagonal] = regularisation.ridge
    return rows, rhs


@lru_cache(maxsize=16)
def _smoothing(regularisation: Regularisation, n: int, widths: tuple[float, ...]) -> Array:
    rows, _ = smoothing_rows(regularisation, n, np.array(widths))
    product: Array = rows.T @ rows
    product.flags.writeable = False
    return product


@lru_cache(maxsize=8)
def unit_ridge(family: str, n: int) -> Array:
    """Matrix (1 + n, 1 + n) of sum w_i^2 in the parameters of a family."""
    weights = np.eye(n)
    if family == "pi-cumulative":
        weights -= np.eye(n, k=-1)
    elif family == "stop":
        weights = -np.eye(n)
        weights[0] = 1.0
    ridge = np.zeros((1 + n, 1 + n))
    ridge[1:, 1:] = weights.T @ weights
    ridge.flags.writeable = False
    return ridge


Marks = npt.NDArray[np.bool_]

# The family without memory.
STATIC = "static"
NORMAL, ORTHOGONAL = "normal equations", "orthogonal factors"
# Condition number of the scaled cells beyond which normal equations lose the digits that are promised.
LARGEST_CONDITION = 1e6
ROUNDING = 1e-9
# Beyond the data the map continues at this slope at most: a saturated end must not explode when extrapolated.
OUTSIDE_SLOPE = 0.5


@dataclass(frozen=True)
class Estimate:
    """Parameters of one fitted family in scaled units."""

    family: str  # Which family
    parameters: Array  # u = [c | parameters of the plays | slopes of the map] of the program
    offset: float  # c
    weights: Array  # Play weights w, (n,), for every family
    slopes: Array | None  # Slopes of the output map, (p,), or None
    # stop_weights, stop_slope: s (n,) and k of the stop form, or None
    stop_weights: Array | None
    stop_slope: float | None
    kkt_residual: float  # Of the quadratic program
    # route, condition: How it was solved, and the condition number of the scaled cells that carry weight
    route: str = NORMAL
    condition: float = 1.0
    # Which unknowns of the program are off their bound, (N,): where a similar program starts. None by the other route.
    passive: Marks | None = None
    # Breakpoints of the curve without memory, increasing, (p + 1,); None for what has plays
    breakpoints: Array | None = None


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

    Two routes lead to the same optimum. Normal equations of the cells need sums only, whatever the number of samples.
    Orthogonal factors keep the condition number of the plays where normal equations would square it; they are taken
    where the printed condition number exceeds `LARGEST_CONDITION`, or where a pivot vanishes.

    Parameters
    ----------
    sums
        Sums of [1 | cells | ramps | y]; the ramps only for "modified-pi", as `knots` (p + 1,) and `regularisation`.
    eps
        Smallest slope right after a reversal, scaled.
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
        raise unsolved(sums.operators)
    u, kkt = solve_family(
        family, triangle(), sums.operators, eps, knots, regularisation, fold_ridge, sums.counted
    )
    return estimate_of(family, sums.operators, u, kkt, ORTHOGONAL, condition, None)


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
        return Estimate(
            family, u, offset, weights, None, s, float(plays[0]), kkt, route, condition, passive
        )
    weights = np.diff(plays, prepend=0.0) if family == "pi-cumulative" else plays
    return Estimate(
        family,
        u,
        offset,
        weights,
        slopes if slopes.size else None,
        None,
        None,
        kkt,
        route,
        condition,
        passive,
    )


def gain_of(estimate: Estimate) -> float:
    """Largest slope of the inverse, scaled: ratios of the ranges."""
    if estimate.family == STATIC and estimate.slopes is not None:
        return 1.0 / float(np.min(estimate.slopes))
    steepest = (
        1.0 if estimate.slopes is None else max(float(np.max(estimate.slopes)), OUTSIDE_SLOPE)
    )
    return steepest / max(float(np.min(np.cumsum(estimate.weights))), 1e-300)


def is_high(gain: float) -> bool:
    """Whether an inverse amplifies too much, in ratios of the ranges."""
    return gain > models_kit.POLICY.high_gain * (1.0 + ROUNDING)


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


# Rows that are reduced at once: 1024 x 120 doubles, 1 MB, stay in the processor's cache, where the triangular
# factor takes a quarter of the time of 8192 rows.
CHUNK = 1024


def solve_family(
    family: str,
    system: Array,
    operators: int,
    eps: float,
    knots: Array | None = None,
    regularisation: Regularisation | None = None,
    fold_ridge: float = 0.0,
    samples: float | None = None,
) -> tuple[Array, float]:
    """Parameters u = [c | plays | slopes of the map] and KKT residual of one family's program, from orthogonal factors.

    `system` is the triangular factor of [1 | plays | ramps | y]; `samples` the number of rows behind it, None where its
    first column tells. This route costs T n^2 operations instead of T.
    """
    # QR keeps column lengths.
    length = float(np.linalg.norm(system[:, :1])) if samples is None else float(np.sqrt(samples))
    if fold_ridge:
        ridge = np.zeros((operators, system.shape[1]))
        ridge[np.arange(operators), 1 + np.arange(operators)] = np.sqrt(fold_ridge)
        system = np.vstack([system, ridge])
    one, plays, y = system[:, :1], system[:, 1 : 1 + operators], system[:, -1:]
    if family == "modified-pi":
        if knots is None or regularisation is None:
            raise AssertionError(
                "the modified model needs knots and a regularisation"
            )  # the caller gives them
        rows, rhs = smoothing_rows(regularisation, operators, np.diff(knots))
        ramp = system[:, 1 + operators : operators + knots.size]
        data = np.hstack([one, plays, -ramp, np.zeros((system.shape[0], 1))])
        system = np.vstack([data, length * np.column_stack([rows, rhs])])
    elif family == "pi-cumulative":
        differences = plays.copy()
        differences[:, :-1] -= plays[:, 1:]
        system = np.hstack([one, differences, y])
    elif family == "stop":
        stops = plays[:, :1] - plays
        stops[:, 0] = plays[:, 0]
        system = np.hstack([one, stops, y])
    else:
        system = np.hstack([one, plays, y])
    solution = solve_bounded(
        system, 1, lower_bounds(family, operators, eps, system.shape[1] - 2 - operators)
    )
    return np.concatenate([solution.free, solution.bounded]), solution.kkt_residual


def reduce(
    data: DataSet,
    bank: PlayBank,
    knots: Array | None = None,
    span: Callable[[Piece], slice] | None = None,
) -> Array:
    """Triangular factor of [1 | plays | ramps | y] over the fitted samples, or another span, in constant memory."""
    factor: Array | None = None
    size = max(CHUNK, 2 * bank.thresholds.size)  # fewer rows than columns would not reduce anything
    for piece, state in zip(data.pieces, bank.states, strict=True):
        chosen = piece.fitted(bank.initial_state) if span is None else span(piece)
        own = piece.unknown_level(bank.initial_state) is not None
        before, factor = factor, None if own else factor
        for part, plays in blocks(piece.x, bank.thresholds, state, chosen, size):
            y = piece.y[part]
            ramps = [] if knots is None else [ramp_columns(y, knots).T]
            block = np.hstack([np.ones((y.size, 1)), plays, *ramps, y[:, None]])
            if piece.weight is not None:
                block *= np.sqrt(piece.weight[part])[:, None]
            factor = triangle(block if factor is None else np.vstack([factor, block]))
        if own and factor is not None:
            factor[0] *= np.sqrt(TRACE)  # the row of the means
        if own and before is not None:
            factor = before if factor is None else triangle(np.vstack([before, factor]))
    if factor is None:
        raise AssertionError("no rows to fit")  # the caller has checked
    return factor


def build_model(
    estimate: Estimate, data: DataSet, bank: PlayBank, knots: Array | None, card: ModelCard
) -> HysteresisModel:
    """Return the fitted model, its zero weights pruned (which is exact), starting where the log starts."""
    a, b = data.half_range, data.amplitude
    keep = estimate.weights != 0.0
    keep[0] = True
    thresholds = bank.thresholds[keep] * a
    state = bank.states[0][keep] * a
    if estimate.stop_weights is not None and estimate.stop_slope is not None:
        gain = data.trend * b / a
        return StopOperatorModel(
            thresholds,
            estimate.stop_weights[keep] * gain,
            estimate.stop_slope * gain,
            data.level + data.trend * b * estimate.offset,
            state if state.any() else None,
            data.center,
            card,
        )
    if estimate.slopes is None or knots is None:
        weights = estimate.weights[keep] * (data.trend * b / a)
        offset = data.level + data.trend * b * estimate.offset
        return PrandtlIshlinskii(
            thresholds, weights, offset, state if state.any() else None, data.center, card
        )
    # The inner operator rises and is in units of the output; the map carries level and direction.
    inner = PrandtlIshlinskii(
        thresholds, estimate.weights[keep] * (b / a), b * (estimate.offset + float(knots[0])),
        state if state.any() else None, data.center,
    )  # fmt: skip
    u, y = map_points(knots, estimate.slopes)
    return ModifiedPrandtlIshlinskii(
        inner, after_map=MonotoneMap(b * u, data.level + data.trend * b * y), card=card
    )
