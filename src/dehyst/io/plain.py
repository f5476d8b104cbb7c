"""Fast reader of regular text logs: constant line width, cells that are numbers or short labels."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

import dehyst._native as _native
from dehyst.arrays import Array, Rows
from dehyst.io.cells import comma_number, is_date_time, is_dressed, number
from dehyst.io.layout import Layout
from dehyst.io.lines import BLANKS, split_line

PROBE = 200  # lines that tell which columns hold labels
LABEL_WIDTH = 64  # characters of a label; longer ones take the careful way
NUMBERISH = "+-(.,0123456789"  # first characters of numbers, plain or not
MOST_BLOCKS = 4096  # of equal labels that are looked at one by one
SPARE = 1.05  # room for more lines than the first ones make expect

Labels = npt.NDArray[np.str_]


@dataclass(frozen=True, slots=True)
class Plain:
    """How the lines of a plain log are to be read."""

    delimiter: str  # a blank stands for any number of blanks
    decimal: str
    letters: tuple[int, ...]  # (width,): 0 for a column of numbers, else one more than the longest label
    whole: tuple[int, ...] = ()  # columns of whole numbers only: a comma in them might separate thousands
    missing: bool = False  # whether an empty cell is a missing number
    doubtful: tuple[int, ...] = ()  # columns of labels that begin as numbers do (200g_a): all must be looked at


@dataclass(frozen=True, slots=True)
class Part:
    """Rows read in one go."""

    columns: list[Array | Labels]  # by position, (K,) each
    rows: Rows  # number of each row's line, (K,)
    lines: int  # used up
    bytes: int
    column: int  # of the cell that is not plain, in the line that follows; -1 if there is none
    empty: bool  # whether there are empty cells
    odd: bool  # whether there are infinite ones


def find_plain(body: Sequence[str], layout: Layout) -> Plain | None:
    """How to read a log whose first lines of data are `body`, or None if it is not plain."""
    if not body or '"' in body[0] or (layout.decimal_comma and layout.delimiter == ","):
        return None
    probe = [split_line(line, layout.delimiter) for line in body[:PROBE]]
    if any(len(row) != layout.width for row in probe):
        return None
    columns = range(layout.width)
    whole: tuple[int, ...] = ()
    if layout.decimal_comma:
        if any(_may_be_thousands([row[j] for row in probe]) for j in columns):
            return None
        if any("." in line for line in body[:PROBE]):
            return None  # points beside decimal commas may separate thousands
        whole = tuple(j for j in columns if not any("," in row[j] for row in probe))
        probe = [[cell.replace(",", ".") for cell in row] for row in probe]
    texts = {j for j in columns if all(number(row[j]) is None for row in probe)}
    if texts and layout.decimal_comma:
        return None  # commas within text are not decimal signs
    doubtful = tuple(j for j in texts if any(_looks_like_number(row[j]) for row in probe))
    if not all(_is_label(cell) for j in doubtful for cell in {row[j] for row in probe}):
        return None  # 1.234.567, (3.21) or 1.2 bar: numbers in disguise
    width = min(LABEL_WIDTH, 8 + max((len(row[j]) for row in probe for j in texts), default=0))
    letters = tuple(width if j in texts else 0 for j in columns)
    missing = not (layout.decimal_comma or layout.delimiter == BLANKS)
    return Plain(layout.delimiter, "," if layout.decimal_comma else ".", letters, whole, missing, doubtful)


def _looks_like_number(cell: str) -> bool:
    return cell.strip()[:1] in NUMBERISH and not is_date_time(cell)


def _is_label(cell: str) -> bool:
    """Whether a cell is a label whatever stands in the other rows: no number, dressed or not, and no date."""
    text = cell.strip()
    if "," in text or text.startswith("(") or is_dressed(text):
        return False
    return not text or not (is_date_time(text) or comma_number(text) is not None)


def _are_labels(column: Labels) -> bool:
    """Whether all cells of a column are labels; False as well if they are too many to be looked at."""
    starts = np.flatnonzero(np.concatenate(([True], column[1:] != column[:-1])))
    return starts.size <= MOST_BLOCKS and all(map(_is_label, set(column[starts].tolist())))


def _may_be_thousands(column: Sequence[str]) -> bool:
    tails = {len(cell.partition(",")[2].strip()) for cell in column if "," in cell}
    return tails == {3}


def read_part(text: bytes, offset: int, line: int, plain: Plain, capacity: int) -> Part:
    """Read at most `capacity` rows of UTF-8 text from a byte on, which begins line number `line`."""
    columns: list[Any] = [np.empty((capacity, k), np.uint32) if k else np.empty(capacity) for k in plain.letters]
    rows = np.empty(capacity, dtype=np.int64)
    count, lines, used, column, empty, odd = _native.text_read(
        text, offset, line, plain.delimiter, plain.decimal, list(plain.letters), columns, rows, plain.missing
    )
    cut = [v[:count].view(f"U{k}")[:, 0] if k else v[:count] for v, k in zip(columns, plain.letters, strict=True)]
    return Part(cut, rows[:count], lines, used, column, empty, odd)


def read_plain(text: bytes, offset: int, line: int, plain: Plain) -> tuple[list[Array | Labels], Rows] | None:
    """All columns from a byte on, and the number of each row's line; None if a cell is not plain."""
    parts: list[Part] = []
    while offset < len(text):
        part = read_part(text, offset, line, plain, _room(text, offset))
        if part.column >= 0:
            return None
        offset, line = offset + part.bytes, line + part.lines
        parts.append(part)
    if not any(part.rows.size for part in parts) or (any(p.empty for p in parts) and any(p.odd for p in parts)):
        return None
    if len(parts) == 1:
        columns, rows = parts[0].columns, parts[0].rows
    else:
        columns = [np.concatenate(column) for column in zip(*(p.columns for p in parts), strict=True)]
        rows = np.concatenate([p.rows for p in parts])
    empty = any(p.empty for p in parts)
    unsure = [j for j, k in enumerate(plain.letters) if k and (empty or j in plain.doubtful)]
    if not keeps_whole(columns, plain) or not all(_are_labels(columns[j]) for j in unsure):  # type: ignore[arg-type]
        return None
    return columns, rows


def keeps_whole(columns: Sequence[npt.NDArray[Any]], plain: Plain) -> bool:
    """Whether columns without commas in the first lines have none later on: 998, 999, 1,017."""
    return not any((columns[j] != np.round(columns[j])).any() for j in plain.whole)


def _room(text: bytes, offset: int) -> int:
    """Rows to expect from a byte on, by the length of the next lines."""
    head = text[offset : offset + (1 << 16)]
    return int(SPARE * _native.text_lines(head) * (len(text) - offset) / len(head)) + 64
