r"""Splits a model into curve, hysteresis and creep, and fits changes of these parts to groups of cycles.

.. math::

    y - \hat y = a_0 + a_1 (\hat y - m) + a_2 h + a_3 P_2(\xi) + a_4 P_3(\xi)
        + a_5 \tfrac13 \sum_k (\xi - L_{\tau_k}[\xi])

with the prediction :math:`\hat y`, its hysteresis h, the middle m of the response's range, the drive :math:`\xi` scaled
to [-1, 1], Legendre polynomials P and first-order lags L of a third of a cycle, a cycle and three cycles. So a_0 is a
shift, a_1 the relative change of the whole, a_2 that of the loop beyond it.
"""

from __future__ import annotations

import itertools
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeAlias, cast

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array
from dehyst.data import Recording
from dehyst.design import lags
from dehyst.identification import state_before
from dehyst.models import (
    GROUPS,
    DirectInverse,
    HysteresisModel,
    Model,
    PrandtlIshlinskii,
    SignalCard,
)
from dehyst.models import kit as models_kit
from dehyst.monitoring._groups import Cycle, rms, samples_of_cycles
from dehyst.monitoring._policy import POLICY

Parted: TypeAlias = Model  # what can be taken apart: the core runs it

# Cores of the models that say what part of their answer is creep.
DIRECT = "direct"
ELEMENTS = "elements"
# Columns of such an answer.
CREEPING = GROUPS.index("creep")
VISCID = GROUPS.index("viscous")


@dataclass(frozen=True)
class Prediction:
    """What a model says of one recording, (T,) each.

    Attributes
    ----------
    response
        Prediction of the response. [response]
    loop
        Part of it that is hysteresis, zero for a curve. [response]
    drive
        Drive that the measured response needs, the model read the other way; None where that does not exist. [drive]
    creep, viscous
        Parts of it that creep and viscosity are, of models that have them. [response]
    """

    response: Array
    loop: Array
    drive: Array | None = None
    creep: Array | None = None
    viscous: Array | None = None


@dataclass(frozen=True)
class JudgedModel:
    """A model in the direction in which it is used.

    A sheared model runs as its compensator, whatever k: forward it may not exist, and the errors of the output on its
    card are those of a loop that sees the output in its input.

    Attributes
    ----------
    model
        As it was saved.
    runs
        What is run: the model, or the compensator of a sheared one.
    backward
        Whether it is driven by the log's output and predicts its input.
    """

    model: Parted
    runs: Parted
    backward: bool

    @classmethod
    def of(cls, model: Parted) -> JudgedModel:
        """Take a model of any family."""
        if model.judged_backward:
            return cls(model, model.compensator(), True)
        return cls(model, model, False)

    @property
    def drive(self) -> SignalCard:
        """Signal that drives what is run."""
        if self.backward:
            return self.model.card.output
        return self.model.card.input

    @property
    def response(self) -> SignalCard:
        """Signal that is predicted."""
        if self.backward:
            return self.model.card.input
        return self.model.card.output

    def signals(self, record: Recording) -> tuple[Array, Array]:
        """Drive and response of a recording."""
        if self.backward:
            return record.output, record.input
        return record.input, record.output

    def cannot(self, record: Recording) -> str:
        """Return why a recording does not hold what the model needs, or ""."""
        for name in self.runs.needs:
            if name not in record.schedules:
                return (
                    f"the model depends on '{name}', which the log does not name. Name its column: --schedule "
                    f"{name}=COLUMN"
                )
        if self.runs.rate_dependent and record.time is None:
            return "the model has creep or viscosity, but the log has no time stamps. Name its time column with --time"
        return ""


def inside(subject: JudgedModel, x: Array) -> npt.NDArray[np.bool_]:
    """Which samples of the drive count: of a direct inverse those within its range, beyond which its curve is held."""
    low, high = subject.drive.low, subject.drive.high
    if subject.runs.core != DIRECT or low is None or high is None:
        return np.ones(x.size, dtype=np.bool_)
    return np.asarray((x >= low) & (x <= high))


def predict_parts(subject: JudgedModel, record: Recording) -> Prediction:
    """Run a model over a recording; before every piece it is taken to have gone through its range and come up."""
    if subject.runs.core == DIRECT:
        return _direct(cast(DirectInverse, subject.runs), record)
    if subject.runs.core == ELEMENTS:
        return _elements(subject.runs, record)
    return _plays(subject, cast(HysteresisModel, subject.runs), record)


def _direct(model: DirectInverse, record: Recording) -> Prediction:
    """Run a direct inverse with any past: what it does not know yet is not used before both ends were visited."""
    restart = np.zeros(len(record), dtype=np.bool_)
    restart[list(record.breaks)] = True
    time = record.time
    if time is None:
        time = np.arange(len(record), dtype=np.float64)
    ran = model.with_past(models_kit.UNKNOWN).run(
        record.output, time, given=record.signals(model.needs), restart=restart
    )
    creep, viscous = ran.parts[:, CREEPING].copy(), ran.parts[:, VISCID].copy()
    loop = np.sum(np.delete(ran.parts, (CREEPING, VISCID), axis=1), axis=1)
    drive = None
    if model.card.output.low is not None:
        drive = _followed(model, record, time)
    return Prediction(ran.u, loop, drive, creep, viscous)


def _elements(model: Any, record: Recording) -> Prediction:
    """Run a sum of elements, the same without lags, and without memory: what differs is creep, and the loop."""
    model = model.with_start("rising")
    response, loop, drive, creep = np.empty((4, len(record)))
    for piece in record.pieces:
        x = record.input[piece]
        time = None
        if record.time is not None:
            time = record.time[piece]
        signals = record.signals(model.needs, piece)
        y = model.simulate(x, time, **signals)
        # Lags without memory would be creep of the curve: each simulation leaves out one thing more.
        quick = model.without_lags.simulate(x, time, **signals)
        still = model.without_memory.simulate(x, time, **signals)
        response[piece] = y
        loop[piece] = quick - still
        creep[piece] = y - quick
        if not model.no_inverse:
            demand = model.inverse().simulate(record.output[piece], time, **signals)
            drive[piece] = model.ahead(demand, time)
    prediction = Prediction(response, loop)
    if not model.no_inverse:
        prediction = replace(prediction, drive=drive)
    if model.rate_dependent:
        prediction = replace(prediction, creep=creep)
    return prediction


def _followed(model: DirectInverse, record: Recording, time: Array) -> Array:
    """Output that the logged input gives, by the model solved for it."""
    outputs = []
    for piece in record.pieces:
        clock = np.ascontiguousarray(time[piece])
        signals = record.signals(model.needs, piece)
        outputs.append(models_kit.follow(model, record.input[piece], clock, signals).y)
    return np.concatenate(outputs)


def _plays(subject: JudgedModel, model: HysteresisModel, record: Recording) -> Prediction:
    """Run a sum of plays, and the same without memory: what differs is the loop."""
    still = memoryless(model)
    driving, measured = subject.signals(record)
    responses, curves, drives = [], [], []
    for piece in record.pieces:
        x = np.ascontiguousarray(driving[piece])
        started = settled_model(model, x)
        responses.append(started.simulate(x))
        curves.append(still.simulate(x))
        if not subject.backward:
            drives.append(started.inverse().simulate(measured[piece]))
    response = np.concatenate(responses)
    drive = np.concatenate(drives) if drives else None
    return Prediction(response, response - np.concatenate(curves), drive)


def settled_model(model: HysteresisModel, x: Array) -> HysteresisModel:
    """The model with a memory of its whole range and of x, coming up to the first sample."""
    if not model.nonzero_weights:
        return model
    plays, before, _ = model._plays()
    card = model.card.input
    low, high, first = float(np.min(x)), float(np.max(x)), float(x[0])
    if card.low is not None and card.high is not None:
        low, high = min(low, card.low), max(high, card.high)
    if before is not None:
        # A curve before the plays may fall, so that its ends change places.
        ends = np.asarray(before([low, high, first])).tolist()
        low, high, first = min(ends[:2]), max(ends[:2]), ends[2]
    center = plays.center
    state = state_before("unknown", plays.thresholds, first - center, low - center, high - center)
    return model.with_state(state)


def memoryless(model: HysteresisModel) -> HysteresisModel:
    """The model with every play of radius r replaced by the identity: no loop, the slope of large motions.

    Examples
    --------
    >>> memoryless(PrandtlIshlinskii([0.0, 0.5], [1.0, 2.0], offset=1.0)).simulate([0.0, 1.0, 0.0]).tolist()
    [1.0, 4.0, 1.0]
    """
    if not model.nonzero_weights:
        return model
    inner = cast(PrandtlIshlinskii, model._inner())
    line = PrandtlIshlinskii(
        np.zeros(1), np.array([np.sum(inner.weights)]), inner.offset, None, inner.center
    )
    return model.with_operator(line)


OFFSET = "offset"
GAIN = "gain"
HYSTERESIS = "hysteresis"
BEND = "bend"
S_BEND = "s-bend"
CREEP = "creep"
# Scales of what a direct inverse has of its own; the creep above is one that the model lacks.
OWN_CREEP = "own-creep"
VISCOUS = "viscous"
# What no part explains, and the whole error.
REST = "rest"
ERROR = "error"
# Parts that are zero on the log that a model was identified from, and parts that a model lacks.
FITTED = (OFFSET, GAIN, HYSTERESIS, OWN_CREEP, VISCOUS)
LACKED = (BEND, S_BEND, CREEP)
PARTS = (*FITTED, *LACKED)
NAMES = {
    OFFSET: "offset",
    GAIN: "gain",
    HYSTERESIS: "hysteresis size",
    OWN_CREEP: "creep size",
    VISCOUS: "viscosity",
    BEND: "bend of the curve",
    S_BEND: "S of the curve",
    CREEP: "creep",
    REST: "unexplained rest",
    ERROR: "error of the model",
}
# Time constants of creep, in cycles.
LAGS = (1 / 3, 1.0, 3.0)
# Cycles after which every lag has settled, and even samples for each one that was logged, at most.
SETTLED, FINEST = 30.0, 20
# Parts that are given up where they cannot be told from the others, tried in this order.
DISPENSABLE = (CREEP, S_BEND, BEND, VISCOUS, OWN_CREEP, HYSTERESIS, GAIN)


@dataclass(frozen=True, slots=True)
class Scale:
    """Middle and half range of drive and response, and the length of a cycle.

    Attributes
    ----------
    drive, response
        Middle and half range. [units of the log]
    period
        Median length of a cycle, None without time stamps. [s]
    """

    drive: tuple[float, float]
    response: tuple[float, float]
    period: float | None

    @property
    def span(self) -> float:
        """Range of the response. [response]"""
        return 2.0 * self.response[1]


def part_columns(
    record: Recording, x: Array, prediction: Prediction, scale: Scale
) -> dict[str, Array]:
    """Regressors by part, (T,) each. [response, 1]"""
    xi = (x - scale.drive[0]) / scale.drive[1]
    columns = {
        OFFSET: np.ones(x.size),
        GAIN: prediction.response - scale.response[0],
        HYSTERESIS: prediction.loop,
        BEND: scale.response[1] * 0.5 * (3.0 * xi**2 - 1.0),
        S_BEND: scale.response[1] * 0.5 * (5.0 * xi**3 - 3.0 * xi),
    }
    if prediction.viscous is not None and np.any(prediction.viscous):
        columns[VISCOUS] = prediction.viscous
    if prediction.creep is not None and np.any(prediction.creep):
        columns[OWN_CREEP] = prediction.creep
    elif scale.period is not None and record.time is not None:
        columns[CREEP] = scale.response[1] * _lagging(record, xi, scale.period)
    return columns


def _lagging(record: Recording, xi: Array, period: float) -> Array:
    """Mean of xi - L[xi] over the lags; each piece starts settled at its mean."""
    assert record.time is not None
    total = np.zeros(xi.size)
    for piece in record.pieces:
        t, values = record.time[piece], xi[piece]
        # A night's rest is as long as it takes to settle.
        steps = np.minimum(np.diff(t), SETTLED * period)
        if steps.size == 0:
            continue
        clock = np.concatenate([np.zeros(1), np.cumsum(steps)])
        step = max(float(np.median(steps)), float(clock[-1]) / (FINEST * t.size))
        even = np.arange(0.0, clock[-1] + 0.5 * step, step)
        signal = np.interp(even, clock, values)
        mean = float(np.mean(signal))
        # The zero in front is where every lag starts.
        padded = np.concatenate([[0.0], signal - mean])
        late = lags(padded, step, [lag * period for lag in LAGS])[1:] + mean
        for column in late.T:
            total[piece] += (values - np.interp(clock, even, column)) / len(LAGS)
    return total


@dataclass(frozen=True)
class Estimates:
    """Fits of q groups.

    Attributes
    ----------
    parts
        Names of the p coefficients.
    values
        Coefficients, (q, p).
    remainder
        RMS of what no part explains, (q,). [response]
    error, inverse
        RMS of the error of the prediction [response], and of the drive that the inverse asks for less the one that was
        applied [drive], (q,); the latter None where there is no inverse.
    counted
        RMS of the error less what parts that are ignored do, (q,). [response]
    sizes
        RMS of each regressor, its mean taken out, over all groups, (p,): a change times its size is what it does.
        [response]
    motion
        Standard deviation of the drive in each group, (q,). [drive]
    """

    parts: tuple[str, ...]
    values: Array
    remainder: Array
    error: Array
    inverse: Array | None
    counted: Array
    sizes: Array
    motion: Array


@dataclass(frozen=True)
class MeasuredRecording:
    """A recording with what the model says of it.

    Attributes
    ----------
    error, inverse_error
        Response less prediction, (T,), and drive asked for less applied, or None.
    columns
        Regressors by part.
    inside
        Samples that count, (T,): all of them, or those within the range in which a direct inverse was identified.
    """

    record: Recording
    drive: Array
    response: Array
    prediction: Prediction
    error: Array
    inverse_error: Array | None
    columns: dict[str, Array]
    inside: npt.NDArray[np.bool_]

    def places(self, group: Sequence[Cycle]) -> npt.NDArray[np.int64]:
        """Indices of the samples of a group that count; all of them if none does."""
        every = samples_of_cycles(group)
        counted = every[self.inside[every]]
        if not counted.size:
            return every
        return counted


def fit_steps(parts: Sequence[str], referred: bool) -> tuple[tuple[str, ...], ...]:
    """Parts that are fitted together, in turn: all at once against a reference; else what the model has comes first.

    A model takes the creep that it lacks for hysteresis. Fitted together with creep, its hysteresis would seem to have
    shrunk from the first day on; against a reference that cancels.
    """
    if referred:
        return (tuple(parts),)
    return tuple(filter(FITTED.__contains__, parts)), tuple(filter(LACKED.__contains__, parts))


def distinct_parts(
    measured: MeasuredRecording, groups: Sequence[Sequence[Cycle]], parts: Sequence[str]
) -> tuple[str, ...]:
    """Return those of the parts fitted together that the groups can tell apart."""
    distinct = []
    for part in parts:
        # A column that never moves is an offset.
        if part == OFFSET or np.any(np.ptp(measured.columns[part]) > 0.0):
            distinct.append(part)
    places = [measured.places(group) for group in groups]
    for part in DISPENSABLE:
        # A part that the model lacks must be told apart more clearly than one that it has.
        limit = POLICY.inflation_lacked
        if part in FITTED:
            limit = POLICY.inflation
        if part in distinct:
            inflation = _inflation(measured, places, distinct)[distinct.index(part)]
            if inflation > limit:
                distinct.remove(part)
    return tuple(distinct)


def _matrix(
    measured: MeasuredRecording, parts: Sequence[str], place: npt.NDArray[np.int64]
) -> Array:
    """Columns of some parts at some samples."""
    return np.column_stack([measured.columns[part][place] for part in parts])


def _inflation(
    measured: MeasuredRecording, places: Sequence[npt.NDArray[np.int64]], parts: Sequence[str]
) -> Array:
    """Median over the groups of the factor by which the other parts raise the variance of each."""
    factors = np.ones((len(places), len(parts)))
    for row, place in zip(factors, places, strict=True):
        matrix = _matrix(measured, parts, place)
        norm = np.linalg.norm(matrix, axis=0)
        unit = matrix / np.where(norm > 0.0, norm, 1.0)
        # The diagonal of the inverse correlation matrix holds the inflation of each variance.
        gram = unit.T @ unit
        row[:] = np.diag(np.linalg.pinv(gram + 1e-12 * np.eye(len(parts)), hermitian=True))
        row[norm == 0.0] = np.inf
    return np.asarray(np.median(factors, axis=0))


def estimate(
    measured: MeasuredRecording,
    groups: Sequence[Sequence[Cycle]],
    steps: Sequence[Sequence[str]],
    ignored: Collection[str] = (),
) -> Estimates:
    """Fit the parts to each group of cycles alone; each step is fitted to the error that the step before left."""
    parts = tuple(itertools.chain(*steps))
    values = np.zeros((len(groups), len(parts)))
    remainder, error, counted, inverse, motion = np.zeros((5, len(groups)))
    places = [measured.places(group) for group in groups]
    for k, place in enumerate(places):
        left = counting = measured.error[place]
        first = 0
        for step in filter(None, steps):
            matrix = _matrix(measured, step, place)
            scale = np.linalg.norm(matrix, axis=0)
            scale[scale == 0.0] = 1.0
            coefficients = np.linalg.lstsq(matrix / scale, left, rcond=1e-10)[0] / scale
            values[k, first : first + len(step)] = coefficients
            # The error that counts is without what the ignored parts do.
            is_ignored = [part in ignored for part in step]
            counting = counting - matrix @ np.where(is_ignored, coefficients, 0.0)
            left = left - matrix @ coefficients
            first += len(step)
        remainder[k] = rms(left)
        error[k] = rms(measured.error[place])
        counted[k] = rms(counting)
        motion[k] = np.std(measured.drive[place])
        if measured.inverse_error is not None:
            inverse[k] = rms(measured.inverse_error[place])
    everything = np.concatenate(places)
    sizes = np.ones(len(parts))
    for k, part in enumerate(parts):
        if part != OFFSET:
            sizes[k] = np.std(measured.columns[part][everything])
    return Estimates(
        parts,
        values,
        remainder,
        error,
        inverse if measured.inverse_error is not None else None,
        counted,
        sizes,
        motion,
    )
