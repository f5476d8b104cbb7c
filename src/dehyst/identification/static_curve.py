"""The best curve without hysteresis: the baseline for every model, and the result if none is better."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

import dehyst._native as _native
from dehyst.arrays import Array
from dehyst.identification.data import DataSet, chunks
from dehyst.identification.families import STATIC, Estimate
from dehyst.identification.short_signal import ShortSignal
from dehyst.models import MonotoneMap, StaticCurve

PIECES = 30
KNOTS = np.linspace(-1.0, 1.0, PIECES + 1)
SMALLEST_SLOPE = 1e-3
SMOOTHING = 0.01
# A curve remembers nothing: one play of radius 0.
NO_MEMORY = np.zeros(1)


def fit_static(data: DataSet, initial_state: str, smallest: float = SMALLEST_SLOPE) -> tuple[Estimate, float]:
    """Fit a rising piecewise linear curve y = v(x) by least squares, and return its RMSE with it, scaled.

    minimise |c + sum_j m_j ramp_j(x) - y|^2 + smoothing |m_{j+1} - m_j|^2,  m_j >= smallest, over [-1, 1] scaled.
    """
    return _solved(*_sums(data, initial_state), smallest)


def curve_of(estimate: Estimate, data: DataSet) -> StaticCurve:
    """Return the fitted curve in units of the log."""
    y = _values(estimate)
    return StaticCurve(MonotoneMap(data.center + data.half_range * KNOTS, data.level + data.trend * data.amplitude * y))


def held_out_errors(short: ShortSignal, blocks: Sequence[slice]) -> Array:
    """RMSE on every block of the curve that is fitted to the others, scaled, (blocks,)."""
    x = np.concatenate([piece.x[piece.place] for piece in short.pieces])
    y, weight = short.y, short.weight
    parts = [_moments(x[b], y[b], None if weight is None else weight[b]) for b in blocks]
    errors = []
    for left_out, block in enumerate(blocks):
        others = [part for k, part in enumerate(parts) if k != left_out]
        moments: Array = np.sum([bins for bins, _ in others], axis=0)
        estimate, _ = _solved(moments, sum(square for _, square in others), SMALLEST_SLOPE)
        squared = short.levelled(np.interp(x[block], KNOTS, _values(estimate)) - y[block], block) ** 2
        errors.append(np.sqrt(np.average(squared, weights=None if weight is None else weight[block])))
    return np.array(errors)


def _values(estimate: Estimate) -> Array:
    """Of the curve at its knots, scaled."""
    rises: Array = np.concatenate([[0.0], np.cumsum(estimate.parameters[1:] * np.diff(KNOTS))])
    return estimate.offset + rises


def _solved(moments: Array, square: float, smallest: float) -> tuple[Estimate, float]:
    gram, rhs = _from_bins(moments)
    difference = np.eye(PIECES - 1, PIECES, k=1) - np.eye(PIECES - 1, PIECES)
    extra = np.zeros_like(gram)
    extra[1:, 1:] = SMOOTHING**2 * gram[0, 0] * (difference.T @ difference)
    lower = np.full(1 + PIECES, smallest)
    u, passive, kkt, condition, *_ = _native.solve_bounded(
        gram, rhs, lower, 1, 0, _native.SLOPES, extra, np.zeros(1 + PIECES), None, np.sqrt(square)
    )
    left = max(float(square - 2.0 * (rhs @ u) + u @ gram @ u), 0.0)
    estimate = Estimate(
        STATIC, u, float(u[0]), np.ones(1), u[1:], None, None, kkt, condition=condition, passive=passive
    )
    return estimate, float(np.sqrt(left / gram[0, 0]))


def _sums(data: DataSet, initial_state: str) -> tuple[Array, float]:
    moments, square = np.zeros((PIECES, 5)), 0.0
    for piece in data.pieces:
        for part in chunks(piece.fitted(initial_state)):
            found = _moments(piece.x[part], piece.y[part], None if piece.weight is None else piece.weight[part])
            moments += found[0]
            square += found[1]
    return moments, square


def _moments(x: Array, y: Array, weight: Array | None) -> tuple[Array, float]:
    """Sums over the bins between the knots, and that of y^2.

    Within a bin between two knots all ramps below are full, all above zero, and one is t = x - knot: the sums of 1, t,
    t^2, y and t y over each bin are enough.
    """
    bins = _native.bin_sums(x, y, weight, PIECES, -1.0, 1.0)
    return bins, float(y @ (y if weight is None else weight * y))


def _from_bins(moments: Array) -> tuple[Array, Array]:
    """Gram matrix of [1 | ramps] and its right-hand side from the sums over bins, t in units of a bin."""
    count, t, tt, y, ty = moments.T
    width = 2.0 / PIECES
    above = np.concatenate([np.cumsum(count[::-1])[::-1][1:], [0.0]])  # samples beyond each bin: its ramp is full
    full = np.concatenate([np.cumsum(y[::-1])[::-1][1:], [0.0]])
    total = width * (t + above)  # sum of each ramp
    gram = np.zeros((1 + PIECES, 1 + PIECES))
    gram[0, 0] = count.sum()
    gram[0, 1:] = gram[1:, 0] = total
    later = np.triu(np.ones((PIECES, PIECES)), 1) * (width * total)  # j < k: ramp j is full where ramp k is not zero
    gram[1:, 1:] = later + later.T + np.diag(width**2 * (tt + above))
    return gram, np.concatenate([[y.sum()], width * (ty + full)])
