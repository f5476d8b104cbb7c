"""dehyst loops: the numbers of every loop of a log, a row each, and a picture of where they are measured."""

from __future__ import annotations

import math
from collections.abc import Sequence

from rich.table import Column

from dehyst.app._logs import files_of, named_columns, read_logs, typed_clocks
from dehyst.app._targets import LOOPS, PAGE, refuse_clashes
from dehyst.app._terminal import (
    ask_progress,
    print_end,
    print_findings,
    print_json,
    table,
    terminal,
)
from dehyst.app.requests import LoopsRequest
from dehyst.data import Loops, MeasuredLoop, Recording, measure_loops
from dehyst.findings import Finding
from dehyst.shell import command, visible

# More rows than these are no table that anybody reads: the first and the last are shown, JSON has all. [rows]
MOST_ROWS = 24
SHORT = {"counter-clockwise": "ccw", "clockwise": "cw"}  # in a narrow column


def run_loops(request: LoopsRequest) -> None:
    """Read, measure, draw, print."""
    mark = LOOPS
    if request.out is not None and request.out.suffix.lower() == ".html":
        mark = PAGE
    refuse_clashes(files_of(request.logs), request.overwrite, out=(request.out, mark))
    request = named_columns("loops", request, request.json)
    with ask_progress("reading", request.json) as progress:
        records = [record for *_, record in read_logs(request, progress)]
    with ask_progress("measuring", request.json):
        measured = measure_loops(records, symmetric=request.symmetric)
    if request.out is not None:
        from dehyst.report import kit as report_kit

        report_kit.write_loops(measured, request.out)
    if request.json:
        print_json(measured.as_dict())
        return
    _print(measured, records, request)


def _print(measured: Loops, records: Sequence[Recording], request: LoopsRequest) -> None:
    """Print a row a loop, the numbers of the largest ones with their intervals, and what changes."""
    out = terminal()
    first = records[0]
    pair = f"{visible(measured.output_label)} over {visible(measured.input_label)}"
    out.print(f"{pair}: {measured.opening_words}", style="bold", soft_wrap=True)
    out.print()
    rows = _rows(measured, first)
    out.print(table(_columns(measured, rows), rows), crop=False)
    hidden = len(measured.loops) - MOST_ROWS
    if hidden > 0:
        out.print(f"{hidden} loops in the middle are not shown; --json has all")
    if measured.count > len(measured.loops):
        out.print(
            f"{len(measured.loops)} of {measured.count} loops were measured, spread over the log"
        )
    out.print()
    out.print(_title(measured), style="bold", soft_wrap=True)
    largest = []
    for label, number, where in measured.rows:
        largest.append((f"  {label}", number, where))
    numbers = table(("", ">", ""), largest)
    numbers.show_header = False
    out.print(numbers)
    out.print(f"intervals of 95 %: {measured.basis}")
    if measured.wing_words:
        out.print(measured.wing_words, soft_wrap=True)
    if measured.trends:
        out.print(_trend_words(measured), soft_wrap=True)
    if any(loop.completed for loop in measured.loops):
        out.print(
            "half of the loop was measured; the other half is the same turned about the centre, as --symmetric says",
            soft_wrap=True,
        )
    print_findings(findings_of(records))
    following = ""
    if request.out is None:
        logs = request.logs[:1]
        if request.input is None:
            logs = request.logs
        following = command(
            "loops",
            *logs,
            input=request.input,
            output=request.output,
            dt=request.dt,
            clocks=typed_clocks(request),
            symmetric=request.symmetric,
            out="loops.svg",
        )
    print_end(following, picture=request.out)


def findings_of(records: Sequence[Recording]) -> list[Finding]:
    """What reading found, each once; that a fit needs more loops is no news of those that were measured."""
    unique: dict[Finding, None] = {}
    for record in records:
        for finding in record.findings:
            if finding.code != "few-loops":
                unique[finding] = None
    return list(unique)


def _title(measured: Loops) -> str:
    """Which loops the numbers below are means of."""
    count = len(measured.largest)
    numbers = ", ".join(str(loop.number) for loop in measured.largest[:8])
    if count == 1:
        return f"the largest loop ({numbers})"
    if count > 8:
        numbers += ", ..."
    return f"mean of the {count} largest loops ({numbers})"


def _heads(measured: Loops) -> tuple[str, ...]:
    heads = ("loop", ">begin", ">from", ">to", ">width", ">opening", f">{measured.area_word}")
    return (*heads, ">coercivity", ">gap", *_turned(measured, ""))


def _columns(measured: Loops, rows: Sequence[tuple[str, ...]]) -> list[Column]:
    """Columns as wide as their widest cell: no number is cut, however narrow the terminal."""
    columns = []
    for k, head in enumerate(_heads(measured)):
        name = head.removeprefix(">")
        width = max(len(row[k]) for row in rows if k < len(row))
        column = Column(name, no_wrap=True, min_width=max(width, len(name)))
        if name != head:
            column.justify = "right"
        columns.append(column)
    return columns


def _turned(measured: Loops, name: str) -> tuple[str, ...]:
    """A cell of the column of directions, which is there where they differ."""
    if len({loop.orientation for loop in measured.loops}) == 1:
        return ()
    return (name,)


def _units(measured: Loops, record: Recording) -> tuple[str, ...]:
    clock = "sample"
    if record.time is not None:
        clock = "s"
    units = {name: visible(unit) for name, unit in measured.units.items()}
    driven, answer = units["input"], units["output"]
    cells = ("", clock, driven, driven, answer, "%", units["work"], driven, "%")
    return (*cells, *_turned(measured, ""))


def _rows(measured: Loops, record: Recording) -> list[tuple[str, ...]]:
    """Units, and a row a loop; of very many the first and the last."""
    hidden = len(measured.loops) - MOST_ROWS
    half = MOST_ROWS // 2
    rows = [_units(measured, record)]
    for k, loop in enumerate(measured.loops):
        if hidden > 0 and half <= k < half + hidden:
            continue
        if hidden > 0 and k == half + hidden:
            rows.append(("...",))
        rows.append(
            (*_row(loop), *_turned(measured, SHORT.get(loop.orientation, loop.orientation)))
        )
    return rows


def _row(loop: MeasuredLoop) -> tuple[str, ...]:
    gap = f"{loop.gap_percent:+.1f}"
    if not loop.closes:
        gap = f"open {gap}"
    return (
        str(loop.number),
        f"{loop.start:.5g}",
        f"{loop.input_low:.4g}",
        f"{loop.input_high:.4g}",
        _number(loop.width),
        f"{float(f'{loop.opening_percent:.2g}'):g}",
        _number(loop.area),
        _number(loop.coercivity),
        gap,
    )


def _number(value: float) -> str:
    if not math.isfinite(value):
        return "unknown"
    return f"{value:.4g}"


def _trend_words(measured: Loops) -> str:
    """What changes from cycle to cycle, and what does not."""
    parts = []
    for name, change in measured.trends.items():
        label = name
        if name == "area":
            label = measured.area_word
        seen = ""
        if not change.is_change:
            seen = ", no change that is certain"
        parts.append(
            f"{label} {change.value:+.2g} % ({change.low:+.2g} to {change.high:+.2g}{seen})"
        )
    return f"from one of these to the next: {'; '.join(parts)}"
