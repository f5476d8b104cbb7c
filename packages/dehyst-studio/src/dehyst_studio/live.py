"""Samples as they come: what every source hands on, and lines that are added to a text log.

A source is a generator of arrays (time, input, output), of `Skipped` where a number is missing, of `Notice` for what
its user must know, and of None now and then, so that its reader can do other work. A source outlives the other side: it
waits and connects again. What is read is what `dehyst.read_log` would read: columns by their names with or without
units, values in the model's units, stamps in seconds.
"""

from __future__ import annotations

import os
import time as clock
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO
from urllib.parse import unquote, urlsplit

import numpy as np

from dehyst.arrays import Array
from dehyst.errors import ColumnError, LogError, ParameterError, TimeError
from dehyst.io import (
    LogTable,
    TableLayout,
    cell_with_unit,
    choose_clock,
    parse_date_times,
    require_unit,
    seconds,
)
from dehyst.io import kit as io_kit
from dehyst.io import with_time_unit as with_unit_of_time
from dehyst.models import SignalCard
from dehyst.models import kit as models_kit
from dehyst.units import DIMENSION, parse_unit, words

Batch = tuple[Array, Array, Array]
PAUSE = 0.2  # seconds between two looks
HEAD = 1 << 16  # bytes in which a table must show
BLOCK = 1 << 20  # bytes that are read at a time
LONGEST_LINE = 1 << 20  # bytes; what has no end before is no line of a log
LEAST_ROWS = (
    8  # by which columns are judged: fewer do not tell whether a nameless column is a clock
)
SHOWN = 200  # characters that are kept of what holds no numbers
PASSWORD = "DEHYST_PASSWORD"  # variable of the environment: a command line can be read by others


@dataclass(frozen=True)
class Skipped:
    """Lines, messages or values that hold no sample, the last of them, and what is wrong with it."""

    count: int
    last: str
    why: str = ""


@dataclass(frozen=True)
class Notice:
    """What is to be said once, in a sentence."""

    text: str


Arrival = Batch | Skipped | Notice | None


@dataclass(frozen=True)
class Names:
    """What the signals are called at the source.

    `time` is None where the source tells or arrival counts; `time_unit` is that of a time whose name does not tell.
    `cards` are the model's signals, into whose units the values are converted; None: they stay as they come.
    """

    input: str
    output: str
    time: str | None = None
    time_unit: str | None = None
    cards: tuple[SignalCard, SignalCard] | None = None

    def converted(
        self, role: int, values: Array, unit: str, column: str
    ) -> tuple[Array, list[str]]:
        """Return values of the input (0) or the output (1) in the model's unit, and what is to be said.

        Raises
        ------
        UnitError
            If the unit cannot be turned into the model's.
        """
        if self.cards is None:
            return values, []
        changed, findings = models_kit.in_units_of(self.cards[role], values, unit, column)
        return changed, [finding.message for finding in findings]


@dataclass(frozen=True)
class Address:
    """Parts of the address of a broker or a server."""

    scheme: str
    user: str
    host: str
    port: int | None
    path: str  # all that follows the first slash, as it stands


def address_of(url: str, schemes: Sequence[str], example: str) -> Address:
    """Take an address apart; one that cannot be meant is refused with an example.

    Examples
    --------
    >>> address_of("mqtt://rig@broker:1884/plant/a?b", ["mqtt"], "")
    Address(scheme='mqtt', user='rig', host='broker', port=1884, path='plant/a?b')
    """
    scheme, mark, location = url.partition("://")
    authority, _, path = location.partition("/")
    why = ""
    try:
        parts = urlsplit(f"//{authority}")
        host, port = parts.hostname or "", parts.port
        host.encode("idna")
    except ValueError as fault:
        host, port, why = "", None, f" ({fault!s:.80})"
    if not mark or scheme not in schemes or not host or port == 0:
        raise ParameterError(
            f"{url!r:.80} is no address that can be listened to{why}. Type {example}.", url=url
        )
    if parts.password is not None:
        raise ParameterError(
            f"the address of {host} holds a password, which every user of this machine can read in the list of "
            f"processes. Leave it out, and put it into the variable {PASSWORD}.",
            host=host,
        )
    return Address(scheme, unquote(parts.username or ""), host, port, path)


def arrivals(
    times: Array, x: Array, y: Array, skipped: Sequence[str], why: str = ""
) -> Iterator[Arrival]:
    """What is yielded of a piece: never nothing, so that the reader can look at its clock."""
    if skipped:
        yield Skipped(len(skipped), skipped[-1][:SHOWN], why)
    if times.size:
        yield times, x, y
    else:
        yield None


def follow_live(path: Path, names: Names) -> Iterator[Arrival]:
    """Lines of a text log, those that are there and those that are added; a file that begins anew is read anew."""
    stream = _opened(path)
    while stream is None:
        yield None
        clock.sleep(PAUSE)
        stream = _opened(path)
    lines: _Lines | None = None
    origin, count = None, 0
    # `pending` is what came after the last end of a line; a `torn` line is too long to be waited for.
    pending, torn = b"", False
    waiting = ""
    while True:
        data = stream.read(BLOCK)
        if not data:
            if waiting:
                yield Notice(waiting)
            else:
                yield None
            waiting = ""
            clock.sleep(PAUSE)
            if _began_anew(path, stream):
                fresh = _opened(path)
                if fresh is not None:
                    stream.close()
                    stream, lines = fresh, None
                    pending, torn = b"", False
            continue
        pending += data
        if lines is None:
            try:
                lines = _Lines.found(pending, path.name, names, origin)
            except (ColumnError, TimeError):
                raise
            except LogError as fault:
                if len(pending) > HEAD:
                    raise
                waiting = f"{fault} It is looked at again when more has come."
            if lines is None:
                yield None
                continue
            waiting, origin = "", lines.origin
            for note in lines.notes:
                yield Notice(note)
            # The head is no sample.
            pending = b"\n".join(pending.split(b"\n")[lines.layout.first :])
        whole, end, pending = pending.rpartition(b"\n")
        if torn and end:
            whole, torn = whole.partition(b"\n")[2], False
        if len(pending) > LONGEST_LINE:
            reason = f"its line has no end within {LONGEST_LINE >> 20} MB"
            yield Skipped(1, repr(pending[:40]), reason)
            pending, torn = b"", True
        batch, skipped, passed = lines.read(whole, count)
        count += passed
        yield from arrivals(*batch, skipped)


def _opened(path: Path) -> BinaryIO | None:
    """Open a log; None where there is none yet."""
    try:
        return path.open("rb") if path.stat().st_size else None
    except FileNotFoundError:
        return None
    except OSError as fault:
        raise LogError(
            f"log '{path.name}' cannot be followed: {fault.strerror or fault}.", file=path.name
        ) from None


def _began_anew(path: Path, stream: BinaryIO) -> bool:
    """Whether another file has the name now, or this one has become shorter."""
    try:
        now = path.stat()
    except OSError:
        return False
    # A program that rotates logs makes a new file; one that empties its log keeps the file.
    return now.st_ino != os.fstat(stream.fileno()).st_ino or now.st_size < stream.tell()


@dataclass(frozen=True)
class _Lines:
    """How the lines of a log are read, by its first ones."""

    layout: TableLayout
    names: Names
    places: tuple[int, int, int]  # of time (-1: the number of the line), input, output
    units: tuple[str, str, str]
    order: str  # of day and month, "" where time is a number
    scale: float  # unit of time [s]
    first: float  # stamp from which time counts
    origin: float | None  # that of the first file, where stamps count from 1970 [s]
    shift: float  # from this file's first stamp to that [s]
    columns: tuple[str, str]
    log: str
    notes: tuple[str, ...] = ()

    @classmethod
    def found(cls, head: bytes, name: str, names: Names, origin: float | None) -> _Lines | None:
        """Judge a table by what there is of it; None if that is too little."""
        whole = head[: head.rfind(b"\n") + 1]
        if whole.count(b"\n") <= LEAST_ROWS:
            if len(head) > HEAD:
                raise LogError(
                    f"the first {len(head) >> 10} kB of log '{name}' hold no lines: it is no text log."
                )
            return None
        table = with_unit_of_time(io_kit.read_delimited(whole, name), names.time_unit, names.time)
        if table.rows.size < LEAST_ROWS:
            return None
        x, y = io_kit.two_columns(table, names.input, names.output)
        timer = choose_clock(table, x, names.time)
        # A column that is called time holds one value for as long as its clock has not moved.
        if timer is None and len(head) <= HEAD and any(map(is_called_time, table.order)):
            return None
        columns = [x, y]
        if timer:
            columns.append(timer)
        for column in columns:
            # A column with some text may be followed: lines without a number are left out one by one.
            reason = table.refused.get(column, io_kit.HOLDS_TEXT)
            if io_kit.HOLDS_TEXT not in reason:
                raise ColumnError(reason, column=column)
        notes = [finding.message for finding in table.findings]
        scale, first, order, shift = 1.0, 0.0, "", 0.0
        text = io_kit.open_text(whole, name)
        layout = io_kit.layout_of(text, name) or io_kit.find_layout(text.all_lines(), name)
        if timer is None:
            notes.append(
                f"{name} has no time column: its lines are counted, and gaps, rates and creep cannot be seen."
            )
        else:
            require_unit(table, timer)
            stamps, zero = seconds(table, timer)
            notes += [finding.message for finding in io_kit.unit_finding(table, timer, stamps)]
            scale, counts = io_kit.counting_clock(table, timer)
            if counts:
                first = float(io_kit.measured(table.columns[timer])[0])
                if origin is None:
                    origin = zero
                shift = zero - origin
            if timer in table.stamps:
                order = io_kit.date_order(_cells(whole, layout, table.order.index(timer)))[0]
        units = (table.units.get(timer or "", ""), table.label(x)[1], table.label(y)[1])
        timer_place = -1
        if timer is not None:
            timer_place = table.order.index(timer)
        places = (timer_place, table.order.index(x), table.order.index(y))
        lines = cls(layout, names, places, units, order, scale, first, origin, shift, (x, y), name)
        lines._check(table, whole, (timer, x, y))
        # A trial conversion tells what is to be said about the units.
        for role in (0, 1):
            notes += lines._converted(role, np.zeros(1))[1]
        return cls(**{**vars(lines), "notes": tuple(notes)})

    def _check(self, table: LogTable, whole: bytes, columns: Sequence[str | None]) -> None:
        """Refuse a log of which the lines one by one say another thing than the whole."""
        body = b"\n".join(whole.split(b"\n")[self.layout.first :])
        raw = self._numbers(body)[0]
        named = [k for k, column in enumerate(columns) if column is not None]
        expected = np.array([table.columns[columns[k] or ""] for k in named])
        expected = expected[:, io_kit.finite(expected).all(axis=0)]
        if not np.array_equal(raw[named][:, io_kit.finite(raw[named]).all(axis=0)], expected):
            raise ColumnError(
                f"log '{self.log}' cannot be followed line by line: a line alone does not tell how its numbers are to "
                f"be read (separators of thousands, an encoding of two bytes a character or the like). Log plain "
                f"numbers in UTF-8.",
                columns=self.columns,
            )

    def read(self, whole: bytes, count: int) -> tuple[Batch, list[str], int]:
        """Samples of whole lines in the model's units, lines without one, and how many lines there were."""
        raw, texts = self._numbers(whole)
        time = count + np.arange(raw.shape[1], dtype=np.float64)
        good = io_kit.finite(raw).all(axis=0)
        if self.places[0] >= 0:
            time = io_kit.in_seconds(raw[0], self.scale, self.first) + self.shift
        skipped = [texts[k] for k in np.flatnonzero(~good)]
        x, _ = self._converted(0, raw[1][good])
        y, _ = self._converted(1, raw[2][good])
        return (time[good], x, y), skipped, raw.shape[1]

    def _converted(self, role: int, values: Array) -> tuple[Array, list[str]]:
        return self.names.converted(
            role, values, self.units[1 + role], f"'{self.columns[role]}' of {self.log}"
        )

    def _numbers(self, whole: bytes) -> tuple[Array, list[str]]:
        """Time, input and output as they stand in lines, (3, lines), NaN where there is none; and the lines."""
        texts, rows = [], []
        for text, row in _rows(whole.split(b"\n"), self.layout):
            # A line of another width is no sample: its cells would lie in the wrong columns.
            if len(row) != self.layout.width:
                row = [""] * self.layout.width
            texts.append(text)
            rows.append(row)
        raw = np.zeros((3, len(rows)))
        for k, place in enumerate(self.places):
            if place >= 0 and rows:
                raw[k] = self._column([row[place].strip() for row in rows], k)
        return raw, texts

    def _column(self, cells: list[str], k: int) -> Array:
        if k == 0 and self.order:
            return parse_date_times(cells, self.order)
        values, bad = io_kit.parse_numbers(cells, self.layout.decimal_comma)
        if bad:  # perhaps with its unit beside it
            pairs = [cell_with_unit(cell) for cell in cells]
            for place, pair in enumerate(pairs):
                if pair and pair[1] == self.units[k]:
                    values[place] = io_kit.comma_number(pair[0])
        return values


def _rows(lines: Sequence[bytes], layout: TableLayout) -> Iterator[tuple[str, list[str]]]:
    """Text and cells of the lines that are no comments."""
    for line in lines:
        text = line.decode("utf-8", "replace").strip("\r\0")
        if not io_kit.is_comment(text):
            yield text, io_kit.split_line(text, layout.delimiter)


def _cells(whole: bytes, layout: TableLayout, place: int) -> list[str]:
    """Cells of a column in the lines of data."""
    cells = []
    for _, row in _rows(whole.split(b"\n")[layout.first :], layout):
        # In a line of another width this place belongs to another column.
        if len(row) == layout.width:
            cells.append(row[place])
    return cells


def is_called_time(name: str) -> bool:
    """Whether a column or key is time by its name or its unit."""
    bare, unit = parse_unit(name)
    return bool(io_kit.TIME_WORDS & set(words(bare))) or DIMENSION.get(unit) == "time"
