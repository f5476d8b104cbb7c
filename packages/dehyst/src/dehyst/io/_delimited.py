"""Text logs, whole or in parts: .csv .txt .tsv .dat, also packed with gzip.

Two ways lead through a whole log: the engine's parser for logs without a blemish, and a careful one, line by line, as
soon as it refuses. In parts there is the engine alone; a line that is not plain is read by itself.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from itertools import compress, filterfalse, islice

import numpy as np
import numpy.typing as npt

import dehyst._native as _native
from dehyst.arrays import Array, Rows
from dehyst.errors import LogError
from dehyst.findings import Finding
from dehyst.io._cells import (
    Marks,
    are_dates,
    cell_number,
    date_order,
    is_data,
    is_date_time,
    is_dressed,
    marks_of,
    parse_date_times,
    parse_numbers,
    seconds_of_dates,
    separator_of,
    text_refusal,
    thousands_finding,
    thousands_refusal,
    undress_negatives,
    undress_units,
)
from dehyst.io._collect import Column, FilePiece, NotInPartsError, Source
from dehyst.io._layout import TableLayout, find_layout
from dehyst.io._lines import is_comment, split_line
from dehyst.io._plain import PROBE, PlainPart, find_plain, keeps_whole, read_part, read_plain
from dehyst.io._policy import POLICY
from dehyst.io._rewrite import Rewriting, rewriting, rewritten
from dehyst.io._table import (
    SHOWN,
    LogTable,
    finite,
    list_names,
    list_rows,
    require_columns,
    shown_names,
    unique_names,
)
from dehyst.io._text import BLOCK, GZIP, Text, expand, open_text, unpacked
from dehyst.shell import visible
from dehyst.units import parse_unit

SUSPECT = " \t#%/"  # first characters of lines that may be comments or blank
ODD_MOST = 0.1  # of the lines of a block may be read one by one
LOOKED_AT = 2000  # rows that tell whether a column names signals
LONGEST_LINE = 1 << 24  # bytes


def read_delimited(data: bytes, name: str) -> LogTable:
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


def _opened(data: bytes, name: str) -> tuple[Text, TableLayout, Rewriting | None]:
    """A text log, how its lines are to be read, and whether they must be written anew before."""
    text = open_text(data, name)
    layout = layout_of(text, name)
    if layout is None:
        text = Text(text.data, text.all_lines(), True)
        layout = find_layout(text.lines, name)
    return text, layout, rewriting(text.lines, layout, name)


def layout_of(text: Text, name: str) -> TableLayout | None:
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


def _quick(text: Text, layout: TableLayout, findings: list[Finding]) -> tuple[Content, Rows] | None:
    """Read with the engine; None if any line or cell is not as the first lines promise."""
    body = list(islice(filterfalse(is_comment, islice(text.lines, layout.first, None)), PROBE))
    if len(body) < PROBE and not text.complete:
        return None
    plain = find_plain(body, layout)
    if plain is None:
        return None
    read = read_plain(text.data, text.offset(layout.first), layout.first + 1, plain)
    if read is None:
        return None
    columns, rows = read
    content = Content()
    for j, column in enumerate(columns):
        if not plain.letters[j]:
            content.numbers[j] = column  # type: ignore[assignment]
        elif is_date_time(str(column[0])):
            content.numbers[j] = seconds_of_dates(column.tolist(), _name(layout, j), findings)[0]
            content.stamps.add(j)
        else:
            content.labels[j] = column  # type: ignore[assignment]
    return content, rows


def _split(
    body: Sequence[str], rows: Rows, layout: TableLayout, name: str, findings: list[Finding]
) -> tuple[list[list[str]], Rows]:
    """Cells of every line of the right width; the others are reported."""
    cells = [split_line(line, layout.delimiter) for line in body]
    keep = np.array(list(map(len, cells))) == layout.width
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
    cells: list[list[str]], rows: Rows, layout: TableLayout, log: str, findings: list[Finding]
) -> tuple[list[list[str]], Rows]:
    """Return the cells without repeated headers; a header with other names begins another table, which is left out."""
    names = frozenset(filter(None, layout.names or ()))
    keep = np.ones(len(cells), dtype=bool)
    for k, row in enumerate(cells):
        if not _names_again(row, names):
            continue
        keep[k] = False
        header = list(map(str.strip, row))
        if header != list(layout.names or ()):
            keep[k:] = False
            message = (
                f"another table begins in {list_rows(rows[[k]])} of {log}, with the names {list_names(header, 6)}: it "
                f"and the {len(cells) - k - 1} rows from there on were left out. To read them, save them as a file of "
                f"their own."
            )
            findings.append(Finding("second-table", message))
            break
    return list(compress(cells, keep)), rows[keep]


def _names_again(row: Sequence[str], names: frozenset[str]) -> bool:
    """Whether a row of a table holds names, one of its header among them, and no number."""
    return not names.isdisjoint(map(str.strip, row)) and not any(map(is_data, row))


def _ragged(layout: TableLayout, lines: str, count: int) -> Finding:
    have, were, them = "do not have", "were", "them"
    if count == 1:
        have, were, them = "does not have", "was", "it"
    return Finding(
        "ragged-lines",
        f"{lines} {have} the {layout.width} cells of the others and {were} left out: the logger was interrupted, a "
        f"line was damaged, or it is no line of the table. Look at {them}, and mend or delete {them}.",
    )


def _careful(
    cells: Sequence[Sequence[str]],
    rows: Rows,
    layout: TableLayout,
    log: str,
    findings: list[Finding],
) -> Content:
    content = Content()
    columns: list[list[str]] = []
    commas = layout.decimal_comma
    for j, raw in enumerate(zip(*cells, strict=True)):
        column = list(map(str.strip, raw))
        columns.append(_undress(column, j, rows, layout, content, log, findings))
        commas = commas or any(map(_has_comma, columns[-1]))
    # Decimal signs that one column shows tell what the marks of another may be.
    marks: list[Marks] = []
    decimals: set[str] = set()
    if commas:
        marks = list(map(marks_of, columns))
        for column_marks in marks:
            decimals |= column_marks.decimals
    for j, column in enumerate(columns):
        name = _name(layout, j)
        filled = list(filter(None, column))
        values, bad = parse_numbers(column, commas)
        separator = ""
        if marks:
            separator, certain = separator_of(column, marks[j], frozenset(decimals))
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
            if bad > POLICY.text_most * len(filled):
                content.refused.setdefault(j, text_refusal(name, log, column, rows))
        elif are_dates(filled[:PROBE]):
            content.numbers[j] = seconds_of_dates(column, _name(layout, j), findings)[0]
            content.stamps.add(j)
        else:
            content.labels[j] = np.array([cell[:200] for cell in column], dtype=np.str_)
    return content


def _has_comma(cell: str) -> bool:
    return "," in cell


def _is_bracketed(cell: str) -> bool:
    return cell.startswith("(")


def _undress(
    column: list[str],
    j: int,
    rows: Rows,
    layout: TableLayout,
    content: Content,
    log: str,
    findings: list[Finding],
) -> list[str]:
    """Take away what stands around the numbers of a column, and keep the unit if it was one."""
    if not any(map(is_dressed, column[:PROBE])) and not any(map(_is_bracketed, column)):
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


def _header_unit(layout: TableLayout, j: int) -> str:
    """Unit of a column by the units row or else by its name, "" if neither tells."""
    name = _name(layout, j)
    unit = ""
    if layout.units:
        below = visible(layout.units[j])
        if below:
            unit = parse_unit(f"{name or 'x'} [{below}]")[1]
    return unit or parse_unit(name)[1]


def _name(layout: TableLayout, j: int) -> str:
    if layout.names:
        return visible(layout.names[j])
    return f"column_{j + 1}"


def _warn_decimal_comma(column: Sequence[str], name: str, findings: list[Finding]) -> None:
    """1,234 is 1.234 or 1234: say so where all commas are followed by three digits and some cells have none."""
    tails = [len(cell.partition(",")[2]) for cell in column if "," in cell]
    if set(tails) == {3} and len(tails) < sum(map(is_data, column)):
        findings.append(
            Finding(
                "decimal-comma",
                f"commas in column '{name}' were read as decimal signs (1,234 is 1.234), but three digits follow "
                f"each and other cells have none. If they separate thousands, save the log without them.",
            )
        )


def _assemble(
    name: str, layout: TableLayout, rows: Rows, content: Content, findings: list[Finding]
) -> LogTable:
    findings.extend(layout.findings)
    numbers = content.numbers
    # Columns without a name are numbered by `unique_names`.
    header = shown_names(layout.names or [""] * layout.width, name, findings)
    names = unique_names(header)
    repeated: set[str] = set()
    renamed: list[str] = []
    for header_name, unique in zip(header, names, strict=True):
        if header_name and header_name != unique:
            repeated.add(header_name)
            renamed.append(unique)
    if renamed:
        message = (
            f"{name} names several columns {list_names(sorted(repeated), 8)}; the later ones were renamed "
            f"({list_names(renamed, 8)}). Name the one you mean, or use #3 for the third column."
        )
        findings.append(Finding("duplicate-columns", message))
    for j, labels in content.labels.items():
        if _is_long(labels):
            findings.append(_long(names[j], labels, name))

    columns: dict[str, Array] = {}
    units: dict[str, str] = {}
    refused: dict[str, str] = {}
    for j in sorted(numbers):
        # A delimiter at the end of every line makes a column: last, nameless, empty.
        is_last = names[j] == f"column_{layout.width}" and layout.width > 1
        if is_last and not finite(numbers[j]).any():
            continue
        columns[names[j]] = numbers[j]
        units[names[j]] = content.units.get(j) or _header_unit(layout, j)
        if j in content.stamps:
            units[names[j]] = "s"
    for j, reason in content.refused.items():
        if names[j] in columns:
            refused[names[j]] = reason
    return require_columns(
        LogTable(
            name=name,
            columns=columns,
            units=units,
            rows=rows,
            labels={names[j]: content.labels[j] for j in sorted(content.labels)},
            row_word="line",
            stamps=frozenset(names[j] for j in content.stamps),
            order=tuple(names),
            findings=tuple(findings),
            refused=refused,
        )
    )


def _is_long(labels: npt.NDArray[np.str_]) -> bool:
    """Whether texts change from row to row among a few, as the names of signals that share one column."""
    part = labels[:LOOKED_AT]
    changes = np.count_nonzero(part[1:] != part[:-1])
    often = part.size > PROBE // 2 and changes >= POLICY.changes_often * (part.size - 1)
    return bool(often and np.unique(part).size <= POLICY.most_signals)


def _long(column: str, labels: npt.NDArray[np.str_], log: str) -> Finding:
    names = list(dict.fromkeys(labels[:LOOKED_AT].tolist()))
    return Finding(
        "long-table",
        f"column '{column}' of {log} has another text in almost every row ({list_names(names, 4)}). If these are names "
        f"of signals, their values stand below one another, and the column of values is no signal. Then write a column "
        f"for each: in pandas, df.pivot_table(index=TIME, columns='{column}', values=VALUE).to_csv('wide.csv'), with "
        f"the names of the columns of time and values. If not, there is nothing to do.",
    )


class TextParts(Source):
    """A text log that is read in blocks of whole lines."""

    def _head(self) -> LogTable:
        data = next(self._blocks(BLOCK), (b"", 0))[0]
        table = read_delimited(data, self.path.name)
        text, layout, change = _opened(data, self.path.name)
        plain = None
        if not change:
            plain = find_plain(list(islice(self._whole(text, layout), PROBE)), layout)
        if plain is None or b"\0" in data[:4096]:
            raise NotInPartsError(
                f"log '{self.path.name}' is too long to be read at once, and its cells are not plain numbers set off "
                f"by one delimiter (quotes, units in cells, separators of thousands, UTF-16 or the like), which could "
                f"be read in parts. Split it, or save it as CSV with plain numbers in UTF-8.",
                file=self.path.name,
            )
        self._layout, self._plain = layout, plain
        self._orders: dict[str, str] = {}  # of day and month in columns of dates
        for name in table.stamps:
            j = table.order.index(name)
            cells = [self._cells(line)[j] for line in self._whole(text, layout)]
            self._orders[name] = date_order(cells)[0]
        self._ragged = 0
        self._shown: list[int] = []
        return table

    @staticmethod
    def _whole(text: Text, layout: TableLayout) -> Iterator[str]:
        """Lines of data with as many cells as most: the others are passed over one by one."""
        for line in text.lines[layout.first :]:
            if not is_comment(line) and len(split_line(line, layout.delimiter)) == layout.width:
                yield line

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
            blocks: Iterator[bytes] = iter(lambda: stream.read(BLOCK), b"")
            if packed:
                blocks = unpacked(stream, self.path.name)
            for block in blocks:
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

    def pieces(self, names: Sequence[str], rows: int) -> Iterator[FilePiece]:
        """All rows of some columns, at most `rows` at a time."""
        index = [self.table.order.index(name) for name in names]
        skip, line = self._layout.first, 1 + self._layout.first
        self._ragged, self._shown = 0, []
        for text, consumed in self._blocks(BLOCK):
            offset = 0
            if skip:
                offset = _native.text_offset(text, skip)
            elif line == 1 and text.startswith(b"\xef\xbb\xbf"):
                offset = 3  # a file without a header may begin with a byte-order mark
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
                    yield FilePiece(columns, numbers, consumed)

    def _with_odd_line(
        self, raw: bytes, line: int, index: Sequence[int], part: PlainPart
    ) -> tuple[list[Column], Rows]:
        """Columns with the cells of one more line, NaN where they hold no number; without it if its width is wrong."""
        cells = self._cells(raw.decode(errors="replace").strip("\r\n"))
        if _names_again(cells, frozenset(filter(None, self._layout.names or ()))):
            raise self._refusal(line, "a header comes again")
        columns = [part.columns[j] for j in index]
        if len(cells) != self._layout.width:
            self._ragged += 1
            if len(self._shown) < SHOWN:
                self._shown.append(line)
            return columns, part.rows
        longer: list[Column] = []
        for column, j in zip(columns, index, strict=True):
            text = cells[j].strip()
            if self._plain.letters[j]:
                longer.append(np.append(column, text))
            else:
                if self._plain.decimal == ",":
                    text = text.replace(",", ".")
                value = cell_number(text)
                longer.append(np.append(column, np.nan if value is None else value))
        return longer, np.append(part.rows, line)

    def _refusal(self, line: int, why: str) -> NotInPartsError:
        return NotInPartsError(
            f"log '{self.path.name}' is too long to be read at once, and cannot be read in parts: near line {line}, "
            f"{why}. Split it, or save it as CSV with plain numbers.",
            file=self.path.name,
            line=line,
        )
