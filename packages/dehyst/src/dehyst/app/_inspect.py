"""dehyst inspect and dehyst example: shows what a log contains; writes an example log."""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from typing import Any

from rich.cells import cell_len
from rich.console import Console
from rich.table import Column

from dehyst.app._targets import write_new
from dehyst.app._terminal import (
    ask_progress,
    print_end,
    print_findings,
    print_json,
    table,
    terminal,
)
from dehyst.app.requests import ExampleRequest, InspectRequest
from dehyst.data import Loops, loops_of
from dehyst.errors import ParameterError
from dehyst.io import (
    ColumnSummary,
    LogSummary,
    Sampling,
    example_csv,
    inspect_log,
    read_two_files,
)
from dehyst.io import kit as io_kit
from dehyst.shell import command, visible

# Letters left for the last column of the table at least.
REMARK = 24
# More columns than this are a recording of everything: those that may be wanted come first, the others are counted.
MOST_COLUMNS = 60
HEADS = ("column", "unit", "from", "to", "loops", "missing", "looks like")
NUMBERS = HEADS[2:6]


def run_inspect(request: InspectRequest) -> None:
    """Print columns, sampling, runs and the line to type next."""
    if request.second is not None or io_kit.two_places([request.log]) is not None:
        _inspect_two(request)
        return
    if request.clocks != "auto":
        raise ParameterError(
            f"--clocks {request.clocks} is about input and output in two files. Leave it out, or name both: "
            f"dehyst inspect u.csv:COLUMN y.csv:COLUMN"
        )
    with ask_progress("reading", request.json) as progress:
        summary = inspect_log(
            request.log,
            request.run,
            time_unit=request.time_unit,
            sheet=request.sheet,
            dt=request.dt,
            progress=progress,
        )
    if request.json:
        print_json(summary.as_dict())
        return
    out = terminal()
    _print_columns_of(out, summary)
    if summary.numbers is not None:
        pair = f"{visible(summary.output or '')} over {visible(summary.input or '')}"
        _print_loops(out, pair, summary.numbers)
    print_findings(summary.findings)
    if summary.doubt:
        out.print(f"\nnot sure: {summary.doubt}", soft_wrap=True)
    print_end(summary.command or "")
    if not summary.command and summary.input and summary.output:
        out.print(
            "next: name two columns that can be read together: --input COLUMN --output COLUMN"
        )
    elif not summary.command:
        out.print(
            "no pair of columns looks like input and output; name them: --input COLUMN --output COLUMN"
        )


def _inspect_two(request: InspectRequest) -> None:
    """Print the columns of two files, and what reading input and output from them finds."""
    logs = [log for log in (request.log, request.second) if log is not None]
    places = io_kit.two_places(logs)
    if places is None:
        raise ParameterError(
            f"inspect shows one log, and here are {len(logs)}. To read input and output from two files, name a "
            f"column of each: {command('inspect', *(f'{log}:COLUMN' for log in logs))}"
        )
    part: dict[str, Any] = {"dt": request.dt, "sheet": request.sheet}
    with ask_progress("reading", request.json):
        summaries = [inspect_log(place.path, request.run, **part) for place in places]
        record = read_two_files(
            *places, clocks=request.clocks, run=request.run, time_unit=request.time_unit, **part
        )
        numbers = loops_of([record], largest_only=True)
    following = command(
        "identify", *logs, run=request.run, time_unit=request.time_unit, dt=request.dt,
        sheet=request.sheet, clocks=None if request.clocks == "auto" else request.clocks,
    )  # fmt: skip
    if request.json:
        print_json(
            {
                "files": [summary.as_dict() for summary in summaries],
                "samples": len(record),
                "clocks": record.provenance.get("clocks"),
                "numbers": numbers and numbers.summary,
                "findings": [entry.as_dict() for entry in record.findings],
                "command": following,
            }
        )
        return
    out = terminal()
    for summary in summaries:
        _print_columns_of(out, summary)
        out.print()
    out.print(f"{record.name}: {len(record)} samples of both", style="bold")
    if numbers is not None:
        _print_loops(
            out, f"{visible(record.output_label)} over {visible(record.input_label)}", numbers
        )
    print_findings(record.findings)
    print_end(following)


def _print_loops(out: Console, pair: str, numbers: Loops) -> None:
    """The main numbers of the largest loops."""
    out.print(f"\nlargest loops, {pair}: {numbers.opening_words}\n{numbers.words}", soft_wrap=True)


def _print_columns_of(out: Console, summary: LogSummary) -> None:
    """Rows, runs, clock and columns of a file."""
    title = f"{summary.name}: {summary.rows} rows"
    if summary.run is not None:
        title += f" of run '{summary.run}'"
    out.print(title, style="bold")
    if len(summary.runs) > 1:
        out.print("runs: " + ", ".join(f"{name} ({count})" for name, count in summary.runs.items()))
    if summary.sampling is not None:
        out.print(_sampling_line(summary.sampling))
    out.print()
    print_columns(out, summary.columns)


def _sampling_line(s: Sampling) -> str:
    """What is known of the clock of a log."""
    rate = ""
    # A log whose stamps are all equal has no rate.
    if s.median > 0:
        rate = f", {1 / s.median:.4g} Hz"
    gaps = f"{s.gaps} gaps"
    if s.gaps == 1:
        gaps = "1 gap"
    return (
        f"time: column '{s.column}', {' to '.join(_from_to(s.first, s.last))} s, step {s.median:.4g} s{rate}, "
        f"jitter {100 * s.jitter:.0f} %, {gaps}, {s.repeated} repeated and {s.backward} backward stamps"
    )


def run_example(request: ExampleRequest) -> None:
    """Write the example log and say what to type next."""
    text = example_csv(request.seed)
    write_new(request.out, request.overwrite, text)
    line = command(
        "identify", request.out, input="pressure_difference_bar", output="angle_deg", save="model.json",
        report="report.html",
    )  # fmt: skip
    sys.stdout.write(
        f"wrote {request.out}: a simulated joint, pressure difference [bar] -> angle [deg], 12 loops\nnext: {line}\n"
    )


def _interest(column: ColumnSummary) -> tuple[bool, bool, bool]:
    """Order of what is shown of very many columns: those with a role, with a unit, those that move."""
    return not column.role, not column.unit, column.constant or not column.loops


def show_columns(summary: LogSummary) -> tuple[str, ...]:
    """Print the columns on the error stream, since the result on the other one would be no JSON any more; names."""
    print_columns(terminal(stderr=True), summary.columns)
    return tuple(column.name for column in summary.columns)


def print_columns(out: Console, columns: Sequence[ColumnSummary]) -> None:
    """Print one row a column, of very many only those that matter most.

    Only the last cell is folded, and the table grows beyond a narrow terminal instead.
    """
    shown = columns
    # A few columns stay in the order of the file, in which the user knows them.
    if len(columns) > MOST_COLUMNS:
        shown = sorted(columns, key=_interest)[:MOST_COLUMNS]
    rows = [_cells(column) for column in shown]
    heads = []
    widths = []
    for k, name in enumerate(HEADS[:-1]):
        # A minimum width keeps numbers and names whole: only the remark may be folded.
        width = max(cell_len(row[k]) for row in (HEADS, *rows))
        head = Column(name, overflow="fold", min_width=width)
        if name in NUMBERS:
            head.justify = "right"
        heads.append(head)
        widths.append(width)
    heads.append(Column(HEADS[-1], overflow="fold"))
    narrowest = sum(widths) + 2 * len(widths) + REMARK
    out.print(table(heads, rows), width=max(out.width, narrowest), crop=False)
    if len(shown) < len(columns):
        out.print(
            f"and {len(columns) - len(shown)} more columns; all of them: dehyst inspect LOG --json"
        )


def _cells(column: ColumnSummary) -> tuple[str, ...]:
    reason = column.reason
    # A column of a few values seems constant, and nobody can say whether it is.
    if reason == "constant" and not column.constant:
        reason = "too few values"
    low, high = _from_to(column.minimum, column.maximum)
    loops, missing = "", ""
    if low:
        loops = str(column.loops)
    if column.missing:
        missing = f"{100 * column.missing:.0f} %"
    remark = ": ".join(filter(None, (column.role, reason)))
    return visible(column.name), visible(column.unit), low, high, loops, missing, remark


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
