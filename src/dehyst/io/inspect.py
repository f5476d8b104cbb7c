"""Describes a log: its columns, likely input and output, and the next command.

Which column is which is a guess to be confirmed: it is shown with its reason, and never used silently unless names and
units leave no other choice.
"""

from __future__ import annotations

import math
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array
from dehyst.data.loops import gap_limit, turning_points
from dehyst.errors import DehystError, TimeError
from dehyst.findings import Finding
from dehyst.io.checks import is_constant
from dehyst.io.clocks import choose_clock, clock_names, newest_first, seconds, unit_finding, with_clock
from dehyst.io.columns import count_runs, select_run
from dehyst.io.formats import PathLike, read_table
from dehyst.io.frames import is_frame
from dehyst.io.pairs import Proposal, Role, propose
from dehyst.io.select import WHOLE, context, read_pair
from dehyst.io.table import Table, measured
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


def inspect_log(
    path: PathLike,
    run: str | None = None,
    *,
    time_unit: str | float | None = None,
    dt: float | None = None,
    sheet: str | int | None = None,
) -> LogSummary:
    """Look at a log without deciding anything.

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
    table = with_clock(read_table(path, sheet), time_unit, None, dt)
    runs = count_runs(table)
    chosen, mask = select_run(table, run if run is not None or not runs else next(iter(runs)))
    rows = {name: v[mask] if v.size == mask.size else v for name, v in table.columns.items()}
    values = {name: measured(v) for name, v in rows.items()}
    paired = {name: v for name, v in rows.items() if v.size == values[name].size}
    clocks = clock_names(table)
    turns = {name: max(0, turning_points(v).size - 2) for name, v in values.items()}
    proposal = propose(table, values, paired, turns, clocks)
    proposal, findings, readable = _readable(table, proposal, chosen)
    x, y = proposal.pairs[0][:2] if proposal.pairs else (None, None)
    roles = proposal.roles
    columns = tuple(_summarise(table, name, rows, values, turns, roles, mask) for name in table.order)
    return LogSummary(
        name=table.name,
        rows=int(mask.sum()),
        columns=columns,
        runs=runs,
        run=chosen,
        sampling=_sampling(table, x, rows, clocks),
        input=x,
        output=y,
        clear=proposal.clear,
        command=_command(path, x, y, chosen if len(runs or ()) > 1 else None, (time_unit, dt), sheet, findings)
        if readable
        else "",
        findings=findings,
        doubt=proposal.doubt,
    )


def _readable(table: Table, proposal: Proposal, run: str | None) -> tuple[Proposal, tuple[Finding, ...], bool]:
    """Return the proposal led by its best pair that can be read, what reading finds, and whether there is one."""
    tried = []
    for pair in proposal.pairs[:TRIED]:
        findings, readable = _findings(table, pair.input, pair.output, run)
        if readable:
            return proposal.led_by(pair), findings, True
        tried.append(findings)
    return (proposal, tried[0], False) if tried else (proposal, *_findings(table, None, None, run))


def _findings(table: Table, x: str | None, y: str | None, run: str | None) -> tuple[tuple[Finding, ...], bool]:
    """What reading the guessed pair would find, and whether it can be read; without a pair, of the clock."""
    found = list(table.findings)
    found += [Finding("not-readable", reason) for name, reason in table.refused.items() if name not in (x, y)]
    if x is None or y is None:
        clocks = clock_names(table)
        return (*found, *(f for name in clocks[:1] for f in unit_finding(table, name, seconds(table, name)[0]))), True
    try:
        read_pair(table, context(table, (x, y), found), None, run, WHOLE)
    except DehystError as fault:
        # Cures on the way to an error cure nothing.
        refused = Finding("not-readable", f"reading '{x}' and '{y}' would end in an error: {fault}")
        return (*table.findings, refused), False
    return tuple(found), True


def _summarise(
    table: Table,
    name: str,
    rows: dict[str, Array],
    values: dict[str, Array],
    turns: dict[str, int],
    roles: dict[str, Role],
    mask: npt.NDArray[np.bool_],
) -> ColumnSummary:
    role = roles.get(name, Role("", "text"))
    if name not in values:
        return ColumnSummary(
            name, "", int(mask.sum()), math.nan, math.nan, 0, 0.0, False, role.role, role.reason or "text"
        )
    v = values[name]
    empty = v.size == 0
    return ColumnSummary(
        name=name,
        unit=table.label(name)[1],
        samples=int(v.size),
        minimum=math.nan if empty else float(v.min()),
        maximum=math.nan if empty else float(v.max()),
        loops=0 if role.role in {"time", "run"} else (turns[name] + 1) // 2,
        missing=1.0 - v.size / max(1, rows[name].size),
        constant=not empty and is_constant(v),
        role=role.role,
        reason=role.reason,
    )


def _sampling(table: Table, signal: str | None, rows: dict[str, Array], clocks: list[str]) -> Sampling | None:
    clock = clocks[0] if clocks else None
    if signal is not None:
        with suppress(TimeError):  # two that contradict each other: show the first, identify will ask
            clock = choose_clock(table, signal, None)
    if clock is None:
        return None
    part = Table(table.name, {clock: rows[clock]}, table.units, table.rows, stamps=table.stamps)
    t = seconds(part, clock)[0]
    t = t[np.isfinite(t)]
    t = t[::-1] if newest_first(t) else t
    step = np.diff(t)
    forward = step[step > 0]
    if forward.size == 0:
        return None
    median = float(np.median(forward))
    low, high = np.percentile(forward, [5, 95])
    return Sampling(
        column=clock,
        first=float(t[0]),
        last=float(t[-1]),
        median=median,
        jitter=float(high - low) / (2 * median),
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
    single = any("--train-fraction 1" in finding.message for finding in findings)
    share = "1" if single else None
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
