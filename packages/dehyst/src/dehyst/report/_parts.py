"""Elements of a report page as plain data: tables, figures with panels, sections, commands."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import groupby, starmap
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
class PageTable:
    """A table with a heading; the first cell of each row names it."""

    title: str
    head: tuple[str, ...]  # names of columns; () for pairs of name and value
    rows: tuple[
        tuple[str | Cell, ...], ...
    ]  # a range in brackets at the end of a cell is printed smaller
    note: str = ""  # sentence below the table
    folded: bool = False  # whether it starts closed
    words: bool = False  # whether cells are words, set to the left


@dataclass(frozen=True, slots=True)
class Panel:
    """A column of axes over one abscissa; most panels have a single one."""

    title: str
    draw: Draw | tuple[Draw, ...]  # one function, or one for each of the axes from above
    alt: str  # what a reader who cannot see it should know
    heights: tuple[float, ...] = (HEIGHT,)  # of the axes [inch]
    left: float = 0.0  # room left of the axes at least; long tick labels get more [inch]
    legend: bool = True  # whether names of lines are listed above the panel

    @property
    def rows(self) -> tuple[Draw, ...]:
        """What draws each of the axes."""
        if isinstance(self.draw, tuple):
            return self.draw
        return (self.draw,)


@dataclass(frozen=True, slots=True)
class PageFigure:
    """A figure of a page: a heading, what is drawn and what to look for, panels side by side."""

    key: str  # name in anchors and file names, for example "loop"
    title: str
    caption: str
    panels: tuple[Panel, ...]
    formula: str = ""  # below the heading, plain text
    table: PageTable | None = None  # below the panels
    points: tuple[str, ...] = ()  # sentences beside the panels: what follows from them
    columns: int = 2  # panels beside each other on a desk
    width: float = WIDTH  # of a panel in a file [inch]
    number: str = ""

    @property
    def stem(self) -> str:
        """Name of its files."""
        if self.number:
            return f"figure-{self.number}-{self.key}"
        return self.key


def numbered(figures: Sequence[PageFigure]) -> tuple[PageFigure, ...]:
    """Return figures with their numbers, from 1."""
    return tuple(replace(figure, number=str(k)) for k, figure in enumerate(figures, start=1))


@dataclass(frozen=True, slots=True)
class Step:
    """Something to type, and what it does."""

    purpose: str
    code: str


@dataclass(frozen=True, slots=True)
class Note:
    """A name with a sentence; it looks like a finding."""

    code: str
    message: str


NOTHING = Markup()
Block = str | Markup | PageTable | PageFigure | Finding | Note | Step


@dataclass(frozen=True, slots=True)
class PageSection:
    """A part of a page with a heading."""

    key: str  # name of its anchor; anchors inside a section that folds begin with it
    title: str
    blocks: tuple[Block | PageSection, ...]
    caption: str = ""
    about: str = ""  # beside the heading of a section that folds
    folds: bool | None = None  # whether it starts closed; None if it cannot be folded
    files: str = ""  # what the names of its figures' files begin with

    @property
    def runs(self) -> Iterator[tuple[str, list[Block | PageSection]]]:
        """Blocks of the same kind that follow each other: tables stand side by side."""
        for kind, run in groupby(self.blocks, lambda block: type(block).__name__):
            yield kind, list(run)


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
    """All that a page shows."""

    kind: str  # the question it answers, above the heading
    title: str
    relation: str  # the signals, below the heading
    subject: str  # word for the title of the window: "drift"
    lead: str  # the verdict
    sections: tuple[PageSection | PageFigure, ...]
    badge: str = ""  # the verdict in a word
    grade: Grade | None = None  # its colour; None for a page that judges nothing
    more: tuple[str, ...] = ()  # further sentences of the verdict
    summary: PageTable | None = None  # small table within the verdict
    tiles: tuple[Tile, ...] = ()
    tiles_note: str = ""
    lights: tuple[Light, ...] = ()
    opening: Markup = NOTHING  # between the first screen and the contents

    @property
    def figures(self) -> Iterator[tuple[str, PageFigure]]:
        """All figures with the names of their files, in the order of the page."""
        return _figures(self.sections, "")


def _figures(
    blocks: Sequence[Block | PageSection], before: str
) -> Iterator[tuple[str, PageFigure]]:
    for block in blocks:
        if isinstance(block, PageFigure):
            yield before + block.stem, block
        elif isinstance(block, PageSection):
            # Two sections of one page may hold figures of the same key.
            prefix = before
            if block.files:
                prefix += f"{block.files}-"
            yield from _figures(block.blocks, prefix)


def tables_section(*tables: PageTable | None) -> PageSection:
    """Return the section of all tables that there are."""
    present = [table for table in tables if table is not None]
    return PageSection("tables", "Tables", tuple(present))


def warnings_section(
    findings: Sequence[Finding], title: str = "Warnings"
) -> tuple[PageSection, ...]:
    """Return the section of findings; none if there are no findings."""
    if not findings:
        return ()
    return (PageSection("warnings", title, tuple(findings)),)


def notes_section(notes: Sequence[tuple[str, str]]) -> tuple[PageSection, ...]:
    """Return the section of notes, names with a sentence each; none if there are no notes."""
    if not notes:
        return ()
    return (PageSection("notes", "Notes", tuple(starmap(Note, notes))),)
