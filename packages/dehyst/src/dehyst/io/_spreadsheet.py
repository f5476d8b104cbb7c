"""Spreadsheets (.xlsx .xlsm .xlsb .xls .ods), by calamine: the extra ``dehyst[excel]``.

One sheet, that with the most numbers unless another is named, is read as a text log would be: preamble, header and a
row of units may stand above the numbers.
"""

from __future__ import annotations

import datetime as dt
import io
from pathlib import Path
from typing import Any

from dehyst.errors import LogError
from dehyst.findings import Finding
from dehyst.io._collect import Collector
from dehyst.io._delimited import read_delimited
from dehyst.io._table import list_names
from dehyst.shell import options_line


def fill(collector: Collector, data: bytes, path: Path) -> None:
    """Add the columns of one sheet."""
    import python_calamine

    book = python_calamine.load_workbook(io.BytesIO(data))
    sheets: dict[str, Rows] = {}
    for name in book.sheet_names:
        sheets[name] = book.get_sheet_by_name(name).to_python(skip_empty_area=True)
    asked = collector.sheet
    if asked is None:
        chosen = max(sheets, key=lambda name: _content(sheets[name]))
    else:
        chosen = _named(collector.name, sheets, asked)
    collector.sheet = chosen
    text = "\n".join("\t".join(map(_cell, row)) for row in sheets[chosen])
    try:
        table = read_delimited(text.encode(), collector.name)
    except LogError:
        raise LogError(
            f"sheet '{chosen}' of '{collector.name}' holds no table of numbers. {_listed(sheets)}",
            sheets=tuple(sheets),
        ) from None
    collector.columns = dict(table.columns)
    collector.labels = dict(table.labels)
    collector.refused = dict(table.refused)
    collector.units = dict(table.units)
    collector.stamps = set(table.stamps)
    collector.findings = list(table.findings)
    if len(sheets) > 1 and asked is None:
        collector.findings.append(
            Finding(
                "sheet",
                f"{collector.name} holds {len(sheets)} sheets; '{chosen}', which has the most numbers, is read. "
                f"{_listed(sheets)}",
            )
        )


Rows = list[list[Any]]


def _content(rows: Rows) -> tuple[int, int]:
    """Cells of numbers, and rows, of a sheet: notes may be longer than the log."""
    return sum(isinstance(cell, int | float) for row in rows for cell in row), len(rows)


def _named(log: str, sheets: dict[str, Rows], asked: str | int) -> str:
    """Name of the sheet that is meant: by its name, also in another case, else by its number from 1."""
    text = str(asked)
    for name in sheets:
        if name == text:
            return name
    same = [name for name in sheets if name.strip().lower() == text.strip().lower()]
    if len(same) == 1:
        return same[0]
    names = list(sheets)
    if text.isascii() and text.isdigit() and 1 <= int(text) <= len(names):
        return names[int(text) - 1]
    raise LogError(f"'{log}' has no sheet '{text}'. {_listed(sheets)}", sheets=tuple(names))


def _listed(sheets: dict[str, Rows]) -> str:
    """What to type for each sheet."""
    listed = [f"{options_line(sheet=name)} ({len(rows)} rows)" for name, rows in sheets.items()]
    return f"Its sheets: {list_names(listed)}."


def _cell(value: object) -> str:
    """A cell as text with all digits."""
    if isinstance(value, dt.datetime):
        return value.isoformat()  # with a T: a blank within a cell might part it
    if isinstance(value, dt.timedelta):
        return repr(value.total_seconds())
    if isinstance(value, float):
        return repr(value)
    return " ".join(str(value).split())
