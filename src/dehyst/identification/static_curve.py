"""The best curve without hysteresis, the bar that every model has to clear."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from dehyst import _native
from dehyst.identification.data import DataSet, chunks
from dehyst.models import ModelCard, MonotoneMap, StaticCurve

Array = npt.NDArray[np.float64]

PIECES = 30
SMALLEST_SLOPE = 1e-3
SMOOTHING = 0.01


def fit_static(data: DataSet, initial_state: str, card: ModelCard) -> StaticCurve:
    """Fit a rising piecewise linear curve y = v(x) by least squares.

    minimise |c + sum_j m_j ramp_j(x) - y|^2 + smoothing |m_{j+1} - m_j|^2,  m_j >= 0.001, over [-1, 1] scaled.
    """
    gram, rhs, square = _sums(data, initial_state)
    difference = np.eye(PIECES - 1, PIECES, k=1) - np.eye(PIECES - 1, PIECES)
    extra = np.zeros_like(gram)
    extra[1:, 1:] = SMOOTHING**2 * gram[0, 0] * (difference.T @ difference)
    lower = np.full(1 + PIECES, SMALLEST_SLOPE)
    u, *_ = _native.solve_bounded(
        gram, rhs, lower, 1, 0, _native.SLOPES, extra, np.zeros(1 + PIECES), None, np.sqrt(square)
    )
    knots = np.linspace(-1.0, 1.0, PIECES + 1)
    y = u[0] + np.concatenate([[0.0], np.cumsum(u[1:] * np.diff(knots))])
    curve = MonotoneMap(data.center + data.half_range * knots, data.level + data.trend * data.amplitude * y)
    return StaticCurve(curve, card)


def _sums(data: DataSet, initial_state: str) -> tuple[Array, Array, float]:
    """Normal equations of [1 | ramps] and y.

    Within a bin between two knots all ramps below are full, all above zero, and one is t = x - knot: the sums of 1, t,
    t^2, y and t y over each bin are enough.
    """
    moments, square = np.zeros((PIECES, 5)), 0.0
    for piece in data.pieces:
        for part in chunks(piece.fitted(initial_state)):
            x, y = piece.x[part], piece.y[part]
            weight = None if piece.weight is None else piece.weight[part]
            moments += _native.bin_sums(x, y, weight, PIECES, -1.0, 1.0)
            square += float(y @ (y if weight is None else weight * y))
    return *_from_bins(moments), square


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
