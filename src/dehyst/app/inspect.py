"""dehyst inspect: what is in a log."""

from __future__ import annotations

import dataclasses
import json
import math
import sys
from pathlib import Path
from typing import Any

from rich.table import Table
from rich.text import Text

from dehyst.app.terminal import print_findings, terminal
from dehyst.io import LogSummary, inspect_log


def run_inspect(log: Path, run: str | None, as_json: bool) -> None:
    """Print columns, sampling, runs and the line to type next."""
    summary = inspect_log(log, run)
    if as_json:
        sys.stdout.write(json.dumps(_plain(dataclasses.asdict(summary)), indent=1, allow_nan=False) + "\n")
        return
    _print(summary)


def _plain(value: Any) -> Any:
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    return value


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
                f"time: column '{s.column}', {s.first:g} to {s.last:g} s, step {s.median:.4g} s{rate}, jitter "
                f"{100 * s.jitter:.0f} %, {s.gaps} gaps, {s.repeated} repeated and {s.backward} backward stamps"
            )
        )
    table = Table(box=None, pad_edge=False)
    for name in ("column", "unit", "from", "to", "loops", "missing", "looks like"):
        number = name in ("from", "to", "loops", "missing")
        # Names and units are there to be typed: folded if need be, never cut short.
        table.add_column(name, justify="right" if number else "left", overflow="fold", no_wrap=number)
    for column in summary.columns:
        role = f"{column.role}: {column.reason}" if column.role and column.reason else column.role or column.reason
        empty = not math.isfinite(column.minimum)
        table.add_row(
            Text(column.name),
            Text(column.unit),
            "" if empty else f"{column.minimum:.5g}",
            "" if empty else f"{column.maximum:.5g}",
            "" if empty else str(column.loops),
            f"{100 * column.missing:.0f} %" if column.missing else "",
            Text(role),
        )
    out.print()
    out.print(table)
    print_findings(summary.findings)
    out.print()
    if summary.command:
        out.print(Text(f"next: {summary.command}"), soft_wrap=True)
    else:
        out.print(Text("no pair of columns looks like input and output; name them: --input COLUMN --output COLUMN"))
