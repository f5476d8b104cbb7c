"""A model of plays or its inverse as a block of the core: tables, limits, the straight line."""

from __future__ import annotations

import hashlib
import struct
from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

import dehyst._native as _native
from dehyst.arrays import Array
from dehyst.errors import ParameterError
from dehyst.models.machine import Direction, Machine, declared_range
from dehyst.models.reach import Operator

if TYPE_CHECKING:
    from dehyst.models.base import HysteresisModel

Words = npt.NDArray[np.uint32]


@dataclass(frozen=True, eq=False)
class BlockParameters:
    """Parameters of a block with the bits that are used: what an exporter prints.

    Attributes
    ----------
    threshold, slope, loading
        r, S_i = w_1 + ... + w_i and phi_i = sum_{j<i} S_j (r_{j+1} - r_j) of the operator H, (n,). [argument of H],
        [output of H / argument], [output of H]
    center, offset
        Subtracted from the argument of H, added to its output. [argument of H], [output of H]
    before_u, before_v, after_u, after_v
        Breakpoints and values of the maps in front of H and behind it; of size 0 if there is none.
    start
        Play states after a reset, (n,). [argument of H]
    input_low, input_high, output_low, output_high
        Limits. [input], [output]
    reach_low, reach_high
        Limits of the output in front of the last map, where the input is held back; those of a forward block, which
        never does that, are the largest numbers that are taken. [output of H]
    line_slope, line_offset
        Of the straight line that answers while the block is off. [output/input], [output]
    fade
        Share of a switching that one sample makes.
    fingerprint
        First 32 bits of the SHA-256 of the model: states of another one are refused.
    """

    threshold: Array
    slope: Array
    loading: Array
    center: float
    offset: float
    before_u: Array
    before_v: Array
    after_u: Array
    after_v: Array
    start: Array
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


def play_machine(model: HysteresisModel, direction: Direction, range: tuple[float, float] | None, ramp: int) -> Machine:
    """Return the block of the core."""
    low, high = declared_range(model.card.input, range)
    operator = started(model, low, high) if direction == "inverse" else model
    native = _native.Block(_image(model, operator, low, high, ramp))
    p, card = _parameters(native), operator.card
    return Machine(
        native, p, replace(card.input, low=p.input_low, high=p.input_high),
        replace(card.output, low=p.output_low, high=p.output_high),
    )  # fmt: skip


def _of(model: HysteresisModel) -> Operator:
    return Operator(*model.stepper("dense").parameters)


def started(model: HysteresisModel, low: float, high: float) -> HysteresisModel:
    """Return the inverse of the model, started where an actuator is that was brought into its range."""
    inverse = model.inverse()
    first = inverse.stepper("dense").output
    if low <= first <= high:
        return inverse
    return model.with_state(model.final_state([min(max(first, low), high)])).inverse()


def _fingerprint(operator: Operator) -> int:
    digest = hashlib.sha256()
    for field in fields(operator):
        if field.name != "start":  # of the model alone: a block may begin elsewhere
            values = np.atleast_1d(np.asarray(getattr(operator, field.name), dtype="<f8"))
            digest.update(struct.pack("<Q", values.size) + values.tobytes())
    return int.from_bytes(digest.digest()[:4], "big")


def _image(
    model: HysteresisModel, stepped: HysteresisModel, low: float, high: float, ramp: int
) -> npt.NDArray[np.uint32]:
    plant, operator = _of(model), _of(stepped)
    bottom, top = plant.reached(low, high)
    reached = plant.after(bottom, top)
    slope, offset = _secant(model, low, high)
    if stepped is model:
        # Reached in exact arithmetic; what rounding adds must not be cut off. A forward block never holds its input
        # back: the actuator did get it, and on a branch that is nearly flat the point to stop at would be anywhere.
        limits = [low, high, *plant.widened(low, high, bottom, top), -_native.INPUT_LIMIT, _native.INPUT_LIMIT]
    else:
        limits = [*reached, low, high, *operator.in_front_of_after(low, high)]
    o = operator
    try:
        if stepped is not model:
            slope, offset = 1 / slope, -offset / slope
        of_model = (o.thresholds, o.weights, o.center, o.offset, o.before_u, o.before_v, o.after_u, o.after_v, o.start)
        image = _native.block_image(*of_model, [*limits, slope, offset, 1 / ramp], _fingerprint(operator))
        _native.Block(image)
    except (ValueError, ZeroDivisionError, OverflowError):
        raise ParameterError(
            f"no block can be made of this model for inputs from {low:g} to {high:g}: some of its numbers is beyond "
            f"{_native.INPUT_LIMIT:g}, or its start state is one that no input leaves. Scale its signals to a unit of "
            f"their size, and take the state from model.final_state(x)."
        ) from None
    return image


def _secant(model: HysteresisModel, low: float, high: float) -> tuple[float, float]:
    """Slope and offset of the straight line through the ends of the model's full loop."""
    step = model.stepper("dense")
    _, top, bottom = step(low), step(high), step(low)
    slope = (top - bottom) / (high - low)
    return slope, bottom - slope * low


def _parameters(native: _native.Block) -> BlockParameters:
    values = native.parameters
    for value in values.values():
        if isinstance(value, np.ndarray):
            value.flags.writeable = False
    return BlockParameters(**values)
