"""Time columns: which one belongs to a signal, its unit, and whether two agree."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from weakref import WeakKeyDictionary

import numpy as np

from dehyst.arrays import Array, Rows
from dehyst.errors import ColumnError, TimeError, UnitError
from dehyst.findings import Finding
from dehyst.io._columns import find_column
from dehyst.io._dates import is_dates, join_dates
from dehyst.io._policy import POLICY
from dehyst.io._table import LogTable, finite, list_names, measured, unique_names, usual_step
from dehyst.io._time_units import DAY, of_clock, seconds_of, unit_in_name
from dehyst.units import DIMENSION, parse_unit, words

TIME_WORDS = frozenset(
    words(
        "t time timestamp timestamps stamp zeit temps tiempo tempo elapsed clock datetime date sec secs seconds msec "
        "usec nsec ms us ns epoch zeitstempel uhrzeit datum dauer laufzeit messzeit zeitpunkt tout"
    )
)
PLAIN_WORDS = frozenset(words("time timestamp timestamps zeit zeitstempel elapsed datetime"))
# Names of what is beyond the seconds of a clock.
FRACTION_WORDS = frozenset(words("fraction fractional subsecond subseconds"))
FINEST, COARSEST = 1e-15, 1e9  # seconds of a unit: beyond it no log was written
FIRST_OF_LABVIEW = "X_Value"  # name of the first column of a measurement file, whatever it holds
# Seconds since 1970 from 2001 to 2099; a stamp in this window counts from an epoch, not from a start button.
EPOCH = (9.78e8, 4.1e9)
# Units of clocks of computers: since 1970 in s, ms, us, ns; then 100 ns since the years 1 (.NET) and 1601 (Windows).
_EPOCHS = (
    (EPOCH[0], EPOCH[1], 1.0),
    (EPOCH[0] / 1e-3, EPOCH[1] / 1e-3, 1e-3),
    (EPOCH[0] / 1e-6, EPOCH[1] / 1e-6, 1e-6),
    (EPOCH[0] / 1e-9, EPOCH[1] / 1e-9, 1e-9),
    (6.31e17, 6.63e17, 1e-7),
    (1.26e17, 1.58e17, 1e-7),
)
# Days of 2000 to 2100 as programs count them; a clock that started hours ago may show the same numbers as seconds.
DAY_NUMBERS = {
    "Excel": (36_526.0, 73_050.0),
    "MATLAB": (730_486.0, 767_010.0),
    "Julian dates": (2_451_544.0, 2_488_070.0),
    "days since 1970": (10_957.0, 36_526.0),
}
# A table is asked for its clocks several times.
_FOUND: WeakKeyDictionary[LogTable, list[str]] = WeakKeyDictionary()


def is_clock(table: LogTable, name: str) -> bool:
    """Whether a column looks like time: called so, or in a unit of time, and running one way."""
    if name in table.stamps:
        return _moves(table, name)
    bare, unit = table.label(name)
    if FRACTION_WORDS & set(words(bare)):
        return False
    kind = DIMENSION.get(unit, "")
    # "days" is a unit of time whatever the name says; "ps" may be horsepower.
    if len(unit) > 2 and seconds_of(unit) is not None:
        kind = "time"
    called = kind == "" and bool(TIME_WORDS & set(words(bare)))
    return (called or kind == "time") and _runs_forward(table.columns[name])


def _runs_forward(values: Array) -> bool:
    good = measured(values)
    if good.size < 2:
        return False
    step = np.diff(good)
    forward = np.count_nonzero(step >= 0) / step.size >= POLICY.forward_share and np.any(step > 0)
    return bool(forward or newest_first(good))


def _is_even(values: Array) -> bool:
    good = measured(values)
    if good.size < 8:
        return False
    step = np.diff(good)
    middle = float(np.median(step))
    return middle > 0 and bool(
        np.mean(np.abs(step - middle) <= 0.5 * middle) >= POLICY.forward_share
    )


def clock_names(table: LogTable) -> list[str]:
    """Columns that look like time, in the order of the log.

    If none runs forward, one that is plainly called time is still the clock: its order is then a fault to be
    reported, not a reason to do without it. Failing that, a nameless column that counts up evenly is time, or the first
    column of a matrix in a binary log.
    """
    if table not in _FOUND:
        _FOUND[table] = _find_clocks(table)
    return list(_FOUND[table])


def _many_a_day(table: LogTable, name: str) -> bool:
    """Whether a column of dates alone does not tell most of its rows apart."""
    if name not in table.stamps:
        return False
    good = measured(table.columns[name])
    return is_dates(good) and bool(2 * np.count_nonzero(np.diff(good)) < good.size)


def _find_clocks(table: LogTable) -> list[str]:
    clear: list[str] = []
    called: list[str] = []
    leading: list[str] = []
    for name in table.order:
        if name not in table.columns or _many_a_day(table, name):
            continue
        if is_clock(table, name):
            clear.append(name)
        if PLAIN_WORDS & set(words(parse_unit(name)[0])) and _moves(table, name):
            called.append(name)
        if _leads_matrix(table, name) and _is_even(table.columns[name]):
            leading.append(name)
    return clear or called or _nameless_clock(table) or leading


def _is_clear(unit: str) -> bool:
    """Whether a clock names a unit of time, or none."""
    return not unit or seconds_of(unit) is not None


def _nameless_clock(table: LogTable) -> list[str]:
    """A column without a name that counts up evenly: the first if others have names, any if none has.

    One that counts the rows is no time beside names, and only if nothing else is where there are none.
    """
    nameless: list[str] = []
    for place, name in enumerate(table.order, 1):
        if name == f"column_{place}":
            nameless.append(name)
    headless = len(nameless) == len(table.order)
    first = next(iter(table.order), "")
    if not headless:
        # Beside names only the first column may be the time.
        if first in (*nameless, FIRST_OF_LABVIEW) and first in table.columns:
            values = table.columns[first]
            if _is_even(values) and not _counts_rows(values):
                return [first]
        return []

    columns = [name for name in nameless if name in table.columns]
    counting: list[str] = []
    blocks: list[str] = []
    for name in columns:
        values = table.columns[name]
        if name != first and not _never_falls(values):
            continue
        if _is_even(values):
            if not _counts_rows(values):
                return [name]
            counting.append(name)
        elif _is_even(_of_blocks(values)):
            blocks.append(name)
    return (counting or blocks or _alone_rises(table, columns))[:1]


def _never_falls(values: Array) -> bool:
    return bool(np.all(np.diff(measured(values)) >= 0))


def _counts_rows(values: Array) -> bool:
    good = measured(values)
    return good[0] in (0.0, 1.0) and bool(np.all(np.diff(good) == 1.0))


def _of_blocks(values: Array) -> Array:
    """The values of a column each of which stands in about as many rows as the others, as a coarse clock writes them.

    None for another column: a temperature that rises stays at one reading for long, at another shortly.
    """
    good = measured(values)
    starts = np.flatnonzero(np.diff(good) != 0) + 1
    lengths = np.diff(starts)
    if lengths.size == 0 or np.max(lengths) > 2.0 * np.mean(lengths):
        return good[:0]
    return good[starts]


def _alone_rises(table: LogTable, names: list[str]) -> list[str]:
    """The one column of at least three that rises from row to row, evenly or not, while the others fall too."""
    count = 0
    rising: list[str] = []
    for name in names:
        if measured(table.columns[name]).size > 1:
            count += 1
            if _never_falls(table.columns[name]):
                rising.append(name)
    if len(rising) != 1 or count < 3:
        return []
    step = np.diff(table.columns[rising[0]])
    if step.size < POLICY.rising or not np.all(step > 0):
        return []
    return rising


def _leads_matrix(table: LogTable, name: str) -> bool:
    """Whether a column is the first of a matrix in a binary log (``data_1`` beside ``data_2``)."""
    stem, _, number = name.rpartition("_")
    second = table.columns.get(f"{stem}_2")
    return (
        table.row_word == "sample"
        and number == "1"
        and second is not None
        and second.size == table.columns[name].size
    )


def _moves(table: LogTable, name: str) -> bool:
    good = measured(table.columns[name])
    return good.size > 1 and float(good.min()) < float(good.max())


def seconds(table: LogTable, name: str) -> tuple[Array, float]:
    """Stamps of a time column in seconds, and their origin.

    Stamps that count from 1970 (date-times, epoch in s, ms, us or ns) are returned from zero, with the time of
    the oldest row as origin; all others keep their own values, with origin 0. Add the origin to compare two clocks.
    """
    values = table.columns[name]
    good = measured(values)
    if good.size == 0:
        return np.full(values.size, np.nan), 0.0
    scale, is_epoch = counting_clock(table, name)
    first = 0.0
    if is_epoch:
        oldest = -1 if newest_first(good) else 0
        first = float(good[oldest])
    return in_seconds(values, scale, first), first * scale


def unit_of_clock(table: LogTable, name: str) -> str:
    """Unit that a time column names, known or not, "" if it names none."""
    return of_clock(table.units.get(name, "")) or unit_in_name(name)


def newest_first(stamps: Array) -> bool:
    """Whether stamps run backward from row to row; rows that share a stamp do not count."""
    step = np.diff(measured(stamps))
    step = step[step != 0]
    return step.size >= 3 and float(np.mean(step < 0)) > POLICY.backward_share


def counting_clock(table: LogTable, name: str) -> tuple[float, bool]:
    """Unit of a time column in seconds, and whether it counts from an epoch; a unit that is not known is 1 s here."""
    good = measured(table.columns[name])
    if good.size == 0 or name in table.stamps:
        return 1.0, name in table.stamps
    scale = seconds_of(unit_of_clock(table, name))
    middle = 0.0
    # Numbers below every epoch need no median, which takes long.
    if float(good.max()) >= DAY_NUMBERS["days since 1970"][0]:
        middle = float(np.median(good))
    counts_days = bool(_who_counts_days(middle))
    epoch_scale = _epoch_scale(middle)
    if scale is None:
        scale = epoch_scale or 1.0
        if epoch_scale is None and counts_days and day_numbers(good) is True:
            scale = DAY
    is_epoch = epoch_scale is not None or EPOCH[0] <= middle * scale < EPOCH[1]
    return scale, is_epoch or (scale == DAY and counts_days)


def _epoch_scale(stamp: float) -> float | None:
    """Seconds of one count, if a stamp counts from an epoch of computers."""
    for low, high, scale in _EPOCHS:
        if low <= stamp < high:
            return scale
    return None


def _who_counts_days(stamp: float) -> str:
    """Which program counts days in such numbers, "" if none does."""
    for program, (low, high) in DAY_NUMBERS.items():
        if low <= stamp < high:
            return program
    return ""


def day_numbers(good: Array) -> bool | None:
    """Whether stamps in the range of day numbers step like these, None if they may as well be seconds.

    A logger samples at a round step or rate: 1 s is 1.1574e-05 in days.
    """
    typical = usual_step(good)
    if typical == 0.0 or typical > POLICY.surely_seconds:
        return False
    if typical < POLICY.surely_days:
        return True
    as_seconds = _is_round(typical) or _is_round(1.0 / typical)
    as_days = _is_round(typical * DAY)
    if as_seconds == as_days:
        return None
    return as_days


def _is_round(step: float) -> bool:
    """Whether a step has two digits, to what stamps of eleven digits tell."""
    digits = step / 10.0 ** (np.floor(np.log10(step)) - 1)
    return bool(abs(digits - round(digits)) <= 1e-4 * digits)


def no_clock(table: LogTable) -> str:
    """Say that a log has no time column, or one whose stamps are not understood."""
    for name, cells in table.labels.items():
        if TIME_WORDS & set(words(name)) and cells.size:
            return (
                f"stamps in column '{name}' of {table.name}, such as {str(cells[0])!r}, are not understood: gaps, "
                f"rate dependence and drift cannot be seen. Write them as 2024-05-01 12:00:00.5, or say how many "
                f"seconds lie between two rows, such as --dt 0.01."
            )
    return (
        f"{table.name} has no time column: gaps, rate dependence and drift cannot be seen. Log one, name it with "
        f"--time, or say how many seconds lie between two rows, such as --dt 0.01."
    )


def require_unit(table: LogTable, name: str) -> None:
    """Refuse a time column in a unit that is none of time, of dates alone, or whose numbers may be days and seconds."""
    if _many_a_day(table, name):
        raise TimeError(
            f"time column '{name}' of {table.name} holds dates without a time of day, and several rows a day: how far "
            f"these are apart, it does not tell. Name the column with the time of day, or leave --time out.",
            column=name,
        )
    if name in table.stamps:
        return
    unit = unit_of_clock(table, name)
    good = measured(table.columns[name])
    cure = (
        "Type how many seconds one is, for example --time-unit 0.0005, or its unit, such as --time-unit ms (in Python "
        "time_unit='ms')."
    )
    if unit and seconds_of(unit) is None and counting_clock(table, name)[0] == 1.0:
        raise UnitError(
            f"time column '{name}' of {table.name} counts in '{unit}', and how many seconds that is, is not known "
            f"here. Rates, creep and windows depend on it, so it is not guessed. {cure}",
            unit=unit,
        )
    if unit or good.size == 0:
        return
    program = _who_counts_days(float(np.median(good)))
    if program and day_numbers(good) is None:
        raise UnitError(
            f"time column '{name}' of {table.name} names no unit, and its numbers, {good[0]:.12g} and up, are either "
            f"seconds or days as {program} counts them: a factor of 86400. Type --time-unit s or --time-unit d.",
            unit="",
        )


def in_seconds(values: Array, scale: float, first: float) -> Array:
    """Stamps from `first` on, in seconds; NaN where there is none."""
    good = finite(values)
    if not good.all():
        values = np.where(good, values, np.nan)
    # Subtract before scaling: 1.7e18 ns has no digits to lose.
    stamps = values - first
    # Dividing by 1000 is exact where multiplying by 0.001 is not.
    parts = round(1.0 / scale)
    if scale < 1.0 and abs(parts * scale - 1.0) < 1e-9:
        return np.asarray(stamps / parts)
    return np.asarray(stamps * scale)


def choose_clock(table: LogTable, column: str, asked_for: str | None) -> str | None:
    """Time column of a signal, or None if the log has none.

    One that was asked for must be there and have the length of the signal; several must not contradict each other.
    """
    size = table.columns[column].size
    if asked_for is not None:
        name = find_column(table, asked_for, "time")
        if table.columns[name].size != size:
            raise TimeError(
                f"time column '{name}' of {table.name} has {table.columns[name].size} samples, but '{column}' has "
                f"{size}: they are not on one clock. Name the time column of '{column}', or leave --time out.",
                time=name,
                column=column,
            )
        return name
    if column in table.clocks:
        return table.clocks[column]
    candidates: list[str] = []
    clear: list[str] = []
    for name in clock_names(table):
        if table.columns[name].size == size and name != column:
            candidates.append(name)
            if name in table.stamps or _is_clear(unit_of_clock(table, name)):
                clear.append(name)
    candidates = clear or candidates
    if not candidates:
        return None
    if len(candidates) == 1:
        return candidates[0]

    # The clock is the one that shares most words with the signal, or else the next on its left.
    own_words = set(words(parse_unit(column)[0])) - TIME_WORDS
    shared = [len(own_words & set(words(parse_unit(name)[0]))) for name in candidates]
    most = max(shared)
    if most > 0 and shared.count(most) == 1:
        return candidates[shared.index(most)]
    place = table.order.index(column)
    for name in reversed(candidates):
        if table.order.index(name) < place:
            return name
    first = candidates[0]
    if all(same_clock(table, first, name) for name in candidates[1:]):
        return first
    raise TimeError(
        f"{table.name} has {len(candidates)} time columns that contradict each other: {list_names(candidates)}. "
        f"Nothing tells which one belongs to '{column}'. Name it: --time {first}",
        columns=tuple(candidates),
    )


def with_clock(
    table: LogTable, unit: str | float | None, time: str | None, dt: float | None = None
) -> LogTable:
    """Table whose dates and times of day are joined, and whose clock counts in `unit`, or its rows in steps of `dt`."""
    if dt is None:
        return with_time_unit(join_dates(table), unit, time)
    if not 0.0 < dt < math.inf:
        raise TimeError(
            f"--dt {dt:g}: the seconds from one row to the next are a number above 0: --dt 0.01",
            dt=dt,
        )
    if unit is not None or time is not None:
        raise TimeError(
            "--dt counts the rows, --time and --time-unit are about a time column: leave out one of them."
        )
    columns: dict[str, Array] = dict(table.columns)
    clocks = dict(table.clocks)
    # Columns of one length share a clock.
    clock_of_size: dict[int, str] = {}
    for size in sorted({values.size for values in table.columns.values()}):
        name = unique_names([*columns, *table.labels, "time_from_rows"])[-1]
        clock_of_size[size] = name
        places = np.arange(size)
        if size == table.rows.size:
            places = table.rows
        columns[name] = row_number(places, table.every) * dt
    for column, values in table.columns.items():
        clocks[column] = clock_of_size[values.size]
    added = clock_of_size.values()
    findings = list(table.findings)
    for name in clock_names(table):
        if is_clock(table, name):
            message = (
                f"{table.name} has a time column, '{name}', which was not read: --dt says that rows are {dt:g} s "
                f"apart. If they are not, leave --dt out."
            )
            findings.append(Finding("several-time-columns", message))
            break
    return replace(
        table,
        columns=columns,
        clocks=clocks,
        units={**table.units, **dict.fromkeys(added, "s")},
        order=(*table.order, *added),
        findings=tuple(findings),
    )


def row_number(rows: Rows, every: int = 1) -> Array:
    """Number of each row from 0, by its line in the file: one that was left out, or is empty in each second line.

    Of a table that stands for a longer one, one of `every` rows.
    """
    away = np.asarray(rows - rows[:1], dtype=np.float64)
    if away.size < 2:
        return away
    step = float(np.median(np.diff(away))) / every
    return np.asarray(away / (step or 1.0))


def with_time_unit(table: LogTable, unit: str | float | None, time: str | None) -> LogTable:
    """Table whose clock counts in `unit`: the named time column, else those that name no known unit, else all."""
    if unit is None:
        return table
    text = str(unit).strip()
    if re.fullmatch(r"[\d.,eE+-]+", text):
        text = f"{text} s"
    scale = seconds_of(text)
    if scale is None or not FINEST <= scale <= COARSEST:
        raise UnitError(
            f"'{unit}' is no unit of time. Type one of s, ms, us, ns, ps, cs, min, h, d, or how many seconds one count "
            f"is: --time-unit ms, --time-unit 0.0005",
            unit=unit,
        )
    named = clock_names(table)
    if time is not None:
        named = [find_column(table, time, "time")]
    clocks: list[str] = []
    unclear: list[str] = []
    for name in named:
        if name not in table.stamps:
            clocks.append(name)
            if seconds_of(unit_of_clock(table, name)) is None:
                unclear.append(name)
    if not clocks:
        raise TimeError(
            f"{table.name} has no time column whose unit could be {text}: it has none, or it holds dates. Name the "
            f"column with --time, or leave --time-unit out.",
            unit=unit,
        )
    return replace(table, units={**table.units, **dict.fromkeys(unclear or clocks, text)})


def refuse_clock(table: LogTable, name: str, role: str) -> None:
    """Refuse the time column as a signal."""
    if not is_clock(table, name):
        return
    signals = [column for column in table.columns if not is_clock(table, column)]
    raise ColumnError(
        f"{role} column '{name}' of {table.name} is its time column: a clock neither drives nor follows. "
        f"Name a signal: {list_names(signals) or 'the log holds none'}. If it is a signal, rename it so that it is "
        f"not called like time.",
        column=name,
        columns=tuple(signals),
    )


def same_clock(table: LogTable, a: str, b: str) -> bool:
    """Whether two time columns tell the same time, to a tenth of a sample.

    Where they start does not matter if one counts from 1970 and the other does not, or if they are further apart
    than the log is long; a small offset between clocks of one kind does.
    """
    if a == b:
        return True
    (ta, zero_a), (tb, zero_b) = seconds(table, a), seconds(table, b)
    if ta.size != tb.size:
        return False
    both = np.isfinite(ta) & np.isfinite(tb)
    if both.sum() < 0.9 * max(np.isfinite(ta).sum(), np.isfinite(tb).sum()) or both.sum() < 2:
        return False
    ta, tb = ta[both], tb[both]
    step = np.abs(np.diff(ta))
    typical = 0.0
    if np.any(step > 0):
        typical = float(np.median(step[step > 0]))
    offset = (tb[0] + zero_b) - (ta[0] + zero_a)
    # Clocks this far apart count from different beginnings.
    if abs(offset) > 0.5 * abs(float(ta[-1] - ta[0])):
        offset = 0.0
    apart = (tb - tb[0]) - (ta - ta[0]) + offset
    return bool(np.max(np.abs(apart)) <= 0.1 * typical)


def unit_finding(table: LogTable, name: str, stamps: Array) -> list[Finding]:
    """Say so when the unit of time had to be assumed, or leads to seconds that no log has."""
    if name in table.stamps or name in table.clocks.values():
        return []
    step = np.diff(stamps[np.isfinite(stamps)])
    lasts = float(np.abs(np.sum(step)))
    step = step[step > 0]
    if step.size == 0:
        return []
    typical = float(np.median(step))
    unit = unit_of_clock(table, name)
    scale, is_epoch = counting_clock(table, name)
    if not unit and scale == DAY:
        program = _who_counts_days(float(np.median(measured(table.columns[name]))))
        message = (
            f"time column '{name}' of {table.name} names no unit; its numbers and its step are those of days as "
            f"{program} counts them, and it was read as such: one sample every {typical:.3g} s. If they are seconds, "
            f"type --time-unit s (in Python time_unit='s')."
        )
        return [Finding("day-numbers", message)]
    if unit:
        if typical >= POLICY.shortest_named and lasts <= POLICY.longest_log:
            return []
        message = (
            f"time column '{name}' of {table.name} is in {unit} by its name, which makes one sample every "
            f"{typical:.3g} s and a log of {lasts:.3g} s. If that is not so, type the unit, such as --time-unit ms "
            f"(in Python time_unit='ms'), or how many seconds one count is, such as --time-unit 0.001."
        )
        return [Finding("time-unit", message)]
    if POLICY.shortest_assumed <= typical < 1.0 or (is_epoch and typical < 1.0):
        return []
    return [
        Finding(
            "time-unit",
            f"time column '{name}' of {table.name} names no unit and was read as seconds, one sample every "
            f"{typical:.3g} s. If these are milliseconds, type --time-unit ms (in Python "
            f"time_unit='ms'), or call the column {name}_ms; windows and rates depend on it.",
        )
    ]


def two_columns(table: LogTable, input: str, output: str) -> tuple[str, str]:
    """Return the columns of input and output; refuse one for both, and clocks."""
    x_name = find_column(table, input, "input")
    y_name = find_column(table, output, "output")
    if x_name == y_name:
        raise ColumnError(
            f"input and output are both column '{x_name}' of {table.name}; a loop needs two. "
            f"Its columns are: {list_names(table.columns)}.",
            column=x_name,
        )
    refuse_clock(table, x_name, "input")
    refuse_clock(table, y_name, "output")
    return x_name, y_name
