"""Turns logs into recordings: chooses columns, run and time window, cleans, and reports."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Literal

import numpy as np

from dehyst.arrays import Array, Rows
from dehyst.data import Recording
from dehyst.errors import ColumnError
from dehyst.findings import Finding
from dehyst.io._clean import Samples, drop_unmeasured, find_gaps
from dehyst.io._clocks import choose_clock, refuse_clock, two_columns, with_clock
from dehyst.io._columns import find_column, provenance, run_column
from dehyst.io._formats import PathLike, read_table
from dehyst.io._long import Selection, is_long, read_long
from dehyst.io._order import order_time
from dehyst.io._policy import POLICY
from dehyst.io._select import (
    context,
    cut_window,
    parse_window,
    prepare_recording,
    read_pair,
    require_samples,
    select_rows,
    selected_samples,
)
from dehyst.io._table import LogTable


@dataclass(frozen=True, eq=False)
class LogSignal:
    """One column of a log, cleaned.

    Attributes
    ----------
    values
        (T,), finite. [unit]
    time
        (T,), strictly increasing within a piece, or None. [s]
    name, unit
        For labels.
    breaks
        Indices before which the log has a gap that matters.
    findings
        What reading the log found and cured.
    provenance
        File, fingerprint, column, run, window, rows.
    """

    values: Array
    time: Array | None
    name: str
    unit: str
    breaks: tuple[int, ...] = ()
    findings: tuple[Finding, ...] = ()
    provenance: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class LogColumns:
    """Columns of one log, rows without a number in one of them left out.

    Attributes
    ----------
    values
        Role -> (T,). [units]
    names, units
        Role -> column name without its unit, and unit, "" where none is known.
    time
        (T,), increasing, or None. [s]
    name
        File.
    findings
        What reading it found and cured.
    provenance
        File, fingerprint, columns, run, window, rows.
    """

    values: Mapping[str, Array]
    names: Mapping[str, str]
    units: Mapping[str, str]
    time: Array | None
    name: str
    findings: tuple[Finding, ...] = ()
    provenance: Mapping[str, Any] = field(default_factory=dict)


def read_log(
    path: PathLike,
    input: str,
    output: str,
    *,
    time: str | None = None,
    run: str | None = None,
    start: float | None = None,
    stop: float | None = None,
    time_unit: str | float | None = None,
    dt: float | None = None,
    sheet: str | int | None = None,
    schedules: Mapping[str, str] | Sequence[str] = (),
    progress: Callable[[float], object] | None = None,
) -> Recording:
    """Read input and output of an actuator from a log file.

    A log above 64 MB is read in parts where its format allows that (text, NPZ, NPY, HDF5, MDF, Parquet, Feather, bags),
    and of more than 500 000 rows those stay that decide the model: memory is bounded for logs of any length.

    Parameters
    ----------
    path
        .csv .txt .tsv .dat (also .gz), .mat, .npz, .npy; with extras .bag .db3 .mcap, a rosbag2 folder, .mf4 .mdf,
        .parquet .feather .xlsx .ods .tdms, or a data frame of pandas, polars or Arrow.
    input, output
        Columns: the exact name, the name in any case, the name without its unit, or ``#3`` for the third column.
    time
        Time column; by default the one that looks like it.
    run
        Run to read, needed when the log holds several.
    start, stop
        Window ``start <= t < stop`` in the log's own time; date-times and epochs count from the first sample of the
        run. [s]
    time_unit
        Unit of the time column, for example ``"ms"``, or how many seconds one count is, where its name does not tell;
        by default seconds.
    dt
        Seconds from one row to the next, where the log has no time column.
    sheet
        Sheet of a workbook, by name or number from 1; by default the one with the most numbers.
    schedules
        Columns of further signals that change the loop, such as a temperature; or name -> column.
    progress
        Called again and again with the share of a long file that was read, 0 to 1.

    Returns
    -------
    recording : Recording
        Samples in the units of the log, with findings and provenance.

    Raises
    ------
    LogError
        If the file cannot be read; ColumnError, RunError and TimeError if it does not hold what was asked for.
    RecordingError
        If too few samples remain, or the output never moves.
    ExcitationError
        If the input never moves.
    MissingExtraError
        If the format needs a package that is not installed.
    UnitError
        If `time_unit` is no unit of time.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> log = pathlib.Path(tempfile.mkdtemp()) / "log.csv"
    >>> rows = [f"{k / 10},{k % 7},{2 * (k % 7)}" for k in range(30)]
    >>> _ = log.write_text("time_s,pressure_bar,angle_deg\\n" + "\\n".join(rows))
    >>> rec = read_log(log, input="pressure", output="angle", stop=2.0)
    >>> len(rec), rec.input_label, rec.output_unit
    (20, 'pressure [bar]', 'deg')
    """
    window = parse_window(start, stop)
    table: LogTable | None = None
    if sheet is None and is_long(path):
        table = read_long(
            path, Selection(input, output, time, run, window, time_unit, dt), progress
        )
    if table is None:
        table = with_clock(read_table(path, sheet), time_unit, time, dt)
    x_name, y_name = two_columns(table, input, output)
    about = context(table, (x_name, y_name))
    samples, chosen, clock = read_pair(table, about, time, run, window)
    (x_bare, x_unit), (y_bare, y_unit) = table.label(x_name), table.label(y_name)
    recording = Recording(
        input=samples.values[0],
        output=samples.values[1],
        time=samples.time,
        name=_of_run(table, chosen),
        input_name=x_bare,
        output_name=y_bare,
        input_unit=x_unit,
        output_unit=y_unit,
        breaks=samples.breaks,
        findings=tuple(about.findings),
        provenance=origin_of(
            table, {"input": x_name, "output": y_name, "time": clock}, chosen, start, stop, samples
        ),
    )
    columns = schedules
    if not isinstance(columns, Mapping):
        listed = [columns] if isinstance(columns, str) else list(columns)
        columns = {
            table.label(find_column(table, column, "schedule"))[0]: column for column in listed
        }
    values, units = {}, {}
    for name, column in columns.items():
        signal = read_signal(
            path,
            column,
            time=time,
            run=run,
            time_unit=time_unit,
            dt=dt,
            sheet=sheet,
            missing="drop",
        )
        values[name] = at_samples(name, signal, recording, len(recording))
        units[name] = signal.unit
    return replace(recording, schedules=values, schedule_units=units) if values else recording


def read_signal(
    path: PathLike,
    column: str,
    *,
    time: str | None = None,
    run: str | None = None,
    start: float | None = None,
    stop: float | None = None,
    time_unit: str | float | None = None,
    dt: float | None = None,
    sheet: str | int | None = None,
    missing: Literal["hold", "drop"] = "hold",
) -> LogSignal:
    """Read one column of a log, for simulation or as a reference to follow.

    Errors are those of `read_log`; a constant column is allowed.

    Parameters
    ----------
    path
        Log of any format that `read_log` reads.
    column
        Column, named as for `read_log`.
    time, run, start, stop, time_unit, dt, sheet
        As for `read_log`.
    missing
        Rows without a number: ``"hold"`` the last value, because a signal is played back sample by sample and must
        not become shorter, or ``"drop"`` them.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> log = pathlib.Path(tempfile.mkdtemp()) / "reference.csv"
    >>> _ = log.write_text("time_s,angle_deg\\n0,1\\n0.1,2\\n0.2,3\\n0.3,2\\n")
    >>> read_signal(log, "angle").values.tolist()
    [1.0, 2.0, 3.0, 2.0]
    """
    table = with_clock(read_table(path, sheet), time_unit, time, dt)
    window = parse_window(start, stop)
    name = find_column(table, column, "signal")
    refuse_clock(table, name, "signal")
    about = context(table, (name,))
    clock = choose_clock(table, name, time)
    chosen, mask = select_rows(table, name, run)
    samples = prepare_recording(
        selected_samples(table, (name,), clock, mask, about), about, window, hold=missing == "hold"
    )
    samples = find_gaps(samples, about)
    require_samples(samples, about, window, least=1)
    if samples.time is None:
        about.say(
            "no-time",
            f"{table.name} has no time column; samples are taken as evenly spaced. If they are, --dt 0.01 says "
            f"how many seconds lie between them.",
        )
    origin = origin_of(table, {"column": name, "time": clock}, chosen, start, stop, samples)
    bare, unit = table.label(name)
    return LogSignal(
        samples.values[0], samples.time, bare, unit, samples.breaks, tuple(about.findings), origin
    )


def at_samples(name: str, signal: LogSignal, record: Recording | LogSignal, size: int) -> Array:
    """Return the values of a scheduling signal at the samples of a recording or of another signal, (size,).

    Raises
    ------
    ColumnError
        If it does not cover them, or there is no clock and the numbers of samples differ.
    """
    values = signal.values
    if record.time is None or signal.time is None:
        # Without a clock the only thing that says which samples belong together is their number.
        if values.size != size:
            raise ColumnError(
                f"schedule {name} '{signal.name}' has {values.size} samples and the recording {size}, and without time "
                f"stamps they cannot be brought together. Name the time column (--time).",
                column=signal.name,
            )
        return values
    first, last = float(record.time[0]), float(record.time[-1])
    missing = max(0.0, float(signal.time[0]) - first) + max(0.0, last - float(signal.time[-1]))
    if missing > POLICY.uncovered * (last - first):
        raise ColumnError(
            f"schedule {name} '{signal.name}' has values from {signal.time[0]:.6g} s to {signal.time[-1]:.6g} s, but "
            f"the recording lasts from {first:.6g} s to {last:.6g} s. Cut it with --from and --to, or name a column "
            f"that covers it.",
            column=signal.name,
        )
    return np.interp(record.time, signal.time, values)


def read_columns(
    path: PathLike,
    columns: Mapping[str, str],
    *,
    time: str | None = None,
    run: str | None = None,
    start: float | None = None,
    stop: float | None = None,
    time_unit: str | float | None = None,
    dt: float | None = None,
    sheet: str | int | None = None,
) -> LogColumns:
    """Read columns of a log that belong together row by row.

    Nothing is taken for an outlier: neighbouring rows of a table may be points that have nothing to do with each other.

    `columns`: role, for messages, -> column, named as for `dehyst.read_log`.

    Raises
    ------
    LogError
        If the file cannot be read; ColumnError, RunError and TimeError if it does not hold what was asked for.
    RecordingError
        If no row has a number in every column.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> log = pathlib.Path(tempfile.mkdtemp()) / "bench.csv"
    >>> _ = log.write_text("length_mm,pressure_bar,force_N\\n300,1,150\\n290,1,\\n280,2,160\\n")
    >>> found = read_columns(log, {"length": "length", "force": "force"})
    >>> found.values["length"].tolist(), found.units["force"], found.findings[0].code
    ([300.0, 280.0], 'N', 'non-finite')
    """
    table = with_clock(read_table(path, sheet), time_unit, time, dt)
    window = parse_window(start, stop)
    names: dict[str, str] = {}
    for role, typed_name in columns.items():
        names[role] = find_column(table, typed_name, role)
    _refuse_columns(table, names)
    chosen = tuple(names.values())
    about = context(table, chosen)
    clock = choose_clock(table, chosen[0], time)
    which, mask = select_rows(table, chosen[0], run)
    samples = cut_window(selected_samples(table, chosen, clock, mask, about), about, window)
    samples = order_time(drop_unmeasured(samples, about), about)
    labels: dict[str, str] = {}
    units: dict[str, str] = {}
    for role, name in names.items():
        labels[role], units[role] = table.label(name)
    return LogColumns(
        dict(zip(names, samples.values, strict=True)),
        labels,
        units,
        samples.time,
        _of_run(table, which),
        tuple(about.findings),
        origin_of(table, {**names, "time": clock}, which, start, stop, samples),
    )


def _refuse_columns(table: LogTable, names: Mapping[str, str]) -> None:
    """Refuse one column for two roles, the time column, and columns of different lengths."""
    role_of: dict[str, str] = {}
    for role, name in names.items():
        if name in role_of:
            raise ColumnError(
                f"{role_of[name]} and {role} are both column '{name}' of {table.name}. Name two columns.",
                column=name,
            )
        role_of[name] = role
    for role, name in names.items():
        refuse_clock(table, name, role)
    sizes = {name: table.columns[name].size for name in role_of}
    if len(set(sizes.values())) > 1:
        listed = ", ".join(f"{name} {size}" for name, size in sizes.items())
        raise ColumnError(
            f"columns of {table.name} differ in length ({listed}): they were logged on clocks of their own. Write them "
            f"into one table first, a row for each instant.",
            sizes=sizes,
        )


def _of_run(table: LogTable, run: str | None) -> str:
    if run is None:
        return table.name
    return f"{table.name}, run {run}"


def origin_of(
    table: LogTable,
    columns: dict[str, str | None],
    run: str | None,
    start: float | None,
    stop: float | None,
    samples: Samples,
) -> dict[str, Any]:
    """Where samples came from, as `provenance` says, with the samples of a longer log and columns that stand still."""
    rows = samples.rows
    window = [start, stop]
    for k, bound in enumerate(window):
        if bound is not None and not math.isfinite(bound):
            window[k] = None  # JSON has no inf
    origin = provenance(
        table, columns, run, window, (int(rows.size), int(rows.min()), int(rows.max()))
    )
    if table.samples > rows.size:
        origin["samples"] = table.samples
    stills = _stills(table, rows, set(columns.values()))
    if stills:
        origin["stills"] = stills
    return origin


# Columns of one value that are kept: a log of a thousand channels has too many to look at.
MOST_STILLS = 20


def _stills(table: LogTable, rows: Rows, used: set[str | None]) -> dict[str, float]:
    """Columns that stand still within a recording, which may be another condition in the next."""
    stills: dict[str, float] = {}
    runs = run_column(table)  # tells runs apart, and is no condition
    within = (table.rows >= rows.min()) & (table.rows <= rows.max())
    for name, values in table.columns.items():
        if (
            name in used
            or name == runs
            or values.size != table.rows.size
            or len(stills) == MOST_STILLS
        ):
            continue
        part = values[within]
        if part.size and math.isfinite(float(part[0])) and bool((part == part[0]).all()):
            stills[name] = float(part[0])
    return stills
