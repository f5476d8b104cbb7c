"""Reads logs larger than memory: input and output in chunks, in constant memory, repeatable.

Rows in which a signal or the time is no number are left out and counted. What needs the whole log at once is not done:
outliers stay in, angles are not unwrapped, rows are not sorted, gaps and a clock that jumps back are findings only.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array, Rows
from dehyst.data.loops import gap_limit
from dehyst.errors import ColumnError, RecordingError, RunError, TimeError
from dehyst.findings import Finding
from dehyst.io.clocks import (
    choose_clock,
    counting,
    in_seconds,
    newest_first,
    require_unit,
    seconds,
    two_columns,
    unit_finding,
    with_clock,
)
from dehyst.io.collect import Piece, Source
from dehyst.io.columns import MAX_NUMBERED_RUNS, numbered_labels, provenance, run_column, select_run
from dehyst.io.formats import PathLike, open_source, readable
from dehyst.io.table import SHOWN, Table, finite, list_rows

Chunk = tuple[Array | None, Array, Array]

ROWS = 1 << 17


def open_chunks(
    path: PathLike,
    input: str,
    output: str,
    time: str | None = None,
    *,
    run: str | None = None,
    time_unit: str | float | None = None,
    dt: float | None = None,
    rows: int = ROWS,
) -> ChunkedLog:
    """Open a log to be read in chunks.

    Parameters
    ----------
    path
        .csv .txt .tsv .dat (also .gz), .npz, .npy; with extras .bag .db3 .mcap, .parquet .feather.
    input, output
        Columns, named as for `read_log`.
    time
        Time column; by default the one that looks like it.
    run
        Run to read, needed when the log holds several.
    time_unit
        Unit of the time column where its name does not tell; by default seconds.
    dt
        Seconds from one row to the next, where the log has no time column.
    rows
        Most samples in a chunk.

    Returns
    -------
    log : ChunkedLog

    Raises
    ------
    LogError
        If the file cannot be read, or not in chunks; ColumnError, RunError and TimeError if it does not hold what was
        asked for.
    MissingExtraError
        If the format needs a package that is not installed.
    UnitError
        If `time_unit` is no unit of time.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "log.csv"
    >>> _ = file.write_text("time_s,pressure_bar,angle_deg\\n" + "".join(f"{k},{k % 7},{k % 5}\\n" for k in range(100)))
    >>> log = open_chunks(file, input="pressure", output="angle", rows=30)
    >>> [x.size for _, x, _ in log], log.input_unit, log.consumed == log.size
    ([30, 30, 30, 10], 'bar', True)
    """
    source = open_source(path)
    table = with_clock(source.table, time_unit, time, dt)
    x_name, y_name = two_columns(table, input, output)
    for name in (x_name, y_name):
        if name in table.refused:
            raise ColumnError(table.refused[name], column=name)
    clock = _clock(source, table, x_name, y_name, time) if dt is None else None
    runs, named = run_column(table), run is not None
    if runs is None or run is None:
        run = select_run(table, run)[0]  # refuses a run where there are none, and none where there are several
    return ChunkedLog(source, table, (x_name, y_name, clock, runs), run, rows, named, dt)


def _clock(source: Source, table: Table, x_name: str, y_name: str, time: str | None) -> str | None:
    """The one clock of both signals."""
    same = source.lengths.get(x_name, 0)
    others = {name for name, length in source.lengths.items() if length != same}
    if y_name not in others:
        kept = {name: values for name, values in table.columns.items() if name not in others}
        table = replace(table, columns=kept, order=tuple(name for name in table.order if name not in others))
        clocks = [choose_clock(table, name, time) for name in (x_name, y_name)]
        if clocks[0] == clocks[1]:
            _require_clock(source, table, clocks[0])
            return clocks[0]
    raise TimeError(
        f"'{x_name}' and '{y_name}' of {table.name} are on two clocks, which cannot be merged in chunks. Name one "
        f"clock with --time if it is that of both, or read the log at once, with dehyst.read_log.",
        columns=(x_name, y_name),
    )


def _require_clock(source: Source, table: Table, clock: str | None) -> None:
    """Refuse a clock that cannot be read row by row."""
    if clock is None:
        return
    require_unit(table, clock)
    joined = table.columns[clock] is not source.table.columns.get(clock)
    backward = newest_first(table.columns[clock])
    if joined or backward:
        why = (
            "has its date and its time in two columns, or days that it does not name"
            if joined
            else "is written newest row first"
        )
        raise TimeError(
            f"{table.name} {why}, which is mended only where all of it is read at once: --no-stream, or in Python "
            f"dehyst.read_log.",
            column=clock,
        )


class ChunkedLog:
    """A log that is read in chunks; iterate over it as often as needed.

    Iteration gives ``(time, x, y)``, float64, (K,) each with 1 <= K <= rows, in the units of the log; time [s] is None
    for a log without a time column. One pass at a time.

    Attributes
    ----------
    name
        File name without its folder, and the run.
    input_name, output_name, input_unit, output_unit
        As in a `Recording`.
    has_time
        Whether chunks have time.
    size
        Bytes that a pass reads.
    consumed
        Bytes read so far in the present pass; `size` at its end.
    samples
        Samples given out in the present pass.
    costly
        Whether a pass takes much longer than reading the numbers from a binary file would.
    """

    name: str
    input_name: str
    output_name: str
    input_unit: str
    output_unit: str
    has_time: bool
    size: int
    consumed: int
    samples: int
    costly: bool

    def __init__(
        self,
        source: Source,
        table: Table,
        columns: tuple[str, str, str | None, str | None],
        run: str | None,
        rows: int,
        named: bool,
        dt: float | None,
    ) -> None:
        self._source, self._table, self._rows = source, table, max(1, int(rows))
        self._columns, self._run, self._named = columns, run, named
        self.input_name, self.input_unit = table.label(columns[0])
        self.output_name, self.output_unit = table.label(columns[1])
        self.name = table.name if run is None else f"{table.name}, run {run}"
        self.size, self.costly, self.has_time = source.size, source.costly, columns[2] is not None or dt is not None
        self._dt, self._line = dt, (table.rows[:1], max(1.0, float(np.median(np.diff(table.rows)))))
        self._counting, self._clock_findings = (1.0, False), list[Finding]()
        if columns[2]:
            self._counting = counting(table, columns[2])
            self._clock_findings = unit_finding(table, columns[2], seconds(table, columns[2])[0])
        self._sha256 = ""
        self._begin()

    def _begin(self) -> None:
        self.consumed, self.samples = 0, 0
        self._first: float | None = None
        self._tally = _Tally(self._table, self._columns)

    @property
    def input_label(self) -> str:
        """Name and unit of the input, for axes."""
        return f"{self.input_name} [{self.input_unit}]" if self.input_unit else self.input_name

    @property
    def output_label(self) -> str:
        """Name and unit of the output, for axes."""
        return f"{self.output_name} [{self.output_unit}]" if self.output_unit else self.output_name

    def __iter__(self) -> Iterator[Chunk]:
        """Read the log from its start.

        Raises
        ------
        LogError
            If the file is damaged further on, or cannot be read in chunks there.
        RunError
            If there is more than one run and none was named, or not the one that was.
        RecordingError
            If no row is left.
        """
        self._begin()
        tally = self._tally
        names = [name for name in self._columns if name is not None]
        pieces = self._source.pieces(names, self._rows)
        while True:
            with readable(self._source.path):
                piece = next(pieces, None)
            if piece is None:
                break
            self.consumed = piece.consumed
            chunk = self._chunk(piece, tally)
            if chunk:
                self.samples += chunk[1].size
                yield chunk
        self.consumed = self.size
        self._require_samples(tally)

    def _chunk(self, piece: Piece, tally: _Tally) -> Chunk | None:
        columns: list[Any] = list(piece.columns)
        rows = piece.rows
        if self._columns[3] is not None:
            mask = self._of_run(columns.pop(), tally)
            columns, rows = [column[mask] for column in columns], rows[mask]
        if self._dt is not None:
            columns.insert(2, (rows - self._line[0]) / self._line[1] * self._dt)
        elif self.has_time:
            columns[2] = self._seconds(columns[2])
        good = np.logical_and.reduce([finite(column) for column in columns])
        if not good.all():
            tally.leave_out(rows[~good])
            columns, rows = [column[good] for column in columns], rows[good]
        if rows.size == 0:
            return None
        time = columns[2] if self.has_time else None
        tally.count(rows, time)
        return time, columns[0], columns[1]

    def _of_run(self, labels: npt.NDArray[Any], tally: _Tally) -> npt.NDArray[np.bool_]:
        """Rows of the run that was named, or of the only one."""
        text = numbered_labels(labels) if labels.dtype.kind == "f" else labels
        tally.meet_runs(text)
        if not self._named and len(tally.runs) > 1:
            raise RunError(
                f"{self._table.name} holds several runs and none was named: {', '.join(list(tally.runs)[:40])} and "
                f"perhaps more. What the actuator remembers does not carry over from one to the next, so name one: "
                f"--run {self._run}",
                runs=tuple(tally.runs),
            )
        return np.asarray(text == self._run)

    def _seconds(self, stamps: Array) -> Array:
        scale, is_epoch = self._counting
        good = stamps[finite(stamps)] if is_epoch and self._first is None else stamps[:0]
        if good.size:
            self._first = float(good[0])
        return in_seconds(stamps, scale, self._first or 0.0)

    def _require_samples(self, tally: _Tally) -> None:
        if self.samples:
            return
        if self._run is not None and self._run not in tally.runs:
            raise RunError(
                f"{self._table.name} has no run '{self._run}'. It holds: {', '.join(list(tally.runs)[:40])}.",
                run=self._run,
                runs=tuple(tally.runs),
            )
        raise RecordingError(
            f"{self._table.name} has no {self._table.row_word} in which {self._columns[0]} and {self._columns[1]} are "
            f"both numbers. Check the columns with: dehyst inspect LOG",
            columns=self._columns[:2],
        )

    @property
    def findings(self) -> tuple[Finding, ...]:
        """What was noticed: at the start of the log, and in the rows that the present pass has met."""
        return (*self._table.findings, *self._clock_findings, *self._source.findings(), *self._tally.findings())

    @property
    def provenance(self) -> Mapping[str, Any]:
        """File, fingerprint, columns and rows, as `read_log` gives them; the rows are those of the present pass."""
        if not self._sha256:
            with readable(self._source.path), self._source.path.open("rb") as stream:
                self._sha256 = hashlib.file_digest(stream, "sha256").hexdigest()
        x_name, y_name, clock, _ = self._columns
        tally = self._tally
        return provenance(
            replace(self._table, sha256=self._sha256),
            {"input": x_name, "output": y_name, "time": clock},
            self._run,
            [None, None],
            (self.samples, tally.first, tally.last),
        )


class _Places:
    """Rows of one kind: how many, and the first few."""

    def __init__(self) -> None:
        self.count = 0
        self.rows: list[int] = []

    def add(self, rows: Rows) -> None:
        self.count += rows.size
        self.rows += rows[: SHOWN - len(self.rows)].tolist()

    def listed(self, word: str) -> str:
        return list_rows(self.rows, word, self.count)


class _Tally:
    """Counts of a pass: the runs met with, in the order of the log, and the rows of the first and the last sample."""

    def __init__(self, table: Table, columns: tuple[str, str, str | None, str | None]) -> None:
        self._table, self._columns = table, [name for name in columns[:3] if name is not None]
        self.runs: dict[str, None] = {}
        self.first = self.last = 0
        self._rows = 0
        self._bad, self._back, self._gaps = _Places(), _Places(), _Places()
        self._limit: float | None = None
        self._time = np.nan
        self._longest = 0.0

    def meet_runs(self, labels: npt.NDArray[np.str_]) -> None:
        """Note the runs of some rows."""
        if labels.size and len(self.runs) <= MAX_NUMBERED_RUNS:
            starts = np.concatenate(([True], labels[1:] != labels[:-1]))
            self.runs.update(dict.fromkeys(label for label in labels[starts].tolist() if label))

    def leave_out(self, rows: Rows) -> None:
        """Note rows without numbers."""
        self._rows += rows.size
        self._bad.add(rows)

    def count(self, rows: Rows, time: Array | None) -> None:
        """Note samples: their rows, and their time [s]."""
        self.first = self.first or int(rows[0])
        self.last = int(rows[-1])
        self._rows += rows.size
        if time is None:
            return
        if self._limit is None:  # by the first chunk, as what a gap is cannot wait for the last one
            self._limit = gap_limit(np.diff(time)) if time.size > 2 else np.inf
        step = np.diff(time, prepend=self._time)
        self._time = float(time[-1])
        gaps = step > self._limit
        self._back.add(rows[step < 0])
        self._gaps.add(rows[gaps])
        self._longest = max(self._longest, float(np.max(step[gaps], initial=0.0)))

    def findings(self) -> list[Finding]:
        """Findings for what was met with."""
        name, word = self._table.name, self._table.row_word
        said = [
            (
                self._bad,
                Finding(
                    "non-finite",
                    f"{self._bad.count} of {self._rows} rows of {name} were left out because a cell of "
                    f"{', '.join(self._columns)} is empty, infinite or not a number: {self._bad.listed(word)}. Nothing "
                    f"to do if the sensor is known to drop out; otherwise check its cable.",
                ),
            ),
            (
                self._gaps,
                Finding(
                    "gap",
                    f"{name} has {self._gaps.count} gap{'s' if self._gaps.count > 1 else ''}, before "
                    f"{self._gaps.listed(word)}; the longest is {self._longest:.4g} s. The log was read in chunks, and "
                    f"the recording goes on across them. Cut the log there if the input may have turned unseen.",
                ),
            ),
            (
                self._back,
                Finding(
                    "clock-restart",
                    f"the clock of {name} jumps back {self._back.count} times, at {self._back.listed(word)}. "
                    f"The log was read in chunks, in the order of its rows, and the recording goes on. If several "
                    f"recordings follow each other, split the log.",
                ),
            ),
        ]
        return [finding for places, finding in said if places.count]
