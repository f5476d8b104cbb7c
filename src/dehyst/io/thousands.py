"""Thousands: whether 1.017 is one point something, or one thousand and seventeen.

Only a log that uses the other mark as its decimal sign raises the question; where it does, the column itself must
answer it, or the column is refused: a guess would be wrong by a factor of a thousand.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from dehyst.arrays import Rows
from dehyst.findings import Finding
from dehyst.io.cells import comma_number
from dehyst.io.table import list_rows

_GROUPS = {mark: re.compile(rf"[+-]?[1-9]\d{{0,2}}(?:{re.escape(mark)}\d{{3}})+", re.ASCII) for mark in ".,"}
_OTHER = {".": ",", ",": "."}
_NAMES = {".": "points", ",": "commas"}
LARGE = 100.0  # whole numbers up to 999 beside 1.017: read as decimals, the column would leap from 999 to 1


@dataclass(frozen=True)
class Marks:
    """How the numbers of one column use points and commas.

    Attributes
    ----------
    groups
        Mark -> positions of the cells that may be whole numbers with that mark between thousands (``1.017``).
    decimals
        Marks that some cell can only use as a decimal sign (``0.5``, ``3.25``, ``1.017,5``: the comma).
    separators
        Marks that some cell can only use between thousands (``1.234.567``, ``1.017,5``: the point).
    """

    groups: dict[str, list[int]]
    decimals: frozenset[str]
    separators: frozenset[str]


def marks_of(cells: Sequence[str]) -> Marks:
    """Look at every number of a column that holds a point or a comma; text is passed over.

    Examples
    --------
    >>> marks = marks_of(["999", "1.017", "0,5", "text, or so"])
    >>> marks.groups["."], sorted(marks.decimals), sorted(marks.separators)
    ([1], [','], [])
    """
    groups: dict[str, list[int]] = {".": [], ",": []}
    decimals: set[str] = set()
    separators: set[str] = set()
    for position, cell in enumerate(cells):
        used = [mark for mark in ".," if mark in cell]
        if not used:
            continue
        mark = used[0]
        if len(used) == 1 and _GROUPS[mark].fullmatch(cell):
            groups[mark].append(position)
            separators.update(used if cell.count(mark) > 1 else [])
        elif (len(used) > 1 or mark not in decimals) and comma_number(cell) is not None:
            last = max(used, key=cell.rindex)
            decimals.add(last)
            separators.update(set(used) - {last})
    return Marks(groups, frozenset(decimals), frozenset(separators))


def separator_of(cells: Sequence[str], marks: Marks, decimals: frozenset[str]) -> tuple[str, bool]:
    """Mark that may separate the thousands of a column, and whether that is certain.

    `decimals` are the decimal signs that are certain anywhere in the log.

    Returns
    -------
    mark : str
        ``"."`` or ``","``, or ``""`` if the groups of three digits, if any, are decimals.
    certain : bool

    Examples
    --------
    >>> def ask(*cells):
    ...     return separator_of(cells, marks_of(cells), frozenset(","))
    >>> ask("998", "999", "1.017"), ask("2.998", "3.169"), ask("0.998", "1.017")
    (('.', True), ('.', False), ('', False))
    """
    for mark in ".,":
        asked = _OTHER[mark] in decimals or mark in marks.separators
        if not marks.groups[mark] or not asked:
            continue
        if mark in marks.decimals:
            # 0.998 beside 1.017: decimals, unless another cell contradicts that.
            if marks.separators or _OTHER[mark] in marks.decimals:
                return mark, False
            continue
        return mark, mark in marks.separators or _is_continued(cells, marks.groups[mark], mark)
    return "", False


def _is_continued(cells: Sequence[str], groups: Sequence[int], mark: str) -> bool:
    """Whether numbers below a thousand stand without the mark, and could not stand beside decimals like these.

    A logger that drops the zeros of 5.000 writes 5.020 as 5.02; if a group ends in 0, it drops none.
    """
    grouped = set(groups)
    values = [comma_number(cell) for position, cell in enumerate(cells) if position not in grouped]
    plain = [abs(value) for value in values if value is not None and value == value]
    if not plain or max(plain) >= 1000:
        return False
    return max(plain) >= LARGE or any(cells[position].endswith("0") for position in groups)


def without(cells: Sequence[str], marks: Marks, mark: str) -> list[str]:
    """Cells of a column without the marks between thousands."""
    grouped = set(marks.groups[mark])
    return [cell.replace(mark, "") if position in grouped else cell for position, cell in enumerate(cells)]


def thousands_finding(column: str, cells: Sequence[str], marks: Marks, mark: str, rows: Rows) -> Finding:
    """What was read, and where."""
    where = marks.groups[mark]
    cell = cells[where[0]]
    return Finding(
        "thousands-separator",
        f"{_NAMES[mark]} in column '{column}' were read as separators of thousands ({cell} is "
        f"{cell.replace(mark, '')}): {list_rows(rows[where])}. The numbers without one lie below 1000, or some have "
        f"two. If they are decimal signs, save the log with one decimal sign throughout.",
    )


def thousands_refusal(column: str, log: str, cells: Sequence[str], marks: Marks, mark: str, rows: Rows) -> str:
    """Both readings of a column that can be read in two ways, and the way out."""
    where = marks.groups[mark]
    cell, other = cells[where[0]], _OTHER[mark]
    return (
        f"column '{column}' of {log} can be read in two ways: {cell} ({list_rows(rows[where])}) is "
        f"{cell.replace(mark, '')} if its {_NAMES[mark]} separate thousands, and {cell.replace(mark, '.')} if they are "
        f"decimal signs; elsewhere the log uses {_NAMES[other]} for that. The readings differ by a factor of 1000, so "
        f"none was chosen. Save the column without separators ({cell.replace(mark, '')}), or with the decimal sign of "
        f"the other numbers ({cell.replace(mark, other)})."
    )
