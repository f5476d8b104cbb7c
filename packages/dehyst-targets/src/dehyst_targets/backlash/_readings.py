"""Reads the filled sheet of a measurement, or a log of one: commanded position, direction, error."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from functools import cached_property
from os import PathLike

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array, Mask
from dehyst.errors import ColumnError, RecordingError, UnitError
from dehyst.findings import Finding
from dehyst.io import LogTable, read_table
from dehyst.io import kit as io_kit
from dehyst.shell import quoted, visible
from dehyst.units import canonical, convert, dimension, words
from dehyst_targets.backlash._policy import POLICY

# What heads a column, by the words of its name.
COMMANDED = frozenset(words("commanded command nominal target setpoint soll"))
MEASURED = frozenset(words("measured reading actual gauge ist"))
ERROR = frozenset(words("error deviation abweichung"))
DIRECTION = frozenset(words("direction side approached richtung"))
APPROACH = frozenset({"approach"})
TIME = frozenset(words("time t zeit"))
RISING = frozenset(["rising", "up", "forward", "positive", "below", "1"])
FALLING = frozenset(["falling", "down", "backward", "reverse", "negative", "above", "-1"])
INCH = 25.4  # mm
NEAR = 0.05  # share within which a factor is taken for that of another unit
MOST_DECIMALS = 9  # that a reading may have
LONGEST = 1e6  # no axis is so long, in whichever unit


@dataclass(frozen=True, eq=False)
class AxisReadings:
    """Readings of one axis, (k,) each, in the order in which they were taken.

    Attributes
    ----------
    commanded
        Position that the axis was sent to. [unit]
    error
        Actual less commanded position. [unit]
    rising
        Whether the axis came from below.
    approach
        Way from the last turn to the reading, NaN where it is not known. [unit]
    rows
        Rows of the sheet.
    unit
        Of all lengths, "" where none is known.
    rounding
        Standard deviation of the rounding of readings, step/sqrt(12). [unit]
    name
        In messages.
    findings
        Of the reading of the sheet.

    Examples
    --------
    >>> AxisReadings.of([0, 0], [0.0, 0.03], [1, 0]).size
    2
    """

    commanded: Array
    error: Array
    rising: Mask
    approach: Array = field(default_factory=lambda: np.zeros(0))
    rows: npt.NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    unit: str = ""
    rounding: float = 1e-9
    name: str = "the readings"
    findings: tuple[Finding, ...] = ()

    @classmethod
    def of(
        cls,
        commanded: npt.ArrayLike,
        error: npt.ArrayLike,
        rising: npt.ArrayLike,
        unit: str = "",
    ) -> AxisReadings:
        """Return readings from anything that numpy takes for an array."""
        return cls(
            np.asarray(commanded, dtype=np.float64),
            np.asarray(error, dtype=np.float64),
            np.asarray(rising, dtype=bool),
            unit=unit,
        )

    @property
    def size(self) -> int:
        """How many readings there are."""
        return int(self.commanded.size)

    @cached_property
    def approaches(self) -> Array:
        """Different approaches that are known, rising. [unit]"""
        return np.unique(self.approach[np.isfinite(self.approach)])

    @cached_property
    def group(self) -> npt.NDArray[np.int64]:
        """Number of the point and direction of each reading, from 0."""
        key = np.column_stack([self.commanded, self.rising])
        return np.unique(key, axis=0, return_inverse=True)[1].reshape(-1)

    @cached_property
    def group_count(self) -> Array:
        """Readings of the group of each reading."""
        return np.bincount(self.group)[self.group].astype(np.float64)

    @cached_property
    def residual(self) -> Array:
        """Error less the mean of its group. [unit]"""
        return self.error - self.group_mean(self.error)

    @cached_property
    def freedom(self) -> int:
        """Degrees of freedom of the spread within groups."""
        return self.size - int(np.unique(self.group).size)

    def group_mean(self, values: Array) -> Array:
        """Return the mean of values over the group of each reading."""
        return np.bincount(self.group, weights=values)[self.group] / self.group_count

    def select(self, part: Mask) -> AxisReadings:
        """Return some of the readings."""
        chosen = replace(
            self, commanded=self.commanded[part], error=self.error[part], rising=self.rising[part]
        )
        if self.approach.size:
            chosen = replace(chosen, approach=self.approach[part])
        if self.rows.size:
            chosen = replace(chosen, rows=self.rows[part])
        return chosen

    def place(self, number: int) -> str:
        """Where a reading stands."""
        if self.rows.size:
            return f"line {self.rows[number]}"
        return f"number {number + 1}"


def read_measurement(
    path: str | PathLike[str],
    *,
    commanded: str | None = None,
    measured: str | None = None,
    unit: str | None = None,
    sheet: str | None = None,
) -> AxisReadings:
    """Read a filled sheet, or a log with a time column that holds stops.

    Columns are found by the words of their names: the commanded position (`commanded`, `nominal`, `target`), the
    measured one (`measured`, `reading`, `actual`) or the error (`error`, `deviation`: measured less commanded), the
    `direction` (rising or falling, up or down, + or -) and the `approach`. Without a direction it is taken from the
    order of the commands. Lengths of both columns may differ in unit; the result has that of the commands.

    In a log with time each stop is a reading: the median of its second half. Short stops, as where an axis turns, are
    none.

    Parameters
    ----------
    path
        CSV or any other format that `dehyst.read_log` reads.
    commanded, measured
        Columns, where the words do not find them.
    unit
        Of both columns where their names say none.
    sheet
        Of a workbook.

    Returns
    -------
    AxisReadings
        Rows without a reading are left out.

    Raises
    ------
    LogError
        If the file cannot be read.
    ColumnError
        If a column is missing, or a direction is no word for one.
    RecordingError
        If there is no reading, the measured position does not follow the commanded one, or runs against it.
    UnitError
        If both units are no lengths, or no angles.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> sheet = pathlib.Path(tempfile.mkdtemp()) / "sheet.csv"
    >>> _ = sheet.write_text("commanded [mm],direction,measured [mm]\\n0,rising,-0.02\\n0,falling,0.02\\n")
    >>> read_measurement(sheet).error.tolist()
    [-0.02, 0.02]
    """
    table = read_table(path, sheet=sheet)
    command_name = _column(table, COMMANDED, "commanded", commanded)
    is_error = measured is None and not _named(table, MEASURED) and bool(_named(table, ERROR))
    if measured is not None:
        is_error = bool(ERROR & set(words(measured)))
    answer_name = _column(table, ERROR if is_error else MEASURED, "measured", measured)
    findings: list[Finding] = []
    x, y, used_unit = _lengths(table, command_name, answer_name, unit, findings)
    rows = np.asarray(table.rows, dtype=np.int64)
    direction, approach = _directions(table), _approaches(table, command_name, used_unit, x.size)
    time_name = next(iter(_named(table, TIME)), "")
    if direction is None and time_name:
        x, y, direction, rows = _stops(x, y, rows)
        approach = np.full(x.size, np.nan)
    _refuse_no_positions(table, x, y, rows)
    used = np.isfinite(x) & np.isfinite(y)
    if not used.any():
        raise RecordingError(
            f"{table.name}: the column '{answer_name}' holds no reading. Fill it in, a number a row, and type the "
            f"same line again."
        )
    x, y, rows, approach = x[used], y[used], rows[used], approach[used]
    # Rows without a reading say nothing of the order either.
    points = _merged(x)
    rising = _from_order(table.name, points, findings) if direction is None else direction[used]
    rounding = _rounding(y, table, answer_name, used_unit)
    error = y
    if not is_error:
        _refuse_another_scale(table.name, answer_name, x, y)
        error = y - x
    return AxisReadings(
        points, error, rising, approach, rows, used_unit, rounding, table.name, tuple(findings)
    )


def _named(table: LogTable, heads: frozenset[str]) -> list[str]:
    """Columns whose name has one of these words."""
    return [name for name in table.order if heads & set(words(name))]


def _column(table: LogTable, heads: frozenset[str], role: str, typed: str | None) -> str:
    if typed is not None:
        return io_kit.find_column(table, typed, role)
    names = _named(table, heads)
    if len(names) == 1:
        return io_kit.find_column(table, names[0], role)
    option = {"commanded": "--input", "measured": "--output"}[role]
    listed = ", ".join(f"'{visible(name)}'" for name in table.order[:12])
    if names:
        raise ColumnError(
            f"{table.name} has {len(names)} columns that may be the {role} position: {', '.join(names)}. "
            f"Name one: {option} {quoted(names[0])}",
            columns=tuple(names),
        )
    wanted = "a column 'commanded'"
    if role == "measured":
        wanted = "neither a column 'measured' nor a column 'error' (measured less commanded)"
    raise ColumnError(
        f"{table.name} has {wanted.replace('a column', 'no column', 1) if role == 'commanded' else wanted}. "
        f"Its columns are {listed}. Name it: {option} COLUMN",
        columns=table.order,
    )


def _lengths(
    table: LogTable, command_name: str, answer_name: str, unit: str | None, findings: list[Finding]
) -> tuple[Array, Array, str]:
    """Both columns in the unit of the commands."""
    if unit is not None:
        canonical_unit = canonical(unit)
        if canonical_unit is None or dimension(canonical_unit) not in ("length", "angle"):
            raise UnitError(f"--unit {unit:.20} is no length and no angle. Type mm, in or deg.")
        unit = canonical_unit
    units = []
    for name in (command_name, answer_name):
        headed = table.label(name)[1]
        if unit and headed and unit != headed:
            raise UnitError(
                f"--unit {unit} contradicts the column '{name}', which is in {headed}. Leave --unit out, or head the "
                f"column with its unit."
            )
        # What heads a column was written by who measured it, and counts more than an option.
        units.append(headed or unit or "")
    if not any(units):
        units = ["mm", "mm"]
        message = (
            f"no column of {table.name} says its unit; mm was taken. If it is another one, type it: `--unit in`, or "
            f"head the columns 'commanded [in]' and 'measured [in]'."
        )
        findings.append(Finding("backlash-unit", message))
    # A column without a unit has that of the other one.
    used = units[0] or units[1]
    answer_unit = units[1] or used
    if dimension(used) not in ("length", "angle"):
        raise UnitError(
            f"the column '{command_name}' is in {used}, and an axis moves by a length or an angle. Name its column: "
            f"--input COLUMN, or head it with its unit: 'commanded [mm]'."
        )
    return (
        np.asarray(table.columns[command_name], dtype=np.float64),
        convert(table.columns[answer_name], answer_unit, used),
        used,
    )


def _refuse_no_positions(table: LogTable, x: Array, y: Array, rows: npt.NDArray[np.int64]) -> None:
    """Refuse what an overloaded gauge or a slip of the keyboard writes."""
    for values in (x, y):
        beyond = np.flatnonzero(np.abs(values) > LONGEST)
        if beyond.size:
            raise RecordingError(
                f"{table.name}, {table.row_word} {rows[beyond[0]]}: {values[beyond[0]]:g} is no position of an axis. "
                f"Empty the cell, or write the reading."
            )


def _merged(x: Array) -> Array:
    """Commands that differ by less than the policy's share of the way become the lowest of them."""
    order = np.argsort(x, kind="stable")
    is_new = np.diff(x[order], prepend=-np.inf) > POLICY.same_point * np.ptp(x)
    number = np.empty(x.size, dtype=np.int64)
    number[order] = np.cumsum(is_new) - 1
    return x[order][is_new][number]


def _directions(table: LogTable) -> Mask | None:
    """Whether each row was approached from below; None where no column says so."""
    names = _named(table, DIRECTION)
    if not names:
        return None
    name = names[0]
    if name in table.labels:
        cells = [cell.strip().lower() for cell in table.labels[name].tolist()]
    else:
        cells = [f"{value:g}" for value in table.columns[name].tolist()]
        cells = ["(no word)" if cell == "nan" else cell for cell in cells]
    rising = np.zeros(len(cells), dtype=bool)
    for number, cell in enumerate(cells):
        first = (cell.split() or [""])[-1]
        if first not in RISING | FALLING:
            raise ColumnError(
                f"{table.name}, {table.row_word} {table.rows[number]}: '{visible(cell)[:30]}' in the column '{name}' "
                f"is no direction. Write rising (the axis came from below) or falling.",
                column=name,
            )
        rising[number] = first in RISING
    return rising


def _approaches(table: LogTable, command_name: str, unit: str, size: int) -> Array:
    for name in _named(table, APPROACH):
        if name in table.columns and name != command_name:
            return convert(table.columns[name], table.label(name)[1] or unit, unit)
    return np.full(size, np.nan)


def _stops(
    x: Array, y: Array, rows: npt.NDArray[np.int64]
) -> tuple[Array, Array, Mask, npt.NDArray[np.int64]]:
    """Readings of a log: the median of the second half of each long stop, and whether it was reached from below."""
    begins = np.flatnonzero(np.diff(x, prepend=np.nan) != 0.0)
    ends = np.append(begins[1:], x.size)
    long_enough = ends - begins >= POLICY.shortest_hold * np.max(ends - begins, initial=0)
    # The first stop was reached from somewhere that the log does not hold.
    long_enough[:1] = False
    chosen = np.flatnonzero(long_enough)
    values, rising = [], []
    for k in chosen:
        middle = (begins[k] + ends[k]) // 2
        # In the first half the axis is still settling.
        values.append(float(np.median(y[middle : ends[k]])))
        rising.append(bool(x[begins[k]] > x[begins[k] - 1]))
    return x[begins[chosen]], np.array(values), np.array(rising, dtype=bool), rows[begins[chosen]]


def _from_order(name: str, x: Array, findings: list[Finding]) -> Mask:
    """Directions by the order of the commands.

    Where every command stands twice, as in a plan, the first is rising. Otherwise onward is rising, back is falling,
    and the same command again was reached from the other side, as at the end of a run.
    """
    rising = np.ones(x.size, dtype=bool)
    steps = np.diff(x)
    if x.size % 2 == 0 and np.array_equal(x[::2], x[1::2]):
        rising[1::2] = False
        steps = steps[:0]
    elif steps[:1].sum() < 0.0:
        rising[0] = False
    for number, step in enumerate(steps, start=1):
        rising[number] = step > 0.0 or (step == 0.0 and not rising[number - 1])
    _refuse_uneven(name, x, rising)
    message = (
        f"no column says the direction; by the order of the commands {int(rising.sum())} readings are rising and "
        f"{int((~rising).sum())} falling (a command that stands twice was reached from below first, or at the end of "
        f"a run from the other side). If that is wrong, add a column 'direction'."
    )
    findings.append(Finding("backlash-direction", message))
    return rising


def _refuse_uneven(name: str, x: Array, rising: Mask) -> None:
    """Refuse an order by which one point has more readings from one side than from the other by two or more."""
    for point in np.unique(x):
        sides = rising[x == point]
        below, above = int(sides.sum()), int((~sides).sum())
        if abs(below - above) > 1 or (below and above and below != above):
            raise RecordingError(
                f"{name} has no column of directions, and by the order of its commands {point:g} was reached {below} "
                f"times from below and {above} times from above, which no even measurement does. Add a column "
                f"'direction' with rising or falling in each row."
            )


def _rounding(y: Array, table: LogTable, name: str, unit: str) -> float:
    """Standard deviation of a value that was rounded to the decimals which the readings have."""
    values = table.columns[name]
    finite = values[np.isfinite(values)]
    decimals = 0
    # A decimal number that was read differs from its digits by the rounding of doubles alone.
    while decimals < MOST_DECIMALS and np.any(
        np.abs(finite - np.round(finite, decimals)) > 1e-12 * np.abs(finite).max(initial=1.0)
    ):
        decimals += 1
    step = convert(10.0**-decimals, table.label(name)[1] or unit, unit)
    return float(step) / math.sqrt(12.0)


def _refuse_another_scale(name: str, column: str, x: Array, y: Array) -> None:
    """Refuse measured positions that are no positions, run backward, or are in another unit than the commands."""
    if np.ptp(x) == 0.0:
        return
    slope = float(np.polyfit(x, y, 1)[0])
    if abs(slope - 1.0) <= POLICY.largest_scale:
        return
    if abs(slope + 1.0) <= POLICY.largest_scale:
        trouble = "it counts against the axis. Turn its sign in the sheet"
    elif min(abs(slope / INCH - 1.0), abs(slope * INCH - 1.0)) < NEAR:
        trouble = (
            "one column is in mm, the other in inch. Head both with their units, as 'measured [in]'"
        )
    elif abs(slope) < 1.0 - POLICY.largest_scale and np.ptp(y) < POLICY.largest_scale * np.ptp(x):
        trouble = (
            "it seems to hold errors. Head it 'error' if it is measured less commanded position"
        )
    else:
        trouble = "steps per unit of the machine are wrong, or the column is. Correct them before backlash is measured"
    raise RecordingError(
        f"{name}: the column '{column}' goes {slope:.4g} times as far as the commands: {trouble}.",
        slope=slope,
    )
