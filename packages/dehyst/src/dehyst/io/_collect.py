"""Converts binary logs to tables: arrays become columns with names and times, whole or in parts."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array, Rows
from dehyst.errors import LogError
from dehyst.findings import Finding
from dehyst.io._cells import are_dates, parse_date_times, seconds_of_dates
from dehyst.io._clocks import TIME_WORDS, is_clock
from dehyst.io._foreign import Result, guard
from dehyst.io._plain import PROBE
from dehyst.io._table import LogTable, require_columns
from dehyst.shell import visible
from dehyst.units import TABLE, canonical, parse_unit, words

HEAD_ROWS = (
    1 << 16
)  # rows by which columns, clock and units of a log that is read in parts are found
MAX_COLUMNS = 4000
MAX_WIDTH = 64  # a wider matrix is a picture or a point cloud, not signals
STEP_NAMES = frozenset(words("ts dt sampletime samplingtime sampleperiod stepsize"))
RATE_NAMES = frozenset(words("fs samplerate samplingrate samplefrequency samplingfrequency"))
COUNTED = "time_from_"  # begins the name of a time column that was counted from a sampling time
STEP_UNITS = TABLE["time"] | {"kHz": 1e3, "MHz": 1e6}  # of a sampling time or rate, in s or Hz

Column = npt.NDArray[np.float64] | npt.NDArray[np.str_]


@dataclass
class Collector:
    """Gathers what a binary log holds: columns and all that belongs to them as in `Table`, and what was noticed."""

    name: str
    columns: dict[str, Array] = field(default_factory=dict)
    labels: dict[str, npt.NDArray[np.str_]] = field(default_factory=dict)
    units: dict[str, str] = field(default_factory=dict)
    clocks: dict[str, str] = field(default_factory=dict)
    stamps: set[str] = field(default_factory=set)
    date_orders: dict[str, str] = field(default_factory=dict)  # of texts: "day" or "month" first
    scalars: dict[str, float] = field(default_factory=dict)
    refused: dict[str, str] = field(default_factory=dict)
    findings: list[Finding] = field(default_factory=list)
    sheet: str | int | None = (
        None  # of a workbook: what was asked for, then the name of what was read
    )

    @property
    def names(self) -> list[str]:
        """Of all columns, those of numbers first."""
        return [*self.columns, *self.labels]

    def add(self, path: str, value: Any, unit: str = "") -> list[str]:
        """Add an array under a path; return the names of the columns it became.

        A vector becomes one column, a matrix one column per signal (``path_1``, ``path_2``, ...) with time along
        its longer side, a single number a scalar. Whatever is no signal is passed over.
        """
        path, unit = visible(path), visible(unit)
        array = np.asarray(value)
        if array.dtype.names:
            names: list[str] = []
            for field_name in array.dtype.names:
                below = f"{path}.{field_name}" if path else field_name
                names += self.add(below, array[field_name])
            return names
        if array.dtype.kind in "mM":
            names = self.add(path, numbers_of(array), "s")
            if array.dtype.kind == "M":
                self.stamps.update(names)
            return names
        if array.dtype.kind in "US":
            flat = np.atleast_1d(np.squeeze(array))
            if flat.ndim == 1 and flat.size > 1:
                self.labels[path] = _texts_of(flat)
            return []
        if array.dtype.kind not in "fiub" or array.size == 0:
            return []
        array = np.squeeze(array)
        if array.ndim == 0:
            self.scalars[path] = float(array) * STEP_UNITS.get(canonical(unit) or unit, 1.0)
            return []
        if array.ndim == 1:
            return [self._put(path, array, unit)]
        if array.ndim != 2 or min(array.shape) > MAX_WIDTH:
            return []
        if array.shape[0] < array.shape[1]:
            array = array.T
        return [self._put(f"{path}_{k}", column, unit) for k, column in enumerate(array.T, 1)]

    def _put(self, path: str, vector: npt.NDArray[Any], unit: str) -> str:
        if len(self.columns) >= MAX_COLUMNS:
            return path
        name, k = path, 1
        while name in self.columns:
            k += 1
            name = f"{path}_{k}"
        with np.errstate(all="ignore"):
            self.columns[name] = np.ascontiguousarray(vector, dtype=np.float64)
        if unit:
            self.units[name] = canonical(unit) or unit
        else:
            self.units[name] = parse_unit(name.rpartition(".")[2])[1]
        return name

    def table(self) -> LogTable:
        """Read dates, find the clocks of structs, make time from a sampling time, and build the table."""
        self._read_dates()
        self._sibling_clocks()
        self._time_from_step()
        longest = max((column.size for column in self.columns.values()), default=0)
        return require_columns(
            LogTable(
                name=self.name,
                columns=self.columns,
                units=self.units,
                rows=np.arange(1, longest + 1, dtype=np.int64),
                labels=self.labels,
                row_word="sample",
                clocks=self.clocks,
                stamps=frozenset(self.stamps),
                scalars=self.scalars,
                refused=self.refused,
                sheet=str(self.sheet or ""),
                findings=tuple(self.findings),
            )
        )

    def _read_dates(self) -> None:
        """Texts that are dates or times of day become seconds, as in a CSV file."""
        for name, texts in list(self.labels.items()):
            if name in self.columns or not are_dates(texts[texts != ""][:PROBE].tolist()):
                continue
            seconds, order = seconds_of_dates(texts.tolist(), name, self.findings)
            self.columns[name], self.units[name] = seconds, "s"
            self.stamps.add(name)
            self.date_orders[name] = order
            del self.labels[name]

    def _sibling_clocks(self) -> None:
        """A field called time in a struct is the clock of the fields beside and below it."""
        for name in list(self.columns):
            folder, dot, leaf = name.rpartition(".")
            if not dot or not set(words(leaf)) & TIME_WORDS:
                continue
            size = self.columns[name].size
            for sibling, values in self.columns.items():
                if sibling.startswith(folder + ".") and sibling != name and values.size == size:
                    self.clocks.setdefault(sibling, name)

    def _time_from_step(self) -> None:
        """Without any time column, a sampling time or rate stored beside the signals tells the time."""
        probe = LogTable(
            self.name,
            self.columns,
            self.units,
            np.zeros(0, dtype=np.int64),
            stamps=frozenset(self.stamps),
        )
        if not self.columns or any(is_clock(probe, name) for name in self.columns):
            return
        steps: list[tuple[str, float]] = []
        for path, value in self.scalars.items():
            leaf = "".join(words(path.rpartition(".")[2]))
            if value > 0 and np.isfinite(value) and leaf in STEP_NAMES | RATE_NAMES:
                steps.append((path, value if leaf in STEP_NAMES else 1.0 / value))
        if len(steps) != 1:
            return
        path, step = steps[0]
        longest = max(column.size for column in self.columns.values())
        made = self._put(f"{COUNTED}{path}", np.arange(longest) * step, "s")
        self.findings.append(
            Finding(
                "time-from-step",
                f"{self.name} holds no time column; time was counted from {path}: {step:g} s.",
            )
        )
        for name, values in self.columns.items():
            if values.size == longest and name != made:
                self.clocks[name] = made


def strings_of(rows: Sequence[Any]) -> npt.NDArray[np.str_] | None:
    """Labels from a sequence of strings, or None if it holds anything else."""
    if not rows or not all(isinstance(row, str) for row in rows):
        return None
    return np.array(rows, dtype=np.str_)


def numbers_of(values: npt.NDArray[Any]) -> Column:
    """Numbers of an array as `Collector` makes them: float64, date-times in seconds, text as labels."""
    if values.dtype.kind == "M":
        seconds = values.astype("datetime64[ns]").astype(np.int64) / 1e9
        return np.where(np.isnat(values), np.nan, seconds)
    if values.dtype.kind == "m":
        return values.astype("timedelta64[ns]").astype(np.float64) / 1e9
    if values.dtype.kind in "US":
        return _texts_of(values)
    with np.errstate(all="ignore"):
        return np.ascontiguousarray(values, dtype=np.float64)


def _texts_of(values: npt.NDArray[Any]) -> npt.NDArray[np.str_]:
    """Texts without blanks around them."""
    if values.dtype.kind == "U":
        return np.asarray(np.char.strip(values))
    try:
        text = np.char.decode(values, "utf-8")
    except UnicodeDecodeError:
        text = np.char.decode(values, "latin-1")
    return np.asarray(np.char.strip(text))


@dataclass(frozen=True, slots=True)
class FilePiece:
    """Some rows of the columns that were asked for."""

    columns: Sequence[Column]  # numbers or labels, (K,) each
    rows: Rows  # number of each row in the file, (K,)
    consumed: int  # bytes of the file that have been read so far


def even_parts(count: int, most: int) -> Iterator[tuple[int, int]]:
    """Cut rows into parts of one size, at most `most`: a last one of few rows would look like a row of many columns."""
    number = -(-count // most)
    for k in range(number):
        yield k * count // number, (k + 1) * count // number


class NotInPartsError(LogError):
    """A log that can only be read at once."""


class Source:
    """A log on disk that is read in pieces and is never in memory as a whole; each format derives its own."""

    path: Path
    size: int  # bytes of the file
    title: str  # of the format
    table: LogTable  # the first rows, as reading the whole file gives them
    lengths: Mapping[
        str, int
    ]  # column -> its samples, where the file tells; others are on other clocks
    date_orders: Mapping[str, str]  # column of dates that are texts -> "day" or "month" first

    def __init__(self, path: Path, title: str) -> None:
        self.path, self.size, self.title = path, path.stat().st_size, title
        self.lengths, self.date_orders = {}, {}
        self.table = self._head()

    def _head(self) -> LogTable:
        collector = Collector(self.path.name)
        self._guard(lambda: self.collect(collector))
        table = collector.table()
        self.date_orders = collector.date_orders
        return table

    def _guard(self, read: Callable[[], Result]) -> Result:
        return guard(self.path.name, self.title, self.size, read)

    def collect(self, collector: Collector) -> None:
        """Gather the first rows of all columns."""
        raise NotImplementedError

    def pieces(self, names: Sequence[str], rows: int) -> Iterator[FilePiece]:
        """All rows of some columns, at most `rows` at a time."""
        count = max(self.lengths.get(name, 0) for name in names)
        with ExitStack() as stack:
            file = self._guard(lambda: self.opened(stack, names))
            for begin, end in even_parts(count, rows):
                columns = self._guard(partial(self.part, file, names, begin, end))
                for k, name in enumerate(names):
                    if name in self.date_orders:
                        columns[k] = parse_date_times(columns[k].tolist(), self.date_orders[name])
                number = np.arange(begin + 1, end + 1, dtype=np.int64)
                yield FilePiece(columns, number, self.size * end // count)

    def opened(self, stack: ExitStack, names: Sequence[str]) -> Any:
        """What `part` reads some columns from; the stack closes it."""
        raise NotImplementedError

    def part(self, file: Any, names: Sequence[str], begin: int, end: int) -> list[Column]:
        """Rows of some columns from one to another; the next call reads on from there."""
        raise NotImplementedError

    def counted(self, name: str, begin: int, end: int) -> Column:
        """Rows of a time column that was counted from a sampling time; nothing else can be told from the head."""
        if not name.startswith(COUNTED):
            raise NotInPartsError(
                f"column '{name}' of '{self.path.name}' cannot be read in parts.",
                file=self.path.name,
            )
        return np.asarray(
            np.arange(begin, end) * float(self.table.columns[name][1]), dtype=np.float64
        )

    def findings(self) -> list[Finding]:
        """What the last pass met with, besides cells without numbers."""
        return []
