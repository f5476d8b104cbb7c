"""The guided measurement: a G-code program that reaches each point from both sides, and the sheet for its readings."""

from __future__ import annotations

import csv
import io
import math
from dataclasses import dataclass

import numpy as np

from dehyst.errors import ParameterError
from dehyst.units import canonical
from dehyst_targets.backlash._machines import MACHINES, MachineFormat, machine_named, number
from dehyst_targets.backlash._policy import POLICY

FULL_WAY = 20.0  # s that the way from one end to the other takes, where no rate is typed


@dataclass(frozen=True)
class PlannedReading:
    """A reading: the axis goes to `turn`, from there to `commanded`, and rests."""

    repeat: int
    commanded: float
    rising: bool
    approach: float

    @property
    def turn(self) -> float:
        """Where the approach begins. [unit]"""
        if self.rising:
            return self.commanded - self.approach
        return self.commanded + self.approach


@dataclass(frozen=True)
class MeasurementPlan:
    """Readings in their order, and how the axis goes from one to the next.

    Attributes
    ----------
    readings
        What is read.
    unit
        Of all lengths: mm, in or deg.
    rate
        Of all moves. [unit/s]
    hold
        Rest before each reading. [s]

    Examples
    --------
    >>> plan = plan_measurement(0.0, 300.0, points=13, approach=(2.0,))
    >>> len(plan.readings), plan.low, plan.high
    (26, -2.0, 302.0)
    >>> plan.sheet().splitlines()[:2]
    ['repeat,approach [mm],commanded [mm],direction,measured [mm]', '1,2,0,rising,']
    """

    readings: tuple[PlannedReading, ...]
    unit: str
    rate: float
    hold: float

    @property
    def low(self) -> float:
        """Lowest position that is commanded. [unit]"""
        return min(reading.turn for reading in self.readings)

    @property
    def high(self) -> float:
        """Highest position that is commanded. [unit]"""
        return max(reading.turn for reading in self.readings)

    @property
    def duration(self) -> float:
        """Time of moves and rests, accelerations left out. [s]"""
        places = []
        for reading in self.readings:
            places += [reading.turn, reading.commanded]
        way = float(np.sum(np.abs(np.diff(places))))
        return way / self.rate + self.hold * len(self.readings)

    def sheet(self) -> str:
        """Return the empty sheet as CSV: a row a reading, its last cell to be filled in."""
        stream = io.StringIO(newline="")
        writer = csv.writer(stream, lineterminator="\n")
        unit = f"[{self.unit}]"
        heads = ("repeat", f"approach {unit}", f"commanded {unit}", "direction", f"measured {unit}")
        writer.writerow(heads)
        for reading in self.readings:
            direction = "falling"
            if reading.rising:
                direction = "rising"
            cells = (number(reading.approach), number(reading.commanded))
            writer.writerow((reading.repeat, *cells, direction, ""))
        return stream.getvalue()

    def gcode(self, machine: str = "linuxcnc", axis: str = "X", *, pause: bool = False) -> str:
        """Return the program of an axis in the G-code of a machine.

        Moves are in machine coordinates (G53) where the machine has them, since a table is. Each reading is a comment
        line, two moves and a dwell; with `pause` a stop until the start button is pressed takes the place of the dwell.

        Raises
        ------
        ParameterError
            If the machine or its axis is not known, or it does not take the unit.
        """
        form = machine_named(machine, axis)
        _refuse_unit(form, self.unit)
        dialect = form.dialect
        length_word = "G21"
        if self.unit == "in":
            length_word = "G20"
        lines = [
            f"; {len(self.readings)} readings of {axis}; it goes from {self.low:g} to {self.high:g} {self.unit}",
            f"; {form.switched_off}",
            *(line.format(length_word=length_word) for line in dialect.preamble),
        ]
        rate = f"F{number(60.0 * self.rate)}"
        wait = dialect.dwell.format(seconds=self.hold, milliseconds=1000.0 * self.hold)
        if pause:
            wait = dialect.pause
        for count, reading in enumerate(self.readings, start=1):
            side = "above"
            if reading.rising:
                side = "below"
            lines.append(f"; reading {count}: {reading.commanded:g} from {side}")
            for place in (reading.turn, reading.commanded):
                lines.append(f"{dialect.prefix}G1 {axis}{number(place)} {rate}")
            # Machines plan moves ahead: the rest must not begin before the axis stands.
            lines += [*dialect.settle, wait]
        return "\n".join([*lines, *dialect.ending]) + "\n"


def plan_measurement(
    low: float,
    high: float,
    *,
    points: int = 13,
    approach: tuple[float, ...] = (2.0,),
    repeats: int = 1,
    unit: str = "mm",
    rate: float | None = None,
    hold: float = 2.0,
) -> MeasurementPlan:
    """Plan a measurement: points at equal distances, each from below and then from above, all of it repeated.

    Parameters
    ----------
    low, high
        First and last point. [unit]
    points
        How many, both ends included.
    approach
        Way from the turn to the point. Several show whether the lost motion depends on it. [unit]
    repeats
        How often. Three or more show how far readings repeat.
    unit
        mm, in or deg.
    rate
        Of all moves; without it the whole way takes 20 s. [unit/s]
    hold
        Rest before a reading. [s]

    Raises
    ------
    ParameterError
        If a number is outside what is possible.

    Examples
    --------
    >>> plan = plan_measurement(0.0, 10.0, points=2, approach=(1.0,))
    >>> [(r.turn, r.commanded) for r in plan.readings]
    [(-1.0, 0.0), (1.0, 0.0), (9.0, 10.0), (11.0, 10.0)]
    """
    _refuse_bad_numbers(low, high, points, approach, repeats, hold)
    if rate is None:
        rate = (high - low) / FULL_WAY
    if not (rate > 0.0 and math.isfinite(rate)):
        raise ParameterError(f"--rate {rate:g} is not positive. Type a rate in {unit}/s.")
    canonical_unit = canonical(unit)
    if canonical_unit not in ("mm", "in", "deg"):
        raise ParameterError(f"--unit {unit:.20}: G-code knows mm, in and deg. Type one of them.")
    readings = []
    for repeat in range(1, repeats + 1):
        for way in approach:
            for point in np.linspace(low, high, points).tolist():
                # Rounded as it is written, so that the sheet and the program name the same position.
                place = float(number(point))
                readings.append(PlannedReading(repeat, place, True, way))
                readings.append(PlannedReading(repeat, place, False, way))
    return MeasurementPlan(tuple(readings), canonical_unit, rate, hold)


def _refuse_bad_numbers(
    low: float, high: float, points: int, approach: tuple[float, ...], repeats: int, hold: float
) -> None:
    if not all(map(math.isfinite, (low, high))) or not low < high:
        raise ParameterError(
            f"--from {low:g} --to {high:g}: the second must be above the first. Type e.g. --from 0 --to 300"
        )
    if points < 2 or repeats < 1 or not 0.0 <= hold < math.inf:
        raise ParameterError(
            f"--points {points} --repeats {repeats} --hold {hold:g}: at least 2 points, 1 repeat and no negative rest."
        )
    total = 2 * points * repeats * len(approach)
    if total > POLICY.most_readings:
        raise ParameterError(
            f"--points {points} --repeats {repeats} are {total} readings, and at most {POLICY.most_readings} are "
            f"planned. Type fewer points: 13 show a screw well."
        )
    for way in approach:
        if not 0.0 < way < math.inf:
            raise ParameterError(
                f"--approach {way:g} is no way. Type one several times as long as the play, e.g. --approach 2"
            )


def _refuse_unit(form: MachineFormat, unit: str) -> None:
    units = form.dialect.units
    if unit not in units:
        raise ParameterError(
            f"{form.title} takes programs in {', '.join(units)}, not in {unit}. Type --unit {units[0]}, or another of "
            f"--machine {', '.join(MACHINES)}."
        )
