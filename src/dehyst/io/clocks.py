"""Time columns: which one belongs to a signal, its unit, and whether two agree."""

from __future__ import annotations

from dataclasses import replace
from weakref import WeakKeyDictionary

import numpy as np

from dehyst.arrays import Array
from dehyst.errors import ColumnError, TimeError, UnitError
from dehyst.findings import Finding
from dehyst.io.columns import find_column
from dehyst.io.table import Table, finite, list_names, measured
from dehyst.units import DIMENSION, TABLE, canonical, parse_unit, words

TIME_WORDS = frozenset(
    words(
        "t time timestamp timestamps stamp zeit temps tiempo tempo elapsed clock datetime date sec secs seconds msec "
        "usec nsec ms us ns epoch zeitstempel uhrzeit datum"
    )
)
PLAIN_WORDS = frozenset(words("time timestamp timestamps zeit zeitstempel elapsed datetime"))
NAMELESS = ("column_1", "X_Value")  # no header; the first column of a LabVIEW measurement file
FORWARD_SHARE = 0.9  # of the steps of a clock
# Seconds since 1970 from 2001 to 2099; a stamp in this window counts from an epoch, not from a start button.
EPOCH = (9.78e8, 4.1e9)
_FOUND: WeakKeyDictionary[Table, list[str]] = WeakKeyDictionary()  # a table is asked for its clocks several times


def is_clock(table: Table, name: str) -> bool:
    """Whether a column looks like time: called so, or in a unit of time, and running forward."""
    if name in table.stamps:
        return _moves(table, name)
    bare, unit = parse_unit(name)
    unit = table.units.get(name) or unit
    called = bool(TIME_WORDS & set(words(bare))) or DIMENSION.get(unit) == "time"
    values = table.columns[name]
    return called and _runs_forward(values)


def _runs_forward(values: Array) -> bool:
    good = measured(values)
    if good.size < 2:
        return False
    step = np.diff(good)
    return bool(np.count_nonzero(step >= 0) / step.size >= FORWARD_SHARE and np.any(step > 0))


def _is_even(values: Array) -> bool:
    good = measured(values)
    if good.size < 8:
        return False
    step = np.diff(good)
    middle = float(np.median(step))
    return middle > 0 and bool(np.mean(np.abs(step - middle) <= 0.5 * middle) >= FORWARD_SHARE)


def clock_names(table: Table) -> list[str]:
    """Columns that look like time, in the order of the log.

    If none runs forward, one that is plainly called time is still the clock: its order is then a fault to be
    reported, not a reason to do without it. Failing that, a nameless first column that counts up evenly is time, or
    the first column of a matrix in a binary log.
    """
    if table not in _FOUND:
        _FOUND[table] = _find_clocks(table)
    return list(_FOUND[table])


def _find_clocks(table: Table) -> list[str]:
    names = [name for name in table.order if name in table.columns]
    return (
        [name for name in names if is_clock(table, name)]
        or [name for name in names if PLAIN_WORDS & set(words(parse_unit(name)[0])) and _moves(table, name)]
        or [name for name in names[:1] if name in NAMELESS and _is_even(table.columns[name])]
        or [name for name in names if _leads_matrix(table, name) and _is_even(table.columns[name])]
    )


def _leads_matrix(table: Table, name: str) -> bool:
    """Whether a column is the first of a matrix in a binary log (``data_1`` beside ``data_2``)."""
    stem, _, number = name.rpartition("_")
    second = table.columns.get(f"{stem}_2")
    return (
        table.row_word == "sample" and number == "1" and second is not None and second.size == table.columns[name].size
    )


def _moves(table: Table, name: str) -> bool:
    good = measured(table.columns[name])
    return good.size > 1 and float(good.min()) < float(good.max())


def seconds(table: Table, name: str) -> tuple[Array, float]:
    """Stamps of a time column in seconds, and their origin.

    Stamps that count from 1970 (date-times, epoch in s, ms, us or ns) are returned from zero, with the time of
    the first one as origin; all others keep their own values, with origin 0. Add the origin to compare two clocks.
    """
    values = table.columns[name]
    good = measured(values)
    if good.size == 0:
        return np.full(values.size, np.nan), 0.0
    scale, is_epoch = counting(table, name)
    first = float(good[0]) if is_epoch else 0.0
    return in_seconds(values, scale, first), first * scale


def counting(table: Table, name: str) -> tuple[float, bool]:
    """Unit of a time column in seconds, and whether it counts from 1970."""
    good = measured(table.columns[name])
    scale = TABLE["time"].get(table.units.get(name, ""), 0.0)
    if good.size == 0 or (name not in table.stamps and float(good.max()) * max(scale, 1.0) < EPOCH[0]):
        return scale or 1.0, False  # whatever the unit
    middle = float(np.median(good))
    if not scale:
        fits = [s for s in (1.0, 1e-3, 1e-6, 1e-9) if EPOCH[0] <= middle * s < EPOCH[1]]
        scale = fits[0] if fits else 1.0
    return scale, name in table.stamps or EPOCH[0] <= middle * scale < EPOCH[1]


def in_seconds(values: Array, scale: float, first: float) -> Array:
    """Stamps from `first` on, in seconds; NaN where there is none."""
    # Subtract before scaling: 1.7e18 ns has no digits to lose.
    good = finite(values)
    stamps = (values if good.all() else np.where(good, values, np.nan)) - first
    return np.asarray(stamps / round(1 / scale) if scale < 1 else stamps * scale)


def choose_clock(table: Table, column: str, wanted: str | None) -> str | None:
    """Time column of a signal, or None if the log has none.

    One that was asked for must be there and have the length of the signal; several must not contradict each other.
    """
    size = table.columns[column].size
    if wanted is not None:
        name = find_column(table, wanted, "time")
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
    candidates = [name for name in clock_names(table) if table.columns[name].size == size and name != column]
    if len(candidates) <= 1:
        return candidates[0] if candidates else None
    mine = set(words(parse_unit(column)[0]))
    shared = [len(mine & (set(words(parse_unit(name)[0])) - TIME_WORDS)) for name in candidates]
    if max(shared) > 0 and shared.count(max(shared)) == 1:
        return candidates[shared.index(max(shared))]
    place = table.order.index(column)
    left = [name for name in candidates if table.order.index(name) < place]
    if left:
        return left[-1]
    first = candidates[0]
    if all(same_clock(table, first, other) for other in candidates[1:]):
        return first
    raise TimeError(
        f"{table.name} has {len(candidates)} time columns that contradict each other: {list_names(candidates)}. "
        f"Nothing tells which one belongs to '{column}'. Name it: --time {first}",
        columns=tuple(candidates),
    )


def with_time_unit(table: Table, unit: str | None, time: str | None) -> Table:
    """Table whose clock counts in `unit`: the named time column, else those that name no unit, else all."""
    if unit is None:
        return table
    known = canonical(unit)
    if known is None or DIMENSION[known] != "time":
        raise UnitError(
            f"'{unit}' is no unit of time. Known are {', '.join(TABLE['time'])}: --time-unit ms",
            unit=unit,
        )
    clocks = [find_column(table, time, "time")] if time is not None else clock_names(table)
    clocks = [name for name in clocks if name not in table.stamps]
    nameless = [name for name in clocks if not table.units.get(name)]
    if not clocks:
        raise TimeError(
            f"{table.name} has no time column whose unit could be {known}: it has none, or it holds dates. Name the "
            f"column with --time, or leave --time-unit out.",
            unit=unit,
        )
    return replace(table, units={**table.units, **dict.fromkeys(nameless or clocks, known)})


def refuse_clock(table: Table, name: str, role: str) -> None:
    """Refuse the time column as a signal."""
    if not is_clock(table, name):
        return
    others = [column for column in table.columns if not is_clock(table, column)]
    raise ColumnError(
        f"{role} column '{name}' of {table.name} is its time column: a clock neither drives nor follows. "
        f"Name a signal: {list_names(others) or 'the log holds none'}. If it is a signal, rename it so that it is "
        f"not called like time.",
        column=name,
        columns=tuple(others),
    )


def same_clock(table: Table, a: str, b: str) -> bool:
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
    typical = float(np.median(step[step > 0])) if np.any(step > 0) else 0.0
    offset = (tb[0] + zero_b) - (ta[0] + zero_a)
    unrelated = abs(offset) > 0.5 * abs(float(ta[-1] - ta[0]))
    apart = (tb - tb[0]) - (ta - ta[0]) + (0.0 if unrelated else offset)
    return bool(np.max(np.abs(apart)) <= 0.1 * typical)


def unit_finding(table: Table, name: str, stamps: Array) -> list[Finding]:
    """Say so when the unit of time had to be assumed and the seconds look wrong."""
    if table.units.get(name) or name in table.stamps:
        return []
    step = np.diff(stamps[np.isfinite(stamps)])
    step = step[step > 0]
    if step.size == 0 or float(np.median(step)) < 1.0 or name in table.clocks.values():
        return []
    return [
        Finding(
            "time-unit",
            f"time column '{name}' of {table.name} names no unit and was read as seconds, one sample every "
            f"{float(np.median(step)):.3g} s. If these are milliseconds, type --time-unit ms (in Python "
            f"time_unit='ms'), or call the column {name}_ms; windows and rates depend on it.",
        )
    ]


def two_columns(table: Table, input: str, output: str) -> tuple[str, str]:
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
