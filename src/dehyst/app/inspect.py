"""dehyst inspect: what is in a log."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from pathlib import Path

from rich.cells import cell_len
from rich.console import Console
from rich.table import Table
from rich.text import Text

from dehyst.app.terminal import print_findings, print_json, terminal
from dehyst.io import LogSummary, inspect_log
from dehyst.io.inspect import ColumnSummary
from dehyst.shell import visible

# Letters left for the last column of the table at least.
REMARK = 24
# More columns than this are a recording of everything: those that may be wanted come first, the others are counted.
MOST_COLUMNS = 60


def run_inspect(log: Path, run: str | None, as_json: bool, time_unit: str | None = None) -> None:
    """Print columns, sampling, runs and the line to type next."""
    summary = inspect_log(log, run, time_unit=time_unit)
    if as_json:
        print_json(dataclasses.asdict(summary))
        return
    _print(summary)


def _print(summary: LogSummary) -> None:
    out = terminal()
    rows = f"{summary.rows} rows" + (f" of run '{summary.run}'" if summary.run is not None else "")
    out.print(Text(f"{summary.name}: {rows}", style="bold"))
    if len(summary.runs) > 1:
        out.print(Text("runs: " + ", ".join(f"{name} ({count})" for name, count in summary.runs.items())))
    if summary.sampling is not None:
        s = summary.sampling
        rate = f", {1 / s.median:.4g} Hz" if s.median > 0 else ""
        out.print(
            Text(
                f"time: column '{s.column}', {' to '.join(_from_to(s.first, s.last))} s, step {s.median:.4g} s{rate}, "
                f"jitter {100 * s.jitter:.0f} %, {s.gaps} gaps, {s.repeated} repeated and {s.backward} backward stamps"
            )
        )
    out.print()
    print_columns(out, summary.columns)
    print_findings(summary.findings)
    out.print()
    if summary.command:
        out.print(Text(f"next: {summary.command}"), soft_wrap=True)
    else:
        out.print(Text("no pair of columns looks like input and output; name them: --input COLUMN --output COLUMN"))


def _interest(column: ColumnSummary) -> tuple[bool, bool, bool]:
    """Order of what is shown of very many columns: those with a role, with a unit, those that move."""
    return not column.role, not column.unit, column.constant or not column.loops


def print_columns(out: Console, columns: Sequence[ColumnSummary]) -> None:
    """Print one row a column, of very many only those that matter most."""
    shown = sorted(columns, key=_interest)[:MOST_COLUMNS] if len(columns) > MOST_COLUMNS else ()
    _print_table(out, shown or columns)
    if shown:
        out.print(Text(f"and {len(columns) - len(shown)} more columns; all of them: dehyst inspect LOG --json"))


def _print_table(out: Console, columns: Sequence[ColumnSummary]) -> None:
    """Print one row a column; only the last cell is folded, and the table grows beyond a narrow terminal instead."""
    heads = ("column", "unit", "from", "to", "loops", "missing", "looks like")
    rows = [_cells(column) for column in columns]
    widths = [max(cell_len(row[k]) for row in (heads, *rows)) for k in range(len(heads) - 1)]
    table = Table(box=None, pad_edge=False)
    for name, width in zip(heads, (*widths, None), strict=True):
        number = name in ("from", "to", "loops", "missing")
        table.add_column(name, justify="right" if number else "left", overflow="fold", min_width=width)
    for row in rows:
        table.add_row(*(Text(cell) for cell in row))
    needed = sum(widths) + 2 * len(widths) + REMARK
    out.print(table, width=max(out.width, needed), crop=False)


def _cells(column: ColumnSummary) -> tuple[str, ...]:
    reason = column.reason
    if reason == "constant" and not column.constant:  # too short to judge is not the same
        reason = "too few values"
    low, high = _from_to(column.minimum, column.maximum)
    return (
        visible(column.name),
        visible(column.unit),
        low,
        high,
        str(column.loops) if low else "",
        f"{100 * column.missing:.0f} %" if column.missing else "",
        f"{column.role}: {reason}" if column.role and reason else column.role or reason,
    )


def _from_to(low: float, high: float) -> tuple[str, str]:
    """A range with five digits, or as many as it takes to see it move; "" for an empty one.

    Examples
    --------
    >>> _from_to(-4.20114, 4.26612), _from_to(99999.0, 100001.0), _from_to(1.00001, 1.00002)
    (('-4.2011', '4.2661'), ('99999', '100001'), ('1.00001', '1.00002'))
    """
    if not (math.isfinite(low) and math.isfinite(high)):
        return "", ""
    digits, largest = 5, max(abs(low), abs(high))
    if high - low > 0.0:
        digits = max(digits, math.ceil(math.log10(largest / (high - low))) + 4)
    if 1.0 <= largest < 1e9:  # whole numbers in full
        digits = max(digits, math.floor(math.log10(largest)) + 1)
    digits = min(digits, 17)
    return f"{low:.{digits}g}", f"{high:.{digits}g}"
