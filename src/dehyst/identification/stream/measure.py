"""Scores of model and curve on all samples of a log, in one pass."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from dehyst.arrays import Array, Mask, Rows
from dehyst.data.loops import TURN_FRACTION
from dehyst.data.ranges import robust_range
from dehyst.identification.data import DataSet, Piece, chunks
from dehyst.identification.evidence import Evidence, evidence, rows_of, stretches_of
from dehyst.identification.facts import agreed, drift_of, middle_third
from dehyst.identification.fit import Score
from dehyst.identification.regressors import Bank, started
from dehyst.identification.scores import Measure, Measured, Moments, input_error_of, score_of
from dehyst.identification.stream.log import Log
from dehyst.identification.stream.outline import PLACE, TAGS, VALUE, Zigzag
from dehyst.identification.stream.samples import INPUT, OUTPUT, TIME
from dehyst.models import HysteresisModel, StaticCurve

# Which samples a part of a piece belongs to.
NEITHER, FITTED, HELD_OUT = range(3)


class Cycles:
    """Mean residuals of the cycles of an input, and the line through them; as `facts.drift` for a whole recording.

    Parameters
    ----------
    swing
        Swings of the input that count. [input]
    residuals
        How many residuals there are.
    low, high
        Range of the input. [input]
    """

    def __init__(self, swing: float, residuals: int, low: float, high: float) -> None:
        # Sums of residuals, of those in the middle third of the range, and how many samples are there.
        sums = 2 * residuals + 1
        self._zigzag = Zigzag(swing, sums)
        self._totals = np.zeros((sums, 1))
        self._points = [np.zeros((0, TAGS + sums))]
        self._residuals, self._range = residuals, (low, high)

    def add(self, begin: int, x: Array, residuals: Array) -> None:
        """Add samples from number `begin` on, with residuals (residuals, K)."""
        inside = middle_third(x, *self._range)
        summed = np.concatenate([residuals, residuals * inside, inside[None]])
        running = self._totals + np.cumsum(summed, axis=1)
        self._totals = running[:, -1:]
        self._points.append(self._zigzag.add(begin, x, running - summed))

    def drift(self, which: int) -> tuple[float, float]:
        """Change of a residual from the first to the last cycle, and its standard error."""
        points = np.concatenate(self._points)
        begins = points[::2]
        sums = np.diff(begins[:, TAGS:], axis=0)
        middle, counts = sums[:, self._residuals + which], np.round(sums[:, -1])
        return drift_of(sums[:, which] / np.diff(begins[:, PLACE]), points[:, VALUE], middle, counts)


class Simulator(Protocol):
    """Steppers, which continue from where they are."""

    def simulate(self, x: Array) -> tuple[Array, int]:
        """Outputs and the number of rejected samples."""
        ...


@dataclass
class Sum:
    """Moments of a signal, added up part by part."""

    count: int = 0
    first: float = 0.0
    second: float = 0.0
    largest: float = 0.0

    def add(self, values: Array) -> None:
        """Add samples."""
        self.count += values.size
        self.first += float(np.sum(values))
        self.second += float(values @ values)
        self.largest = max(self.largest, float(np.max(values)), -float(np.min(values)))

    @property
    def moments(self) -> Moments:
        """Mean, mean square and largest size."""
        count = max(self.count, 1)
        return Moments(float(self.count), self.first / count, self.second / count, self.largest)

    @property
    def deviation(self) -> float:
        """Standard deviation."""
        about = self.moments
        return float(np.sqrt(max(about.square - about.mean**2, 0.0)))


@dataclass
class Errors:
    """Sums over the fitted or the held-out samples."""

    model: Sum = field(default_factory=Sum)
    curve: Sum = field(default_factory=Sum)
    asked: Sum = field(default_factory=Sum)  # input asked for less the input applied
    asked_by_curve: Sum = field(default_factory=Sum)
    output: Sum = field(default_factory=Sum)  # less its mid-range
    excursion: Sum = field(default_factory=Sum)  # input less its centre

    def scores(self, output_range: float) -> tuple[Score, Score] | None:
        """Scores of model and curve; None if there are no samples."""
        if self.model.count == 0:
            return None
        spread = self.output.deviation
        return score_of(self.model.moments, spread, output_range), score_of(self.curve.moments, spread, output_range)


@dataclass
class RoundTrip:
    """Inverse after model and model after inverse, over the first log."""

    model: Simulator
    inverse: Simulator
    again: Simulator
    farthest: float = 0.0
    miss: float = 0.0
    low: float = np.inf
    high: float = -np.inf

    def add(self, x: Array) -> None:
        """Add samples of the input."""
        y = self.model.simulate(x)[0]
        back = self.inverse.simulate(y)[0]
        again = self.again.simulate(back)[0]
        self.farthest = max(self.farthest, float(np.max(np.abs(back - x))))
        self.miss = max(self.miss, float(np.max(np.abs(again - y))))
        self.low, self.high = min(self.low, float(np.min(y))), max(self.high, float(np.max(y)))

    def result(self, input_range: float) -> float:
        """Larger of the two, relative to the ranges."""
        return max(self.farthest / max(input_range, 1e-300), self.miss / max(self.high - self.low, 1e-300))


@dataclass(frozen=True)
class Kept:
    """Values at some samples of a log, filled as they come by."""

    places: Rows
    values: Array  # (signals, m)

    def put(self, begin: int, end: int, signals: Sequence[Array]) -> None:
        """Take what is wanted of the samples from `begin` to `end`."""
        low, high = np.searchsorted(self.places, [begin, end])
        inside = self.places[low:high] - begin
        for row, signal in zip(self.values, signals, strict=True):
            row[low:high] = signal[inside]


def measure_streamed(logs: Sequence[Log], entering: Callable[[str], object]) -> Measure:
    """Compare with logs that are not in memory."""

    def measure(data: DataSet, bank: Bank, model: HysteresisModel, static: StaticCurve, turns: int) -> Measured:
        entering("scoring")
        return _Comparison(logs, data, bank, model, static, turns).run()

    return measure


class _Comparison:
    def __init__(
        self,
        logs: Sequence[Log],
        data: DataSet,
        bank: Bank,
        model: HysteresisModel,
        static: StaticCurve,
        turns: int,
    ) -> None:
        self.logs, self.data, self.bank, self.model, self.static = logs, data, bank, model, static
        self.parts = {NEITHER: Errors(), FITTED: Errors(), HELD_OUT: Errors()}
        self.levels = [(Sum(), Sum()) for _ in logs]  # fitted, held out
        self.kept = [Kept(log.places, np.empty((2, log.places.size))) for log in logs]
        # Rate and creep are looked for in some rows of the logs that have time.
        timed = [k for k, log in enumerate(logs) if log.reader.tape.has_time]
        self.rows = dict(zip(timed, rows_of([logs[k].samples for k in timed], turns), strict=True))
        self.rated = {k: _kept(rows) for k, rows in self.rows.items()}
        low, high = logs[0].reader.extremes(0, logs[0].samples, INPUT)
        self.trip = RoundTrip(model.stepper("dense"), model.inverse().stepper("dense"), model.stepper("dense"))
        self.cycles = Cycles(TURN_FRACTION * (high - low), 2, low, high)
        self.first_range = high - low
        ends = [log.reader.extremes(0, log.samples, INPUT) for log in logs]
        self.applied = min(end[0] for end in ends), max(end[1] for end in ends)
        self.static_inverse = static.inverse()

    def run(self) -> Measured:
        for index, log in enumerate(self.logs):
            log.reader.restart(clock=index in self.rated)
            for k, piece in enumerate(self.data.pieces):
                if piece.recording == index:
                    self._piece(log, piece, self.bank.states[k])
        return self._result()

    def _piece(self, log: Log, piece: Piece, state: Array) -> None:
        model = started(self.data, self.bank, self.model, state)
        simulate, ask = model.stepper("dense"), model.inverse().stepper("dense")
        for kind, part in _parts(piece, self.bank.initial_state):
            begin, end = piece.start + part.start, piece.start + part.stop
            x, y = log.reader.read(begin, end, INPUT), log.reader.read(begin, end, OUTPUT)
            output, asked, curve = simulate.simulate(x)[0], ask.simulate(y)[0], self.static.simulate(x)
            self._add(self.parts[kind], x, y, output, asked, curve)
            self.parts[kind].asked_by_curve.add(np.clip(self.static_inverse.simulate(y), *self.applied) - x)
            if kind in (FITTED, HELD_OUT):
                self.levels[piece.recording][kind == HELD_OUT].add(y - output)
            self.kept[piece.recording].put(begin, end, (output, asked))
            if piece.recording in self.rated:
                self.rated[piece.recording].put(begin, end, (log.reader.read(begin, end, TIME), x, y))
            if piece.recording == 0:
                self.trip.add(x)
                self.cycles.add(begin, x, np.array([output - y, curve - y]))

    def _add(self, errors: Errors, x: Array, y: Array, output: Array, asked: Array, curve: Array) -> None:
        errors.model.add(output - y)
        errors.curve.add(curve - y)
        errors.asked.add(np.clip(asked, *self.applied) - x)
        errors.output.add(y - self.data.level)
        errors.excursion.add(x - self.data.center)

    def _result(self) -> Measured:
        data, fitted, held_out = self.data, self.parts[FITTED], self.parts[HELD_OUT]
        train, test = fitted.scores(data.output_range), held_out.scores(data.output_range)
        if train is None:
            raise AssertionError("no training samples")  # the caller has checked
        # Where a curve is as good as the model, what is left of the model's error is not about the actuator.
        better = 0 if train[0].rmse <= train[1].rmse else 1
        span = robust_range([log.recording.input for log in self.logs])
        input_train, input_test = (input_error_of(each.asked.moments, span) for each in (fitted, held_out))
        curve_input = input_error_of((held_out if test else fitted).asked_by_curve.moments, span)
        assert input_train is not None and curve_input is not None
        levels = [next(p.moments.mean for p in each if p.count) for each in self.levels if any(p.count for p in each)]
        beyond = held_out.excursion.largest / data.half_range - 1.0
        train_masks, test_masks = (tuple(self._masks(kind)) for kind in (FITTED, HELD_OUT))
        return Measured(
            recordings=tuple(log.recording for log in self.logs),
            predictions=tuple(kept.values[0] for kept in self.kept),
            inverse_predictions=tuple(kept.values[1] for kept in self.kept),
            train_masks=train_masks,
            test_masks=test_masks,
            train=train[0],
            test=test[0] if test else None,
            static_train=train[1],
            static_test=test[1] if test else None,
            round_trip=self.trip.result(self.first_range),
            input_train=input_train,
            input_test=input_test,
            curve_input=curve_input,
            beyond=0.5 * max(0.0, beyond),
            levels_apart=max(levels) - min(levels) if len(levels) > 1 else 0.0,
            evidence=self._evidence(),
            drift=agreed(self.cycles.drift(better), self.cycles.drift(1)) if self.logs[0].samples > 8 else (0.0, 0.0),
        )

    def _evidence(self) -> tuple[Evidence, ...]:
        found = [stretches_of(self.data, k, self.rows[k], kept.values) for k, kept in self.rated.items()]
        return evidence([stretch for each in found for stretch in each])

    def _masks(self, kind: int) -> Iterator[Mask]:
        for index, log in enumerate(self.logs):
            mask = np.zeros(log.places.size, dtype=np.bool_)
            for piece in self.data.pieces:
                if piece.recording == index:
                    span = (piece.fitted if kind == FITTED else piece.held_out)(self.bank.initial_state)
                    low, high = np.searchsorted(log.places, [piece.start + span.start, piece.start + span.stop])
                    mask[low:high] = True
            yield mask


def _kept(rows: slice) -> Kept:
    places = np.arange(0, rows.stop, rows.step or 1, dtype=np.int64)
    return Kept(places, np.empty((3, places.size)))


def _parts(piece: Piece, initial_state: str) -> Iterator[tuple[int, slice]]:
    """All samples of a piece in parts, and which they belong to; cut as the spans of recordings in memory are."""
    fitted, held_out = piece.fitted(initial_state), piece.held_out(initial_state)
    for kind, span in (
        (NEITHER, slice(0, min(fitted.start, piece.x.size))),
        (FITTED, fitted),
        (NEITHER, slice(fitted.stop, held_out.start)),
        (HELD_OUT, held_out),
    ):
        for part in chunks(span):
            yield kind, part
