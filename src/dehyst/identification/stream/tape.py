"""Samples by number: blocks of a log that come from a spool, or from its source anew."""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from dehyst.errors import LogError
from dehyst.identification.stream.source import Chunk, Source
from dehyst.identification.stream.spool import BLOCK, Spool

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Block:
    """Samples from `begin` on, at most `BLOCK`."""

    begin: int
    time: Array | None
    x: Array
    y: Array


def blocks_of(source: Source, name: str) -> Iterator[Block]:
    """Chunks of any length as blocks of `BLOCK` samples; only the last one is shorter."""
    parts: list[Chunk] = []
    held, begin = 0, 0
    for chunk in source:
        time, x, y = _checked(chunk, name)
        if x.size == 0:
            continue
        parts.append((time, x, y))
        held += x.size
        if held < BLOCK:
            continue
        joined = _join(parts)
        whole = held // BLOCK * BLOCK
        for k in range(0, whole, BLOCK):
            yield _block(begin + k, joined, slice(k, k + BLOCK))
        parts = [tuple(None if part is None else part[whole:].copy() for part in joined)] if held > whole else []  # type: ignore[list-item]
        begin, held = begin + whole, held - whole
    if held:
        yield _block(begin, _join(parts), slice(0, held))


def _checked(chunk: Chunk, name: str) -> Chunk:
    time, x, y = (None if part is None else np.asarray(part, dtype=np.float64) for part in chunk)
    if x is None or y is None or x.ndim != 1 or x.shape != y.shape or (time is not None and time.shape != x.shape):
        shapes = [None if part is None else part.shape for part in (time, x, y)]
        raise LogError(
            f"{name} gave a chunk of shapes {shapes}; a chunk is (time, x, y), three arrays of one length, with "
            f"time None for a log without one.",
            shapes=shapes,
        )
    return time, x, y


def _join(parts: list[Chunk]) -> Chunk:
    if len(parts) == 1:
        return parts[0]
    times = [time for time, _, _ in parts if time is not None]
    time = np.concatenate(times) if len(times) == len(parts) else None
    return time, np.concatenate([x for _, x, _ in parts]), np.concatenate([y for _, _, y in parts])


def _block(begin: int, chunk: Chunk, part: slice) -> Block:
    time, x, y = chunk
    return Block(begin, None if time is None else time[part], np.ascontiguousarray(x[part]), np.ascontiguousarray(y[part]))


class Tape:
    """One log, read forward as often as needed.

    Parameters
    ----------
    source
        Chunks of the log.
    name
        Used in messages.
    spool
        Where a copy is kept that is faster to read again; None reads the source itself.
    """

    def __init__(self, source: Source, name: str, spool: Spool | None = None) -> None:
        self.name, self.samples = name, 0
        self._source, self._spool = source, spool
        self._mark = 0

    @property
    def skip(self) -> int:
        """Samples that may be left out before it is faster to begin anew."""
        return 0 if self._spool is not None else self.samples

    def record(self) -> Iterator[Block]:
        """The first pass: blocks with time; afterwards `samples` is known and the other passes may begin."""
        self.samples, mark = 0, 0
        for block in blocks_of(self._source, self.name):
            if self._spool is not None:
                if block.begin % (BLOCK << 7) == 0:
                    self._spool.require(self._expected(block.begin), self.name)
                self._spool.write(block.x, block.y)
            mark = _fingerprint(mark, block)
            self.samples = block.begin + block.x.size
            yield block
        self._mark = mark

    def _expected(self, read: int) -> float:
        """Samples that are still to come, from the share of the bytes that was read."""
        size, consumed = _number(self._source, "size"), _number(self._source, "consumed")
        if not size or not consumed:
            return float(BLOCK)
        return (read + BLOCK) * max(size / consumed - 1.0, 0.0) + BLOCK

    def blocks(self, start: int = 0, stop: int | None = None) -> Iterator[Block]:
        """Blocks of the samples from `start` to `stop`, without time; their borders lie at multiples of `BLOCK`."""
        stop = self.samples if stop is None else min(stop, self.samples)
        if stop <= start:
            return
        for block in self._again(start // BLOCK * BLOCK, stop):
            low, high = max(start - block.begin, 0), min(stop - block.begin, block.x.size)
            if low < high:
                yield Block(block.begin + low, None, block.x[low:high], block.y[low:high])

    def _again(self, start: int, stop: int) -> Iterator[Block]:
        if self._spool is not None:
            for begin in range(start, stop, BLOCK):
                yield Block(begin, None, *self._spool.read(begin // BLOCK, min(BLOCK, self.samples - begin)))
            return
        mark, samples = 0, 0
        for block in blocks_of(self._source, self.name):
            mark, samples = _fingerprint(mark, block), block.begin + block.x.size
            if samples > self.samples:
                break
            if block.begin >= start:
                yield block
            if samples >= stop and stop < self.samples:
                return
        if samples != self.samples or mark != self._mark:
            raise LogError(
                f"{self.name} changed while it was read: {self.samples} samples in the first pass, then "
                f"{'others' if samples == self.samples else 'more' if samples > self.samples else samples}. Several "
                f"passes are made, so the log must stay as it is: wait until the logger has closed it, or work on a "
                f"copy.",
                samples=(self.samples, samples),
            )

    def close(self) -> None:
        """Give the spool back."""
        if self._spool is not None:
            self._spool.close()


def _fingerprint(mark: int, block: Block) -> int:
    """Checksum over some samples of each block: a log that was written anew gives another one."""
    return zlib.crc32(block.y[::511].tobytes(), zlib.crc32(block.x[::511].tobytes(), mark))


def _number(source: Any, name: str) -> float:
    value = getattr(source, name, 0)
    return float(value) if isinstance(value, (int, float)) else 0.0
