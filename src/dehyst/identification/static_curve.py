"""The best curve without hysteresis, the bar that every model has to clear."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from dehyst.identification.data import DataSet
from dehyst.identification.least_squares import solve_bounded, triangle
from dehyst.identification.regressors import CHUNK, Rows, ramps
from dehyst.models import ModelCard, MonotoneMap, StaticCurve

Array = npt.NDArray[np.float64]

PIECES = 30
SMALLEST_SLOPE = 1e-3
SMOOTHING = 0.01


def fit_static(data: DataSet, rows: tuple[Rows, ...], card: ModelCard) -> StaticCurve:
    """Fit a rising piecewise linear curve y = v(x) by least squares.

    minimise |c + sum_j m_j ramp_j(x) - y|^2 + smoothing |m_{j+1} - m_j|^2,  m_j >= 0.001, over [-1, 1] scaled.
    """
    knots = np.linspace(-1.0, 1.0, PIECES + 1)
    factor: Array | None = None
    for piece, chosen in zip(data.pieces, rows, strict=True):
        for begin in range(0, chosen.size, CHUNK):
            part = chosen[begin : begin + CHUNK]
            block = np.hstack([np.ones((part.size, 1)), ramps(piece.x[part], knots), piece.y[part][:, None]])
            factor = triangle(block if factor is None else np.vstack([factor, block]))
    if factor is None:
        raise AssertionError("no rows to fit")  # the caller has checked
    samples = float(np.linalg.norm(factor[:, 0]))
    smooth = np.zeros((PIECES - 1, PIECES + 2))
    rows_index = np.arange(PIECES - 1)
    smooth[rows_index, 1 + rows_index] = -SMOOTHING * samples
    smooth[rows_index, 2 + rows_index] = SMOOTHING * samples
    solution = solve_bounded(np.vstack([factor, smooth]), 1, np.full(PIECES, SMALLEST_SLOPE))
    y = solution.free[0] + np.concatenate([[0.0], np.cumsum(solution.bounded * np.diff(knots))])
    curve = MonotoneMap(data.center + data.half_range * knots, data.level + data.trend * data.amplitude * y)
    return StaticCurve(curve, card)
