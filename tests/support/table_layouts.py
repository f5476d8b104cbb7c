"""Tables of numbers in the layouts that loggers, spreadsheets and scripts write, each with its truth."""

from __future__ import annotations

import datetime as dt
import io
import itertools
from contextlib import suppress
from dataclasses import dataclass

import numpy as np

from dehyst.errors import DehystError
from dehyst.io import read_log, read_table

ROWS = 60
SECONDS = np.round(np.arange(ROWS) * 0.25, 6)
PRESSURE = np.round(4.5 * np.sin(0.4 * np.arange(ROWS) + 0.3), 3)
FLOW = np.round(20.0 + 7.0 * np.sin(0.17 * np.arange(ROWS) + 0.1), 2)
ANGLE = np.round(31.0 * np.sin(0.4 * np.arange(ROWS)) + 1.0, 4)
BEGIN = dt.datetime(2024, 3, 5, 11, 59, 58)

DELIMITERS = {
    "comma": ",",
    "semicolon": ";",
    "tab": "\t",
    "pipe": "|",
    "blank": " ",
    "comma+blank": ", ",
    "xlsx": "",
}
STAMPS = ("none", "seconds", "iso-T", "iso-blank", "german", "us", "days")
HEADERS = (
    "none", "one-line", "two-words", "first-two-words", "quoted", "units-row", "unknown-units", "grouped",
    "groups-above", "one-short", "counter", "named-counter", "row-names", "padded", "padded-title", "two-more-cells",
)  # fmt: skip
ENDS = {"lf": "\n", "crlf": "\r\n", "nul": "\0\n", "nul-padded": "\0\0\0\0\r\n"}


@dataclass(frozen=True)
class Case:
    """A file and what it holds."""

    name: str
    ending: str
    data: bytes
    names: (
        tuple[str, ...] | None
    )  # of the last three columns, as they stand in the header; None without a header
    units: tuple[str, ...]  # of the last three columns
    time: np.ndarray | None  # [s] from the first row; None where the file holds none


def _stamp(kind: str, second: float, row: int, decimal: str) -> str:
    moment = BEGIN + dt.timedelta(seconds=second)
    text = {
        "seconds": f"{second:g}.0" if second == int(second) else f"{second:g}",
        "iso-T": f"{moment:%Y-%m-%dT%H:%M:%S}.{moment.microsecond // 1000:03d}",
        "iso-blank": f"{moment:%Y-%m-%d %H:%M:%S}.{moment.microsecond // 1000:03d}",
        "german": f"{moment:%d.%m.%Y %H:%M:%S},{moment.microsecond // 1000:03d}",
        "us": f"{moment:%m/%d/%Y %I:%M:%S}.{moment.microsecond // 1000:03d} {moment:%p}",
        "days": f"{BEGIN + dt.timedelta(days=row):%Y-%m-%d}",
    }[kind]
    return text.replace(".", ",") if kind == "seconds" and decimal == "," else text


def _time(kind: str) -> np.ndarray | None:
    if kind == "none":
        return None
    return 86400.0 * np.arange(ROWS) if kind == "days" else SECONDS


def _heads(
    kind: str, timed: bool
) -> tuple[list[list[str]], list[str] | None, tuple[str, str, str]]:
    """Lines above the data, the names of all columns that it names, and the units of the last three."""
    clock = ["time"] if timed else []
    units = ("bar", "m3/h", "deg")
    plain = [*clock, "pressure_bar", "flow", "angle_deg"]
    bare = [*clock, "pressure", "flow", "angle"]
    some = ("bar", "", "deg")
    if kind == "none":
        return [], None, ("", "", "")
    if kind in {"one-line", "quoted", "one-short", "two-more-cells"}:
        return [plain], plain, some
    if kind == "two-words":
        names = [*clock, "pressure_bar", "ambient flow", "angle_deg"]
        return [names], names, some
    if kind == "first-two-words":
        names = [*clock, "supply pressure_bar", "flow", "angle_deg"]
        return [names], names, some
    if kind == "units-row":
        return [bare, [*("s" for _ in clock), "bar", "l/min", "deg"]], bare, ("bar", "l/min", "deg")
    if kind == "unknown-units":
        return [bare, [*("s" for _ in clock), "bar", "m3/h", "deg"]], bare, units
    if kind == "grouped":
        return [[*("" for _ in clock), "Inlet", "", "Outlet"], plain], plain, some
    if kind == "groups-above":
        return [[*clock, "Inlet", "Outlet"], plain], plain, some
    if kind in {"counter", "row-names"}:
        return [["", *plain]], ["", *plain], some
    if kind == "named-counter":
        return [["No", *plain]], ["No", *plain], some
    padding = [""] * (len(plain) - 1)
    if kind == "padded":
        return (
            [["Report 3", *padding], ["Rate", "4", *padding[1:]], ["", *padding], plain],
            plain,
            some,
        )
    return [["Report 3", *padding], plain], plain, some


def _rows(stamps: str, header: str, decimal: str) -> list[list[str]]:
    rows = []
    for k in range(ROWS):
        cells = [_stamp(stamps, SECONDS[k], k, decimal)] if stamps != "none" else []
        digits = ((PRESSURE[k], 3), (FLOW[k], 2), (ANGLE[k], 4))
        cells += [f"{value:.{places}f}".replace(".", decimal) for value, places in digits]
        if header in {"counter", "named-counter", "one-short"}:
            cells.insert(0, str(k))
        if header == "row-names":
            cells.insert(0, f"r{k + 1}")
        if header == "two-more-cells":
            cells += ["0", "0"]
        rows.append(cells)
    return rows


def make(
    delimiter: str, decimal: str, stamps: str, header: str, end: str, bom: bool, quoted: bool
) -> Case:
    """Write one layout."""
    heads, names, units = _heads(header, stamps != "none")
    rows = _rows(stamps, header, decimal)
    mark = DELIMITERS[delimiter]
    label = "-".join([delimiter, {".": "point", ",": "decimalcomma"}[decimal], stamps, header, end])
    label += "-bom" * bom + "-quoted" * quoted
    truth = None if names is None else tuple(names[-3:])
    if delimiter == "xlsx":
        return Case(
            label, ".xlsx", _workbook(heads, rows, stamps, header), truth, units, _time(stamps)
        )

    def line(cells: list[str], quotes: bool) -> str:
        return mark.join(f'"{cell}"' if quotes else cell for cell in cells)

    lines = [line(cells, header == "quoted" or quoted) for cells in heads]
    lines += [line(cells, quoted) for cells in rows]
    text = ENDS[end].join([*lines, ""])
    return Case(label, ".csv", b"\xef\xbb\xbf" * bom + text.encode(), truth, units, _time(stamps))


def _workbook(heads: list[list[str]], rows: list[list[str]], stamps: str, header: str) -> bytes:
    """The same as cells of a spreadsheet: numbers and date-times are no text there."""
    import openpyxl

    book = openpyxl.Workbook(write_only=True)
    sheet = book.create_sheet("log")
    for r, cells in enumerate([*heads, *rows]):
        stamped = (
            len(cells) - (6 if header == "two-more-cells" else 4)
            if stamps not in {"none", "seconds"} and r >= len(heads)
            else -1
        )
        values = [_value(cell) for cell in cells]
        if stamped >= 0:
            values[stamped] = _moment(stamps, r - len(heads))
        sheet.append(values)
    stream = io.BytesIO()
    book.save(stream)
    return stream.getvalue()


def _moment(stamps: str, row: int) -> dt.datetime | dt.date:
    if stamps == "days":
        return (BEGIN + dt.timedelta(days=row)).date()
    return BEGIN + dt.timedelta(seconds=SECONDS[row])


def _value(cell: str) -> float | str | None:
    with suppress(ValueError):
        return float(cell)
    return cell or None


def layouts(workbooks: bool = True) -> list[tuple]:
    """Arguments of `make` for every delimiter, decimal sign, stamp and header.

    Line ends, byte-order mark and quoted cells go round.
    """
    listed = []
    turn = itertools.cycle(itertools.product(ENDS, (False, True), (False, False, True)))
    for delimiter, decimal, stamps, header in itertools.product(DELIMITERS, ".,", STAMPS, HEADERS):
        others = next(turn)
        plain = (delimiter, decimal, stamps, header, "lf", False, False)
        if delimiter != "xlsx":
            listed += [plain, (delimiter, decimal, stamps, header, *others)]
        elif decimal == "." and workbooks:
            listed.append(plain)
    return listed


# Codes that say of a table that its names, cells or time may not be what they seem.
WORDS_OF_NAMES = {
    "header-width",
    "comma-twice",
    "ragged-lines",
    "duplicate-columns",
    "not-readable",
}
WORDS_OF_TIME = WORDS_OF_NAMES | {"no-time", "time-unit", "date-order"}


def judge(case: Case, folder) -> str:
    """What reading gives: "right", "said: ..." (no truth, but a finding or an error), or what is wrong in silence."""
    path = folder / f"{case.name}{case.ending}"
    path.write_bytes(case.data)
    try:
        table = read_table(path)
    except DehystError as fault:
        return "said: " + str(fault)
    codes = {finding.code for finding in table.findings}
    order = list(table.order)
    if case.names is None:
        names = order[-3:]
    else:
        names = [name for name in case.names if name in order]
        if len(names) < 3:
            return (
                "said: " + ", ".join(sorted(codes))
                if codes & WORDS_OF_NAMES
                else f"names are {order}"
            )
    try:
        rec = read_log(path, names[0], names[2])
    except DehystError as fault:
        return "said: " + str(fault) if codes & WORDS_OF_NAMES else f"error: {fault}"
    codes |= {finding.code for finding in rec.findings}
    if not (np.array_equal(rec.input, PRESSURE) and np.array_equal(rec.output, ANGLE)):
        return "said: values" if codes & WORDS_OF_NAMES else "values differ"
    units = tuple(table.label(name)[1] for name in names)
    if units != case.units:
        return "said: units" if codes & WORDS_OF_NAMES else f"units are {units}"
    if (rec.time is None) != (case.time is None):
        return "said: time" if codes & WORDS_OF_TIME else f"time is {rec.time}"
    if rec.time is not None and not np.allclose(rec.time - rec.time[0], case.time, atol=2e-6):
        return "said: time" if codes & WORDS_OF_TIME else f"time is {rec.time}"
    return "right"
