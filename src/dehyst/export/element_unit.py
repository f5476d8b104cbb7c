"""A sum of elements, or its inverse, as a unit: its input and the signals of its schedules in."""

from __future__ import annotations

from dehyst.errors import ParameterError
from dehyst.export.element_numbers import element_numbers
from dehyst.export.signal import moving_input
from dehyst.export.unit import Asked, Unit, c_names
from dehyst.families.element_block import ElementBlock
from dehyst.families.elements import ElementModel


def unit_of(model: ElementModel, asked: Asked) -> Unit:
    """Return the unit; without a period it is made for that of the log, where time counts at all.

    Raises
    ------
    ParameterError
        If the model has no ranges, does not survive the rounding to float, or the period is not known.
    """
    timed = model.rate_dependent or model.dead_time > 0.0
    period = asked.period or model.period
    if timed and not period:
        raise ParameterError(
            "the model creeps, depends on the rate or has a dead time, and does not say at which period it was "
            "identified. Add --period SECONDS, what your target calls it with, for example --period 0.001."
        )
    block = ElementBlock(
        model, "forward" if asked.what == "forward" else "inverse", period=period or 1.0, range=asked.range,
        ramp=asked.ramp,
    )  # fmt: skip
    names = c_names(block.given, ("x",))
    numbers = element_numbers(block.parameters, names, asked.real)
    ranges = [_range(model, k) for k in range(len(names))]
    inputs, on = moving_input(numbers.input_low, numbers.input_high, list(ranges), asked.ramp, asked.real)
    more = tuple(
        (name, f"{own}, held beyond {low:.6g} .. {high:.6g}")
        for name, own, (low, high) in zip(names, block.given, ranges, strict=True)
    )
    return Unit(
        block, numbers, inputs, on, more, block.given, (0.0, *(0.5 * (low + high) for low, high in ranges)),
        period=block.period if timed else None,
    )  # fmt: skip


def _range(model: ElementModel, signal: int) -> tuple[float, float]:
    """Ends of all schedules that follow a signal."""
    found = [(low, high) for source, low, high in model.schedules if source == signal]
    return min(low for low, _ in found or [(0.0, 1.0)]), max(high for _, high in found or [(0.0, 1.0)])
