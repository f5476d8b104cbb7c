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
from dehyst.io.checks import BETWEEN_WORDS, COMMAND_WORDS, hold_length, is_constant
from dehyst.io.clocks import choose_clock, clock_names, newest_first, seconds, unit_finding, with_time_unit
from dehyst.io.columns import count_runs, run_column, select_run
from dehyst.io.formats import PathLike, read_table
from dehyst.io.frames import is_frame
from dehyst.io.select import WHOLE, context, read_pair
from dehyst.io.table import Table, measured
from dehyst.shell import command
from dehyst.units import dimension, words

# How well a dimension drives and follows: pressure drives, angle follows, length does both.
INPUT_POINTS = {"pressure": 6.0, "voltage": 6.0, "current": 5.0, "length": 2.0, "angle": 1.5, "force": 0.5}
OUTPUT_POINTS = {"angle": 5.0, "length": 4.0, "force": 4.0, "torque": 4.0, "pressure": 0.5}
CLEAR = 1.0  # points by which a pair leads all others if names and units leave no choice
CANDIDATES = 20  # pairs grow with the square, and a bag may hold thousands of columns
INPUT_WORDS = frozenset(words("input u x pressure voltage current drive valve command"))
OUTPUT_WORDS = frozenset(words("output y angle displacement position force tilt contraction strain length measured"))


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


def inspect_log(path: PathLike, run: str | None = None, *, time_unit: str | float | None = None) -> LogSummary:
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
    table = with_time_unit(read_table(path), time_unit, None)
    runs = count_runs(table)
    chosen, mask = select_run(table, run if run is not None or not runs else next(iter(runs)))
    rows = {name: v[mask] if v.size == mask.size else v for name, v in table.columns.items()}
    values = {name: measured(v) for name, v in rows.items()}
    paired = {name: v for name, v in rows.items() if v.size == values[name].size}
    clocks = clock_names(table)
    turns = {name: max(0, turning_points(v).size - 2) for name, v in values.items()}
    roles, x, y, clear = guess_roles(table, values, paired, turns, clocks)
    columns = tuple(_summarise(table, name, rows, values, turns, roles, mask) for name in table.order)
    findings, readable = _findings(table, x, y, chosen)
    return LogSummary(
        name=table.name,
        rows=int(mask.sum()),
        columns=columns,
        runs=runs,
        run=chosen,
        sampling=_sampling(table, x, rows, clocks),
        input=x,
        output=y,
        clear=clear,
        command=_command(path, x, y, chosen if len(runs or ()) > 1 else None, time_unit, findings) if readable else "",
        findings=findings,
    )


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
    time_unit: str | float | None,
    findings: tuple[Finding, ...],
) -> str:
    if x is None or y is None:
        return ""
    if is_frame(path):
        return f"dehyst.identify(dehyst.Recording.from_frame(df, input={x!r}, output={y!r}))"
    single = any("--train-fraction 1" in finding.message for finding in findings)
    share = "1" if single else None
    return command("identify", Path(path), input=x, output=y, run=run, time_unit=time_unit, train_fraction=share)


@dataclass(frozen=True, slots=True)
class Role:
    """What a column looks like, and why: "time", "run", "input", "output" or ""."""

    role: str
    reason: str


def _points(table: Table, name: str, values: Array, turns: int) -> tuple[float, float, str]:
    """Points as input and as output, and what they rest on."""
    bare, unit = table.label(name)
    kind = dimension(unit)
    spoken = set(words(bare))
    into = INPUT_POINTS.get(kind, 0.0) + bool(spoken & INPUT_WORDS)
    out = OUTPUT_POINTS.get(kind, 0.0) + bool(spoken & OUTPUT_WORDS)
    reasons = [f"{kind} [{unit}]"] if kind else []
    if spoken & COMMAND_WORDS:
        # A command of the output's own kind is the input; beside a measured pressure it is second choice.
        into += 3.0 if kind not in {"pressure", "voltage", "current"} else -0.5
        out -= 4.0
        reasons.append("named like a command")
    if spoken & {"velocity", "speed", "rate", "acceleration", "aux"}:
        into, out = into - 3.0, out - 3.0
        reasons.append("a rate or auxiliary signal")
    if spoken & BETWEEN_WORDS:
        into += 0.5
        reasons.append("interpolated between updates")
    hold = hold_length(values)
    if hold > 1.0:
        into, out = into - 1.0, out - 1.0
        reasons.append(f"held for {hold:.0f} samples at a time")
    if turns < 1:
        into -= 2.0
        reasons.append("never turns")
    return into, out, ", ".join(reasons)


def _relation(x: Array, y: Array) -> float:
    """Strength of the linear relation of two signals, 0 to 1."""
    size = min(x.size, y.size)
    if size < 3 or x.size != y.size or is_constant(x) or is_constant(y):
        return 0.0
    a, b = x - x.mean(), y - y.mean()
    scale = float(np.linalg.norm(a) * np.linalg.norm(b))
    return abs(float(np.dot(a, b))) / scale if scale > 0 else 0.0


def guess_roles(
    table: Table, values: dict[str, Array], paired: dict[str, Array], turns: dict[str, int], clocks: list[str]
) -> tuple[dict[str, Role], str | None, str | None, bool]:
    """Role of every column, the best pair of input and output, and whether names and units leave no other choice.

    `values` are the finite samples of each column in the run, `paired` the same columns row by row, `turns` how often
    they turn, `clocks` the columns that look like time.
    """
    roles = {name: Role("time", "named or stepping like time") for name in clocks}
    runs = run_column(table)
    if runs is not None:
        roles[runs] = Role("run", "tells recordings apart")
    free = [n for n, v in values.items() if n not in roles and v.size >= 4 and not is_constant(v)]
    points = {name: _points(table, name, values[name], turns[name]) for name in free}
    best: tuple[float, str | None, str | None] = (0.0, None, None)
    drivers = sorted(free, key=lambda n: -points[n][0])[:CANDIDATES]
    followers = sorted(free, key=lambda n: -points[n][1])[:CANDIDATES]
    place = {name: k for k, name in enumerate(table.order)}
    for x in drivers:
        for y in followers:
            if x == y:
                continue
            score = points[x][0] + points[y][1]
            if score > 0:
                score += 1.5 * _relation(paired.get(x, values[x]), paired.get(y, values[y]))
            # Unknown names: earlier columns tend to be the cause.
            score += 0.01 * (place[y] > place[x])
            if score > best[0]:
                best = (score, x, y)
    for name, role in ((best[1], "input"), (best[2], "output")):
        if name is not None:
            roles[name] = Role(role, points[name][2] or "the best match by its order and its movement")
    for name in free:
        roles.setdefault(name, Role("", points[name][2]))
    for name in values:
        roles.setdefault(name, Role("", "constant" if values[name].size else "empty"))
    return roles, best[1], best[2], _leads(points, best[1], best[2])


def _leads(points: dict[str, tuple[float, float, str]], x: str | None, y: str | None) -> bool:
    """Whether a pair leads every other one by `CLEAR`, movement and order left out: these decide too little."""
    if x is None or y is None:
        return False
    drivers = sorted(points, key=lambda name: -points[name][0])[:3]
    followers = sorted(points, key=lambda name: -points[name][1])[:3]
    others = [points[a][0] + points[b][1] for a in drivers for b in followers if a != b and (a, b) != (x, y)]
    return points[x][0] + points[y][1] >= CLEAR + max(others, default=-np.inf)
