"""Logs larger than memory: input and output in chunks, in constant memory, as often as they are needed.

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

from dehyst.arrays import Array
from dehyst.errors import ColumnError, LogError, RecordingError, RunError, TimeError
from dehyst.findings import Finding
from dehyst.io.clocks import choose_clock, counting, in_seconds, two_columns, with_time_unit
from dehyst.io.columns import labels_of, run_column, select_run
from dehyst.io.formats import BINARY, PathLike, open_source, path_of, readable, require_file
from dehyst.io.streams import Piece, Source
from dehyst.io.table import Table, finite
from dehyst.io.tally import Tally
from dehyst.units import parse_unit

Chunk = tuple[Array | None, Array, Array]

ROWS = 1 << 17
STREAMED = {".npz", ".npy", ".bag", ".db3", ".mcap", ".parquet", ".feather"}


def open_chunks(
    path: PathLike,
    input: str,
    output: str,
    time: str | None = None,
    *,
    run: str | None = None,
    time_unit: str | None = None,
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
    source = _open(path)
    table = with_time_unit(source.head(), time_unit, time)
    x_name, y_name = two_columns(table, input, output)
    for name in (x_name, y_name):
        if name in table.refused:
            raise ColumnError(table.refused[name], column=name)
    clock = _clock(source, table, x_name, y_name, time)
    runs, named = run_column(table), run is not None
    if runs is None or run is None:
        run = select_run(table, run)[0]  # refuses a run where there are none, and none where there are several
    return ChunkedLog(source, table, (x_name, y_name, clock, runs), run, rows, named)


def _open(path: PathLike) -> Source:
    source = path_of(path)
    with readable(source):
        if source.is_dir():
            raise LogError(
                f"'{source}' is a folder, which cannot be read in chunks. Name the .db3 or .mcap file inside it.",
                path=str(source),
            )
        require_file(source)
        with source.open("rb") as stream:
            head = stream.read(16)
        if source.suffix.lower() in {*BINARY, ".mat"} - STREAMED:
            raise LogError(
                f"'{source.name}' cannot be read in chunks; CSV, NPZ, NPY, Parquet, Feather, ROS bags and MCAP can. "
                f"Read it at once, with dehyst.read_log, or export it as one of these.",
                path=str(source),
            )
        return open_source(source, head)


def _clock(source: Source, table: Table, x_name: str, y_name: str, time: str | None) -> str | None:
    """The one clock of both signals."""
    same = source.lengths.get(x_name, 0)
    others = {name for name, length in source.lengths.items() if length != same}
    if y_name not in others:
        kept = {name: values for name, values in table.columns.items() if name not in others}
        table = replace(table, columns=kept, order=tuple(name for name in table.order if name not in others))
        clocks = [choose_clock(table, name, time) for name in (x_name, y_name)]
        if clocks[0] == clocks[1]:
            return clocks[0]
    raise TimeError(
        f"'{x_name}' and '{y_name}' of {table.name} are on two clocks, which cannot be merged in chunks. Name one "
        f"clock with --time if it is that of both, or read the log at once, with dehyst.read_log.",
        columns=(x_name, y_name),
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

    __slots__ = (
        "_columns",
        "_counting",
        "_first",
        "_named",
        "_rows",
        "_run",
        "_sha256",
        "_source",
        "_table",
        "_tally",
        "consumed",
        "has_time",
        "input_name",
        "input_unit",
        "name",
        "output_name",
        "output_unit",
        "samples",
        "size",
    )

    def __init__(
        self,
        source: Source,
        table: Table,
        columns: tuple[str, str, str | None, str | None],
        run: str | None,
        rows: int,
        named: bool,
    ) -> None:
        self._source, self._table, self._rows = source, table, max(1, int(rows))
        self._columns, self._run, self._named = columns, run, named
        x_name, y_name, clock, _ = columns
        (self.input_name, x_unit), (self.output_name, y_unit) = parse_unit(x_name), parse_unit(y_name)
        self.input_unit, self.output_unit = table.units.get(x_name) or x_unit, table.units.get(y_name) or y_unit
        self.name = table.name if run is None else f"{table.name}, run {run}"
        self.size, self.consumed, self.samples = source.size, 0, 0
        self.has_time = clock is not None
        self._first: float | None = None
        self._counting = counting(table, clock) if clock else (1.0, False)
        self._tally = Tally(table, columns)
        self._sha256 = ""

    @property
    def costly(self) -> bool:
        """Whether a pass takes much longer than reading the numbers from a binary file would."""
        return self._source.costly

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
        self.consumed, self.samples, self._first = 0, 0, None
        self._tally = tally = Tally(self._table, self._columns)
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

    def _chunk(self, piece: Piece, tally: Tally) -> Chunk | None:
        columns: list[Any] = list(piece.columns)
        rows = piece.rows
        if self._columns[3] is not None:
            mask = self._of_run(columns.pop(), tally)
            columns, rows = [column[mask] for column in columns], rows[mask]
        if self.has_time:
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

    def _of_run(self, labels: npt.NDArray[Any], tally: Tally) -> npt.NDArray[np.bool_]:
        """Rows of the run that was named, or of the only one."""
        text = labels_of(labels) if labels.dtype.kind == "f" else labels
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

    def _require_samples(self, tally: Tally) -> None:
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
        return (*self._table.findings, *self._source.findings(), *self._tally.findings())

    @property
    def provenance(self) -> Mapping[str, Any]:
        """File, fingerprint, columns and rows, as `read_log` gives them; the rows are those of the present pass."""
        if not self._sha256:
            with readable(self._source.path), self._source.path.open("rb") as stream:
                self._sha256 = hashlib.file_digest(stream, "sha256").hexdigest()
        x_name, y_name, clock, runs = self._columns
        return {
            "file": self._table.name,
            "sha256": self._sha256,
            "input": x_name,
            "output": y_name,
            "time": clock,
            "run_column": runs if self._run is not None else None,
            "run": self._run,
            "window": [None, None],
            "rows": self.samples,
            "first_row": self._tally.first,
            "last_row": self._tally.last,
        }
