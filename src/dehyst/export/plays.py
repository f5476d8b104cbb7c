"""A model of plays, or its inverse, as a unit: with dead zones, maps, and any state."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from typing import Any, cast

import numpy as np

from dehyst.control.block import Block
from dehyst.control.machine_block import Direction
from dehyst.errors import ParameterError
from dehyst.export.float_rules import check_block
from dehyst.export.numbers import BlockNumbers, ModelNumbers, block_in
from dehyst.export.signal import test_input
from dehyst.export.unit import Asked, Unit
from dehyst.models import HysteresisModel

NARROWEST = 1e-6  # share of the identified range


def unit_of(model: HysteresisModel, asked: Asked) -> Unit:
    """Return the unit.

    Raises
    ------
    ParameterError
        If the model has no ranges, does not survive the rounding to float, or knows nothing of a period.
    """
    if asked.period is not None:
        raise ParameterError(
            f"--period {asked.period:g} belongs to a model that creeps or depends on the rate, and this one does not: "
            f"no number of it depends on the time between two samples. Leave --period out."
        )
    block = Block(model, cast(Direction, asked.what), range=asked.range, ramp=asked.ramp)
    _refuse_narrow(model, asked.range)
    exact = block_numbers(block)
    numbers = block_in(exact, asked.real)
    if asked.real == "float":
        check_block(exact, numbers)
    x, on = test_input(numbers, asked.real, asked.ramp)
    return Unit(block, numbers, x[:, None], on)


def model_numbers(values: Mapping[str, Any]) -> ModelNumbers:
    """Return the numbers of the core's model from a mapping of arrays."""

    def pair(place: str) -> tuple[tuple[float, ...], tuple[float, ...]] | None:
        u, v = floats(f"{place}_u"), floats(f"{place}_v")
        return (u, v) if u else None

    def floats(name: str) -> tuple[float, ...]:
        return tuple(float(value) for value in np.asarray(values[name]).ravel())

    return ModelNumbers(
        floats("threshold"),
        floats("slope"),
        floats("loading"),
        floats("start"),
        float(values["center"]),
        float(values["offset"]),
        pair("before"),
        pair("after"),
    )


def block_numbers(block: Block) -> BlockNumbers:
    """Return the numbers of a block, in double precision."""
    values = {entry.name: getattr(block.parameters, entry.name) for entry in fields(block.parameters)}
    own: dict[str, Any] = {entry.name: float(values[entry.name]) for entry in fields(BlockNumbers)[1:-2]}
    return BlockNumbers(model_numbers(values), **own, fingerprint=int(values["fingerprint"]))


def _refuse_narrow(model: HysteresisModel, bounds: tuple[float, float] | None) -> None:
    card = model.card.input
    if bounds is None or card.low is None or card.high is None:
        return
    low, high = (float(end) for end in bounds)
    if 0 < high - low < NARROWEST * (card.high - card.low):
        raise ParameterError(
            f"the range from {low:.9g} to {high:.9g} is less than a millionth of what was identified, {card!s}: the "
            f"unit would do nothing. Pass --range LO HI in {card.unit or 'the unit of the input'}, what the actuator "
            f"can be given.",
            low=low,
            high=high,
        )
