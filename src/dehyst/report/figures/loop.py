"""Figure 1: the loop as measured, what was fitted and what was held out, and the model over it; arrows of its sense."""

from __future__ import annotations

from functools import partial

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array, Mask
from dehyst.data.loops import turning_points
from dehyst.identification import Fit
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


def loop_figure(fit: Fit) -> Figure:
    """Return figure 1."""
    drawn = min(len(fit.recordings), MAXIMUM_PANELS)
    first = fit.recordings[0]
    panels = [
        Panel(
            "Output over input" if len(fit.recordings) == 1 else short(fit.recordings[i].name, 60),
            partial(_draw_loop, fit, i),
            says(
                f"Loop of {fit.recordings[i].output_label} over {fit.recordings[i].input_label},",
                f"{len(fit.recordings[i])} samples, {fit.facts.orientation}, with the model over it.",
            ),
        )
        for i in range(drawn)
    ]
    caption = "Arrows show the direction of time. The thin dark line is the model."
    if np.any([mask.any() for mask in fit.test_masks]):
        caption += " It was identified from the blue part alone; the orange part was held out."
    if len(fit.recordings) == 1:
        begin, loops = _stretch(first.input)
        panels.append(
            Panel(
                "The same over time" if begin == 0 else f"The same over time, last {LOOPS_SHOWN} loops",
                partial(_draw_time, fit, begin),
                says(f"{first.output_label} over time, measured and model, {count(loops, 'loop')}."),
            )
        )
    elif len(fit.recordings) > drawn:
        caption += f" The first {drawn} of {len(fit.recordings)} logs are drawn; all of them are in the scores."
    if any(recording.breaks for recording in fit.recordings):
        caption += " Lines are interrupted where samples are missing."
    return Figure("loop", "The loop", caption, tuple(panels))


def parts(fit: Fit, i: int) -> tuple[tuple[Mask, str, Token], ...]:
    """Return mask, name and colour of the parts of recording i that have samples."""
    train, test = fit.train_masks[i], fit.test_masks[i]
    rest = ~(train | test)
    named = ((rest, "not scored", OTHER), (train, "fitted", TRAIN), (test, "held out", TEST))
    return tuple(part for part in named if part[0].any())


def draw_parts(fit: Fit, i: int, pair: tuple[Array, Array], window: Window, axes: Axes) -> None:
    """Draw the measured loop of recording i, each part in its colour."""
    path = path_of(fit.recordings[i], pair[0])
    for mask, name, token in parts(fit, i):
        # The later part lies over the earlier one: thinner, so that both are seen where they agree.
        width = 2.0 if token is TEST else 3.0
        measured = path_of(fit.recordings[i], pair[1], mask)
        draw_path(axes, path, measured, window, token, label=name, width=width, alpha=0.6)


def _draw_loop(fit: Fit, i: int, axes: Axes) -> None:
    rec = fit.recordings[i]
    x, y = rec.input, rec.output
    window = Window.around((x, y), (x, fit.predictions[i]))
    label_axes(axes, window, rec.input_label, rec.output_label)
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


def _draw_time(fit: Fit, first: int, axes: Axes) -> None:
    rec = fit.recordings[0]
    t, label = time_of(rec)
    inside = np.arange(len(rec)) >= first
    window = Window.around((t[inside], rec.output[inside]), (t[inside], fit.predictions[0][inside]))
    label_axes(axes, window, label, rec.output_label)
    for mask, name, token in parts(fit, 0):
        if (mask & inside).any():
            measured = path_of(rec, rec.output, mask & inside)
            draw_series(axes, path_of(rec, t), measured, token, label=name, width=2.4)
    said = path_of(rec, fit.predictions[0], inside)
    draw_series(axes, path_of(rec, t), said, MODEL, label="model", width=0.8, order=3)
    for moment in break_times(rec, t)[:100]:
        axes.axvline(moment, color=BAD.light, lw=1.4, ls=(0, (1, 1.5)), zorder=2.5)
    add_legend(axes)


# Where along a swing an arrow sits: not in the middle, so that those of both branches stay apart in a thin loop.
_PLACE = {1: 0.60, -1: 0.58}
# An arrow spans this share of its swing: long enough to average over noise, short enough to look straight.
_REACH = 0.05


def draw_arrows(axes: Axes, x: Array, y: Array, piece: slice, window: Window, token: Token) -> int:
    """Draw one arrow on the largest rising and one on the largest falling swing of a piece.

    Returns
    -------
    number
        Arrows drawn; none where the input did not swing.
    """
    u, v = x[piece], y[piece]
    points = turning_points(u)
    drawn = 0
    for direction in (1, -1):
        place = _place(u, points, direction)
        if place is None:
            continue
        i, k = place
        tip = (float(np.mean(u[k])), float(np.mean(v[k])))
        tail = (float(np.mean(u[i])), float(np.mean(v[i])))
        axes.annotate(
            "",
            xy=tip,
            xytext=tail,
            zorder=6,
            arrowprops={
                "arrowstyle": "-|>,head_width=0.28,head_length=0.6",
                "color": token.light,
                "lw": 0.0,
                "shrinkA": 0,
                "shrinkB": 0,
                "mutation_scale": 13,
            },
        )
        drawn += 1
    return drawn


def _place(
    u: Array, points: npt.NDArray[np.int64], direction: int
) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]] | None:
    """Samples at tail and tip of the arrow on the largest swing in a direction."""
    swings = np.diff(u[points]) * direction
    if swings.size == 0 or swings.max() <= 0:
        return None
    best = int(np.argmax(swings))
    a, b = int(points[best]), int(points[best + 1])
    share = (u[a : b + 1] - u[a]) / (u[b] - u[a])
    middle = _PLACE[direction]
    tail = a + np.flatnonzero(np.abs(share - (middle - _REACH)) <= _REACH / 2)
    tip = a + np.flatnonzero(np.abs(share - (middle + _REACH)) <= _REACH / 2)
    if tail.size == 0 or tip.size == 0:  # a coarse log: take the nearest samples
        k = a + int(np.argmin(np.abs(share - middle)))
        k = min(max(k, a + 1), b)
        return np.array([k - 1]), np.array([k])
    return tail, tip
