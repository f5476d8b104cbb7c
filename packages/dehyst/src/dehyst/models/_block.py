"""A model or its inverse as a function block: limited output, bumpless switching, state that can be saved."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any, cast

import numpy as np
import numpy.typing as npt

import dehyst._native as _native
from dehyst.arrays import Array
from dehyst.errors import ParameterError
from dehyst.models._arrays import signal_array
from dehyst.models._card import ModelCard, SignalCard
from dehyst.models._machine import Direction, Machine
from dehyst.models._model import Model, positive_period, require_model
from dehyst.models._offset import OffsetNumbers, offset_numbers, range_width

MEASURED = "measured"


Words = npt.NDArray[np.uint32]

_FAULTS = {  # answers of the core, as in packages/dehyst/core/dehyst.h
    1: ("size", "it has another length: cut off, or of a model with another number of operators"),
    2: ("kind", "it is no image of such a state in double precision"),
    3: ("damaged", "its checksum is wrong"),
    4: ("foreign", "it was saved with another model or other parameters"),
    5: ("invalid", "it holds a state that cannot be here"),
}


def refuse_image(answer: int, cure: str) -> None:
    """Raise ParameterError with the fault's name as ``facts["fault"]`` unless the core's answer is good."""
    if answer:
        fault, reason = _FAULTS[answer]
        raise ParameterError(f"the state was not restored: {reason}. {cure}", fault=fault)


def words_of(image: npt.ArrayLike) -> Words:
    """Return an image as 32-bit words, or refuse_image what is none."""
    words = np.asarray(image)
    integers = words.ndim == 1 and words.dtype.kind in "iu"
    if not integers or np.any((words < 0) | (words >= 2**32)):
        raise ParameterError(
            f"the state was not restored: an image is an array of 32-bit words, (m,), not {type(image).__name__} of "
            f"shape {words.shape} and type {words.dtype}; pass what save() returned.",
            fault="kind",
        )
    return cast(Words, np.ascontiguousarray(words, dtype=np.uint32))


def followed(machine: Machine, card: ModelCard, direction: Direction, limit: float) -> Machine:
    """Return the machine with an offset that follows the last cycle; what was measured is its last input."""
    forward = direction == "forward"
    # The signal of the actuator's output: what a forward block answers, and what an inverse one is asked for.
    answered = machine.output if forward else machine.input
    height = range_width(card.output, np.array((answered.low, answered.high), float))
    way = range_width(machine.input, ()) if forward else height
    numbers = offset_numbers(limit, height, way)
    # The offset adds to what a forward block answers, so that its output may go further by its limit.
    wide = numbers.limit if forward else 0.0
    low, high = float(machine.output.low or 0.0) - wide, float(machine.output.high or 0.0) + wide
    return replace(
        machine, native=Following(machine, numbers, forward), output=replace(machine.output, low=low, high=high),
        more=(*machine.more, SignalCard(MEASURED, card.output.unit, None, None)), slots=len(machine.more) + 1,
        defaults={**machine.defaults, MEASURED: float("nan")},
    )  # fmt: skip


class Following:
    """A block of the core beside an offset, called as one of the core's; the last further input is what was measured.

    Parameters
    ----------
    machine
        What it stands around; the block belongs to this one from now on.
    numbers
        Of the offset.
    forward
        Whether the offset is added to the answer; otherwise it is taken off what is asked for.
    """

    def __init__(self, machine: Machine, numbers: OffsetNumbers, forward: bool) -> None:
        self.numbers = numbers
        # The core's block and the core's offset are kept apart: each has its own image of its state.
        self.offset: _native.Offset = numbers.made()
        self._inner: Any = machine.native
        self._empty = [0.0] * (machine.slots - len(machine.more))
        self._forward = forward

    @property
    def share(self) -> float:
        """Present share of the model, 0 to 1."""
        return float(self._inner.share)

    @property
    def flags(self) -> int:
        """Flags after the last sample."""
        return int(self._inner.flags)

    @property
    def state(self) -> Array:
        """Play states (n,), of a model of plays."""
        return np.asarray(self._inner.state)

    @property
    def doubt(self) -> float:
        """Half width for the unknown past, of a direct inverse."""
        return float(self._inner.doubt)

    @property
    def output(self) -> float:
        """Last good output."""
        return float(self._inner.output) + (self.offset.applied if self._forward else 0.0)

    def observe(self, x: float | None, answer: float | None, *scheduling: float | None) -> None:
        """Follow a sample that something else made: what would have gone in, and what would have come out."""
        # The offset is a part of what the actuator's output shows, but not of what the model says.
        shift = self.offset.applied
        if self._forward:
            self._inner.observe(x, None if answer is None else answer - shift, *scheduling)
        else:
            self._inner.observe(None if x is None else x - shift, answer, *scheduling)

    def reset(self) -> None:
        """Return to the start, without an offset and with nothing seen."""
        self._inner.reset()
        self.offset.reset()

    def step(self, x: float | None, *more: Any) -> float:
        """Return the output for x, further inputs, what was measured, and the switch."""
        # What was measured is the last of the further inputs, the switch comes behind it.
        *inputs, on = more
        values = []
        for value in (x, *inputs):
            # A sensor without an answer is a rejected sample.
            values.append(float("nan") if value is None else float(value))
        return self._step(values[0], values[1:-1], values[-1], on)

    def _step(self, x: float, scheduling: list[float], measured: float, on: bool) -> float:
        inner, offset = self._inner, self.offset
        if self._forward:
            y = inner.step(x, *scheduling, *self._empty, on)
            return float(y + offset.step(x, y, measured, inner.share, inner.flags, on))
        # An inverse block needs the offset before it answers: it is taken off what is asked for.
        asked = x - offset.next(x, on)
        y = inner.step(asked, *scheduling, *self._empty, on)
        offset.step(x, asked, measured, inner.share, inner.flags, on)
        return float(y)

    def run(self, x: Array, table: Array, on: npt.NDArray[np.bool_]) -> tuple[Array, Words]:
        """Return outputs and flags (T,), sample by sample in Python: about 3 us each, ten times as long as without."""
        # The offset of a sample depends on the answer of the sample before, so that no array operation can do this.
        outputs, flags = np.empty(x.size), np.empty(x.size, dtype=np.uint32)
        for k, (value, row, switch) in enumerate(
            zip(x.tolist(), table.tolist(), on.tolist(), strict=True)
        ):
            outputs[k] = self._step(value, row[:-1], row[-1], switch)
            flags[k] = self._inner.flags
        return outputs, flags

    def save(self) -> Words:
        """Return an image of the state: that of the block, then that of the offset."""
        return np.concatenate([self._inner.save(), self.offset.save()])

    def restore(self, words: Words) -> int:
        """Go on from an image of `save`; a bad one is answered with its fault and changes nothing."""
        # The offset is restored first, and put back if the image of the block is bad.
        before = self.offset.save()
        fault = self.offset.restore(words[-_native.OFFSET_WORDS :])
        fault = fault or self._inner.restore(words[: -_native.OFFSET_WORDS])
        if fault:
            self.offset.restore(before)
        return int(fault)


BLOCK_FLAGS: Mapping[str, int] = MappingProxyType(
    {
        "rejected": _native.BLOCK_REJECTED,
        "rejected-ever": _native.BLOCK_REJECTED_EVER,
        "limited": _native.BLOCK_LIMITED,
        "limited-ever": _native.BLOCK_LIMITED_EVER,
    }
)
"""Bits of a block's flags by name; those with "ever" stay until a reset."""

LONGEST_RAMP = 10**9  # samples


class Block:
    r"""A model or its inverse as a function block: what runs on a machine, and what is exported.

    .. math::

        y = s \, \Gamma[\min(\max(x, x_0), x_1)] + (1 - s)(a + b x), \qquad y_0 \le y \le y_1

    Gamma is the model or its inverse, s the share of it (1 on, 0 off), a + b x a straight line.

    It runs a model of any family that the core knows, at the period that it was made for where time counts.

    **Limits.** An inverse block asks for inputs of the actuator within `range` and for no other; a forward block takes
    them, answers what the model reaches from there, and never holds back. A wanted output beyond what the actuator can
    do is where a plain inverse goes wrong: it asks for too much, believes that it was given, and its memory is not that
    of the actuator any more, so that it errs long after the limit was left. An inverse block holds its own input back
    at the point where its output meets the limit: its memory stays that of an actuator that got what it answered.

    **Switching.** `on` may change at any sample: s runs from 0 to 1 or back in `ramp` samples, so that no output jumps
    by more than the model or the line moved and 1/`ramp` of the distance between both. The states follow the input in
    either case, as if the block were on. The first sample after a reset begins where it is told to.

    **Guard.** A sample with a number that is not finite is rejected: the last good output is held, no state moves, a
    flag rises.

    In range and on, outputs of a model of plays have the bits of ``model.inverse().stepper("dense")`` or
    ``model.stepper("dense")``. What creeps or depends on the rate begins at its first good sample as ``model.before``
    says, a direct inverse at rest there.

    **Offset.** With `follow_offset` the block follows what was measured over the last cycle,

    .. math::

        d = y_{measured} - y_{said}, \qquad
        o \to \Pi_{\pm limit}\Bigl[\tfrac{1}{n}\sum_{cycle} d\Bigr], \qquad
        |\Delta o| \le \frac{limit}{range}\,|\Delta x|

    A forward block answers y + o, an inverse one is asked for x - o: for an actuator whose loop keeps its shape and
    wanders as a whole, with temperature, load, or the zero of its sensor. A cycle is two strokes between turning points
    of x, reversals by more than 5 % of its range; when a stroke ends, the mean over it and the one before is what o
    goes to, along the way that x makes. So o rests where x rests, no output jumps, and the demand of an inverse turns
    where its reference turns. While the block is off o does not change. Samples that are off or fading, limited, or
    without a measurement do not count, and a stroke with more than an eighth of them teaches nothing. An answer depends
    on measurements before its own sample alone. What was measured is given as "measured"; left out, NaN or None:
    nothing.

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
    period
        Between two samples, where time counts; None takes that of the log. [s]
    follow_offset
        Limit of the offset, a share of the output's range, above 0 and at most 0.5; None: nothing is followed.

    Raises
    ------
    ParameterError
        If `model` is no model, no target can run it, no range is known, or a setting makes no sense.
    InvertibilityError
        If an inverse is asked for and the model has none.

    Examples
    --------
    The actuator takes 0 to 1 V. The reference goes further than it can follow, and comes back:

    >>> from dehyst import PrandtlIshlinskii
    >>> from dehyst.models import BLOCK_FLAGS
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

    The actuator lies 0.3 above the model. After two strokes the compensator asks for as much less:

    >>> block = Block(PrandtlIshlinskii([0.0], [1.0]), range=(-2.0, 2.0), follow_offset=0.2)
    >>> wanted = np.sin(np.linspace(0, 20, 2000))
    >>> asked = [block.step(y, given={"measured": block.last + 0.3}) for y in wanted]
    >>> round(asked[-1] - float(wanted[-1]), 2)
    -0.3
    """

    def __init__(
        self,
        model: Model,
        direction: Direction = "inverse",
        range: tuple[float, float] | None = None,
        ramp: int = 500,
        *,
        period: float | None = None,
        follow_offset: float | None = None,
    ) -> None:
        require_model(
            model, "a hysteresis model: fit.model, or what dehyst.load('model.json') returns"
        )
        if direction not in ("inverse", "forward"):
            raise ParameterError(
                f"direction = {direction!r:.40} is none; pass 'inverse' (wanted output in, needed input out) or "
                f"'forward'."
            )
        # True and False are integers of Python, but no numbers of samples.
        whole = isinstance(ramp, int | np.integer) and not isinstance(ramp, bool)
        if not whole or not 1 <= ramp <= LONGEST_RAMP:
            raise ParameterError(
                f"ramp = {ramp!r:.40} is no number of samples; pass a whole one from 1 (at once) to "
                f"{LONGEST_RAMP:.0e}, for example 500.",
                ramp=ramp,
            )
        self.ramp = int(ramp)
        self.model = model
        self.direction: Direction = direction
        if period is not None:
            period = positive_period(period)
        self._machine = model.machine(direction, range, self.ramp, period)
        if follow_offset is not None:
            self._machine = followed(self._machine, model.card, direction, follow_offset)
        self._native = self._machine.native

    @property
    def input(self) -> SignalCard:
        """Name, unit and limits of what goes in."""
        return self._machine.input

    @property
    def output(self) -> SignalCard:
        """Name, unit and limits of what comes out."""
        return self._machine.output

    @property
    def more(self) -> tuple[SignalCard, ...]:
        """Name, unit and range of each further input."""
        return self._machine.more

    @property
    def given(self) -> tuple[str, ...]:
        """Names of the further inputs, in their order."""
        return tuple(card.name for card in self.more)

    @property
    def period(self) -> float:
        """Between two samples, of a block that is made for one; 0 of plays. [s]"""
        return self._machine.period

    @property
    def timed(self) -> bool:
        """Whether answers depend on the period."""
        return self._machine.timed

    @property
    def share(self) -> float:
        """Present share of the model in the output: 0 off, 1 on."""
        return float(self._native.share)

    @property
    def last(self) -> float:
        """Last good output; before the first sample that of the start. [output]"""
        return float(self._native.output)

    @property
    def flags(self) -> int:
        """Sum of the bits in `BLOCK_FLAGS` after the last sample."""
        return int(self._native.flags)

    @property
    def parameters(self) -> Any:
        """What the core's block was made of, with the bits that are used; of plays `BlockParameters`."""
        return self._machine.parameters

    @property
    def following(self) -> Following | None:
        """The offset that follows the last cycle, if there is one."""
        if isinstance(self._native, Following):
            return self._native
        return None

    @property
    def state(self) -> Array:
        """Play states z (n,) of a model of plays, a copy. [argument of the operator]"""
        return np.asarray(self._native.state)

    @property
    def doubt(self) -> float:
        """Guaranteed half width of what a direct inverse answers, for the unknown past. [output]"""
        return float(self._native.doubt)

    @property
    def saved(self) -> bool:
        """Whether its state has an image: all but that of a direct inverse."""
        return self._machine.saved

    def step(
        self, x: float | None, on: bool = True, given: Mapping[str, float | None] | None = None
    ) -> float:
        """Return the output for the next sample.

        Parameters
        ----------
        x
            Input; None, for a sensor without an answer, is a rejected sample. [input]
        on
            Whether the model answers; otherwise the straight line does.
        given
            Further inputs by name: scheduling variables, the "rate" of a direct inverse, 0 if it is left out, and what
            was "measured".

        Raises
        ------
        ParameterError
            If one of them is no number, or a scheduling variable is missing.
        """
        inputs = self._further_inputs(given)
        try:
            return float(self._native.step(x, *inputs, bool(on)))
        except (TypeError, ValueError, OverflowError):
            raise ParameterError(
                f"a sample is one number, or None for a sensor without an answer, and so is the switch True or False; "
                f"got {type(x).__name__} and {type(on).__name__}. Whole signals go through run()."
            ) from None

    def observe(
        self,
        applied: float | None,
        measured: float | None,
        given: Mapping[str, float | None] | None = None,
    ) -> None:
        r"""Follow the actuator for a sample in which something else drives it, in place of `step`.

        .. math::

            x_{most} - r \le z \le x_{least} + r, \qquad
            z \leftarrow \Pi\Bigl[z + \tfrac14 \frac{c\,b\,e}{\sum c^2 b}\Bigr]

        The memory follows the input that was applied. A play z that no stroke has reached yet lies between two bounds,
        b apart, of which the input up to now tells. What is missing to the measured output, e, moves each by its weight
        c and its b, and never out of its bounds. After a stroke over 2r a play of radius r is known, and moved by the
        input alone. The next step that is on goes on from there, without a ramp. Steps that are off make nothing known.

        Parameters
        ----------
        applied
            Input that the actuator got. [input of the actuator]
        measured
            Its output; None or NaN: nothing is learnt, the input is followed alone. For an actuator with a dead time it
            is the output that belongs to this input. [output of the actuator]
        given
            Scheduling variables by name.

        Raises
        ------
        ParameterError
            If the block is of another kind than a sum of elements, or something is no number.

        Examples
        --------
        An actuator comes from the top of its range, and its compensator does not know that:

        >>> from dehyst.families.kit import ElementModel
        >>> model = ElementModel([("input", 0.0, 0.0, 0.5), ("play", 0.4, 0.0, 0.5)])
        >>> block, actuator = (Block(model, what, range=(-1.0, 1.0)) for what in ("inverse", "forward"))
        >>> u = np.concatenate([np.linspace(1.0, 0.0, 50), np.linspace(0.0, 0.3, 50)])
        >>> y = [actuator.step(value) for value in u]
        >>> for applied, measured in zip(u[50:], y[50:], strict=True):
        ...     block.observe(applied, measured)
        >>> round(block.step(y[-1]), 6), round(Block(model, range=(-1.0, 1.0)).step(y[-1]), 6)
        (0.3, 0.35)
        """
        if not self._machine.observes:
            raise ParameterError(
                f"a block of {self.model.family!r} has no observe(): that is for sums of elements. Step it with the "
                f"measured output while something else drives the actuator, block.step(measured, on=False); its memory "
                f"follows that."
            )
        inputs = self._further_inputs(given)
        if self.following is not None:
            inputs = [*inputs[:-1], *[0.0] * (_native.DIRECT_GIVEN - len(inputs) + 1)]
        pair = (measured, applied) if self.direction == "inverse" else (applied, measured)
        try:
            self._native.observe(*pair, *inputs)
        except (TypeError, ValueError, OverflowError):
            raise ParameterError(
                f"what was applied and measured is a number each, or None; got {type(applied).__name__} and "
                f"{type(measured).__name__}."
            ) from None

    def run(
        self,
        x: npt.ArrayLike,
        on: npt.ArrayLike = True,
        given: Mapping[str, npt.ArrayLike] | None = None,
    ) -> tuple[Array, Words]:
        """Return outputs and flags of many samples, going on from the present state.

        Parameters
        ----------
        x
            Inputs, (T,). [input]
        on
            Whether the model answers, (T,) or one value for all.
        given
            Further inputs by name, (T,) or a number each.

        Returns
        -------
        y : (T,)
            Outputs, with the bits of `step`. [output]
        flags : (T,)
            Sums of the bits in `BLOCK_FLAGS`.

        Raises
        ------
        ParameterError
            If lengths differ, values are no numbers, or a scheduling variable is missing.
        """
        samples = signal_array(x, "input x")
        y, flags = self._native.run(
            samples, *self._table(given, samples.size), switched(on, samples.size)
        )
        return y, flags

    def answer(self, inputs: Array, on: npt.ArrayLike) -> tuple[Array, Words]:
        """Return outputs and flags (T,) for all inputs in their order, (T, m)."""
        further = dict(zip(self.given, inputs.T[1:], strict=True))
        return self.run(inputs[:, 0], np.asarray(on) != 0, further)

    def reset(self) -> None:
        """Return to the start, flags cleared; the next good sample begins there and switches at once."""
        self._native.reset()

    def save(self) -> Words:
        """Return an image of the state, 32-bit words with a checksum: the same as the exported C code saves."""
        image: Words = self._native.save()
        return image

    def restore(self, image: npt.ArrayLike) -> None:
        """Go on from an image of `save`, bit for bit.

        Raises
        ------
        ParameterError
            If the image is damaged, of another model, or holds an impossible state; ``error.facts["fault"]`` says
            which: "size", "kind", "damaged", "foreign" or "invalid". The block keeps the state that it had.
        """
        refuse_image(
            self._native.restore(words_of(image)),
            "Restore what save() of a block of the same model returned; this block still has the state it had.",
        )

    def dump(self) -> Words:
        """Return an image of all parameters of a block of plays, as the C function dehyst_block_load reads it."""
        image: Words = self._native.dump()
        return image

    def __repr__(self) -> str:
        """One line: direction, signals and their limits."""
        return (
            f"<Block {self.direction} of {self.model.family!r}: {self.input!s} -> {self.output!s}>"
        )

    def _further_inputs(self, inputs: Mapping[str, float | None] | None) -> list[float | None]:
        """Return the further inputs of a sample as the core takes them."""
        if not self._machine.slots:
            return []
        # The core takes as many as it has slots; those that this model does not use are 0.
        values = self._ordered(inputs)
        return [*values, *[0.0] * (self._machine.slots - len(values))]

    def _table(self, inputs: Mapping[str, npt.ArrayLike] | None, samples: int) -> tuple[Array, ...]:
        """Return the further inputs of many samples as the core takes them, (T, slots), if it takes any."""
        table = np.zeros((samples, self._machine.slots))
        for column, (name, values) in enumerate(
            zip(self.given, self._ordered(inputs), strict=True)
        ):
            table[:, column] = per_sample(values, samples, name)
        return (table,) if table.shape[1] else ()

    def _ordered(self, inputs: Mapping[str, Any] | None) -> list[Any]:
        """Return the further inputs in the order of the block, or refuse if one is missing."""
        values = {**self._machine.defaults, **(inputs or {})}
        for name in self.given:
            if name not in values:
                raise ParameterError(
                    f"the model depends on '{name}', which was not given. Pass given={{'{name}': value}}."
                )
        return [values[name] for name in self.given]


def per_sample(values: npt.ArrayLike, samples: int, name: str) -> Array:
    """Return one value for all samples, or one for each, as an array (T,)."""
    array = np.asarray(values)
    if array.dtype.kind not in "biuf" or array.shape not in ((), (samples,)):
        raise ParameterError(
            f"{name} has shape {array.shape} and type {array.dtype} for {samples} samples; pass a number a sample, or "
            f"one for all."
        )
    return np.ascontiguousarray(np.broadcast_to(array.astype(np.float64), (samples,)))


def switched(on: npt.ArrayLike, samples: int) -> npt.NDArray[np.bool_]:
    """Return whether the model answers, (T,)."""
    values = np.asarray(on)
    fits = values.dtype.kind in "biuf" and values.shape in ((), (samples,))
    if not fits or np.any((values != 0) & (values != 1)):
        raise ParameterError(
            f"on has shape {values.shape} and type {values.dtype} for {samples} samples; pass True or False, or one of "
            f"them a sample. A block takes no time stamps: it runs at its own period."
        )
    return np.ascontiguousarray(np.broadcast_to(values != 0, (samples,)))
