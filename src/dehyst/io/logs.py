"""Logs become recordings: choose columns, run and window, clean, say what was found."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

from dehyst.arrays import Array
from dehyst.data.recording import Recording
from dehyst.findings import Finding
from dehyst.io.checks import check_pair, check_signal
from dehyst.io.clean import Context, Samples, find_gaps
from dehyst.io.clocks import choose_clock, refuse_clock, two_columns, with_time_unit
from dehyst.io.columns import find_column, run_column
from dehyst.io.formats import PathLike, read_table
from dehyst.io.select import pair_samples, parse_window, prepare, require_samples, samples_of, select_rows
from dehyst.io.table import Table
from dehyst.units import parse_unit


@dataclass(frozen=True, eq=False)
class Signal:
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


def read_log(
    path: PathLike,
    input: str,
    output: str,
    *,
    time: str | None = None,
    run: str | None = None,
    start: float | None = None,
    stop: float | None = None,
    time_unit: str | None = None,
) -> Recording:
    """Read input and output of an actuator from a log file.

    Parameters
    ----------
    path
        .csv .txt .tsv .dat (also .gz), .mat, .npz, .npy; with extras .bag .db3 .mcap, a rosbag2 folder, .mf4 .mdf,
        .parquet .feather.
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
        Unit of the time column, for example ``"ms"``, where its name does not tell; by default seconds.

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
    table = with_time_unit(read_table(path), time_unit, time)
    window = parse_window(start, stop)
    x_name, y_name = two_columns(table, input, output)
    findings = list(table.findings)
    samples, chosen, clock = read_pair(table, x_name, y_name, time, run, window, findings)
    (x_bare, x_unit), (y_bare, y_unit) = _label(table, x_name), _label(table, y_name)
    return Recording(
        input=samples.values[0],
        output=samples.values[1],
        time=samples.time,
        name=table.name if chosen is None else f"{table.name}, run {chosen}",
        input_name=x_bare,
        output_name=y_bare,
        input_unit=x_unit,
        output_unit=y_unit,
        breaks=samples.breaks,
        findings=tuple(findings),
        provenance=_provenance(table, {"input": x_name, "output": y_name, "time": clock}, chosen, start, stop, samples),
    )


def read_pair(
    table: Table,
    x_name: str,
    y_name: str,
    time: str | None,
    run: str | None,
    window: tuple[float, float],
    findings: list[Finding],
) -> tuple[Samples, str | None, str | None]:
    """Input and output of a table, cleaned and checked, with the run and the time column that were used.

    `findings` grows by what was found; the errors are those of `read_log`.
    """
    units = (_label(table, x_name)[1], _label(table, y_name)[1])
    about = Context(table.name, (x_name, y_name), table.row_word, units)
    samples, chosen, clock = pair_samples(table, x_name, y_name, time, run, window, about, findings)
    samples = find_gaps(samples, about, findings)
    require_samples(samples, about, window)
    check_pair(table, x_name, y_name, samples, findings)
    return samples, chosen, clock


def read_signal(
    path: PathLike,
    column: str,
    *,
    time: str | None = None,
    run: str | None = None,
    start: float | None = None,
    stop: float | None = None,
    time_unit: str | None = None,
    missing: Literal["hold", "drop"] = "hold",
) -> Signal:
    """Read one column of a log, for simulation or as a reference to follow.

    Errors are those of `read_log`; a constant column is allowed.

    Parameters
    ----------
    path
        Log of any format that `read_log` reads.
    column
        Column, named as for `read_log`.
    time, run, start, stop, time_unit
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
    table = with_time_unit(read_table(path), time_unit, time)
    window = parse_window(start, stop)
    name = find_column(table, column, "signal")
    refuse_clock(table, name, "signal")
    findings = list(table.findings)
    about = Context(table.name, (name,), table.row_word, (_label(table, name)[1],))
    clock = choose_clock(table, name, time)
    chosen, mask = select_rows(table, name, run)
    samples = samples_of(table, (name,), clock, mask, findings)
    samples = prepare(samples, about, window, findings, hold=missing == "hold")
    samples = find_gaps(samples, about, findings)
    require_samples(samples, about, window, least=1)
    check_signal(samples, about, findings)
    bare, unit = _label(table, name)
    provenance = _provenance(table, {"column": name, "time": clock}, chosen, start, stop, samples)
    return Signal(samples.values[0], samples.time, bare, unit, samples.breaks, tuple(findings), provenance)


def _label(table: Table, name: str) -> tuple[str, str]:
    bare, unit = parse_unit(name)
    return bare, table.units.get(name) or unit


def _provenance(
    table: Table,
    columns: dict[str, str | None],
    run: str | None,
    start: float | None,
    stop: float | None,
    samples: Samples,
) -> dict[str, Any]:
    return {
        "file": table.name,
        "sha256": table.sha256,
        **columns,
        "run_column": run_column(table) if run is not None else None,
        "run": run,
        "window": [start, stop],
        "rows": int(samples.rows.size),
        "first_row": int(samples.rows.min()),
        "last_row": int(samples.rows.max()),
    }
