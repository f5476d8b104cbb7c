"""Dates and times of day in two columns are joined to whole stamps; a time of day alone goes on over midnight."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array
from dehyst.findings import Finding
from dehyst.io._cells import MISSING, date_order, parse_date_times
from dehyst.io._policy import POLICY
from dehyst.io._table import LogTable, finite, measured
from dehyst.io._time_units import DAY, seconds_of, unit_in_name
from dehyst.units import words

_DATE = re.compile(
    r"(?:\d{1,2}([/.-])\d{1,2}\1(?:\d{4}|\d\d)|\d{4}([/.-])\d{1,2}\2\d{1,2}|(?:19|20)\d{6}"
    r"|\d{1,2}[ -][A-Za-z]{3}[ -](?:\d{4}|\d\d))",
    re.ASCII,
)
_CLOCK = re.compile(
    r"(\d{1,2})[:.h](\d\d)(?:[:.m](\d\d)(?:[.,:](\d+))?)?s?\s*([AP])?\.?(?:M\.?)?",
    re.ASCII | re.IGNORECASE,
)
DATE_WORDS = frozenset(words("date datum fecha jour"))
CLOCK_WORDS = frozenset(words("time clock zeit uhrzeit heure hora t"))
STAMP_WORDS = DATE_WORDS | CLOCK_WORDS | {"timestamp", "datetime"}
AFTER_1973 = 1e8  # seconds: dates are later, times of day are far earlier
PROBE = 20  # cells that tell what a column of text holds


def join_dates(table: LogTable) -> LogTable:
    """Table in which a date and its time of day, in two columns, are both whole stamps.

    Both keep their names, and either may be named as the clock.
    """
    table = _with_long_numbers(table)
    columns, findings = dict(table.columns), list(table.findings)
    dates, clocks, halves = _dates_and_clocks(table)
    stamps = set(table.stamps)
    for clock, of_day in clocks.items():
        date = _date_of(table, clock, [*dates])
        if date is None:
            whole = _over_midnight(of_day)
        else:
            days, assumed = _days(table, date, dates.pop(date), clock in halves)
            if assumed:
                findings.append(_assumed(date, table, assumed))
            # Counted from the first day: a double that counts from 1970 has no digits left for microseconds.
            whole = days - np.nanmin(days) + of_day
            columns[date] = whole
            stamps.add(date)
        columns[clock] = whole
        stamps.add(clock)
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


def _with_long_numbers(table: LogTable) -> LogTable:
    """Table in which stamps that are written as one number, 20240305195959, are stamps."""
    stamped: dict[str, Array] = {}
    for name, values in table.columns.items():
        if name in table.stamps or not STAMP_WORDS & set(words(name)):
            continue
        values = np.where(finite(values), values, np.nan)
        midnights = _of_digits(np.floor(values / 1e6))
        if midnights is None:
            continue
        of_day = np.mod(values, 1e6)
        minutes, seconds = of_day // 100 % 100, of_day % 100
        if np.all((minutes < 60) & (seconds < 60)):
            stamped[name] = midnights + of_day // 1e4 * 3600.0 + minutes * 60.0 + seconds
    if not stamped:
        return table
    return replace(
        table,
        columns={**table.columns, **stamped},
        units={**table.units, **dict.fromkeys(stamped, "s")},
        stamps=table.stamps.union(stamped),
    )


def _dates_and_clocks(
    table: LogTable,
) -> tuple[dict[str, Array | None], dict[str, Array], set[str]]:
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
                if any(cell.strip()[-1:] in "mM." for cell in cells[:PROBE].tolist()):
                    halves.add(name)
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
            if of_day is None:
                of_day = _restarting(table, name, dates)
            if of_day is not None:
                clocks[name] = of_day
    return dates, clocks, halves


def _of_digits(values: Array) -> Array | None:
    """Midnights of dates that are written as numbers, 20240305; None if they are none."""
    good = measured(values)
    if not good.size or float(good.min()) < 19_000_101 or float(good.max()) > 21_001_231:
        return None
    if np.any(good % 1 != 0):
        return None
    # Few days stand in many rows: each is read once.
    numbers, place = np.unique(values, return_inverse=True)
    spelled = [f"{_spelled(f'{number:.0f}')} 00:00" for number in numbers.tolist()]
    days = parse_date_times(spelled, "day")[place]
    if np.isfinite(days).sum() < good.size:
        return None
    return days


def _digits_of_day(values: Array) -> Array | None:
    """Seconds of times of day that are written as numbers, 195959; None if they are none."""
    good = measured(values)
    hours, minutes, seconds = values // 10_000, values // 100 % 100, values % 100
    if good.size < PROBE or float(good.min()) < 0.0:
        return None
    if not DAY <= float(good.max()) < 240_000.0 or np.any(minutes >= 60) or np.any(seconds >= 60):
        return None
    return np.asarray(hours * 3600.0 + minutes * 60.0 + seconds)


def _restarting(table: LogTable, name: str, dates: dict[str, Array | None]) -> Array | None:
    """Seconds of a clock that begins anew with each date, and only there; None if it does not."""
    scale = seconds_of(table.units.get(name) or unit_in_name(name) or "s")
    date = _date_of(table, name, [*dates])
    if scale is None or date is None:
        return None
    of_day = table.columns[name] * scale
    if not np.isfinite(of_day).all() or of_day.min() < 0.0 or of_day.max() > DAY:
        return None
    days = _days(table, date, dates[date], False)[0]
    step = np.diff(of_day)
    against = step * -np.sign(float(np.median(step))) > 0.0
    if not against.any() or not np.array_equal(against, np.diff(days) != 0.0):
        return None
    return of_day


def is_dates(good: Array) -> bool:
    """Whether stamps are dates without a time of day."""
    return bool(good.size and float(good.min()) > AFTER_1973 and np.all(good % DAY == 0.0))


def _all_match(cells: npt.NDArray[np.str_], pattern: re.Pattern[str]) -> bool:
    """Whether a column of text holds nothing but such cells, and empty ones."""
    # The first cells tell of most columns that they are none.
    matches = 0
    for cell in map(str.strip, cells[:PROBE].tolist()):
        if cell.lower() not in MISSING:
            if not pattern.fullmatch(cell):
                return False
            matches += 1
    if matches == 0:
        return False
    for cell in map(str.strip, set(cells.tolist())):
        if cell.lower() not in MISSING and not pattern.fullmatch(cell):
            return False
    return True


def _of_day(cells: npt.NDArray[np.str_]) -> Array:
    """Seconds since midnight of each cell."""
    texts = list(set(cells.tolist()))
    values = dict(zip(texts, map(_seconds, texts), strict=True))
    return np.array(list(map(values.__getitem__, cells.tolist())), dtype=np.float64)


def _seconds(cell: str) -> float:
    match = _CLOCK.fullmatch(cell.strip())
    if match is None:
        return float("nan")
    hour, minute, second, share, half = match.groups()
    hours = int(hour)
    if half is not None:
        hours = hours % 12 + 12 * (half.lower() == "p")
    return hours * 3600.0 + int(minute) * 60.0 + float(f"{second or 0}.{share or 0}")


def _date_of(table: LogTable, clock: str, dates: list[str]) -> str | None:
    """The date beside a time of day, left of it rather than right, else the only one of the log."""
    place = table.order.index(clock)
    for beside in (place - 1, place + 1):
        if 0 <= beside < len(table.order) and table.order[beside] in dates:
            return table.order[beside]
    if len(dates) == 1:
        return dates[0]
    return None


def _days(table: LogTable, name: str, days: Array | None, half: bool) -> tuple[Array, str]:
    """Midnight of each row, and which of day and month was taken first where nothing tells."""
    if days is not None:
        return days, ""
    cells = table.labels[name].tolist()
    texts = list(dict.fromkeys(cells))
    stamps = [f"{_spelled(text)} 00:00" for text in texts]
    # AM and PM tell that the log writes the month first.
    suffix = " AM" * half
    order, assumed = date_order([stamp + suffix for stamp in stamps])
    midnights = dict(zip(texts, parse_date_times(stamps, order).tolist(), strict=True))
    for text, midnight in midnights.items():
        if midnight != midnight and text.strip().lower() not in MISSING:
            return np.full(len(cells), np.nan), ""  # 20.15.00 is no date
    days = np.array([midnights[cell] for cell in cells], dtype=np.float64)
    if assumed:
        return days, order
    return days, ""


def _spelled(text: str) -> str:
    """A date as `parse_date_times` knows it before a time of day."""
    digits = text.strip()
    if digits.isdigit() and len(digits) == 8:
        return f"{digits[:4]}/{digits[4:6]}/{digits[6:]}"
    if re.match(r"\d{4}-", digits):
        return digits.replace("-", "/")
    return digits


def _assumed(name: str, table: LogTable, order: str) -> Finding:
    return Finding(
        "date-order",
        f"dates in column '{name}', such as {str(table.labels[name][0]).strip()}, were read with the {order} first; "
        f"nothing in the log tells. If that is wrong, log dates as 2024-05-01.",
    )


def _over_midnight(of_day: Array) -> Array:
    """Times of day that go on where they fall, or rise where they run backward, by a day less a usual step."""
    good = np.isfinite(of_day)
    step = np.diff(of_day[good])
    usual = 0.0
    if np.any(step != 0.0):
        usual = float(np.median(np.abs(step[step != 0.0])))
    left = DAY - np.abs(step)
    turns = np.where(
        (left <= POLICY.midnight * usual) & (np.abs(step) > DAY / 2), -np.sign(step), 0.0
    )
    whole = of_day.copy()
    whole[good] += DAY * np.concatenate(([0.0], np.cumsum(turns)))
    return whole
