"""A direct inverse as a block of the core: limits, and the straight line through its curve."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

import dehyst._native as _native
from dehyst.errors import ParameterError
from dehyst.models.card import SignalCard
from dehyst.models.machine import Direction, Machine, declared_range

if TYPE_CHECKING:
    from dehyst.models.direct import DirectInverse

RATE = "rate"
BEYOND = 1e14  # no limit of a signal lies there
_LIMITS = 8  # place of center, input low and high, output low and high among the parameters


@dataclass(frozen=True)
class DirectParameters:
    """What the core's ``dehyst_direct_block`` is made of.

    Attributes
    ----------
    direct
        ``DirectInverse.parameters(period)`` with the block's limits.
    line_slope, line_offset
        Of the straight line that answers while the block is off. [u/y], [u]
    fade
        Share of a switching that one sample makes.
    """

    direct: tuple[Any, ...]
    line_slope: float
    line_offset: float
    fade: float


def direct_machine(
    model: DirectInverse, direction: Direction, range: tuple[float, float] | None, ramp: int, period: float | None
) -> Machine:
    """Return the block of the core."""
    if direction == "forward":
        raise ParameterError(
            "the model is a direct inverse: it answers which input an output needs, and there is no model of the "
            "output to run. Leave direction out (in a terminal: --what forward), or identify another family for it."
        )
    if period is None:
        raise ParameterError(
            "the model is a direct inverse: what creeps depends on the time between two samples, which is not known "
            "here. Pass period, the seconds between two samples of your loop (in a terminal: --period SECONDS, what "
            "your target calls it with, for example --period 0.001)."
        )
    input, output = _limited(model.card.output, None, "y"), _limited(model.card.input, range, "u")
    told = list(model.parameters(period))
    told[_LIMITS] = np.array([model.center, input.low, input.high, output.low, output.high], float)
    p = DirectParameters(tuple(told), *_line(model, float(input.low or 0.0), float(input.high or 0.0)), 1.0 / ramp)
    rate = SignalCard(RATE, "", None, None)
    return Machine(
        _native.DirectBlock(p.direct, p.line_slope, p.line_offset, p.fade), p, input, output, (rate, *model.context), 3,
        {RATE: 0.0}, float(period), True, False,
    )  # fmt: skip


def _limited(card: SignalCard, range: tuple[float, float] | None, name: str) -> SignalCard:
    """The signal with limits: those given, or those of the identification."""
    card = replace(card, name=card.name or name)
    low, high = declared_range(card, range)
    if max(abs(low), abs(high)) > BEYOND:
        raise ParameterError(
            f"{card.label} goes from {low:g} to {high:g}; pass --range LO HI, both within {BEYOND:g}.",
            low=low,
            high=high,
        )
    return replace(card, low=low, high=high)


def _line(model: DirectInverse, low: float, high: float) -> tuple[float, float]:
    """Slope and offset of the straight line through the curve at both ends of y."""
    ends = [_curve(model, y) for y in (low, high)]
    slope = (ends[1] - ends[0]) / (high - low)
    return slope, ends[0] - slope * low


def _curve(model: DirectInverse, y: float) -> float:
    """The curve at y, scheduling variables from outside in the middle of their ranges."""
    values = [float(np.polynomial.polynomial.polyval(y - model.center, row)) for row in model.polynomial]
    if not model.schedules:
        return values[0]
    total = 0.0
    for schedule, (below, above) in zip(model.schedules, zip(values[::2], values[1::2], strict=True), strict=True):
        xi = 0.5 if schedule.outside else float(np.clip((y - schedule.low) / (schedule.high - schedule.low), 0.0, 1.0))
        total += (1 - xi) * below + xi * above
    return total
