"""Cells of a text log: numbers, missing values, date-times, text."""

from __future__ import annotations

import re
from collections.abc import Sequence
from contextlib import suppress
from datetime import UTC, datetime
from math import nan

import numpy as np

from dehyst.io.table import Array

MISSING = frozenset(
    [
        "",
        "nan",
        "na",
        "n/a",
        "#n/a",
        "null",
        "none",
        "nil",
        "-",
        "--",
        "?",
        "missing",
        "-nan",
        "+nan",
        "nan(ind)",
        "-nan(ind)",
        "1.#qnan",
        "-1.#ind",
        "1.#ind",
        "#nan",
        "nat",
    ]
)
_NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eEdD][+-]?\d+)?", re.ASCII)
_COMMA_NUMBER = re.compile(r"[+-]?(?:\d+,\d*|,\d+)(?:[eEdD][+-]?\d+)?", re.ASCII)
_THOUSANDS_POINT = re.compile(r"[+-]?\d{1,3}(?:\.\d{3})+,\d*", re.ASCII)
_THOUSANDS_COMMA = re.compile(r"[+-]?\d{1,3}(?:,\d{3})+\.\d*", re.ASCII)
_INFINITE = frozenset(["inf", "+inf", "-inf", "infinity", "+infinity", "-infinity", "1.#inf", "-1.#inf"])
_DATE_TIME = re.compile(r"\d{4}-\d\d-\d\d([T ]\d\d:\d\d(:\d\d([.,]\d+)?)?)?( ?(Z|UTC|[+-]\d\d:?\d\d))?", re.ASCII)
_CLOCK = re.compile(r"\d{1,2}:\d\d:\d\d([.,]\d+)?", re.ASCII)


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
    """Whether a cell is an ISO date, date-time or time of day."""
    text = cell.strip()
    return bool(_DATE_TIME.fullmatch(text) or _CLOCK.fullmatch(text))


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


def parse_date_times(cells: Sequence[str]) -> Array:
    """Seconds since 1970 (or since midnight for a time of day), NaN where a cell is no date-time.

    Examples
    --------
    >>> parse_date_times(["1970-01-01T00:01:00Z", "x"]).tolist()
    [60.0, nan]
    """
    return np.array([_seconds(cell) for cell in cells], dtype=np.float64)


def _seconds(cell: str) -> float:
    text = cell.strip().replace(",", ".").replace("UTC", "Z").replace(" Z", "Z")
    if _CLOCK.fullmatch(text):
        text = f"1970-01-01T{text.zfill(len(text) + (text.index(':') == 1))}"
    try:
        moment = datetime.fromisoformat(text)
        if moment.tzinfo is None:
            moment = moment.replace(tzinfo=UTC)
        return moment.timestamp()
    except (ValueError, OverflowError):
        return nan
