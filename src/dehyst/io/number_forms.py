"""Numbers of a text log that are more than digits: with a unit, in brackets, with separators of thousands.

A unit or brackets are taken away where the whole column agrees. Whether 1.017 is one point something, or one thousand
and seventeen, is asked only where the log uses the other mark as its decimal sign; the column itself must answer it, or
it is refused: a guess would be wrong by a factor of a thousand.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from dehyst.arrays import Rows
from dehyst.findings import Finding
from dehyst.io.cells import MISSING, comma_number
from dehyst.io.table import list_rows
from dehyst.units import canonical

_DIGITS = r"(?:\d[\d.,]*|[.,]\d+)(?:[eE][+-]?\d+)?"
_BRACKETED = re.compile(rf"\(\s*({_DIGITS})\s*\)", re.ASCII)
# A single letter needs a blank before it: 1A and 2A are names of something.
_WITH_UNIT = re.compile(rf"([+-]?{_DIGITS})(?:\s+([^\W\d_]\S*(?: \S+)?|°)|([^\W\d_]{{2,}}|°))")
_TWO_MARKS = re.compile(r"[+-]?\d{1,3}(?:(?:\.\d{3}){2,}|(?:,\d{3}){2,})", re.ASCII)
_GROUPS = {mark: re.compile(rf"[+-]?[1-9]\d{{0,2}}(?:{re.escape(mark)}\d{{3}})+", re.ASCII) for mark in ".,"}
_OTHER = {".": ",", ",": "."}
_NAMES = {".": "points", ",": "commas"}
LARGE = 100.0  # whole numbers up to 999 beside 1.017: read as decimals, the column would leap from 999 to 1


def is_dressed(cell: str) -> bool:
    """Whether a cell holds a number in brackets, with a unit, or with two or more separators of thousands.

    Examples
    --------
    >>> [is_dressed(cell) for cell in ("(3.21)", "1,2 bar", "1.234.567", "3.21", "1A", "OFF")]
    [True, True, True, False, False, False]
    """
    text = cell.strip()
    return bool(_BRACKETED.fullmatch(text) or _TWO_MARKS.fullmatch(text)) or with_unit(text) is not None


def with_unit(cell: str) -> tuple[str, str] | None:
    """Number and unit of a cell, or None if it does not hold both.

    Examples
    --------
    >>> with_unit("1,2 bar"), with_unit("20°"), with_unit("3 pigs")
    (('1,2', 'bar'), ('20', 'deg'), None)
    """
    match = _WITH_UNIT.fullmatch(cell)
    unit = canonical(match[2] or match[3]) if match else None
    return (match[1], unit) if match and unit else None


def undress_units(column: str, cells: Sequence[str], findings: list[Finding]) -> tuple[list[str], str] | None:
    """Cells without their unit, and that unit; None unless all that are not missing carry the same one."""
    filled = [with_unit(cell) for cell in cells if cell.lower() not in MISSING]
    units = {pair[1] if pair else "" for pair in filled}
    if len(units) != 1 or "" in units:
        return None
    unit = units.pop()
    findings.append(
        Finding(
            "unit-in-cells",
            f"every number in column '{column}' carries its unit, {unit}; it was taken from there. Nothing to do.",
        )
    )
    return [pair[0] if (pair := with_unit(cell)) else cell for cell in cells], unit


def undress_negatives(column: str, cells: Sequence[str], rows: Rows, findings: list[Finding]) -> list[str]:
    """Cells with (3.21) as -3.21, where that is all the brackets can mean: no other text, and no minus sign."""
    where = [k for k, cell in enumerate(cells) if cell.startswith("(")]
    plain = [comma_number(cell) for cell in cells if not cell.startswith("(")]
    whole = all(_BRACKETED.fullmatch(cells[k]) for k in where)
    if not where or not whole or not any(value == value for value in plain) or any(v is None or v < 0 for v in plain):
        return list(cells)
    bare = [f"-{cell[1:-1].strip()}" if cell.startswith("(") else cell for cell in cells]
    findings.append(
        Finding(
            "bracketed-negatives",
            f"numbers in brackets in column '{column}' were read as negative ({cells[where[0]]} is {bare[where[0]]}), "
            f"as in accounting: {list_rows(rows[where])}. The column has no minus sign and no other text. If they mean "
            f"something else, save the log without them.",
        )
    )
    return bare


def text_refusal(column: str, log: str, cells: Sequence[str], rows: Rows) -> str:
    """Why a column with much text among its numbers is not read, with two examples."""
    where = [k for k, cell in enumerate(cells) if comma_number(cell) is None]
    kinds = {cells[k]: k for k in reversed(where)}
    examples = " and ".join(f"{cells[k][:30]!r} ({list_rows(rows[[k]])})" for k in sorted(kinds.values())[:2])
    filled = sum(bool(cell) for cell in cells)
    return (
        f"column '{column}' of {log} holds text in {len(where)} of {filled} cells, such as {examples}. Without these "
        f"rows much of the loop would be lost, so it is not read. Write them as plain numbers, or empty the cells in "
        f"which nothing was measured."
    )


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

    def without(self, cells: Sequence[str], mark: str) -> list[str]:
        """Cells of the column without the marks between thousands."""
        grouped = set(self.groups[mark])
        return [cell.replace(mark, "") if position in grouped else cell for position, cell in enumerate(cells)]


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
    """Mark that may separate the thousands of a column, ``""`` if there is none, and whether that is certain.

    `decimals` are the decimal signs that are certain anywhere in the log.

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
        return mark, mark in marks.separators or _is_continued(cells, marks.groups[mark])
    return "", False


def _is_continued(cells: Sequence[str], groups: Sequence[int]) -> bool:
    """Whether numbers below a thousand stand without the mark, and could not stand beside decimals like these.

    A logger that drops the zeros of 5.000 writes 5.020 as 5.02; if a group ends in 0, it drops none.
    """
    grouped = set(groups)
    values = [comma_number(cell) for position, cell in enumerate(cells) if position not in grouped]
    plain = [abs(value) for value in values if value is not None and value == value]
    if not plain or max(plain) >= 1000:
        return False
    return max(plain) >= LARGE or any(cells[position].endswith("0") for position in groups)


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
