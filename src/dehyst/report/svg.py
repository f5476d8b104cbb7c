"""Panels -> SVG that lives inside the page, and figure files (SVG, PNG)."""

from __future__ import annotations

import io
import re
import warnings
import xml.etree.ElementTree as ElementTree
from os import PathLike
from pathlib import Path
from typing import Any

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure as Canvas

from dehyst.errors import OutputError
from dehyst.files import write_atomically
from dehyst.report.figures.panel import Figure, Panel
from dehyst.report.text import short
from dehyst.report.theme import INK, PAPER, TOKENS, settings, style
from dehyst.shell import visible_lines as clean

# Size of a panel: two fit beside each other on a desk, one fills a phone with letters still readable. [inch]
WIDTH, HEIGHT = 4.7, 3.55
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
        canvas = Canvas(figsize=(WIDTH, HEIGHT * panel.tall), layout="constrained")
        FigureCanvasSVG(canvas)
        panel.draw(canvas.add_subplot())
        return inline_svg(canvas, prefix, panel.alt)


def inline_svg(canvas: Canvas, prefix: str, alt: str) -> str:
    """Return what was drawn on an SVG canvas as an element of the page, under the settings it was drawn with."""
    stream = io.StringIO()
    _save(canvas, stream, format="svg", metadata=_NO_METADATA)
    root = ElementTree.fromstring(_body(stream.getvalue()))
    _make_inline(root, prefix)
    root.set("role", "img")
    root.set("aria-label", clean(alt))
    return ElementTree.tostring(root, encoding="unicode")


def write_figure(figure: Figure, folder: Path, number: int) -> list[Path]:
    """Write a figure with all its panels as SVG and PNG; return the files."""
    stem = f"figure-{number}-{figure.key}"
    with settings(paper(stem)):
        return write_canvas(_drawn(figure), folder, stem, figure.title)


def write_picture(figure: Figure, path: str | PathLike[str], title: str) -> Path:
    """Write a figure with all its panels as one file, ``.svg`` or ``.png``; any other ending is refused."""
    target = require_picture_name(path)
    with settings(paper(figure.key)):
        return write_drawn(_drawn(figure), target, title)


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


def write_drawn(canvas: Canvas, target: Path, title: str) -> Path:
    """Write what was drawn on paper, PNG if the name ends so and SVG otherwise."""
    png = target.suffix.lower() == ".png"
    return write_atomically(target, png_file(canvas, title) if png else svg_file(canvas, title))


def paper(salt: str) -> dict[str, Any]:
    """Return the settings of a picture that stands in a file of its own."""
    return style() | {"svg.hashsalt": salt, "figure.facecolor": PAPER.light, "savefig.facecolor": PAPER.light}


def _drawn(figure: Figure) -> Canvas:
    """All panels on one canvas, under the settings of the caller."""
    columns = min(2, len(figure.panels))
    rows = -(-len(figure.panels) // columns)
    tall = max(panel.tall for panel in figure.panels)
    canvas = Canvas(figsize=(WIDTH * columns, HEIGHT * tall * rows + 0.3), layout="constrained")
    parts = canvas.subfigures(rows, columns, squeeze=False).ravel()
    for part, panel in zip(parts, figure.panels, strict=False):
        part.suptitle(short(panel.title, 60), x=0.02, ha="left", fontsize=10.5, fontweight="bold", color=INK.light)
        panel.draw(part.add_subplot())
    for part in parts:
        part.set_facecolor("none")
    return canvas


def write_canvas(canvas: Canvas, folder: Path, stem: str, title: str) -> list[Path]:
    """Write what was drawn as STEM.svg and STEM.png; return the files."""
    picture = png_file(canvas, title)
    return [
        write_atomically(folder / f"{stem}.svg", svg_file(canvas, title)),
        write_atomically(folder / f"{stem}.png", picture),
    ]


def png_file(canvas: Canvas, title: str) -> bytes:
    """Return what was drawn as the content of a PNG file."""
    picture = io.BytesIO()
    FigureCanvasAgg(canvas)
    _save(canvas, picture, format="png", dpi=PNG_DPI, metadata={"Software": None, "Title": clean(title)})
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
    return '<?xml version="1.0" encoding="utf-8"?>\n' + ElementTree.tostring(root, encoding="unicode") + "\n"


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
                if value in used:
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
    value = _COLOUR.sub(lambda found: _VARIABLE.get(found.group(), found.group()), value)
    if tag == "text":  # "font: 9px 'DejaVu Sans'": keep the size, take the page's family
        value = re.sub(r"font:\s*((?:bold|700)\s+)?([\d.]+px)[^;]*", r"font-size: \2", value)
    return value


def _round_paths(root: ElementTree.Element) -> None:
    """Write coordinates with two decimals, a hundredth of a point."""
    for element in root.iter():
        for name in ("d", "x", "y"):
            value = element.get(name)
            if value is not None:
                shorter = _LONG_NUMBER.sub(lambda found: f"{float(found.group()):.2f}", value)
                element.set(name, " ".join(shorter.split()) if name == "d" else shorter)
