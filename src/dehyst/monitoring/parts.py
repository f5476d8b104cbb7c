"""A model taken apart: what it predicts, and how much of it is hysteresis, creep and curve."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
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

Parted: TypeAlias = Model  # what can be taken apart: the core runs it
Given: TypeAlias = Mapping[str, Array]

DIRECT, ELEMENTS = "direct", "elements"  # cores of the models that say what part of their answer is creep
CREEPING, VISCOUS = GROUPS.index("creep"), GROUPS.index("viscous")


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
    loop = np.sum(np.delete(ran.parts, (CREEPING, VISCOUS), axis=1), axis=1)
    drive = None if model.card.output.low is None else _followed(model, record, time, given)
    return Prediction(ran.u, loop, drive, ran.parts[:, CREEPING].copy(), ran.parts[:, VISCOUS].copy())


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
