"""Writes a page as one HTML file without outside references, and its figures as SVG and PNG."""

from __future__ import annotations

import base64
import hashlib
import os
from datetime import UTC, datetime
from functools import cache
from importlib.resources import files
from pathlib import Path

import jinja2
from markupsafe import Markup

from dehyst.errors import OutputError
from dehyst.files import write_atomically
from dehyst.report._parts import Page, PageFigure
from dehyst.report._svg import panel_svg, write_figure
from dehyst.report._theme import FONT_STACK, variables
from dehyst.shell import visible_lines as clean
from dehyst.version import __version__


def write_page(
    page: Page, path: str | os.PathLike[str], figures: str | os.PathLike[str] | None = None
) -> Path:
    """Write a page as HTML, and its figures as SVG and PNG into a folder if one is named."""
    # The page comes first: it is whole without the files of its figures.
    written = write_atomically(path, page_text(page))
    if figures is not None:
        write_figures_of(page, figures)
    return written


def write_figures_of(page: Page, folder: str | os.PathLike[str]) -> Path:
    """Write every figure of a page as SVG and PNG into a folder, which is made if it does not exist."""
    target = Path(folder)
    try:
        target.mkdir(parents=True, exist_ok=True)
    except OSError as fault:
        raise OutputError(
            f"cannot make the folder '{target}' for the figures: {fault.strerror}. "
            f"Name a folder that exists or can be made.",
            path=str(target),
        ) from None
    for stem, figure in page.figures:
        write_figure(figure, target, stem)
    return target


def page_text(page: Page) -> str:
    """Return the HTML of a page."""
    # The page allows the one script with this checksum, so that no name in a log can bring another.
    script = _template("page.js")
    return (
        _environment()
        .get_template("page.html")
        .render(
            page=page,
            script=Markup(script),
            allowed=base64.b64encode(hashlib.sha256(script.encode()).digest()).decode(),
            version=__version__,
            date=datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC"),
            light=Markup(variables(dark=False)),
            dark=Markup(variables(dark=True)),
            font=Markup(FONT_STACK),
        )
    )


def _pictures(figure: PageFigure, prefix: str) -> list[tuple[str, Markup]]:
    """Titles and pictures of the panels; ids begin with the prefix and the figure's name."""
    pictures = []
    for k, panel in enumerate(figure.panels):
        picture = Markup(panel_svg(panel, f"{prefix}{figure.key}{k}"))
        pictures.append((panel.title, picture))
    return pictures


def _template(name: str) -> str:
    return (files("dehyst.report") / "templates" / name).read_text(encoding="utf-8")


@cache
def _environment() -> jinja2.Environment:
    # finalize: whatever a log calls itself passes through clean() and then through escaping; only mark-up of this
    # room is exempt.
    made = jinja2.Environment(
        loader=jinja2.FunctionLoader(_template),
        autoescape=True,
        finalize=lambda value: value if isinstance(value, Markup) else clean(value),
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    made.globals["pictures"] = _pictures
    made.tests["figure"] = lambda block: isinstance(block, PageFigure)
    return made
