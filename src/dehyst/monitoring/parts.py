r"""Splits a model into curve, hysteresis and creep, and fits changes of these parts to groups of cycles.

.. math::

    y - \hat y = a_0 + a_1 (\hat y - m) + a_2 h + a_3 P_2(\xi) + a_4 P_3(\xi)
        + a_5 \tfrac13 \sum_k (\xi - L_{\tau_k}[\xi])

with the prediction :math:`\hat y`, its hysteresis h, the middle m of the response's range, the drive :math:`\xi` scaled
to [-1, 1], Legendre polynomials P and first-order lags L of a third of a cycle, a cycle and three cycles. So a_0 is a
shift, a_1 the relative change of the whole, a_2 that of the loop beyond it.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias, cast

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array
from dehyst.data.recording import Recording
from dehyst.identification.memory import state_before
from dehyst.models import GROUPS, DirectInverse, HysteresisModel, PrandtlIshlinskii, SignalCard
from dehyst.models.follow import follow
from dehyst.models.model import Model
from dehyst.monitoring.groups import Cycle, rms, samples_of

Parted: TypeAlias = Model  # what can be taken apart: the core runs it
Given: TypeAlias = Mapping[str, Array]

DIRECT, ELEMENTS = "direct", "elements"  # cores of the models that say what part of their answer is creep
CREEPING, VISCID = GROUPS.index("creep"), GROUPS.index("viscous")


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
class Subject:
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
    def of(cls, model: Parted) -> Subject:
        """Take a model of any family."""
        runs = model.compensator() if model.judged_backward else model
        return cls(model, runs, model.judged_backward)

    @property
    def drive(self) -> SignalCard:
        """Signal that drives what is run."""
        return self.model.card.output if self.backward else self.model.card.input

    @property
    def response(self) -> SignalCard:
        """Signal that is predicted."""
        return self.model.card.input if self.backward else self.model.card.output

    def signals(self, record: Recording) -> tuple[Array, Array]:
        """Drive and response of a recording."""
        return (record.output, record.input) if self.backward else (record.input, record.output)

    def cannot(self, record: Recording, given: Given) -> str:
        """Return why a recording does not hold what the model needs, or ""."""
        missing = [name for name in self.runs.needs if name not in given]
        if missing:
            option = missing[0].replace("_", "-")
            return f"the model depends on '{missing[0]}', which was not given. Name its column: --{option}"
        if self.runs.rate_dependent and record.time is None:
            return "the model has creep or viscosity, but the log has no time stamps. Name its time column with --time"
        return ""


def inside(subject: Subject, x: Array) -> npt.NDArray[np.bool_]:
    """Which samples of the drive count: of a direct inverse those within its range, beyond which its curve is held."""
    low, high = subject.drive.low, subject.drive.high
    if subject.runs.core != DIRECT or low is None or high is None:
        return np.ones(x.size, dtype=np.bool_)
    return np.asarray((x >= low) & (x <= high))


def predict(subject: Subject, record: Recording, given: Given | None = None) -> Prediction:
    """Run a model over a recording; before every piece it is taken to have gone through its range and come up."""
    if subject.runs.core == DIRECT:
        return _direct(cast(DirectInverse, subject.runs), record, given or {})
    if subject.runs.core == ELEMENTS:
        return _elements(subject.runs, record, given or {})
    plays = cast(HysteresisModel, subject.runs)
    joined = [np.concatenate(part) for part in zip(*_pieces(subject, plays, record), strict=True)]
    drive = None if subject.backward else joined[2]
    return Prediction(joined[0], joined[0] - joined[1], drive)


def _direct(model: DirectInverse, record: Recording, given: Given) -> Prediction:
    """Run a direct inverse with any past: what it does not know yet is not used before both ends were visited."""
    restart = np.zeros(len(record), dtype=np.bool_)
    restart[list(record.breaks)] = True
    time = record.time if record.time is not None else np.arange(len(record), dtype=np.float64)
    ran = model.with_known(False).run(record.output, time, given=given, restart=restart)
    loop = np.sum(np.delete(ran.parts, (CREEPING, VISCID), axis=1), axis=1)
    drive = None if model.card.output.low is None else _followed(model, record, time, given)
    return Prediction(ran.u, loop, drive, ran.parts[:, CREEPING].copy(), ran.parts[:, VISCID].copy())


def _elements(model: Any, record: Recording, given: Given) -> Prediction:
    """Run a sum of elements, the same without lags, and without memory: what differs is creep, and the loop."""
    model = model.with_start("rising")
    parts = []
    for piece in record.pieces:
        time = None if record.time is None else record.time[piece]
        signals = {name: values[piece] for name, values in given.items()}
        sums = (model, model.without_lags, model.without_memory)
        y, quick, still = (each.simulate(record.input[piece], time, **signals) for each in sums)
        asked = y if model.no_inverse else model.ahead(model.inverse().simulate(record.output[piece], time, **signals))
        parts.append((y, quick - still, asked, y - quick))
    response, loop, drive, creep = (np.concatenate(part) for part in zip(*parts, strict=True))
    return Prediction(response, loop, None if model.no_inverse else drive, creep if model.rate_dependent else None)


def _followed(model: DirectInverse, record: Recording, time: Array, given: Given) -> Array:
    """Output that the logged input gives, by the model solved for it."""
    parts = []
    for piece in record.pieces:
        held = {name: np.ascontiguousarray(values[piece]) for name, values in given.items()}
        parts.append(follow(model, record.input[piece], np.ascontiguousarray(time[piece]), held).y)
    return np.concatenate(parts)


def _pieces(subject: Subject, model: HysteresisModel, record: Recording) -> Iterator[tuple[Array, Array, Array]]:
    still = memoryless(model)
    drive, measured = subject.signals(record)
    for piece in record.pieces:
        x = np.ascontiguousarray(drive[piece])
        started = settled(model, x)
        asked = x if subject.backward else started.inverse().simulate(measured[piece])
        yield started.simulate(x), still.simulate(x), asked


def settled(model: HysteresisModel, x: Array) -> HysteresisModel:
    """The model with a memory of its whole range and of x, coming up to the first sample."""
    if not model.nonzero_weights:
        return model
    plays, before, _ = model._plays()
    card = model.card.input
    ends = [float(np.min(x)), float(np.max(x)), float(x[0])]
    if card.low is not None and card.high is not None:
        ends = [min(ends[0], card.low), max(ends[1], card.high), ends[2]]
    if before is not None:
        ends = np.asarray(before(ends)).tolist()
        ends = [min(ends[:2]), max(ends[:2]), ends[2]]
    low, high, first = (value - plays.center for value in ends)
    return model.with_state(state_before("unknown", plays.thresholds, first, low, high))


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
    line = PrandtlIshlinskii(np.zeros(1), np.array([np.sum(inner.weights)]), inner.offset, None, inner.center)
    return model.with_operator(line)


OFFSET, GAIN, HYSTERESIS, BEND, S_BEND, CREEP = "offset", "gain", "hysteresis", "bend", "s-bend", "creep"
# Scales of what a direct inverse has of its own; the creep above is one that the model lacks.
OWN_CREEP, VISCOUS, REST, ERROR = "own-creep", "viscous", "rest", "error"
FITTED = (OFFSET, GAIN, HYSTERESIS, OWN_CREEP, VISCOUS)  # zero on the log that a model was identified from
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
# A part whose variance is raised more than this by the others cannot be told from them: one that the model has, and one
# that it lacks. Tried in this order.
INFLATION = 100.0
INFLATION_LACKED = 10.0
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


def columns_of(record: Recording, x: Array, prediction: Prediction, scale: Scale) -> dict[str, Array]:
    """Regressors by part, (T,) each. [response, 1]"""
    xi = (x - scale.drive[0]) / scale.drive[1]
    found = {
        OFFSET: np.ones(x.size),
        GAIN: prediction.response - scale.response[0],
        HYSTERESIS: prediction.loop,
        BEND: scale.response[1] * 0.5 * (3.0 * xi**2 - 1.0),
        S_BEND: scale.response[1] * 0.5 * (5.0 * xi**3 - 3.0 * xi),
    }
    if prediction.viscous is not None and np.any(prediction.viscous):
        found[VISCOUS] = prediction.viscous
    if prediction.creep is not None and np.any(prediction.creep):
        found[OWN_CREEP] = prediction.creep
    elif scale.period is not None and record.time is not None:
        found[CREEP] = scale.response[1] * _lagging(record, xi, scale.period)
    return found


def _lagging(record: Recording, xi: Array, period: float) -> Array:
    """Mean of xi - L[xi] over the lags; each piece starts settled at its mean."""
    from scipy.signal import lfilter  # takes long to import

    assert record.time is not None
    total = np.zeros(xi.size)
    for piece in record.pieces:
        t, values = record.time[piece], xi[piece]
        steps = np.minimum(np.diff(t), SETTLED * period)  # a night's rest is as long as it takes to settle
        if steps.size == 0:
            continue
        clock = np.concatenate([np.zeros(1), np.cumsum(steps)])
        step = max(float(np.median(steps)), float(clock[-1]) / (FINEST * t.size))
        even = np.arange(0.0, clock[-1] + 0.5 * step, step)
        signal = np.interp(even, clock, values)
        mean = float(np.mean(signal))
        for lag in LAGS:
            gain = 1.0 - np.exp(-step / (lag * period))
            late = lfilter([gain], [1.0, gain - 1.0], signal - mean) + mean
            total[piece] += (values - np.interp(clock, even, late)) / len(LAGS)
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
    rest
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
    rest: Array
    error: Array
    inverse: Array | None
    counted: Array
    sizes: Array
    motion: Array


@dataclass(frozen=True)
class Measured:
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
        """Indices of the samples of a group that count."""
        every = samples_of(group)
        kept = every[self.inside[every]]
        return kept if kept.size else every


def steps_of(parts: Sequence[str], referred: bool) -> tuple[tuple[str, ...], ...]:
    """Parts that are fitted together, in turn: all at once against a reference; else what the model has comes first.

    A model takes the creep that it lacks for hysteresis. Fitted together with creep, its hysteresis would seem to have
    shrunk from the first day on; against a reference that cancels.
    """
    if referred:
        return (tuple(parts),)
    return tuple(p for p in parts if p in FITTED), tuple(p for p in parts if p in LACKED)


def distinct_parts(measured: Measured, groups: Sequence[Sequence[Cycle]], parts: Sequence[str]) -> tuple[str, ...]:
    """Return those of the parts fitted together that the groups can tell apart."""
    kept = [part for part in parts if part == OFFSET or np.any(np.ptp(measured.columns[part]) > 0.0)]
    places = [measured.places(group) for group in groups]
    for part in DISPENSABLE:
        limit = INFLATION if part in FITTED else INFLATION_LACKED
        if part in kept and _inflation(measured, places, kept)[kept.index(part)] > limit:
            kept.remove(part)
    return tuple(kept)


def _inflation(measured: Measured, places: Sequence[npt.NDArray[np.int64]], parts: Sequence[str]) -> Array:
    """Median over the groups of the factor by which the other parts raise the variance of each."""
    factors = np.ones((len(places), len(parts)))
    for row, place in zip(factors, places, strict=True):
        matrix = np.column_stack([measured.columns[part][place] for part in parts])
        norm = np.linalg.norm(matrix, axis=0)
        unit = matrix / np.where(norm > 0.0, norm, 1.0)
        gram = unit.T @ unit
        row[:] = np.diag(np.linalg.pinv(gram + 1e-12 * np.eye(len(parts)), hermitian=True))
        row[norm == 0.0] = np.inf
    return np.asarray(np.median(factors, axis=0))


def estimate(
    measured: Measured,
    groups: Sequence[Sequence[Cycle]],
    steps: Sequence[Sequence[str]],
    ignored: Collection[str] = (),
) -> Estimates:
    """Fit the parts to every group by itself, step after step to what the one before left."""
    parts = [part for step in steps for part in step]
    values = np.zeros((len(groups), len(parts)))
    rest, error, counted = np.zeros((3, len(groups)))
    inverse = None if measured.inverse_error is None else np.zeros(len(groups))
    for k, group in enumerate(groups):
        place = measured.places(group)
        left, first = measured.error[place], 0
        counting = left
        for step in filter(None, steps):
            matrix = np.column_stack([measured.columns[part][place] for part in step])
            scale = np.linalg.norm(matrix, axis=0)
            scale[scale == 0.0] = 1.0
            found = np.linalg.lstsq(matrix / scale, left, rcond=1e-10)[0] / scale
            values[k, first : first + len(step)] = found
            counting = counting - matrix @ np.where([part in ignored for part in step], found, 0.0)
            left, first = left - matrix @ found, first + len(step)
        rest[k], error[k], counted[k] = rms(left), rms(measured.error[place]), rms(counting)
        if inverse is not None and measured.inverse_error is not None:
            inverse[k] = rms(measured.inverse_error[place])
    everything = np.concatenate([measured.places(group) for group in groups])
    sizes = [1.0 if part == OFFSET else float(np.std(measured.columns[part][everything])) for part in parts]
    motion = np.array([np.std(measured.drive[measured.places(group)]) for group in groups])
    return Estimates(tuple(parts), values, rest, error, inverse, counted, np.array(sizes), motion)
