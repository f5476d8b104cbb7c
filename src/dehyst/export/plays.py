"""A model of plays, or its inverse, as numbers of a unit: dead zones, maps, any state."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from dehyst.arrays import Array
from dehyst.control.block import Block
from dehyst.errors import ParameterError
from dehyst.export.float_rules import check_unit
from dehyst.export.numbers import (
    FLOAT_LIMIT,
    LIMITS,
    TOLERANCE,
    Constant,
    Map,
    ModelNumbers,
    OffsetUnit,
    Tables,
    UnitNumbers,
    in_real,
    inward,
    outward,
)
from dehyst.export.signal import Whole, test_input
from dehyst.models import SignalCard
from dehyst.models.machine import EPS_FLOAT, Operator

NARROWEST = 1e-6  # share of the identified range


def numbers_of(block: Block, real: str) -> BlockNumbers:
    """Return the numbers of a block in a precision."""
    _refuse_narrow(block)
    exact = block_numbers(block)
    numbers = block_in(exact, real)
    check_unit(exact, numbers, block.ramp, real)
    return numbers


@dataclass(frozen=True)
class BlockNumbers(UnitNumbers):
    """``dehyst_block``, fields named as there."""

    functions = ("dehyst_block_reset", "dehyst_block_step", "dehyst_block_save", "dehyst_block_restore")
    model: ModelNumbers
    input_low: float
    input_high: float
    output_low: float
    output_high: float
    reach_low: float
    reach_high: float
    line_slope: float
    line_offset: float
    fade: float
    fingerprint: int
    offset: OffsetUnit | None = None

    @property
    def tolerance(self) -> float:  # type: ignore[override]
        """1e-5 of the range."""
        return TOLERANCE * (self.output_high - self.output_low)

    @property
    def map_points(self) -> tuple[int, ...]:
        """Breakpoints of the maps."""
        return self.model.points

    @property
    def rising(self) -> Tables:
        """Those of the model, and the ranges."""
        yield from self.model.rising
        yield from super().rising

    def signal(self, others: Sequence[SignalCard], ramp: int, real: str) -> tuple[Array, Whole]:
        """Return the signal that moves every operator."""
        x, on = test_input(self.input_low, self.input_high, real, ramp)
        return x[:, None], on

    @property
    def memory(self) -> tuple[tuple[str, str, str], ...]:
        """Play states."""
        return (("model.z", "z", "OPERATORS"),)

    @property
    def sizes(self) -> tuple[tuple[str, str, str], ...]:
        """Operators, words of an image."""
        n = self.parts
        return ("OPERATORS", f"{n}", ""), ("IMAGE_WORDS", f"DEHYST_STATE_WORDS({n})", "of a saved state")

    @property
    def parts(self) -> int:
        """Play operators."""
        return self.model.operators

    def bytes(self, size: int) -> tuple[int, int, int]:
        """Return bytes of constants, state and image on a 32-bit target, by the size of a real."""
        n, points = self.parts, sum(self.model.points)
        rest = {4: 48, 8: 64}[size]
        state = size * (n + 3) + 4 * 4 + (8 if size == 8 else 0)
        return size * (4 * n + 2 * points + 11) + rest, state, 4 * (6 + size // 4 * (n + 3))

    def avr_ram(self, fixed: int) -> int:
        """Return bytes of RAM on AVR, where constants are copied there."""
        return 20 * self.parts + 8 * sum(self.map_points) + fixed

    def constants(self, unit: str) -> Iterable[Constant]:
        """Return those of the model."""
        return self.model.constants("" if self.model.before else unit)

    @property
    def holds_back(self) -> bool:
        """Whether there is an output in front of the last map at which the input is held back: not so forward."""
        return self.reach_high < FLOAT_LIMIT


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


def block_in(numbers: BlockNumbers, real: str) -> BlockNumbers:
    """Return the block in that precision; its values stay doubles."""
    if real == "double":
        return numbers
    pairs = {name: (getattr(numbers, f"{name}_low"), getattr(numbers, f"{name}_high")) for name in LIMITS}
    limits = {name: inward(*pair, real) for name, pair in pairs.items()}
    if not numbers.holds_back:
        # What a model reaches is no limit of a machine: the answers in float must not be cut off by their rounding.
        limits["output"] = outward(*_reached_in_float(numbers), real)
        limits["reach"] = (-FLOAT_LIMIT, FLOAT_LIMIT)
    ends: dict[str, Any] = {
        f"{name}_{end}": pair[k] for name, pair in limits.items() for k, end in enumerate(("low", "high"))
    }
    return replace(in_real(numbers, real), **ends)


def _reached_in_float(numbers: BlockNumbers) -> tuple[float, float]:
    """Range of the output with the rounding of floats."""
    m = numbers.model
    nothing: Map = ((), ())
    (u, v), (p, q) = ([np.array(values) for values in points or nothing] for points in (m.before, m.after))
    weights = np.diff(np.array(m.slope), prepend=0.0)
    operator = Operator(np.array(m.threshold), weights, m.center, m.offset, u, v, p, q, np.array(m.start))
    bottom, top = operator.in_front_of_after(numbers.output_low, numbers.output_high)
    return operator.widened(numbers.input_low, numbers.input_high, bottom, top, EPS_FLOAT)


def _refuse_narrow(block: Block) -> None:
    card, held = block.model.card.input, block.input if block.direction == "forward" else block.output
    if card.low is None or card.high is None or held.low is None or held.high is None:
        return
    if held.high - held.low < NARROWEST * (card.high - card.low):
        raise ParameterError(
            f"the range from {held.low:.9g} to {held.high:.9g} is less than a millionth of what was identified, "
            f"{card!s}: the unit would do nothing. Pass --range LO HI in {card.unit or 'the unit of the input'}, what "
            f"the actuator can be given.",
            low=held.low,
            high=held.high,
        )
