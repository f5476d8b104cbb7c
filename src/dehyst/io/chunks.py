"""Logs larger than memory: input and output in chunks, in constant memory, as often as they are needed.

``open_chunks(path, input, output, time=None, *, rows=131072) -> ChunkedLog``

    log = open_chunks("long.csv", input="pressure", output="angle")
    for time, x, y in log:                 # float64 (K,), 1 <= K <= rows; time is None without a time column
        progress(log.consumed, log.size)   # bytes
    for time, x, y in log: ...             # and again from the start

A `ChunkedLog` has ``name``, ``input_name``, ``output_name``, ``input_unit``, ``output_unit``, ``input_label``,
``output_label``, ``has_time``, ``size`` and ``consumed`` (bytes), ``findings`` and ``provenance``; the last two tell of
the rows of the whole log once a pass has ended.

What needs the whole log at once is not done here: outliers stay in, angles are not unwrapped, rows are not sorted.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from dehyst.errors import ColumnError, LogError, TimeError
from dehyst.findings import Finding
from dehyst.io.clocks import EPOCH, choose_clock, refuse_clock, seconds
from dehyst.io.columns import count_runs, find_column
from dehyst.io.formats import NPY, ZIP, PathLike
from dehyst.io.streams import ArraySource, Piece, Source, TextSource
from dehyst.io.table import LARGEST, Array, Table, list_rows
from dehyst.units import TABLE, parse_unit

Chunk = tuple[Array | None, Array, Array]

ROWS = 1 << 17
BLOCK = 1 << 20
SHOWN = 4  # rows named in a finding


def open_chunks(path: PathLike, input: str, output: str, time: str | None = None, *, rows: int = ROWS) -> ChunkedLog:
    """Open a log to be read in chunks.

    Parameters
    ----------
    path
        .csv .txt .tsv .dat (also .gz), .npz, .npy.
    input, output
        Columns, named as for `read_log`.
    time
        Time column; by default the one that looks like it.
    rows
        Most samples in a chunk.

    Raises
    ------
    LogError
        If the file cannot be read, or not in chunks; ColumnError and TimeError as `read_log`.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "log.csv"
    >>> _ = file.write_text("time_s,pressure_bar,angle_deg\\n" + "".join(f"{k},{k % 7},{k % 5}\\n" for k in range(100)))
    >>> log = open_chunks(file, input="pressure", output="angle", rows=30)
    >>> [x.size for _, x, _ in log], log.input_unit, log.consumed == log.size
    ([30, 30, 30, 10], 'bar', True)
    """
    source = _source(Path(path))
    table = source.head()
    x_name, y_name = find_column(table, input, "input"), find_column(table, output, "output")
    if x_name == y_name:
        raise ColumnError(
            f"input and output are both column '{x_name}' of {table.name}; a loop needs two. "
            f"Its columns are: {', '.join(table.columns)}.",
            column=x_name,
        )
    refuse_clock(table, x_name, "input")
    refuse_clock(table, y_name, "output")
    clocks = [choose_clock(table, name, time) for name in (x_name, y_name)]
    if clocks[0] != clocks[1]:
        raise TimeError(
            f"'{x_name}' and '{y_name}' of {table.name} are on two clocks ({clocks[0]} and {clocks[1]}), which cannot "
            f"be merged in chunks. Name one clock with --time, or cut the log so that it fits into memory.",
            columns=(x_name, y_name),
        )
    if len(count_runs(table)) > 1:
        raise LogError(
            f"{table.name} holds several runs, which are not told apart in chunks. Save each run as a file of its own.",
            file=table.name,
        )
    return ChunkedLog(source, table, x_name, y_name, clocks[0], rows)


def _source(path: Path) -> Source:
    with path.open("rb") as stream:
        head = stream.read(16)
    if head.startswith((*ZIP, NPY)):
        return ArraySource(path)
    return TextSource(path)


class ChunkedLog:
    """A log that is read in chunks; iterate over it as often as needed.

    Iteration gives ``(time, x, y)``, float64, (K,) each with 1 <= K <= rows; time [s] is None for a log without one.

    Attributes
    ----------
    name
        File name without its folder.
    input_name, output_name, input_unit, output_unit
        As in a `Recording`.
    has_time
        Whether chunks have time.
    size
        Bytes that a pass reads.
    consumed
        Bytes read so far in the present pass; `size` at its end.
    """

    def __init__(self, source: Source, table: Table, x_name: str, y_name: str, clock: str | None, rows: int) -> None:
        self._source, self._clock, self._rows = source, clock, rows
        self._columns = (x_name, y_name)
        (self.input_name, x_unit), (self.output_name, y_unit) = parse_unit(x_name), parse_unit(y_name)
        self.input_unit, self.output_unit = table.units.get(x_name) or x_unit, table.units.get(y_name) or y_unit
        self.name, self.size, self.consumed = table.name, source.size, 0
        self.has_time = clock is not None
        self._head = table
        self._samples, self._first, self._last, self._bad, self._shown = 0, 0, 0, 0, [0][:0]
        self._sha256 = ""

    @property
    def input_label(self) -> str:
        """Name and unit of the input, for axes."""
        return f"{self.input_name} [{self.input_unit}]" if self.input_unit else self.input_name

    @property
    def output_label(self) -> str:
        """Name and unit of the output, for axes."""
        return f"{self.output_name} [{self.output_unit}]" if self.output_unit else self.output_name

    def __iter__(self) -> Iterator[Chunk]:
        x_name, y_name = self._columns
        names = [x_name, y_name, *([self._clock] if self._clock else [])]
        self.consumed, self._samples, self._bad, self._shown = 0, 0, 0, []
        for piece in self._source.pieces(names):
            self.consumed = piece.consumed
            yield from self._chunks(piece)
        self.consumed = self.size
        if self._samples == 0:
            raise LogError(f"{self.name} has no row in which both are numbers.", file=self.name)

    def _chunks(self, piece: Piece) -> Iterator[Chunk]:
        parts = piece.columns
        good = np.logical_and.reduce([np.abs(part) <= LARGEST for part in parts])
        rows = piece.rows
        if not good.all():
            bad = rows[~good]
            self._bad += bad.size
            self._shown += bad[: SHOWN - len(self._shown)].tolist()
            parts, rows = [part[good] for part in parts], rows[good]
        if rows.size == 0:
            return
        if self._samples == 0:
            self._first = int(rows[0])
        self._last = int(rows[-1])
        self._samples += rows.size
        time = self._seconds(parts[2]) if self._clock else None
        for k in range(0, rows.size, self._rows):
            part = slice(k, k + self._rows)
            yield (None if time is None else time[part]), parts[0][part], parts[1][part]

    def _seconds(self, stamps: Array) -> Array:
        """Stamps in seconds as `clocks.seconds` gives them, with scale and origin of the log's first rows."""
        table, clock = self._head, self._clock
        assert clock is not None
        _, shift = seconds(table, clock)
        middle = float(np.nanmedian(table.columns[clock]))
        scale = TABLE["time"].get(table.units.get(clock, ""), 0.0)
        if not scale:
            scale = next((s for s in (1.0, 1e-3, 1e-6, 1e-9) if EPOCH[0] <= middle * s < EPOCH[1]), 1.0)
        moved = stamps - (shift / scale if shift else 0.0)
        return np.asarray(moved / round(1 / scale) if scale < 1 else moved * scale)

    @property
    def findings(self) -> tuple[Finding, ...]:
        """What was noticed: at the start of the log, and in its rows once a pass has ended."""
        found = list(self._head.findings)
        if self._bad:
            what = f"{list_rows(self._shown, self._head.row_word)}{' and more' if self._bad > SHOWN else ''}"
            found.append(
                Finding(
                    "non-finite",
                    f"{self._bad} of {self._samples + self._bad} rows of {self.name} were left out because a cell of "
                    f"{', '.join(self._columns)} is empty, infinite or not a number: {what}. Nothing to do if the "
                    f"sensor is known to drop out; otherwise check its cable.",
                )
            )
        return tuple(found)

    @property
    def provenance(self) -> Mapping[str, Any]:
        """File, fingerprint, columns and rows, as `read_log` gives them."""
        if not self._sha256:
            with self._source.path.open("rb") as stream:
                self._sha256 = hashlib.file_digest(stream, "sha256").hexdigest()
        return {
            "file": self.name,
            "sha256": self._sha256,
            "input": self._columns[0],
            "output": self._columns[1],
            "time": self._clock,
            "run_column": None,
            "run": None,
            "window": [None, None],
            "rows": self._samples,
            "first_row": self._first,
            "last_row": self._last,
        }
