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
from dehyst.io._policy import POLICY
from dehyst.io._table import list_rows
from dehyst.units import canonical

MISSING = frozenset(
    "nan na n/a #n/a null none nil - -- ? missing -nan +nan nan(ind) -nan(ind) 1.#qnan -1.#ind 1.#ind #nan nat".split()  # noqa: SIM905
) | {""}
_NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eEdD][+-]?\d+)?", re.ASCII)
_COMMA_NUMBER = re.compile(r"[+-]?(?:\d+,\d*|,\d+)(?:[eEdD][+-]?\d+)?", re.ASCII)
_THOUSANDS_POINT = re.compile(r"[+-]?\d{1,3}(?:\.\d{3})+,\d*", re.ASCII)
_THOUSANDS_COMMA = re.compile(r"[+-]?\d{1,3}(?:,\d{3})+\.\d*", re.ASCII)
_THOUSANDS_BLANK = re.compile(
    r"[+-]?\d{1,3}(?:[\u00a0\u202f\u2009'\u2019]\d{3})+(?:[.,]\d*)?", re.ASCII
)
# Whoever reads line by line recognises by these words a refusal that does not concern it.
HOLDS_TEXT = "holds text in"
_INFINITE = frozenset(
    ["inf", "+inf", "-inf", "infinity", "+infinity", "-infinity", "1.#inf", "-1.#inf"]
)
_DATE_TIME = re.compile(
    r"\d{4}-\d\d-\d\d([T ]\d\d:\d\d(:\d\d([.,:]\d+)?)?)?( ?(Z|UTC|[+-]\d\d:?\d\d))?", re.ASCII
)
# 2024/03/05, 05.03.2024 or 3/5/24 before a time of day; a date by itself with the year first, or with points and a
# whole year.
_TIME_OF_DAY = r"[T ] *(?P<clock>\d{1,2}:\d\d(?::\d\d(?:[.,:]\d+)?)?) *(?P<half>[AP]\.? ?M\.?)?"
_SLASHED = r"(?P<year>\d{4})[/.](?P<month>\d{1,2})[/.](?P<day>\d{1,2})"
_YEAR_FIRST = re.compile(rf"{_SLASHED}{_TIME_OF_DAY}", re.ASCII | re.IGNORECASE)
_YEAR_LAST = re.compile(
    rf"(?P<day>\d{{1,2}})([/.-])(?P<month>\d{{1,2}})\2(?P<year>\d{{4}}|\d\d){_TIME_OF_DAY}",
    re.ASCII | re.IGNORECASE,
)
_MONTHS = "jan feb mar apr may jun jul aug sep oct nov dec".split()  # noqa: SIM905
_GERMAN_MONTHS = {"mai": "may", "okt": "oct", "dez": "dec", "mrz": "mar", "mär": "mar"}
_MONTH = f"(?P<month>{'|'.join([*_MONTHS, *_GERMAN_MONTHS])})[a-z]*"
# 05-Mar-24 10:00:00, 5 March 2024 10:00, Mar 5, 2024 10:00
_DAY_AND_MONTH = re.compile(
    rf"(?P<day>\d{{1,2}})[. -]+{_MONTH}[. ,-]+(?P<year>\d{{4}}|\d\d){_TIME_OF_DAY}", re.IGNORECASE
)
_MONTH_AND_DAY = re.compile(
    rf"{_MONTH}[. -]+(?P<day>\d{{1,2}})[ ,-]+(?P<year>\d{{4}}){_TIME_OF_DAY}", re.IGNORECASE
)
_SLASHED_DATE = re.compile(_SLASHED, re.ASCII)
_POINTED_DATE = re.compile(r"(?P<day>\d{1,2})\.(?P<month>\d{1,2})\.(?P<year>\d{4})", re.ASCII)
# Tried in this order; all but `_YEAR_LAST` have one meaning.
_DATES = (_DAY_AND_MONTH, _MONTH_AND_DAY, _YEAR_FIRST, _YEAR_LAST, _SLASHED_DATE, _POINTED_DATE)
_CLOCK = re.compile(r"\d{1,2}:\d\d:\d\d([.,]\d+)?", re.ASCII)
_COLON_SHARE = re.compile(r"(:\d\d:\d\d):(\d+)", re.ASCII)  # 10:11:12:345 with milliseconds
# mm:ss.0, as a spreadsheet shows short times
_MINUTES = re.compile(r"(\d{1,3}):([0-5]\d[.,]\d+)", re.ASCII)
# Durations as pandas writes them.
_DURATION = re.compile(r"(-?\d+) days?,? \+?(\d{1,2}):(\d\d):(\d\d(?:[.,]\d+)?)", re.ASCII)
# What a spreadsheet runs: signs of formulas, also the wide ones; an apostrophe before them says that they are text.
FORMULA = re.compile("'*[=+\\-@\uff1d\uff0b\uff0d\uff20]")
_STAMPS = (_DATE_TIME, _CLOCK, *reversed(_DATES), _MINUTES, _DURATION)


_DIGITS = r"(?:\d[\d.,]*|[.,]\d+)(?:[eE][+-]?\d+)?"
_BRACKETED = re.compile(rf"\(\s*({_DIGITS})\s*\)", re.ASCII)
# A single letter needs a blank before it: 1A and 2A are names of something.
_WITH_UNIT = re.compile(
    rf"([+-]?{_DIGITS})(?:\s+([^\W\d_]\S*(?: \S+)?|[%°][CF]?)|([^\W\d_]{{2,}}|[%°][CF]?))"
)
# Units of cells that no table converts.
_CELL_UNITS = frozenset(
    ["%", "°C", "°F", "rpm", "L/min", "l/min", "m3/h", "m³/h", "m/s", "mm/s", "kg", "W", "kW"]
)
_TWO_MARKS = re.compile(r"[+-]?\d{1,3}(?:(?:\.\d{3}){2,}|(?:,\d{3}){2,})", re.ASCII)
_GROUPS = {
    ".": re.compile(r"[+-]?[1-9]\d{0,2}(?:\.\d{3})+", re.ASCII),
    ",": re.compile(r"[+-]?[1-9]\d{0,2}(?:,\d{3})+", re.ASCII),
}
_OTHER = {".": ",", ",": "."}
_NAMES = {".": "points", ",": "commas"}


def cell_number(cell: str) -> float | None:
    """Value of a cell with a decimal point; NaN for a missing one, None for text.

    Stricter than ``float``: no underscores, no digits of other scripts.

    Examples
    --------
    >>> cell_number(" 1.5e3 "), cell_number("1_000"), cell_number("NaN")
    (1500.0, None, nan)
    """
    text = cell.strip()
    if _NUMBER.fullmatch(text):
        return float(text.replace("d", "e").replace("D", "e"))
    if _THOUSANDS_BLANK.fullmatch(text) and "," not in text:  # 1 234.5 with a narrow blank, 1'234.5
        return float(_without_blanks(text))
    low = text.lower()
    if low in MISSING or low in _INFINITE:
        return nan
    return None


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
        return cell_number(text.replace(",", "."))
    if _THOUSANDS_POINT.fullmatch(text):
        return cell_number(text.replace(".", "").replace(",", "."))
    if _THOUSANDS_COMMA.fullmatch(text):
        return cell_number(text.replace(",", ""))
    return cell_number(text)


def unescaped(cell: str) -> str:
    """Text of a cell without the apostrophe that keeps spreadsheets from running it as a formula.

    Examples
    --------
    >>> unescaped("'=1+1"), unescaped("'tis")
    ('=1+1', "'tis")
    """
    if cell.startswith("'") and FORMULA.match(cell):
        return cell[1:]
    return cell


def is_data(cell: str) -> bool:
    """Whether a cell holds a number or a date-time: something a header does not.

    Examples
    --------
    >>> is_data("1,5"), is_data("2024-05-01 12:00:00"), is_data(""), is_data("time")
    (True, True, False, False)
    """
    value = comma_number(cell)
    if value is None:
        return is_date_time(cell)
    return value == value  # NaN stands for a missing one


def is_date_time(cell: str) -> bool:
    """Whether a cell is a date, date-time or time of day: ISO, with the year first, or with the year last."""
    text = cell.strip()
    if _NUMBER.fullmatch(text):
        return False
    return any(pattern.fullmatch(text) for pattern in _STAMPS)


def are_dates(filled: Sequence[str]) -> bool:
    """Whether most of some cells, none of them empty, are dates or times of day."""
    return sum(map(is_date_time, filled)) > 0.5 * len(filled)


def parse_numbers(cells: Sequence[str], decimal_comma: bool) -> tuple[Array, int]:
    """Numbers of a column, NaN where there are none, and how many cells held text instead."""
    joined = "".join(cells)
    # float() also takes underscores and the digits of other scripts; plain cells may go the quick way.
    if joined.isascii() and "_" not in joined and not decimal_comma:
        with suppress(ValueError):
            return np.array(list(map(float, cells)), dtype=np.float64), 0
    convert = cell_number
    if decimal_comma:
        convert = comma_number
    values = list(map(convert, cells))
    # None becomes NaN in an array of floats.
    return np.array(values, dtype=np.float64), values.count(None)


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


def seconds_of_dates(cells: Sequence[str], name: str, findings: list[Finding]) -> tuple[Array, str]:
    """Seconds of a column of dates, and whether the day or the month comes first; an assumption is a finding."""
    order, assumed = date_order(cells)
    if assumed:
        findings.append(
            Finding(
                "date-order",
                f"dates in column '{name}', such as {cells[0].strip()}, were read with the {order} first; nothing in "
                f"the log tells. If that is wrong, log dates as 2024-05-01 12:00:00.",
            )
        )
    return parse_date_times(cells, order), order


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
    dates: set[tuple[str, str, str]] = set()
    halves: set[str] = set()
    for cell in cells:
        if match := _YEAR_LAST.fullmatch(cell.strip()):
            dates.add((match[1], match[2], match[3]))
            halves.add(match[6] or ".")
    if not dates:
        return "day", False
    left, marks, right = map(set, zip(*dates, strict=True))
    if "." in marks:
        return "day", False
    if not all("." in half for half in halves):  # a. m. is Spanish
        return "month", False

    # Only days lie above 12.
    if max(map(int, left)) > 12:
        return "day", False
    if max(map(int, right)) > 12:
        return "month", False

    usual, unusual = "day", "month"
    if "/" in marks:
        usual, unusual = unusual, usual
    if len(dates) == 1:
        return usual, False
    as_usual = _unevenness(parse_date_times(cells, usual))
    as_unusual = _unevenness(parse_date_times(cells, unusual))
    if as_unusual < as_usual:
        return unusual, False
    return usual, as_usual == as_unusual


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
    for pattern in _DATES:
        match = pattern.fullmatch(text)
        if match:
            break
    else:
        return text
    parts = match.groupdict()
    year, month, day = parts["year"], parts["month"], parts["day"]
    if pattern is _YEAR_LAST and order == "month":
        day, month = month, day
    if not month.isdigit():
        month = _month(month)
    hour, _, minutes = parts.get("clock", "00:00").partition(":")
    half = parts.get("half")
    if half:
        hour = str(int(hour) % 12 + 12 * (half[0] in "Pp"))
    if len(year) == 2:
        year = f"20{year}"
    return f"{year}-{month:0>2}-{day:0>2}T{hour:0>2}:{minutes}"


def _seconds(cell: str, order: str) -> float:
    if short := _MINUTES.fullmatch(cell.strip()):
        return 60.0 * int(short[1]) + float(short[2].replace(",", "."))
    if lasting := _DURATION.fullmatch(cell.strip()):
        days, hours, minutes = map(int, lasting.group(1, 2, 3))
        seconds = float(lasting[4].replace(",", "."))
        return 86400.0 * days + 3600.0 * hours + 60.0 * minutes + seconds
    text = _COLON_SHARE.sub(r"\1.\2", _iso(cell.strip(), order))
    text = text.replace(",", ".").replace("UTC", "Z").replace(" Z", "Z")
    if _CLOCK.fullmatch(text):
        # ISO wants two digits of the hour.
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
    if _BRACKETED.fullmatch(text) or _TWO_MARKS.fullmatch(text):
        return True
    return cell_with_unit(text) is not None


def cell_with_unit(cell: str) -> tuple[str, str] | None:
    """Number and unit of a cell, or None if it does not hold both.

    Examples
    --------
    >>> cell_with_unit("1,2 bar"), cell_with_unit("20°"), cell_with_unit("3 pigs")
    (('1,2', 'bar'), ('20', 'deg'), None)
    """
    match = _WITH_UNIT.fullmatch(cell)
    if match is None:
        return None
    unit = match[2] or match[3]
    if unit in _CELL_UNITS:
        return match[1], unit
    known_unit = canonical(unit)
    if not known_unit:
        return None
    return match[1], known_unit


def undress_units(
    column: str, cells: Sequence[str], findings: list[Finding]
) -> tuple[list[str], str] | None:
    """Cells without their unit, and that unit; None unless all that are not missing carry the same one."""
    bare: list[str] = []
    units: set[str] = set()
    for cell in cells:
        pair = cell_with_unit(cell)
        if pair is not None:
            bare.append(pair[0])
            units.add(pair[1])
        elif cell.lower() in MISSING:
            bare.append(cell)
        else:
            return None
    if len(units) != 1:
        return None
    unit = units.pop()
    findings.append(
        Finding(
            "unit-in-cells",
            f"every number in column '{column}' carries its unit, {unit}; it was taken from there. Nothing to do.",
        )
    )
    return bare, unit


def undress_negatives(
    column: str, cells: Sequence[str], rows: Rows, findings: list[Finding]
) -> list[str]:
    """Cells with (3.21) as -3.21, where that is all the brackets can mean: no other text, and no minus sign."""
    bare = list(cells)
    in_brackets: list[int] = []
    is_measured = False
    for k, cell in enumerate(cells):
        if cell.startswith("("):
            if not _BRACKETED.fullmatch(cell):
                return list(cells)
            in_brackets.append(k)
            bare[k] = f"-{cell[1:-1].strip()}"
            continue
        value = comma_number(cell)
        if value is None or value < 0:
            return list(cells)
        is_measured |= value == value
    if not in_brackets or not is_measured:
        return list(cells)
    first = in_brackets[0]
    message = (
        f"numbers in brackets in column '{column}' were read as negative ({cells[first]} is {bare[first]}), as in "
        f"accounting: {list_rows(rows[in_brackets])}. The column has no minus sign and no other text. If they mean "
        f"something else, save the log without them."
    )
    findings.append(Finding("bracketed-negatives", message))
    return bare


def text_refusal(column: str, log: str, cells: Sequence[str], rows: Rows) -> str:
    """Why a column with much text among its numbers is not read, with two examples."""
    count = 0
    first_rows: dict[str, int] = {}
    for k, cell in enumerate(cells):
        if comma_number(cell) is None:
            count += 1
            first_rows.setdefault(cell, k)
    examples: list[str] = []
    for cell, k in list(first_rows.items())[:2]:
        examples.append(f"{cell[:30]!r} ({list_rows(rows[[k]])})")
    filled = sum(map(bool, cells))
    return (
        f"column '{column}' of {log} {HOLDS_TEXT} {count} of {filled} cells, such as {' and '.join(examples)}. "
        f"Without these rows much of the loop would be lost, so it is not read. Write them as plain numbers, or empty "
        f"the cells in which nothing was measured."
    )


@dataclass(frozen=True)
class Marks:
    """How the numbers of one column use points and commas."""

    # mark -> cells that may be whole numbers with it between thousands (1.017)
    groups: dict[str, list[int]]
    # marks that some cell can only use as a decimal sign (0.5, or the comma in 1.017,5)
    decimals: frozenset[str]
    # marks that some cell can only use between thousands (1.234.567, or the point there)
    separators: frozenset[str]

    def without(self, cells: Sequence[str], mark: str) -> list[str]:
        """Cells of the column without the marks between thousands."""
        bare = list(cells)
        for position in self.groups[mark]:
            bare[position] = bare[position].replace(mark, "")
        return bare


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
        # Of two marks in one number the last is the decimal sign.
        last = max(".,", key=cell.rfind)
        if last not in cell:
            continue
        both = _OTHER[last] in cell
        if not both and _GROUPS[last].fullmatch(cell):
            groups[last].append(position)
            if cell.count(last) > 1:
                separators.add(last)
        elif (both or last not in decimals) and comma_number(cell) is not None:
            decimals.add(last)
            if both:
                separators.add(_OTHER[last])
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
    largest = -1.0
    for position, cell in enumerate(cells):
        value = None
        if position not in grouped:
            value = comma_number(cell)
        if value is not None and value == value:
            largest = max(largest, abs(value))
    if largest < 0.0 or largest >= 1000:
        return False
    return largest >= POLICY.thousands_from or any(
        cells[position].endswith("0") for position in groups
    )


def thousands_finding(
    column: str, cells: Sequence[str], marks: Marks, mark: str, rows: Rows
) -> Finding:
    """What was read, and where."""
    grouped = marks.groups[mark]
    cell = cells[grouped[0]]
    return Finding(
        "thousands-separator",
        f"{_NAMES[mark]} in column '{column}' were read as separators of thousands ({cell} is "
        f"{cell.replace(mark, '')}): {list_rows(rows[grouped])}. The numbers without one lie below 1000, or some have "
        f"two. If they are decimal signs, save the log with one decimal sign throughout.",
    )


def thousands_refusal(
    column: str, log: str, cells: Sequence[str], marks: Marks, mark: str, rows: Rows
) -> str:
    """Both readings of a column that can be read in two ways, and the way out."""
    grouped = marks.groups[mark]
    cell = cells[grouped[0]]
    other_mark = _OTHER[mark]
    whole = cell.replace(mark, "")
    return (
        f"column '{column}' of {log} can be read in two ways: {cell} ({list_rows(rows[grouped])}) is {whole} if its "
        f"{_NAMES[mark]} separate thousands, and {cell.replace(mark, '.')} if they are decimal signs; elsewhere the "
        f"log uses {_NAMES[other_mark]} for that. The readings differ by a factor of 1000, so none was chosen. Save "
        f"the column without separators ({whole}), or with the decimal sign of the other numbers "
        f"({cell.replace(mark, other_mark)})."
    )
