"""Figure 1: the loop as measured, what was fitted and what was held out, and the model over it.

This figure and that of the residual show a fit the way round it was made: a direct inverse from output to input.
"""

from __future__ import annotations

from functools import partial
from typing import NamedTuple, TypeAlias

import numpy as np

from dehyst.arrays import Array, Mask
from dehyst.identification import DirectFit, Fit
from dehyst.loops import turning_points
from dehyst.report.figures.arrows import draw_arrows
from dehyst.report.figures.panel import (
    Axes,
    Figure,
    Panel,
    add_legend,
    break_times,
    draw_path,
    draw_series,
    label_axes,
    path_of,
    says,
    time_of,
)
from dehyst.report.text import count, short
from dehyst.report.theme import BAD, MODEL, OTHER, TEST, TRAIN, Token
from dehyst.report.thin import Window

MAXIMUM_PANELS = 6
# A time series with more loops than this is a solid band; then only its end is drawn.
LOOPS_OVER_TIME, LOOPS_SHOWN = 14, 6


AnyFit: TypeAlias = Fit | DirectFit


class Shown(NamedTuple):
    """What a fit drives and what answers, of one recording."""

    x: Array
    y: Array
    drive: str
    answer: str
    x_label: str
    y_label: str
    y_unit: str


def shown(fit: AnyFit, i: int) -> Shown:
    """Return the signals of a recording the way round the model was fitted."""
    rec = fit.recordings[i]
    if fit.backward:
        return Shown(rec.output, rec.input, "output", "input", rec.output_label, rec.input_label, rec.input_unit)
    return Shown(rec.input, rec.output, "input", "output", rec.input_label, rec.output_label, rec.output_unit)


def loop_figure(fit: AnyFit) -> Figure:
    """Return figure 1."""
    drawn = min(len(fit.recordings), MAXIMUM_PANELS)
    first, backward = shown(fit, 0), fit.backward
    panels = [
        Panel(
            f"{first.answer.capitalize()} over {first.drive}"
            if len(fit.recordings) == 1
            else short(fit.recordings[i].name, 60),
            partial(_draw_loop, fit, i),
            says(
                f"Loop of {shown(fit, i).y_label} over {shown(fit, i).x_label},",
                f"{len(fit.recordings[i])} samples, {fit.facts.orientation}, with the model over it.",
            ),
        )
        for i in range(drawn)
    ]
    caption = "Arrows show the direction of time. The thin dark line is the model."
    if backward:
        caption = (
            "The loop seen from the compensator: output across, the input that it took up. The thin dark line is the "
            "input that the model asks for at the measured output."
        )
    if np.any([mask.any() for mask in fit.test_masks]):
        caption += " It was identified from the blue part alone; the orange part was held out."
    if len(fit.recordings) == 1:
        begin, loops = _stretch(first.x)
        panels.append(
            Panel(
                "The same over time" if begin == 0 else f"The same over time, last {LOOPS_SHOWN} loops",
                partial(_draw_time, fit, begin),
                says(f"{first.y_label} over time, measured and model, {count(loops, 'loop')}."),
            )
        )
    elif len(fit.recordings) > drawn:
        caption += f" The first {drawn} of {len(fit.recordings)} logs are drawn; all of them are in the scores."
    if any(recording.breaks for recording in fit.recordings):
        caption += " Lines are interrupted where samples are missing."
    return Figure("loop", "The loop, from output to input" if backward else "The loop", caption, tuple(panels))


def parts(fit: AnyFit, i: int) -> tuple[tuple[Mask, str, Token], ...]:
    """Return mask, name and colour of the parts of recording i that have samples."""
    train, test = fit.train_masks[i], fit.test_masks[i]
    rest = ~(train | test)
    named = ((rest, "not scored", OTHER), (train, "fitted", TRAIN), (test, "held out", TEST))
    return tuple(part for part in named if part[0].any())


def draw_parts(fit: AnyFit, i: int, pair: tuple[Array, Array], window: Window, axes: Axes) -> None:
    """Draw the measured loop of recording i, each part in its colour."""
    path = path_of(fit.recordings[i], pair[0])
    for mask, name, token in parts(fit, i):
        # The later part lies over the earlier one: thinner, so that both are seen where they agree.
        width = 2.0 if token is TEST else 3.0
        measured = path_of(fit.recordings[i], pair[1], mask)
        draw_path(axes, path, measured, window, token, label=name, width=width, alpha=0.6)


def _draw_loop(fit: AnyFit, i: int, axes: Axes) -> None:
    rec, (x, y, _, _, x_label, y_label, _) = fit.recordings[i], shown(fit, i)
    window = Window.around((x, y), (x, fit.predictions[i]))
    label_axes(axes, window, x_label, y_label)
    draw_parts(fit, i, (x, y), window, axes)
    said = path_of(rec, fit.predictions[i])
    draw_path(axes, path_of(rec, x), said, window, MODEL, label="model", width=0.9, outline=True, order=3)
    longest = max(rec.pieces, key=lambda piece: piece.stop - piece.start)
    draw_arrows(axes, x, y, longest, window, MODEL)
    add_legend(axes)


def _stretch(x: Array) -> tuple[int, int]:
    """First sample to draw over time, and the number of loops drawn."""
    points = turning_points(x)
    loops = max(0, points.size - 2) // 2
    if loops <= LOOPS_OVER_TIME:
        return 0, loops
    return int(points[-2 * LOOPS_SHOWN - 2]), LOOPS_SHOWN


def _draw_time(fit: AnyFit, first: int, axes: Axes) -> None:
    rec, told = fit.recordings[0], shown(fit, 0)
    t, label = time_of(rec)
    inside = np.arange(len(rec)) >= first
    window = Window.around((t[inside], told.y[inside]), (t[inside], fit.predictions[0][inside]))
    label_axes(axes, window, label, told.y_label)
    for mask, name, token in parts(fit, 0):
        if (mask & inside).any():
            measured = path_of(rec, told.y, mask & inside)
            draw_series(axes, path_of(rec, t), measured, token, label=name, width=2.4)
    said = path_of(rec, fit.predictions[0], inside)
    draw_series(axes, path_of(rec, t), said, MODEL, label="model", width=0.8, order=3)
    for moment in break_times(rec, t)[:100]:
        axes.axvline(moment, color=BAD.light, lw=1.4, ls=(0, (1, 1.5)), zorder=2.5)
    add_legend(axes)
