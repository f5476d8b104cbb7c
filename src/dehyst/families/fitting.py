"""identify_family(): fits a family of the literature to recordings, scored on held-out data."""

from __future__ import annotations

import datetime as _datetime
import time as _time
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from dehyst.arrays import Array
from dehyst.data.recording import Recording, require_recordings, takes_recordings
from dehyst.data.repeats import counted_once
from dehyst.errors import IdentificationError
from dehyst.families.base import LoopModel
from dehyst.families.inversion import first_input
from dehyst.families.registry import family, title_of
from dehyst.families.training import Training, steps_of, training_of
from dehyst.findings import ENDINGS, Grade
from dehyst.identification.cautions import POOR_PERCENT
from dehyst.identification.certify import GOOD_PERCENT, fitted_speed
from dehyst.identification.data import DataSet, Piece, range_over
from dehyst.identification.fit import Fit, Score
from dehyst.identification.procedure import Prepared, prepared
from dehyst.identification.scores import Part, input_error, parts, score
from dehyst.identification.settings import check_recordings
from dehyst.identification.threads import single_blas
from dehyst.models import Model, ModelCard, SignalCard
from dehyst.version import __version__

LONG, WINDOWS, WINDOW = 200_000, 5, 20_000  # samples of a held-out span from which on inverses are asked in windows


@dataclass(frozen=True, repr=False)
class FamilyFit:
    """A family on a log: the identified model and how well it predicts, or why there is none.

    Attributes
    ----------
    family, title
        Its name, and the name written in tables.
    model
        What was identified, `model.inverse()` where `invertible`; None if nothing could be.
    recordings
        The data.
    predictions
        Output of the model for each recording, (T,); empty without a model. [output]
    demands
        Input that the inverse asks for at the measured output of each recording, (T,), where it was kept; NaN where a
        long log was not asked: of more than 200 000 held-out samples, five windows of 20 000 are. [input]
    train, test
        Scores on fitted and on held-out samples; test is None when nothing was held out.
    inverse_percent
        RMS of the demand less the applied input on held-out samples; percent of the input's range. None without an
        inverse.
    parameters
        Number of identified values; zero weights do not count.
    seconds
        What the fit took, processor time of its thread. [s]
    start
        Memory before the first sample that was assumed.
    seed
        Of everything random; None for convex fits, which have nothing random.
    reason
        Why the family cannot fit this log, or fits it badly, in one sentence; empty if nothing stands against it.
    no_inverse
        Why there is no inverse.
    tied
        Whether the held-out error is within noise of the smallest one: on another log the order may turn.
    same_as
        Family whose model answers the same to the last bit on this log, of a row further up; "" if there is none.

    Examples
    --------
    >>> import numpy as np
    >>> from dehyst import Recording
    >>> from dehyst.families.dahl import Dahl
    >>> x = np.sin(np.linspace(0.0, 40.0, 800)) * np.linspace(1.0, 0.3, 800)
    >>> fit = identify_family(Recording(input=x, output=Dahl.example().simulate(x)), "dahl")
    >>> fit.family, fit.invertible, fit.seed, bool(fit.test.rmse < 0.01)
    ('dahl', True, None, True)
    """

    family: str
    title: str
    model: Any = None
    recordings: tuple[Recording, ...] = ()
    predictions: tuple[Array, ...] = ()
    demands: tuple[Array, ...] | None = None
    train: Score | None = None
    test: Score | None = None
    inverse_percent: float | None = None
    parameters: int = 0
    seconds: float = 0.0
    start: str = ""
    seed: int | None = None
    reason: str = ""
    same_as: str = ""
    no_inverse: str = ""
    tied: bool = False

    def __repr__(self) -> str:
        """One line: family, error, inverse; arrays are attributes."""
        where = "held out" if self.test is not None else "fitted"
        inverse = "an inverse" if self.invertible else "no inverse"
        return f"<FamilyFit {self.family!r}: {self.error_percent:.3g} % of range {where}, {inverse}>"

    @property
    def invertible(self) -> bool:
        """Whether there is a model and it has an inverse."""
        return self.model is not None and not self.no_inverse

    @property
    def exportable(self) -> bool:
        """Whether there is a model and a target can run it or its inverse; else it runs in Python only."""
        return self.model is not None and not self.model.no_export

    @property
    def free_parameters(self) -> int:
        """Number of identified values."""
        return self.parameters

    @property
    def judged(self) -> Score | None:
        """The held-out score, or that of the fit if nothing was held out."""
        return self.test if self.test is not None else self.train

    @property
    def error_percent(self) -> float:
        """RMS error that counts, percent of the output's range; infinite without a model."""
        return self.judged.rmse_percent if self.judged is not None else float("inf")

    def as_dict(self) -> dict[str, Any]:
        """Return the row as printed by ``dehyst compare --json``."""
        return {
            "title": self.title,
            "test": None if self.test is None else self.test.as_dict(),
            "train": None if self.train is None else self.train.as_dict(),
            "seconds": self.seconds,
            "parameters": self.parameters,
            "invertible": self.invertible,
            "inverse_percent": self.inverse_percent,
            "no_inverse": self.no_inverse,
            "exportable": self.exportable,
            "start": self.start,
            "seed": self.seed,
            "tied": self.tied,
            "reason": self.reason,
        }


@dataclass(frozen=True)
class Judge:
    """The samples on which every family is scored."""

    records: tuple[Recording, ...]
    parts: tuple[Part, Part]
    output_range: float
    _known: dict[str, tuple[tuple[Array, ...], tuple[Array, ...] | None]] = field(default_factory=dict)

    @property
    def asked(self) -> Part:
        """The samples on which inverses are scored: the held-out ones, of a long span windows that lie evenly in it."""
        part = self.parts[1] or self.parts[0]
        return replace(part, spans=tuple(tuple(w for span in spans for w in _evenly(span)) for spans in part.spans))

    def answers(self, model: LoopModel, data: DataSet) -> tuple[tuple[Array, ...], tuple[Array, ...] | None]:
        """What a model predicts and what its inverse asks for; once for rows that come to the same sum."""
        values = [(name, value) for name, value in model.parameters().items() if name != "row"]
        key = repr((model.start, values))
        if key not in self._known:
            self._known[key] = self._answers(model, data)
        return self._known[key]

    def _answers(self, model: LoopModel, data: DataSet) -> tuple[tuple[Array, ...], tuple[Array, ...] | None]:
        outputs = [np.empty(len(record)) for record in self.records]
        demands = [np.full(len(record), np.nan) for record in self.records]
        for piece, x, y, dt in _pieces(self.records, data, model):
            windows = _windows(self.asked.spans[piece.recording], piece)
            memory, ends = model.before(float(x[0])), [0, *(window.start for window in windows), x.size]
            for number, span in enumerate(map(slice, ends, ends[1:])):
                if number and not model.no_inverse:  # a window begins with what the applied input has left behind
                    asked = windows[number - 1]
                    found = model.run_inverse(y[asked], None if dt is None else dt[asked], memory)[0]
                    demands[piece.recording][piece.start + asked.start : piece.start + asked.stop] = _outward(
                        model, found
                    )
                f, memory = model.run(x[span], None if dt is None else dt[span], memory)
                outputs[piece.recording][piece.start + span.start : piece.start + span.stop] = model.scaling.outward(f)
            if not windows and not model.no_inverse:
                demands[piece.recording][piece.start : piece.start + x.size] = _demand(model, y, dt)
        if not all(np.all(np.isfinite(y)) for y in outputs):
            raise IdentificationError(f"the fitted {model.family} model diverges on the held-out part.")
        return tuple(outputs), None if model.no_inverse else tuple(demands)

    def scored(self, family: str, model: Model, predictions: tuple[Array, ...], **more: Any) -> FamilyFit:
        """Return the fit of a model by what it predicts."""
        train, test = (score(self.records, predictions, part, self.output_range) for part in self.parts)
        return FamilyFit(
            family, title_of(family), model, self.records, predictions, train=train, test=test,
            no_inverse=model.no_inverse, **more,
        )  # fmt: skip

    def identified(self, fit: Fit, seconds: float) -> FamilyFit:
        """Return what was identified otherwise."""
        return self.scored(
            fit.family, fit.model, fit.predictions, inverse_percent=fit.certificate.inverse_miss_percent,
            parameters=fit.model.free_parameters, seconds=seconds, start=fit.certificate.initial_state,
        )  # fmt: skip

    def curve_of(self, fit: Fit) -> FamilyFit:
        """Return the curve without memory that every fit carries; it takes no time of its own."""
        return self.scored(
            "static", fit.static, tuple(fit.static.simulate(record.input) for record in self.records),
            inverse_percent=fit.curve_input.rms_percent, parameters=fit.static.curve.v.size,
        )  # fmt: skip


@takes_recordings
def identify_family(
    recordings: Recording | Sequence[Recording], name: str, *, train_fraction: float | None = None, seed: int = 0
) -> FamilyFit:
    """Identify a model of a family of the literature.

    Parameters
    ----------
    recordings
        One recording or a list; all are fitted together.
    name
        Of the family: `dehyst.families.names()`.
    train_fraction
        Share of each recording that is fitted; the rest is the test.
    seed
        Of the starts of a search, for families whose fit is not convex.

    Returns
    -------
    fit : FamilyFit
        Model and scores.

    Raises
    ------
    ParameterError
        If there is no such family, or it needs time stamps that are missing.
    ExcitationError
        If input or output does not move.
    IdentificationError
        If the family cannot fit such data; the message says why.

    Examples
    --------
    >>> import numpy as np
    >>> from dehyst import Recording
    >>> from dehyst.families import example, identify_family
    >>> x = np.sin(np.linspace(0.0, 40.0, 800)) * np.linspace(1.0, 0.3, 800)
    >>> fit = identify_family(Recording(input=x, output=example("dahl").simulate(x)), "dahl")
    >>> bool(fit.test.rmse_percent < 0.5)
    True
    """
    log = prepared(check_recordings(tuple(map(counted_once, require_recordings(recordings)))), train_fraction)
    with single_blas():
        training, records, data = training_of_log(log, seed), log.records, log.data
        return fit_one(name, Judge(records, parts(records, data, "zero"), data.output_range), data, training)


def training_of_log(log: Prepared, seed: int = 0) -> Training:
    """Fitted part of recordings that were prepared."""
    return training_of(log.records, log.data, log.seen.loop.name, seed)


def fit_one(name: str, judge: Judge, data: DataSet, training: Training) -> FamilyFit:
    """Fit a family to the training of prepared recordings."""
    found, records = family(name), judge.records
    begun = _time.thread_time()
    model = found.fit(training)
    seconds = _time.thread_time() - begun
    outputs, demands = judge.answers(model, data)
    error = None if demands is None else input_error(records, demands, judge.asked)
    fit = judge.scored(
        name, model, outputs, demands=demands, inverse_percent=None if error is None else error.rms_percent,
        parameters=model.free_parameters, seconds=seconds, start=model.start,
        seed=None if found.convex else training.seed,
    )  # fmt: skip
    return replace(fit, model=model.with_card(_card(fit)))


def predicted(model: LoopModel, records: tuple[Recording, ...], data: DataSet) -> tuple[Array, ...]:
    """Output of a model for each recording; every piece starts from its own memory. [output]"""
    outputs = [np.empty(len(record)) for record in records]
    for piece, x, _, dt in _pieces(records, data, model):
        f = model.run(x, dt, model.before(float(x[0])))[0]
        outputs[piece.recording][piece.start : piece.start + x.size] = model.scaling.outward(f)
    return tuple(outputs)


def demanded(model: LoopModel, records: tuple[Recording, ...], data: DataSet) -> tuple[Array, ...]:
    """Input that the inverse asks for at the measured output of each recording, known as far ahead as it takes."""
    inputs = [np.empty(len(record)) for record in records]
    for piece, _, y, dt in _pieces(records, data, model):
        inputs[piece.recording][piece.start : piece.start + y.size] = _demand(model, y, dt)
    return tuple(inputs)


def _demand(model: LoopModel, y: Array, dt: Array | None) -> Array:
    """Input that the inverse asks for along a piece, from the memory that its start says. [input]"""
    return _outward(model, model.run_inverse(y, dt, model.before(first_input(model, float(y[0]))))[0])


def _outward(model: LoopModel, x: Array) -> Array:
    return model.ahead(model.scaling.center + model.scaling.half_range * x)


def _evenly(span: slice) -> tuple[slice, ...]:
    """A span, or of a long one windows that lie evenly in it."""
    if span.stop - span.start <= LONG:
        return (span,)
    starts = np.linspace(span.start, span.stop - WINDOW, WINDOWS).astype(int).tolist()
    return tuple(slice(start, start + WINDOW) for start in starts)


def _windows(spans: Sequence[slice], piece: Piece) -> list[slice]:
    """The windows that lie in a piece, counted from its first sample; none where its span is asked as a whole."""
    inside = [span for span in spans if piece.start <= span.start and span.stop <= piece.start + piece.x.size]
    return [slice(w.start - piece.start, w.stop - piece.start) for w in inside] if len(inside) > 1 else []


def _pieces(
    records: tuple[Recording, ...], data: DataSet, model: LoopModel
) -> list[tuple[Piece, Array, Array, Array | None]]:
    listed = []
    for piece in data.pieces:
        x, y = (np.ascontiguousarray(np.asarray(v[0 : v.size], dtype=np.float64)) for v in (piece.x, piece.y))
        dt = steps_of(records[piece.recording], piece.start, x.size) if model.rate_dependent else None
        listed.append((piece, x, y, dt))
    return listed


def _card(fit: FamilyFit) -> ModelCard:
    records, first = fit.recordings, fit.recordings[0]
    assert fit.train is not None
    return ModelCard(
        SignalCard(first.input_name, first.input_unit, *range_over([record.input for record in records])),
        SignalCard(first.output_name, first.output_unit, *range_over([record.output for record in records])),
        {
            "logs": [dict(record.provenance) | {"name": record.name, "samples": record.samples} for record in records],
            "date": _datetime.datetime.now(_datetime.UTC).isoformat(timespec="seconds"),
            "dehyst": __version__,
            "identified_family": fit.model.family,
            "initial_state": fit.start,
            "train": fit.train.as_dict(),
            "test": None if fit.test is None else fit.test.as_dict(),
            "verdict": _verdict(fit),
            **fitted_speed(records, [np.ones(len(record), dtype=bool) for record in records]),
        },
    )


def grade_of(fit: FamilyFit) -> Grade:
    """Good where what was held out is followed, and the inverse gives the input back, to 3 % each.

    Without an inverse, or where both errors are large, a model is no compensator.
    """
    inverse = float("inf") if fit.inverse_percent is None else fit.inverse_percent
    if not fit.invertible or (fit.error_percent > POOR_PERCENT and inverse > GOOD_PERCENT):
        return Grade.BAD
    within = fit.error_percent <= GOOD_PERCENT and inverse <= GOOD_PERCENT
    return Grade.GOOD if within and fit.test is not None else Grade.CARE


def _verdict(fit: FamilyFit) -> str:
    """The judgement in one sentence, with the words of all verdicts at its end."""
    grade = grade_of(fit)
    words = next(ending for rank, ending in ENDINGS if rank is grade) + (" with it" if grade is Grade.BAD else "")
    where = "on held-out loops" if fit.test is not None else "on the fitted samples (none held out)"
    gives = "" if fit.inverse_percent is None else f"; its inverse misses the input by {fit.inverse_percent:.2f} %"
    return f"{fit.family}, {fit.parameters} parameters: {fit.error_percent:.2f} % of range rms {where}{gives}: {words}."
