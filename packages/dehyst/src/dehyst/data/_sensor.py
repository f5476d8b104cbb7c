"""Measures a sensor from a log of its reading and the true quantity: the figures of a data sheet."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from dehyst.arrays import Array
from dehyst.data._holds import SLACK, Hold, holds_of
from dehyst.data._loop_figures import CONFIDENCE, NORMAL, ROUNDING
from dehyst.data._loop_numbers import LoopEstimate
from dehyst.data._loops import turning_points
from dehyst.data._policy import POLICY
from dehyst.data._ranges import range_over
from dehyst.data._recording import Recording, require_recordings
from dehyst.data._sensor_sheet import LINES, DataSheet, SheetFigure, with_its_unit
from dehyst.data._sensor_strokes import SensorPart, Stroke, paired, read_at, sensor_parts
from dehyst.data._straight_lines import IDEAL, StraightLine, best_line, terminal_line, zero_line
from dehyst.errors import ExcitationError, ParameterError
from dehyst.student import quantile

PLACES = 21  # at which a log without steps is read: every 5 % of the range
REACH = 0.01  # of the range: samples so near a place are read together
TAIL = 0.02  # share of a hold, its begin or its end, whose mean is taken at most
FEWEST_IN_LINE = 4  # samples that tell how fast the reading creeps there, and its noise
STEPS = 60  # a stroke of more samples is no table of steps
PERCENT = "%"  # of full scale
ALIKE = 0.8  # holds of this share of the longest one are averaged with it
DIRECTIONS = ("rising", "falling")

# Readings at the places, rising and falling, (2, m); NaN where a direction is missing.
Curves = Array
# Deviations at the places, (m,), or for each direction, (2, m). [%]
Profile = Callable[[Curves], Array]


@dataclass(frozen=True)
class _Slope:
    """A slope with its standard error."""

    value: float
    error: float

    def __sub__(self, other: _Slope) -> _Slope:
        return _Slope(self.value - other.value, math.hypot(self.error, other.error))


@dataclass(frozen=True)
class _End:
    """Begin or end of a hold: mean of `count` samples, its standard error, and what creep within them moves it by."""

    value: float
    error: float
    bias: float
    count: int


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
        self.parts = sensor_parts(records)
        self.low, self.high = range_over([part.quantity for part in self.parts])
        self.span = self.high - self.low
        if not self.span > 0.0:
            raise _still(records[0].output_name, "quantity", "--quantity COLUMN")
        lowest, highest = range_over([part.reading for part in self.parts])
        if not highest > lowest:
            raise _still(records[0].input_name, "reading", "--reading COLUMN")
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
        read = [read_at(samples, self.places, reach, slope) for samples in self.samples]
        self.curves = np.array([values for values, _ in read])
        # Standard error of a reading at a place; not known, and 0, for a table of single rows.
        squares = np.array([errors for _, errors in read]) ** 2
        self.noise = 0.0
        if np.any(np.isfinite(squares)):
            self.noise = math.sqrt(float(np.nanmean(squares)))
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
        self.effects = self._effects()

    def _strokes(self) -> tuple[list[Stroke], list[tuple[int, int]], list[tuple[SensorPart, Hold]]]:
        """Full strokes, the cycles as pairs of a rising and a falling one, and all holds."""
        bare: list[tuple[int, Stroke]] = []
        longest = (0.0, 0.0, 0.0)
        for number, part in enumerate(self.parts):
            turns = turning_points(part.quantity, POLICY.turn_fraction * self.span).tolist()
            for first, last in itertools.pairwise(turns):
                a, b = float(part.quantity[first]), float(part.quantity[last])
                longest = max(longest, (abs(b - a), a, b))
                if abs(b - a) >= POLICY.full_stroke * self.span:
                    bare.append((number, Stroke(part, first, last + 1, b > a, ())))
        if not bare:
            raise self._no_stroke(*longest)
        self.duration = float(np.median([stroke.duration for _, stroke in bare]))
        holds: list[list[Hold]] = []
        for part in self.parts:
            least = POLICY.hold_time * self.duration
            holds.append(holds_of(part.quantity, part.time, least, POLICY.hold_band * self.span))
        strokes = []
        for number, stroke in bare:
            stroke_holds = tuple(holds[number])
            strokes.append(
                Stroke(stroke.part, stroke.begin, stroke.end, stroke.rising, stroke_holds)
            )
        # A cycle rises first, as calibrations do; where none does, it falls first.
        pairs = paired(strokes, True, self.span)
        if not pairs:
            pairs = [(after, before) for before, after in paired(strokes, False, self.span)]
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
        """Mean reading of each direction, (2, m): of the cycles, else of all strokes of a direction."""
        if self.pairs:
            return np.asarray(np.mean(self.cycles, axis=0))
        mean = np.full((2, self.places.size), np.nan)
        for row, rising in enumerate((True, False)):
            if np.any(self.rising == rising):
                mean[row] = np.mean(self.curves[self.rising == rising], axis=0)
        return mean

    def _line_of(self, name: str, middle: Array) -> StraightLine:
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
            missing = np.full(curve.size, np.nan)
            curves.append(np.array([curve, missing] if rising else [missing, curve]))
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
        creep, holds = self._creeps()
        figures = {
            "zero": self._number(lambda curves: float(_middle(curves)[0]), reading),
            "output": self._number(
                lambda curves: float(_middle(curves)[-1] - _middle(curves)[0]), reading
            ),
            "sensitivity": self._number(
                lambda curves: self._line_of(self.line_name, _middle(curves)).slope,
                slope_unit,
                self.span,
            ),
            "terminal": self._bend(terminal_line, True),
            "best": self._bend(best_line),
            "through_zero": self._bend(zero_line),
            "hysteresis": self._hysteresis(),
            "repeatability": self._repeatability(),
            "zero_return": self._zero_return(),
            **creep,
            "combined": self._largest(
                lambda curves: self._percent(curves - self.line.at(self.places)), self.places
            ),
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
            mean=self.mean,
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

    def _number(
        self, number: Callable[[Curves], float], unit: str, per: float = 1.0
    ) -> SheetFigure:
        """A number of the whole range; a reading that errs by 1 makes it err by 1 / `per`."""
        of_cycles = np.array([number(cycle) for cycle in self.cycles])
        error = math.sqrt(2.0) * self.noise / per
        return SheetFigure(
            _estimate(number(self.mean), of_cycles, error, unit), count=of_cycles.size
        )

    def _largest(self, profile: Profile, places: Array, signed: bool = False) -> SheetFigure:
        """The largest deviation of the mean of the cycles, their scatter there, and the largest of a single cycle."""
        mean = profile(self.mean)
        size = np.nan_to_num(np.abs(mean))
        # Of places where it is as large but for rounding the first one is named.
        index = np.unravel_index(int(np.argmax(size >= (1.0 - SLACK) * np.max(size))), mean.shape)
        value = float(mean[index])
        sign = 1.0
        if not signed:
            sign = math.copysign(1.0, value)
        cycles = [profile(cycle) for cycle in self.cycles]
        of_cycles = np.array([sign * cycle[index] for cycle in cycles])
        # Of strokes without a partner some have another direction.
        of_cycles = of_cycles[np.isfinite(of_cycles)]
        error = math.sqrt(2.0) * 100.0 * self.noise / self.full_scale
        largest = [float(np.nanmax(np.abs(cycle))) for cycle in cycles]
        worst = int(np.argmax(largest))
        direction = ""
        if mean.ndim == 2:
            direction = DIRECTIONS[int(index[0])]
        return SheetFigure(
            _estimate(sign * value, of_cycles, error, PERCENT),
            worst=_nothing(largest[worst]),
            cycle=worst + 1,
            place=float(places[index[-1]]),
            direction=direction,
            count=of_cycles.size,
        )

    def _percent(self, deviation: Array) -> Array:
        return np.asarray(100.0 * deviation / self.full_scale)

    def _bend(
        self, line: Callable[[Array, Array], StraightLine], signed: bool = False
    ) -> SheetFigure:
        """Largest deviation of the mean of both directions from its own line."""

        def profile(curves: Curves) -> Array:
            middle = _middle(curves)
            return self._percent(middle - line(self.places, middle).at(self.places))

        return self._largest(profile, self.places, signed)

    def _hysteresis(self) -> SheetFigure:
        if not self.pairs:
            return self._one_way()
        inner = slice(1, -1)
        return self._largest(
            lambda curves: self._percent(curves[1, inner] - curves[0, inner]), self.places[inner]
        )

    def _zero_return(self) -> SheetFigure:
        if not self.pairs:
            return self._one_way()
        up, down = self.pairs[0]
        if up > down:
            return _unknown(
                "the cycles of this log begin at the upper end; log some from the lower one"
            )
        return self._largest(
            lambda curves: self._percent(curves[1, :1] - curves[0, :1]), self.places[:1], True
        )

    def _one_way(self) -> SheetFigure:
        """A figure that needs both directions, of a log that has one."""
        directions = "no rising and falling stroke next to each other"
        if np.all(self.rising):
            directions = "rising strokes only"
        elif not np.any(self.rising):
            directions = "falling strokes only"
        return _unknown(
            f"this log has {directions}; log strokes over the whole range in both directions, one behind the other"
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
                best = max(best, (_nothing(float(spread[place])), row, place))
        if max(counts) < 2:
            return _unknown(
                "this log has no two strokes of one direction; log three cycles or more"
            )
        value, row, place = best
        estimate = LoopEstimate(value, value, value, PERCENT)
        return SheetFigure(
            estimate,
            place=float(self.places[place]),
            direction=DIRECTIONS[row],
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

    def _seconds(self, part: SensorPart, hold: Hold) -> float:
        return float(part.time[hold.end - 1] - part.time[hold.begin])

    def _creep(
        self, holds: Sequence[tuple[SensorPart, Hold]], drawn: list[tuple[float, float, float]]
    ) -> SheetFigure:
        """Creep over the same time in the longest hold, and in those that are about as long."""
        longest = max(self._seconds(part, hold) for part, hold in holds)
        holds = [pair for pair in holds if self._seconds(*pair) >= ALIKE * longest]
        seconds = min(self._seconds(part, hold) for part, hold in holds)
        changes, levels, errors, biases = [], [], [], []
        for part, hold in holds:
            last = part.time[hold.begin] + seconds
            end = hold.begin + int(np.searchsorted(part.time[hold.begin : hold.end], last, "right"))
            size = max(1, round(TAIL * (end - hold.begin)))
            # A quantity that is not quite at rest moves the reading too, and so does the temperature.
            still = self._at_rest(part)[hold.begin : end]
            times = part.time[hold.begin : end]
            begin = _end_of(still, times, size)
            last_end = _end_of(still[::-1], times[::-1], size)
            changes.append(last_end.value - begin.value)
            levels.append(hold.level)
            errors.append(math.hypot(begin.error, last_end.error))
            biases.append(begin.bias + last_end.bias)
            head = slice(hold.begin, hold.begin + begin.count)
            away = part.reading[head] - self.line.at(part.quantity[head])
            first = float(np.mean(self._percent(away)))
            drawn.append((hold.level, first, first + changes[-1]))
        values = np.array(changes)
        # What a mean leaves out is alike in all holds: it does not average out.
        estimate = _estimate(
            float(np.mean(values)), values, max(errors), PERCENT, float(np.mean(biases))
        )
        worst = int(np.argmax(np.abs(values)))
        return SheetFigure(
            estimate,
            worst=_nothing(float(values[worst])),
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
            # A signal that another recording lacks tells nothing of it.
            if not all(name in part.signals for part in self.parts):
                continue
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

    def _at_rest(self, part: SensorPart) -> Array:
        """Reading less what the quantity and other signals move it, (T,): what creeps is left. [%]"""
        share = (part.quantity - self.low) / (self.high - self.low)
        left = self._percent(part.reading - self.output * share)
        for name, values in part.signals.items():
            zero = self.effects.get(f"zero with {name}")
            if zero is not None and not zero.why:
                output = self.effects[f"output with {name}"]
                left = left - (zero.value.value + output.value.value * share) * values
        return np.asarray(left)

    def _notes(self) -> tuple[str, ...]:
        notes = []
        if len(self.cycles) < POLICY.fewest_scatter:
            notes.append(
                f"intervals are those of the noise alone; from {POLICY.fewest_scatter} cycles on they are those of the "
                f"scatter, and this log has {len(self.pairs)}"
            )
        names = self._within_noise()
        if names:
            percent = 100.0 * self.noise / self.full_scale
            notes.append(
                f"{' and '.join(names)}: no more than the noise of the readings makes, which is {percent:.2g} % rms at "
                f"each place; the sensor's own may be less"
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

    def _within_noise(self) -> list[str]:
        """Figures that noise alone would make as large: they are the largest of many places."""
        error = 100.0 * self.noise / self.full_scale
        hysteresis = self._hysteresis()
        names = []
        limit = POLICY.above_noise * math.sqrt(2.0 / max(1, len(self.pairs))) * error
        if not hysteresis.why and 0.0 < hysteresis.value.value <= limit:
            names.append("hysteresis")
        if 0.0 < self._spread_of(slice(None)) <= 2.0 * POLICY.above_noise * error:
            names.append("repeatability")
        return names

    def _spread_of(self, part: slice) -> float:
        spreads = [0.0]
        for rising in (True, False):
            strokes = self.curves[self.rising == rising][part]
            if len(strokes) >= 2:
                spreads.append(float(np.max(np.ptp(self._percent(strokes), axis=0))))
        return _nothing(max(spreads))


def _middle(curves: Curves) -> Array:
    """Mean of both directions, (m,); the one there is where the other is missing."""
    if np.isnan(curves[0, 0]):
        return np.asarray(curves[1])
    if np.isnan(curves[1, 0]):
        return np.asarray(curves[0])
    return np.asarray(0.5 * (curves[0] + curves[1]))


def _end_of(values: Array, times: Array, most: int) -> _End:
    """The first of values that creep: the mean of as many as make noise and bias least together, at most so many."""
    window = max(most, FEWEST_IN_LINE)
    if values.size < 2 * window:
        mean = float(np.mean(values[:most]))
        return _End(mean, float(np.std(values[:most])) / math.sqrt(most), 0.0, most)
    seconds = np.abs(times[:window] - times[0])
    rate, level = np.polyfit(seconds, values[:window], 1)
    left = values[:window] - rate * seconds - level
    noise = math.sqrt(float(left @ left) / (window - 2))
    counts = np.arange(1, most + 1)
    errors = noise / np.sqrt(counts)
    biases = abs(float(rate)) * np.cumsum(seconds[:most]) / counts
    count = int(np.argmin(np.hypot(errors, biases))) + 1
    mean = float(np.mean(values[:count]))
    return _End(mean, float(errors[count - 1]), float(biases[count - 1]), count)


def _estimate(
    value: float, of_cycles: Array, error: float, unit: str, bias: float = 0.0
) -> LoopEstimate:
    """A figure with its interval: that of the scatter of single ones, no less than the noise makes, and a bias."""
    if unit == PERCENT:
        value = _nothing(value)
    reach = quantile(CONFIDENCE, NORMAL) * error / math.sqrt(of_cycles.size)
    if of_cycles.size >= POLICY.fewest_scatter:
        scatter = float(np.std(of_cycles, ddof=1)) / math.sqrt(of_cycles.size)
        reach = max(reach, quantile(CONFIDENCE, of_cycles.size - 1) * scatter)
    reach += bias
    if unit == PERCENT:
        reach = _nothing(reach)
    return LoopEstimate(value, value - reach, value + reach, unit)


def _slope_along(signal: Array, of_cycles: Array) -> _Slope:
    """Slope of a line through a number of each cycle beside a signal; without an error if there is no such line."""
    count = of_cycles.size
    centred = signal - np.mean(signal)
    spread = float(centred @ centred)
    if count < POLICY.fewest_scatter or not spread > 0.0:
        return _Slope(math.nan, math.nan)
    slope = float(centred @ of_cycles) / spread
    left = of_cycles - np.mean(of_cycles) - slope * centred
    return _Slope(slope, math.sqrt(float(left @ left) / (count - 2) / spread))


def _nothing(percent: float) -> float:
    """0 for what only rounding makes."""
    if abs(percent) < 100.0 * ROUNDING:
        return 0.0
    return percent


def _unknown(why: str) -> SheetFigure:
    return SheetFigure(LoopEstimate(math.nan, math.nan, math.nan, PERCENT), why=why)


def _still(name: str, role: str, cure: str) -> ExcitationError:
    return ExcitationError(
        f"the {role} '{name}' stands still, so it tells nothing about the sensor. Check what was logged, or name "
        f"another column: {cure}.",
        name=name,
    )
