"""Reads long logs: in parts, thinned to rows that fit into memory with ease.

A log above `WHOLE_BYTES` is never in memory as a whole, if its format allows that. What comes out is a usual table with
the columns that were asked for, whose rows stand for all (`dehyst.io._thin`). Everything after that is the same for
short and for long logs.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array, Mask, Rows
from dehyst.errors import ColumnError, RecordingError
from dehyst.findings import Finding
from dehyst.io._clocks import (
    choose_clock,
    counting_clock,
    in_seconds,
    newest_first,
    require_unit,
    two_columns,
    with_clock,
)
from dehyst.io._collect import FilePiece, NotInPartsError, Source
from dehyst.io._columns import choose_run, count_labels, numbered_labels, run_column
from dehyst.io._formats import PathLike, open_source, readable
from dehyst.io._frames import is_frame
from dehyst.io._table import SHOWN, LogTable, finite, list_rows
from dehyst.io._text import SIZE_LIMIT
from dehyst.io._thin import MOST_ROWS, Thinner

Progress = Callable[[float], object]  # takes the share of the file that was read

# Identifying a log at once takes up to 5 bytes of memory for each byte of its file, so that shorter files take 300 MB.
WHOLE_BYTES = 64 << 20
# How much larger packed logs are than their files, roughly.
PACKED = {".gz": 4.0, ".parquet": 2.0, ".feather": 2.0}
PART_ROWS = 1 << 17  # rows that are read at once, and fewer of many columns
PART_CELLS = 1 << 20
# Cells by which a log of unknown input and output is looked at: three columns of as many rows as an input may have.
MOST_CELLS = 3 * MOST_ROWS


@dataclass(frozen=True)
class Selection:
    """What is to be read of a log, as `dehyst.read_log` is told."""

    input: str
    output: str
    time: str | None
    run: str | None
    window: tuple[float, float]
    time_unit: str | float | None
    dt: float | None


def is_long(path: Any) -> bool:
    """Whether a log is better read in parts."""
    if is_frame(path) or not isinstance(path, str | Path):
        return False
    file = Path(path)
    try:
        return (
            file.is_file()
            and file.stat().st_size * PACKED.get(file.suffix.lower(), 1.0) > WHOLE_BYTES
        )
    except (OSError, ValueError):  # which reading it will explain
        return False


def read_long(
    path: PathLike, selection: Selection, progress: Progress | None = None
) -> LogTable | None:
    """Input, output and time of a long log, thinned; None where it has to be read at once, and can be."""
    return _unless_refused(
        path, lambda: _Reader(open_source(path), selection).read(progress or _no_one)
    )


def look_at_long(path: PathLike, progress: Progress | None = None) -> LogTable | None:
    """All columns of a long log, one of so many rows; None where it has to be read at once, and can be."""
    return _unless_refused(path, lambda: _look_at(open_source(path), progress or _no_one))


def _no_one(share: float) -> None:
    """Hear nothing of the progress."""


def _unless_refused(path: PathLike, read: Callable[[], LogTable]) -> LogTable | None:
    try:
        return read()
    except NotInPartsError:
        if Path(path).stat().st_size > SIZE_LIMIT:
            raise
        return None


def _parts(source: Source, names: list[str], width: int, progress: Progress) -> Iterator[FilePiece]:
    rows = min(PART_ROWS, max(1, PART_CELLS // width))
    pieces = source.pieces(names, rows)
    while True:
        with readable(source.path):
            piece = next(pieces, None)
        if piece is None:
            return
        yield piece
        progress(min(1.0, piece.consumed / source.size))


def _sha256(path: Path) -> str:
    with readable(path), path.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


@dataclass
class _Unmeasured:
    """Rows without a number that were left out: how many, and the first of them."""

    count: int = 0
    first: list[int] = field(default_factory=list)

    def add(self, rows: Rows) -> None:
        self.count += rows.size
        self.first += rows[: SHOWN - len(self.first)].tolist()


class _Reader:
    """Reads input, output and time of one log."""

    def __init__(self, source: Source, selection: Selection) -> None:
        self.source, self.selection = source, selection
        self.head = with_clock(source.table, selection.time_unit, selection.time, selection.dt)
        self.pair = two_columns(self.head, selection.input, selection.output)
        for name in self.pair:
            if name in self.head.refused:
                raise ColumnError(self.head.refused[name], column=name)
        self.clock = self._clock()
        self.run_column = run_column(self.head)
        self.thinner = Thinner(MOST_ROWS, signal=0)
        if self.clock is not None:
            self.thinner = Thinner(MOST_ROWS, signal=0, clock=2)
        self.unmeasured, self.rows = _Unmeasured(), 0
        self.runs: dict[str, int] = {}
        self.first_stamp: float | None = None

    def _clock(self) -> str | None:
        """The one time column of both signals."""
        head, source = self.head, self.source
        lengths = source.lengths
        length = lengths.get(self.pair[0], 0)
        if lengths.get(self.pair[1], 0) != length:
            raise self._two_clocks()
        fitting = [name for name in head.order if lengths.get(name, length) == length]
        columns = {name: head.columns[name] for name in fitting if name in head.columns}
        same_length = replace(head, columns=columns, order=tuple(fitting))
        first = choose_clock(same_length, self.pair[0], self.selection.time)
        if first != choose_clock(same_length, self.pair[1], self.selection.time):
            raise self._two_clocks()
        if first is None or self.selection.dt is not None:
            return first
        require_unit(head, first)
        stamps = head.columns[first]
        if stamps is not source.table.columns.get(first):
            raise NotInPartsError(
                f"{head.name} is too long to be read at once, and has its date and its time in two columns, or days "
                f"that it does not name. Write one column of time, or split the log.",
                column=first,
            )
        if newest_first(stamps) and self.selection.window != (-math.inf, math.inf):
            raise NotInPartsError(
                f"{head.name} is too long to be read at once, and is written newest row first, so that no window of it "
                f"can be cut. Read all of it, or split it.",
                column=first,
            )
        return first

    def _two_clocks(self) -> NotInPartsError:
        x, y = self.pair
        return NotInPartsError(
            f"{self.head.name} is too long to be read at once, and '{x}' and '{y}' are on two clocks, which are not "
            f"merged in parts. Name one clock with --time if it is that of both, or split the log.",
            columns=self.pair,
        )

    def read(self, progress: Progress) -> LogTable:
        """Read the whole log once."""
        names = [*self.pair]
        if self.clock is not None and self.selection.dt is None:
            names.append(self.clock)
        if self.run_column is not None:
            names.append(self.run_column)
        for piece in _parts(self.source, names, len(self.head.order), progress):
            self._add(piece)
            if self.thinner.is_full:
                break
        run = choose_run(self.head.name, self.runs, self.selection.run)
        if not self.thinner.samples:
            raise RecordingError(
                f"{self.head.name} has no {self.head.row_word} in which {' and '.join(self.pair)} are both numbers. "
                f"Check the columns with: dehyst inspect LOG",
                columns=self.pair,
            )
        return self._table(run)

    def _add(self, piece: FilePiece) -> None:
        columns: list[Any] = [*piece.columns]
        rows = piece.rows
        if self.run_column is not None:
            mask = self._of_run(columns.pop())
            columns, rows = _take(columns, mask), rows[mask]
        if self.selection.dt is not None:
            columns.append(self._counted(rows))
        measured = np.ones(rows.size, dtype=np.bool_)
        for column in columns:
            measured &= finite(column)
        self.rows += rows.size
        self.unmeasured.add(rows[~measured])
        if self.clock is not None:
            measured &= self._in_window(columns[2], measured)
        self.thinner.add(_take(columns, measured), rows[measured])

    def _of_run(self, labels: npt.NDArray[Any]) -> Mask:
        """Rows of the run that was named, else of the first one; `choose_run` refuses several in the end."""
        if labels.dtype.kind == "f":
            labels = numbered_labels(labels)
        for name, count in count_labels(labels).items():
            self.runs[name] = self.runs.get(name, 0) + count
        run = self.selection.run
        if run is None:
            run = next(iter(self.runs), "")
        return np.asarray(labels == run)

    def _counted(self, rows: Rows) -> Array:
        """Time by the number of rows. [s]"""
        first_rows = self.head.rows
        step = 1.0
        if first_rows.size > 1:
            step = max(1.0, float(np.median(np.diff(first_rows))))
        return np.asarray((rows - first_rows[0]) / step * (self.selection.dt or 0.0))

    def _in_window(self, stamps: Array, measured: Mask) -> Mask:
        """Rows in the window, and the very first, from which some clocks count."""
        window = self.selection.window
        if window == (-math.inf, math.inf) or self.clock is None:
            return measured
        scale, is_epoch = counting_clock(self.head, self.clock)
        inside = np.zeros(stamps.size, dtype=np.bool_)
        if self.first_stamp is None and measured.any():
            begin = int(np.argmax(measured))
            self.first_stamp = float(stamps[begin])
            inside[begin] = True
        zero = 0.0
        if is_epoch and self.first_stamp is not None:
            zero = self.first_stamp
        time = in_seconds(stamps, scale, zero)
        return inside | ((time >= window[0]) & (time < window[1]))

    def _table(self, run: str | None) -> LogTable:
        head, thinner = self.head, self.thinner
        values, rows = thinner.result()
        names = [*self.pair]
        clocks: dict[str, str] = {}
        if self.clock is not None:
            names.append(self.clock)
            clocks = dict.fromkeys(self.pair, self.clock)
        columns = dict(zip(names, values, strict=True))
        labels = {}
        if self.run_column is not None and run is not None:
            if self.run_column in head.labels:
                labels[self.run_column] = np.broadcast_to(np.array(run), rows.shape)
            else:
                columns[self.run_column] = np.broadcast_to(np.array(float(run)), rows.shape)
        return replace(
            head,
            columns=columns,
            rows=rows,
            labels=labels,
            clocks=clocks,
            sha256=_sha256(self.source.path),
            findings=tuple(self._findings(rows)),
            every=thinner.every,
            samples=thinner.samples,
        )

    def _findings(self, rows: Rows) -> Iterator[Finding]:
        head, thinner = self.head, self.thinner
        yield from head.findings
        yield from self.source.findings()
        if self.unmeasured.count:
            listed = list_rows(self.unmeasured.first, head.row_word, self.unmeasured.count)
            yield Finding(
                "non-finite",
                f"{self.unmeasured.count} of {self.rows} rows of {head.name} were left out because a cell of "
                f"{', '.join(self.pair)} or of the time is empty, infinite or not a number: {listed}. Nothing to do if "
                f"the sensor is known to drop out; otherwise check its cable.",
            )
        if rows.size == thinner.samples and not thinner.is_full:
            return
        _, unit = head.label(self.pair[0])
        swing = f"{thinner.swing:.3g} {unit}".strip()
        end = ""
        if thinner.is_full:
            last = f"{head.row_word} {rows[-1]}"
            end = (
                f" '{self.pair[0]}' turns so often that there was no room for what follows {last}."
            )
        yield Finding(
            "thinned",
            f"{head.name} is long: {rows.size} of {thinner.samples} rows stand for it, one in {thinner.every}, and "
            f"beside them those where '{self.pair[0]}' turns by more than {swing} and those at gaps.{end} Model, "
            f"scores and verdict are of these rows; what takes less time than {thinner.every} rows, such as a short "
            f"dead time, is not seen. To see it, name a window of at most {MOST_ROWS} rows: --from and --to.",
        )


def _take(columns: list[Any], mask: Mask) -> list[Any]:
    """Rows of columns that a mask chooses."""
    return [column[mask] for column in columns]


def _look_at(source: Source, progress: Progress) -> LogTable:
    head = source.table
    named = [*head.columns, *head.labels]
    longest = max(source.lengths.get(name, 0) for name in named)
    names = [name for name in named if source.lengths.get(name, 0) == longest]
    thinner = Thinner(most=max(1000, MOST_CELLS // len(names)))
    for piece in _parts(source, names, len(head.order), progress):
        thinner.add(piece.columns, piece.rows)
    values, rows = thinner.result()
    columns: dict[str, Array] = {}
    labels: dict[str, npt.NDArray[np.str_]] = {}
    for name, column in zip(names, values, strict=True):
        if name in head.labels:
            labels[name] = column
        else:
            columns[name] = column
    findings = [*head.findings, *source.findings()]
    if rows.size < thinner.samples:
        message = (
            f"{head.name} is long: its columns were looked at by one in {thinner.every} of its {thinner.samples} rows. "
            f"Ranges and loops are those of these rows. Nothing to do."
        )
        findings.append(Finding("thinned", message))
    return replace(
        head,
        columns=columns,
        labels=labels,
        rows=rows,
        sha256=_sha256(source.path),
        findings=tuple(findings),
        every=thinner.every,
        samples=thinner.samples,
    )
