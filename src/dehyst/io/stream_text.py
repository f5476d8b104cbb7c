"""Text logs in chunks: blocks of whole lines, read by the engine; a line that is not plain is read by itself."""

from __future__ import annotations

import zlib
from collections.abc import Iterator, Mapping, Sequence
from itertools import islice
from pathlib import Path
from typing import BinaryIO

import numpy as np

import dehyst._native as _native
from dehyst.arrays import Rows
from dehyst.errors import LogError
from dehyst.findings import Finding
from dehyst.io.cells import date_order, number, parse_date_times
from dehyst.io.delimited import layout_of, read_delimited
from dehyst.io.layout import Layout, is_comment, split_line
from dehyst.io.plain import PROBE, Part, find_plain, keeps_whole, read_part
from dehyst.io.streams import Column, Piece, Source
from dehyst.io.table import list_rows
from dehyst.io.text import open_text

BLOCK = 1 << 20  # bytes read at a time
LONGEST_LINE = 1 << 24
HEAD = 1 << 20  # bytes by which columns, clock and units are found
ODD_MOST = 0.1  # of the lines of a chunk may be read one by one
SHOWN = 4


class TextSource(Source):
    """A .csv .txt .tsv .dat file, also packed with gzip."""

    costly = True

    def __init__(self, path: Path) -> None:
        self.path, self.size = path, path.stat().st_size
        self.lengths: Mapping[str, int] = {}
        data = next(_joined(self._blocks(), HEAD), (b"", 0))[0]
        text = open_text(data, path.name)
        self._table = read_delimited(data, path.name)
        layout = layout_of(text, path.name)
        lines = _lines_of_width(text.lines, layout) if layout else iter(())
        plain = find_plain(list(islice(lines, PROBE)), layout) if layout else None
        if layout is None or plain is None or b"\0" in data[:4096]:
            raise LogError(
                f"log '{path.name}' cannot be read in chunks: its cells are not plain numbers set off by one delimiter "
                f"(quotes, units in cells, separators of thousands, UTF-16 or the like). Read it at once, with "
                f"dehyst.read_log, or save it as CSV with plain numbers in UTF-8.",
                file=path.name,
            )
        self._layout, self._plain = layout, plain
        self._ragged = 0
        self._shown: list[int] = []

    def _blocks(self) -> Iterator[tuple[bytes, int]]:
        """Unpacked bytes, a block at a time, and how much of the file has been read."""
        with self.path.open("rb") as stream:
            packed = stream.read(2) == b"\x1f\x8b"
            stream.seek(0)
            if packed:
                yield from _unpacked(stream, self.path.name)
            else:
                while block := stream.read(BLOCK):
                    yield block, stream.tell()

    def findings(self) -> list[Finding]:
        """Lines of another width, left out in the last pass."""
        if not self._ragged:
            return []
        return [
            Finding(
                "ragged-lines",
                f"{self._ragged} lines of {self.path.name}, among them {list_rows(self._shown)}, do not have the "
                f"{self._layout.width} cells of the others and were left out: the logger was interrupted or lines were "
                f"damaged. Look at them, and mend or delete them.",
            )
        ]

    def pieces(self, names: Sequence[str], rows: int) -> Iterator[Piece]:
        """All rows of some columns, at most `rows` at a time.

        Raises
        ------
        LogError
            If lines are not plain, and they are many.
        """
        index = [self._table.order.index(name) for name in names]
        orders = {name: self._order(name) for name in names if name in self._table.stamps}
        skip, line = self._layout.first, 1 + self._layout.first
        self._ragged, self._shown = 0, []
        for text, consumed in _joined(self._blocks(), BLOCK):
            offset = _native.text_offset(text, skip) if skip else _mark(text, line)
            skip = odd = 0
            begin = line
            while offset < len(text):
                part = read_part(text, offset, line, self._plain, rows)
                offset, line = offset + part.bytes, line + part.lines
                if not keeps_whole(part.columns, self._plain):
                    raise self._refusal(line, "commas appear in a column that had none before")
                columns, numbers = [part.columns[j] for j in index], part.rows
                if part.column >= 0:
                    end = _native.text_offset(text, 1, offset)
                    columns, numbers = self._with_odd_line(text[offset:end], line, index, part)
                    offset, line, odd = end, line + 1, odd + 1
                    if odd > 100 and odd > ODD_MOST * (line - begin):
                        raise self._refusal(line, "many of its lines are not plain numbers")
                for k, name in enumerate(names):
                    if name in orders:
                        columns[k] = parse_date_times(columns[k].tolist(), orders[name])
                if numbers.size:
                    yield Piece(columns, numbers, consumed)

    def _order(self, name: str) -> str:
        """Whether day or month comes first in a column of dates, by the first rows."""
        j = self._table.order.index(name)
        lines = open_text(next(_joined(self._blocks(), HEAD))[0], self.path.name).lines
        cells = (split_line(line, self._layout.delimiter)[j] for line in _lines_of_width(lines, self._layout))
        return date_order(list(cells))[0]

    def _with_odd_line(self, raw: bytes, line: int, index: Sequence[int], part: Part) -> tuple[list[Column], Rows]:
        """Columns with the cells of one more line, NaN where they hold no number; without it if its width is wrong."""
        cells = split_line(raw.decode(errors="replace").strip("\r\n"), self._layout.delimiter)
        columns = [part.columns[j] for j in index]
        if len(cells) != self._layout.width:
            self._ragged += 1
            self._shown += [line] if len(self._shown) < SHOWN else []
            return columns, part.rows
        longer: list[Column] = []
        for column, j in zip(columns, index, strict=True):
            text = cells[j].strip()
            if self._plain.letters[j]:
                longer.append(np.append(column, text))
            else:
                value = number(text.replace(",", ".") if self._plain.decimal == "," else text)
                longer.append(np.append(column, np.nan if value is None else value))
        return longer, np.append(part.rows, line)

    def _refusal(self, line: int, why: str) -> LogError:
        return LogError(
            f"log '{self.path.name}' cannot be read in chunks: near line {line}, {why}. Read it at once, with "
            f"dehyst.read_log, or save it as CSV with plain numbers.",
            file=self.path.name,
            line=line,
        )


def _lines_of_width(lines: Sequence[str], layout: Layout) -> Iterator[str]:
    """Lines of data with as many cells as most: the others are passed over one by one."""
    data = (line for line in lines[layout.first :] if not is_comment(line))
    return (line for line in data if len(split_line(line, layout.delimiter)) == layout.width)


def _mark(text: bytes, line: int) -> int:
    """Bytes of the byte-order mark that a file without a header begins with."""
    return 3 if line == 1 and text.startswith(b"\xef\xbb\xbf") else 0


def _joined(blocks: Iterator[tuple[bytes, int]], least: int) -> Iterator[tuple[bytes, int]]:
    """Blocks of whole lines of at least so many bytes each; the last one may be shorter and end without a line end."""
    parts: list[bytes] = []
    size = consumed = 0
    for block, consumed in blocks:
        parts.append(block)
        size += len(block)
        if size < least:
            continue
        text = b"".join(parts)
        cut = _native.text_whole_lines(text)
        if cut:
            yield text[:cut], consumed
        elif size > LONGEST_LINE:
            raise LogError(
                f"a line of the log is longer than {LONGEST_LINE >> 20} MB: it is no table. Check that it is the right "
                f"file.",
                bytes=size,
            )
        parts, size = [text[cut:]], len(text) - cut
    if size:
        yield b"".join(parts), consumed


def _unpacked(stream: BinaryIO, name: str) -> Iterator[tuple[bytes, int]]:
    """Blocks of a gzip file, member by member."""
    data = stream.read(BLOCK // 4)
    try:
        while data:
            unpack = zlib.decompressobj(wbits=31)
            while not unpack.eof:
                block = unpack.decompress(data, BLOCK)
                data = unpack.unconsumed_tail or stream.read(BLOCK // 4)
                if block:
                    yield block, stream.tell()
                elif not data and not unpack.eof:
                    raise zlib.error("it ends early")
            data = (unpack.unused_data + data).lstrip(b"\0") or stream.read(BLOCK // 4).lstrip(b"\0")
    except zlib.error as fault:
        raise LogError(
            f"log '{name}' is damaged: its gzip data cannot be expanded ({fault}). Copy the file again, or save what "
            f"can be saved with: gzip -dc {name} > log.csv",
            file=name,
        ) from None
