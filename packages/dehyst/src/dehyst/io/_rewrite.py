"""Writes a text log anew, line by line, where its cells cannot be told by one delimiter.

Commas may part cells and mark decimals, blanks may part cells and the two halves of a stamp, and tables of a text
editor have an outline. What was joined then reads like every other log.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import filterfalse, pairwise

from dehyst.errors import LogError
from dehyst.findings import Finding
from dehyst.io._cells import is_data, is_date_time
from dehyst.io._clocks import TIME_WORDS
from dehyst.io._heading import header_cells
from dehyst.io._layout import TableLayout
from dehyst.io._lines import BLANKS, COMMENTS, is_comment, split_line
from dehyst.io._table import list_first, number_of
from dehyst.io._text import Text
from dehyst.units import parse_unit, words

ROWS = 400  # lines that decide
MOST_CELLS = 40  # in a line in which commas may mean two things
MOST_READINGS = 2000  # that are tried
_WHOLE = re.compile(r"\s*[+-]?\d+", re.ASCII)
_DIGITS = re.compile(r"\d+\s*", re.ASCII)
_LEADING_ZERO = re.compile(r"0\d+\s*", re.ASCII)
# How Arduino's serial monitor begins a line.
_MONITOR = re.compile(r"\s*(\d{1,2}:\d\d:\d\d[.,]\d+)\s*->\s*", re.ASCII)
_HALF_DAY = re.compile(r"[AP]M", re.IGNORECASE)


@dataclass(frozen=True)
class Rewriting:
    """How each line is written anew, and what to say about it."""

    line: Callable[[str], str]
    findings: tuple[Finding, ...] = ()


def rewriting(lines: Sequence[str], layout: TableLayout, log: str) -> Rewriting | None:
    """How to write a log anew whose lines read as `layout`; None where nothing needs to be.

    Raises
    ------
    LogError
        If commas part cells and mark decimals, and nothing tells which does what.
    """
    if layout.width > MOST_CELLS:
        return None
    body = list(filterfalse(is_comment, lines[layout.first : layout.first + ROWS]))
    if body and all(map(_MONITOR.match, body)):
        return Rewriting(_without_arrow(layout.delimiter))
    if layout.delimiter == "|":
        whole = [line for line in body if line.count("|") == layout.width - 1]
        if all(map(_is_outlined, whole)):
            return Rewriting(_without_outline)
    if layout.delimiter == BLANKS:
        rows = layout.parting.rows(body)
        if rows:
            return _joined_stamps(rows, layout)
    if layout.delimiter == "," and not layout.decimal_comma and not layout.names:
        rows = layout.parting.rows(body)
        return _joined_decimals([row for row in rows if '"' not in "".join(row)], layout, log)
    return None


def _without_arrow(delimiter: str) -> Callable[[str], str]:
    """Lines whose time of arrival is a cell like the others; above names it is called time."""

    def line(text: str) -> str:
        match = _MONITOR.match(text)
        if match is None:
            return text
        after_arrow = text[match.end() :]
        arrival = "time"
        if any(map(is_data, split_line(after_arrow, delimiter))):
            arrival = match[1].replace(",", ".")
        return arrival + delimiter + after_arrow

    return line


def _is_outlined(line: str) -> bool:
    return line.strip().startswith("|") and line.strip().endswith("|")


def _without_outline(line: str) -> str:
    """A line of a table without the marks at its ends, and nothing of a rule (``+---+---+``)."""
    if set("+-=|:") >= set(line.strip()):
        return ""
    if "|" not in line:
        return line
    return line.strip().removeprefix("|").removesuffix("|")


def rewritten(text: Text, change: Rewriting) -> Text:
    """A text log with every line written anew; the numbers of its lines stay the same."""
    lines = [change.line(line).replace("\n", " ") for line in text.all_lines()]
    return Text("\n".join(lines).encode(), lines, True)


def _joined_stamps(rows: Sequence[Sequence[str]], layout: TableLayout) -> Rewriting | None:
    """Dates and times of day that blanks part, as one cell each; not where each of them has a name."""
    ends: dict[int, int] = {}
    last = -1
    for j in range(layout.width - 1):
        if j <= last or ":" in rows[0][j] or ":" not in rows[0][j + 1]:
            continue
        end = j + 2
        # AM or PM may follow the time of day.
        if end < layout.width and all(_HALF_DAY.fullmatch(row[end]) for row in rows):
            end += 1
        if all(is_date_time(" ".join(row[j:end])) for row in rows):
            ends[j], last = end, end - 1
    if not ends or _all_named(ends, layout):
        return None

    start, stop = min(ends.items())

    def line(text: str) -> str:
        cells = split_line(text, BLANKS)
        is_row = not is_comment(text) and len(cells) == layout.width
        if not is_row or not is_date_time(" ".join(cells[start:stop])):
            return _with_tabs(text)
        joined: list[str] = []
        k = 0
        while k < len(cells):
            end = ends.get(k, k + 1)
            joined.append(" ".join(cells[k:end]))
            k = end
        return "\t".join(joined)

    return Rewriting(line)


def _all_named(ends: dict[int, int], layout: TableLayout) -> bool:
    """Whether every column of the stamps is called time: dates and times of day are then columns of their own."""
    if layout.names is None:
        return False
    for start, end in ends.items():
        for name in layout.names[start:end]:
            if not TIME_WORDS & set(words(parse_unit(name)[0])):
                return False
    return True


def _with_tabs(header: str) -> str:
    """A line above the data whose cells are set off by tabs."""
    mark = ""
    for comment in COMMENTS:
        if header.lstrip().startswith(comment):
            mark = comment
            break
    cells: list[str] = []
    for cell in header_cells(header, BLANKS):
        if "\t" in cell:
            cell = f'"{cell}"'
        cells.append(cell)
    return mark + "\t".join(cells)


def _joined_decimals(
    rows: Sequence[Sequence[str]], layout: TableLayout, log: str
) -> Rewriting | None:
    """Commas that mark decimals in a log whose cells commas part."""
    if not rows:
        return None
    width, named_columns = layout.width, len(layout.unfit)
    columns = list(zip(*rows, strict=True))
    free: list[int] = []  # may be the digits after a comma
    close: list[int] = []  # have no blank before them
    apart: list[int] = []  # have one in every row
    sure: set[int] = set()  # are the digits after a comma: 0,05 or -0,5
    for j in range(1, width):
        before, column = columns[j - 1], columns[j]
        blanks = sum(cell.startswith(" ") for cell in column)
        if blanks == 0:
            close.append(j)
        elif blanks == len(column):
            apart.append(j)
        if all(map(_DIGITS.fullmatch, column)) and all(map(_is_whole_or_stamp, before)):
            free.append(j)
            if any(map(_LEADING_ZERO.fullmatch, column)) or "-0" in map(str.strip, before):
                sure.add(j)
    if not free:
        return None
    count = 0
    if named_columns:
        count = width - named_columns
    if apart and close and len(apart) + len(close) == width - 1 and set(close) <= set(free):
        # A blank follows each comma that parts cells.
        readings = [tuple(close)] * _are_apart(close)
    elif sure:
        readings = _readings(free, sure, count)
    else:
        return None  # whole numbers
    if named_columns and count not in map(len, readings):
        return None
    if len(readings) == 1 and (named_columns or apart):
        return _join(readings[0], rows[0], layout, log)
    if not readings:
        return None
    first = _listed(_cells(rows[0], readings[0], ","))
    if named_columns:
        second = _listed(_cells(rows[0], readings[1], ","))
    else:
        first, second = _listed(rows[0]), first
    raise LogError(
        f"log '{log}' can be read in two ways: its commas part cells, and some seem to mark decimals as well. Its "
        f"first row is {first} or {second}. Save it with semicolons between the cells, or with points as decimal "
        f"signs.",
        file=log,
    )


def _is_whole_or_stamp(cell: str) -> bool:
    return bool(_WHOLE.fullmatch(cell)) or is_date_time(cell)


def _are_apart(places: Sequence[int]) -> bool:
    return all(later > earlier + 1 for earlier, later in pairwise(places))


def _readings(free: Sequence[int], sure: set[int], count: int) -> list[tuple[int, ...]]:
    """Sets of columns that are the digits after a comma: `count` of them, or any number if it is 0."""
    readings: list[tuple[int, ...]] = []
    if not _are_apart(sorted(sure)):
        return []
    optional_columns = [j for j in free if sure.isdisjoint((j - 1, j, j + 1))]
    sizes: Sequence[int] = range(len(optional_columns), -1, -1)
    if count:
        sizes = [count - len(sure)]
    for size in sizes:
        for more in _some(optional_columns, size):
            reading = tuple(sorted({*sure, *more}))
            if _are_apart(reading):
                readings.append(reading)
            if len(readings) > MOST_READINGS:
                return readings
    return readings


def _some(places: Sequence[int], size: int) -> list[tuple[int, ...]]:
    """Every choice of `size` places of which no two are neighbours."""
    if size == 0:
        return [()]
    if size < 0 or not places:
        return []
    first, *later_places = places
    choices: list[tuple[int, ...]] = []
    for more in _some([j for j in later_places if j > first + 1], size - 1):
        choices.append((first, *more))
    return choices + _some(later_places, size)


def _cells(row: Sequence[str], reading: Sequence[int], mark: str) -> list[str]:
    """Cells of a row, the digits after a decimal sign joined to those before it."""
    joined: list[str] = []
    for j, cell in enumerate(row):
        if j in reading:
            joined[-1] += mark + cell.strip()
        else:
            joined.append(cell.strip())
    return joined


def _listed(cells: Sequence[str]) -> str:
    return list_first(cells, 8, " | ")


def _join(reading: Sequence[int], row: Sequence[str], layout: TableLayout, log: str) -> Rewriting:
    def line(text: str) -> str:
        cells = split_line(text, ",")
        if len(cells) == layout.width:
            cells = _cells(cells, reading, ".")
        return ";".join(cells)

    why = "a blank follows those that part cells"
    if layout.unfit:
        why = f"its header has {number_of(len(layout.unfit), 'name')}"
    message = (
        f"commas in {log} part cells and mark decimals: {why}, so its first row was read as "
        f"{_listed(_cells(row, reading, ','))}. If that is wrong, save the log with semicolons between the cells."
    )
    return Rewriting(line, (Finding("comma-twice", message),))
