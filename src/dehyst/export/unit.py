"""A unit: a block that runs here, the numbers that a target runs it with, and the signal that compares both."""

from __future__ import annotations

from dataclasses import dataclass, replace
from importlib import import_module

import numpy as np

from dehyst.arrays import Array
from dehyst.control.block import BLOCK_FLAGS, MEASURED, Block
from dehyst.errors import ParameterError
from dehyst.export.numbers import OffsetUnit, UnitNumbers, rounded
from dehyst.export.signal import Whole
from dehyst.models import Model, SignalCard
from dehyst.models.machine import Direction


@dataclass(frozen=True)
class Asked:
    """What a unit is wanted for: the settings of an export."""

    what: str
    real: str
    range: tuple[float, float] | None
    ramp: int
    period: float | None
    follow_offset: float | None = None


@dataclass(frozen=True)
class Unit:
    """A unit of any kind.

    Attributes
    ----------
    block
        As it runs here, in double precision.
    numbers
        In the precision of the target.
    inputs, on
        Test signal, (T, m) and (T,).
    more
        (C name, meaning) of each input behind the first.
    heads
        Names of these in tables.
    middle
        A usual value of each input.
    period
        Between samples, if that counts. [s]
    """

    block: Block
    numbers: UnitNumbers
    inputs: Array
    on: Whole
    more: tuple[tuple[str, str], ...] = ()
    heads: tuple[str, ...] = ()
    middle: tuple[float, ...] = (0.0,)
    period: float | None = None


NUMBERS = {  # what a model is run by -> the module with the numbers of its units
    "plays": "dehyst.export.plays",
    "direct": "dehyst.export.direct",
    "elements": "dehyst.export.elements",
}
RATE = "its rate of change a second, 0 if the model has no viscous term"


def unit_of(model: Model, asked: Asked) -> Unit:
    """Return a model, or its inverse, as a unit."""
    if model.no_export:
        raise ParameterError(f"the model cannot be exported: {model.no_export}")
    block = _block(model, asked)
    if asked.period is not None and not block.period:
        raise ParameterError(
            f"--period {asked.period:g} belongs to a model that creeps or depends on the rate, and this one does not: "
            f"no number of it depends on the time between two samples. Leave --period out."
        )
    numbers: UnitNumbers = import_module(NUMBERS[model.core]).numbers_of(block, asked.real)
    inputs, on = numbers.signal(block.more, asked.ramp, asked.real)
    told = [_told(card, block.input.name or "y") for card in block.more]
    return Unit(
        block, numbers, inputs, on, tuple(zip(numbers.inputs[1:], (about for about, _, _ in told), strict=True)),
        tuple(head for _, head, _ in told), (0.0, *(middle for _, _, middle in told)),
        block.period if block.timed else None,
    )  # fmt: skip


def _block(model: Model, asked: Asked, limit: float | None = None) -> Block:
    direction: Direction = "forward" if asked.what == "forward" else "inverse"
    return Block(model, direction, asked.range, asked.ramp, period=asked.period, follow_offset=limit)


def _told(card: SignalCard, first: str) -> tuple[str, str, float]:
    """Meaning, name in tables and usual value of a further input; one without a range is the rate of the first."""
    if card.low is None or card.high is None:
        return RATE, f"{first}_rate", 0.0
    about = f"{card.label}, held beyond {card.low:.6g} .. {card.high:.6g}"
    return about, card.name, 0.5 * (card.low + card.high)


def followed(unit: Unit, asked: Asked) -> Unit:
    """Return the unit with an offset that follows the last cycle, if that was asked for: one more input."""
    if asked.follow_offset is None:
        return unit
    block = _block(unit.block.model, asked, asked.follow_offset)
    assert block.following is not None
    told = block.following.numbers
    offset = OffsetUnit(
        rounded(told.limit, asked.real), rounded(told.turn, asked.real), rounded(told.part, asked.real),
        told.fingerprint, block.direction == "forward",
    )  # fmt: skip
    card = block.model.card.output
    about = f"measured {card.label} of this sample, no number where there is none; it counts from the next one on"
    measured = _measured(unit, offset, asked)
    middle = unit.numbers.line_offset if offset.forward else 0.0
    return replace(
        unit, block=block, numbers=replace(unit.numbers, offset=offset),  # type: ignore[type-var]
        inputs=np.column_stack((unit.inputs, measured)),
        more=(*unit.more, (MEASURED, about)), heads=(*unit.heads, f"{card.name or 'output'}_measured"),
        middle=(*unit.middle, middle),
    )  # fmt: skip


def _measured(unit: Unit, offset: OffsetUnit, asked: Asked) -> Array:
    """An actuator on the unit's line whose offset wanders to and fro beyond the limit, with gaps, (T,).

    Nothing is measured near a limit nor near the end of a switching: in float the last digit decides there which
    sample counts.
    """
    near = np.zeros(unit.inputs.shape[0])
    for shift in (0.0,) if offset.forward else (-offset.limit, 0.0, offset.limit):
        unit.block.reset()
        shifted = np.column_stack((unit.inputs[:, 0] + shift, unit.inputs[:, 1:]))
        near += (unit.block.answer(shifted, unit.on)[1] & BLOCK_FLAGS["limited"]) != 0
    unit.block.reset()
    for k in np.flatnonzero(np.diff(unit.on) > 0):
        near[k + 1 : k + asked.ramp + 20] = 1.0
    x, n = np.nan_to_num(unit.inputs[:, 0], posinf=0.0, neginf=0.0), unit.numbers
    x = np.clip(x, n.input_low, n.input_high)
    y = n.line_offset + n.line_slope * x if offset.forward else x
    y = y + 1.5 * offset.limit * np.sin(np.arange(y.size) * (2.0 * np.pi / 700.0))
    y[np.convolve(near, np.ones(3), "same") > 0.0] = np.nan
    strange = (np.nan, np.inf, -np.inf, -0.0)
    y[np.random.default_rng(7).choice(y.size, len(strange), replace=False)] = strange
    return np.array(y if asked.real == "double" else y.astype(np.float32), dtype=np.float64)
