"""dehyst simulate and compensate: what is assumed of the actuator's past, and how that is said."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from dehyst.app.terminal import tell
from dehyst.app.unknown import closed_from, place
from dehyst.errors import ParameterError
from dehyst.io import Signal
from dehyst.models import HysteresisModel, SignalCard

if TYPE_CHECKING:
    from dehyst.app.play import PlayRequest

Array = npt.NDArray[np.float64]

UNKNOWN, REST, MODEL = STARTS = ("unknown", "rest", "model")
ABOUT = {
    REST: "at rest at the first sample, as if the actuator had never moved",
    MODEL: "as the log began that the model was identified from; wrong where the actuator comes from elsewhere",
}


def start_of(request: PlayRequest, default: str) -> str:
    """Return which start was asked for, `default` if none.

    Raises
    ------
    ParameterError
        If there is no such start, or it contradicts another option.
    """
    start = request.begin or (UNKNOWN if request.unknown_state else default)
    if start not in STARTS:
        raise ParameterError(f"--start {start!r:.40} is unknown; there are: {', '.join(STARTS)}.", start=start)
    for option, given in (("--unknown-state", request.unknown_state), ("--past", request.past is not None)):
        if given and start != UNKNOWN:
            cure = f"Leave out {option} or --start {start}" if request.begin else f"Add --start unknown to {option}"
            raise ParameterError(
                f"{option} is for an actuator of whose past nothing is known, and the start '{start}' assumes one: "
                f"{ABOUT[start]}. {cure}."
            )
    return start


def say(start: str, more: str = "") -> None:
    """Say on the error stream which start was taken."""
    tell(f"start: {start}, {more or ABOUT[start]}")


def begun(model: HysteresisModel, start: str, first: float) -> HysteresisModel:
    """Return the model in the state of a start that assumes a past, with the first sample that it is going to get."""
    return model.at_rest(first) if start == REST else model


def middle(
    model: HysteresisModel,
    x: Array,
    into: SignalCard,
    out: SignalCard,
    signal: Signal,
    past: tuple[float, float] | None,
) -> tuple[Array, str]:
    """Return the middle (T,) of what a model may answer after any past within a range, and what to say about it.

    Parameters
    ----------
    model, x
        The model, and its input (T,).
    into, out
        Signals of the model.
    signal
        Where x was read from.
    past
        What the input cannot have left before; None: its identified range.
    """
    if past is None and into.low is not None and into.high is not None and into.low < into.high:
        past = into.low, into.high
    low, high = model.interval(x, past=past)
    width = 0.5 * (high - low)
    where = f" within {past[0]:.4g} to {past[1]:.4g} {into.unit}".rstrip() if past else ""
    closed = closed_from(low, high)
    end = f"by {width[-1]:.3g} at the end" if closed is None else f"known from {place(signal, closed)} on"
    told = f"the middle of all pasts{where}: the first value may be off by {width[0]:.3g} {out.unit}".rstrip()
    return 0.5 * (low + high), f"{told}, {end}; --start rest or model assumes one past"
