"""The families as quadratic programs on the normal equations of cells.

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

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

import dehyst._native as _native
from dehyst.arrays import Array
from dehyst.identification.sums import NormalEquations

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
class Program:
    """One quadratic program, ready for the engine.

    Attributes
    ----------
    basis
        What the unknowns of the plays are: slopes, weights or stops.
    gram, rhs
        G (N, N) and g (N,) of the columns [1 | cells | -ramps].
    lower
        Bounds (N,); that of the offset, which comes first, is ignored.
    extra, extra_rhs
        E (N, N) and h (N,), or None.
    target
        |y| of the least squares behind it.
    """

    basis: int
    gram: Array
    rhs: Array
    lower: Array
    extra: Array | None
    extra_rhs: Array | None
    target: float


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
) -> Program:
    """State one family's program.

    Parameters
    ----------
    sums
        Sums of [1 | cells | ramps | y]; the ramps are used by "modified-pi" only.
    eps
        Smallest slope right after a reversal, scaled.
    fold_ridge
        Weight of each play weight w_i, squared and times the number of samples.
    """
    n, matrix = sums.operators, sums.matrix
    if family != "modified-pi":
        rhs, target = matrix[: 1 + n, -1].copy(), float(np.sqrt(matrix[-1, -1]))
        lower = np.concatenate([[0.0], lower_bounds(family, n, eps)])
        extra = fold_ridge * unit_ridge(family, n) if fold_ridge else None
        gram = np.ascontiguousarray(matrix[: 1 + n, : 1 + n])
        return Program(BASIS[family], gram, rhs, lower, extra, None, target)
    if knots is None or regularisation is None:
        raise AssertionError("the modified model needs knots and a regularisation")  # the caller gives them
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
    return Program(BASIS[family], gram, np.zeros(size), lower, extra, extra_rhs, target)


def smoothing_rows(regularisation: Regularisation, n: int, widths: Array) -> tuple[Array, Array]:
    """Rows (1 + (p - 1) + n, 1 + n + p) and their right-hand side that stand beside one sample.

    Mean slope 1, differences of successive slopes, weights.
    """
    pieces = widths.size
    rows = np.zeros((pieces + n, 1 + n + pieces))
    rhs = np.zeros(pieces + n)
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
