"""One row of a comparison: a family, what came of it on the log, or why nothing did."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from dehyst.families.base import LoopModel
from dehyst.identification.fit import Score
from dehyst.models import DirectInverse, HysteresisModel

Array = npt.NDArray[np.float64]
AnyModel: TypeAlias = LoopModel | HysteresisModel | DirectInverse


@dataclass(frozen=True)
class Entry:
    """A family on a log.

    Attributes
    ----------
    family
        Its name.
    title
        As written in tables.
    model
        What was identified; None if nothing could be.
    predictions
        Output of the model for each recording, (T,); empty without a model. [output]
    train, test
        Scores on fitted and on held-out samples.
    inverse_percent
        RMS of the input that the inverse asks for at the measured output, less the applied one, on held-out samples;
        percent of the input's range. None without an inverse.
    parameters
        Number of identified values; zero weights do not count.
    invertible
        Whether the model has an inverse.
    seconds
        Processor time of the fit. [s]
    start
        Memory before the first sample that was assumed.
    seed
        Of the search; None for convex fits.
    reason
        Why the family cannot fit this log, or fits it badly, in one sentence; empty if nothing stands against it.
    no_inverse
        Why there is no inverse.
    tied
        Whether the held-out error is within noise of the smallest one: on another log the order may turn.
    """

    family: str
    title: str
    model: AnyModel | None = None
    predictions: tuple[Array, ...] = ()
    train: Score | None = None
    test: Score | None = None
    inverse_percent: float | None = None
    parameters: int = 0
    invertible: bool = False
    seconds: float = 0.0
    start: str = ""
    seed: int | None = None
    reason: str = ""
    no_inverse: str = ""
    tied: bool = False

    @property
    def judged(self) -> Score | None:
        """The held-out score, or that of the fit if nothing was held out."""
        return self.test if self.test is not None else self.train

    @property
    def error_percent(self) -> float:
        """RMS error that counts, percent of the output's range; infinite without a model."""
        return self.judged.rmse_percent if self.judged is not None else float("inf")

    def as_dict(self) -> dict[str, Any]:
        """Return the row as printed by ``--json``."""
        return {
            "title": self.title,
            "test": None if self.test is None else self.test.as_dict(),
            "train": None if self.train is None else self.train.as_dict(),
            "seconds": self.seconds,
            "parameters": self.parameters,
            "invertible": self.invertible,
            "inverse_percent": self.inverse_percent,
            "no_inverse": self.no_inverse,
            "start": self.start,
            "seed": self.seed,
            "tied": self.tied,
            "reason": self.reason,
        }
