"""A page of a verdict, figures and tables: what the smaller reports have in common."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from dehyst.findings import Finding
from dehyst.grades import Grade
from dehyst.report.figures.panel import Figure
from dehyst.report.rendering import pictures, rendered
from dehyst.report.tables import Table


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
    return rendered("sheet.html", sheet=sheet, figures=pictures(sheet.figures))
