"""Logs become recordings: choose columns, run and window, clean, say what was found."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from dehyst.errors import ColumnError, RecordingError, TimeError
from dehyst.findings import Finding
from dehyst.io.checks import check_pair, check_signal
from dehyst.io.clean import Context, Samples, drop_unmeasured, find_gaps, order_time
from dehyst.io.clocks import choose_clock, clock_names, same_clock, seconds, unit_finding
from dehyst.io.columns import count_runs, find_column, run_column, select_run
from dehyst.io.formats import PathLike, read_table
from dehyst.io.merge import logged_in_turns, merge_clocks
from dehyst.io.table import Array, Table
from dehyst.recording import MINIMUM_SAMPLES, Recording
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
    table = read_table(path)
    window = _window(start, stop)
    x_name = find_column(table, input, "input")
    y_name = find_column(table, output, "output")
    if x_name == y_name:
        raise ColumnError(
            f"input and output are both column '{x_name}' of {table.name}; a loop needs two. "
            f"Its columns are: {', '.join(table.columns)}.",
            column=x_name,
        )
    findings = list(table.findings)
    about = Context(table.name, (x_name, y_name), table.row_word)
    samples, chosen, clock = _pair(table, x_name, y_name, time, run, window, about, findings)
    samples = find_gaps(samples, about, findings)
    _require_samples(samples, about, window)
    (x_bare, x_unit), (y_bare, y_unit) = _label(table, x_name), _label(table, y_name)
    check_pair(table, x_name, y_name, samples, findings)
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


def read_signal(
    path: PathLike,
    column: str,
    *,
    time: str | None = None,
    run: str | None = None,
    start: float | None = None,
    stop: float | None = None,
) -> Signal:
    """Read one column of a log, for simulation or as a reference to follow.

    Parameters and errors are those of `read_log`; a constant column is allowed.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> log = pathlib.Path(tempfile.mkdtemp()) / "reference.csv"
    >>> _ = log.write_text("time_s,angle_deg\\n0,1\\n0.1,2\\n0.2,3\\n0.3,2\\n")
    >>> read_signal(log, "angle").values.tolist()
    [1.0, 2.0, 3.0, 2.0]
    """
    table = read_table(path)
    window = _window(start, stop)
    name = find_column(table, column, "signal")
    findings = list(table.findings)
    about = Context(table.name, (name,), table.row_word)
    clock = choose_clock(table, name, time)
    chosen, mask = _select(table, name, run)
    samples = _samples(table, (name,), clock, mask, findings)
    samples = _prepare(samples, about, window, findings)
    samples = find_gaps(samples, about, findings)
    _require_samples(samples, about, window, least=1)
    check_signal(samples, about, findings)
    bare, unit = _label(table, name)
    provenance = _provenance(table, {"column": name, "time": clock}, chosen, start, stop, samples)
    return Signal(samples.values[0], samples.time, bare, unit, samples.breaks, tuple(findings), provenance)


def list_runs(path: PathLike) -> dict[str, int]:
    """Runs of a log, in its order, and their number of rows; empty if it does not tell runs apart."""
    return count_runs(read_table(path))


def _window(start: float | None, stop: float | None) -> tuple[float, float]:
    window = (-math.inf if start is None else float(start), math.inf if stop is None else float(stop))
    if not window[0] < window[1]:
        raise TimeError(
            f"the window from {start} s to {stop} s is empty. --from must be less than --to, both in seconds of the "
            f"log's own time.",
            start=start,
            stop=stop,
        )
    return window


def _label(table: Table, name: str) -> tuple[str, str]:
    bare, unit = parse_unit(name)
    return bare, table.units.get(name) or unit


def _select(table: Table, column: str, run: str | None) -> tuple[str | None, Any]:
    """Run and mask; columns on clocks of their own (other lengths) have no runs."""
    if table.columns[column].size != table.rows.size:
        return None, np.ones(table.columns[column].size, dtype=bool)
    return select_run(table, run)


def _samples(
    table: Table, names: tuple[str, ...], clock: str | None, mask: Any, findings: list[Finding], shift: bool = False
) -> Samples:
    part = Table(
        name=table.name,
        columns={n: table.columns[n][mask] for n in dict.fromkeys((*names, *((clock,) if clock else ())))},
        units=table.units,
        rows=table.rows,
        clocks=table.clocks,
        stamps=table.stamps,
    )
    stamps: Array | None = None
    if clock:
        stamps, origin = seconds(part, clock)
        stamps = stamps + origin if shift else stamps
        findings.extend(f for f in unit_finding(part, clock, stamps) if f not in findings)
    rows = table.rows[: mask.size][mask]
    return Samples(stamps, tuple(part.columns[n] for n in names), rows)


def _prepare(samples: Samples, about: Context, window: tuple[float, float], findings: list[Finding]) -> Samples:
    """Window, then drop, then order: a fault outside the window is none of the user's business."""
    if math.isfinite(window[0]) or math.isfinite(window[1]):
        t = samples.time
        if t is None:
            raise TimeError(
                f"{about.log} has no time column, so it cannot be cut from {window[0]:g} s to {window[1]:g} s. "
                f"Name one with --time, or leave --from and --to out.",
                log=about.log,
            )
        with np.errstate(invalid="ignore"):
            inside = (t >= window[0]) & (t < window[1])
        if not inside.any():
            known = t[np.isfinite(t)]
            spans = f"from {known.min():.6g} s to {known.max():.6g} s" if known.size else "no time at all"
            raise TimeError(
                f"no sample of {about.log} lies in the window {window[0]:g} s <= t < {window[1]:g} s; the log covers "
                f"{spans}. Change --from and --to.",
                window=window,
            )
        samples = samples.take(inside)
    samples = drop_unmeasured(samples, about, findings)
    return order_time(samples, about, findings)


def _pair(
    table: Table,
    x_name: str,
    y_name: str,
    time: str | None,
    run: str | None,
    window: tuple[float, float],
    about: Context,
    findings: list[Finding],
) -> tuple[Samples, str | None, str | None]:
    x_size, y_size = table.columns[x_name].size, table.columns[y_name].size
    clocks = [choose_clock(table, name, time if x_size == y_size else None) for name in (x_name, y_name)]
    chosen, mask = _select(table, x_name, run)
    one_clock = x_size == y_size and (
        clocks[0] == clocks[1] or (clocks[0] is not None and clocks[1] is not None and same_clock(table, *clocks))  # type: ignore[arg-type]
    )
    if one_clock:
        samples = _samples(table, (x_name, y_name), clocks[0], mask, findings)
        if clocks[0] is None:
            findings.append(
                Finding(
                    "no-time",
                    f"{table.name} has no time column: gaps, rate dependence and drift cannot be seen. Log one, or "
                    f"name it with --time.",
                )
            )
        elif time is None:
            _warn_other_clocks(table, clocks[0], x_size, findings)
        if clocks[0] is None or not logged_in_turns(*samples.values):
            return _prepare(samples, about, window, findings), chosen, clocks[0]
        pair = tuple(Samples(samples.time, (v,), samples.rows).take(np.isfinite(v)) for v in samples.values)
    else:
        masks = [_select(table, name, run)[1] for name in (x_name, y_name)]
        pair = tuple(
            _samples(table, (name,), clock, m, findings, shift=True)
            for name, clock, m in zip((x_name, y_name), clocks, masks, strict=True)
        )
        pair = _from_common_zero(pair)
    # Each signal keeps its own context in messages: a bad cell of one is not a bad cell of the other.
    ready = [
        _prepare(s, Context(about.log, (name,), about.word), window, findings)
        for s, name in zip(pair, (x_name, y_name), strict=True)
    ]
    return merge_clocks(ready[0], ready[1], about, findings), chosen, clocks[0]


def _from_common_zero(pair: tuple[Samples, ...]) -> tuple[Samples, ...]:
    """Two epoch clocks count from the earlier of their first samples; other clocks keep their values."""
    times = [s.time for s in pair if s.time is not None and np.isfinite(s.time).any()]
    if len(times) < 2 or min(float(np.nanmedian(t)) for t in times) < 9.78e8:
        return pair
    zero = min(float(t[np.isfinite(t)][0]) for t in times)
    return tuple(Samples(s.time - zero if s.time is not None else None, s.values, s.rows) for s in pair)


def _warn_other_clocks(table: Table, clock: str, size: int, findings: list[Finding]) -> None:
    others = [
        name
        for name in clock_names(table)
        if name != clock and table.columns[name].size == size and not same_clock(table, clock, name)
    ]
    if others and clock not in table.clocks.values():
        findings.append(
            Finding(
                "several-time-columns",
                f"{table.name} has more than one time column; '{clock}' was taken, and {', '.join(others)} tells "
                f"another time. If that is the right one: --time {others[0]}",
            )
        )


def _require_samples(
    samples: Samples, about: Context, window: tuple[float, float], least: int = MINIMUM_SAMPLES
) -> None:
    if samples.rows.size < least:
        cut = f" in the window {window[0]:g} s <= t < {window[1]:g} s" if window != (-math.inf, math.inf) else ""
        raise RecordingError(
            f"{about.log} has {samples.rows.size} usable rows{cut}; a loop needs at least {least}. Check the window "
            f"(--from, --to), the run (--run) and the columns.",
            rows=samples.rows.size,
        )


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
