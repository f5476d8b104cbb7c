"""From a scaled estimate to the direct inverse in the units of the log."""

from __future__ import annotations

import numpy as np

from dehyst.arrays import Array
from dehyst.identification.direct.columns import GROUPS, Layout
from dehyst.identification.direct.data import DirectData
from dehyst.identification.direct.program import DirectEstimate
from dehyst.models import DirectInverse, ModelCard, Schedule


def build_direct(layout: Layout, estimate: DirectEstimate, data: DirectData, card: ModelCard) -> DirectInverse:
    """Return the model of an estimate; terms without weight are left out, which is exact."""
    shape, slope = estimate.shape, data.amplitude / data.half_range
    given = tuple(Schedule(g.name, g.low, g.high, g.unit) for g in data.given)
    low, high = data.center - data.half_range, data.center + data.half_range
    schedules = (Schedule("output", low, high), *given) if shape.by_output else given
    tables = _tables(layout, estimate)
    return DirectInverse(
        radii=layout.bank.radii * data.half_range,
        stop_weights=tables["stops"] * slope,
        path_lengths=layout.bank.lengths * data.half_range,
        path_weights=tables["path"] * slope,
        time_constants=layout.bank.time_constants,
        creep_weights=tables["creep"] * slope,
        polynomial=_polynomials(estimate, data, len(given)),
        viscous=tables["viscous"][:, 0] * slope,
        center=data.center,
        schedules=schedules,
        known=shape.start == "rest",
        card=card,
    ).pruned()


def _tables(layout: Layout, estimate: DirectEstimate) -> dict[str, Array]:
    """Weights (sets, terms) of every group, zero where the shape has none."""
    sets, tables, begin = estimate.weights.shape[0], {}, 0
    for name in GROUPS:
        size = layout.sizes[name]
        there = name in estimate.shape.groups
        tables[name] = estimate.weights[:, begin : begin + size] if there else np.zeros((sets, size))
        begin += size if there else 0
    return tables


def _polynomials(estimate: DirectEstimate, data: DirectData, given: int) -> Array:
    """(sets, d): the polynomial in both sets of the output's schedule, or those of the given schedules in theirs."""
    parts = estimate.polynomials * (data.amplitude / data.half_range ** np.arange(estimate.shape.degree + 1))
    parts[: 2 if given else 1, 0] += data.level
    if given == 0:
        return np.repeat(parts, 2 if estimate.shape.by_output else 1, axis=0)
    return np.vstack([np.zeros((2, parts.shape[1])), parts]) if estimate.shape.by_output else parts
