"""Pages from templates: escaped, complete, with the date."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import UTC, datetime
from functools import cache
from importlib.resources import files
from typing import Any

import jinja2
from markupsafe import Markup

from dehyst import __version__
from dehyst.report.figures.panel import Figure
from dehyst.report.svg import panel_svg
from dehyst.report.text import clean
from dehyst.report.theme import FONT_STACK, variables


def rendered(template: str, **values: Any) -> str:
    """Return the text of a page: one HTML file that needs nothing else and runs nothing."""
    return (
        _environment()
        .get_template(template)
        .render(
            **values,
            version=__version__,
            date=datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC"),
            light=Markup(variables(dark=False)),
            dark=Markup(variables(dark=True)),
            font=Markup(FONT_STACK),
        )
    )


def pictures(figures: Sequence[Figure]) -> list[tuple[Figure, list[tuple[Any, Markup]]]]:
    """Return each figure with its panels and their pictures."""
    return [
        (figure, [(panel, Markup(panel_svg(panel, f"{figure.key}{k}"))) for k, panel in enumerate(figure.panels)])
        for figure in figures
    ]


@cache
def _environment() -> jinja2.Environment:
    room = files("dehyst.report") / "templates"
    # finalize: whatever a log calls itself passes through clean() and then through escaping; only mark-up of this
    # room is exempt.
    return jinja2.Environment(
        loader=jinja2.FunctionLoader(lambda name: (room / name).read_text(encoding="utf-8")),
        autoescape=True,
        finalize=lambda value: value if isinstance(value, Markup) else clean(value),
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
