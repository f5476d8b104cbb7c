"""Draws figures with matplotlib: as SVG within a page, as SVG and PNG files; sets margins and legends."""

from __future__ import annotations

import io
import json
import re
import warnings
import xml.etree.ElementTree as ElementTree
from collections.abc import Sequence
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure as Canvas
from matplotlib.ticker import AutoLocator

from dehyst.errors import OutputError
from dehyst.files import write_atomically
from dehyst.report._parts import WIDTH, Axes, PageFigure, Panel
from dehyst.report._text import short, width
from dehyst.report._theme import INK, MUTED, PAPER, TOKENS, settings, style
from dehyst.shell import visible_lines as clean

# Inches around and between axes: least room for tick labels, right edge, the label of the abscissa, the name of an
# ordinate, a line of the legend, the title of a panel in a file, heading and caption of a file.
LEFT, RIGHT, BOTTOM, NAME, LEGEND, TITLE, HEADING = 0.5, 0.10, 0.47, 0.30, 0.24, 0.35, 0.62
SHORT = 2.0  # lower axes have fewer ticks [inch]
LETTER = 0.62  # width of a letter over its size
# Letters in a line of a legend for each inch, and how many of them the sample of an entry takes.
LEGEND_WIDTH, LEGEND_KEY = 13.5, 5
PNG_DPI = 200
ENDINGS = (".svg", ".png")

_SVG = "{http://www.w3.org/2000/svg}"
_XLINK = "{http://www.w3.org/1999/xlink}"
_VARIABLE = {token.light: f"var(--{token.name})" for token in TOKENS}
_COLOUR = re.compile(r"#[0-9a-f]{6}")
_LONG_NUMBER = re.compile(r"-?\d+\.\d{3,}")
_NO_METADATA = {"Creator": None, "Date": None, "Format": None, "Type": None}


def panel_svg(panel: Panel, prefix: str) -> str:
    """Return one panel as an SVG element for the page.

    Its colours are the page's CSS variables, its letters are the page's letters, its ids begin with `prefix`, and
    it refers to nothing outside.
    """
    with settings(style() | {"svg.hashsalt": prefix}):
        canvas = Canvas()
        FigureCanvasSVG(canvas)
        draw_panels(canvas, (panel,), 1)
        _tell_script(canvas.axes)
        stream = io.StringIO()
        _save(canvas, stream, format="svg", metadata=_NO_METADATA)
        root = ElementTree.fromstring(_body(stream.getvalue()))
        _make_inline(root, prefix)
        root.set("role", "img")
        root.set("aria-label", clean(panel.alt))
        return ElementTree.tostring(root, encoding="unicode")


def _tell_script(rows: Sequence[Axes]) -> None:
    """Name what the script of the page reads: axes with their ranges and labels, both axes' ticks, and curves.

    Only if each of the axes is a chart of lines over plain scales: the script makes ticks of its own when it zooms.
    """
    curves = []
    for axes_row in rows:
        if not _is_plain(axes_row.xaxis) or not _is_plain(axes_row.yaxis):
            return
        lines = _curves(axes_row)
        if not lines:
            return
        curves.append(lines)
    for axes_row, lines in zip(rows, curves, strict=True):
        descriptions = [
            [*_shown_ends(axes_row.xaxis, axes_row.get_xlim()), rows[-1].get_xlabel()],
            [*_shown_ends(axes_row.yaxis, axes_row.get_ylim()), axes_row.get_title("left")],
        ]
        axes_row.set_gid(f"axes:{json.dumps(descriptions, ensure_ascii=False)}")
        axes_row.xaxis.set_gid("across:")
        axes_row.yaxis.set_gid("up:")
        for line in lines:
            name = line.get_label()
            # An underscore hides a line from the legend, so that it has no name for the reader either.
            if name.startswith("_"):
                name = ""
            line.set_gid(f"curve:{name}")


def _is_plain(axis: Any) -> bool:
    """Whether an axis has the ticks that the script makes, too."""
    return type(axis.get_major_locator()) is AutoLocator


def _curves(axes: Axes) -> list[Any]:
    """Lines with points; helpers of matplotlib have no name of their own."""
    lines = []
    for line in axes.lines:
        if not line.get_label().startswith("_child") and len(line.get_xdata()):
            lines.append(line)
    return lines


def _shown_ends(axis: Any, ends: tuple[float, float]) -> list[float]:
    """Ends of an axis in the unit in which its ticks are written."""
    unit = getattr(axis, "unit", 1.0)
    return [float(f"{end / unit:.9g}") for end in ends]


def write_figure(figure: PageFigure, folder: Path, stem: str) -> list[Path]:
    """Write a figure with all its panels as STEM.svg and STEM.png; return the files."""
    with settings(paper(stem)):
        canvas = _drawn(figure, headed=False)
        picture = png_file(canvas, figure.title)
        return [
            write_atomically(folder / f"{stem}.svg", svg_file(canvas, figure.title)),
            write_atomically(folder / f"{stem}.png", picture),
        ]


def write_picture(
    figure: PageFigure, path: str | PathLike[str], title: str, *, headed: bool = False
) -> Path:
    """Write a figure with all its panels as one file, ``.svg`` or ``.png``; any other ending is refused.

    `title` stands in the data of the file; a headed picture shows the figure's own title and caption above the panels.
    """
    target = require_picture_name(path)
    with settings(paper(clean(figure.key))):
        canvas = _drawn(figure, headed)
        if target.suffix.lower() == ".png":
            return write_atomically(target, png_file(canvas, title))
        return write_atomically(target, svg_file(canvas, title))


def require_picture_name(path: str | PathLike[str]) -> Path:
    """Return the path of a picture, or refuse one that ends in neither ``.svg`` nor ``.png``."""
    target = Path(path)
    if target.suffix.lower() in ENDINGS:
        return target
    raise OutputError(
        f"cannot write the picture '{target}': its ending says neither SVG nor PNG. Name a file that ends in "
        f"{' or '.join(ENDINGS)}.",
        path=str(target),
    )


def paper(salt: str) -> dict[str, Any]:
    """Return the settings of a picture that stands in a file of its own."""
    return style() | {
        "svg.hashsalt": salt,
        "figure.facecolor": PAPER.light,
        "savefig.facecolor": PAPER.light,
    }


def _drawn(figure: PageFigure, headed: bool) -> Canvas:
    """All panels on one canvas, under the settings of the caller."""
    canvas = Canvas()
    above = 0.0
    if headed:
        above = HEADING
        if not figure.caption:
            above *= 0.6
    columns = max(1, min(figure.columns, len(figure.panels)))
    height = draw_panels(canvas, figure.panels, columns, figure.width, TITLE, above)
    if headed:
        place = 0.08 / float(canvas.get_figwidth())
        heads = (
            (figure.title, 0.08, 12.5, "bold", INK),
            (figure.caption, 0.36, 8.6, "normal", MUTED),
        )
        for text, down, size, weight, token in heads:
            canvas.text(
                place,
                1.0 - down / height,
                short(text, 90),
                va="top",
                fontsize=size,
                fontweight=weight,
                color=token.light,
            )
    return canvas


@dataclass
class _Drawn:
    """A panel on the canvas, before its axes have a place."""

    panel: Panel
    axes: list[Axes]
    left: float
    legends: int

    @property
    def height(self) -> float:
        """Of the whole. [inch]"""
        return (
            sum(self.panel.heights)
            + sum(map(_room_for_name, self.axes))
            + LEGEND * self.legends
            + BOTTOM
        )

    def place(self, canvas: Canvas, x: float, top: float, across: float) -> None:
        """Put the axes below `top`, between `x` and `x + across`, measured from the lower left corner. [inch]"""
        size = canvas.get_size_inches()
        top -= LEGEND * self.legends
        for axes, height in zip(self.axes, self.panel.heights, strict=False):
            top -= _room_for_name(axes) + height
            box = (x + self.left, top, across - self.left - RIGHT, height)
            axes.set_position(
                [box[0] / size[0], box[1] / size[1], box[2] / size[0], box[3] / size[1]]
            )
            axes.xaxis.set_label_coords(0.5, -0.26 / height)
        if not self.axes:
            return
        legend = self.axes[0].get_legend()
        if legend is not None:
            # The place of a legend is measured in heights of the axes, not in inches.
            above = (_room_for_name(self.axes[0]) + 0.01) / self.panel.heights[0]
            legend.set_bbox_to_anchor((0.0, 1.0 + above), transform=self.axes[0].transAxes)


def _room_for_name(axes: Axes) -> float:
    if axes.get_title(loc="left"):
        return NAME
    return 0.08


def draw_panels(
    canvas: Canvas,
    panels: Sequence[Panel],
    columns: int,
    across: float = WIDTH,
    title: float = 0.0,
    above: float = 0.0,
) -> float:
    """Draw panels in rows of `columns`, `title` inches for the title of each; return the height of the whole. [inch]"""
    drawn = [_draw(canvas, panel, across) for panel in panels]
    lines, heights = [], []
    for first in range(0, len(drawn), columns):
        line = drawn[first : first + columns]
        # The tallest panel and the first title decide for the whole row.
        tallest, gap = 0.0, 0.1
        for drawing in line:
            tallest = max(tallest, drawing.height)
            if drawing.panel.title:
                gap = title
        lines.append(line)
        heights.append(tallest + gap)
    total, wide = sum(heights) + above, across * columns
    canvas.set_size_inches(wide, max(total, 0.1))
    # From the top of the canvas downwards, as matplotlib counts from the bottom.
    top = total - above
    for line, height in zip(lines, heights, strict=True):
        for k, drawing in enumerate(line):
            if title and drawing.panel.title:
                x, y = (k * across + 0.08) / wide, (top - 0.06) / total
                name = short(drawing.panel.title, int(13 * across))
                canvas.text(x, y, name, va="top", fontsize=10.5, fontweight="bold", color=INK.light)
            drawing.place(canvas, k * across, top - height + drawing.height, across)
        top -= height
    return total


def _draw(canvas: Canvas, panel: Panel, across: float) -> _Drawn:
    """Draw a panel; how far its axes stand from the left follows from the widest number at its ticks."""
    axes: list[Axes] = []
    top_axes: Axes | None = None
    for draw, height in zip(panel.rows, panel.heights, strict=False):
        axes_row = canvas.add_axes((0.0, 0.0, 1.0, 1.0), sharex=top_axes)
        top_axes = top_axes or axes_row
        draw(axes_row)
        # Ticks of the usual number would overlap on low axes.
        if height < SHORT and isinstance(axes_row.yaxis.get_major_locator(), AutoLocator):
            axes_row.locator_params(axis="y", nbins=4)
        axes.append(axes_row)
    # Only the lowest axes carry the numbers and the name of what all share.
    for axes_row in axes[:-1]:
        axes_row.tick_params(labelbottom=False)
        axes_row.set_xlabel("")
    widest = 0.0
    for axes_row in axes:
        for label in axes_row.yaxis.get_majorticklabels():
            inches = width(label.get_text()) * LETTER * label.get_fontsize() / 72.0
            widest = max(widest, inches)
    left = max(panel.left, LEFT, 0.12 + widest)
    legends = 0
    if panel.legend:
        legends = _add_legend(axes, across - left)
    return _Drawn(panel, axes, left, legends)


def _add_legend(axes: Sequence[Axes], room: float) -> int:
    """Put one legend for all axes above the first, in as many columns as fit; return its lines."""
    entries: dict[tuple[str, str], Any] = {}
    for axes_row in axes:
        for handle, label in zip(*axes_row.get_legend_handles_labels(), strict=True):
            # The same line on several axes is listed once, and two colours of one name are two lines.
            entries.setdefault((label, str(getattr(handle, "get_color", str)())), handle)
    if not entries:
        return 0
    names = [label for label, _ in entries]
    columns = len(names)
    while columns > 1 and not _legend_width(names, columns) <= LEGEND_WIDTH * room:
        columns -= 1
    legend = axes[0].legend(
        list(entries.values()), names, loc="lower left", ncols=columns, labelcolor=INK.light
    )
    # A thin line is seen on the axes by its length; its sample in the legend is short.
    for handle in legend.legend_handles:
        if handle is not None and hasattr(handle, "set_linewidth"):
            handle.set_linewidth(max(1.6, handle.get_linewidth()))
    return -(-len(names) // columns)


def _legend_width(labels: list[str], columns: int) -> int:
    """Letters across a legend that is filled column by column, the first columns one longer."""
    widths = np.array([width(label) for label in labels])
    letters = 0
    for column in np.array_split(widths, columns):
        letters += max(column.tolist()) + LEGEND_KEY
    return letters


def png_file(canvas: Canvas, title: str) -> bytes:
    """Return what was drawn as the content of a PNG file."""
    picture = io.BytesIO()
    FigureCanvasAgg(canvas)
    _save(
        canvas,
        picture,
        format="png",
        dpi=PNG_DPI,
        metadata={"Software": None, "Title": clean(title)},
    )
    return picture.getvalue()


def svg_file(canvas: Canvas, title: str) -> str:
    """Return what was drawn as the content of an SVG file."""
    drawing = io.StringIO()
    FigureCanvasSVG(canvas)
    _save(canvas, drawing, format="svg", metadata=_NO_METADATA)
    root = ElementTree.fromstring(_body(drawing.getvalue()))
    _round_paths(root)
    heading = ElementTree.Element(f"{_SVG}title")
    heading.text = clean(title)
    root.insert(0, heading)
    ElementTree.register_namespace("", _SVG[1:-1])
    ElementTree.register_namespace("xlink", _XLINK[1:-1])
    return (
        '<?xml version="1.0" encoding="utf-8"?>\n'
        + ElementTree.tostring(root, encoding="unicode")
        + "\n"
    )


def _save(canvas: Canvas, stream: io.StringIO | io.BytesIO, **options: Any) -> None:
    """Draw a figure; a letter that no installed font has becomes a box, which is nothing to warn a caller about."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Glyph .* missing from")
        canvas.savefig(stream, **options)


def _body(document: str) -> str:
    """Drop the document type, which names an address."""
    return document[document.index("<svg") :]


def _make_inline(root: ElementTree.Element, prefix: str) -> None:
    """Turn a document into an element of the page: own ids, CSS colours, no namespaces, no style sheet."""
    _round_paths(root)
    used = _referenced(root)
    for parent in list(root.iter()):
        for child in list(parent):
            if child.tag in (f"{_SVG}style", f"{_SVG}metadata"):
                parent.remove(child)
    for element in root.iter():
        element.tag = element.tag.removeprefix(_SVG)
        attributes = dict(element.attrib)
        element.attrib.clear()
        for name, value in attributes.items():
            if name == "id":
                kind, colon, about = value.partition(":")
                if colon:
                    element.attrib.update({"class": kind, "data-about": about})
                elif value in used:
                    element.set("id", f"{prefix}-{value}")
            elif name == f"{_XLINK}href":
                element.set("href", f"#{prefix}-{value[1:]}")
            elif name in ("style", "clip-path"):
                element.set(name, _styled(value, prefix, element.tag))
            elif not name.startswith("{"):
                element.set(name, value)
    for name in ("width", "height", "version"):
        root.attrib.pop(name, None)
    root.set("class", "plot")


def _referenced(root: ElementTree.Element) -> set[str]:
    used: set[str] = set()
    for element in root.iter():
        for name, value in element.attrib.items():
            if name == f"{_XLINK}href":
                used.add(value[1:])
            elif name in ("style", "clip-path"):
                used.update(re.findall(r"url\(#([^)]+)\)", value))
    return used


def _styled(value: str, prefix: str, tag: str) -> str:
    value = value.replace("url(#", f"url(#{prefix}-")
    value = _COLOUR.sub(lambda match: _VARIABLE.get(match.group(), match.group()), value)
    if tag == "text":  # "font: 9px 'DejaVu Sans'": keep the size, take the page's family
        value = re.sub(r"font:\s*((?:bold|700)\s+)?([\d.]+px)[^;]*", r"font-size: \2", value)
    return value


def _round_paths(root: ElementTree.Element) -> None:
    """Write coordinates with two decimals, a hundredth of a point."""
    for element in root.iter():
        for name in ("d", "x", "y"):
            value = element.get(name)
            if value is None:
                continue
            shorter = _LONG_NUMBER.sub(lambda match: f"{float(match.group()):.2f}", value)
            if name == "d":
                shorter = " ".join(shorter.split())
            element.set(name, shorter)
