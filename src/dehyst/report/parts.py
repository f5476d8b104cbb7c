"""What a page is made of: tables, figures of one or more panels, steps to type, sections; plain data, no drawing."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import groupby
from typing import Any

from markupsafe import Markup

from dehyst.findings import Finding, Grade

Axes = Any  # matplotlib's classes carry no types
Draw = Callable[[Axes], None]

# Size of a panel and of the axes in it: two panels fit beside each other on a desk, one fills a phone. [inch]
WIDTH, HEIGHT = 4.7, 2.45


@dataclass(frozen=True, slots=True)
class Cell:
    """A cell of a table that ends in a coloured word."""

    text: str
    badge: str
    grade: Grade


@dataclass(frozen=True, slots=True)
class Table:
    """A table with a heading; the first cell of each row names it.

    Attributes
    ----------
    title
        Heading.
    head
        Column names, () for pairs of name and value.
    rows
        Cells; a range in brackets at the end of one is printed smaller.
    note
        Sentence below the table, or "".
    folded
        Whether it starts closed.
    words
        Whether cells are words, set to the left.
    """

    title: str
    head: tuple[str, ...]
    rows: tuple[tuple[str | Cell, ...], ...]
    note: str = ""
    folded: bool = False
    words: bool = False


@dataclass(frozen=True, slots=True)
class Panel:
    """A column of axes over one abscissa; most panels have a single one.

    Attributes
    ----------
    title
        What it shows, a few words.
    draw
        Draws into matplotlib axes: one function, or one for each of the axes from above.
    alt
        What a reader who cannot see it should know.
    heights
        Of the axes. [inch]
    left
        Room left of the axes at least; more is taken when the tick labels need it. [inch]
    legend
        Whether names of lines are listed above the panel.
    """

    title: str
    draw: Draw | tuple[Draw, ...]
    alt: str
    heights: tuple[float, ...] = (HEIGHT,)
    left: float = 0.0
    legend: bool = True

    @property
    def rows(self) -> tuple[Draw, ...]:
        """What draws each of the axes."""
        return self.draw if isinstance(self.draw, tuple) else (self.draw,)


@dataclass(frozen=True, slots=True)
class Figure:
    """A figure of a page.

    Attributes
    ----------
    key
        Name in anchors and file names, for example "loop".
    title
        Heading.
    caption
        What is drawn and what to look for; plain text.
    panels
        Drawn side by side, one below the other on a narrow screen.
    formula
        Formula below the heading in plain text, or "".
    table
        Table below the panels, or None.
    points
        Sentences beside the panels: what follows from them.
    columns
        Panels beside each other.
    width
        Of a panel in a file. [inch]
    number
        Of the figure, or "".
    """

    key: str
    title: str
    caption: str
    panels: tuple[Panel, ...]
    formula: str = ""
    table: Table | None = None
    points: tuple[str, ...] = ()
    columns: int = 2
    width: float = WIDTH
    number: str = ""

    @property
    def stem(self) -> str:
        """Name of its files."""
        return f"figure-{self.number}-{self.key}" if self.number else self.key


def numbered(figures: Sequence[Figure]) -> tuple[Figure, ...]:
    """Return figures with their numbers, from 1."""
    return tuple(replace(figure, number=str(k)) for k, figure in enumerate(figures, start=1))


@dataclass(frozen=True, slots=True)
class Step:
    """Something to type, and what it does."""

    purpose: str
    code: str


NOTHING = Markup()
Block = str | Markup | Table | Figure | Finding | Step


@dataclass(frozen=True, slots=True)
class Section:
    """A part of a page with a heading.

    Attributes
    ----------
    key
        Name of its anchor; anchors and files of what is inside begin with it where `folds` is not None.
    title, caption
        Heading, and text below it.
    blocks
        Sentences, tables, figures, findings, steps, sections, in their order.
    about
        Beside the heading of a section that can be folded.
    folds
        Whether it starts closed; None if it cannot be folded.
    files
        What the names of its figures' files begin with.
    """

    key: str
    title: str
    blocks: tuple[Block | Section, ...]
    caption: str = ""
    about: str = ""
    folds: bool | None = None
    files: str = ""

    @property
    def runs(self) -> Iterator[tuple[str, list[Block | Section]]]:
        """Blocks of the same kind that follow each other: tables stand side by side."""
        return ((kind, list(run)) for kind, run in groupby(self.blocks, lambda block: type(block).__name__))


@dataclass(frozen=True, slots=True)
class Tile:
    """A number of the first screen; `before` is what it was without the compensator, or ""."""

    name: str
    value: str
    unit: str
    remark: str
    before: str = ""


@dataclass(frozen=True, slots=True)
class Light:
    """One aspect of a result: what is judged, the judgement, and the numbers behind it."""

    aspect: str
    grade: Grade
    reason: str


@dataclass(frozen=True, slots=True)
class Page:
    """All that a page shows.

    Attributes
    ----------
    kind, title, relation
        The question it answers, the heading, the signals below it.
    subject
        Word for the title of the window: "drift".
    lead
        The verdict.
    sections
        Sections, and figures that are sections of their own.
    badge, grade
        The verdict in a word, and its colour; "" and None for a page that judges nothing.
    more
        Further sentences of the verdict.
    summary
        Small table within the verdict.
    tiles, tiles_note
        Numbers of the first screen, and a line below them.
    lights
        Aspects of the result, each judged.
    opening
        Between the first screen and the contents.
    """

    kind: str
    title: str
    relation: str
    subject: str
    lead: str
    sections: tuple[Section | Figure, ...]
    badge: str = ""
    grade: Grade | None = None
    more: tuple[str, ...] = ()
    summary: Table | None = None
    tiles: tuple[Tile, ...] = ()
    tiles_note: str = ""
    lights: tuple[Light, ...] = ()
    opening: Markup = NOTHING

    @property
    def figures(self) -> Iterator[tuple[str, Figure]]:
        """All figures with the names of their files, in the order of the page."""
        return _figures(self.sections, "")


def _figures(blocks: Sequence[Block | Section], before: str) -> Iterator[tuple[str, Figure]]:
    for block in blocks:
        if isinstance(block, Figure):
            yield before + block.stem, block
        elif isinstance(block, Section):
            yield from _figures(block.blocks, before + (f"{block.files}-" if block.files else ""))


def tables_section(*tables: Table | None) -> Section:
    """Return the section of all tables that there are."""
    return Section("tables", "Tables", tuple(table for table in tables if table is not None))


def warnings_section(
    findings: Sequence[Finding], title: str = "Warnings", key: str = "warnings"
) -> tuple[Section, ...]:
    """Return the section of findings; none if there are no findings."""
    return (Section(key, title, tuple(findings)),) if findings else ()
