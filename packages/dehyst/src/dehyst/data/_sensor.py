"""Measures a sensor from a log of its reading and the true quantity: the figures of a data sheet."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array, Mask
from dehyst.data._closed_path import noise_of
from dehyst.data._holds import SLACK, Hold, holds_of
from dehyst.data._loop_figures import CONFIDENCE, NORMAL, ROUNDING
from dehyst.data._loop_numbers import LoopEstimate
from dehyst.data._loops import turning_points
from dehyst.data._policy import POLICY
from dehyst.data._ranges import range_over
from dehyst.data._recording import Recording, require_recordings
from dehyst.data._sensor_sheet import LINES, DataSheet, SheetFigure, with_its_unit
from dehyst.data._straight_lines import IDEAL, Line, best_line, terminal_line, zero_line
from dehyst.errors import ExcitationError, ParameterError
from dehyst.student import quantile

PLACES = 21  # at which a log without steps is read: every 5 % of the range
REACH = 0.01  # of the range: samples so near a place are read together
FITTED = 3  # samples that make a line; fewer are shifted to the place along the whole line
TAIL = 0.02  # share of a hold whose mean is its begin, or its end
STEP_END = 0.2  # share of a step whose mean is its reading
STEPS = 60  # a stroke of more samples is no table of steps
PERCENT = "%"  # of full scale
ALIKE = 0.8  # holds of this share of the longest one are averaged with it

Curves = (
    Array  # (2, m): readings at the places, rising and falling; NaN where a direction is missing
)
Measure = Callable[[Curves], tuple[float, float, str]]  # value, place and direction


class _Part(NamedTuple):
    """Samples that count and follow each other."""

    quantity: Array
    reading: Array
    time: Array  # [s], or numbers of samples
    signals: Mapping[str, Array]  # such as the temperature


@dataclass(frozen=True)
class _Slope:
    """A slope with its standard error."""

    value: float
    error: float

    def __sub__(self, other: _Slope) -> _Slope:
        return _Slope(self.value - other.value, math.hypot(self.error, other.error))


class _Samples(NamedTuple):
    """A stroke as it is read, sorted by the quantity, (n,) each."""

    quantity: Array
    reading: Array
    places: npt.NDArray[np.int64]  # in its part


@dataclass(frozen=True, eq=False)
class _Stroke:
    """A way over the whole range, in one direction."""

    part: _Part
    begin: int
    end: int  # behind the last sample
    rising: bool
    holds: tuple[Hold, ...]

    @property
    def inner_holds(self) -> list[Hold]:
        """Holds that begin and end within the stroke."""
        return [hold for hold in self.holds if self.begin < hold.begin and hold.end < self.end]

    @property
    def duration(self) -> float:
        """Time that the whole range would take at the pace between its ends. [unit of time]"""
        quantity = self.part.quantity[self.begin : self.end]
        low, high = float(np.min(quantity)), float(np.max(quantity))
        within = np.flatnonzero(np.abs(quantity - 0.5 * (low + high)) <= 0.4 * (high - low))
        if within.size < 2:
            return 0.0
        time = self.part.time[self.begin : self.end]
        return float(time[within[-1]] - time[within[0]]) / 0.8

    def samples(self, stepped: bool, near: float) -> _Samples:
        """Quantity and reading along it, sorted by the quantity: at the ends of its steps if it has some."""
        if stepped:
            points = self._steps(0.5 * near)
            quantity = [float(np.mean(self.part.quantity[point])) for point in points]
            reading = [float(np.mean(self.part.reading[point])) for point in points]
            unsorted = _Samples(
                np.array(quantity),
                np.array(reading),
                np.array([point.stop - 1 for point in points]),
            )
        else:
            places = self._moving(near)
            unsorted = _Samples(self.part.quantity[places], self.part.reading[places], places)
        order = np.argsort(unsorted.quantity, kind="stable")
        return _Samples(unsorted.quantity[order], unsorted.reading[order], unsorted.places[order])

    def _moving(self, near: float) -> npt.NDArray[np.int64]:
        """All samples between the rests at its ends, in which readings creep."""
        begin, end = self.begin, self.end
        first, last = self.part.quantity[[begin, end - 1]].tolist()
        for hold in self._overlapping:
            if abs(hold.level - first) <= near:
                begin = max(begin, hold.end - 1)
            elif abs(hold.level - last) <= near:
                end = min(end, hold.begin + 1)
        return np.arange(begin, end)

    def _steps(self, near: float) -> list[slice]:
        """Ends of its steps, where they are read."""
        usual = int(np.median([hold.end - hold.begin for hold in self.inner_holds]))
        points = []
        ends = {self.begin, self.end - 1}
        first, final = self.part.quantity[[self.begin, self.end - 1]].tolist()
        for hold in self._overlapping:
            last = hold.end
            if abs(hold.level - first) <= near:
                ends.discard(self.begin)
            elif abs(hold.level - final) <= near:
                # At the far end the sensor may be held for long to see its creep, which is no part of the curve.
                last = min(hold.end, hold.begin + usual)
                ends.discard(self.end - 1)
            size = max(1, round(STEP_END * min(usual, last - hold.begin)))
            points.append(slice(last - size, last))
        # Where it does not rest at an end, the turn itself is read.
        for place in sorted(ends):
            points.append(slice(place, place + 1))
        return points

    @property
    def _overlapping(self) -> list[Hold]:
        return [hold for hold in self.holds if hold.begin < self.end and hold.end > self.begin]


def sensor_data_sheet(
    recordings: Recording | Sequence[Recording], line: str = "terminal"
) -> DataSheet:
    """Measure a sensor as its data sheet does: non-linearity, hysteresis, repeatability, creep, combined error.

    All are percent of full scale, FS = |y(high) - y(low)|, y(x) the mean reading of both directions at a quantity x
    (ISA-51.1; makers of load cells take the rising direction alone for the linearity). With the readings u_c(x) and
    d_c(x) of the full strokes of cycle c, rising and falling, and their means u(x) and d(x):

    - non-linearity: max over x of y(x) - L(x), L the straight line through both ends ("terminal"), of the least largest
      deviation ("best"; ISA: independent), or that through the lower end ("zero"; ISA: zero-based);
    - hysteresis: max over x, its ends left out, of |d(x) - u(x)|;
    - repeatability: max over x and direction of max_c - min_c, at least two cycles;
    - zero return: d_c(low) - u_c(low), the reading behind a cycle less that before it;
    - creep: reading at the end of a hold less that at its begin, less what quantity and other signals moved it by;
    - zero, and FS, with another signal of the recordings: slope of a line through y_c(low) of the cycles beside the
      signal there, and that of y_c(high) less it;
    - combined error: max over x of |u(x) - L(x)| and |d(x) - L(x)|; rms error: of all samples, less L.

    Parameters
    ----------
    recordings
        One, or several of one sensor: input the reading, output the true quantity, as `identify` takes them.
    line
        L of sensitivity, combined error and rms error: "terminal", "best", "zero", or "ideal", L(x) = x, for a
        reading that has been corrected.

    Raises
    ------
    ExcitationError
        If a signal stands still, no stroke goes over the range, or the reading is the same at both ends.
    ParameterError
        If there is no such line.

    Notes
    -----
    A stroke counts if it goes over 90 % of the range of the quantity. A log that rests at steps is read at the end of
    each step; another one at 21 places, by a line through the samples within 1 % of the range. Intervals are of 95 %:
    from the scatter of three cycles or more, else from the noise.

    Examples
    --------
    A cubic y = x + 0.1 x (1 - x)(2 - x): from the terminal line it deviates by 0.1 x (1 - x)(2 - x).

    >>> x = np.tile(np.concatenate([np.linspace(0.0, 1.0, 500), np.linspace(1.0, 0.0, 500)]), 3)
    >>> sheet = sensor_data_sheet(Recording(x + 0.1 * x * (1 - x) * (2 - x), x))
    >>> figure = sheet.figures["terminal"]
    >>> round(figure.value.value, 2), round(figure.place, 2), round(sheet.figures["best"].value.value, 2)
    (3.84, 0.4, 1.92)
    """
    records = require_recordings(recordings)
    if line not in LINES:
        raise ParameterError(
            f"line {line!r:.40} is unknown; there are: {', '.join(LINES)}.", line=line
        )
    return _Measured(records, line).sheet()


class _Measured:
    """Strokes of a log, read at common places."""

    def __init__(self, records: Sequence[Recording], line: str) -> None:
        self.records = records
        self.line_name = line
        self.parts = _parts(records)
        self.low, self.high = range_over([part.quantity for part in self.parts])
        self.span = self.high - self.low
        if not self.span > 0.0:
            raise _still(records[0].output_name, "quantity", "--quantity COLUMN")
        lowest, highest = range_over([part.reading for part in self.parts])
        if not highest > lowest:
            raise _still(records[0].input_name, "reading", "--reading COLUMN")
        self.noise = max(noise_of(part.reading) for part in self.parts)
        self.strokes, self.pairs, self.holds = self._strokes()
        rests = [len(stroke.inner_holds) for stroke in self.strokes]
        self.stepped = float(np.median(rests)) >= POLICY.fewest_steps
        near = 2.0 * POLICY.hold_band * self.span
        self.samples = [stroke.samples(self.stepped, near) for stroke in self.strokes]
        self.low = max(float(samples.quantity[0]) for samples in self.samples)
        self.high = min(float(samples.quantity[-1]) for samples in self.samples)
        self.places = self._places([samples.quantity for samples in self.samples])
        ways = [np.ptp(samples.quantity) for samples in self.samples]
        rises = [samples.reading[-1] - samples.reading[0] for samples in self.samples]
        slope = float(np.mean(np.array(rises) / np.array(ways)))
        reach = (1.0 + SLACK) * REACH * self.span
        curves = [_read(samples, self.places, reach, slope) for samples in self.samples]
        self.curves = np.array(curves)
        self.rising = np.array([stroke.rising for stroke in self.strokes])
        self.mean = self._mean_curves()
        middle = _middle(self.mean)
        self.output = float(middle[-1] - middle[0])
        if abs(self.output) < POLICY.least_output * (highest - lowest):
            raise ExcitationError(
                f"the reading '{records[0].input_name}' is {middle[0]:.4g} at the lower end of the quantity and "
                f"{middle[-1]:.4g} at the upper one, of its range {lowest:.4g} to {highest:.4g}: without a full-scale "
                f"output there is nothing that figures could be percent of. Cut the log to a range over which the "
                f"reading rises or falls, or name other columns: --reading COLUMN --quantity COLUMN.",
                output=self.output,
            )
        self.full_scale = abs(self.output)
        self.line = self._line_of(line, middle)

    def _strokes(self) -> tuple[list[_Stroke], list[tuple[int, int]], list[tuple[_Part, Hold]]]:
        """Full strokes, the cycles as pairs of a rising and a falling one, and all holds."""
        bare: list[tuple[int, _Stroke]] = []
        longest = (0.0, 0.0, 0.0)
        for number, part in enumerate(self.parts):
            turns = turning_points(part.quantity, POLICY.turn_fraction * self.span).tolist()
            for first, last in itertools.pairwise(turns):
                a, b = float(part.quantity[first]), float(part.quantity[last])
                longest = max(longest, (abs(b - a), a, b))
                if abs(b - a) >= POLICY.full_stroke * self.span:
                    bare.append((number, _Stroke(part, first, last + 1, b > a, ())))
        if not bare:
            raise self._no_stroke(*longest)
        self.duration = float(np.median([stroke.duration for _, stroke in bare]))
        holds: list[list[Hold]] = []
        for part in self.parts:
            least = POLICY.hold_time * self.duration
            holds.append(holds_of(part.quantity, part.time, least, POLICY.hold_band * self.span))
        strokes = []
        for number, stroke in bare:
            own = tuple(holds[number])
            strokes.append(_Stroke(stroke.part, stroke.begin, stroke.end, stroke.rising, own))
        # A cycle rises first, as calibrations do; where none does, it falls first.
        pairs = _paired(strokes, True)
        if not pairs:
            pairs = [(after, before) for before, after in _paired(strokes, False)]
        rests = []
        for part, part_holds in zip(self.parts, holds, strict=True):
            rests += [(part, hold) for hold in part_holds]
        return strokes, pairs, rests

    def _no_stroke(self, way: float, begin: float, end: float) -> ExcitationError:
        record = self.records[0]
        unit = record.output_unit
        return ExcitationError(
            f"no stroke of the quantity '{record.output_name}' goes over its range, "
            f"{with_its_unit(self.low, unit)} to {with_its_unit(self.high, unit)}: the longest one goes from "
            f"{with_its_unit(begin, unit)} to {with_its_unit(end, unit)}, {100.0 * way / self.span:.0f} % of it. "
            f"Figures of a data sheet are those of strokes over at least {100 * POLICY.full_stroke:g} %. Log the "
            f"sensor from its lowest quantity to its highest and back, three times or more.",
            share=way / self.span,
        )

    def _places(self, quantities: Sequence[Array]) -> Array:
        """Levels that all strokes share, if they are tables of steps; else evenly spaced places."""
        levels = quantities[0]
        near = POLICY.hold_band * self.span
        if 2 < levels.size <= STEPS and float(np.min(np.diff(levels))) > near:
            alike = []
            for quantity in quantities:
                same = quantity.size == levels.size
                alike.append(same and float(np.max(np.abs(quantity - levels))) <= near)
            if all(alike):
                return np.asarray(np.clip(np.mean(quantities, axis=0), self.low, self.high))
        return np.linspace(self.low, self.high, PLACES)

    def _mean_curves(self) -> Curves:
        """Mean reading of each direction, (2, m)."""
        mean = np.full((2, self.places.size), np.nan)
        for row, rising in enumerate((True, False)):
            if np.any(self.rising == rising):
                mean[row] = np.mean(self.curves[self.rising == rising], axis=0)
        return mean

    def _line_of(self, name: str, middle: Array) -> Line:
        lines = {"terminal": terminal_line, "best": best_line, "zero": zero_line}
        if name == "ideal":
            return IDEAL
        return lines[name](self.places, middle)

    @property
    def cycles(self) -> list[Curves]:
        """Readings of each cycle; of strokes alone where there is one direction only."""
        if self.pairs:
            return [self.curves[list(pair)] for pair in self.pairs]
        curves = []
        for curve, rising in zip(self.curves, self.rising, strict=True):
            other = np.full(curve.size, np.nan)
            curves.append(np.array([curve, other] if rising else [other, curve]))
        return curves

    def sheet(self) -> DataSheet:
        """Return the data sheet."""
        record = self.records[0]
        reading, quantity = record.input_unit, record.output_unit
        slope_unit = ""
        if reading and quantity:
            divisor = quantity
            if "/" in divisor:
                divisor = f"({divisor})"
            slope_unit = f"({reading})/{divisor}" if "/" in reading else f"{reading}/{divisor}"
        units = {"reading": reading, "quantity": quantity, "slope": slope_unit, "percent": PERCENT}
        self.effects = self._effects()
        creep, holds = self._creeps()
        figures = {
            "zero": self._figure(lambda curves: self._plain(_middle(curves)[0]), reading),
            "output": self._figure(
                lambda curves: self._plain(_middle(curves)[-1] - _middle(curves)[0]), reading
            ),
            "sensitivity": self._figure(self._slope, slope_unit, self.span),
            "terminal": self._figure(lambda curves: self._bend(curves, terminal_line)),
            "best": self._figure(lambda curves: self._bend(curves, best_line)),
            "through_zero": self._figure(lambda curves: self._bend(curves, zero_line)),
            "hysteresis": self._hysteresis(),
            "repeatability": self._repeatability(),
            "zero_return": self._zero_return(),
            **creep,
            "combined": self._figure(self._combined),
            "rms": self._rms(),
            **self.effects,
        }
        if self.line_name == "ideal":
            del figures["sensitivity"]
        return DataSheet(
            figures=figures,
            line_name=self.line_name,
            line=self.line,
            places=self.places,
            rising=self.curves[self.rising],
            falling=self.curves[~self.rising],
            cycles=tuple(self._numbered(pair) for pair in self.pairs),
            low=self.low,
            high=self.high,
            full_scale=self.full_scale,
            stepped=self.stepped,
            holds=holds,
            notes=self._notes(),
            units=units,
            name=record.name,
            reading_name=record.input_name,
            quantity_name=record.output_name,
        )

    def _numbered(self, pair: tuple[int, int]) -> tuple[int, int]:
        """Numbers of two strokes among those of their direction."""
        before = np.cumsum(self.rising) - 1, np.cumsum(~self.rising) - 1
        return int(before[0][pair[0]]), int(before[1][pair[1]])

    def _figure(self, measure: Measure, unit: str = PERCENT, per: float = 1.0) -> SheetFigure:
        """Measure the mean of the cycles, and each of them: their scatter makes the interval.

        A reading that errs by 1 makes the figure err by 1 / `per`.
        """
        value, place, direction = measure(self.mean)
        each = np.array([measure(cycle)[0] for cycle in self.cycles])
        worst = int(np.argmax(np.abs(each)))
        error = math.sqrt(2.0) * self.noise / per
        if unit == PERCENT:
            error *= 100.0 / self.full_scale
        estimate = _estimate(value, each, error, unit)
        if unit != PERCENT:
            return SheetFigure(estimate, count=each.size)
        return SheetFigure(
            estimate,
            worst=float(each[worst]),
            cycle=worst + 1,
            place=place,
            direction=direction,
            count=each.size,
        )

    def _plain(self, value: float) -> tuple[float, float, str]:
        return float(value), math.nan, ""

    def _slope(self, curves: Curves) -> tuple[float, float, str]:
        return self._plain(self._line_of(self.line_name, _middle(curves)).slope)

    def _percent(self, deviation: Array) -> Array:
        return np.asarray(100.0 * deviation / self.full_scale)

    def _bend(
        self, curves: Curves, line: Callable[[Array, Array], Line]
    ) -> tuple[float, float, str]:
        """Largest deviation of the mean of both directions from its own line."""
        middle = _middle(curves)
        deviation = self._percent(middle - line(self.places, middle).at(self.places))
        place = int(np.argmax(np.abs(deviation)))
        value = float(deviation[place])
        # From the best line the largest deviations to both sides are equal: rounding would choose the sign.
        if line is not terminal_line:
            value = abs(value)
        return value, float(self.places[place]), ""

    def _combined(self, curves: Curves) -> tuple[float, float, str]:
        deviation = np.abs(self._percent(curves - self.line.at(self.places)))
        row, place = np.unravel_index(int(np.nanargmax(deviation)), deviation.shape)
        direction = ("rising", "falling")[int(row)]
        return float(deviation[row, place]), float(self.places[place]), direction

    def _hysteresis(self) -> SheetFigure:
        if not self.pairs:
            return self._one_way()
        inner = slice(1, -1)

        def measure(curves: Curves) -> tuple[float, float, str]:
            apart = np.abs(self._percent(curves[1, inner] - curves[0, inner]))
            place = int(np.argmax(apart))
            return float(apart[place]), float(self.places[inner][place]), ""

        return self._figure(measure)

    def _zero_return(self) -> SheetFigure:
        if not self.pairs:
            return self._one_way()
        up, down = self.pairs[0]
        if up > down:
            return _unknown(
                "the cycles of this log begin at the upper end; log some from the lower one"
            )
        return self._figure(
            lambda curves: (
                float(self._percent(curves[1, :1] - curves[0, :1])[0]),
                float(self.places[0]),
                "",
            )
        )

    def _one_way(self) -> SheetFigure:
        """A figure that needs both directions, of a log that has one."""
        what = "no rising and falling stroke next to each other"
        if np.all(self.rising):
            what = "rising strokes only"
        elif not np.any(self.rising):
            what = "falling strokes only"
        return _unknown(
            f"this log has {what}; log strokes over the whole range in both directions, one behind the other"
        )

    def _repeatability(self) -> SheetFigure:
        """Largest spread of strokes of one direction."""
        best = (-1.0, 0, 0)
        counts = []
        for row, rising in enumerate((True, False)):
            strokes = self.curves[self.rising == rising]
            counts.append(len(strokes))
            if len(strokes) >= 2:
                spread = np.ptp(self._percent(strokes), axis=0)
                place = int(np.argmax(spread))
                best = max(best, (float(spread[place]), row, place))
        if max(counts) < 2:
            return _unknown(
                "this log has no two strokes of one direction; log three cycles or more"
            )
        value, row, place = best
        estimate = LoopEstimate(value, value, value, PERCENT)
        return SheetFigure(
            estimate,
            place=float(self.places[place]),
            direction=("rising", "falling")[row],
            count=counts[row],
        )

    def _rms(self) -> SheetFigure:
        squares, count = 0.0, 0
        for part in self.parts:
            left = self._percent(part.reading - self.line.at(part.quantity))
            squares += float(left @ left)
            count += left.size
        value = math.sqrt(squares / count)
        return SheetFigure(LoopEstimate(value, value, value, PERCENT), count=count)

    def _creeps(self) -> tuple[dict[str, SheetFigure], Array]:
        """Creep at both ends, and the holds that it is measured on."""
        figures = {}
        drawn: list[tuple[float, float, float]] = []
        within = POLICY.creep_end * (self.high - self.low)
        for name, end in (("creep_upper", self.high), ("creep_lower", self.low)):
            holds = [
                (part, hold)
                for part, hold in self.holds
                if abs(hold.level - end) <= within and self._seconds(part, hold) >= self._least
            ]
            if self.records[0].time is None:
                figures[name] = _unknown("the log has no time: creep is a change with time")
            elif not holds:
                figures[name] = _unknown(
                    f"no hold of {self._least:.3g} s or more in this log, within "
                    f"{100 * POLICY.creep_end:g} % of the range from that end; hold the quantity there at rest, for "
                    f"30 min to compare with data sheets"
                )
            else:
                figures[name] = self._creep(holds, drawn)
        return figures, np.array(drawn).reshape(-1, 3)

    @property
    def _least(self) -> float:
        return POLICY.creep_time * self.duration

    def _seconds(self, part: _Part, hold: Hold) -> float:
        return float(part.time[hold.end - 1] - part.time[hold.begin])

    def _creep(
        self, holds: Sequence[tuple[_Part, Hold]], drawn: list[tuple[float, float, float]]
    ) -> SheetFigure:
        """Creep over the same time in the longest hold, and in those that are about as long."""
        longest = max(self._seconds(part, hold) for part, hold in holds)
        holds = [pair for pair in holds if self._seconds(*pair) >= ALIKE * longest]
        seconds = min(self._seconds(part, hold) for part, hold in holds)
        each, levels, errors = [], [], []
        for part, hold in holds:
            last = part.time[hold.begin] + seconds
            end = hold.begin + int(np.searchsorted(part.time[hold.begin : hold.end], last, "right"))
            size = max(1, round(TAIL * (end - hold.begin)))
            # A quantity that is not quite at rest moves the reading too, and so does the temperature.
            still = self._at_rest(part)
            each.append(
                float(
                    np.mean(still[end - size : end])
                    - np.mean(still[hold.begin : hold.begin + size])
                )
            )
            levels.append(hold.level)
            errors.append(100.0 * self.noise / self.full_scale * math.sqrt(2.0 / size))
            begin = part.reading[hold.begin : hold.begin + size] - self.line.at(
                part.quantity[hold.begin : hold.begin + size]
            )
            first = float(np.mean(self._percent(begin)))
            drawn.append((hold.level, first, first + each[-1]))
        values = np.array(each)
        estimate = _estimate(float(np.mean(values)), values, max(errors), PERCENT)
        worst = int(np.argmax(np.abs(values)))
        return SheetFigure(
            estimate,
            worst=float(values[worst]),
            place=float(np.mean(levels)),
            seconds=seconds,
            count=values.size,
        )

    def _effects(self) -> dict[str, SheetFigure]:
        """What another signal does to zero and full-scale output: slopes of lines through the cycles, at both ends."""
        effects = {}
        pairs: Sequence[tuple[int, ...]] = self.pairs or [(k,) for k in range(len(self.strokes))]
        middle = np.array([self._percent(_middle(curves)) for curves in self.cycles])
        for name, unit in self.records[0].schedule_units.items():
            ends = np.empty((len(pairs), 2))
            for number, pair in enumerate(pairs):
                values = []
                for k in pair:
                    signal = self.strokes[k].part.signals[name]
                    values.append(signal[self.samples[k].places[[0, -1]]])
                ends[number] = np.mean(values, axis=0)
            unit = f"%/{unit or 'unit'}"
            low = _slope_along(ends[:, 0], middle[:, 0])
            high = _slope_along(ends[:, 1], middle[:, -1])
            for figure, slope in (("zero", low), ("output", high - low)):
                effects[f"{figure} with {name}"] = self._effect(slope, unit, name)
        return effects

    def _effect(self, slope: _Slope, unit: str, name: str) -> SheetFigure:
        count = len(self.cycles)
        if not math.isfinite(slope.error):
            return _unknown(
                f"this log has {len(self.pairs)} cycles, or {name} is the same in all; log {POLICY.fewest_scatter} or "
                f"more at several values"
            )
        reach = quantile(CONFIDENCE, count - 2) * slope.error
        estimate = LoopEstimate(slope.value, slope.value - reach, slope.value + reach, unit)
        return SheetFigure(estimate, count=count)

    def _at_rest(self, part: _Part) -> Array:
        """Reading less what the quantity and other signals move it, (T,): what creeps is left. [%]"""
        share = (part.quantity - self.low) / (self.high - self.low)
        left = self._percent(part.reading - self.output * share)
        for name, values in part.signals.items():
            zero, output = self.effects[f"zero with {name}"], self.effects[f"output with {name}"]
            if not zero.why:
                left = left - (zero.value.value + output.value.value * share) * values
        return np.asarray(left)

    def _notes(self) -> tuple[str, ...]:
        notes = []
        if len(self.cycles) < POLICY.fewest_scatter:
            notes.append(
                f"intervals are those of the noise alone; from {POLICY.fewest_scatter} cycles on they are those of the "
                f"scatter, and this log has {len(self.pairs)}"
            )
        whole = self._spread_of(slice(None))
        without = self._spread_of(slice(1, None))
        certain = whole > 100.0 * ROUNDING and len(self.cycles) >= POLICY.fewest_scatter
        if certain and without <= POLICY.first_cycle * whole:
            notes.append(
                f"without the first cycle the repeatability is {without:.2g} %: the first one is that of a sensor that "
                f"has rested. Standards load it to the end three times before they measure; leave that out with --from"
            )
        return tuple(notes)

    def _spread_of(self, part: slice) -> float:
        spreads = [0.0]
        for rising in (True, False):
            strokes = self.curves[self.rising == rising][part]
            if len(strokes) >= 2:
                spreads.append(float(np.max(np.ptp(self._percent(strokes), axis=0))))
        return max(spreads)


def _paired(strokes: Sequence[_Stroke], rising: bool) -> list[tuple[int, int]]:
    """Numbers of strokes of which the first one rises, or falls, and the second one leads back at once."""
    pairs = []
    for k in range(1, len(strokes)):
        before, after = strokes[k - 1], strokes[k]
        back = before.part is after.part and before.end == after.begin + 1
        if back and before.rising == rising and after.rising != rising:
            pairs.append((k - 1, k))
    return pairs


def _parts(records: Sequence[Recording]) -> list[_Part]:
    """Samples that count, piece by piece."""
    parts = []
    for record in records:
        counts: Mask = np.ones(len(record), dtype=np.bool_)
        counts[list(record.left_out)] = False
        for piece in record.pieces:
            rows = piece.start + np.flatnonzero(counts[piece])
            if not rows.size:
                continue
            time = rows.astype(np.float64)
            if record.time is not None:
                time = record.time[rows]
            signals = {name: values[rows] for name, values in record.schedules.items()}
            parts.append(_Part(record.output[rows], record.input[rows], time, signals))
    return parts


def _read(samples: _Samples, places: Array, reach: float, slope: float) -> Array:
    """Readings of a stroke at places, (m,): by a line through the samples near each, or between those beside it."""
    quantity, reading, _ = samples
    values = np.interp(places, quantity, reading)
    for k, place in enumerate(places.tolist()):
        first = int(np.searchsorted(quantity, place - reach, "left"))
        last = int(np.searchsorted(quantity, place + reach, "right"))
        near, at = quantity[first:last] - place, reading[first:last]
        if near.size >= FITTED and float(np.ptp(near)) > 0.1 * reach:
            centred = near - np.mean(near)
            own = float(centred @ at) / float(centred @ centred)
            values[k] = float(np.mean(at)) - own * float(np.mean(near))
        elif near.size:
            values[k] = float(np.mean(at - slope * near))
    return np.asarray(values)


def _middle(curves: Curves) -> Array:
    """Mean of both directions, (m,); the one there is where the other is missing."""
    if np.isnan(curves[0, 0]):
        return np.asarray(curves[1])
    if np.isnan(curves[1, 0]):
        return np.asarray(curves[0])
    return np.asarray(0.5 * (curves[0] + curves[1]))


def _estimate(value: float, each: Array, error: float, unit: str) -> LoopEstimate:
    """A figure with its interval: that of the scatter of single ones, and no less than the noise makes."""
    # Curves that are equal but for rounding differ by nothing.
    if unit == PERCENT and abs(value) < 100.0 * ROUNDING:
        value = 0.0
    reach = quantile(CONFIDENCE, NORMAL) * error / math.sqrt(each.size)
    if each.size >= POLICY.fewest_scatter:
        scatter = float(np.std(each, ddof=1)) / math.sqrt(each.size)
        reach = max(reach, quantile(CONFIDENCE, each.size - 1) * scatter)
    return LoopEstimate(value, value - reach, value + reach, unit)


def _slope_along(signal: Array, each: Array) -> _Slope:
    """Slope of a line through a number of each cycle beside a signal; without an error if there is no such line."""
    count = each.size
    centred = signal - np.mean(signal)
    spread = float(centred @ centred)
    if count < POLICY.fewest_scatter or not spread > 0.0:
        return _Slope(math.nan, math.nan)
    slope = float(centred @ each) / spread
    left = each - np.mean(each) - slope * centred
    return _Slope(slope, math.sqrt(float(left @ left) / (count - 2) / spread))


def _unknown(why: str) -> SheetFigure:
    return SheetFigure(LoopEstimate(math.nan, math.nan, math.nan, PERCENT), why=why)


def _still(name: str, role: str, cure: str) -> ExcitationError:
    return ExcitationError(
        f"the {role} '{name}' stands still, so it tells nothing about the sensor. Check what was logged, or name "
        f"another column: {cure}.",
        name=name,
    )
