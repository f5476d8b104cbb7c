"""How a model begins: one default for all that runs one, and the pasts of an actuator that can be named instead."""

from __future__ import annotations

from typing import TypeVar

from dehyst.errors import ParameterError
from dehyst.models._model import Model

M = TypeVar("M", bound=Model)
UNKNOWN, REST, RISING, FALLING, MODEL = STARTS = ("unknown", "rest", "rising", "falling", "model")
# simulate, compensate, evaluate, steppers, blocks and exported code begin alike, so that one can stand for another.
DEFAULT: str = MODEL
# Where the output was logged, too, its first part tells the past.
KNOWN = "known"
# Pasts of which an actuator has one and no other: what a log of unknown beginning is tried with.
PASTS = (MODEL, REST, RISING, FALLING)
ABOUT = {
    UNKNOWN: "after any past: the middle of what the model may answer",
    REST: "at rest at the first sample, as if the actuator had never moved",
    RISING: "after strokes over the whole range, the last one rising to the first sample",
    FALLING: "after strokes over the whole range, the last one falling to the first sample",
    MODEL: "the past is taken to be that of the identified log at its first sample; wrong where the actuator comes "
    "from elsewhere",
    KNOWN: "the past that agrees best with the first tenth of the log, which then counts in no error",
}


def check_start(start: str, more: tuple[str, ...] = ()) -> str:
    """Return a start, one of `STARTS` or of `more`; or refuse one that there is not."""
    starts = (*STARTS, *more)
    if start in starts:
        return start
    raise ParameterError(
        f"--start {start!r:.40} is unknown; there are: {', '.join(starts)}.", start=start
    )


def begun(model: M, start: str, first: float) -> M:
    """Return a model, or an inverse, that has one past on arrival at its first input.

    Parameters
    ----------
    start
        One of `PASTS`. What rises or falls is the signal that the model is given.
    first
        The first input. [input]

    Raises
    ------
    ParameterError
        If the model cannot begin so.

    Examples
    --------
    >>> from dehyst.models import ModelCard, PrandtlIshlinskii, SignalCard
    >>> card = ModelCard(SignalCard("u", low=-4.0, high=4.0), SignalCard("y"))
    >>> model = PrandtlIshlinskii([0.0, 0.5], [1.0, 1.0], card=card)
    >>> [(start, begun(model, start, 1.0).simulate([1.0]).tolist()) for start in PASTS]
    [('model', [1.5]), ('rest', [2.0]), ('rising', [1.5]), ('falling', [2.5])]
    """
    if start == REST:
        return model.at_rest(first)
    # A saved model carries the past of its log.
    if start == MODEL:
        return model
    return model.after_strokes(first, start == RISING)
