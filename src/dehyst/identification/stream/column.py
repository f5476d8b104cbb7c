"""A signal of a log that is not in memory, sliced like an array."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from threading import Lock
from typing import overload

import numpy as np
import numpy.typing as npt

from dehyst.identification.stream.spool import BLOCK
from dehyst.identification.stream.tape import Block, Tape

Array = npt.NDArray[np.float64]
Rows = npt.NDArray[np.int64]

WINDOW = 4  # blocks that are kept: x and y are asked for one after the other


class Reader:
    """Samples of a tape by number; asking forward is one pass, asking back begins another one."""

    def __init__(self, tape: Tape, advanced: Callable[[int], None] | None = None) -> None:
        self.tape = tape
        self._advanced = advanced
        self._window: deque[Block] = deque(maxlen=WINDOW)
        self._blocks: Iterator[Block] = iter(())
        self._next = tape.samples
        self._lock = Lock()

    def read(self, start: int, stop: int, which: int) -> Array:
        """x (0) or y (1) of the samples from `start` to `stop`."""
        with self._lock:  # candidates are compared on threads
            return self._read(start, stop, which)

    def _read(self, start: int, stop: int, which: int) -> Array:
        if stop <= start:
            return np.zeros(0)
        out = None
        position = start
        while position < stop:
            block = self._block(position)
            low = position - block.begin
            part = (block.y if which else block.x)[low : low + stop - position]
            if part.size == stop - start:
                return part
            if out is None:
                out = np.empty(stop - start)
            out[position - start : position - start + part.size] = part
            position += part.size
        assert out is not None
        return out

    def _block(self, position: int) -> Block:
        for block in self._window:
            if block.begin <= position < block.begin + block.x.size:
                return block
        if position < self._next or position >= self._next + self.tape.skip:
            self._window.clear()
            self._blocks = self.tape.blocks(position // BLOCK * BLOCK)
        while True:
            block = next(self._blocks)
            self._window.append(block)
            self._next = block.begin + block.x.size
            if self._advanced is not None:
                self._advanced(self._next)
            if position < self._next:
                return block


@dataclass(frozen=True)
class Column:
    """Part of a signal, scaled: (value - origin) / unit.

    Attributes
    ----------
    reader
        Where the samples come from.
    which
        0 for the input, 1 for the output.
    start, size
        First sample and number of samples.
    origin, unit
        Scaling.
    """

    reader: Reader
    which: int
    start: int
    size: int
    origin: float
    unit: float

    @overload
    def __getitem__(self, key: int) -> float: ...
    @overload
    def __getitem__(self, key: slice | Rows) -> Array: ...
    def __getitem__(self, key: int | slice | Rows) -> float | Array:
        """Samples by number, slice, or increasing numbers, (m,)."""
        if isinstance(key, slice):
            begin, end, step = key.indices(self.size)
            if step != 1:
                return self[np.arange(begin, end, step, dtype=np.int64)]
            return self._scaled(self.reader.read(self.start + begin, self.start + end, self.which))
        if isinstance(key, np.ndarray):
            return self._scaled(self._gather(self.start + key))
        place = self.start + (key if key >= 0 else self.size + key)
        return float(self._scaled(self.reader.read(place, place + 1, self.which))[0])

    def _scaled(self, values: Array) -> Array:
        scaled: Array = np.subtract(values, self.origin)
        scaled /= self.unit
        return scaled

    def _gather(self, rows: Rows) -> Array:
        out = np.empty(rows.size)
        begin = 0
        while begin < rows.size:
            block = int(rows[begin]) // BLOCK
            end = int(np.searchsorted(rows, (block + 1) * BLOCK))
            low = int(rows[begin])
            values = self.reader.read(low, int(rows[end - 1]) + 1, self.which)
            out[begin:end] = values[rows[begin:end] - low]
            begin = end
        return out
