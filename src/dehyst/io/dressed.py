"""Dressed numbers: cells that hold a number and something around it, as (3.21) for -3.21 or 1.2 bar."""

from __future__ import annotations

import re
from collections.abc import Sequence

from dehyst.arrays import Rows
from dehyst.findings import Finding
from dehyst.io.cells import MISSING, comma_number
from dehyst.io.table import list_rows
from dehyst.units import canonical

_DIGITS = r"(?:\d[\d.,]*|[.,]\d+)(?:[eE][+-]?\d+)?"
_BRACKETED = re.compile(rf"\(\s*({_DIGITS})\s*\)", re.ASCII)
# A single letter needs a blank before it: 1A and 2A are names of something.
_WITH_UNIT = re.compile(rf"([+-]?{_DIGITS})(?:\s+([^\W\d_]\S*(?: \S+)?|°)|([^\W\d_]{{2,}}|°))")
_GROUPED = re.compile(r"[+-]?\d{1,3}(?:(?:\.\d{3}){2,}|(?:,\d{3}){2,})", re.ASCII)


def is_dressed(cell: str) -> bool:
    """Whether a cell holds a number in brackets, with a unit, or with two or more separators of thousands.

    Examples
    --------
    >>> [is_dressed(cell) for cell in ("(3.21)", "1,2 bar", "1.234.567", "3.21", "1A", "OFF")]
    [True, True, True, False, False, False]
    """
    text = cell.strip()
    return bool(_BRACKETED.fullmatch(text) or _GROUPED.fullmatch(text)) or with_unit(text) is not None


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
    shown = sorted(kinds.values())[:2]
    examples = " and ".join(f"{cells[k][:30]!r} ({list_rows(rows[[k]])})" for k in shown)
    filled = sum(bool(cell) for cell in cells)
    return (
        f"column '{column}' of {log} holds text in {len(where)} of {filled} cells, such as {examples}. Without these "
        f"rows much of the loop would be lost, so it is not read. Write them as plain numbers, or empty the cells in "
        f"which nothing was measured."
    )
