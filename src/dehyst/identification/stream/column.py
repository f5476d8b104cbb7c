"""A signal of a log that is not in memory, sliced like an array."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from threading import Lock
from typing import Any, overload

import numpy as np

from dehyst.arrays import Array, Rows
from dehyst.identification.stream.outline import Outline
from dehyst.identification.stream.samples import Block, Tape
from dehyst.identification.stream.spool import BLOCK

INPUT, OUTPUT, TIME = range(3)
WINDOW = 4  # blocks that are kept: signals are asked for one after the other, in parts of about a block


class Reader:
    """Samples of a tape by number; asking forward is one pass, asking back begins another one."""

    def __init__(self, tape: Tape, outline: Outline) -> None:
        self.tape, self.outline = tape, outline
        self._window: deque[Block] = deque(maxlen=WINDOW)
        self._blocks: Iterator[Block] = iter(())
        self._next = tape.samples
        self._clock = False
        self._extremes: dict[tuple[int, int, int], tuple[float, float]] = {}
        self._lock = Lock()

    def restart(self, clock: bool) -> None:
        """Begin another pass with what is asked for next, with time or without."""
        self._window.clear()
        self._next, self._clock = self.tape.samples, clock

    def read(self, start: int, stop: int, signal: int) -> Array:
        """Samples from `start` to `stop` of the input, the output or the time."""
        with self._lock:  # candidates are compared on threads
            parts = []
            position = start
            while position < stop:
                block = self._block(position)
                values = (block.x, block.y, block.time)[signal]
                assert values is not None
                parts.append(values[position - block.begin : stop - block.begin])
                position = block.end
            return parts[0] if len(parts) == 1 else np.concatenate(parts) if parts else np.zeros(0)

    def _block(self, position: int) -> Block:
        for block in self._window:
            if block.begin <= position < block.end:
                return block
        if position < self._next or position >= self._next + self.tape.skip:
            self._window.clear()
            self._blocks = self.tape.blocks(position, self._clock)
        for block in self._blocks:
            self._window.append(block)
            self._next = block.end
            self.tape.advanced(block.end)
            if position < block.end:
                return block
        raise AssertionError("asked for a sample beyond the end")

    def extremes(self, start: int, stop: int, signal: int) -> tuple[float, float]:
        """Least and largest value of the samples from `start` to `stop`: of whole buckets, and of the parts beside."""
        if (start, stop, signal) in self._extremes:  # asked for again and again, and far from where a pass is
            return self._extremes[start, stop, signal]
        low, high, begin, end = self.outline.extremes(start, stop, signal)
        for first, last in ((start, min(begin, stop)), (max(end, start), stop)) if begin < end else ((start, stop),):
            for position in range(first, last, BLOCK):
                part = self.read(position, min(position + BLOCK, last), signal)
                low, high = min(low, float(part.min())), max(high, float(part.max()))
        self._extremes[start, stop, signal] = low, high
        return low, high

    def first_beyond(self, bound: float, below: bool, start: int, stop: int) -> int:
        """Number of the first sample of the input from `start` on that reaches a bound, or `stop`."""
        position = start
        while position < stop:
            position = max(position, self.outline.first_beyond(bound, below, position))
            end = min(stop, position + BLOCK)
            if position >= stop:
                break
            part = self.read(position, end, INPUT)
            found = np.flatnonzero(part <= bound if below else part >= bound)
            if found.size:
                return position + int(found[0])
            position = end
        return stop


@dataclass(frozen=True)
class Column:
    """Part of a signal, scaled: (value - origin) / unit.

    Attributes
    ----------
    reader, signal
        Where the samples come from, and which of its signals they are.
    start, size
        First sample and number of samples.
    origin, unit
        Scaling.
    """

    reader: Reader
    signal: int
    start: int
    size: int
    origin: float
    unit: float

    @overload
    def __getitem__(self, key: int) -> Any: ...
    @overload
    def __getitem__(self, key: slice | Rows) -> Array: ...
    def __getitem__(self, key: int | slice | Rows) -> Any:
        """Samples by number, by slice of step 1, or by increasing numbers, (m,)."""
        if isinstance(key, slice):
            begin, end, step = key.indices(self.size)
            assert step == 1
            return self._scaled(self.reader.read(self.start + begin, self.start + end, self.signal))
        if isinstance(key, np.ndarray):
            return self._scaled(self._gather(self.start + key))
        return float(self._scaled(self.reader.read(self.start + key, self.start + key + 1, self.signal))[0])

    def extremes(self, span: slice) -> tuple[float, float]:
        """Least and largest value within a span."""
        found = self._scaled(
            np.array(self.reader.extremes(self.start + span.start, self.start + span.stop, self.signal))
        )
        return float(found.min()), float(found.max())

    def _scaled(self, values: Array) -> Array:
        scaled: Array = np.subtract(values, self.origin)
        scaled /= self.unit
        return scaled

    def _gather(self, rows: Rows) -> Array:
        out = np.empty(rows.size)
        begin = 0
        while begin < rows.size:
            low = int(rows[begin])
            end = int(np.searchsorted(rows, (low // BLOCK + 1) * BLOCK))
            values = self.reader.read(low, int(rows[end - 1]) + 1, self.signal)
            out[begin:end] = values[rows[begin:end] - low]
            begin = end
        return out
