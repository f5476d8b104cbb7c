"""Picture of a designed excitation: what is run when, and how much better it is than one loop."""

from __future__ import annotations

from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure as Canvas

from dehyst.design import ExcitationPlan
from dehyst.report.svg import paper, require_picture_name, write_drawn
from dehyst.report.text import number, short
from dehyst.report.theme import FIFTH, INK, MUTED, OTHER, TEST, TRAIN, settings

TITLE = "dehyst design: "  # by which a picture is known that may be drawn anew
SIZE = (9.6, 4.6)  # [inch]
COLOURS = {"home": OTHER, "loops": TRAIN, "cycles": TRAIN, "holds": FIFTH, "test": TEST}
POINTS = 6000  # drawn at most
BARS = (("smallest", "hardest mix\nof weights"), ("creep", "creep"), ("rate", "rate"), ("congruency", "place"))


def write_excitation_figure(path: str | PathLike[str], plan: ExcitationPlan, title: str) -> Path:
    """Write the picture of a plan."""
    target = require_picture_name(path)
    with settings(paper("dehyst design")):
        canvas = Canvas(figsize=SIZE, layout="constrained")
        canvas.suptitle(short(title, 80), x=0.01, ha="left", fontsize=12.5, fontweight="bold", color=INK.light)
        above, below = canvas.subplots(2, 1, height_ratios=[2.3, 1.0])
        _draw_motion(above, plan)
        _draw_figures(below, plan)
        return write_drawn(canvas, target, f"{TITLE}{title}")


def _draw_motion(axes: Any, plan: ExcitationPlan) -> None:
    period = max(plan.period, plan.duration / POINTS)
    time, value, part = plan.signal(period)
    drawn = {name: colour for name, colour in COLOURS.items() if name in part}
    for name, colour in drawn.items():
        mine = part == name
        mine[1:] |= mine[:-1]  # no gap where the next one begins
        axes.plot(time, np.where(mine, value, np.nan), color=colour.light, lw=1.3, label=name)
    axes.set_xlim(0.0, plan.duration)
    axes.set_xlabel("time [s]", color=MUTED.light)
    axes.set_ylabel(f"command [{short(plan.unit, 30)}]" if plan.unit else "command")
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, 1.14), ncols=len(drawn))


def _draw_figures(axes: Any, plan: ExcitationPlan) -> None:
    """Bars: what this plan tells apart, and what one loop over the range does in the same time."""
    places = np.arange(len(BARS))[::-1]
    for shift, figures, colour, label in (
        (0.2, plan.separable, TRAIN, "this plan"),
        (-0.2, plan.one_loop, OTHER, "the largest loop, all the time"),
    ):
        lengths = [max(getattr(figures, key), 1e-4) for key, _ in BARS]
        axes.barh(places + shift, lengths, 0.36, color=colour.light, label=label)
        for place, length in zip(places + shift, lengths, strict=True):
            axes.text(length * 1.06, place, number(length, 2), va="center", fontsize=8.6, color=MUTED.light)
    axes.set_xscale("log")
    axes.set_xlim(5e-4, 12.0)
    axes.set_xticks([0.001, 0.01, 0.1, 1.0], ["0.001", "0.01", "0.1", "1"])
    axes.minorticks_off()
    axes.set_yticks(places, [label.replace("\n", " ") for _, label in BARS])
    axes.set_xlabel("share that nothing else imitates (1: apart for sure)", color=MUTED.light)
    axes.legend(loc="lower right")
    axes.grid(axis="y", visible=False)
