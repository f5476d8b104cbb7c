"""Pictures of two commands: output band for an unknown initial state, and plan of an excitation."""

from __future__ import annotations

from os import PathLike
from pathlib import Path

import numpy as np

from dehyst.arrays import Array
from dehyst.design import ExcitationPlan
from dehyst.report._drawing import PanelLine, chart, logarithmic
from dehyst.report._parts import Axes, PageFigure, Panel
from dehyst.report._svg import write_picture
from dehyst.report._text import bracketed, number, short
from dehyst.report._theme import DATA, FIFTH, MODEL, MUTED, OTHER, TEST, TRAIN
from dehyst.report._thin import Window

BAND, EXCITATION = (
    "dehyst band: ",
    "dehyst design: ",
)  # by which a picture is known that may be drawn anew
COLOURS = {"home": OTHER, "loops": TRAIN, "cycles": TRAIN, "holds": FIFTH, "test": TEST}
POINTS = 6000  # of a plan, drawn at most
BARS = (
    ("smallest", "hardest mix of weights"),
    ("creep", "creep"),
    ("rate", "rate"),
    ("congruency", "place"),
)


def write_band(
    path: str | PathLike[str],
    time: Array,
    low: Array,
    high: Array,
    certainty: Array,
    across: str,
    up: str,
) -> Path:
    """Write the picture of an interval over time, with how much of the memory is known below it."""

    def filled(axes: Axes) -> None:
        axes.fill_between(
            time,
            low,
            high,
            color=DATA.light,
            alpha=0.6,
            lw=0,
            label="possible, whatever was before",
        )

    lines = [
        PanelLine(time, low, TEST, "lowest", 0.8),
        PanelLine(time, high, TEST, "highest", 0.8, dashes="dashed"),
        PanelLine(time, 0.5 * (low + high), MODEL, "middle", 1.1),
    ]
    window = Window(float(time[0]), float(time[-1]), -0.04, 1.04)
    drawn = chart(
        across,
        "share of the memory that is known",
        [PanelLine(time, certainty, MODEL, width=1.1)],
        window=window,
    )
    panel = Panel("", (chart(across, up, lines, also=filled), drawn), "", heights=(3.2, 1.1))
    return write_picture(PageFigure("band", up, "", (panel,), width=7.05), path, BAND + up)


def write_excitation_figure(path: str | PathLike[str], plan: ExcitationPlan, title: str) -> Path:
    """Write the picture of a plan: what is run when, and how much better it is than one loop."""
    time, value, part = plan.signal(max(plan.period, plan.duration / POINTS))
    motion = []
    for name, colour in COLOURS.items():
        mine = part == name
        # Each part goes on to the first sample of the next one, so that no gap lies between them.
        if mine.any():
            mine[1:] |= mine[:-1]
            motion.append(PanelLine(time, value, colour, name, 1.3, mask=mine))
    panels = (
        Panel(
            "What is run",
            chart("time [s]", f"command{bracketed(short(plan.unit, 30))}", motion),
            "",
        ),
        Panel(
            "What can be told apart afterwards",
            lambda axes: _draw_shares(axes, plan),
            "",
            heights=(1.3,),
            left=1.9,
        ),
    )
    return write_picture(
        PageFigure("design", title, "", panels, columns=1, width=9.6),
        path,
        EXCITATION + title,
        headed=True,
    )


def _draw_shares(axes: Axes, plan: ExcitationPlan) -> None:
    """Bars: what this plan tells apart, and what one loop over the range does in the same time."""
    # Bars are counted from below, and read from above.
    places = np.arange(len(BARS))[::-1]
    for shift, figures, colour, label in (
        (0.2, plan.separable, TRAIN, "this plan"),
        (-0.2, plan.one_loop, OTHER, "the largest loop, all the time"),
    ):
        # A logarithmic axis has no place for zero.
        lengths = [max(getattr(figures, key), 1e-4) for key, _ in BARS]
        axes.barh(places + shift, lengths, 0.36, color=colour.light, label=label)
        for place, length in zip(places + shift, lengths, strict=True):
            axes.text(
                length * 1.06,
                place,
                number(length, 2),
                va="center",
                fontsize=8.6,
                color=MUTED.light,
            )
    logarithmic(axes, "x", 5e-4, 3.0)
    axes.set_yticks(places, [label for _, label in BARS])
    axes.set_xlabel(
        "share that nothing else imitates (1: can be told apart for sure)", color=MUTED.light
    )
    axes.grid(axis="y", visible=False)
