"""identify_family(): from recordings to a model of a family of the literature, scored on what was held out."""

from __future__ import annotations

import datetime as _datetime
import time as _time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from dehyst import __version__
from dehyst.errors import IdentificationError
from dehyst.families.base import LoopModel
from dehyst.families.inversion import first_input
from dehyst.families.registry import family
from dehyst.families.training import Training, steps_of, training_of
from dehyst.grades import ENDINGS, Grade
from dehyst.identification import facts
from dehyst.identification.cautions import POOR_PERCENT
from dehyst.identification.data import DataSet, Piece, prepare, range_over
from dehyst.identification.fit import Score
from dehyst.identification.judge import GOOD_PERCENT
from dehyst.identification.scores import Part, input_error, parts, score
from dehyst.identification.settings import check_recordings
from dehyst.identification.split import split_recordings
from dehyst.identification.threads import single_blas
from dehyst.models import ModelCard, SignalCard
from dehyst.recording import Recording, takes_recordings

Array = npt.NDArray[np.float64]


@dataclass(frozen=True, repr=False)
class FamilyFit:
    """An identified model of a family, and how well it predicts.

    Attributes
    ----------
    family
        Name of the family.
    model
        The model; `model.inverse()` where `invertible`.
    recordings
        The data.
    predictions
        Output of the model for each recording, (T,). [output]
    demands
        Input that the inverse asks for at the measured output of each recording, (T,); None without an inverse.
        [input]
    train, test
        Scores on fitted and on held-out samples; test is None when nothing was held out.
    inverse_percent
        RMS of the demand less the applied input on held-out samples; percent of the input's range. None without an
        inverse.
    seconds
        What the fit took, processor time of its thread. [s]
    seed
        Of everything random; None for convex fits, which have nothing random.

    Examples
    --------
    >>> import numpy as np
    >>> from dehyst import Recording
    >>> from dehyst.families.dahl import Dahl
    >>> x = np.sin(np.linspace(0.0, 40.0, 800)) * np.linspace(1.0, 0.3, 800)
    >>> fit = Dahl.identify(Recording(input=x, output=Dahl.example().simulate(x)))
    >>> fit.family, fit.invertible, fit.seed, bool(fit.test.rmse < 0.01)
    ('dahl', True, None, True)
    """

    family: str
    model: LoopModel
    recordings: tuple[Recording, ...]
    predictions: tuple[Array, ...]
    demands: tuple[Array, ...] | None
    train: Score
    test: Score | None
    inverse_percent: float | None
    seconds: float
    seed: int | None

    def __repr__(self) -> str:
        """One line: family, error, inverse; arrays are attributes."""
        error, where = (self.test or self.train).rmse_percent, "held out" if self.test is not None else "fitted"
        inverse = "an inverse" if self.invertible else "no inverse"
        return f"<FamilyFit {self.family!r}: {error:.3g} % of range {where}, {inverse}>"

    @property
    def invertible(self) -> bool:
        """Whether the model has an inverse."""
        return self.demands is not None

    @property
    def free_parameters(self) -> int:
        """Number of identified values."""
        return self.model.free_parameters

    def as_dict(self) -> dict[str, Any]:
        """Return the result as plain values."""
        return {
            "family": self.family,
            "test": None if self.test is None else self.test.as_dict(),
            "train": self.train.as_dict(),
            "seconds": self.seconds,
            "parameters": self.free_parameters,
            "invertible": self.invertible,
            "inverse_percent": self.inverse_percent,
            "start": self.model.start,
            "seed": self.seed,
        }


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
    records = check_recordings(recordings)
    with single_blas():
        data = prepare(records, split_recordings(records, train_fraction))
        training = training_of(records, data, orientation_of(data), seed)
        return fit_one(name, records, data, parts(records, data, "zero"), training)


def orientation_of(data: DataSet) -> str:
    """Which way round the loops of the fitted part run."""
    return facts.orientation(facts.branches(data)).name


def fit_one(
    name: str, records: tuple[Recording, ...], data: DataSet, part: tuple[Part, Part], training: Training
) -> FamilyFit:
    """Fit a family to the training of prepared recordings."""
    found = family(name)
    begun = _time.thread_time()
    model = found.fit(training)
    seconds = _time.thread_time() - begun
    outputs = predicted(model, records, data)
    if not all(np.all(np.isfinite(y)) for y in outputs):
        raise IdentificationError(f"the fitted {name} model diverges on the held-out part.", family=name)
    demands = None if model.no_inverse else demanded(model, records, data)
    train = score(records, outputs, part[0], data.output_range)
    assert train is not None
    test = score(records, outputs, part[1], data.output_range)
    error = None if demands is None else input_error(records, demands, part[1] if part[1] else part[0])
    return FamilyFit(
        family=name,
        model=model.with_card(_card(model, records, train, test)),
        recordings=records,
        predictions=outputs,
        demands=demands,
        train=train,
        test=test,
        inverse_percent=None if error is None else error.rms_percent,
        seconds=seconds,
        seed=None if found.convex else training.seed,
    )


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
        x = model.run_inverse(y, dt, model.before(first_input(model, float(y[0]))))[0]
        scaled = model.ahead(model.scaling.center + model.scaling.half_range * x)
        inputs[piece.recording][piece.start : piece.start + y.size] = scaled
    return tuple(inputs)


def _pieces(
    records: tuple[Recording, ...], data: DataSet, model: LoopModel
) -> list[tuple[Piece, Array, Array, Array | None]]:
    listed = []
    for piece in data.pieces:
        x, y = (np.ascontiguousarray(np.asarray(v[0 : v.size], dtype=np.float64)) for v in (piece.x, piece.y))
        dt = steps_of(records[piece.recording], piece.start, x.size) if model.rate_dependent else None
        listed.append((piece, x, y, dt))
    return listed


def _card(model: LoopModel, records: tuple[Recording, ...], train: Score, test: Score | None) -> ModelCard:
    first = records[0]
    return ModelCard(
        SignalCard(first.input_name, first.input_unit, *range_over([record.input for record in records])),
        SignalCard(first.output_name, first.output_unit, *range_over([record.output for record in records])),
        {
            "logs": [dict(record.provenance) | {"name": record.name, "samples": record.samples} for record in records],
            "date": _datetime.datetime.now(_datetime.UTC).isoformat(timespec="seconds"),
            "dehyst": __version__,
            "identified_family": model.family,
            "initial_state": model.start,
            "train": train.as_dict(),
            "test": None if test is None else test.as_dict(),
            "verdict": verdict_of(model, train, test),
        },
    )


def verdict_of(model: LoopModel, train: Score, test: Score | None) -> str:
    """The judgement in one sentence, with the words of all verdicts at its end."""
    error = (test or train).rmse_percent
    grade = _grade(error, test is not None, not model.no_inverse)
    words = next(ending for rank, ending in ENDINGS if rank is grade) + (" with it" if grade is Grade.BAD else "")
    where = "on held-out loops" if test is not None else "on the fitted samples (none held out)"
    return f"{model.family}, {model.free_parameters} parameters: {error:.2f} % of range rms {where}: {words}."


def _grade(error: float, held_out: bool, invertible: bool) -> Grade:
    if not invertible or error > POOR_PERCENT:
        return Grade.BAD
    return Grade.GOOD if error <= GOOD_PERCENT and held_out else Grade.CARE
