"""Cells of a text log: numbers, missing values, date-times; units, brackets and separators of thousands.

A unit or brackets around a number are taken away where the whole column agrees. Whether 1.017 is one point something,
or one thousand and seventeen, is asked only where the log uses the other mark as its decimal sign; the column itself
must answer it, or it is refused: a guess would be wrong by a factor of a thousand.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from datetime import UTC, datetime
from math import nan

import numpy as np

from dehyst.arrays import Array, Rows
from dehyst.findings import Finding
from dehyst.io.table import list_rows
from dehyst.units import canonical

MISSING = frozenset(
    "nan na n/a #n/a null none nil - -- ? missing -nan +nan nan(ind) -nan(ind) 1.#qnan -1.#ind 1.#ind #nan nat".split()  # noqa: SIM905
) | {""}
_NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eEdD][+-]?\d+)?", re.ASCII)
_COMMA_NUMBER = re.compile(r"[+-]?(?:\d+,\d*|,\d+)(?:[eEdD][+-]?\d+)?", re.ASCII)
_THOUSANDS_POINT = re.compile(r"[+-]?\d{1,3}(?:\.\d{3})+,\d*", re.ASCII)
_THOUSANDS_COMMA = re.compile(r"[+-]?\d{1,3}(?:,\d{3})+\.\d*", re.ASCII)
_THOUSANDS_BLANK = re.compile(r"[+-]?\d{1,3}(?:[\u00a0\u202f\u2009'\u2019]\d{3})+(?:[.,]\d*)?", re.ASCII)
HOLDS_TEXT = "holds text in"  # by which who reads line by line knows a refusal that does not concern it
_INFINITE = frozenset(["inf", "+inf", "-inf", "infinity", "+infinity", "-infinity", "1.#inf", "-1.#inf"])
_DATE_TIME = re.compile(r"\d{4}-\d\d-\d\d([T ]\d\d:\d\d(:\d\d([.,:]\d+)?)?)?( ?(Z|UTC|[+-]\d\d:?\d\d))?", re.ASCII)
# 2024/03/05, 05.03.2024 or 3/5/24 before a time of day; a date by itself with the year first, or with points and a
# whole year.
_TIME_OF_DAY = r"[T ] *(\d{1,2}:\d\d(?::\d\d(?:[.,:]\d+)?)?) *([AP]\.? ?M\.?)?"
_YEAR_FIRST = re.compile(rf"(\d{{4}})[/.](\d{{1,2}})[/.](\d{{1,2}}){_TIME_OF_DAY}", re.ASCII | re.IGNORECASE)
_YEAR_LAST = re.compile(rf"(\d{{1,2}})([/.-])(\d{{1,2}})\2(\d{{4}}|\d\d){_TIME_OF_DAY}", re.ASCII | re.IGNORECASE)
_MONTHS = "jan feb mar apr may jun jul aug sep oct nov dec".split()  # noqa: SIM905
_GERMAN_MONTHS = {"mai": "may", "okt": "oct", "dez": "dec", "mrz": "mar", "mär": "mar"}
_MONTH = f"({'|'.join([*_MONTHS, *_GERMAN_MONTHS])})[a-z]*"
# 05-Mar-24 10:00:00, 5 March 2024 10:00, Mar 5, 2024 10:00
_DAY_AND_MONTH = re.compile(rf"(\d{{1,2}})[. -]+{_MONTH}[. ,-]+(\d{{4}}|\d\d){_TIME_OF_DAY}", re.IGNORECASE)
_MONTH_AND_DAY = re.compile(rf"{_MONTH}[. -]+(\d{{1,2}})[ ,-]+(\d{{4}}){_TIME_OF_DAY}", re.IGNORECASE)
_SLASHED_DATE = re.compile(r"(\d{4})[/.](\d{1,2})[/.](\d{1,2})", re.ASCII)
_POINTED_DATE = re.compile(r"\d{1,2}\.\d{1,2}\.\d{4}", re.ASCII)
_CLOCK = re.compile(r"\d{1,2}:\d\d:\d\d([.,]\d+)?", re.ASCII)
_COLON_SHARE = re.compile(r"(:\d\d:\d\d):(\d+)", re.ASCII)  # 10:11:12:345 with milliseconds
_MINUTES = re.compile(r"(\d{1,3}):([0-5]\d[.,]\d+)", re.ASCII)  # mm:ss.0, as a spreadsheet shows short times
_DURATION = re.compile(r"(-?\d+) days?,? \+?(\d{1,2}):(\d\d):(\d\d(?:[.,]\d+)?)", re.ASCII)  # as pandas writes them
# What a spreadsheet runs: signs of formulas, also the wide ones; an apostrophe before them says that they are text.
FORMULA = re.compile("'*[=+\\-@\uff1d\uff0b\uff0d\uff20]")
_STAMPS = (
    _DATE_TIME, _CLOCK, _YEAR_LAST, _YEAR_FIRST, _POINTED_DATE, _SLASHED_DATE, _MINUTES, _DURATION, _DAY_AND_MONTH,
    _MONTH_AND_DAY,
)  # fmt: skip


_DIGITS = r"(?:\d[\d.,]*|[.,]\d+)(?:[eE][+-]?\d+)?"
_BRACKETED = re.compile(rf"\(\s*({_DIGITS})\s*\)", re.ASCII)
# A single letter needs a blank before it: 1A and 2A are names of something.
_WITH_UNIT = re.compile(rf"([+-]?{_DIGITS})(?:\s+([^\W\d_]\S*(?: \S+)?|[%°][CF]?)|([^\W\d_]{{2,}}|[%°][CF]?))")
# Units of cells that no table converts.
_CELL_UNITS = frozenset(["%", "°C", "°F", "rpm", "L/min", "l/min", "m3/h", "m³/h", "m/s", "mm/s", "kg", "W", "kW"])
_TWO_MARKS = re.compile(r"[+-]?\d{1,3}(?:(?:\.\d{3}){2,}|(?:,\d{3}){2,})", re.ASCII)
_GROUPS = {mark: re.compile(rf"[+-]?[1-9]\d{{0,2}}(?:{re.escape(mark)}\d{{3}})+", re.ASCII) for mark in ".,"}
_OTHER = {".": ",", ",": "."}
_NAMES = {".": "points", ",": "commas"}
LARGE = 100.0  # whole numbers up to 999 beside 1.017: read as decimals, the column would leap from 999 to 1


def number(cell: str) -> float | None:
    """Value of a cell with a decimal point; NaN for a missing one, None for text.

    Stricter than ``float``: no underscores, no digits of other scripts.

    Examples
    --------
    >>> number(" 1.5e3 "), number("1_000"), number("NaN")
    (1500.0, None, nan)
    """
    text = cell.strip()
    if _NUMBER.fullmatch(text):
        return float(text.replace("d", "e").replace("D", "e"))
    if _THOUSANDS_BLANK.fullmatch(text) and "," not in text:  # 1 234.5 with a narrow blank, 1'234.5
        return float(_without_blanks(text))
    low = text.lower()
    if low in MISSING:
        return nan
    return nan if low in _INFINITE else None


def _without_blanks(text: str) -> str:
    return re.sub("[\u00a0\u202f\u2009'\u2019]", "", text)


def comma_number(cell: str) -> float | None:
    """Value of a cell with a decimal comma, and perhaps points between thousands.

    Examples
    --------
    >>> comma_number("1,5"), comma_number("1.234,5"), comma_number("2"), comma_number("a")
    (1.5, 1234.5, 2.0, None)
    """
    text = cell.strip()
    if _THOUSANDS_BLANK.fullmatch(text):
        text = _without_blanks(text)
    if _COMMA_NUMBER.fullmatch(text):
        return number(text.replace(",", "."))
    if _THOUSANDS_POINT.fullmatch(text):
        return number(text.replace(".", "").replace(",", "."))
    if _THOUSANDS_COMMA.fullmatch(text):
        return number(text.replace(",", ""))
    return number(text)


def unescaped(cell: str) -> str:
    """Text of a cell without the apostrophe that keeps spreadsheets from running it as a formula.

    Examples
    --------
    >>> unescaped("'=1+1"), unescaped("'tis")
    ('=1+1', "'tis")
    """
    return cell[1:] if cell.startswith("'") and FORMULA.match(cell) else cell


def is_data(cell: str) -> bool:
    """Whether a cell holds a number or a date-time: something a header does not.

    Examples
    --------
    >>> is_data("1,5"), is_data("2024-05-01 12:00:00"), is_data(""), is_data("time")
    (True, True, False, False)
    """
    value = comma_number(cell)
    return value == value if value is not None else is_date_time(cell)


def is_date_time(cell: str) -> bool:
    """Whether a cell is a date, date-time or time of day: ISO, with the year first, or with the year last."""
    text = cell.strip()
    return not _NUMBER.fullmatch(text) and any(pattern.fullmatch(text) for pattern in _STAMPS)


def parse_numbers(cells: Sequence[str], decimal_comma: bool) -> tuple[Array, int]:
    """Numbers of a column, NaN where there are none, and how many cells held text instead."""
    joined = "".join(cells)
    # float() also takes underscores and the digits of other scripts; plain cells may go the quick way.
    if joined.isascii() and "_" not in joined and not decimal_comma:
        with suppress(ValueError):
            return np.array(list(map(float, cells)), dtype=np.float64), 0
    convert = comma_number if decimal_comma else number
    values = [convert(cell) for cell in cells]
    bad = values.count(None)
    return np.array([nan if value is None else value for value in values], dtype=np.float64), bad


def parse_date_times(cells: Sequence[str], order: str | None = None) -> Array:
    """Seconds since 1970 (or since midnight for a time of day), NaN where a cell is no date-time.

    Where the year stands last, day or month may come first: as `order` says, by default as `date_order` finds.

    Examples
    --------
    >>> parse_date_times(["1970-01-01T00:01:00Z", "x", "01.02.1970 00:00:00,5"]).tolist()
    [60.0, nan, 2678400.5]
    """
    order = order or date_order(cells)[0]
    return np.array([_seconds(cell, order) for cell in cells], dtype=np.float64)


def date_order(cells: Sequence[str]) -> tuple[str, bool]:
    """Whether dates such as 03/05/2024 have the day or the month first, and whether that had to be assumed.

    Points mean day first, AM and PM month first. Otherwise a number above 12 decides, then the order in which time
    runs evenly forward; failing that, slashes mean month first and dashes day first. Nothing is assumed
    where both orders give the same times from the first sample on.

    Examples
    --------
    >>> date_order(["05.03.2024 12:00"]), date_order(["03/25/2024 12:00"]), date_order(["03/05/2024 12:00"])
    (('day', False), ('month', False), ('month', False))
    """
    dates = {match.group(1, 2, 3, 6) for match in map(_YEAR_LAST.fullmatch, map(str.strip, cells)) if match}
    if not dates or any(mark == "." for _, mark, _, _ in dates):
        return "day", False
    if any(half and "." not in half for _, _, _, half in dates):  # a. m. is Spanish
        return "month", False
    first, second = (max(int(date[k]) for date in dates) for k in (0, 2))
    if first > 12 or second > 12:
        return ("day" if first > 12 else "month"), False
    usual, other = ("month", "day") if any(mark == "/" for _, mark, _, _ in dates) else ("day", "month")
    if len({date[:3] for date in dates}) == 1:
        return usual, False
    spans = [_unevenness(parse_date_times(cells, order)) for order in (usual, other)]
    return (usual, True) if spans[0] == spans[1] else ((usual if spans[0] < spans[1] else other), False)


def _unevenness(t: Array) -> tuple[int, float]:
    """How often time runs backward, and its longest step: the smaller, the likelier the order of day and month."""
    step = np.diff(t[~np.isnan(t)])
    return int(np.sum(step < 0)), float(np.max(np.abs(step), initial=0.0))


def _month(word: str) -> str:
    """Number of a month by the first three letters of its name."""
    low = word.lower()
    return str(_MONTHS.index(_GERMAN_MONTHS.get(low, low)) + 1)


def _iso(text: str, order: str) -> str:
    """Spell a date with the year first or last as in ISO 8601."""
    if match := _DAY_AND_MONTH.fullmatch(text):
        day, word, year, clock, half = match.groups()
        month = _month(word)
    elif match := _MONTH_AND_DAY.fullmatch(text):
        word, day, year, clock, half = match.groups()
        month = _month(word)
    elif match := _YEAR_FIRST.fullmatch(text):
        year, month, day, clock, half = match.groups()
    elif match := _YEAR_LAST.fullmatch(text):
        one, _, two, year, clock, half = match.groups()
        day, month = (one, two) if order == "day" else (two, one)
    elif match := _SLASHED_DATE.fullmatch(text):
        year, month, day = match.groups()
        clock, half = "00:00", None
    elif _POINTED_DATE.fullmatch(text):
        day, month, year = text.split(".")
        clock, half = "00:00", None
    else:
        return text
    hour, _, rest = clock.partition(":")
    if half:
        hour = str(int(hour) % 12 + (12 if half[0] in "Pp" else 0))
    return f"{year if len(year) == 4 else '20' + year}-{month:0>2}-{day:0>2}T{hour:0>2}:{rest}"


def _seconds(cell: str, order: str) -> float:
    if short := _MINUTES.fullmatch(cell.strip()):
        return 60.0 * int(short[1]) + float(short[2].replace(",", "."))
    if lasting := _DURATION.fullmatch(cell.strip()):
        days, hours, minutes = (int(lasting[k]) for k in (1, 2, 3))
        return 86400.0 * days + 3600.0 * hours + 60.0 * minutes + float(lasting[4].replace(",", "."))
    text = (
        _COLON_SHARE.sub(r"\1.\2", _iso(cell.strip(), order)).replace(",", ".").replace("UTC", "Z").replace(" Z", "Z")
    )
    if _CLOCK.fullmatch(text):
        text = f"1970-01-01T{text.zfill(len(text) + (text.index(':') == 1))}"
    try:
        moment = datetime.fromisoformat(text)
        if moment.tzinfo is None:
            moment = moment.replace(tzinfo=UTC)
        return moment.timestamp()
    except (ValueError, OverflowError):
        return nan


def is_dressed(cell: str) -> bool:
    """Whether a cell holds a number in brackets, with a unit, or with two or more separators of thousands.

    Examples
    --------
    >>> [is_dressed(cell) for cell in ("(3.21)", "1,2 bar", "1.234.567", "3.21", "1A", "OFF")]
    [True, True, True, False, False, False]
    """
    text = cell.strip()
    return bool(_BRACKETED.fullmatch(text) or _TWO_MARKS.fullmatch(text)) or with_unit(text) is not None


def with_unit(cell: str) -> tuple[str, str] | None:
    """Number and unit of a cell, or None if it does not hold both.

    Examples
    --------
    >>> with_unit("1,2 bar"), with_unit("20°"), with_unit("3 pigs")
    (('1,2', 'bar'), ('20', 'deg'), None)
    """
    match = _WITH_UNIT.fullmatch(cell)
    text = (match[2] or match[3]) if match else ""
    unit = text if text in _CELL_UNITS else canonical(text)
    return (match[1], unit) if match and unit else None


def undress_units(column: str, cells: Sequence[str], findings: list[Finding]) -> tuple[list[str], str] | None:
    """Cells without their unit, and that unit; None unless all that are not missing carry the same one."""
    filled = [with_unit(cell) for cell in cells if cell.lower() not in MISSING]
    units = {pair[1] if pair else "" for pair in filled}
    if len(units) != 1 or "" in units:
        return None
    unit = units.pop()
    findings.append(
        Finding(
            "unit-in-cells",
            f"every number in column '{column}' carries its unit, {unit}; it was taken from there. Nothing to do.",
        )
    )
    return [pair[0] if (pair := with_unit(cell)) else cell for cell in cells], unit


def undress_negatives(column: str, cells: Sequence[str], rows: Rows, findings: list[Finding]) -> list[str]:
    """Cells with (3.21) as -3.21, where that is all the brackets can mean: no other text, and no minus sign."""
    where = [k for k, cell in enumerate(cells) if cell.startswith("(")]
    plain = [comma_number(cell) for cell in cells if not cell.startswith("(")]
    whole = all(_BRACKETED.fullmatch(cells[k]) for k in where)
    if not where or not whole or not any(value == value for value in plain) or any(v is None or v < 0 for v in plain):
        return list(cells)
    bare = [f"-{cell[1:-1].strip()}" if cell.startswith("(") else cell for cell in cells]
    findings.append(
        Finding(
            "bracketed-negatives",
            f"numbers in brackets in column '{column}' were read as negative ({cells[where[0]]} is {bare[where[0]]}), "
            f"as in accounting: {list_rows(rows[where])}. The column has no minus sign and no other text. If they mean "
            f"something else, save the log without them.",
        )
    )
    return bare


def text_refusal(column: str, log: str, cells: Sequence[str], rows: Rows) -> str:
    """Why a column with much text among its numbers is not read, with two examples."""
    where = [k for k, cell in enumerate(cells) if comma_number(cell) is None]
    kinds = {cells[k]: k for k in reversed(where)}
    examples = " and ".join(f"{cells[k][:30]!r} ({list_rows(rows[[k]])})" for k in sorted(kinds.values())[:2])
    filled = sum(bool(cell) for cell in cells)
    return (
        f"column '{column}' of {log} {HOLDS_TEXT} {len(where)} of {filled} cells, such as {examples}. Without these "
        f"rows much of the loop would be lost, so it is not read. Write them as plain numbers, or empty the cells in "
        f"which nothing was measured."
    )


@dataclass(frozen=True)
class Marks:
    """How the numbers of one column use points and commas."""

    groups: dict[str, list[int]]  # mark -> cells that may be whole numbers with it between thousands (1.017)
    decimals: frozenset[str]  # marks that some cell can only use as a decimal sign (0.5, or the comma in 1.017,5)
    separators: frozenset[str]  # marks that some cell can only use between thousands (1.234.567, or the point there)

    def without(self, cells: Sequence[str], mark: str) -> list[str]:
        """Cells of the column without the marks between thousands."""
        grouped = set(self.groups[mark])
        return [cell.replace(mark, "") if position in grouped else cell for position, cell in enumerate(cells)]


def marks_of(cells: Sequence[str]) -> Marks:
    """Look at every number of a column that holds a point or a comma; text is passed over.

    Examples
    --------
    >>> marks = marks_of(["999", "1.017", "0,5", "text, or so"])
    >>> marks.groups["."], sorted(marks.decimals), sorted(marks.separators)
    ([1], [','], [])
    """
    groups: dict[str, list[int]] = {".": [], ",": []}
    decimals: set[str] = set()
    separators: set[str] = set()
    for position, cell in enumerate(cells):
        used = [mark for mark in ".," if mark in cell]
        if not used:
            continue
        mark = used[0]
        if len(used) == 1 and _GROUPS[mark].fullmatch(cell):
            groups[mark].append(position)
            separators.update(used if cell.count(mark) > 1 else [])
        elif (len(used) > 1 or mark not in decimals) and comma_number(cell) is not None:
            last = max(used, key=cell.rindex)
            decimals.add(last)
            separators.update(set(used) - {last})
    return Marks(groups, frozenset(decimals), frozenset(separators))


def separator_of(cells: Sequence[str], marks: Marks, decimals: frozenset[str]) -> tuple[str, bool]:
    """Mark that may separate the thousands of a column, ``""`` if there is none, and whether that is certain.

    `decimals` are the decimal signs that are certain anywhere in the log.

    Examples
    --------
    >>> def ask(*cells):
    ...     return separator_of(cells, marks_of(cells), frozenset(","))
    >>> ask("998", "999", "1.017"), ask("2.998", "3.169"), ask("0.998", "1.017")
    (('.', True), ('.', False), ('', False))
    """
    for mark in ".,":
        asked = _OTHER[mark] in decimals or mark in marks.separators
        if not marks.groups[mark] or not asked:
            continue
        if mark in marks.decimals:
            # 0.998 beside 1.017: decimals, unless another cell contradicts that.
            if marks.separators or _OTHER[mark] in marks.decimals:
                return mark, False
            continue
        return mark, mark in marks.separators or _is_continued(cells, marks.groups[mark])
    return "", False


def _is_continued(cells: Sequence[str], groups: Sequence[int]) -> bool:
    """Whether numbers below a thousand stand without the mark, and could not stand beside decimals like these.

    A logger that drops the zeros of 5.000 writes 5.020 as 5.02; if a group ends in 0, it drops none.
    """
    grouped = set(groups)
    values = [comma_number(cell) for position, cell in enumerate(cells) if position not in grouped]
    plain = [abs(value) for value in values if value is not None and value == value]
    if not plain or max(plain) >= 1000:
        return False
    return max(plain) >= LARGE or any(cells[position].endswith("0") for position in groups)


def thousands_finding(column: str, cells: Sequence[str], marks: Marks, mark: str, rows: Rows) -> Finding:
    """What was read, and where."""
    where = marks.groups[mark]
    cell = cells[where[0]]
    return Finding(
        "thousands-separator",
        f"{_NAMES[mark]} in column '{column}' were read as separators of thousands ({cell} is "
        f"{cell.replace(mark, '')}): {list_rows(rows[where])}. The numbers without one lie below 1000, or some have "
        f"two. If they are decimal signs, save the log with one decimal sign throughout.",
    )


def thousands_refusal(column: str, log: str, cells: Sequence[str], marks: Marks, mark: str, rows: Rows) -> str:
    """Both readings of a column that can be read in two ways, and the way out."""
    where = marks.groups[mark]
    cell, other = cells[where[0]], _OTHER[mark]
    return (
        f"column '{column}' of {log} can be read in two ways: {cell} ({list_rows(rows[where])}) is "
        f"{cell.replace(mark, '')} if its {_NAMES[mark]} separate thousands, and {cell.replace(mark, '.')} if they are "
        f"decimal signs; elsewhere the log uses {_NAMES[other]} for that. The readings differ by a factor of 1000, so "
        f"none was chosen. Save the column without separators ({cell.replace(mark, '')}), or with the decimal sign of "
        f"the other numbers ({cell.replace(mark, other)})."
    )
