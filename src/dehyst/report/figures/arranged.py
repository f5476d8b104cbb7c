"""Figure 2: the loop around the 45 degree line (the paper's Figure 3)."""

from __future__ import annotations

from functools import partial

import numpy as np

from dehyst.arrays import Array
from dehyst.identification.fit import Fit
from dehyst.report.figures.loop import draw_arrows
from dehyst.report.figures.panel import (
    Axes,
    Figure,
    Panel,
    add_legend,
    draw_path,
    label_axes,
    path_of,
    says,
)
from dehyst.report.theme import CYCLE, MODEL, MUTED
from dehyst.report.thin import Window

_CAPTION = (
    "Arranged: both signals less their centre and over their half range. A straight line without hysteresis would be "
    "the dashed 45 degree line; what lies around it is the hysteresis."
)
_MIRRORED = " The output falls with the input here, so it is mirrored."
_PNEUMATIC = (
    " On a pneumatic joint the 2012 paper shears the input instead, x = Δp − Δp₀(q) + k q, Δp₀ the pressure difference "
    "without load. That needs the joint's calibrated static characteristic, which this log does not contain; scaling "
    "needs nothing but the log."
)


def arranged_figure(fit: Fit) -> Figure:
    """Return figure 2."""
    rec = fit.recordings[0]
    caption = _CAPTION + (_MIRRORED if fit.facts.trend < 0 else "") + _PNEUMATIC
    width = f"Mean width {fit.facts.width_percent:.1f} % of the output's range."
    return Figure(
        "arranged",
        "The loop around the 45° line",
        caption,
        (
            Panel("As measured", partial(_draw_measured, fit), says(f"{rec.output_label} over {rec.input_label}.")),
            Panel(
                "Arranged around 45°",
                partial(_draw_arranged, fit),
                says("The same loop, both signals scaled to plus and minus one, with the 45 degree line.", width),
            ),
        ),
    )


def scaled(fit: Fit) -> list[tuple[Array, Array]]:
    """Return input and output of each recording scaled to -1..1 over all recordings, output mirrored if it falls."""
    x_center, x_half = _center([rec.input for rec in fit.recordings])
    y_center, y_half = _center([rec.output for rec in fit.recordings])
    sign = -1.0 if fit.facts.trend < 0 else 1.0
    return [((rec.input - x_center) / x_half, sign * (rec.output - y_center) / y_half) for rec in fit.recordings]


def _center(signals: list[Array]) -> tuple[float, float]:
    low = min(float(s.min()) for s in signals)
    high = max(float(s.max()) for s in signals)
    half = (high - low) / 2.0
    return (high + low) / 2.0, half if half > 0.0 else 1.0


def _draw(fit: Fit, pairs: list[tuple[Array, Array]], window: Window, axes: Axes) -> None:
    several = len(pairs) > 1
    for i, (x, y) in enumerate(pairs):
        rec = fit.recordings[i]
        token = CYCLE[i % len(CYCLE)]
        label = rec.name if several else "measured"
        draw_path(axes, path_of(rec, x), path_of(rec, y), window, token, label=label, width=1.2)
    x, y = pairs[0]
    longest = max(fit.recordings[0].pieces, key=lambda piece: piece.stop - piece.start)
    draw_arrows(axes, x, y, longest, window, MODEL)
    if several and len(pairs) <= len(CYCLE):
        add_legend(axes)


def _draw_measured(fit: Fit, axes: Axes) -> None:
    pairs = [(rec.input, rec.output) for rec in fit.recordings]
    window = Window.around(*pairs)
    label_axes(axes, window, fit.recordings[0].input_label, fit.recordings[0].output_label)
    _draw(fit, pairs, window, axes)


def _draw_arranged(fit: Fit, axes: Axes) -> None:
    window = Window(-1.1, 1.1, -1.1, 1.1)
    axes.set_aspect("equal", anchor="W")
    axes.set_xticks(np.linspace(-1.0, 1.0, 5))
    axes.set_yticks(np.linspace(-1.0, 1.0, 5))
    mirrored = "−" if fit.facts.trend < 0 else ""
    first = fit.recordings[0]
    label_axes(axes, window, f"{first.input_name}, scaled [1]", f"{mirrored}{first.output_name}, scaled [1]")
    axes.plot([-1.1, 1.1], [-1.1, 1.1], color=MUTED.light, lw=1.0, ls=(0, (5, 3)), zorder=1.5)
    _draw(fit, scaled(fit), window, axes)
