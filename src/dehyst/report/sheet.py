"""A page of a verdict, figures and tables: what the smaller reports have in common."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from importlib.resources import files

import jinja2
from markupsafe import Markup

from dehyst import __version__
from dehyst.findings import Finding
from dehyst.grades import Grade
from dehyst.report.figures.panel import Figure
from dehyst.report.svg import panel_svg
from dehyst.report.tables import Table
from dehyst.report.text import clean
from dehyst.report.theme import FONT_STACK, variables

TEMPLATES = ("sheet.html", "page.css", "tables.html")


@dataclass(frozen=True)
class Sheet:
    """What a page shows.

    Attributes
    ----------
    kind
        The question it answers, above the heading.
    title, relation
        Heading, and the signals below it.
    subject
        Word for the title of the window, "drift".
    badge, grade, lead
        Verdict: one word, its colour, one sentence.
    more
        Further sentences of the verdict.
    figures, warnings, tables, notes
        What stands below; notes are names with a sentence each.
    warnings_of
        Heading of the warnings.
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
    room = files("dehyst.report") / "templates"
    environment = jinja2.Environment(
        loader=jinja2.DictLoader({name: (room / name).read_text(encoding="utf-8") for name in TEMPLATES}),
        autoescape=True,
        finalize=lambda value: value if isinstance(value, Markup) else clean(value),
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template("sheet.html").render(
        sheet=sheet,
        figures=[
            (figure, [(panel, Markup(panel_svg(panel, f"{figure.key}{k}"))) for k, panel in enumerate(figure.panels)])
            for figure in sheet.figures
        ],
        version=__version__,
        date=datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC"),
        light=Markup(variables(dark=False)),
        dark=Markup(variables(dark=True)),
        font=Markup(FONT_STACK),
    )
