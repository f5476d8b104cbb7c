"""Text logs: .csv .txt .tsv .dat, also packed with gzip.

Two ways: the engine's parser for logs without a blemish, and a careful one, line by line, as soon as it refuses.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from itertools import compress, islice

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array, Rows
from dehyst.errors import LogError
from dehyst.findings import Finding
from dehyst.io.cells import date_order, is_data, is_date_time, parse_date_times, parse_numbers
from dehyst.io.dressed import is_dressed, text_refusal, undress_negatives, undress_units
from dehyst.io.layout import Layout, find_layout, is_comment, split_line
from dehyst.io.plain import PROBE, find_plain, read_plain
from dehyst.io.table import (
    Table,
    finite,
    list_names,
    list_rows,
    require_columns,
    shown_names,
    unique_names,
)
from dehyst.io.text import Text, expand, open_text
from dehyst.io.thousands import marks_of, separator_of, thousands_finding, thousands_refusal, without
from dehyst.shell import visible
from dehyst.units import parse_unit

SUSPECT = " \t#%/"  # first characters of lines that may be comments or blank
TEXT_MOST = 0.1  # of the filled cells of a column may be text, and their rows left out


def read_delimited(data: bytes, name: str, sha256: str = "") -> Table:
    """Read a text log."""
    text = open_text(expand(data, name), name)
    layout = layout_of(text, name)
    findings: list[Finding] = []
    quick = _quick(text, layout, findings) if layout else None
    if layout and quick:
        return _assemble(name, sha256, layout, quick[1], quick[0], findings)
    lines = text.all_lines()
    layout = layout if layout and text.complete else find_layout(lines, name)
    body, rows = _body(lines, layout.first)
    cells, rows = _split(body, rows, layout, name, findings)
    content = _careful(cells, rows, layout, name, findings)
    return _assemble(name, sha256, layout, rows, content, findings)


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
        findings.append(
            Finding(
                "ragged-lines",
                f"{list_rows(ragged)} of {name} do not have the {layout.width} cells of the others and were left "
                f"out: the logger was interrupted or lines were damaged. Look at them, and mend or delete them.",
            )
        )
    if ragged.size > 0.5 * keep.size:
        raise LogError(
            f"log '{name}' is not a table: {ragged.size} of its {keep.size} lines do not have the {layout.width} cells "
            f"of the others ({list_rows(ragged)}). Check the delimiter and the decimal sign, or cut the file.",
            file=name,
            rows=ragged,
        )
    return list(compress(cells, keep)), rows[keep]


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
            whole, text = parse_numbers(without(column, marks[j], separator), commas)
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
                _warn_decimal_comma(column, layout, j, findings)
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
    given = parse_unit(f"x [{visible(layout.units[j])}]")[1] if layout.units and layout.units[j] else ""
    return given or parse_unit(_name(layout, j))[1]


def _name(layout: Layout, j: int) -> str:
    return visible(layout.names[j]) if layout.names else f"column_{j + 1}"


def _dates(column: Sequence[str], layout: Layout, j: int, findings: list[Finding]) -> Array:
    """Seconds of a column of dates, and what had to be assumed."""
    order, assumed = date_order(column)
    if assumed:
        name = _name(layout, j)
        findings.append(
            Finding(
                "date-order",
                f"dates in column '{name}', such as {column[0].strip()}, were read with the {order} first; nothing in "
                f"the log tells. If that is wrong, log dates as 2024-05-01 12:00:00.",
            )
        )
    return parse_date_times(column)


def _warn_decimal_comma(column: Sequence[str], layout: Layout, j: int, findings: list[Finding]) -> None:
    """1,234 is 1.234 or 1234: say so where all commas are followed by three digits and some cells have none."""
    tails = [len(cell.partition(",")[2]) for cell in column if "," in cell]
    if tails and set(tails) == {3} and len(tails) < sum(is_data(cell) for cell in column):
        name = _name(layout, j)
        findings.append(
            Finding(
                "decimal-comma",
                f"commas in column '{name}' were read as decimal signs (1,234 is 1.234), but three digits follow "
                f"each and other cells have none. If they separate thousands, save the log without them.",
            )
        )


def _assemble(
    name: str,
    sha256: str,
    layout: Layout,
    rows: Rows,
    content: Content,
    findings: list[Finding],
) -> Table:
    numbers, labels, stamps = content.numbers, content.labels, content.stamps
    raw = shown_names(layout.names or [_name(layout, j) for j in range(layout.width)], name, findings)
    names = unique_names(raw)
    doubled = sorted({given for given, unique in zip(raw, names, strict=True) if given and given != unique})
    if doubled:
        findings.append(
            Finding(
                "duplicate-columns",
                f"{name} names several columns {list_names(doubled, 8)}; the later ones were renamed "
                f"({list_names([u for g, u in zip(raw, names, strict=True) if g != u and g], 8)}). "
                f"Name the one you mean, or use #3 for the third column.",
            )
        )
    units = {names[j]: content.units.get(j) or _header_unit(layout, j) for j in numbers}
    units.update({names[j]: "s" for j in stamps})
    columns = {names[j]: numbers[j] for j in sorted(numbers) if not _is_trailing(layout, names[j], numbers[j])}
    return require_columns(
        Table(
            name=name,
            columns=columns,
            units={column: units[column] for column in columns},
            rows=rows,
            labels={names[j]: labels[j] for j in sorted(labels)},
            row_word="line",
            stamps=frozenset(names[j] for j in stamps),
            order=tuple(names),
            sha256=sha256,
            findings=tuple(findings),
            refused={names[j]: reason for j, reason in content.refused.items() if names[j] in columns},
        )
    )


def _is_trailing(layout: Layout, column: str, values: Array) -> bool:
    """Column made by a delimiter at the end of every line: last, nameless, empty."""
    return column == f"column_{layout.width}" and layout.width > 1 and not finite(values).any()
