"""A sum of elements, or its inverse, as a unit: its input and the signals of its schedules in."""

from __future__ import annotations

from dehyst.control.machine_block import Direction
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
    direction: Direction = "forward" if asked.what == "forward" else "inverse"
    block = ElementBlock(model, direction, period=asked.period, range=asked.range, ramp=asked.ramp)
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
        period=block.period if model.timed else None,
    )  # fmt: skip


def _range(model: ElementModel, signal: int) -> tuple[float, float]:
    """Ends of all schedules that follow a signal."""
    found = [(low, high) for source, low, high in model.schedules if source == signal]
    return min(low for low, _ in found or [(0.0, 1.0)]), max(high for _, high in found or [(0.0, 1.0)])
