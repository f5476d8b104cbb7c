"""Scores over the cycles, and straight lines through them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from dehyst.monitoring import design, testing
from dehyst.monitoring.cycles import Cycle, groups_of
from dehyst.monitoring.design import Estimates, Measured, Scale
from dehyst.monitoring.result import Blocks, LogDrift, Trend
from dehyst.monitoring.statistics import rms, trend

MOST_BLOCKS = 120


def percents(found: Estimates, scale: Scale) -> tuple[float, float | None]:
    """Errors of all groups together, of the response and of the drive that the inverse asks for. [% of range]"""
    inverse = None if found.inverse is None else 100.0 * rms(found.inverse) / (2.0 * scale.drive[1])
    return 100.0 * rms(found.error) / scale.span, inverse


def blocks_of(
    measured: Measured,
    cycles: Sequence[Cycle],
    steps: Sequence[Sequence[str]],
    scale: Scale,
    first: int,
    old: Sequence[Cycle],
) -> Blocks:
    """Score blocks of cycles one by one; a block is either of the reference or not."""
    groups = [*groups_of(old, MOST_BLOCKS), *groups_of(cycles[len(old) :], MOST_BLOCKS)]
    found = design.estimate(measured, [group for group in groups if group], steps)
    counts = np.cumsum([0, *(len(group) for group in groups if group)])
    percent = 100.0 * found.sizes / scale.span
    inverse = None if found.inverse is None else 100.0 * found.inverse / (2.0 * scale.drive[1])
    changes = {
        part: testing.factor_of(part, float(percent[k])) * found.values[:, k] for k, part in enumerate(found.parts)
    }
    return Blocks(
        first + 0.5 * (counts[:-1] + counts[1:] + 1.0), 100.0 * found.error / scale.span, inverse, changes
    )  # fmt: skip


def trends_of(entries: Sequence[LogDrift], rate: float) -> tuple[Trend, ...]:
    """Straight lines over the blocks of all logs, at the false alarm rate over all parts."""
    blocks = [entry.blocks for entry in entries if entry.blocks is not None]
    if not blocks:
        return ()
    places = np.concatenate([block.cycle for block in blocks])
    series = {"error": ("%", np.concatenate([block.error_percent for block in blocks]))}
    units = {change.part: change.unit for entry in entries for change in entry.changes}
    for part in blocks[0].changes:
        series[part] = (units.get(part, "%"), np.concatenate([block.changes[part] for block in blocks]))
    found = []
    for part, (unit, values) in series.items():
        line = trend(places, values, 1.0 - rate / len(series))
        if line is not None:
            slope, low, high = line
            found.append(Trend(part, 100.0 * slope, 100.0 * low, 100.0 * high, unit))
    return tuple(found)
