"""Predictions and scores of a model and of the curve, round trip through the inverse, residual warnings."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from dehyst.arrays import Array, Mask
from dehyst.data.ranges import robust_range
from dehyst.data.recording import Recording
from dehyst.identification import facts
from dehyst.identification.conditions import Condition, conditions, steeper, wider
from dehyst.identification.data import DataSet, Piece, chunks, range_over
from dehyst.identification.evidence import Evidence, evidence, rows_of, stretches_of
from dehyst.identification.fit import InputError, Score
from dehyst.identification.regressors import Bank, started
from dehyst.models import HysteresisModel, StaticCurve


class Readable(Protocol):
    """Samples that can be asked for part by part."""

    def __getitem__(self, part: slice, /) -> Array:
        """Samples of a part."""


@dataclass(frozen=True)
class Part:
    """Which samples of the recordings are meant, and how much each counts."""

    spans: tuple[tuple[slice, ...], ...]  # Spans of samples, for each recording
    weights: tuple[Array | None, ...]  # Weight of each sample of each recording, (T,), or None where all count alike

    def __bool__(self) -> bool:
        """Whether there are any samples."""
        return any(True for _ in self.blocks())

    def blocks(self, *numbers: int) -> Iterator[tuple[int, slice, Array | None]]:
        """Recording, samples and their weights, a cacheful at a time; of some recordings only."""
        for index, (spans, weight) in enumerate(zip(self.spans, self.weights, strict=True)):
            if numbers and index not in numbers:
                continue
            for span in spans:
                for part in chunks(span):
                    chosen = None if weight is None else weight[part]
                    if chosen is None or np.any(chosen > 0.0):
                        yield index, part, chosen

    def mask(self, index: int, size: int) -> Mask:
        """Whether each sample of a recording of that size belongs to the part; those of no weight do not."""
        mask, weight = np.zeros(size, dtype=np.bool_), self.weights[index]
        for span in self.spans[index]:
            mask[span] = True if weight is None else weight[span] > 0.0
        return mask

    def moments(
        self, signals: Sequence[Readable], less: Sequence[Readable] | None = None, *numbers: int, extremes: bool = False
    ) -> Moments:
        """Count, mean, mean square and, if `extremes`, largest size of a signal, or of a difference of two."""
        count = first = second = largest = 0.0
        for index, part, weight in self.blocks(*numbers):
            values = signals[index][part] if less is None else signals[index][part] - less[index][part]
            scaled = values if weight is None else values * weight
            count += values.size if weight is None else float(np.sum(weight))
            first += float(np.sum(scaled))
            second += float(scaled @ values)
            if extremes:
                sized = values if weight is None else values[weight > 0.0]
                largest = max(largest, float(sized.max()), -float(sized.min()))
        return Moments(count, first / count if count else 0.0, second / count if count else 0.0, largest)


@dataclass(frozen=True, slots=True)
class Moments:
    """Sums over samples of a signal."""

    # count, mean, square, largest: Sum of the weights, weighted mean, weighted mean square, largest absolute value
    count: float
    mean: float
    square: float
    largest: float

    @property
    def rms(self) -> float:
        """Root of the mean square."""
        return float(np.sqrt(self.square))


def parts(records: tuple[Recording, ...], data: DataSet, initial_state: str) -> tuple[Part, Part]:
    """Fitted and held-out samples of each recording, without those whose memory is unknown."""
    fitted: list[list[slice]] = [[] for _ in records]
    held_out: list[list[slice]] = [[] for _ in records]
    weights: list[Array | None] = [None if not data.weighted else np.ones(len(record)) for record in records]
    for piece in data.pieces:
        for spans, span in ((fitted, piece.fitted(initial_state)), (held_out, piece.held_out(initial_state))):
            if span.stop > span.start:
                spans[piece.recording].append(slice(piece.start + span.start, piece.start + span.stop))
        given = weights[piece.recording]
        if given is not None and piece.weight is not None:
            given[piece.start : piece.start + piece.x.size] = piece.weight
    first, second = (Part(tuple(map(tuple, spans)), tuple(weights)) for spans in (fitted, held_out))
    return first, second


def part_of(masks: Sequence[Mask]) -> Part:
    """Return the samples that masks (T,) of all recordings choose."""
    spans = []
    for mask in masks:
        ends = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]]).astype(np.int8))).reshape(-1, 2)
        spans.append(tuple(slice(int(low), int(high)) for low, high in ends))
    return Part(tuple(spans), (None,) * len(spans))


def predictions(
    records: tuple[Recording, ...], data: DataSet, bank: Bank, model: HysteresisModel
) -> tuple[tuple[Array, ...], tuple[Array, ...]]:
    """Output of the model for each recording, and the input its inverse asks for to reach the measured output.

    Every piece starts from its own memory.
    """
    demands: list[list[Array]] = [[] for _ in records]
    for piece, begun in _started(data, bank, model):
        span = slice(piece.start, piece.start + piece.x.size)
        demands[piece.recording].append(begun.inverse().simulate(records[piece.recording].output[span]))
    return simulated(records, data, bank, model), tuple(map(_joined, demands))


def simulated(records: tuple[Recording, ...], data: DataSet, bank: Bank, model: HysteresisModel) -> tuple[Array, ...]:
    """Output of the model for each recording; every piece starts from its own memory."""
    outputs: list[list[Array]] = [[] for _ in records]
    for piece, begun in _started(data, bank, model):
        span = slice(piece.start, piece.start + piece.x.size)
        outputs[piece.recording].append(begun.simulate(records[piece.recording].input[span]))
    return tuple(map(_joined, outputs))


def _started(data: DataSet, bank: Bank, model: HysteresisModel) -> Iterator[tuple[Piece, HysteresisModel]]:
    """Each piece with the model in its state before it."""
    for piece, state in zip(data.pieces, bank.states, strict=True):
        yield piece, started(data, bank, model, state)


def _joined(pieces: list[Array]) -> Array:
    return pieces[0] if len(pieces) == 1 else np.concatenate(pieces)


def score(records: tuple[Recording, ...], outputs: Sequence[Readable], part: Part, output_range: float) -> Score | None:
    """Score of the chosen samples of all recordings together; None if there are none."""
    measured = [record.output for record in records]
    about = part.moments(measured)
    if about.count == 0.0:
        return None
    error = part.moments(outputs, measured, extremes=True)
    middle = [np.broadcast_to(about.mean, record.output.shape) for record in records]
    return score_of(error, part.moments(measured, middle).rms, output_range)


def score_of(error: Moments, deviation: float, output_range: float) -> Score:
    """Score from the moments of the error and the standard deviation of the output."""
    return Score(
        rmse=error.rms,
        rmse_percent=100.0 * error.rms / output_range,
        nrmse=error.rms / deviation if deviation > 0 else float("inf") if error.rms > 0 else 0.0,
        max=error.largest,
    )


def round_trip(model: HysteresisModel, x: Array) -> float:
    """Larger of max|inverse(model(x)) - x| and max|model(inverse(y)) - y|, y = model(x), relative to the ranges."""
    forward, inverse, again = (m.stepper("dense") for m in (model, model.inverse(), model))
    misses, ranges = np.zeros(2), np.array([[np.inf, -np.inf], [np.inf, -np.inf]])
    for part in chunks(slice(0, x.size)):
        y = forward.simulate(x[part])[0]
        back = inverse.simulate(y)[0]
        for k, (found, wanted) in enumerate(((back, x[part]), (again.simulate(back)[0], y))):
            misses[k] = max(misses[k], float(np.max(np.abs(found - wanted))))
            ranges[k] = min(ranges[k, 0], float(wanted.min())), max(ranges[k, 1], float(wanted.max()))
    return float(np.max(misses / np.maximum(ranges[:, 1] - ranges[:, 0], 1e-300)))


def input_error(records: tuple[Recording, ...], demands: Sequence[Array], part: Part) -> InputError | None:
    """Error of the input asked for, kept within the range that was applied; None if no samples are chosen."""
    inputs = [record.input for record in records]
    low, high = range_over(inputs)
    held = [np.clip(demand, low, high) for demand in demands]
    return input_error_of(part.moments(held, inputs), robust_range(inputs))


def input_error_of(moments: Moments, span: float) -> InputError | None:
    """Error from the moments of the input asked for less the input applied."""
    if not moments.count:
        return None
    return InputError(100.0 * moments.rms / span, 100.0 * moments.mean / span)


@dataclass(frozen=True)
class Measured:
    """What comparing a model with all samples gives."""

    # The data, the model's output and what its inverse asks for, (T,) for each recording; names as in `Fit`
    recordings: tuple[Recording, ...]
    predictions: tuple[Array, ...]
    inverse_predictions: tuple[Array, ...]
    # train_masks, test_masks: Which samples were fitted and held out
    train_masks: tuple[Mask, ...]
    test_masks: tuple[Mask, ...]
    # train, test, static_train, static_test: Scores of the model and of the curve
    train: Score
    test: Score | None
    static_train: Score
    static_test: Score | None
    round_trip: float  # Of model and inverse, relative to the ranges
    # input_train, input_test: Error of the input asked for; None where nothing was held out
    input_train: InputError
    input_test: InputError | None
    curve_input: InputError  # The same of the curve's inverse, over held-out samples if there are any
    beyond: float  # How far the held-out input leaves what was fitted, share of the range
    levels_apart: float  # Largest difference of the mean residuals of two recordings. [output]
    evidence: tuple[Evidence, ...]  # Of rate and creep; empty without time stamps
    # Change of the residual from the first to the last cycle, and its standard error. [output]
    drift: tuple[float, float]
    conditions: tuple[Condition, ...] = ()  # Of the recordings, where there are several in memory

    @property
    def input_error(self) -> InputError:
        """Over held-out samples, over fitted ones if none were held out."""
        return self.input_test or self.input_train


@dataclass(frozen=True)
class Answers:
    """Output of a curve without memory, made where it is asked for."""

    curve: StaticCurve
    input: Array

    def __getitem__(self, part: slice) -> Array:
        """Output at some samples."""
        return self.curve.simulate(self.input[part])

    @property
    def whole(self) -> Array:
        """Output at all samples, (T,)."""
        return self.curve.simulate(self.input)


class Measure(Protocol):
    """Compares a model and a curve with all samples of a data set."""

    def __call__(self, data: DataSet, bank: Bank, model: HysteresisModel, static: StaticCurve, turns: int) -> Measured:
        """Return scores and what the residuals say; `turns` is the number of turning points of the fitted part."""
        ...


class InMemory:
    """Compares models with recordings in memory; the test of rate and creep is made once for all of them.

    Parameters
    ----------
    records
        The data.
    loads
        Shares (T,), 0 at the least and 1 at the most, of signals that change the loop, for each recording.
    """

    def __init__(self, records: tuple[Recording, ...], loads: Sequence[Sequence[Array]] = ()) -> None:
        self._records, self._loads = records, loads
        self._tested: tuple[Evidence, ...] | None = None

    def __call__(self, data: DataSet, bank: Bank, model: HysteresisModel, static: StaticCurve, turns: int) -> Measured:
        """Compare a model whose memory before each piece a bank tells."""
        outputs, demands = predictions(self._records, data, bank, model)
        trip = round_trip(model, self._records[0].input)
        scored = parts(self._records, data, bank.initial_state)
        return self.compared(data, scored, outputs, demands, trip, static, turns)

    def compared(
        self,
        data: DataSet,
        scored: tuple[Part, Part],
        outputs: tuple[Array, ...],
        demands: tuple[Array, ...],
        trip: float,
        static: StaticCurve,
        turns: int,
    ) -> Measured:
        """Compare what a model answers, and what its inverse asks for, over fitted and held-out samples."""
        records, (fitted, held_out) = self._records, scored
        curves = tuple(Answers(static, record.input) for record in records)
        train, test = (score(records, outputs, part, data.output_range) for part in (fitted, held_out))
        static_train, static_test = (score(records, curves, part, data.output_range) for part in (fitted, held_out))
        input_train, input_test = (input_error(records, demands, part) for part in (fitted, held_out))
        asked = tuple(static.inverse().simulate(record.output) for record in records)
        curve_input = input_error(records, asked, fitted if test is None else held_out)
        if train is None or static_train is None or input_train is None or curve_input is None:
            raise AssertionError("no training samples")  # the caller has checked
        # Where a curve is as good as the model, what is left of the model's error is not about the actuator.
        better = outputs if train.rmse <= static_train.rmse else tuple(curve.whole for curve in curves)
        change = (0.0, 0.0)
        seen = fitted.mask(0, len(records[0])) | held_out.mask(0, len(records[0]))
        if np.count_nonzero(seen) > 8:
            signals = [records[0].input, better[0], curves[0].whole, records[0].output]
            x, model, curve, y = signals if seen.all() else [signal[seen] for signal in signals]
            change = facts.agreed(facts.drift(x, model, y), facts.drift(x, curve, y))
        if self._tested is None:
            self._tested = _evidence(records, data, turns, self._loads)
            if any(tested.there for tested in self._tested) and not self._loads:
                self._tested = _of_one_condition(records, data, turns, self._tested)
        return Measured(
            recordings=records,
            predictions=outputs,
            inverse_predictions=demands,
            train_masks=tuple(fitted.mask(index, len(record)) for index, record in enumerate(records)),
            test_masks=tuple(held_out.mask(index, len(record)) for index, record in enumerate(records)),
            train=train,
            test=test,
            static_train=static_train,
            static_test=static_test,
            round_trip=trip,
            input_train=input_train,
            input_test=input_test,
            curve_input=curve_input,
            beyond=_beyond_training(records, held_out, data),
            levels_apart=_levels_apart(records, outputs, fitted, held_out),
            evidence=self._tested,
            drift=change,
            conditions=conditions(records, outputs, data.output_range),
        )


def _of_one_condition(
    records: tuple[Recording, ...], data: DataSet, turns: int, tested: tuple[Evidence, ...]
) -> tuple[Evidence, ...]:
    """Evidence of recordings under different conditions: what most of them do not show alone is not there.

    Loops that another signal widens are followed by any term that is wide where they are.
    """
    found = conditions(records, None, data.output_range)
    if not wider(found) and not steeper(found):
        return tested
    alone = [_evidence((record,), data, turns, (), index) for index, record in enumerate(records)]
    judged = []
    for group in tested:
        own = [each for row in alone for each in row if each.group == group.group]
        shown = sum(each.there for each in own)
        judged.append(group if 2 * shown > len(own) else replace(group, with_percent=group.without_percent))
    return tuple(judged)


def _evidence(
    records: tuple[Recording, ...], data: DataSet, turns: int, loads: Sequence[Sequence[Array]], first: int = 0
) -> tuple[Evidence, ...]:
    """Evidence of recordings that stand in the data from number `first` on."""
    timed = [(first + k, record, record.time) for k, record in enumerate(records) if record.time is not None]
    found = []
    for (k, record, time), rows in zip(timed, rows_of([len(record) for _, record, _ in timed], turns), strict=True):
        signals = [time, record.input, record.output, *(loads[k] if loads else ())]
        found += stretches_of(data, k, rows, np.array([signal[rows] for signal in signals]))
    return evidence(found)


def _levels_apart(records: tuple[Recording, ...], outputs: tuple[Array, ...], fitted: Part, held_out: Part) -> float:
    """Largest difference of the mean residuals of two recordings, where they are fitted if they are. [output]"""
    if len(records) < 2:
        return 0.0
    measured = [record.output for record in records]
    parts_of = [[part.moments(measured, outputs, k) for part in (fitted, held_out)] for k in range(len(records))]
    levels = [next(about.mean for about in found if about.count) for found in parts_of if any(a.count for a in found)]
    return max(levels) - min(levels)


def _beyond_training(records: tuple[Recording, ...], part: Part, data: DataSet) -> float:
    """How far the held-out input leaves [-1, 1] scaled, share of the range."""
    if not part:
        return 0.0
    inputs = [record.input for record in records]
    middle = [np.broadcast_to(data.center, x.shape) for x in inputs]
    farthest = part.moments(inputs, middle, extremes=True).largest
    return 0.5 * max(0.0, farthest / data.half_range - 1.0)
