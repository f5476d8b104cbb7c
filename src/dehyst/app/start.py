"""dehyst simulate and compensate: what is assumed of the actuator's past, and the band of all pasts if nothing is."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from dehyst.app.targets import BAND, refuse_existing
from dehyst.app.terminal import tell
from dehyst.arrays import Array
from dehyst.errors import ParameterError
from dehyst.findings import Finding
from dehyst.io import Signal
from dehyst.models import Band, ModelCard, SignalCard

if TYPE_CHECKING:
    from dehyst.app.requests import SimulateRequest

UNKNOWN, REST, MODEL = STARTS = ("unknown", "rest", "model")
ABOUT = {
    REST: "at rest at the first sample, as if the actuator had never moved",
    MODEL: "as the log began that the model was identified from; wrong where the actuator comes from elsewhere",
}


def start_of(request: SimulateRequest, default: str) -> str:
    """Return which start was asked for, `default` if none."""
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
    """Return what to say about the middle of what a model may answer after any past within a range."""
    width = band.half_width
    where = f" within {past[0]:.4g} to {past[1]:.4g} {card.input.unit}".rstrip() if past else ""
    closed = closed_from(band.low, band.high)
    end = f"by {width[-1]:.3g} at the end" if closed is None else f"known from {place(signal, closed)} on"
    told = f"the middle of all pasts{where}: the first value may be off by {width[0]:.3g} {card.output.unit}".rstrip()
    return f"{told}, {end}; --start rest or model assumes one past"


# A band narrower than this share of its largest width has closed.
CLOSED = 1e-6


def column(card: SignalCard, prefix: str = "") -> str:
    """Name of a column: that of the signal with its unit."""
    name = f"{prefix}_{card.name}" if prefix else card.name
    return f"{name} [{card.unit}]" if card.unit else name


def refuse_without_unknown_state(unknown: bool, figure: Path | None, overwrite: bool) -> None:
    """Refuse a picture of the band when none is asked for, and one that cannot be written."""
    if figure is not None:
        from dehyst.report.svg import require_picture_name

        refuse_existing(require_picture_name(figure), overwrite, own=BAND)
    if figure is not None and not unknown:
        raise ParameterError(
            "--figure belongs to --unknown-state, which gives the band that the output lies in; add that, or leave it "
            "out."
        )


def band_columns(
    band: Band, card: SignalCard, prefix: str, signal: Signal, figure: Path | None
) -> tuple[dict[str, Array], list[Finding]]:
    """Return columns middle, low, high and certainty, and what to say about them; draw them if a picture is wanted.

    Nothing is known at the first sample, and nothing new is unknown at a gap: the memory is carried on across it.
    """
    columns = {
        column(card, prefix): 0.5 * (band.low + band.high),
        column(card, f"{prefix}_low"): band.low,
        column(card, f"{prefix}_high"): band.high,
        "certainty": band.certainty,
    }
    if figure is not None:
        from dehyst.report.pictures import write_band

        time, across = _abscissa(signal)
        write_band(figure, time, band.low, band.high, band.certainty, across, column(card, prefix))
    return columns, [_finding(band.low, band.high, card.unit, column(card, prefix), signal)]


def closed_from(low: Array, high: Array) -> int | None:
    """Return the first sample from which on a band is a point; None if it stays open."""
    width = high - low
    closed = np.flatnonzero(width <= CLOSED * max(float(width[0]), 1e-300))
    return int(closed[0]) if closed.size else None


def place(signal: Signal, index: int) -> str:
    """Where a sample lies, in words."""
    return f"sample {index + 1}" if signal.time is None else f"{signal.time[index]:.6g} s"


def _abscissa(signal: Signal) -> tuple[Array, str]:
    if signal.time is None:
        return np.arange(signal.values.size, dtype=np.float64), "sample number"
    return signal.time, "time [s]"


def _finding(low: Array, high: Array, unit: str, name: str, signal: Signal) -> Finding:
    width = high - low
    unit = f" {unit}" if unit else ""
    closed = closed_from(low, high)
    if closed is not None:
        end = f"it is known from {place(signal, closed)} on"
    else:
        end = f"at the end it is still {0.5 * float(width[-1]):.3g}{unit}: begin with a stroke over the whole range"
    return Finding(
        "memory-unknown",
        f"nothing was assumed of the past: the first value is known to {0.5 * float(width[0]):.3g}{unit} to either "
        f"side, and {end}. The column {name} is the middle of the band.",
    )
