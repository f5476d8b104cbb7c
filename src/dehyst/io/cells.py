"""Cells of a text log: numbers, missing values, date-times, text."""

from __future__ import annotations

import re
from collections.abc import Sequence
from contextlib import suppress
from datetime import UTC, datetime
from math import nan

import numpy as np

from dehyst.arrays import Array

MISSING = frozenset(
    "nan na n/a #n/a null none nil - -- ? missing -nan +nan nan(ind) -nan(ind) 1.#qnan -1.#ind 1.#ind #nan nat".split()  # noqa: SIM905
) | {""}
_NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eEdD][+-]?\d+)?", re.ASCII)
_COMMA_NUMBER = re.compile(r"[+-]?(?:\d+,\d*|,\d+)(?:[eEdD][+-]?\d+)?", re.ASCII)
_THOUSANDS_POINT = re.compile(r"[+-]?\d{1,3}(?:\.\d{3})+,\d*", re.ASCII)
_THOUSANDS_COMMA = re.compile(r"[+-]?\d{1,3}(?:,\d{3})+\.\d*", re.ASCII)
_INFINITE = frozenset(["inf", "+inf", "-inf", "infinity", "+infinity", "-infinity", "1.#inf", "-1.#inf"])
_DATE_TIME = re.compile(r"\d{4}-\d\d-\d\d([T ]\d\d:\d\d(:\d\d([.,]\d+)?)?)?( ?(Z|UTC|[+-]\d\d:?\d\d))?", re.ASCII)
# 2024/03/05, 05.03.2024 or 3/5/24 before a time of day; a date by itself only with points and a whole year.
_TIME_OF_DAY = r"[T ] *(\d{1,2}:\d\d(?::\d\d(?:[.,]\d+)?)?) *([AP]M)?"
_YEAR_FIRST = re.compile(rf"(\d{{4}})[/.](\d{{1,2}})[/.](\d{{1,2}}){_TIME_OF_DAY}", re.ASCII | re.IGNORECASE)
_YEAR_LAST = re.compile(rf"(\d{{1,2}})([/.-])(\d{{1,2}})\2(\d{{4}}|\d\d){_TIME_OF_DAY}", re.ASCII | re.IGNORECASE)
_POINTED_DATE = re.compile(r"\d{1,2}\.\d{1,2}\.\d{4}", re.ASCII)
_CLOCK = re.compile(r"\d{1,2}:\d\d:\d\d([.,]\d+)?", re.ASCII)
# What a spreadsheet runs: signs of formulas, also the wide ones; an apostrophe before them says that they are text.
FORMULA = re.compile("'*[=+\\-@\uff1d\uff0b\uff0d\uff20]")
_STAMPS = (_DATE_TIME, _CLOCK, _YEAR_LAST, _YEAR_FIRST, _POINTED_DATE)


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
    low = text.lower()
    if low in MISSING:
        return nan
    return nan if low in _INFINITE else None


def comma_number(cell: str) -> float | None:
    """Value of a cell with a decimal comma, and perhaps points between thousands.

    Examples
    --------
    >>> comma_number("1,5"), comma_number("1.234,5"), comma_number("2"), comma_number("a")
    (1.5, 1234.5, 2.0, None)
    """
    text = cell.strip()
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
    return any(pattern.fullmatch(text) for pattern in _STAMPS)


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

    Returns
    -------
    order : str
        ``"day"`` or ``"month"``.
    assumed : bool

    Examples
    --------
    >>> date_order(["05.03.2024 12:00"]), date_order(["03/25/2024 12:00"]), date_order(["03/05/2024 12:00"])
    (('day', False), ('month', False), ('month', False))
    """
    dates = {match.group(1, 2, 3, 6) for match in map(_YEAR_LAST.fullmatch, map(str.strip, cells)) if match}
    if not dates or any(mark == "." for _, mark, _, _ in dates):
        return "day", False
    if any(half for _, _, _, half in dates):
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


def _iso(text: str, order: str) -> str:
    """Spell a date with the year first or last as in ISO 8601."""
    if match := _YEAR_FIRST.fullmatch(text):
        year, month, day, clock, half = match.groups()
    elif match := _YEAR_LAST.fullmatch(text):
        one, _, two, year, clock, half = match.groups()
        day, month = (one, two) if order == "day" else (two, one)
    elif _POINTED_DATE.fullmatch(text):
        day, month, year = text.split(".")
        clock, half = "00:00", None
    else:
        return text
    hour, _, rest = clock.partition(":")
    if half:
        hour = str(int(hour) % 12 + (12 if half.upper() == "PM" else 0))
    return f"{year if len(year) == 4 else '20' + year}-{month:0>2}-{day:0>2}T{hour:0>2}:{rest}"


def _seconds(cell: str, order: str) -> float:
    text = _iso(cell.strip(), order).replace(",", ".").replace("UTC", "Z").replace(" Z", "Z")
    if _CLOCK.fullmatch(text):
        text = f"1970-01-01T{text.zfill(len(text) + (text.index(':') == 1))}"
    try:
        moment = datetime.fromisoformat(text)
        if moment.tzinfo is None:
            moment = moment.replace(tzinfo=UTC)
        return moment.timestamp()
    except (ValueError, OverflowError):
        return nan
