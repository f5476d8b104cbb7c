"""Pictures of the reproduction's page: rows of axes under each other, painted into the page or into a file.

Margins are fixed instead of measured: a page has about a hundred axes, and measuring letters takes longer than drawing.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure as Canvas

from dehyst.report.figures.panel import Axes, Panel, add_legend
from dehyst.report.svg import inline_svg, paper, write_canvas
from dehyst.report.text import short
from dehyst.report.theme import INK, settings, style

Part = Any  # a matplotlib Figure or SubFigure: it carries no types

# Inches around and between axes: tick labels, the label of the abscissa, the name of a row, the legend.
LEFT, RIGHT, BOTTOM, ROW_NAME, LEGEND = 0.56, 0.10, 0.47, 0.30, 0.24
WIDTH = 4.7
# The name of a row stands right above its axes; without this matplotlib looks for room among the ticks.
NAMED = {"axes.titley": 1.0}


@dataclass(frozen=True)
class Picture:
    """A column of axes that share their abscissa.

    Attributes
    ----------
    title
        What it shows, a few words.
    rows
        Each draws into its axes, and names them by `label_axes`.
    alt
        What a reader who cannot see it should know.
    heights
        Of the rows. [inch]
    left
        Room left of the axes, for names on the ordinate. [inch]
    legends
        Rows of the legend that is put above the first axes; 0 for none.
    """

    title: str
    rows: tuple[Callable[[Axes], None], ...]
    alt: str
    heights: tuple[float, ...] = (2.45,)
    left: float = LEFT
    legends: int = 1

    @property
    def height(self) -> float:
        """Of the whole. [inch]"""
        return sum(self.heights) + ROW_NAME * len(self.rows) + LEGEND * self.legends + BOTTOM

    def paint(self, part: Part, above: float = 0.0) -> None:
        """Draw all rows into a figure or a part of one, `above` inches below its upper edge."""
        total = self.height + above
        top = total - above - LEGEND * self.legends
        axes = None
        for k, (draw, height) in enumerate(zip(self.rows, self.heights, strict=True)):
            top -= ROW_NAME + height
            box = (self.left / WIDTH, top / total, 1.0 - (self.left + RIGHT) / WIDTH, height / total)
            axes = part.add_axes(box, sharex=axes)
            draw(axes)
            _place_labels(axes, height)
            if k == 0 and self.legends:
                _legend(axes, height)
            if k + 1 < len(self.rows):
                axes.tick_params(labelbottom=False)
                axes.set_xlabel("")


@dataclass(frozen=True)
class Plate:
    """A numbered figure: a heading, what is drawn and what to look for, and its pictures.

    Attributes
    ----------
    key
        Name in anchors and file names.
    title
        Heading.
    caption
        Plain text.
    pictures
        Side by side, one below the other on a narrow screen.
    formula
        Below the heading, or "".
    columns
        Pictures beside each other on a desk.
    """

    key: str
    title: str
    caption: str
    pictures: tuple[Picture, ...]
    formula: str = ""
    columns: int = 2


def _place_labels(axes: Axes, height: float) -> None:
    """Put the labels where they always stand, so that matplotlib need not measure the ticks to find out."""
    axes.xaxis.set_label_coords(0.5, -0.26 / height)
    axes.yaxis.set_label_coords(-0.1, 0.5)


def _legend(axes: Axes, height: float) -> None:
    """Put the legend above the row's name, at the same distance whatever the height of the axes."""
    add_legend(axes)
    legend = axes.get_legend()
    if legend is not None:
        legend.set_bbox_to_anchor((0.0, 1.0 + 0.31 / height), transform=axes.transAxes)


def from_panel(panel: Panel) -> Picture:
    """Return a panel of the report of a fit as a picture."""
    return Picture(panel.title, (panel.draw,), panel.alt)


def picture_svg(picture: Picture, prefix: str) -> str:
    """Return a picture as an SVG element for the page; its ids begin with `prefix`."""
    with settings(style() | NAMED | {"svg.hashsalt": prefix}):
        canvas = Canvas(figsize=(WIDTH, picture.height))
        FigureCanvasSVG(canvas)
        picture.paint(canvas)
        return inline_svg(canvas, prefix, picture.alt)


def write_plate(plate: Plate, folder: Path, stem: str) -> list[Path]:
    """Write a figure with all its pictures as SVG and PNG; return the files."""
    columns = min(plate.columns, len(plate.pictures))
    lines = [plate.pictures[k : k + columns] for k in range(0, len(plate.pictures), columns)]
    heights = [max(picture.height for picture in line) + 0.35 for line in lines]
    with settings(paper(stem) | NAMED):
        canvas = Canvas(figsize=(WIDTH * columns, sum(heights)))
        parts = canvas.subfigures(len(lines), columns, squeeze=False, height_ratios=heights)
        for line, row, height in zip(lines, parts, heights, strict=True):
            for picture, part in zip(line, row, strict=False):
                part.set_facecolor("none")
                name = short(picture.title, 60)
                part.suptitle(name, x=0.02, y=0.99, ha="left", fontsize=10.5, fontweight="bold", color=INK.light)
                picture.paint(part, above=height - picture.height)
        return write_canvas(canvas, folder, stem, plate.title)
