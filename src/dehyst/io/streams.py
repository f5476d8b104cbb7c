"""Sources of chunks: text and NumPy files, read piece by piece."""

from __future__ import annotations

import gzip
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from dehyst.errors import LogError
from dehyst.io.collect import Collector
from dehyst.io.delimited import _body, _fast, read_delimited
from dehyst.io.layout import find_layout
from dehyst.io.table import Array, Rows, Table
from dehyst.io.text import decode, lines_of

HEAD = 1 << 20
BLOCK = 1 << 22


@dataclass(frozen=True)
class Piece:
    """Some rows of the columns asked for, their numbers in the file, and the bytes consumed so far."""

    columns: list[Array]
    rows: Rows
    consumed: int


class Source(Protocol):
    """A log that gives its first rows as a table, and then all rows of some columns in pieces."""

    path: Path
    size: int

    def head(self) -> Table:
        """First rows."""
        ...

    def pieces(self, names: Sequence[str]) -> Iterator[Piece]:
        """All rows."""
        ...


class TextSource:
    """CSV and its kin."""

    def __init__(self, path: Path) -> None:
        self.path, self.size = path, path.stat().st_size

    def _open(self) -> tuple[Any, Any]:
        raw = self.path.open("rb")
        packed = raw.read(2) == b"\x1f\x8b"
        raw.seek(0)
        return raw, (gzip.GzipFile(fileobj=raw) if packed else raw)

    def head(self) -> Table:
        """First rows, as the reader of whole files gives them."""
        raw, stream = self._open()
        with raw:
            data = stream.read(HEAD)
        cut = data.rfind(b"\n") + 1 if len(data) == HEAD else len(data)
        self._lines = lines_of(decode(data[:cut], self.path.name))
        self._layout = find_layout(self._lines, self.path.name)
        return read_delimited(data[:cut], self.path.name)

    def pieces(self, names: Sequence[str]) -> Iterator[Piece]:
        """All rows in pieces."""
        table = self.head()
        index = [table.order.index(name) for name in names]
        first, line = self._layout.first, 0
        raw, stream = self._open()
        rest = b""
        with raw:
            while True:
                block = stream.read(BLOCK)
                data = rest + block
                cut = data.rfind(b"\n") + 1 if block else len(data)
                data, rest = data[:cut], data[cut:]
                if data:
                    lines = lines_of(decode(data, self.path.name))
                    body, rows = _body(lines, first)
                    content = _fast(body, self._layout, [])
                    if content is None:
                        raise LogError(f"{self.path.name} is not simple enough to be read in chunks.")
                    yield Piece([content.numbers[j] for j in index], rows + line, raw.tell())
                    line += data.count(b"\n")
                    first = 0
                if not block:
                    return


class ArraySource:
    """NPZ archives and NPY arrays."""

    def __init__(self, path: Path) -> None:
        self.path, self.size = path, path.stat().st_size

    def head(self) -> Table:
        """All rows."""
        found = Collector(self.path.name)
        with np.load(self.path) as arrays:
            for key in arrays.files:
                found.add(key, arrays[key])
        return found.table("")

    def pieces(self, names: Sequence[str]) -> Iterator[Piece]:
        """All rows in pieces."""
        table = self.head()
        columns = [table.columns[name] for name in names]
        for k in range(0, columns[0].size, 1 << 17):
            part = slice(k, k + (1 << 17))
            yield Piece(
                [c[part] for c in columns], np.arange(k + 1, min(columns[0].size, k + (1 << 17)) + 1), self.size
            )
