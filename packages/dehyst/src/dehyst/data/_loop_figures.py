"""Measures every loop of a log: width, opening, area, coercivity, remanence, slopes, and how they change."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from dehyst.arrays import Array
from dehyst.data._closed_path import UNREAD, Branch, ClosedPath, ReadValue
from dehyst.data._cycles import LoopPath, half_loop, loop_paths, values_at
from dehyst.data._loop_numbers import NUMBERS, LoopEstimate, Loops, MeasuredLoop
from dehyst.data._loops import turning_points
from dehyst.data._policy import POLICY
from dehyst.data._ranges import range_over, robust_range
from dehyst.data._recording import Recording, counted_rows, require_recordings
from dehyst.errors import ExcitationError
from dehyst.student import quantile
from dehyst.units import work_unit

CONFIDENCE = 0.95
TINY = 1e-300  # stands for a zero that would be divided by
ROUNDING = 1e-12  # of the range of a signal
NORMAL = 1_000_000  # degrees of freedom of an interval that the noise of many samples makes


class _Piece(NamedTuple):
    """Samples of a recording that count and follow each other."""

    name: str
    x: Array
    y: Array
    time: Array  # [s], or numbers of samples


class _Spot(NamedTuple):
    """A loop before it is measured."""

    piece: _Piece
    path: LoopPath
    completed: bool


def measure_loops(recordings: Recording | Sequence[Recording], *, symmetric: bool = False) -> Loops:
    """Measure every closed loop of a log.

    A loop begins where the input turns and ends where it comes back to that value, after swings of more than 5 % of
    its range; small loops inside a large one are loops of their own.

    Parameters
    ----------
    recordings
        One, or several of one actuator.
    symmetric
        Whether half a loop, where there is no whole one, is completed by odd symmetry about its centre: the other
        branch is -y(-x). Only who knows the actuator can tell that it is so.

    Raises
    ------
    ExcitationError
        If there is no closed loop.

    Examples
    --------
    A play of half width 0.5 and weight 2: its branches are 2 (0.5) 2 apart.

    >>> import dehyst
    >>> x = 3.0 * np.sin(np.linspace(0.0, 8.0 * np.pi, 2001))
    >>> y = dehyst.PrandtlIshlinskii([0.5], [2.0]).simulate(x)
    >>> measured = measure_loops(Recording(x, y, input_unit="mm", output_unit="N"))
    >>> largest = measured.largest[0]
    >>> round(largest.width, 6), round(largest.coercivity, 6), largest.orientation
    (2.0, 0.5, 'counter-clockwise')
    >>> f"{measured.estimates['area'].value:.3f} {measured.estimates['area'].unit}"
    '10.000 mJ'
    """
    records = require_recordings(recordings)
    measured = loops_of(records, symmetric=symmetric)
    if measured is None:
        raise _no_loop(records, symmetric)
    return measured


def loops_of(
    recordings: Sequence[Recording], *, symmetric: bool = False, largest_only: bool = False
) -> Loops | None:
    """Return the loops, or None where there is none; with `largest_only` no others are measured, which is faster."""
    spots = _spots(recordings, symmetric)
    outputs = []
    for record in recordings:
        outputs.append(np.delete(record.output, list(record.left_out)))
    output_range = robust_range(outputs)
    if not spots or not output_range > 0.0:
        return None
    count = len(spots)
    deepest = max(spot.path.depth for spot in spots)
    large = [spot for spot in spots if spot.path.depth >= POLICY.loops_large * deepest]
    most = POLICY.most_loops
    if largest_only:
        spots, most = large, POLICY.most_largest
    numbers = np.arange(len(spots))
    if numbers.size > most:
        numbers = np.unique(np.linspace(0, numbers.size - 1, most).astype(np.int64))
    references = _references(large[: POLICY.most_largest])
    first = recordings[0]
    factor, unit = work_unit(first.input_unit, first.output_unit)
    scale = _Measures(output_range, factor, references, not largest_only)
    measured = [scale.loop(spots[k], int(k) + 1) for k in numbers.tolist()]
    chosen = [loop for loop in measured if loop.depth >= POLICY.loops_large * deepest]
    # One that does not close is no cycle of the steady state, unless most are like that.
    closed = [loop for loop in chosen if loop.closes]
    if 2 * len(closed) >= len(chosen):
        chosen = closed
    # Of so few loops of several sizes a mean has no interval that is true: the largest one stands for itself.
    basis = f"scatter of {len(chosen)} loops"
    if len(chosen) < POLICY.fewest_scatter:
        chosen = [max(chosen, key=lambda loop: loop.depth)]
        basis = f"noise of the samples of loop {chosen[0].number}"
    slope = ""
    if first.input_unit and first.output_unit:
        divisor = first.input_unit
        if "/" in divisor:
            divisor = f"({divisor})"
        slope = f"{first.output_unit}/{divisor}"
    units = {
        "input": first.input_unit,
        "output": first.output_unit,
        "work": unit,
        "slope": slope,
        "percent": "%",
    }
    estimates = {}
    for name, kind in NUMBERS.items():
        estimates[name] = _estimate(chosen, name, units[kind.unit])
    names = ["zero" if reference is not None else "middle" for reference in references]
    return Loops(
        tuple(measured),
        tuple(chosen),
        estimates,
        basis,
        _trends(chosen),
        units,
        names[0],
        names[1],
        output_range,
        count,
        first.name,
        first.input_name,
        first.output_name,
    )


def _spots(recordings: Sequence[Recording], symmetric: bool) -> list[_Spot]:
    """All loops; half a loop where that is asked for and there is no whole one."""
    low, high = range_over([record.input for record in recordings])
    swing = POLICY.turn_fraction * (high - low)
    whole: list[_Spot] = []
    halves: list[_Spot] = []
    if not swing > 0.0:
        return []
    for record in recordings:
        for rows, time in counted_rows(record):
            part = _Piece(record.name, record.input[rows], record.output[rows], time)
            for path in loop_paths(part.x, swing):
                whole.append(_Spot(part, path, False))
            half = half_loop(part.x, swing)
            if half is not None:
                halves.append(_Spot(part, half, True))
    if whole or not symmetric or not halves:
        return whole
    return [max(halves, key=lambda spot: spot.path.depth)]


def _references(spots: Sequence[_Spot]) -> tuple[float | None, float | None]:
    """Zero of input and of output, where it lies well inside the range of the largest loops; else None."""
    references: list[float | None] = []
    for signal in ("x", "y"):
        parts = []
        for spot in spots:
            parts.append(values_at(getattr(spot.piece, signal), spot.path.places))
        low, high = range_over(parts)
        inside = POLICY.zero_inside * (high - low)
        references.append(0.0 if low + inside <= 0.0 <= high - inside else None)
    return references[0], references[1]


@dataclass(frozen=True)
class _Measures:
    """What the numbers of a loop refer to."""

    output_range: float
    factor: float  # Of the area, from the units of the log
    references: tuple[float | None, float | None]
    with_path: bool  # Whether loops keep their samples, which for long logs are many

    def loop(self, spot: _Spot, number: int) -> MeasuredLoop:
        """Measure a loop."""
        places = spot.path.places
        x = values_at(spot.piece.x, places)
        y = values_at(spot.piece.y, places)
        time = values_at(spot.piece.time, places)
        if spot.completed:
            x, y = _completed(x, y)
        path = ClosedPath(x, y)
        readings = self._readings(path)
        openings = path.openings()
        orientation = self._orientation(openings)
        wings = None
        if orientation == "mixed" and path.bend:
            orientation = "butterfly"
            readings |= _at_turns(path)
            heights = self.factor * float(np.ptp(x)) * path.openings(ends=0.0)
            lags, leads = np.maximum(heights, 0.0), np.maximum(-heights, 0.0)
            wings = (float(np.mean(lags)), float(np.mean(leads)))
        gap = 100.0 * float(y[-1] - y[0]) / self.output_range
        noise = 100.0 * math.sqrt(2.0) * path.noise[1] / self.output_range
        jump = 100.0 * _jump(x, y) / self.output_range
        closed_within = max(100.0 * POLICY.loop_closed, POLICY.closed_errors * noise, jump)
        drawn = np.array([x, y])
        if not self.with_path:
            drawn = drawn[:, :0]
        if spot.completed:
            gap = 0.0
        values = {name: reading.value for name, reading in readings.items()}
        # What only rounding makes is nothing.
        if values["area"] < ROUNDING * self.factor * float(np.ptp(x)) * self.output_range:
            values["area"] = 0.0
        if abs(gap) < 100.0 * ROUNDING:
            gap = 0.0
        # A cell is as wide as a twenty-fourth of the loop, where the middle is read at one place.
        widest = max(float(np.max(np.abs(openings))), np.nan_to_num(readings["width"].value))
        opening = 0.0
        if widest > ROUNDING * self.output_range:
            opening = 100.0 * widest / self.output_range
        errors = {name: reading.error for name, reading in readings.items()}
        # A cell has a twenty-fourth of the samples of either branch.
        samples = max(1.0, x.size / (2.0 * openings.size))
        errors["opening_percent"] = noise / math.sqrt(samples)
        errors["gap_percent"] = noise
        return MeasuredLoop(
            number=number,
            recording=spot.piece.name,
            start=float(np.min(time)),
            end=float(np.max(time)),
            input_low=float(np.min(x)),
            input_high=float(np.max(x)),
            output_low=float(np.min(y)),
            output_high=float(np.max(y)),
            opening_percent=opening,
            gap_percent=gap,
            closes=abs(gap) <= closed_within,
            orientation=orientation,
            completed=spot.completed,
            wings=wings,
            errors=errors,
            path=drawn,
            **values,
        )

    def _readings(self, path: ClosedPath) -> dict[str, ReadValue]:
        """Read everything that is read at one place of the loop."""
        by_input, by_output = path.by_input(), path.by_output()
        x_middle, y_middle = _middle(path.x), _middle(path.y)
        x_reference, y_reference = self.references
        if x_reference is None:
            x_reference = x_middle
        if y_reference is None:
            y_reference = y_middle
        rising, falling = by_input
        high, low = float(np.max(path.x)), float(np.min(path.x))
        at_high, slope_to_high = rising.near_end(high)
        at_low, slope_to_low = falling.near_end(low)
        from_high, slope_from_high = falling.near_end(high)
        from_low, slope_from_low = rising.near_end(low)
        area = path.area
        return {
            "area": ReadValue(self.factor * abs(area.value), self.factor * area.error),
            "width": _apart(by_input, x_middle, 1.0),
            "width_input": _apart(by_output, y_middle, 1.0),
            "remanence": _apart(by_input, x_reference, 0.5),
            "coercivity": _apart(by_output, y_reference, 0.5),
            # Where the output lags both branches bend upright at the turn; in their mean that cancels.
            "saturation_high": _mean_of(at_high, from_high),
            "saturation_low": _mean_of(at_low, from_low),
            "slope_to_high": slope_to_high,
            "slope_to_low": slope_to_low,
            "slope_from_high": slope_from_high,
            "slope_from_low": slope_from_low,
        }

    def _orientation(self, openings: Array) -> str:
        """The output is lower while the input rises: the loop runs counter-clockwise."""
        lag = float(np.sum(openings[openings > 0.0]))
        lead = float(-np.sum(openings[openings < 0.0]))
        if lag + lead < POLICY.loop_narrow * self.output_range * openings.size:
            return "none"
        if min(lag, lead) > POLICY.loop_mixed * max(lag, lead):
            return "mixed"
        if lag > lead:
            return "counter-clockwise"
        return "clockwise"


def _at_turns(path: ClosedPath) -> dict[str, ReadValue]:
    """What a butterfly has in place of a width beside its middle output, which each of its branches passes twice."""
    up, down = path.turned_at()
    distance = ReadValue(0.5 * abs(up.value - down.value), 0.5 * math.hypot(up.error, down.error))
    return {"coercivity": distance, "width_input": UNREAD}


def _jump(x: Array, y: Array) -> float:
    """How far the output goes at the begin and at the end of a loop while the input hardly moves, as of a damper."""
    away = np.flatnonzero(np.abs(x - x[0]) > POLICY.at_turn * float(np.ptp(x)))
    begin, end = y[: away[0] + 1], y[away[-1] :]
    return float(np.ptp(begin)) + float(np.ptp(end))


def _mean_of(one: ReadValue, other: ReadValue) -> ReadValue:
    """Return the mean of two readings; the one there is where the other could not be read."""
    if not math.isfinite(other.value):
        return one
    if not math.isfinite(one.value):
        return other
    return ReadValue(0.5 * (one.value + other.value), 0.5 * math.hypot(one.error, other.error))


def _apart(branches: tuple[Branch, Branch], place: float, share: float) -> ReadValue:
    """Distance of two branches at a place."""
    first, second = (branch.at(place) for branch in branches)
    error = share * math.hypot(first.error, second.error)
    distance = abs(first.value - second.value)
    # Branches that touch, as those of a self-centring brace do at zero, differ by rounding.
    if distance < ROUNDING * max(float(np.ptp(branch.v)) for branch in branches):
        distance = 0.0
    return ReadValue(share * distance, error)


def _middle(values: Array) -> float:
    return 0.5 * (float(np.min(values)) + float(np.max(values)))


def _completed(x: Array, y: Array) -> tuple[Array, Array]:
    """A branch, and behind it the same turned about the middle between its ends, so that the loop closes."""
    ends = x[0] + x[-1], y[0] + y[-1]
    return np.append(x, ends[0] - x[1:]), np.append(y, ends[1] - y[1:])


def _estimate(chosen: Sequence[MeasuredLoop], name: str, unit: str) -> LoopEstimate:
    """Mean over loops, with the interval of their scatter, or of the noise of so few that they have none."""
    values = _numbers(chosen, name)
    count = values.size
    errors = np.empty(count)
    for k, loop in enumerate(chosen):
        errors[k] = loop.errors[name]
    # Squares of very large numbers would overflow, and so would large errors over small numbers.
    largest_error = float(np.max(errors, initial=0.0, where=np.isfinite(errors)))
    scale = max(float(np.max(np.abs(values))), largest_error, TINY)
    mean = float(np.mean(values))
    # Samples that lie alike in every cycle scatter less than they err.
    reach = quantile(CONFIDENCE, NORMAL) * math.hypot(*(errors / scale).tolist()) / count
    if count >= POLICY.fewest_scatter:
        scatter = float(np.std(values / scale, ddof=1)) / math.sqrt(count)
        reach = max(reach, quantile(CONFIDENCE, count - 1) * scatter)
    reach *= scale
    return LoopEstimate(mean, mean - reach, mean + reach, unit)


def _trends(chosen: Sequence[MeasuredLoop]) -> dict[str, LoopEstimate]:
    """Change from cycle to cycle: a line through the numbers of the largest loops, in percent of their mean.

    Where the loops are not of one size the line stands beside their depth, which is no wear.
    """
    count = len(chosen)
    if count < POLICY.fewest_trend:
        return {}
    depth = _numbers(chosen, "depth")
    place = np.arange(count) - 0.5 * (count - 1)
    beside = [np.ones(count)]
    if float(np.std(depth)) > POLICY.one_depth * float(np.mean(depth)):
        beside.append(depth / float(np.mean(depth)) - 1.0)
    freedom = count - 1 - len(beside)
    basis = np.column_stack(beside)
    along = place - basis @ np.linalg.lstsq(basis, place, rcond=None)[0]
    spread = float(along @ along)
    # Loops that grow evenly do not tell wear from size.
    if freedom < 1 or not spread > POLICY.own_place * float(place @ place):
        return {}
    trends = {}
    for name, series in _wearing(chosen).items():
        mean = float(np.mean(series))
        if not abs(mean) > 0.0:
            continue
        share = series / abs(mean)
        # What rounding does is no change, however regular.
        if float(np.ptp(share)) < ROUNDING:
            share = np.ones(count)
        left = share - basis @ np.linalg.lstsq(basis, share, rcond=None)[0]
        slope = float(along @ left) / spread
        left = left - slope * along
        reach = quantile(CONFIDENCE, freedom) * math.sqrt(float(left @ left) / freedom / spread)
        trends[name] = LoopEstimate(
            100.0 * slope, 100.0 * (slope - reach), 100.0 * (slope + reach), "%/cycle"
        )
    return trends


def _wearing(chosen: Sequence[MeasuredLoop]) -> dict[str, Array]:
    """Numbers whose change tells of wear; no gain where the output is no higher at one turn than at the other."""
    numbers = {"width": _numbers(chosen, "width")}
    # The area of a butterfly is a difference, and may be next to nothing.
    if all(loop.wings is None for loop in chosen):
        numbers["area"] = _numbers(chosen, "area")
    gains = np.array([_gain(loop) for loop in chosen])
    heights = _numbers(chosen, "output_high") - _numbers(chosen, "output_low")
    heights /= _numbers(chosen, "depth")
    if abs(float(np.mean(gains))) > POLICY.rises_by * float(np.mean(heights)):
        numbers["gain"] = gains
    return numbers


def _numbers(loops: Sequence[MeasuredLoop], name: str) -> Array:
    """One number of each loop, (n,)."""
    return np.array([getattr(loop, name) for loop in loops])


def _gain(loop: MeasuredLoop) -> float:
    """Output over input from turn to turn. [output/input]"""
    return (loop.saturation_high - loop.saturation_low) / loop.depth


def _no_loop(records: Sequence[Recording], symmetric: bool) -> ExcitationError:
    """What to log, or to type, where the input never comes back."""
    if not robust_range([record.output for record in records]) > 0.0:
        name = records[0].output_name
        return ExcitationError(
            f"the log holds no closed loop: its output '{name}' stands still, so no loop has an area or a width. Check "
            f"the sensor, or name another column: --output COLUMN.",
            output=name,
        )
    turns = 0
    half = 0.0
    low, high = range_over([record.input for record in records])
    for record in records:
        for piece in record.pieces:
            x = record.input[piece]
            swing = POLICY.turn_fraction * (high - low)
            if swing > 0.0:
                turns += max(0, turning_points(x, swing).size - 2)
                half = max(half, float(np.ptp(x)))
    cure = ""
    if half > 0.0 and not symmetric:
        cure = (
            ", or, if you know that the other half is the same turned about the centre, complete it: --symmetric "
            "(in Python symmetric=True)"
        )
    return ExcitationError(
        f"the log holds no closed loop: its input turns {turns} times by more than "
        f"{100 * POLICY.turn_fraction:g} % of its range ({low:.4g} to {high:.4g}) and never comes back to where it "
        f"was, so no loop has an area or a width. Log at least one whole cycle, there and back{cure}.",
        turns=turns,
    )
