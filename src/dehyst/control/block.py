"""A model or its inverse as a function block of a machine: bounded, switched without a bump, saved and restored."""

from __future__ import annotations

import hashlib
import struct
from dataclasses import dataclass, fields, replace

import numpy as np

from dehyst import _native
from dehyst.arrays import Array
from dehyst.control.images import Words
from dehyst.control.machine_block import Direction, SavedBlock, declared_range, refuse_direction, refuse_ramp
from dehyst.control.reach import Operator
from dehyst.errors import ParameterError
from dehyst.models import HysteresisModel


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


class Block(SavedBlock[_native.Block]):
    r"""A model or its inverse as a function block: what runs on a machine, and what is exported.

    .. math::

        y = s \, \Gamma[\min(\max(x, x_0), x_1)] + (1 - s)(a + b x), \qquad y_0 \le y \le y_1

    Gamma is the model or its inverse, s the share of it (1 on, 0 off), a + b x a straight line.

    **Limits.** An inverse block asks for inputs of the actuator within `range` and for no other; a forward block takes
    them, answers what the model reaches from there, and never holds back. A wanted output beyond what the actuator can
    do is where a plain inverse goes wrong: it asks for too much, believes that it was given, and its memory is not that
    of the actuator any more, so that it errs long after the limit was left. An inverse block holds its own input back
    at the point where its output meets the limit: its memory stays that of an actuator that got what it answered.

    **Switching.** `on` may change at any sample: s runs from 0 to 1 or back in `ramp` samples, so that no output jumps
    by more than the model or the line moved and 1/`ramp` of the distance between both. The states follow the input in
    either case, as if the block were on. The first sample after a reset begins where it is told to.

    **Guard.** A sample that is not finite is rejected: the last good output is held, no state moves, a flag rises.

    In range and on, outputs have the bits of ``model.inverse().stepper("dense")`` or ``model.stepper("dense")``.

    Parameters
    ----------
    model
        From the actuator's input to its output, for both directions. It starts in the model's state.
    direction
        "inverse": wanted output in, needed input out. "forward": applied input in, expected output out.
    range
        Smallest and largest input of the actuator; None takes the range in which the model was identified. [input]
    ramp
        Samples that switching takes, at least 1.

    Raises
    ------
    ParameterError
        If `model` is no model, no range is known, or a setting makes no sense.
    InvertibilityError
        If an inverse is asked for and the model has none.

    Examples
    --------
    The actuator takes 0 to 1 V. The reference goes further than it can follow, and comes back:

    >>> from dehyst import PrandtlIshlinskii
    >>> from dehyst.control import BLOCK_FLAGS
    >>> model = PrandtlIshlinskii([0.0, 0.2], [1.0, 1.0])
    >>> block = Block(model, range=(0.0, 1.0))
    >>> wanted = [0.0, 1.0, 3.0, 1.5, 0.9]
    >>> needed, flags = block.run(wanted)
    >>> needed.round(3).tolist(), (flags & BLOCK_FLAGS["limited"]).tolist()
    ([0.0, 0.6, 1.0, 0.7, 0.35], [0, 0, 4, 0, 0])
    >>> model.simulate(needed).round(3).tolist()
    [0.0, 1.0, 1.8, 1.5, 0.9]

    A plain inverse whose output is cut off remembers what never was, and errs on the way back:

    >>> model.simulate(model.inverse().simulate(wanted).clip(0.0, 1.0)).round(3).tolist()
    [0.0, 1.0, 1.8, 1.45, 0.9]
    """

    def __init__(
        self,
        model: HysteresisModel,
        direction: Direction = "inverse",
        range: tuple[float, float] | None = None,
        ramp: int = 500,
    ) -> None:
        _check(model)
        refuse_direction(direction)
        refuse_ramp(ramp)
        low, high = declared_range(model.card.input, range)
        self.model: HysteresisModel = model
        self.direction: Direction = direction
        self.ramp = int(ramp)
        self.operator = _started(model, low, high) if direction == "inverse" else model
        native = _native.Block(_image(model, self.operator, low, high, self.ramp))
        self.parameters = p = _parameters(native)
        card = self.operator.card
        super().__init__(
            native,
            replace(card.input, low=p.input_low, high=p.input_high),
            replace(card.output, low=p.output_low, high=p.output_high),
        )

    takes_given = False

    @property
    def state(self) -> Array:
        """Play states z (n,), a copy. [argument of the operator]"""
        return self._native.state

    def step(self, x: float | None, on: bool = True) -> float:
        """Return the output for the next sample.

        Parameters
        ----------
        x
            Input; None, for a sensor without an answer, is a rejected sample. [input]
        on
            Whether the model answers; otherwise the straight line does.

        Raises
        ------
        ParameterError
            If `x` is not one number.
        """
        try:
            return self._native.step(x, bool(on))
        except (TypeError, ValueError, OverflowError):
            raise ParameterError(
                f"a sample is one number, or None for a sensor without an answer, and so is the switch True or False; "
                f"got {type(x).__name__} and {type(on).__name__}. Whole signals go through run()."
            ) from None

    def dump(self) -> Words:
        """Return an image of all parameters, as the C function dehyst_block_load reads it."""
        return self._native.dump()


def _check(model: HysteresisModel) -> None:
    if not isinstance(model, HysteresisModel):
        raise ParameterError(
            f"a Block runs a hysteresis model of plays, not a {type(model).__name__}. dehyst.block(model, ...) makes "
            f"the block of any model."
        )


def _of(model: HysteresisModel) -> Operator:
    return Operator(*model.stepper("dense").parameters)


def _started(model: HysteresisModel, low: float, high: float) -> HysteresisModel:
    """Inverse of the model, started where an actuator is that was brought into its range."""
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


def _image(model: HysteresisModel, stepped: HysteresisModel, low: float, high: float, ramp: int) -> Words:
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
