"""Pages from templates: escaped, complete, with the date; and the sheet, what the smaller reports have in common."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from functools import cache
from importlib.resources import files
from typing import Any

import jinja2
from markupsafe import Markup

from dehyst.findings import Finding, Grade
from dehyst.report.figures.panel import Figure
from dehyst.report.svg import panel_svg
from dehyst.report.tables import Table
from dehyst.report.theme import FONT_STACK, variables
from dehyst.shell import visible_lines as clean
from dehyst.version import __version__


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


@dataclass(frozen=True)
class Sheet:
    """What a page of a verdict, figures and tables shows.

    `kind` is the question it answers, above the heading; `relation` the signals below it; `subject` the word for the
    title of the window, "drift"; `more` are further sentences of the verdict, notes names with a sentence each.
    """

    kind: str
    title: str
    relation: str
    subject: str
    badge: str
    grade: Grade
    lead: str
    figures: Sequence[Figure] = ()
    warnings: Sequence[Finding] = ()
    tables: Sequence[Table] = ()
    more: Sequence[str] = ()
    notes: Sequence[tuple[str, str]] = ()
    warnings_of: str = "Warnings"


def sheet_page(sheet: Sheet) -> str:
    """Return the text of the page: one HTML file that needs nothing else and runs nothing."""
    return rendered("sheet.html", sheet=sheet, figures=pictures(sheet.figures))
