"""Picture of an unknown memory: the band that the output lies in, and how it closes."""

from __future__ import annotations

from os import PathLike
from pathlib import Path

from matplotlib.figure import Figure as Canvas

from dehyst.arrays import Array
from dehyst.report.figures.panel import Axes, add_legend, draw_series, label_axes
from dehyst.report.svg import HEIGHT, WIDTH, paper, require_picture_name, write_drawn
from dehyst.report.theme import DATA, MODEL, TEST, settings
from dehyst.report.thin import Window

TITLE = "dehyst band: "  # by which a picture is known that may be drawn anew


def write_band(
    path: str | PathLike[str], time: Array, low: Array, high: Array, certainty: Array, across: str, up: str
) -> Path:
    """Write the picture of an interval over time, with how much of the memory is known below it."""
    target = require_picture_name(path)
    with settings(paper("band")):
        canvas = Canvas(figsize=(1.5 * WIDTH, 1.5 * HEIGHT), layout="constrained")
        above, below = canvas.subplots(2, 1, sharex=True, height_ratios=[3, 1])
        _draw_band(above, time, low, high, up)
        _draw_certainty(below, time, certainty, across)
        return write_drawn(canvas, target, TITLE + up)


def _draw_band(axes: Axes, time: Array, low: Array, high: Array, up: str) -> None:
    label_axes(axes, Window.around((time, low), (time, high)), "", up)
    axes.fill_between(time, low, high, color=DATA.light, alpha=0.6, lw=0, label="any past")
    draw_series(axes, time, low, TEST, label="lowest", width=0.8)
    draw_series(axes, time, high, TEST, label="highest", width=0.8, dashes="dashed")
    draw_series(axes, time, 0.5 * (low + high), MODEL, label="middle")
    add_legend(axes)


def _draw_certainty(axes: Axes, time: Array, certainty: Array, across: str) -> None:
    label_axes(axes, Window(float(time[0]), float(time[-1]), -0.04, 1.04), across, "share of the memory that is known")
    draw_series(axes, time, certainty, MODEL, label="certainty")
