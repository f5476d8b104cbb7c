"""What a model hands over to the core: its block for a machine, with signals, limits and the numbers it is made of."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal, TypeAlias

from dehyst.errors import ParameterError
from dehyst.models.arrays import parameter_number
from dehyst.models.card import SignalCard

Direction: TypeAlias = Literal["inverse", "forward"]


@dataclass(frozen=True)
class Machine:
    """A block of the core.

    Attributes
    ----------
    native
        The block, with its memory.
    parameters
        What it was made of: what an exporter prints.
    input, output
        Signals with limits.
    more
        Further inputs in their order.
    slots
        How many of these a step of the core takes; those that are not used are 0.
    defaults
        Values of those that need not be given.
    period
        Between two samples, of what is made for one. [s]
    timed
        Whether answers depend on it.
    saved
        Whether the state has an image.
    """

    native: Any
    parameters: Any
    input: SignalCard
    output: SignalCard
    more: tuple[SignalCard, ...] = ()
    slots: int = 0
    defaults: Mapping[str, float] = field(default_factory=dict)
    period: float = 0.0
    timed: bool = False
    saved: bool = True


def declared_range(card: SignalCard, bounds: tuple[float, float] | None) -> tuple[float, float]:
    """Return the range of the actuator's input: `bounds`, or those of its signal; refuse what is none."""
    if bounds is None:
        if card.low is None or card.high is None:
            raise ParameterError(
                f"the range of {card.label} is not known: this model was not identified from a log. Without it a block "
                f"has no limits; pass range=(low, high), what the actuator can be given (in a terminal: --range LO HI)."
            )
        bounds = (card.low, card.high)
    try:
        low, high = bounds
    except (TypeError, ValueError):
        raise ParameterError(f"range = {bounds!r:.60} is no pair of numbers; pass range=(low, high).") from None
    low, high = parameter_number(low, "range[0]"), parameter_number(high, "range[1]")
    if not low < high:
        raise ParameterError(
            f"range = ({low:g}, {high:g}) holds no input to move in; pass the smallest first, then the largest (in a "
            f"terminal: --range LO HI).",
            low=low,
            high=high,
        )
    return low, high
