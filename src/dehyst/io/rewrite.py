"""Writes a text log anew, line by line, where its cells cannot be told by one delimiter.

Commas may part cells and mark decimals, blanks may part cells and the two halves of a stamp, and tables of a text
editor have an outline. What was joined then reads like every other log.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

from dehyst.errors import LogError
from dehyst.findings import Finding
from dehyst.io.cells import is_data, is_date_time
from dehyst.io.clocks import TIME_WORDS
from dehyst.io.heading import header_cells
from dehyst.io.layout import Layout
from dehyst.io.lines import BLANKS, COMMENTS, is_comment, split_line
from dehyst.io.text import Text
from dehyst.units import parse_unit, words

ROWS = 400  # lines that decide
MOST_CELLS = 40  # in a line in which commas may mean two things
MOST_READINGS = 2000  # that are tried
_WHOLE = re.compile(r"\s*[+-]?\d+", re.ASCII)
_DIGITS = re.compile(r"\d+\s*", re.ASCII)
_LEADING_ZERO = re.compile(r"0\d+\s*", re.ASCII)
_MONITOR = re.compile(r"\s*(\d{1,2}:\d\d:\d\d[.,]\d+)\s*->\s*", re.ASCII)  # how Arduino's serial monitor begins a line
_HALF_DAY = re.compile(r"[AP]M", re.IGNORECASE)


@dataclass(frozen=True)
class Rewriting:
    """How each line is written anew, and what to say about it."""

    line: Callable[[str], str]
    findings: tuple[Finding, ...] = ()


def rewriting(lines: Sequence[str], layout: Layout, log: str) -> Rewriting | None:
    """How to write a log anew whose lines read as `layout`; None where nothing needs to be.

    Raises
    ------
    LogError
        If commas part cells and mark decimals, and nothing tells which does what.
    """
    if layout.width > MOST_CELLS:
        return None
    rows = [line for line in lines[layout.first : layout.first + ROWS] if not is_comment(line)]
    if rows and all(map(_MONITOR.match, rows)):
        return Rewriting(_without_arrow(layout.delimiter))
    if layout.delimiter == "|" and all(_is_outlined(line) for line in rows if line.count("|") == layout.width - 1):
        return Rewriting(_without_outline)
    if layout.delimiter not in {BLANKS, ","}:
        return None
    cells = [row for row in (split_line(line, layout.delimiter) for line in rows) if len(row) == layout.width]
    if layout.delimiter == BLANKS and cells:
        return _joined_stamps(cells, layout)
    if layout.delimiter == "," and not layout.decimal_comma and not layout.names:
        return _joined_decimals([row for row in cells if '"' not in "".join(row)], layout, log)
    return None


def _without_arrow(delimiter: str) -> Callable[[str], str]:
    """Lines whose time of arrival is a cell like the others; above names it is called time."""

    def line(text: str) -> str:
        match = _MONITOR.match(text)
        if match is None:
            return text
        rest = text[match.end() :]
        named = not any(map(is_data, split_line(rest, delimiter)))
        return ("time" if named else match[1].replace(",", ".")) + delimiter + rest

    return line


def _is_outlined(line: str) -> bool:
    return line.strip().startswith("|") and line.strip().endswith("|")


def _without_outline(line: str) -> str:
    """A line of a table without the marks at its ends, and nothing of a rule (``+---+---+``)."""
    if set("+-=|:") >= set(line.strip()):
        return ""
    return line.strip().removeprefix("|").removesuffix("|") if "|" in line else line


def rewritten(text: Text, change: Rewriting) -> Text:
    """A text log with every line written anew; the numbers of its lines stay the same."""
    lines = [change.line(line).replace("\n", " ") for line in text.all_lines()]
    return Text("\n".join(lines).encode(), lines, True)


def _joined_stamps(rows: Sequence[Sequence[str]], layout: Layout) -> Rewriting | None:
    """Dates and times of day that blanks part, as one cell each; not where each of them has a name."""
    ends: dict[int, int] = {}
    last = -1
    for j in range(layout.width - 1):
        if j <= last or ":" in rows[0][j] or ":" not in rows[0][j + 1]:
            continue
        end = j + 3 if j + 2 < layout.width and all(_HALF_DAY.fullmatch(row[j + 2]) for row in rows) else j + 2
        if all(is_date_time(" ".join(row[j:end])) for row in rows):
            ends[j], last = end, end - 1
    named = layout.names is not None and all(
        TIME_WORDS & set(words(parse_unit(layout.names[k])[0])) for j, end in ends.items() for k in range(j, end)
    )
    if not ends or named:
        return None

    start, stop = min(ends.items())

    def line(text: str) -> str:
        cells = split_line(text, BLANKS)
        if is_comment(text) or len(cells) != layout.width or not is_date_time(" ".join(cells[start:stop])):
            mark = next((mark for mark in COMMENTS if text.lstrip().startswith(mark)), "")
            return mark + "\t".join(f'"{cell}"' if "\t" in cell else cell for cell in header_cells(text, BLANKS))
        joined: list[str] = []
        k = 0
        while k < len(cells):
            end = ends.get(k, k + 1)
            joined.append(" ".join(cells[k:end]))
            k = end
        return "\t".join(joined)

    return Rewriting(line)


def _joined_decimals(rows: Sequence[Sequence[str]], layout: Layout, log: str) -> Rewriting | None:
    """Commas that mark decimals in a log whose cells commas part."""
    if not rows:
        return None
    width, wanted = layout.width, len(layout.unfit)
    columns = list(zip(*rows, strict=True))
    whole = [all(_WHOLE.fullmatch(cell) or is_date_time(cell) for cell in column) for column in columns]
    digits = [all(map(_DIGITS.fullmatch, column)) for column in columns]
    free = [j for j in range(1, width) if digits[j] and whole[j - 1]]  # may be the digits after a comma
    if not free:
        return None
    close = [j for j in range(1, width) if not any(cell[:1] == " " for cell in columns[j])]
    apart = [j for j in range(1, width) if all(cell[:1] == " " for cell in columns[j])]
    if apart and close and len(apart) + len(close) == width - 1 and set(close) <= set(free):
        readings = [tuple(close)] if _are_apart(close) else []  # a blank follows each comma that parts cells
    else:
        sure = {j for j in free if any(map(_LEADING_ZERO.fullmatch, columns[j]))}
        sure |= {j + 1 for j in range(width - 1) if any(cell.strip() == "-0" for cell in columns[j]) and j + 1 in free}
        if not sure:
            return None  # whole numbers
        readings = _readings(free, sure, width - wanted if wanted else 0)
    if wanted and not any(width - len(reading) == wanted for reading in readings):
        return None
    if len(readings) == 1 and (wanted or apart):
        return _join(readings[0], rows[0], layout, log)
    if not readings:
        return None
    shown = [_listed(_cells(rows[0], reading, ",")) for reading in readings[:2]]
    if not wanted:
        shown = [_listed(rows[0]), shown[0]]
    raise LogError(
        f"log '{log}' can be read in two ways: its commas part cells, and some seem to mark decimals as well. Its "
        f"first row is {shown[0]} or {shown[1]}. Save it with semicolons between the cells, or with points as decimal "
        f"signs.",
        file=log,
    )


def _are_apart(places: Sequence[int]) -> bool:
    return all(later > earlier + 1 for earlier, later in pairwise(places))


def _readings(free: Sequence[int], sure: set[int], count: int) -> list[tuple[int, ...]]:
    """Sets of columns that are the digits after a comma: `count` of them, or any number if it is 0."""
    found: list[tuple[int, ...]] = []
    others = [j for j in free if j not in sure and j - 1 not in sure and j + 1 not in sure]
    if not _are_apart(sorted(sure)):
        return []
    sizes = [count - len(sure)] if count else range(len(others), -1, -1)
    for size in sizes:
        for more in _some(others, size):
            reading = tuple(sorted({*sure, *more}))
            if _are_apart(reading):
                found.append(reading)
            if len(found) > MOST_READINGS:
                return found
    return found


def _some(places: Sequence[int], size: int) -> list[tuple[int, ...]]:
    """Every choice of `size` places of which no two are neighbours."""
    if size == 0:
        return [()]
    if size < 0 or not places:
        return []
    first, *rest = places
    with_first = [(first, *more) for more in _some([j for j in rest if j > first + 1], size - 1)]
    return [*with_first, *_some(rest, size)]


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
    return " | ".join(cells[:8]) + (" | ..." if len(cells) > 8 else "")


def _join(reading: Sequence[int], row: Sequence[str], layout: Layout, log: str) -> Rewriting:
    def line(text: str) -> str:
        cells = split_line(text, ",")
        return ";".join(_cells(cells, reading, ".") if len(cells) == layout.width else cells)

    count = len(layout.unfit)
    why = (
        f"its header has {count} name{'s' if count > 1 else ''}"
        if layout.unfit
        else "a blank follows those that part cells"
    )
    said = (
        f"commas in {log} part cells and mark decimals: {why}, so its first row was read as "
        f"{_listed(_cells(row, reading, ','))}. If that is wrong, save the log with semicolons between the cells."
    )
    return Rewriting(line, (Finding("comma-twice", said),))
