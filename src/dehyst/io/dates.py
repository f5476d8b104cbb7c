"""Dates and times of day in two columns are joined to whole stamps; a time of day alone goes on over midnight."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array
from dehyst.findings import Finding
from dehyst.io.cells import MISSING, date_order, parse_date_times
from dehyst.io.table import Table, finite, measured
from dehyst.io.time_units import DAY, seconds_of, unit_in_name
from dehyst.units import words

_DATE = re.compile(
    r"(?:\d{1,2}([/.-])\d{1,2}\1(?:\d{4}|\d\d)|\d{4}([/.-])\d{1,2}\2\d{1,2}|(?:19|20)\d{6}"
    r"|\d{1,2}[ -][A-Za-z]{3}[ -](?:\d{4}|\d\d))",
    re.ASCII,
)
_CLOCK = re.compile(
    r"(\d{1,2})[:.h](\d\d)(?:[:.m](\d\d)(?:[.,:](\d+))?)?s?\s*([AP])?\.?(?:M\.?)?", re.ASCII | re.IGNORECASE
)
DATE_WORDS = frozenset(words("date datum fecha jour"))
CLOCK_WORDS = frozenset(words("time clock zeit uhrzeit heure hora t"))
AFTER_1973 = 1e8  # seconds: dates are later, times of day are far earlier
PROBE = 20  # cells that tell what a column of text holds
MIDNIGHT = 10.0  # usual steps: what may lie between the last row of a day and the first of the next


def join_dates(table: Table) -> Table:
    """Table in which a date and its time of day, in two columns, are both whole stamps.

    Both keep their names, and either may be named as the clock.
    """
    table = _with_long_numbers(table)
    columns, findings = dict(table.columns), list(table.findings)
    dates, clocks, halves = _dates_and_clocks(table)
    stamps = set(table.stamps)
    for clock, of_day in clocks.items():
        date = _date_of(table, clock, [*dates])
        days: Array | None = None
        if date is not None:
            half = clock in halves
            days, assumed = _days(table, date, dates.pop(date), half)
            findings += [_assumed(date, table, assumed)] if assumed else []
        # Counted from the first day: a double that counts from 1970 has no digits left for microseconds.
        whole = _over_midnight(of_day) if days is None else days - np.nanmin(days) + of_day
        for name in (clock, date):
            if name is not None:
                columns[name] = whole
                stamps.add(name)
    if not clocks:
        return table
    return replace(
        table,
        columns={name: columns[name] for name in table.order if name in columns},
        units={**table.units, **dict.fromkeys(stamps, "s")},
        labels={name: cells for name, cells in table.labels.items() if name not in columns},
        stamps=frozenset(stamps),
        findings=tuple(findings),
    )


def _with_long_numbers(table: Table) -> Table:
    """Table in which stamps that are written as one number, 20240305195959, are stamps."""
    columns = dict(table.columns)
    for name, values in table.columns.items():
        if name in table.stamps or not (DATE_WORDS | CLOCK_WORDS | {"timestamp", "datetime"}) & set(words(name)):
            continue
        values = np.where(finite(values), values, np.nan)
        days, of_day = np.floor(values / 1e6), np.mod(values, 1e6)
        midnights = _of_digits(days)
        if midnights is not None and np.all((of_day // 100 % 100 < 60) & (of_day % 100 < 60)):
            columns[name] = midnights + of_day // 1e4 * 3600.0 + of_day // 100 % 100 * 60.0 + of_day % 100
    changed = {name for name in columns if columns[name] is not table.columns[name]}
    if not changed:
        return table
    return replace(
        table,
        columns=columns,
        units={**table.units, **dict.fromkeys(changed, "s")},
        stamps=table.stamps | changed,
    )


def _dates_and_clocks(table: Table) -> tuple[dict[str, Array | None], dict[str, Array], set[str]]:
    """Columns of dates, None where they are text; columns of times of day; which of these have AM and PM."""
    dates: dict[str, Array | None] = {}
    clocks: dict[str, Array] = {}
    halves: set[str] = set()
    numbers: dict[str, Array] = {}
    for name in table.order:
        if name in table.labels and table.labels[name].size == table.rows.size:
            cells = table.labels[name]
            if _all_match(cells, _DATE) and np.isfinite(_days(table, name, None, False)[0]).any():
                dates[name] = None
            elif _all_match(cells, _CLOCK):
                clocks[name] = _of_day(cells)
                halves |= {name} if any(cell.strip()[-1:] in "mM." for cell in cells[:PROBE].tolist()) else set()
        elif name in table.stamps and table.columns[name].size == table.rows.size:
            good = measured(table.columns[name])
            if is_dates(good):
                dates[name] = table.columns[name]
            elif good.size and float(good.min()) >= 0.0 and float(good.max()) < DAY:
                clocks[name] = table.columns[name]
        elif name in table.columns and table.columns[name].size == table.rows.size:
            numbers[name] = table.columns[name]
    for name, values in numbers.items():
        if DATE_WORDS & set(words(name)) and (days := _of_digits(values)) is not None:
            dates[name] = days
    for name, values in numbers.items():
        if dates and not clocks and CLOCK_WORDS & set(words(name)):
            of_day = _digits_of_day(values)
            of_day = _restarting(table, name, dates) if of_day is None else of_day
            clocks.update({} if of_day is None else {name: of_day})
    return dates, clocks, halves


def _of_digits(values: Array) -> Array | None:
    """Midnights of dates that are written as numbers, 20240305; None if they are none."""
    good = measured(values)
    if not good.size or float(good.min()) < 19_000_101 or float(good.max()) > 21_001_231 or np.any(good % 1 != 0):
        return None
    texts = [f"{int(v)}" if v == v else "" for v in values.tolist()]
    spelled = {text: _spelled(text) + " 00:00" for text in set(texts)}
    midnights = dict(zip(spelled, parse_date_times([*spelled.values()], "day").tolist(), strict=True))
    days = np.array([midnights[text] for text in texts], dtype=np.float64)
    return days if np.isfinite(days).sum() == good.size else None


def _digits_of_day(values: Array) -> Array | None:
    """Seconds of times of day that are written as numbers, 195959; None if they are none."""
    good = measured(values)
    hours, minutes, rest = values // 10_000, values // 100 % 100, values % 100
    least = good.size >= PROBE and float(good.min()) >= 0.0 and DAY <= float(good.max()) < 240_000.0
    if not least or np.any(minutes >= 60) or np.any(rest >= 60):
        return None
    return np.asarray(hours * 3600.0 + minutes * 60.0 + rest)


def _restarting(table: Table, name: str, dates: dict[str, Array | None]) -> Array | None:
    """Seconds of a clock that begins anew with each date, and only there; None if it does not."""
    scale = seconds_of(table.units.get(name) or unit_in_name(name) or "s")
    of_day = table.columns[name] * (scale or 1.0)
    date = _date_of(table, name, [*dates])
    if scale is None or date is None or not np.isfinite(of_day).all() or of_day.min() < 0.0 or of_day.max() > DAY:
        return None
    days = _days(table, date, dates[date], False)[0]
    step = np.diff(of_day)
    against = step * -np.sign(float(np.median(step))) > 0.0
    anew = bool(against.any()) and bool(np.array_equal(against, np.diff(days) != 0.0))
    return of_day if anew else None


def is_dates(good: Array) -> bool:
    """Whether stamps are dates without a time of day."""
    return bool(good.size and float(good.min()) > AFTER_1973 and np.all(good % DAY == 0.0))


def _all_match(cells: npt.NDArray[np.str_], pattern: re.Pattern[str]) -> bool:
    """Whether a column of text holds nothing but such cells, and empty ones."""
    filled = [cell for cell in map(str.strip, cells[:PROBE].tolist()) if cell.lower() not in MISSING]
    if not filled or not all(map(pattern.fullmatch, filled)):
        return False
    return all(cell.lower() in MISSING or pattern.fullmatch(cell) for cell in map(str.strip, set(cells.tolist())))


def _of_day(cells: npt.NDArray[np.str_]) -> Array:
    """Seconds since midnight of each cell."""
    values = {cell: _seconds(cell) for cell in set(cells.tolist())}
    return np.array([values[cell] for cell in cells.tolist()], dtype=np.float64)


def _seconds(cell: str) -> float:
    match = _CLOCK.fullmatch(cell.strip())
    if match is None:
        return float("nan")
    hour, minute, second, share, half = match.groups()
    hours = int(hour) if half is None else int(hour) % 12 + (12 if half.lower() == "p" else 0)
    return hours * 3600.0 + int(minute) * 60.0 + float(f"{second or 0}.{share or 0}")


def _date_of(table: Table, clock: str, dates: list[str]) -> str | None:
    """The date beside a time of day, left of it rather than right, else the only one of the log."""
    place = table.order.index(clock)
    beside = [name for step in (-1, 1) for name in dates if table.order.index(name) == place + step]
    return beside[0] if beside else dates[0] if len(dates) == 1 else None


def _days(table: Table, name: str, days: Array | None, half: bool) -> tuple[Array, str]:
    """Midnight of each row, and which of day and month was taken first where nothing tells."""
    if days is not None:
        return days, ""
    cells = table.labels[name]
    texts = list(dict.fromkeys(cells.tolist()))
    order, assumed = date_order([f"{_spelled(text)} 00:00{' AM' if half else ''}" for text in texts])
    values = dict(
        zip(texts, parse_date_times([f"{_spelled(text)} 00:00" for text in texts], order).tolist(), strict=True)
    )
    if any(value != value for text, value in values.items() if text.strip().lower() not in MISSING):
        return np.full(cells.size, np.nan), ""  # 20.15.00 is no date
    return np.array([values[cell] for cell in cells.tolist()], dtype=np.float64), order if assumed else ""


def _spelled(text: str) -> str:
    """A date as `parse_date_times` knows it before a time of day."""
    digits = text.strip()
    if digits.isdigit() and len(digits) == 8:
        return f"{digits[:4]}/{digits[4:6]}/{digits[6:]}"
    return digits.replace("-", "/") if re.match(r"\d{4}-", digits) else digits


def _assumed(name: str, table: Table, order: str) -> Finding:
    return Finding(
        "date-order",
        f"dates in column '{name}', such as {str(table.labels[name][0]).strip()}, were read with the {order} first; "
        f"nothing in the log tells. If that is wrong, log dates as 2024-05-01.",
    )


def _over_midnight(of_day: Array) -> Array:
    """Times of day that go on where they fall, or rise where they run backward, by a day less a usual step."""
    good = np.isfinite(of_day)
    step = np.diff(of_day[good])
    usual = float(np.median(np.abs(step[step != 0.0]))) if np.any(step != 0.0) else 0.0
    left = DAY - np.abs(step)
    turns = np.where((left <= MIDNIGHT * usual) & (np.abs(step) > DAY / 2), -np.sign(step), 0.0)
    whole = of_day.copy()
    whole[good] += DAY * np.concatenate(([0.0], np.cumsum(turns)))
    return whole
