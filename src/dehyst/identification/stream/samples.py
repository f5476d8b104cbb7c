"""Access to samples of a log by number: reads blocks from the file or from a temporary copy."""

from __future__ import annotations

import zlib
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from threading import Lock
from typing import Any, overload

import numpy as np

import dehyst._native as _native
from dehyst.arrays import Array, Rows
from dehyst.errors import LogError
from dehyst.identification.stream.outline import Outline
from dehyst.identification.stream.source import BLOCK, Chunk, Source, Spool, Watch

# Blocks between two looks at the free space of the disk.
OFTEN = 128
# Every so many samples enter the checksum that tells whether a log has changed.
CHECKED = 511


@dataclass(frozen=True)
class Block:
    """Samples from number `begin` on, at most `BLOCK`; time is there in the first pass and where it was asked for."""

    begin: int
    time: Array | None
    x: Array
    y: Array

    @property
    def end(self) -> int:
        """Number of the sample after the last one."""
        return self.begin + self.x.size


class Tape:
    """One log, read forward as often as needed.

    Parameters
    ----------
    source
        Chunks of the log.
    name
        Used in messages.
    watch
        Told of what was read.
    copied, folder
        Whether a temporary copy is made, which is faster to read again, and where.
    """

    samples: int = 0  # Known after the first pass, `record`
    has_time: bool = False  # Whether the samples have time
    passes: int = 0  # Passes begun

    def __init__(self, source: Source, name: str, watch: Watch, copied: bool, folder: str | None = None) -> None:
        self.name = name
        self._source, self._watch, self._copied, self._folder = source, watch, copied, folder
        self._spool: Spool | None = None
        self._mark = 0

    @property
    def skip(self) -> int:
        """Samples that may be left out before it is faster to begin anew."""
        return 0 if self._spool is not None else self.samples

    def record(self) -> Iterator[Block]:
        """Blocks of the first pass, with time."""
        self.samples, self.passes, mark = 0, 1, 0
        for block in blocks_of(self._source, self.name):
            if self._copied:
                self._copy(block)
            mark = _fingerprint(mark, block)
            self.samples, self.has_time = block.end, block.time is not None
            self._watch.read(self.samples, _number(self._source, "consumed"), _number(self._source, "size"))
            yield block
        self._mark = mark

    def _copy(self, block: Block) -> None:
        signals = (block.x, block.y) if block.time is None else (block.x, block.y, block.time)
        if self._spool is None:
            self._spool = Spool(self._folder, len(signals))
        if block.begin % (BLOCK * OFTEN) == 0:
            self._spool.require(self._expected(block.begin), self.name)
        self._spool.write(signals)

    def _expected(self, read: int) -> float:
        """Samples that are still to come, from the share of the bytes that was read."""
        size, consumed = _number(self._source, "size"), _number(self._source, "consumed")
        left = max(size / consumed - 1.0, 0.0) if size and consumed else 0.0
        return left * (read + BLOCK) + BLOCK

    def blocks(self, start: int = 0, clock: bool = False) -> Iterator[Block]:
        """Blocks from the one that holds sample `start` on; with time if it is asked for, and there."""
        self.passes += 1
        if self._spool is not None:
            signals = 3 if self.has_time and clock else 2
            for begin in range(start // BLOCK * BLOCK, self.samples, BLOCK):
                values = self._spool.read(begin // BLOCK, min(BLOCK, self.samples - begin), signals)
                yield Block(begin, values[2] if signals == 3 else None, values[0], values[1])
            return
        mark, samples = 0, 0
        for block in blocks_of(self._source, self.name):
            mark, samples = _fingerprint(mark, block), block.end
            if samples > self.samples:
                break
            if block.end > start:
                if samples == self.samples:  # before it is used, not after
                    self._confirm(mark, samples)
                yield block
        self._confirm(mark, samples)

    def _confirm(self, mark: int, samples: int) -> None:
        if samples == self.samples and mark == self._mark:
            return
        then = "others" if samples == self.samples else "more" if samples > self.samples else str(samples)
        raise LogError(
            f"{self.name} changed while it was read: {self.samples} samples in the first pass, then {then}. Several "
            f"passes are made, so the log must stay as it is: wait until the logger has closed it, or work on a copy.",
            samples=(self.samples, samples),
        )

    def advanced(self, samples: int) -> None:
        """Tell whoever watches how far a pass has come."""
        self._watch.advance(samples, self.samples)

    def close(self) -> None:
        """Give the temporary copy back."""
        if self._spool is not None:
            self._spool.close()


def blocks_of(source: Source, name: str) -> Iterator[Block]:
    """Chunks of any length as blocks of `BLOCK` samples; only the last one is shorter."""
    parts: list[Chunk] = []
    held, begin = 0, 0
    for chunk in source:
        parts.append(_checked(chunk, name))
        held += parts[-1][1].size
        if held < BLOCK:
            continue
        time, x, y = _joined(parts, name)
        whole = held // BLOCK * BLOCK
        for k in range(0, whole, BLOCK):
            part = slice(k, k + BLOCK)
            yield Block(begin + k, None if time is None else time[part], x[part], y[part])
        # A copy, so that the large chunk it is a part of can go.
        parts = [(None if time is None else time[whole:].copy(), x[whole:].copy(), y[whole:].copy())]
        begin, held = begin + whole, held - whole
    if held:
        yield Block(begin, *_joined(parts, name))


def _checked(chunk: Chunk, name: str) -> Chunk:
    try:
        time, x, y = (None if part is None else np.ascontiguousarray(part, dtype=np.float64) for part in chunk)
    except (TypeError, ValueError) as fault:
        raise LogError(
            f"{name} gave a chunk that is not (time, x, y), three arrays of numbers of one length ({fault}). Files are "
            f"opened by dehyst.open_chunks(path, input=..., output=...)."
        ) from None
    if x is None or y is None or x.ndim != 1 or x.shape != y.shape or (time is not None and time.shape != x.shape):
        shapes = [None if part is None else part.shape for part in (time, x, y)]
        raise LogError(
            f"{name} gave a chunk of shapes {shapes}; a chunk is (time, x, y), three arrays of one length, with "
            f"time None for a log without one.",
            shapes=shapes,
        )
    for part in (time, x, y):
        if part is not None and not np.all(np.abs(part) <= _native.INPUT_LIMIT):
            raise LogError(
                f"{name} gave a chunk with values that are not finite, or beyond {_native.INPUT_LIMIT:g}; a play would "
                f"carry them into every later sample. Leave such samples out of the chunks; dehyst.open_chunks does."
            )
    return time, x, y


def _joined(parts: list[Chunk], name: str) -> Chunk:
    parts = [part for part in parts if part[1].size] or parts[:1]
    if len(parts) == 1:
        return parts[0]
    times = [time for time, _, _ in parts if time is not None]
    if 0 < len(times) < len(parts):
        raise LogError(f"{name} gave chunks with time and chunks without; give it with all of them, or with none.")
    time = np.concatenate(times) if times else None
    return time, np.concatenate([x for _, x, _ in parts]), np.concatenate([y for _, _, y in parts])


def _fingerprint(mark: int, block: Block) -> int:
    """Checksum over some samples of each block: a log that was written anew gives another one."""
    return zlib.crc32(block.y[::CHECKED].tobytes(), zlib.crc32(block.x[::CHECKED].tobytes(), mark))


def _number(source: Any, name: str) -> float:
    value = getattr(source, name, 0)
    return float(value) if isinstance(value, (int, float)) else 0.0


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
    """Part of a signal, scaled: (value - origin) / unit."""

    # reader, signal: Where the samples come from, and which of its signals they are
    reader: Reader
    signal: int
    # start, size: First sample and number of samples
    start: int
    size: int
    # origin, unit: Scaling
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
