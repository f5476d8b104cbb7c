"""The picture of a measurement: errors of both directions with their spread, lost motion with its interval."""

from __future__ import annotations

from os import PathLike
from pathlib import Path

import numpy as np

from dehyst.arrays import Array
from dehyst.report import Axes, Draw, PageFigure, Panel, PanelLine, chart
from dehyst.report import kit as report_kit
from dehyst_targets.backlash._lost_motion import LostMotion
from dehyst_targets.backlash._write import BacklashTable

TITLE = "dehyst backlash: "  # by which a picture is known that may be drawn anew


def write_backlash_figure(
    path: str | PathLike[str], lost: LostMotion, table: BacklashTable, title: str
) -> Path:
    """Write the picture of a measurement and of what a table leaves, ``.svg`` or ``.png``.

    Raises
    ------
    OutputError
        If the ending is another one, or the file cannot be written.
    """
    across = f"commanded position [{lost.unit}]"
    panels = [
        Panel(
            "Error, 2 standard deviations around",
            _errors(lost, across),
            "Errors of both directions over the commanded position.",
        ),
        Panel(
            "Lost motion, its interval",
            _lost(lost, table, across),
            "Lost motion over the commanded position, measured and left.",
        ),
    ]
    figure = PageFigure("backlash", title, "", tuple(panels))
    return report_kit.write_picture(figure, path, f"{TITLE}{title}", headed=True)


def _errors(lost: LostMotion, across: str) -> Draw:
    lines, reaches = [], []
    sides = (
        ("rising", lost.rising, lost.rising_spread, report_kit.TRAIN),
        ("falling", lost.falling, lost.falling_spread, report_kit.TEST),
    )
    for name, error, spread, token in sides:
        lines.append(PanelLine(lost.nominal, error, token, name, marker="o"))
        # A point that was read once has the spread of all.
        around = 2.0 * np.where(np.isfinite(spread), spread, lost.spread)
        reaches += [error - around, error + around]

    def bands(axes: Axes) -> None:
        for low, high, side in zip(reaches[::2], reaches[1::2], sides, strict=True):
            axes.fill_between(lost.nominal, low, high, color=side[3].light, alpha=0.2, lw=0)

    return chart(
        across, f"error [{lost.unit}]", lines, zero=True, include=_ends(*reaches), also=bands
    )


def _lost(lost: LostMotion, table: BacklashTable, across: str) -> Draw:
    lines = [PanelLine(lost.nominal, lost.lost_motion, report_kit.MODEL, "measured", marker="o")]
    if table.files:
        left = table.lost_motion
        lines.append(
            PanelLine(lost.nominal, left, report_kit.MUTED, "left by the table", dashes="dashed")
        )
    low, high = lost.lost_motion - lost.interval, lost.lost_motion + lost.interval

    def bars(axes: Axes) -> None:
        axes.vlines(lost.nominal, low, high, color=report_kit.MODEL.light, lw=1.2)

    return chart(
        across,
        f"lost motion [{lost.unit}]",
        lines,
        zero=True,
        include=_ends(low, high),
        also=bars,
    )


def _ends(*values: Array) -> tuple[float, float]:
    """Smallest and largest of all values."""
    together = np.concatenate(values)
    return float(together.min()), float(together.max())
