"""Describes a log: its columns, likely input and output, and the next command.

Which column is which is a guess to be confirmed: it is shown with its reason, and never used silently unless names and
units leave no other choice.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import suppress
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array
from dehyst.data import Loops, Recording, gap_limit, loops_of, turning_points
from dehyst.errors import DehystError, TimeError
from dehyst.findings import Finding
from dehyst.io._checks import is_constant
from dehyst.io._clocks import (
    choose_clock,
    clock_names,
    newest_first,
    seconds,
    unit_finding,
    with_clock,
)
from dehyst.io._columns import count_runs, select_run
from dehyst.io._formats import PathLike, read_table
from dehyst.io._frames import is_frame
from dehyst.io._long import is_long, look_at_long
from dehyst.io._pairs import Proposal, Role, propose
from dehyst.io._select import WHOLE, context, read_pair
from dehyst.io._table import LogTable, measured
from dehyst.shell import command

TRIED = 4  # pairs: the best that can be read is proposed


@dataclass(frozen=True, slots=True)
class ColumnSummary:
    """One column of a log.

    Attributes
    ----------
    name, unit
        As in the file.
    samples
        Rows of the run that hold a number.
    minimum, maximum
        Range, NaN if the column is empty. [unit]
    loops
        Complete back-and-forth cycles.
    missing
        Share of the rows without a number, 0 to 1.
    constant
        Whether it never moves.
    role
        ``"input"``, ``"output"``, ``"time"``, ``"run"`` or "".
    reason
        Why it looks like that.
    """

    name: str
    unit: str
    samples: int
    minimum: float
    maximum: float
    loops: int
    missing: float
    constant: bool
    role: str
    reason: str


@dataclass(frozen=True, slots=True)
class Sampling:
    """How the time column steps.

    Attributes
    ----------
    column
        Time column.
    first, last
        Range. [s]
    median
        Median step. [s]
    jitter
        Half the spread between the 5th and 95th percentile of the steps over the median, 0 for an even clock.
    gaps, repeated, backward
        Number of gaps, of repeated and of backward stamps.
    """

    column: str
    first: float
    last: float
    median: float
    jitter: float
    gaps: int
    repeated: int
    backward: int


@dataclass(frozen=True, slots=True)
class LogSummary:
    """What `inspect_log` found.

    Attributes
    ----------
    name
        File name.
    rows
        Rows of the run.
    columns
        One entry a column, text columns too, in the order of the file.
    runs
        Run -> rows, empty if the log does not tell runs apart.
    run
        The run these numbers are about: the one asked for, else the first.
    sampling
        None without a time column.
    input, output
        Best guess, or None.
    clear
        Whether names and units of the columns leave no other choice.
    command
        Line to type next, "" if no pair was found, or it cannot be read.
    findings
        What reading found, and what reading this input and output would find and cure.
    doubt
        Which other pairs are as likely, in a sentence; "" for none.
    numbers
        Width, area, coercivity and others of the largest loops of that input and output, as `dehyst.data.measure_loops`
        measures them; None if no loop is closed.
    """

    name: str
    rows: int
    columns: tuple[ColumnSummary, ...]
    runs: dict[str, int]
    run: str | None
    sampling: Sampling | None
    input: str | None
    output: str | None
    clear: bool
    command: str
    findings: tuple[Finding, ...]
    doubt: str = ""
    numbers: Loops | None = None

    def as_dict(self) -> dict[str, Any]:
        """Return everything as plain values, the content of ``dehyst inspect --json``."""
        numbers = self.numbers and self.numbers.summary
        return asdict(replace(self, numbers=None)) | {"numbers": numbers}


def inspect_log(
    path: PathLike,
    run: str | None = None,
    *,
    time_unit: str | float | None = None,
    dt: float | None = None,
    sheet: str | int | None = None,
    progress: Callable[[float], object] | None = None,
) -> LogSummary:
    """Look at a log without deciding anything.

    Of a log above 64 MB one in so many rows is looked at, where its format allows that; counts are those of all rows.

    Parameters
    ----------
    path
        Log of any format that `read_log` reads.
    run
        Run to look at; by default the first.
    time_unit
        Unit of the time column, for example ``"ms"``, or how many seconds one count is, where its name does not tell;
        by default seconds.
    dt
        Seconds from one row to the next, where the log has no time column.
    sheet
        Sheet of a workbook, by name or number from 1; by default the one with the most numbers.
    progress
        Called again and again with the share of a long file that was read, 0 to 1.

    Raises
    ------
    LogError
        If the file cannot be read.
    RunError
        If it has no such run.
    UnitError
        If `time_unit` is no unit of time.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> log = pathlib.Path(tempfile.mkdtemp()) / "log.csv"
    >>> rows = [f"{k / 10},{abs(k % 14 - 7)},{2 * abs(k % 14 - 7)}" for k in range(60)]
    >>> _ = log.write_text("time_s,pressure_bar,angle_deg\\n" + "\\n".join(rows))
    >>> summary = inspect_log(log)
    >>> summary.input, summary.output, summary.columns[1].loops
    ('pressure_bar', 'angle_deg', 4)
    """
    table = look_at_long(path, progress) if sheet is None and is_long(path) else None
    table = with_clock(table or read_table(path, sheet), time_unit, None, dt)
    stands_for = table.samples / table.rows.size if table.samples else 1.0
    runs = count_runs(table)
    chosen, mask = select_run(table, run if run is not None or not runs else next(iter(runs)))
    rows: dict[str, Array] = {}
    values: dict[str, Array] = {}
    paired: dict[str, Array] = {}
    turns: dict[str, int] = {}
    for name, column in table.columns.items():
        rows[name] = column
        if column.size == mask.size:
            rows[name] = column[mask]
        values[name] = measured(rows[name])
        if values[name].size == rows[name].size:
            paired[name] = rows[name]
        turns[name] = max(0, turning_points(values[name]).size - 2)
    clocks = clock_names(table)
    proposal = propose(table, values, paired, turns, clocks)
    proposal, readable = _readable(table, proposal, chosen)
    findings = readable.findings
    x = y = None
    if proposal.pairs:
        x, y = proposal.pairs[0][:2]
    next_command = ""
    numbers = None
    if readable.record is not None:
        numbers = loops_of([readable.record], largest_only=True)
    if readable.can_be_read:
        run_named = chosen if len(runs) > 1 else None
        next_command = _command(path, x, y, run_named, (time_unit, dt), sheet, findings)
    roles = proposal.roles
    columns = tuple(
        _summarise(table, name, rows, values, turns, roles, mask, stands_for)
        for name in table.order
    )
    return LogSummary(
        name=table.name,
        rows=round(stands_for * mask.sum()),
        columns=columns,
        runs={name: round(stands_for * count) for name, count in runs.items()},
        run=chosen,
        sampling=_sampling(table, x, rows, clocks),
        input=x,
        output=y,
        clear=proposal.clear,
        command=next_command,
        findings=findings,
        doubt=proposal.doubt,
        numbers=numbers,
    )


class _ReadablePair(NamedTuple):
    """What reading a pair of columns finds, whether it can be read, and what is read."""

    findings: tuple[Finding, ...]
    can_be_read: bool
    record: Recording | None = None


def _readable(
    table: LogTable, proposal: Proposal, run: str | None
) -> tuple[Proposal, _ReadablePair]:
    """Return the proposal led by its best pair that can be read, and what reading it finds."""
    tried = []
    for pair in proposal.pairs[:TRIED]:
        reading = _read(table, pair.input, pair.output, run)
        if reading.can_be_read:
            return proposal.led_by(pair), reading
        tried.append(reading)
    if not tried:
        return proposal, _read(table, None, None, run)
    return proposal, tried[0]


def _read(table: LogTable, x: str | None, y: str | None, run: str | None) -> _ReadablePair:
    """Read the guessed pair; without a pair, judge the clock."""
    findings = list(table.findings)
    for name, reason in table.refused.items():
        if name not in (x, y):
            findings.append(Finding("not-readable", reason))
    if x is None or y is None:
        for name in clock_names(table)[:1]:
            findings += unit_finding(table, name, seconds(table, name)[0])
        return _ReadablePair(tuple(findings), True)
    try:
        samples, _, _ = read_pair(table, context(table, (x, y), findings), None, run, WHOLE)
        record = Recording(
            samples.values[0],
            samples.values[1],
            samples.time,
            input_unit=table.label(x)[1],
            output_unit=table.label(y)[1],
            breaks=samples.breaks,
        )
    except DehystError as fault:
        # Cures on the way to an error cure nothing.
        refused = Finding("not-readable", f"reading '{x}' and '{y}' would end in an error: {fault}")
        return _ReadablePair((*table.findings, refused), False)
    return _ReadablePair(tuple(findings), True, record)


def _summarise(
    table: LogTable,
    name: str,
    rows: dict[str, Array],
    values: dict[str, Array],
    turns: dict[str, int],
    roles: dict[str, Role],
    mask: npt.NDArray[np.bool_],
    stands_for: float,
) -> ColumnSummary:
    role = roles.get(name, Role("", "text"))
    if name not in values:
        return ColumnSummary(
            name,
            "",
            round(stands_for * mask.sum()),
            math.nan,
            math.nan,
            0,
            0.0,
            False,
            role.role,
            role.reason or "text",
        )
    v = values[name]
    empty = v.size == 0
    return ColumnSummary(
        name=name,
        unit=table.label(name)[1],
        samples=round(stands_for * v.size),
        minimum=math.nan if empty else float(v.min()),
        maximum=math.nan if empty else float(v.max()),
        loops=0 if role.role in {"time", "run"} else (turns[name] + 1) // 2,
        missing=1.0 - v.size / max(1, rows[name].size),
        constant=not empty and is_constant(v),
        role=role.role,
        reason=role.reason,
    )


def _sampling(
    table: LogTable, signal: str | None, rows: dict[str, Array], clocks: list[str]
) -> Sampling | None:
    clock = next(iter(clocks), None)
    if signal is not None:
        # Of two that contradict each other the first is shown: identify will ask.
        with suppress(TimeError):
            clock = choose_clock(table, signal, None)
    if clock is None:
        return None
    part = LogTable(table.name, {clock: rows[clock]}, table.units, table.rows, stamps=table.stamps)
    t = seconds(part, clock)[0]
    t = t[np.isfinite(t)]
    if newest_first(t):
        t = t[::-1]
    step = np.diff(t)
    forward = step[step > 0]
    if forward.size == 0:
        return None
    median = float(np.median(forward)) / table.every
    low, high = np.percentile(forward, [5, 95])
    return Sampling(
        column=clock,
        first=float(t[0]),
        last=float(t[-1]),
        median=median,
        jitter=float(high - low) / (2 * median * table.every),
        gaps=int(np.sum(step > gap_limit(step))),
        repeated=int(np.sum(step == 0)),
        backward=int(np.sum(step < 0)),
    )


def _command(
    path: PathLike,
    x: str | None,
    y: str | None,
    run: str | None,
    clock: tuple[str | float | None, float | None],
    sheet: str | int | None,
    findings: tuple[Finding, ...],
) -> str:
    if x is None or y is None:
        return ""
    if is_frame(path):
        return f"dehyst.identify(dehyst.Recording.from_frame(df, input={x!r}, output={y!r}))"
    share = None
    if "--train-fraction 1" in "".join(finding.message for finding in findings):
        share = "1"
    return command(
        "identify",
        Path(path),
        input=x,
        output=y,
        run=run,
        time_unit=clock[0],
        dt=clock[1],
        sheet=sheet,
        train_fraction=share,
    )
