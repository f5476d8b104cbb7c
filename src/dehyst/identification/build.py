"""From scaled estimates to models in the log's own units."""

from __future__ import annotations

from dehyst.arrays import Array
from dehyst.identification.data import DataSet
from dehyst.identification.families import Estimate, map_points
from dehyst.identification.regressors import Bank
from dehyst.models import (
    HysteresisModel,
    ModelCard,
    ModifiedPrandtlIshlinskii,
    MonotoneMap,
    PrandtlIshlinskii,
    StopOperatorModel,
)


def build_model(estimate: Estimate, data: DataSet, bank: Bank, knots: Array | None, card: ModelCard) -> HysteresisModel:
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
        return PrandtlIshlinskii(thresholds, weights, offset, state if state.any() else None, data.center, card)
    # The inner operator rises and is in units of the output; the map carries level and direction.
    inner = PrandtlIshlinskii(
        thresholds, estimate.weights[keep] * (b / a), b * (estimate.offset + float(knots[0])),
        state if state.any() else None, data.center,
    )  # fmt: skip
    u, y = map_points(knots, estimate.slopes)
    return ModifiedPrandtlIshlinskii(inner, after=MonotoneMap(b * u, data.level + data.trend * b * y), card=card)
