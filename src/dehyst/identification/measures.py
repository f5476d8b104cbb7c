"""How model and curve compare with all samples: scores, round trip, and what the residuals say of the data."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from dehyst.arrays import Array, Mask
from dehyst.data.recording import Recording
from dehyst.identification import facts
from dehyst.identification.data import DataSet
from dehyst.identification.evidence import Evidence, evidence, rows_of, stretches_of
from dehyst.identification.fit import InputError, Score
from dehyst.identification.regressors import Bank
from dehyst.identification.scores import Part, input_error, parts, predictions, round_trip, score
from dehyst.models import HysteresisModel, StaticCurve


@dataclass(frozen=True)
class Measured:
    """What comparing a model with all samples gives.

    Attributes
    ----------
    recordings, outputs, demands
        The data, the model's output and what its inverse asks for, (T,) for each recording.
    train_masks, test_masks
        Which samples were fitted and held out.
    train, test, static_train, static_test
        Scores of the model and of the curve.
    round_trip
        Of model and inverse, relative to the ranges.
    input_train, input_test
        Error of the input asked for; None where nothing was held out.
    curve_input
        The same of the curve's inverse, over held-out samples if there are any.
    beyond
        How far the held-out input leaves what was fitted, share of the range.
    levels_apart
        Largest difference of the mean residuals of two recordings. [output]
    evidence
        Of rate and creep; empty without time stamps.
    drift
        Change of the residual from the first to the last cycle, and its standard error. [output]
    """

    recordings: tuple[Recording, ...]
    outputs: tuple[Array, ...]
    demands: tuple[Array, ...]
    train_masks: tuple[Mask, ...]
    test_masks: tuple[Mask, ...]
    train: Score
    test: Score | None
    static_train: Score
    static_test: Score | None
    round_trip: float
    input_train: InputError
    input_test: InputError | None
    curve_input: InputError
    beyond: float
    levels_apart: float
    evidence: tuple[Evidence, ...]
    drift: tuple[float, float]

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
            signals = (records[0].input, better[0], records[0].output)
            change = facts.drift(*(signals if seen.all() else (signal[seen] for signal in signals)))
        if self._tested is None:
            self._tested = _evidence(records, data, turns, self._loads)
        return Measured(
            recordings=records,
            outputs=outputs,
            demands=demands,
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
        )


def _evidence(
    records: tuple[Recording, ...], data: DataSet, turns: int, loads: Sequence[Sequence[Array]]
) -> tuple[Evidence, ...]:
    timed = [(k, record, record.time) for k, record in enumerate(records) if record.time is not None]
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
