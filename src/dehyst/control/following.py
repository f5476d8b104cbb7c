"""An offset that follows the last cycle, around what the core runs."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

import dehyst._native as _native
from dehyst.arrays import Array
from dehyst.control.images import Words
from dehyst.models.card import ModelCard, SignalCard
from dehyst.models.machine import Direction, Machine
from dehyst.models.offset import OffsetNumbers, offset_numbers, width

MEASURED = "measured"


def followed(machine: Machine, card: ModelCard, direction: Direction, limit: float) -> Machine:
    """Return the machine with an offset that follows the last cycle; what was measured is its last input."""
    forward = direction == "forward"
    ours, theirs = (machine.output, machine.input) if forward else (machine.input, machine.output)
    height = width(card.output, np.array((ours.low, ours.high), float))
    numbers = offset_numbers(limit, height, width(theirs, ()) if forward else height)
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

    def reset(self) -> None:
        """Return to the start, without an offset and with nothing seen."""
        self._inner.reset()
        self.offset.reset()

    def step(self, x: float | None, *more: Any) -> float:
        """Return the output for x, further inputs, what was measured, and the switch."""
        *others, measured, on = more
        values = [float("nan") if value is None else float(value) for value in (x, *others, measured)]
        return self._step(values[0], values[1:-1], values[-1], on)

    def _step(self, x: float, others: list[float], measured: float, on: bool) -> float:
        inner, offset = self._inner, self.offset
        if self._forward:
            y = inner.step(x, *others, *self._empty, on)
            return float(y + offset.step(x, y, measured, inner.share, inner.flags, on))
        asked = x - offset.next(x, on)
        y = inner.step(asked, *others, *self._empty, on)
        offset.step(x, asked, measured, inner.share, inner.flags, on)
        return float(y)

    def run(self, x: Array, table: Array, on: npt.NDArray[np.bool_]) -> tuple[Array, Words]:
        """Return outputs and flags (T,), sample by sample in Python: about 3 us each, ten times as long as without."""
        outputs, flags = np.empty(x.size), np.empty(x.size, dtype=np.uint32)
        for k, (value, row, switch) in enumerate(zip(x.tolist(), table.tolist(), on.tolist(), strict=True)):
            outputs[k] = self._step(value, row[:-1], row[-1], switch)
            flags[k] = self._inner.flags
        return outputs, flags

    def save(self) -> Words:
        """Return an image of the state: that of the block, then that of the offset."""
        return np.concatenate([self._inner.save(), self.offset.save()])

    def restore(self, words: Words) -> int:
        """Go on from an image of `save`; a bad one is answered with its fault and changes nothing."""
        before = self.offset.save()
        fault = self.offset.restore(words[-_native.OFFSET_WORDS :])
        fault = fault or self._inner.restore(words[: -_native.OFFSET_WORDS])
        if fault:
            self.offset.restore(before)
        return int(fault)
