"""Several columns of a log, row by row: tables and logs in which more than two signals belong together."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from dehyst.arrays import Array
from dehyst.errors import ColumnError
from dehyst.findings import Finding
from dehyst.io.clean import Context, drop_unmeasured
from dehyst.io.clocks import choose_clock, refuse_clock, with_time_unit
from dehyst.io.columns import find_column
from dehyst.io.formats import PathLike, read_table
from dehyst.io.logs import _label, _provenance
from dehyst.io.order import order_time
from dehyst.io.select import cut_window, parse_window, samples_of, select_rows


@dataclass(frozen=True, eq=False)
class Columns:
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


def read_columns(
    path: PathLike,
    columns: Mapping[str, str],
    *,
    time: str | None = None,
    run: str | None = None,
    start: float | None = None,
    stop: float | None = None,
    time_unit: str | None = None,
) -> Columns:
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
    table = with_time_unit(read_table(path), time_unit, time)
    window = parse_window(start, stop)
    names = {role: find_column(table, wanted, role) for role, wanted in columns.items()}
    _refuse_twice(names, table.name)
    for role, name in names.items():
        refuse_clock(table, name, role)
    chosen = tuple(names.values())
    _refuse_lengths({name: table.columns[name].size for name in chosen}, table.name)
    labels = {role: _label(table, name) for role, name in names.items()}
    findings = list(table.findings)
    about = Context(table.name, chosen, table.row_word, tuple(unit for _, unit in labels.values()))
    clock = choose_clock(table, chosen[0], time)
    which, mask = select_rows(table, chosen[0], run)
    samples = cut_window(samples_of(table, chosen, clock, mask, findings), about, window)
    samples = order_time(drop_unmeasured(samples, about, findings), about, findings)
    return Columns(
        dict(zip(names, samples.values, strict=True)),
        {role: bare for role, (bare, _) in labels.items()},
        {role: unit for role, (_, unit) in labels.items()},
        samples.time,
        table.name if which is None else f"{table.name}, run {which}",
        tuple(findings),
        _provenance(table, {**names, "time": clock}, which, start, stop, samples),
    )


def _refuse_twice(names: Mapping[str, str], log: str) -> None:
    seen: dict[str, str] = {}
    for role, name in names.items():
        if name in seen:
            raise ColumnError(
                f"{seen[name]} and {role} are both column '{name}' of {log}. Name two columns.", column=name
            )
        seen[name] = role


def _refuse_lengths(sizes: Mapping[str, int], log: str) -> None:
    if len(set(sizes.values())) > 1:
        listed = ", ".join(f"{name} {size}" for name, size in sizes.items())
        raise ColumnError(
            f"columns of {log} differ in length ({listed}): they were logged on clocks of their own. Write them into "
            f"one table first, a row for each instant.",
            sizes=dict(sizes),
        )
