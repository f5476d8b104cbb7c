"""dehyst simulate and compensate: what is assumed of the actuator's past, and how that is said."""

from __future__ import annotations

from typing import TYPE_CHECKING

from dehyst.app.terminal import tell
from dehyst.app.unknown import closed_from, place
from dehyst.errors import ParameterError
from dehyst.io import Signal
from dehyst.models import Band, ModelCard

if TYPE_CHECKING:
    from dehyst.app.requests import SimulateRequest

UNKNOWN, REST, MODEL = STARTS = ("unknown", "rest", "model")
ABOUT = {
    REST: "at rest at the first sample, as if the actuator had never moved",
    MODEL: "as the log began that the model was identified from; wrong where the actuator comes from elsewhere",
}


def start_of(request: SimulateRequest, default: str) -> str:
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
    """Say on the error stream which start was taken; nothing where the band itself was asked for."""
    if start:
        tell(f"start: {start}, {more or ABOUT[start]}")


def middle_of(band: Band, past: tuple[float, float] | None, card: ModelCard, signal: Signal) -> str:
    """Return what to say about the middle of what a model may answer after any past within a range.

    Parameters
    ----------
    band
        Of the answer.
    past
        What the input cannot have left before; None: it may have been anywhere.
    card
        Of the model.
    signal
        Where its input was read from.
    """
    width = band.half_width
    where = f" within {past[0]:.4g} to {past[1]:.4g} {card.input.unit}".rstrip() if past else ""
    closed = closed_from(band.low, band.high)
    end = f"by {width[-1]:.3g} at the end" if closed is None else f"known from {place(signal, closed)} on"
    told = f"the middle of all pasts{where}: the first value may be off by {width[0]:.3g} {card.output.unit}".rstrip()
    return f"{told}, {end}; --start rest or model assumes one past"
