"""Figures of the measured loop: as logged with the model over it, scaled to the 45° line, model and inverse."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array, Mask
from dehyst.data import range_over, turning_points
from dehyst.identification import Fit
from dehyst.report._drawing import DASHED, PanelLine, break_times, chart, time_of
from dehyst.report._judgement import inverse_miss
from dehyst.report._parts import Axes, PageFigure, Panel
from dehyst.report._text import count, number, short, with_unit
from dehyst.report._theme import (
    CYCLE,
    DATA,
    FIFTH,
    MODEL,
    MUTED,
    OTHER,
    STATIC,
    TEST,
    TRAIN,
    ThemeColour,
)
from dehyst.report._thin import Window

MAXIMUM_PANELS = 6
# A time series with more loops than this is a solid band; then only its end is drawn.
LOOPS_OVER_TIME, LOOPS_SHOWN = 14, 6
BAND_POINTS = 1500


def loop_figure(fit: Fit) -> PageFigure:
    """Return the loop as measured, what was fitted and what was held out, and the model over it."""
    alone = len(fit.recordings) == 1
    shown = fit.recordings[:MAXIMUM_PANELS]
    panels = [
        Panel(
            "Output over input" if alone else short(rec.name, 60),
            _loop(fit, i),
            f"Loop of {rec.output_label} over {rec.input_label}, {len(rec)} samples, {fit.facts.orientation}, with the "
            "model over it.",
        )
        for i, rec in enumerate(shown)
    ]
    caption = "Arrows show the direction of time. The thin dark line is the model."
    if np.any([mask.any() for mask in fit.test_masks]):
        caption += " It was identified from the blue part alone; the orange part was held out."
    if _band_of(fit) is not None:
        caption += (
            " The band around it, along the fitted part, is where the model would lie on other logs with the same "
            "input (95 %); the noise of a measurement comes on top."
        )
    if alone:
        panels.append(_over_time(fit))
    elif len(fit.recordings) > len(shown):
        caption += f" The first {len(shown)} of {len(fit.recordings)} logs are drawn; all of them are in the scores."
    if any(recording.breaks for recording in fit.recordings):
        caption += " Lines are interrupted where samples are missing."
    return PageFigure("loop", "The loop", caption, tuple(panels))


def _loop(fit: Fit, i: int) -> Callable[[Axes], None]:
    rec = fit.recordings[i]
    model = PanelLine(
        rec.input,
        fit.predictions[i],
        MODEL,
        "model",
        0.9,
        order=3.0,
        outline=True,
        breaks=rec.breaks,
    )
    lines = [*part_lines(fit, i, rec.input, rec.output, 3.0, alpha=0.6), model]

    def also(axes: Axes) -> None:
        draw_arrows(fit, i, rec.input, rec.output, axes)
        band = _band_of(fit)
        if band is not None:
            _draw_band(band, axes)

    return chart(rec.input_label, rec.output_label, lines, also=also)


def _band_of(fit: Fit) -> tuple[Array, Array, Array] | None:
    """Where the model of the only log would lie on other logs; a dead time would move it along the input."""
    first, model = fit.recordings[0], fit.model
    if len(fit.recordings) > 1 or first.breaks or model.shear is not None or model.dead_time:
        return None
    return None if fit.draws is None else fit.draws.band


def _draw_band(band: tuple[Array, Array, Array], axes: Axes) -> None:
    x, y, half_width = band
    # A polygon of many points makes the page heavy.
    drawn = slice(None, None, -(-x.size // BAND_POINTS))
    low, high = (y - half_width)[drawn], (y + half_width)[drawn]
    look: dict[str, Any] = {"color": FIFTH.light, "alpha": 0.35, "lw": 0.0, "zorder": 2.8}
    axes.fill_between(x[drawn], low, high, label="95 % interval", **look)


def part_lines(
    fit: Fit,
    i: int,
    x: Array,
    y: Array,
    width: float,
    *,
    alpha: float = 1.0,
    inside: Mask | None = None,
) -> list[PanelLine]:
    """Return the samples of recording i as lines: those not scored, fitted and held out, each in its colour."""
    train, test, rec = fit.train_masks[i], fit.test_masks[i], fit.recordings[i]
    named: tuple[tuple[Mask, str, ThemeColour], ...] = (
        (~(train | test), "not scored", OTHER), (train, "fitted", TRAIN), (test, "held out", TEST),
    )  # fmt: skip
    lines = []
    for mask, name, token in named:
        drawn = mask if inside is None else mask & inside
        if not drawn.any():
            continue
        thick = width
        if token is TEST and width > 2.5:
            # It lies over the fitted part: thinner, so that both are seen where they agree.
            thick -= 1.0
        lines.append(PanelLine(x, y, token, name, thick, alpha, mask=drawn, breaks=rec.breaks))
    return lines


def _over_time(fit: Fit) -> Panel:
    """The only recording over time, or its last loops if it has many."""
    rec = fit.recordings[0]
    points = turning_points(rec.input)
    title = "The same over time"
    loops, begin = max(0, points.size - 2) // 2, 0
    if loops > LOOPS_OVER_TIME:
        begin, loops = int(points[-2 * LOOPS_SHOWN - 2]), LOOPS_SHOWN
        if begin:
            title += f", last {LOOPS_SHOWN} loops"
    t, label = time_of(rec)
    inside = np.arange(len(rec)) >= begin
    model = PanelLine(
        t, fit.predictions[0], MODEL, "model", 0.8, order=3.0, mask=inside, breaks=rec.breaks
    )
    lines = [*part_lines(fit, 0, t, rec.output, 2.4, inside=inside), model]
    return Panel(
        title,
        chart(label, rec.output_label, lines, marks=break_times(rec, t)),
        f"{rec.output_label} over time, measured and model, {count(loops, 'loop')}.",
    )


# Where along a swing an arrow sits: not in the middle, so that those of both branches stay apart in a thin loop.
_PLACE = {1: 0.60, -1: 0.58}
# An arrow spans this share of its swing: long enough to average over noise, short enough to look straight.
_REACH = 0.05


def draw_arrows(fit: Fit, i: int, x: Array, y: Array, axes: Axes) -> int:
    """Draw one arrow on the largest rising and one on the largest falling swing of the longest piece of recording i.

    Returns
    -------
    number
        Arrows drawn; none where the input did not swing.
    """
    piece = max(fit.recordings[i].pieces, key=lambda piece: piece.stop - piece.start)
    u, v = x[piece], y[piece]
    points = turning_points(u)
    look = {
        "arrowstyle": "-|>,head_width=0.28,head_length=0.6",
        "color": MODEL.light,
        "lw": 0.0,
        "shrinkA": 0,
        "shrinkB": 0,
        "mutation_scale": 13,
    }
    drawn = 0
    for direction in (1, -1):
        place = _place(u, points, direction)
        if place is None:
            continue
        tail, tip = place
        # The mean of some samples at either end is hardly moved by noise.
        begin = (float(np.mean(u[tail])), float(np.mean(v[tail])))
        end = (float(np.mean(u[tip])), float(np.mean(v[tip])))
        axes.annotate("", end, begin, zorder=6, arrowprops=dict(look))
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
        k = min(max(a + int(np.argmin(np.abs(share - middle))), a + 1), b)
        return np.array([k - 1]), np.array([k])
    return tail, tip


_CAPTION = (
    "Both signals centred and divided by half of their range. Without hysteresis the curve would be a single line "
    "along the dashed 45° line; what lies around it is the hysteresis.{mirrored}"
)
_MIRRORED = " The output falls with the input here, so it is mirrored."


def arranged_figure(fit: Fit) -> PageFigure:
    """Return the loop as measured, and around the 45° line (the paper's figure 3)."""
    rec, falls = fit.recordings[0], fit.facts.trend < 0
    inputs, outputs = _signals(fit)
    x_centre, x_half = _middle(inputs)
    y_centre, y_half = _middle(outputs)
    sign = -1.0 if falls else 1.0
    measured, scaled = [], []
    for x, y in zip(inputs, outputs, strict=True):
        measured.append((x, y))
        scaled.append(((x - x_centre) / x_half, sign * (y - y_centre) / y_half))
    ends = np.array([-1.1, 1.1])
    diagonal = PanelLine(ends, ends, MUTED, width=1.0, dashes=DASHED, order=1.5)
    window = Window(-1.1, 1.1, -1.1, 1.1)
    across, up = f"{rec.input_name}, scaled [1]", f"{rec.output_name}, scaled [1]"
    caption = _CAPTION.format(mirrored="")
    if falls:
        up = f"−{up}"
        caption = _CAPTION.format(mirrored=_MIRRORED)
    around = chart(
        across,
        up,
        [diagonal, *_logs(fit, scaled)],
        window=window,
        square=True,
        also=partial(draw_arrows, fit, 0, *scaled[0]),
    )
    as_measured = chart(
        rec.input_label,
        rec.output_label,
        _logs(fit, measured),
        also=partial(draw_arrows, fit, 0, *measured[0]),
    )
    return PageFigure(
        "arranged",
        "The loop around the 45° line",
        caption,
        (
            Panel("As measured", as_measured, f"{rec.output_label} over {rec.input_label}."),
            Panel(
                "Scaled, around the 45° line",
                around,
                "The same loop, both signals scaled to plus and minus one, with the 45 degree line. "
                f"At its widest {number(fit.facts.width_percent, 2)} % of the output's range.",
            ),
        ),
    )


def _signals(fit: Fit) -> tuple[list[Array], list[Array]]:
    """Inputs and outputs of all recordings."""
    inputs = [record.input for record in fit.recordings]
    outputs = [record.output for record in fit.recordings]
    return inputs, outputs


def _middle(signals: list[Array]) -> tuple[float, float]:
    """Centre and half of the range over all recordings; the half of a constant is taken as 1."""
    low, high = range_over(signals)
    half = (high - low) / 2.0
    if not half > 0.0:
        half = 1.0
    return (high + low) / 2.0, half


def _logs(fit: Fit, pairs: list[tuple[Array, Array]]) -> list[PanelLine]:
    """Each recording in a colour of its own, named where there are several."""
    named = 1 < len(pairs) <= len(CYCLE)
    lines = []
    for i, (rec, (x, y)) in enumerate(zip(fit.recordings, pairs, strict=True)):
        name = rec.name if named else ""
        lines.append(PanelLine(x, y, CYCLE[i % len(CYCLE)], name, breaks=rec.breaks))
    return lines


def model_figure(fit: Fit) -> PageFigure:
    """Return model and inverse model against the data (the paper's figure 5)."""
    rec = fit.recordings[0]
    caption = (
        "Model: the output that it predicts for the measured input. Dashed: the best curve without hysteresis, which "
        "every hysteresis model has to beat."
    )
    inputs, outputs = _signals(fit)
    across = np.linspace(*range_over(inputs), 400)
    curve = PanelLine(
        across,
        fit.static.simulate(across),
        STATIC,
        "without hysteresis",
        1.5,
        dashes=(0, (4, 2)),
        order=2.5,
    )
    data, model = (0, DATA, 2.6), (1, MODEL, 0.8)
    lines = [
        *_pairs(fit, inputs, outputs, "measured", data),
        curve,
        *_pairs(fit, inputs, fit.predictions, "model", model),
    ]
    forward = Panel(
        "Model: output over input",
        chart(rec.input_label, rec.output_label, lines),
        f"{rec.output_label} over {rec.input_label}: measured, model, and the curve without hysteresis.",
    )
    if fit.model.no_inverse:
        return PageFigure(
            "model", "Model against the data", f"{caption} It has no inverse.", (forward,)
        )
    rms_miss, largest_miss = inverse_miss(fit)
    rms, worst = with_unit(rms_miss, rec.input_unit), with_unit(largest_miss, rec.input_unit)
    caption += (
        " Inverse model: the input that the compensator would ask for to reach the measured output. It misses the "
        f"input that was really applied by {rms} (RMS; largest {worst})."
    )
    asked = [
        *_pairs(fit, outputs, inputs, "applied", data),
        *_pairs(fit, outputs, fit.inverse_predictions, "asked for by the inverse", model),
    ]
    inverse = Panel(
        "Inverse model: input over output",
        chart(rec.output_label, rec.input_label, asked),
        f"{rec.input_label} over {rec.output_label}: applied, and asked for by the inverse model.",
    )
    return PageFigure("model", "Model and inverse against the data", caption, (forward, inverse))


def _pairs(
    fit: Fit,
    across: Sequence[Array],
    up: Sequence[Array],
    label: str,
    look: tuple[int, ThemeColour, float],
) -> list[PanelLine]:
    """All recordings in one colour: wide and light for the data, thin and dark for the model over it."""
    over, token, width = look
    order, outline = 2.0 + over, bool(over)
    lines = []
    for rec, x, y in zip(fit.recordings, across, up, strict=True):
        line = PanelLine(x, y, token, label, width, order=order, outline=outline, breaks=rec.breaks)
        lines.append(line)
    return lines
