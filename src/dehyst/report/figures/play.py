"""Figure 3: the play operators of the identified model over this log's own input (the paper's Figure 4)."""

from __future__ import annotations

from functools import partial

import numpy as np

from dehyst.arrays import Array
from dehyst.data.loops import turning_points
from dehyst.data.recording import Recording
from dehyst.identification.fit import Fit
from dehyst.models import PrandtlIshlinskii
from dehyst.report.figures.panel import (
    Axes,
    Figure,
    Panel,
    add_legend,
    draw_path,
    draw_series,
    label_axes,
    says,
    time_of,
)
from dehyst.report.text import number, with_unit
from dehyst.report.theme import FIFTH, MUTED, TEST, TRAIN
from dehyst.report.thin import Window

_COLOURS = (TRAIN, FIFTH, TEST)
_WIDTHS = (2.6, 1.8, 1.1)
# Plays are told apart in the picture when their thresholds differ by this share of half the input's range.
APART = 0.06
# Loops drawn over time: enough to see the memory, few enough to follow.
LOOPS_SHOWN = 3

FORMULA = "z[k] = max( x[k] − c − r,  min( x[k] − c + r,  z[k−1] ) )"


def play_figure(fit: Fit) -> Figure | None:
    """Return figure 3, or None for a model without memory."""
    core = fit.model.play_core
    if core is None:
        return None
    recording = fit.recordings[0]
    chosen = typical_thresholds(core, 0.5 * float(np.ptp(recording.input)))
    unit = recording.input_unit
    named = ", ".join(with_unit(float(r), unit) for r in chosen)
    caption = (
        f"The building block of the model: a play of half width r, driven by this log's input less its centre "
        f"c = {with_unit(core.center, unit)}. Inside the play nothing moves; that is the memory. Drawn for "
        f"r = {named}, out of {core.nonzero_weights} with weight; the model is their weighted sum."
    )
    x, z = _plays(fit, core, chosen)
    end = _first_loops(x)
    return Figure(
        "play",
        "The play operator",
        caption,
        (
            Panel(
                "Play over input",
                partial(_draw_over_input, recording, core, chosen, x, z),
                says(f"Play operators with r = {named} over the input: parallelograms of width 2 r."),
            ),
            Panel(
                "Play over time" + ("" if end == x.size else f", first {LOOPS_SHOWN} loops"),
                partial(_draw_over_time, recording, core, chosen, x, z, end),
                says("The input and the same play operators over time; each follows after a turn of 2 r."),
            ),
        ),
        FORMULA,
    )


def typical_thresholds(core: PrandtlIshlinskii, reach: float) -> Array:
    """Return two or three thresholds to draw: the play without width, a wide one and one between, where it differs.

    Parameters
    ----------
    core
        The plays; those that carry weight are chosen from.
    reach
        Half the range of the input, which decides what can be told apart. [input]

    Examples
    --------
    >>> typical_thresholds(PrandtlIshlinskii([0.0, 0.01, 0.3, 0.9, 1.9], [1.0, 1.0, 1.0, 1.0, 1.0]), 2.0).tolist()
    [0.0, 0.3, 0.9]
    >>> typical_thresholds(PrandtlIshlinskii([0.0, 0.01, 0.05, 0.2], [1.0, 1.0, 1.0, 1.0]), 2.0).tolist()
    [0.0, 0.2]
    """
    first = core.thresholds[:1]
    carrying = core.thresholds[(core.weights != 0.0) & (core.thresholds > first[0])]
    if carrying.size == 0:
        return first
    # The widest plays hardly move; a play of half the reach shows what a play is.
    wide = _nearest(carrying, 0.5 * reach)
    middle = _nearest(carrying, first[0] + (wide - first[0]) / 3.0)
    between = [middle] if min(middle - first[0], wide - middle) >= APART * reach else []
    return np.array([first[0], *between, wide])


def _nearest(values: Array, aim: float) -> float:
    return float(values[int(np.argmin(np.abs(values - aim)))])


def _plays(fit: Fit, core: PrandtlIshlinskii, thresholds: Array) -> tuple[Array, list[Array]]:
    """Input of the first piece (T,) and the play of each threshold (T,), memory as identified."""
    piece = fit.recordings[0].pieces[0]
    x = np.asarray(fit.recordings[0].input[piece])
    plays = []
    for r in thresholds:
        k = int(np.argmin(np.abs(core.thresholds - r)))
        state = None if core.state is None else core.state[k : k + 1]
        plays.append(PrandtlIshlinskii(np.array([r]), np.ones(1), 0.0, state, core.center).simulate(x))
    return x, plays


def _first_loops(x: Array) -> int:
    points = turning_points(x)
    return int(points[2 * LOOPS_SHOWN + 1]) if points.size > 2 * LOOPS_SHOWN + 2 else x.size


def _label(r: float, unit: str) -> str:
    return f"r = {number(r)} {unit}".rstrip()


def _draw_over_input(
    recording: Recording, core: PrandtlIshlinskii, thresholds: Array, x: Array, plays: list[Array], axes: Axes
) -> None:
    window = Window.around(*((x, z) for z in plays))
    unit = f" [{recording.input_unit}]" if recording.input_unit else ""
    label_axes(axes, window, recording.input_label, f"play z{unit}")
    for r, z, token, width in zip(thresholds, plays, _COLOURS, _WIDTHS, strict=False):
        draw_path(axes, x, z, window, token, label=_label(r, recording.input_unit), width=width, outline=True)
    add_legend(axes)


def _draw_over_time(
    recording: Recording,
    core: PrandtlIshlinskii,
    thresholds: Array,
    x: Array,
    plays: list[Array],
    end: int,
    axes: Axes,
) -> None:
    t, label = time_of(recording)
    t = t[:end]
    centred = x[:end] - core.center
    window = Window.around((t, centred), *((t, z[:end]) for z in plays))
    unit = f" [{recording.input_unit}]" if recording.input_unit else ""
    label_axes(axes, window, label, f"play z{unit}")
    if thresholds[0] > 0.0:  # the play of width zero is the centred input itself
        draw_series(axes, t, centred, MUTED, label="x − c", width=0.9)
    for r, z, token, width in zip(thresholds, plays, _COLOURS, _WIDTHS, strict=False):
        draw_series(axes, t, z[:end], token, label=_label(r, recording.input_unit), width=width)
    add_legend(axes)
