"""Fast reader of regular text logs: constant line width, cells that are numbers or short labels."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

import dehyst._native as _native
from dehyst.arrays import Array, Rows
from dehyst.io._cells import cell_number, comma_number, is_date_time, is_dressed
from dehyst.io._layout import TableLayout
from dehyst.io._lines import BLANKS, split_line
from dehyst.io._table import Labels

PROBE = 200  # lines that tell which columns hold labels
LABEL_WIDTH = 64  # characters of a label; longer ones take the careful way
NUMBERISH = "+-(.,0123456789"  # first characters of numbers, plain or not
MOST_BLOCKS = 4096  # of equal labels that are looked at one by one
SPARE = 1.05  # room for more lines than the first ones make expect


@dataclass(frozen=True, slots=True)
class Plain:
    """How the lines of a plain log are to be read."""

    delimiter: str  # a blank stands for any number of blanks
    decimal: str
    # (width,): 0 for a column of numbers, else one more than the longest label
    letters: tuple[int, ...]
    # columns of whole numbers only: a comma in them might separate thousands
    whole: tuple[int, ...] = ()
    missing: bool = False  # whether an empty cell is a missing number
    # columns of labels that begin as numbers do (200g_a): all must be looked at
    doubtful: tuple[int, ...] = ()


@dataclass(frozen=True, slots=True)
class PlainPart:
    """Rows read in one go."""

    columns: list[Array | Labels]  # by position, (K,) each
    rows: Rows  # number of each row's line, (K,)
    lines: int  # used up
    bytes: int
    column: int  # of the cell that is not plain, in the line that follows; -1 if there is none
    empty: bool  # whether there are empty cells
    odd: bool  # whether there are infinite ones


def find_plain(body: Sequence[str], layout: TableLayout) -> Plain | None:
    """How to read a log whose first lines of data are `body`, or None if it is not plain."""
    if not body or '"' in body[0] or (layout.decimal_comma and layout.delimiter == ","):
        return None
    rows = [split_line(line, layout.delimiter) for line in body[:PROBE]]
    if {layout.width} != set(map(len, rows)):
        return None
    columns = list(zip(*rows, strict=True))
    if layout.decimal_comma:
        return _find_plain_commas(columns, layout)

    # A column in which no cell is a number holds labels.
    texts: dict[int, Sequence[str]] = {}
    longest = 0
    for j, column in enumerate(columns):
        if not any(map(_is_number, column)):
            texts[j] = column
            longest = max(longest, *map(len, column))
    doubtful: list[int] = []
    for j, cells in texts.items():
        if any(map(_looks_like_number, cells)):
            # 1.234.567, (3.21) or 1.2 bar are numbers in disguise: the careful way reads them.
            if not all(map(_is_label, set(cells))):
                return None
            doubtful.append(j)

    letters = [0] * layout.width
    for j in texts:
        letters[j] = min(LABEL_WIDTH, 8 + longest)
    missing = layout.delimiter != BLANKS
    return Plain(layout.delimiter, ".", tuple(letters), (), missing, tuple(doubtful))


def _find_plain_commas(columns: Sequence[Sequence[str]], layout: TableLayout) -> Plain | None:
    """How to read a log with decimal commas; None if some may separate thousands, or stand within text."""
    whole: list[int] = []
    for j, column in enumerate(columns):
        text = "".join(column)
        # Points beside decimal commas may separate thousands.
        if "." in text or _may_be_thousands(column):
            return None
        if "," not in text:
            whole.append(j)
        if not any(map(_is_comma_number, column)):
            return None
    return Plain(layout.delimiter, ",", (0,) * layout.width, tuple(whole))


def _is_number(cell: str) -> bool:
    return cell_number(cell) is not None


def _is_comma_number(cell: str) -> bool:
    return cell_number(cell.replace(",", ".")) is not None


def _looks_like_number(cell: str) -> bool:
    return cell.strip()[:1] in NUMBERISH and not is_date_time(cell)


def _is_label(cell: str) -> bool:
    """Whether a cell is a label whatever stands in the other rows: no number, dressed or not, and no date."""
    text = cell.strip()
    if not text:
        return True
    if "," in text or text.startswith("(") or is_dressed(text):
        return False
    return not is_date_time(text) and comma_number(text) is None


def _are_labels(column: Labels) -> bool:
    """Whether all cells of a column are labels; False as well if they are too many to be looked at."""
    starts = np.flatnonzero(np.concatenate(([True], column[1:] != column[:-1])))
    return starts.size <= MOST_BLOCKS and all(map(_is_label, set(column[starts].tolist())))


def _may_be_thousands(column: Sequence[str]) -> bool:
    tails = {len(cell.partition(",")[2].strip()) for cell in column if "," in cell}
    return tails == {3}


def read_part(text: bytes, offset: int, line: int, plain: Plain, capacity: int) -> PlainPart:
    """Read at most `capacity` rows of UTF-8 text from a byte on, which begins line number `line`."""
    columns: list[npt.NDArray[Any]] = []
    for width in plain.letters:
        if width:
            columns.append(np.empty((capacity, width), np.uint32))
        else:
            columns.append(np.empty(capacity))
    rows = np.empty(capacity, dtype=np.int64)
    count, lines, used, column, empty, odd = _native.text_read(
        text,
        offset,
        line,
        plain.delimiter,
        plain.decimal,
        list(plain.letters),
        columns,
        rows,
        plain.missing,
    )
    # Labels are filled in as code points: the same bytes are texts of fixed length.
    filled: list[Any] = []
    for values, width in zip(columns, plain.letters, strict=True):
        if width:
            filled.append(values[:count].view(f"U{width}")[:, 0])
        else:
            filled.append(values[:count])
    return PlainPart(filled, rows[:count], lines, used, column, empty, odd)


def read_plain(
    text: bytes, offset: int, line: int, plain: Plain
) -> tuple[list[Array | Labels], Rows] | None:
    """All columns from a byte on, and the number of each row's line; None if a cell is not plain."""
    columns: list[Array | Labels] = []
    rows: Rows = np.zeros(0, dtype=np.int64)
    empty = odd = False
    while offset < len(text):
        part = read_part(text, offset, line, plain, _room(text, offset))
        if part.column >= 0:
            return None
        offset += part.bytes
        line += part.lines
        empty |= part.empty
        odd |= part.odd
        # Nearly always there is one part: only if the room was too small, they are joined.
        if rows.size:
            columns = list(map(np.concatenate, zip(columns, part.columns, strict=True)))
            rows = np.concatenate((rows, part.rows))
        else:
            columns, rows = part.columns, part.rows
    if rows.size == 0 or (empty and odd) or not keeps_whole(columns, plain):
        return None
    for j, width in enumerate(plain.letters):
        if width and (empty or j in plain.doubtful) and not _are_labels(columns[j]):  # type: ignore[arg-type]
            return None
    return columns, rows


def keeps_whole(columns: Sequence[npt.NDArray[Any]], plain: Plain) -> bool:
    """Whether columns without commas in the first lines have none later on: 998, 999, 1,017."""
    return not any((columns[j] != np.round(columns[j])).any() for j in plain.whole)


def _room(text: bytes, offset: int) -> int:
    """Rows to expect from a byte on, by the length of the next lines."""
    head = text[offset : offset + (1 << 16)]
    return int(SPARE * _native.text_lines(head) * (len(text) - offset) / len(head)) + 64
