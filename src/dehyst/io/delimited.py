"""Text logs, whole or in chunks: .csv .txt .tsv .dat, also packed with gzip.

Two ways lead through a whole log: the engine's parser for logs without a blemish, and a careful one, line by line, as
soon as it refuses. In chunks there is the engine alone; a line that is not plain is read by itself.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from itertools import compress, islice

import numpy as np
import numpy.typing as npt

import dehyst._native as _native
from dehyst.arrays import Array, Rows
from dehyst.errors import LogError
from dehyst.findings import Finding
from dehyst.io.cells import (
    date_order,
    is_data,
    is_date_time,
    is_dressed,
    marks_of,
    number,
    parse_date_times,
    parse_numbers,
    separator_of,
    text_refusal,
    thousands_finding,
    thousands_refusal,
    undress_negatives,
    undress_units,
)
from dehyst.io.collect import Column, Piece, Source
from dehyst.io.layout import Layout, find_layout
from dehyst.io.lines import is_comment, split_line
from dehyst.io.plain import PROBE, Part, find_plain, keeps_whole, read_part, read_plain
from dehyst.io.rewrite import Rewriting, rewriting, rewritten
from dehyst.io.table import SHOWN, Table, finite, list_names, list_rows, require_columns, shown_names, unique_names
from dehyst.io.text import BLOCK, GZIP, Text, expand, open_text, unpacked
from dehyst.shell import visible
from dehyst.units import parse_unit

SUSPECT = " \t#%/"  # first characters of lines that may be comments or blank
TEXT_MOST = 0.1  # of the filled cells of a column may be text, and their rows left out
ODD_MOST = 0.1  # of the lines of a chunk may be read one by one
LOOKED_AT = 2000  # rows that tell whether a column names signals
MOST_SIGNALS = 50
OFTEN = 0.9  # of the rows: a state stays for some, and signals that were stored at once follow each other
LONGEST_LINE = 1 << 24  # bytes


def read_delimited(data: bytes, name: str) -> Table:
    """Read a text log."""
    text, layout, change = _opened(expand(data, name), name)
    findings: list[Finding] = []
    if change:
        text = rewritten(text, change)
        layout = find_layout(text.lines, name)
        findings.extend(change.findings)
    quick = _quick(text, layout, findings)
    if quick:
        return _assemble(name, layout, quick[1], quick[0], findings)
    lines = text.all_lines()
    layout = layout if text.complete else find_layout(lines, name)
    body, rows = _body(lines, layout.first)
    cells, rows = _split(body, rows, layout, name, findings)
    cells, rows = _without_headers(cells, rows, layout, name, findings)
    content = _careful(cells, rows, layout, name, findings)
    return _assemble(name, layout, rows, content, findings)


def _opened(data: bytes, name: str) -> tuple[Text, Layout, Rewriting | None]:
    """A text log, how its lines are to be read, and whether they must be written anew before."""
    text = open_text(data, name)
    layout = layout_of(text, name)
    if layout is None:
        text = Text(text.data, text.all_lines(), True)
        layout = find_layout(text.lines, name)
    return text, layout, rewriting(text.lines, layout, name)


def layout_of(text: Text, name: str) -> Layout | None:
    """Layout by the first lines of a log; None if only all of it can tell, or what is wrong with it."""
    if text.complete:
        return find_layout(text.lines, name)
    with suppress(LogError):
        layout = find_layout(text.lines, name)
        if layout.first + 2 * PROBE <= len(text.lines):
            return layout
    return None


def _body(lines: Sequence[str], first: int) -> tuple[list[str], Rows]:
    """Lines of data without comments and empty lines, and their numbers from 1."""
    body = list(lines[first:])
    while body and not body[-1].strip():
        body.pop()
    if all(body) and not any(line[0] in SUSPECT for line in body):
        return body, np.arange(first + 1, first + 1 + len(body), dtype=np.int64)
    keep = [not is_comment(line) for line in body]
    rows = np.flatnonzero(np.array(keep, dtype=bool)) + first + 1
    return list(compress(body, keep)), rows.astype(np.int64)


@dataclass(frozen=True)
class Content:
    """Columns by position: numbers, text, which numbers are date-times, why some cannot be trusted, units in cells."""

    numbers: dict[int, Array] = field(default_factory=dict)
    labels: dict[int, npt.NDArray[np.str_]] = field(default_factory=dict)
    stamps: set[int] = field(default_factory=set)
    refused: dict[int, str] = field(default_factory=dict)
    units: dict[int, str] = field(default_factory=dict)


def _quick(text: Text, layout: Layout, findings: list[Finding]) -> tuple[Content, Rows] | None:
    """Read with the engine; None if any line or cell is not as the first lines promise."""
    body = list(islice((line for line in text.lines[layout.first :] if not is_comment(line)), PROBE))
    if len(body) < PROBE and not text.complete:
        return None
    plain = find_plain(body, layout)
    read = read_plain(text.data, text.offset(layout.first), layout.first + 1, plain) if plain else None
    if plain is None or read is None:
        return None
    columns, rows = read
    content = Content()
    for j, column in enumerate(columns):
        if not plain.letters[j]:
            content.numbers[j] = column  # type: ignore[assignment]
        elif is_date_time(str(column[0])):
            content.numbers[j] = _dates(column.tolist(), layout, j, findings)
            content.stamps.add(j)
        else:
            content.labels[j] = column  # type: ignore[assignment]
    return content, rows


def _split(
    body: Sequence[str], rows: Rows, layout: Layout, name: str, findings: list[Finding]
) -> tuple[list[list[str]], Rows]:
    """Cells of every line of the right width; the others are reported."""
    cells = [split_line(line, layout.delimiter) for line in body]
    keep = np.array([len(row) == layout.width for row in cells], dtype=bool)
    ragged = rows[~keep]
    if ragged.size:
        findings.append(_ragged(layout, f"{list_rows(ragged)} of {name}", ragged.size))
    if ragged.size > 0.5 * keep.size:
        raise LogError(
            f"log '{name}' is not a table: {ragged.size} of its {keep.size} lines do not have the {layout.width} cells "
            f"of the others ({list_rows(ragged)}). Check the delimiter and the decimal sign, or cut the file.",
            file=name,
            rows=ragged,
        )
    return list(compress(cells, keep)), rows[keep]


def _without_headers(
    cells: list[list[str]], rows: Rows, layout: Layout, log: str, findings: list[Finding]
) -> tuple[list[list[str]], Rows]:
    """Cells without the header where it comes again; up to where one with other names begins another table."""
    names = frozenset(filter(None, layout.names or ()))
    keep = np.ones(len(cells), dtype=bool)
    for k, row in enumerate(cells):
        if not _names_again(row, names):
            continue
        again = {cell.strip() for cell in row if cell.strip()}
        keep[k] = False
        if again != names or [cell.strip() for cell in row] != list(layout.names or ()):
            keep[k:] = False
            findings.append(
                Finding(
                    "second-table",
                    f"another table begins in {list_rows(rows[[k]])} of {log}, with the names "
                    f"{list_names([cell.strip() for cell in row], 6)}: it and the {len(cells) - k - 1} rows from "
                    f"there on were left out. To read them, save them as a file of their own.",
                )
            )
            break
    return list(compress(cells, keep)), rows[keep]


def _names_again(row: Sequence[str], names: frozenset[str]) -> bool:
    """Whether a row of a table holds names, one of its header among them, and no number."""
    return not names.isdisjoint(map(str.strip, row)) and not any(map(is_data, row))


def _ragged(layout: Layout, lines: str, count: int) -> Finding:
    have, were, them = ("does not have", "was", "it") if count == 1 else ("do not have", "were", "them")
    return Finding(
        "ragged-lines",
        f"{lines} {have} the {layout.width} cells of the others and {were} left out: the logger was interrupted, a "
        f"line was damaged, or it is no line of the table. Look at {them}, and mend or delete {them}.",
    )


def _careful(cells: Sequence[Sequence[str]], rows: Rows, layout: Layout, log: str, findings: list[Finding]) -> Content:
    content = Content()
    columns = [[cell.strip() for cell in raw] for raw in zip(*cells, strict=True)]
    columns = [_undress(column, j, rows, layout, content, log, findings) for j, column in enumerate(columns)]
    commas = layout.decimal_comma or any("," in cell for column in columns for cell in column)
    marks = [marks_of(column) for column in columns] if commas else []
    decimals = frozenset[str]().union(*(found.decimals for found in marks))
    for j, column in enumerate(columns):
        name = _name(layout, j)
        filled = [cell for cell in column if cell]
        values, bad = parse_numbers(column, commas)
        separator, certain = separator_of(column, marks[j], decimals) if marks else ("", False)
        if separator:
            whole, text = parse_numbers(marks[j].without(column, separator), commas)
            if text > 0.5 * len(filled):
                separator = ""  # a column of text that holds a number or two
            elif certain:
                findings.append(thousands_finding(name, column, marks[j], separator, rows))
                values, bad = whole, text
            else:
                content.refused[j] = thousands_refusal(name, log, column, marks[j], separator, rows)
        if separator or bad <= 0.5 * len(filled):
            content.numbers[j] = values
            if not separator:
                _warn_decimal_comma(column, name, findings)
            if bad > TEXT_MOST * len(filled):
                content.refused.setdefault(j, text_refusal(name, log, column, rows))
        elif sum(is_date_time(cell) for cell in filled[:PROBE]) > 0.5 * len(filled[:PROBE]):
            content.numbers[j] = _dates(column, layout, j, findings)
            content.stamps.add(j)
        else:
            content.labels[j] = np.array([cell[:200] for cell in column], dtype=np.str_)
    return content


def _undress(
    column: list[str], j: int, rows: Rows, layout: Layout, content: Content, log: str, findings: list[Finding]
) -> list[str]:
    """Take away what stands around the numbers of a column, and keep the unit if it was one."""
    if not any(is_dressed(cell) for cell in column[:PROBE]) and not any(cell[:1] == "(" for cell in column):
        return column
    name = _name(layout, j)
    bare = undress_units(name, column, findings)
    if bare is None:
        return undress_negatives(name, column, rows, findings)
    content.units[j] = bare[1]
    header = _header_unit(layout, j)
    if header and header != bare[1]:
        content.refused[j] = (
            f"column '{name}' of {log} is in {header} by its header and in {bare[1]} by its cells ({column[0]!r}); one "
            f"of them is wrong. Correct the header, or take the unit out of the cells."
        )
    return bare[0]


def _header_unit(layout: Layout, j: int) -> str:
    """Unit of a column by the units row or else by its name, "" if neither tells."""
    name = _name(layout, j)
    below = visible(layout.units[j]) if layout.units else ""
    by_row = parse_unit(f"{name or 'x'} [{below}]")[1] if below else ""
    return by_row or parse_unit(name)[1]


def _name(layout: Layout, j: int) -> str:
    return visible(layout.names[j]) if layout.names else f"column_{j + 1}"


def _dates(column: Sequence[str], layout: Layout, j: int, findings: list[Finding]) -> Array:
    """Seconds of a column of dates, and what had to be assumed."""
    order, assumed = date_order(column)
    if assumed:
        findings.append(
            Finding(
                "date-order",
                f"dates in column '{_name(layout, j)}', such as {column[0].strip()}, were read with the {order} first; "
                f"nothing in the log tells. If that is wrong, log dates as 2024-05-01 12:00:00.",
            )
        )
    return parse_date_times(column)


def _warn_decimal_comma(column: Sequence[str], name: str, findings: list[Finding]) -> None:
    """1,234 is 1.234 or 1234: say so where all commas are followed by three digits and some cells have none."""
    tails = [len(cell.partition(",")[2]) for cell in column if "," in cell]
    if tails and set(tails) == {3} and len(tails) < sum(is_data(cell) for cell in column):
        findings.append(
            Finding(
                "decimal-comma",
                f"commas in column '{name}' were read as decimal signs (1,234 is 1.234), but three digits follow "
                f"each and other cells have none. If they separate thousands, save the log without them.",
            )
        )


def _assemble(name: str, layout: Layout, rows: Rows, content: Content, findings: list[Finding]) -> Table:
    findings.extend(layout.findings)
    numbers = content.numbers
    raw = shown_names(layout.names or [_name(layout, j) for j in range(layout.width)], name, findings)
    names = unique_names(raw)
    renamed = [(given, unique) for given, unique in zip(raw, names, strict=True) if given and given != unique]
    if renamed:
        findings.append(
            Finding(
                "duplicate-columns",
                f"{name} names several columns {list_names(sorted({given for given, _ in renamed}), 8)}; the later "
                f"ones were renamed ({list_names([unique for _, unique in renamed], 8)}). Name the one you mean, or "
                f"use #3 for the third column.",
            )
        )
    findings.extend(_long(names[j], labels, name) for j, labels in content.labels.items() if _is_long(labels))
    # A delimiter at the end of every line makes a column: last, nameless, empty.
    trailing = f"column_{layout.width}" if layout.width > 1 else ""
    kept = [j for j in sorted(numbers) if names[j] != trailing or finite(numbers[j]).any()]
    return require_columns(
        Table(
            name=name,
            columns={names[j]: numbers[j] for j in kept},
            units={
                names[j]: "s" if j in content.stamps else content.units.get(j) or _header_unit(layout, j) for j in kept
            },
            rows=rows,
            labels={names[j]: content.labels[j] for j in sorted(content.labels)},
            row_word="line",
            stamps=frozenset(names[j] for j in content.stamps),
            order=tuple(names),
            findings=tuple(findings),
            refused={names[j]: reason for j, reason in content.refused.items() if j in kept},
        )
    )


def _is_long(labels: npt.NDArray[np.str_]) -> bool:
    """Whether texts change from row to row among a few, as the names of signals that share one column."""
    part = labels[:LOOKED_AT]
    changes = np.count_nonzero(part[1:] != part[:-1])
    often = part.size > PROBE // 2 and changes >= OFTEN * (part.size - 1)
    return bool(often and np.unique(part).size <= MOST_SIGNALS)


def _long(column: str, labels: npt.NDArray[np.str_], log: str) -> Finding:
    names = list(dict.fromkeys(labels[:LOOKED_AT].tolist()))
    return Finding(
        "long-table",
        f"column '{column}' of {log} has another text in almost every row ({list_names(names, 4)}). If these are names "
        f"of signals, their values stand below one another, and the column of values is no signal. Then write a column "
        f"for each: in pandas, df.pivot_table(index=TIME, columns='{column}', values=VALUE).to_csv('wide.csv'), with "
        f"the names of the columns of time and values. If not, there is nothing to do.",
    )


class TextChunks(Source):
    """A text log that is read in blocks of whole lines."""

    def _head(self) -> Table:
        data = next(self._blocks(BLOCK), (b"", 0))[0]
        table = read_delimited(data, self.path.name)
        text, layout, change = _opened(data, self.path.name)
        plain = None if change else find_plain(list(islice(self._whole(text, layout), PROBE)), layout)
        if plain is None or b"\0" in data[:4096]:
            raise LogError(
                f"log '{self.path.name}' cannot be read in chunks: its cells are not plain numbers set off by one "
                f"delimiter (quotes, units in cells, separators of thousands, UTF-16 or the like). Read it at once, "
                f"with dehyst.read_log, or save it as CSV with plain numbers in UTF-8.",
                file=self.path.name,
            )
        self._layout, self._plain = layout, plain
        self._orders: dict[str, str] = {}  # of day and month in columns of dates
        for name in table.stamps:
            j = table.order.index(name)
            self._orders[name] = date_order([self._cells(line)[j] for line in self._whole(text, layout)])[0]
        self._ragged, self._shown = 0, list[int]()
        return table

    @staticmethod
    def _whole(text: Text, layout: Layout) -> Iterator[str]:
        """Lines of data with as many cells as most: the others are passed over one by one."""
        lines = (line for line in text.lines[layout.first :] if not is_comment(line))
        return (line for line in lines if len(split_line(line, layout.delimiter)) == layout.width)

    def _cells(self, line: str) -> list[str]:
        return split_line(line, self._layout.delimiter)

    def _blocks(self, least: int) -> Iterator[tuple[bytes, int]]:
        """Blocks of whole lines of at least so many bytes each, and how much of the file has been read.

        The last one may be shorter and end without a line end.
        """
        parts: list[bytes] = []
        size = 0
        with self.path.open("rb") as stream:
            packed = stream.read(len(GZIP)) == GZIP
            stream.seek(0)
            for block in unpacked(stream, self.path.name) if packed else iter(lambda: stream.read(BLOCK), b""):
                parts.append(block)
                size += len(block)
                if size < least:
                    continue
                text = b"".join(parts)
                cut = _native.text_whole_lines(text)
                if cut:
                    yield text[:cut], stream.tell()
                elif size > LONGEST_LINE:
                    raise LogError(
                        f"a line of the log is longer than {LONGEST_LINE >> 20} MB: it is no table. Check that it is "
                        f"the right file.",
                        bytes=size,
                    )
                parts, size = [text[cut:]], len(text) - cut
            if size:
                yield b"".join(parts), stream.tell()

    def findings(self) -> list[Finding]:
        """Lines of another width, left out in the last pass."""
        if not self._ragged:
            return []
        lines = f"{self._ragged} lines of {self.path.name}, among them {list_rows(self._shown)},"
        return [_ragged(self._layout, lines, 2)]

    def pieces(self, names: Sequence[str], rows: int) -> Iterator[Piece]:
        """All rows of some columns, at most `rows` at a time."""
        index = [self.table.order.index(name) for name in names]
        skip, line = self._layout.first, 1 + self._layout.first
        self._ragged, self._shown = 0, []
        for text, consumed in self._blocks(BLOCK):
            # A file without a header may begin with a byte-order mark.
            mark = 3 if line == 1 and text.startswith(b"\xef\xbb\xbf") else 0
            offset = _native.text_offset(text, skip) if skip else mark
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
                    if name in self._orders:
                        columns[k] = parse_date_times(columns[k].tolist(), self._orders[name])
                if numbers.size:
                    yield Piece(columns, numbers, consumed)

    def _with_odd_line(self, raw: bytes, line: int, index: Sequence[int], part: Part) -> tuple[list[Column], Rows]:
        """Columns with the cells of one more line, NaN where they hold no number; without it if its width is wrong."""
        cells = self._cells(raw.decode(errors="replace").strip("\r\n"))
        if _names_again(cells, frozenset(filter(None, self._layout.names or ()))):
            raise self._refusal(line, "a header comes again")
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
