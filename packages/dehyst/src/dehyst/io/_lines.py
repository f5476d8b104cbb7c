"""Lines of a text log and their cells."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import filterfalse

from dehyst.io._cells import MISSING, cell_number, comma_number, is_date_time, is_dressed

COMMENTS = ("#", "%", "//")
VOTERS = 1000  # cells of a line that tell what the others are
BLANKS = " "  # delimiter meaning one or more blanks


def is_comment(line: str) -> bool:
    """Whether a line is empty or a comment."""
    stripped = line.lstrip()
    return not stripped or stripped.startswith(COMMENTS)


def split_line(line: str, delimiter: str) -> list[str]:
    """Cells of one line; a quoted cell may hold the delimiter, but never the end of the line.

    Examples
    --------
    >>> split_line('1,"a,b",2', ","), split_line("  1   2 ", " ")
    (['1', 'a,b', '2'], ['1', '2'])
    """
    if '"' not in line:
        if delimiter == BLANKS:
            return line.split()
        return line.split(delimiter)
    if delimiter == BLANKS:
        line = line.strip()
    try:
        return next(csv.reader([line], delimiter=delimiter, skipinitialspace=True), [])
    except csv.Error:
        return [line]


@dataclass(frozen=True, slots=True)
class Parting:
    """What parts the cells of a line, and how their numbers are written."""

    delimiter: str  # , ; | tab, or one blank for any number of blanks
    decimal_comma: bool
    width: int  # cells in a line of data

    def split(self, line: str) -> list[str]:
        """Cells of a line."""
        return split_line(line, self.delimiter)

    def rows(self, lines: Iterable[str]) -> list[list[str]]:
        """Cells of those lines that have as many as the lines of data."""
        return [cells for cells in map(self.split, lines) if len(cells) == self.width]

    def value(self, cell: str) -> float | None:
        """Number of a cell in which no mark separates thousands; None for text."""
        if self.decimal_comma:
            cell = cell.replace(",", ".")
        return cell_number(cell)

    def is_number(self, cell: str) -> bool:
        """Whether a cell holds a number, perhaps with its unit, or says that it is missing."""
        read = cell_number
        if self.decimal_comma:
            read = comma_number
        value = read(cell)
        if value is None:
            return is_dressed(cell)
        return value == value or cell.strip() != ""

    def is_data(self, cell: str) -> bool:
        """Whether a cell holds a number or a date-time, missing or not."""
        return self.is_number(cell) or is_date_time(cell)

    def is_data_row(self, cells: Sequence[str]) -> bool:
        """Whether most cells of a line hold numbers or date-times."""
        if len(cells) != self.width:
            return False
        filled = list(filterfalse(is_missing, cells[:VOTERS]))
        hits = sum(map(self.is_data, filled))
        return hits > 0 and len(filled) - hits <= hits


def is_missing(cell: str) -> bool:
    """Whether a cell is empty, or says that there is no number."""
    return cell.strip().lower() in MISSING
