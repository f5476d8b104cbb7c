"""Spreadsheets (.xlsx .xlsm .xlsb .xls .ods), by calamine: the extra ``dehyst[excel]``.

The sheet with the most rows is read as a text log would be: preamble, header and a row of units may stand above the
numbers.
"""

from __future__ import annotations

import datetime as dt
import io
from pathlib import Path

from dehyst.findings import Finding
from dehyst.io.collect import Collector
from dehyst.io.delimited import read_delimited


def fill(found: Collector, data: bytes, path: Path) -> None:
    """Add the columns of the longest sheet."""
    import python_calamine

    book = python_calamine.load_workbook(io.BytesIO(data))
    sheets = {name: book.get_sheet_by_name(name) for name in book.sheet_names}
    chosen = max(sheets, key=lambda name: sheets[name].total_height)
    rows = sheets[chosen].to_python(skip_empty_area=True)
    text = "\n".join("\t".join(map(_cell, row)) for row in rows)
    table = read_delimited(text.encode(), found.name)
    found.columns, found.labels = dict(table.columns), dict(table.labels)
    found.units, found.stamps = dict(table.units), set(table.stamps)
    found.findings = list(table.findings)
    if len(sheets) > 1:
        others = ", ".join(name for name in sheets if name != chosen)
        found.findings.append(
            Finding(
                "sheet", f"{found.name} holds {len(sheets)} sheets; '{chosen}', the longest, is read, not {others}."
            )
        )


def _cell(value: object) -> str:
    """A cell as text with all digits."""
    if isinstance(value, dt.datetime):
        return value.isoformat(sep=" ")
    if isinstance(value, dt.timedelta):
        return repr(value.total_seconds())
    return repr(value) if isinstance(value, float) else " ".join(str(value).split())
