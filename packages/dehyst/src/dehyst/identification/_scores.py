"""Scores a model and the curve without memory: predictions, errors, round trip through the inverse, drift."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from dehyst.arrays import Array, Mask
from dehyst.data import Recording, robust_range, top_speed
from dehyst.identification import _facts as facts
from dehyst.identification._conditions import Condition, conditions, steeper, wider
from dehyst.identification._data import (
    DataSet,
    Piece,
    chunks,
    input_range,
    inputs_of,
    output_range,
    outputs_of,
)
from dehyst.identification._evidence import Evidence, evidence, rows_of, stretches_of
from dehyst.identification._fit import InputError, Score
from dehyst.identification._regressors import PlayBank, started
from dehyst.models import HysteresisModel, StaticCurve


@dataclass(frozen=True)
class Part:
    """Which samples of the recordings are meant, and how much each counts."""

    spans: tuple[tuple[slice, ...], ...]  # Spans of samples, for each recording
    # Weight of each sample of each recording, (T,), or None where all count alike
    weights: tuple[Array | None, ...]

    def __bool__(self) -> bool:
        """Whether there are any samples."""
        return next(self.blocks(), None) is not None

    def blocks(self, *numbers: int) -> Iterator[tuple[int, slice, Array | None]]:
        """Recording, samples and their weights, a cacheful at a time; of some recordings only."""
        for index, (spans, weight) in enumerate(zip(self.spans, self.weights, strict=True)):
            if numbers and index not in numbers:
                continue
            for span in spans:
                for part in chunks(span):
                    if weight is None:
                        yield index, part, None
                    elif np.any(weight[part] > 0.0):
                        yield index, part, weight[part]

    def mask(self, index: int, size: int) -> Mask:
        """Whether each sample of a recording of that size belongs to the part; those of no weight do not."""
        mask = np.zeros(size, dtype=np.bool_)
        weight = self.weights[index]
        for span in self.spans[index]:
            if weight is None:
                mask[span] = True
            else:
                mask[span] = weight[span] > 0.0
        return mask

    def masks(self, records: Sequence[Recording]) -> tuple[Mask, ...]:
        """Whether each sample of each recording belongs to the part."""
        masks = []
        for index, record in enumerate(records):
            masks.append(self.mask(index, len(record)))
        return tuple(masks)

    def moments(
        self,
        signals: Sequence[Array],
        less: Sequence[Array] | None = None,
        *numbers: int,
        extremes: bool = False,
    ) -> Moments:
        """Count, mean, mean square and, if `extremes`, largest size of a signal, or of a difference of two."""
        count = first = second = largest = 0.0
        for index, part, weight in self.blocks(*numbers):
            values = signals[index][part]
            if less is not None:
                values = values - less[index][part]
            counted = values
            if weight is None:
                count += values.size
                first += float(np.sum(values))
                second += float(values @ values)
            else:
                scaled = values * weight
                count += float(np.sum(weight))
                first += float(np.sum(scaled))
                second += float(scaled @ values)
                counted = values[weight > 0.0]
            if extremes:
                largest = max(largest, float(counted.max()), -float(counted.min()))
        if not count:
            return Moments(count, 0.0, 0.0, largest)
        return Moments(count, first / count, second / count, largest)


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


def scored_parts(
    records: tuple[Recording, ...], data: DataSet, initial_state: str
) -> tuple[Part, Part]:
    """Fitted and held-out samples of each recording, without those whose memory is unknown."""
    fitted: list[list[slice]] = [[] for _ in records]
    held_out: list[list[slice]] = [[] for _ in records]
    weights: list[Array | None] = [None] * len(records)
    if data.weighted:
        weights = [np.ones(len(record)) for record in records]
    for piece in data.pieces:
        for spans, span in (
            (fitted, piece.fitted(initial_state)),
            (held_out, piece.held_out(initial_state)),
        ):
            if span.stop > span.start:
                spans[piece.recording].append(
                    slice(piece.start + span.start, piece.start + span.stop)
                )
        weight = weights[piece.recording]
        if weight is not None and piece.weight is not None:
            weight[piece.start : piece.start + piece.x.size] = piece.weight
    fitted_part = Part(tuple(map(tuple, fitted)), tuple(weights))
    held_out_part = Part(tuple(map(tuple, held_out)), tuple(weights))
    return fitted_part, held_out_part


def part_of(masks: Sequence[Mask]) -> Part:
    """Return the samples that masks (T,) of all recordings choose."""
    all_spans = []
    for mask in masks:
        # A span begins and ends where the mask changes.
        padded = np.concatenate([[False], mask, [False]]).astype(np.int8)
        ends = np.flatnonzero(np.diff(padded)).reshape(-1, 2)
        all_spans.append(tuple(slice(low, high) for low, high in ends.tolist()))
    return Part(tuple(all_spans), (None,) * len(all_spans))


def predictions(
    records: tuple[Recording, ...], data: DataSet, bank: PlayBank, model: HysteresisModel
) -> tuple[tuple[Array, ...], tuple[Array, ...]]:
    """Output of the model for each recording, and the input its inverse asks for to reach the measured output.

    Every piece starts from its own memory.
    """
    demands: list[list[Array]] = [[] for _ in records]
    for piece, begun in _started(data, bank, model):
        span = slice(piece.start, piece.start + piece.x.size)
        demands[piece.recording].append(
            begun.inverse().simulate(records[piece.recording].output[span])
        )
    return simulated(records, data, bank, model), tuple(map(_joined, demands))


def simulated(
    records: tuple[Recording, ...], data: DataSet, bank: PlayBank, model: HysteresisModel
) -> tuple[Array, ...]:
    """Output of the model for each recording; every piece starts from its own memory."""
    outputs: list[list[Array]] = [[] for _ in records]
    for piece, begun in _started(data, bank, model):
        span = slice(piece.start, piece.start + piece.x.size)
        outputs[piece.recording].append(begun.simulate(records[piece.recording].input[span]))
    return tuple(map(_joined, outputs))


def _started(
    data: DataSet, bank: PlayBank, model: HysteresisModel
) -> Iterator[tuple[Piece, HysteresisModel]]:
    """Each piece with the model in its state before it."""
    for piece, state in zip(data.pieces, bank.states, strict=True):
        yield piece, started(data, bank, model, state)


def _joined(pieces: list[Array]) -> Array:
    if len(pieces) == 1:
        return pieces[0]
    return np.concatenate(pieces)


def score(
    records: tuple[Recording, ...],
    outputs: Sequence[Array],
    part: Part,
    output_range: float,
    deviation: float | None = None,
) -> Score | None:
    """Score of the chosen samples of all recordings together; None if there are none.

    `deviation` is that of `deviation_of`, where it is known.
    """
    error = part.moments(outputs, outputs_of(records), extremes=True)
    if error.count == 0.0:
        return None
    if deviation is None:
        deviation = deviation_of(records, part)
    return score_from(error, deviation, output_range)


def deviation_of(records: tuple[Recording, ...], part: Part) -> float:
    """Standard deviation of the output over the chosen samples; 0 if there are none. [output]"""
    measured = outputs_of(records)
    about = part.moments(measured)
    middle = [np.broadcast_to(about.mean, record.output.shape) for record in records]
    return part.moments(measured, middle).rms


def score_from(error: Moments, deviation: float, output_range: float) -> Score:
    """Score from the moments of the error and the standard deviation of the output."""
    if deviation > 0:
        nrmse = error.rms / deviation
    elif error.rms > 0:
        nrmse = float("inf")
    else:
        nrmse = 0.0
    return Score(
        rmse=error.rms,
        rmse_percent=100.0 * error.rms / output_range,
        nrmse=nrmse,
        max=error.largest,
    )


def round_trip(model: HysteresisModel, x: Array) -> float:
    """Larger of max|inverse(model(x)) - x| and max|model(inverse(y)) - y|, y = model(x), relative to the ranges."""
    forward = model.stepper("dense")
    inverse = model.inverse().stepper("dense")
    again = model.stepper("dense")
    misses, ranges = np.zeros(2), np.array([[np.inf, -np.inf], [np.inf, -np.inf]])
    for part in chunks(slice(0, x.size)):
        y = forward.simulate(x[part])[0]
        back = inverse.simulate(y)[0]
        for k, (result, goal) in enumerate(((back, x[part]), (again.simulate(back)[0], y))):
            misses[k] = max(misses[k], float(np.max(np.abs(result - goal))))
            ranges[k, 0] = min(ranges[k, 0], float(goal.min()))
            ranges[k, 1] = max(ranges[k, 1], float(goal.max()))
    return float(np.max(misses / np.maximum(ranges[:, 1] - ranges[:, 0], 1e-300)))


def input_error(
    records: tuple[Recording, ...], demands: Sequence[Array], part: Part
) -> InputError | None:
    """Error of the input asked for, kept within the range that was applied; None if no samples are chosen."""
    inputs = inputs_of(records)
    low, high = input_range(records)
    # No actuator follows an input outside the range that was applied.
    clipped = [np.clip(demand, low, high) for demand in demands]
    return input_error_of(part.moments(clipped, inputs), robust_range(inputs))


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
    # The same of the curve's inverse, over held-out samples if there are any
    curve_input: InputError
    beyond: float  # How far the held-out input leaves what was fitted, share of the range
    levels_apart: float  # Largest difference of the mean residuals of two recordings. [output]
    evidence: tuple[Evidence, ...]  # Of rate and creep; empty without time stamps
    # Change of the residual from the first to the last cycle, and its standard error. [output]
    drift: tuple[float, float]
    conditions: tuple[Condition, ...] = ()  # Of the recordings, where there are several in memory
    # Of both signals in the fitted samples by name, ranges a second; empty without time
    speeds: Mapping[str, float] = field(default_factory=dict)

    @property
    def input_error(self) -> InputError:
        """Over held-out samples, over fitted ones if none were held out."""
        return self.input_test or self.input_train


class _Cycles:
    """Cycles of the samples of a recording that count, (T,)."""

    def __init__(self, record: Recording, counted: Mask) -> None:
        self._counted = None if counted.all() else counted
        self._cycles: facts.Cycles | None = None
        if np.count_nonzero(counted) > 8:
            self._cycles = facts.Cycles(self._of(record.input))

    def _of(self, signal: Array) -> Array:
        return signal if self._counted is None else signal[self._counted]

    def drift(self, record: Recording, output: Array) -> tuple[float, float]:
        """Change of a residual from the first to the last cycle, and its standard error. [output]"""
        if self._cycles is None:
            return 0.0, 0.0
        return self._cycles.drift(self._of(output), self._of(record.output))


@dataclass(frozen=True, eq=False)
class Baseline:
    """What all models of a log are compared with, where they are scored on the same samples."""

    static: StaticCurve  # The curve without memory
    scored: tuple[Part, Part]  # The samples, fitted and held out
    masks: tuple[tuple[Mask, ...], tuple[Mask, ...]]  # The same for each recording, (T,)
    # train, test, asked: Scores of the curve, and its error of the input
    train: Score
    test: Score | None
    asked: InputError
    # Of the output over the fitted and the held-out samples. [output]
    deviations: tuple[float, float]
    cycles: _Cycles  # Of the first recording
    drift: tuple[float, float]  # Change of its residual, and the standard error. [output]
    speeds: Mapping[str, float]  # Of both signals, as in `Measured`

    def serves(self, static: StaticCurve, scored: tuple[Part, Part]) -> bool:
        """Whether it is that of a curve and of samples; weights are not compared, so with any it is not."""
        if self.static.curve is not static.curve:
            return False
        for own, other in zip(self.scored, scored, strict=True):
            weighted = any(weight is not None for weight in (*own.weights, *other.weights))
            if weighted or own.spans != other.spans:
                return False
        return True


class Measure:
    """Compares models with recordings; what does not depend on the model is found once for all of them.

    Parameters
    ----------
    records
        The data.
    loads
        Shares (T,), 0 at the least and 1 at the most, of signals that change the loop, for each recording.
    """

    def __init__(
        self, records: tuple[Recording, ...], loads: Sequence[Sequence[Array]] = ()
    ) -> None:
        self._records, self._loads = records, loads
        self._tested: tuple[Evidence, ...] | None = None
        self._baseline: Baseline | None = None

    def __call__(
        self, data: DataSet, bank: PlayBank, model: HysteresisModel, static: StaticCurve, turns: int
    ) -> Measured:
        """Compare a model whose memory before each piece a bank tells."""
        outputs, demands = predictions(self._records, data, bank, model)
        trip = round_trip(model, self._records[0].input)
        scored = scored_parts(self._records, data, bank.initial_state)
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
        records = self._records
        fitted, held_out = scored
        baseline = self._compared_with(data, static, scored)
        train = score(records, outputs, fitted, data.output_range, baseline.deviations[0])
        test = score(records, outputs, held_out, data.output_range, baseline.deviations[1])
        input_train = input_error(records, demands, fitted)
        input_test = input_error(records, demands, held_out)
        if train is None or input_train is None:
            raise AssertionError("no training samples")  # the caller has checked
        train_masks, test_masks = baseline.masks
        # Where a curve is as good as the model, what is left of the model's error is not about the actuator.
        drift = baseline.drift
        if train.rmse <= baseline.train.rmse:
            drift = baseline.cycles.drift(records[0], outputs[0])
        if self._tested is None:
            self._tested = _evidence(records, data, turns, self._loads)
            if any(term.there for term in self._tested) and not self._loads:
                self._tested = _of_one_condition(records, data, turns, self._tested)
        return Measured(
            recordings=records,
            predictions=outputs,
            inverse_predictions=demands,
            train_masks=train_masks,
            test_masks=test_masks,
            train=train,
            test=test,
            static_train=baseline.train,
            static_test=baseline.test,
            round_trip=trip,
            input_train=input_train,
            input_test=input_test,
            curve_input=baseline.asked,
            beyond=_beyond_training(records, held_out, data),
            levels_apart=_levels_apart(records, outputs, fitted, held_out),
            evidence=self._tested,
            drift=facts.agreed(drift, baseline.drift),
            conditions=conditions(records, outputs, data.output_range),
            speeds=baseline.speeds,
        )

    def _compared_with(
        self, data: DataSet, static: StaticCurve, scored: tuple[Part, Part]
    ) -> Baseline:
        """Return the baseline of a curve and of samples; that of the model before serves most others."""
        if self._baseline is None or not self._baseline.serves(static, scored):
            self._baseline = _baseline(self._records, data, static, scored)
        return self._baseline


def _baseline(
    records: tuple[Recording, ...], data: DataSet, static: StaticCurve, scored: tuple[Part, Part]
) -> Baseline:
    fitted, held_out = scored
    curves = []
    demands = []
    for record in records:
        curves.append(static.simulate(record.input))
        demands.append(static.inverse().simulate(record.output))
    deviations = deviation_of(records, fitted), deviation_of(records, held_out)
    train = score(records, curves, fitted, data.output_range, deviations[0])
    test = score(records, curves, held_out, data.output_range, deviations[1])
    judged = held_out
    if test is None:
        judged = fitted
    asked = input_error(records, demands, judged)
    if train is None or asked is None:
        raise AssertionError("no training samples")  # the caller has checked
    masks = fitted.masks(records), held_out.masks(records)
    cycles = _Cycles(records[0], masks[0][0] | masks[1][0])
    return Baseline(
        static=static,
        scored=scored,
        masks=masks,
        train=train,
        test=test,
        asked=asked,
        deviations=deviations,
        cycles=cycles,
        drift=cycles.drift(records[0], curves[0]),
        speeds=_fitted_speeds(records, masks[0]),
    )


def _fitted_speeds(records: Sequence[Recording], masks: Sequence[Mask]) -> dict[str, float]:
    """Speeds of both signals in the fitted samples, in ranges a second; empty without time."""
    inputs = []
    outputs = []
    for record, mask in zip(records, masks, strict=True):
        if record.time is not None:
            time = np.asarray(record.time)[mask]
            inputs.append((time, record.input[mask]))
            outputs.append((time, record.output[mask]))
    if not inputs:
        return {}
    low, high = input_range(records)
    least, most = output_range(records)
    return {
        "input": float(f"{top_speed(inputs, high - low):.4g}"),
        "output": float(f"{top_speed(outputs, most - least):.4g}"),
    }


def _of_one_condition(
    records: tuple[Recording, ...], data: DataSet, turns: int, tested: tuple[Evidence, ...]
) -> tuple[Evidence, ...]:
    """Evidence of recordings under different conditions: what most of them do not show alone is not there.

    Loops that another signal widens are followed by any term that is wide where they are.
    """
    conditions_met = conditions(records, None, data.output_range)
    if not wider(conditions_met) and not steeper(conditions_met):
        return tested
    alone = [_evidence((record,), data, turns, (), index) for index, record in enumerate(records)]
    judged = []
    for term in tested:
        # How many recordings can be tested alone, and how many of these show it.
        able = shown = 0
        for terms in alone:
            for single in terms:
                if single.group == term.group:
                    able += 1
                    shown += single.there
        if 2 * shown > able:
            judged.append(term)
        else:
            judged.append(replace(term, with_percent=term.without_percent))
    return tuple(judged)


def _evidence(
    records: tuple[Recording, ...],
    data: DataSet,
    turns: int,
    loads: Sequence[Sequence[Array]],
    first: int = 0,
) -> tuple[Evidence, ...]:
    """Evidence of recordings that stand in the data from number `first` on."""
    timed = []
    for k, record in enumerate(records):
        if record.time is not None:
            timed.append((k, record, record.time))
    all_rows = rows_of([time.size for _, _, time in timed], turns)
    stretches = []
    for (k, record, time), rows in zip(timed, all_rows, strict=True):
        signals = [time, record.input, record.output]
        if loads:
            signals += loads[first + k]
        sampled = np.array([signal[rows] for signal in signals])
        stretches += stretches_of(data, first + k, rows, sampled)
    return evidence(stretches)


def _levels_apart(
    records: tuple[Recording, ...], outputs: tuple[Array, ...], fitted: Part, held_out: Part
) -> float:
    """Largest difference of the mean residuals of two recordings, where they are fitted if they are. [output]"""
    if len(records) < 2:
        return 0.0
    measured = outputs_of(records)
    levels = []
    for k in range(len(records)):
        # The held-out samples stand for a recording of which nothing is fitted.
        for part in (fitted, held_out):
            about = part.moments(measured, outputs, k)
            if about.count:
                levels.append(about.mean)
                break
    return max(levels) - min(levels)


def _beyond_training(records: tuple[Recording, ...], part: Part, data: DataSet) -> float:
    """How far the held-out input leaves [-1, 1] scaled, share of the range."""
    if not part:
        return 0.0
    inputs = inputs_of(records)
    middle = [np.broadcast_to(data.center, x.shape) for x in inputs]
    farthest = part.moments(inputs, middle, extremes=True).largest
    return 0.5 * max(0.0, farthest / data.half_range - 1.0)
