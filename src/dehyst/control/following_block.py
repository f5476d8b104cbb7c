"""A block of any kind beside an offset that follows the last cycle."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from dehyst import _native
from dehyst.arrays import Array
from dehyst.control.images import Words, refuse, words_of
from dehyst.control.machine_block import Direction, MachineBlock, along, switched
from dehyst.errors import ParameterError
from dehyst.models.arrays import signal_array
from dehyst.models.card import SignalCard
from dehyst.models.offset import OffsetNumbers, offset_numbers


class FollowingBlock(MachineBlock[Any]):
    r"""A block whose offset follows what was measured over the last cycle.

    .. math::

        d = y_{measured} - y_{said}, \qquad
        o \to \Pi_{\pm limit}\Bigl[\tfrac{1}{n}\sum_{cycle} d\Bigr], \qquad
        |\Delta o| \le \frac{limit}{range}\,|\Delta x|

    A forward block answers y + o, an inverse one is asked for x - o: for an actuator whose loop keeps its shape and
    wanders as a whole, with temperature, load, or the zero of its sensor.

    **Cycle.** Two strokes between turning points of x, reversals by more than 5 % of its range. When a stroke ends, the
    mean over it and the one before is what o goes to: within its limit, along the way that x makes. So o rests where x
    rests, no output jumps, and the demand of an inverse turns where its reference turns.

    **Held.** While the block is off o does not change. Samples that are off or fading, limited, or without a
    measurement (NaN, None) do not count, and a stroke with more than an eighth of them teaches nothing. An answer
    depends on measurements before its own sample alone.

    Parameters
    ----------
    block
        Of any kind, in either direction; it belongs to this one from now on.
    limit
        Of the offset, a share of the output's range, above 0 and at most 0.5.

    Raises
    ------
    ParameterError
        If `limit` is none.

    Examples
    --------
    The actuator lies 0.3 above the model. After two strokes the compensator asks for as much less:

    >>> import dehyst
    >>> model = dehyst.PrandtlIshlinskii([0.0], [1.0])
    >>> block = FollowingBlock(dehyst.block(model, range=(-2.0, 2.0)), limit=0.2)
    >>> wanted = np.sin(np.linspace(0, 20, 2000))
    >>> asked = [block.step(y, block.last + 0.3) for y in wanted]
    >>> round(asked[-1] - float(wanted[-1]), 2)
    -0.3
    """

    def __init__(self, block: MachineBlock[Any], limit: float) -> None:
        self.block = block
        self.model = block.model
        self.direction: Direction = block.direction
        self.period = block.period
        ours, theirs = (block.output, block.input) if self.direction == "forward" else (block.input, block.output)
        height = _width(block.model.card.output, ours)
        self.numbers: OffsetNumbers = offset_numbers(
            limit, height, _width(theirs, theirs) if self.direction == "forward" else height
        )
        output = block.output
        if self.direction == "forward":
            wide = self.numbers.limit
            output = replace(output, low=float(output.low or 0.0) - wide, high=float(output.high or 0.0) + wide)
        self.offset: _native.Offset = self.numbers.made()
        self._inner = block._native
        self._empty = (0.0,) * (2 - len(block.given)) if block.takes_given else ()
        super().__init__(self._inner, block.input, output, block.given)

    @property
    def last(self) -> float:
        """Last good output; before the first sample that of the start. [output]"""
        return float(self._inner.output) + (self.offset.applied if self.direction == "forward" else 0.0)

    def reset(self) -> None:
        """Return to the start, without an offset and with nothing seen."""
        self._inner.reset()
        self.offset.reset()

    def step(
        self, x: float | None, *more: float | None, on: bool = True, given: Mapping[str, float] | None = None
    ) -> float:
        """Return the output for the next sample.

        Parameters
        ----------
        x
            Input. [input]
        more
            Its rate where the block of a direct inverse wants it, and last what was measured; None: nothing. [output]
        on
            Whether the model answers; otherwise the straight line does.
        given
            Scheduling variables by name.

        Raises
        ------
        ParameterError
            If one of them is no number, or one is missing.
        """
        if len(more) != self._leading:
            raise ParameterError(
                f"a sample of this block has {self._leading + 1} numbers, the last one measured; got {1 + len(more)}."
            )
        *values, _ = self._sample(given, on, x, *more)
        leading, measured = values[: self._leading], values[self._leading]
        rest = values[self._leading + 1 :] if self.block.takes_given else []
        return self._step((*leading, *rest), measured, bool(on))

    @property
    def _leading(self) -> int:
        return len(self.block.leading)

    def _step(self, values: tuple[float, ...], measured: float, on: bool) -> float:
        inner, offset, x = self._inner, self.offset, values[0]
        if self.direction == "forward":
            y = inner.step(*values, on)
            return float(y + offset.step(x, y, measured, inner.share, inner.flags, on))
        asked = x - offset.next(x, on)
        y = inner.step(asked, *values[1:], on)
        offset.step(x, asked, measured, inner.share, inner.flags, on)
        return float(y)

    def run(
        self,
        x: npt.ArrayLike,
        *more: npt.ArrayLike,
        on: npt.ArrayLike = True,
        given: Mapping[str, npt.ArrayLike] | None = None,
    ) -> tuple[Array, Words]:
        """Return outputs and flags (T,) of many samples, going on from the present state; signals as in `step`."""
        samples = signal_array(x, "input x")
        if len(more) != self._leading:
            raise ParameterError(
                f"this block has {self._leading + 1} signals, the last one measured; got {1 + len(more)}."
            )
        columns = [samples, *(along(values, samples.size, "a signal") for values in more[:-1])]
        if self.block.takes_given:
            columns += list(self._table(given, samples.size).T)
        measured = along(more[-1], samples.size, "measured").tolist()
        switches = switched(on, samples.size).tolist()
        outputs, flags = np.empty(samples.size), np.empty(samples.size, dtype=np.uint32)
        for k, row in enumerate(zip(*(column.tolist() for column in columns), strict=True)):
            outputs[k] = self._step(row, measured[k], switches[k])
            flags[k] = self._inner.flags
        return outputs, flags

    def answer(self, inputs: Array, on: npt.ArrayLike) -> tuple[Array, Words]:
        """Return outputs and flags (T,) for all inputs in their order: what was measured is the last, (T, m)."""
        own = inputs.shape[1] - 1 - len(self.given)
        given = dict(zip(self.given, inputs.T[own:-1], strict=True))
        return self.run(*inputs.T[:own], inputs[:, -1], on=np.asarray(on) != 0, given=given)

    def save(self) -> Words:
        """Return an image of the state: that of the block, then that of the offset."""
        return np.concatenate([self._inner.save(), self.offset.save()])

    def restore(self, image: npt.ArrayLike) -> None:
        """Go on from an image of `save`, bit for bit; a bad one is refused and changes nothing.

        Raises
        ------
        ParameterError
            As `restore` of a block.
        """
        words = words_of(image)
        inner, offset = words[: -_native.OFFSET_WORDS], words[-_native.OFFSET_WORDS :]
        before = self.offset.save()
        fault = self.offset.restore(offset)
        fault = fault or self._inner.restore(inner)
        if fault:
            self.offset.restore(before)
        refuse(
            fault, "Restore what save() of a block of the same model returned; this block still has the state it had."
        )

    def __repr__(self) -> str:
        """One line: the block, and the limit."""
        return f"<FollowingBlock {self.block!r}, offset within +-{self.numbers.limit:g}>"


def _width(card: SignalCard, otherwise: SignalCard) -> float:
    known = otherwise if card.low is None or card.high is None else card
    return float(known.high or 0.0) - float(known.low or 0.0)
