"""The page and the picture of a comparison of model families on one log."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

import numpy as np

from dehyst.families.comparison import Comparison
from dehyst.families.fitting import FamilyFit, grade_of
from dehyst.identification.fit import Score
from dehyst.report.drawing import Bar, Line, bar_heights, bars, chart
from dehyst.report.page import write_page
from dehyst.report.parts import Figure, Page, Panel, Table, notes_section, numbered, tables_section, warnings_section
from dehyst.report.svg import write_picture
from dehyst.report.text import bracketed, number, short
from dehyst.report.theme import DATA, MODEL, OTHER, STATIC, TEST, TRAIN

TITLE = "dehyst compare: "  # by which a picture is known that may be drawn anew
# Bars longer than this many times the error of the best one are cut.
CUT = 8.0


def write_comparison_report(found: Comparison, path: str | os.PathLike[str]) -> Path:
    """Write the page of a comparison: one HTML file that needs nothing else.

    Parameters
    ----------
    found
        Result of `dehyst.compare`.
    path
        File to write, for example ``"families.html"``.

    Returns
    -------
    path
        The page.

    Raises
    ------
    OutputError
        If the file cannot be written. An earlier file of that name stays as it was.

    Examples
    --------
    >>> import numpy as np, dehyst, pathlib, tempfile
    >>> x = 2 * np.sin(np.linspace(0, 20, 400)) * np.linspace(1, 0.3, 400)
    >>> y = dehyst.PrandtlIshlinskii([0.0, 0.6], [1.0, 0.5]).simulate(x)
    >>> found = dehyst.compare(dehyst.Recording(input=x, output=y), ["static", "pi"])
    >>> page = write_comparison_report(found, pathlib.Path(tempfile.mkdtemp()) / "families.html")
    >>> page.read_text(encoding="utf-8")[:15]
    '<!DOCTYPE html>'
    """
    first = found.recordings[0]
    page = Page(
        kind="Which model for this loop?",
        title=short(_names(found), 80),
        relation=f"{short(first.input_label, 60)} → {short(first.output_label, 60)}",
        subject="families",
        badge=found.chosen.family,
        grade=grade_of(found.chosen),
        lead=found.verdict,
        sections=(
            *comparison_figures(found),
            *warnings_section(found.auto.warnings, f"Warnings of identify, whose choice is {found.auto.family}"),
            tables_section(_table(found)),
            *notes_section(found.notes),
        ),
    )
    return write_page(page, path)


def write_comparison_figure(found: Comparison, path: str | os.PathLike[str]) -> Path:
    """Write the picture of a comparison, ``.svg`` or ``.png``.

    Raises
    ------
    OutputError
        If the file cannot be written or has another ending.
    """
    return write_picture(comparison_figures(found)[0], path, f"{TITLE}{short(_names(found), 60)}")


def _names(found: Comparison) -> str:
    return ", ".join(record.name for record in found.recordings)


_ERRORS = (
    "RMS error of the output on samples that no fit has seen, percent of its range. A ring marks errors that differ "
    "from the smallest one by less than the scatter between parts of the held-out samples: another log may turn their "
    "order. Open bars are models without an inverse, which cannot become a compensator."
)


def comparison_figures(found: Comparison) -> tuple[Figure, ...]:
    """Return the pictures: errors of all families; the loop with the best one and what identify chooses."""
    rival = _beside(found)
    over_input, loop = _loops(found, rival)
    caption = "Samples that no fit has seen, with the best family and what identify chooses (or the next one)."
    return numbered(
        (
            Figure("families", "Every family on this log", _ERRORS, (_errors(found), over_input)),
            Figure("loop", "The loop, held out", caption, (loop,)),
        )
    )


def _beside(found: Comparison) -> FamilyFit:
    """What is drawn beside the best one: what identify chooses, or the next one if that is the best."""
    if found.chosen.family != found.auto.family:
        return found.auto_entry
    others = [entry for entry in found.rows[1:] if entry.model is not None]
    return others[0] if others else found.chosen


def _errors(found: Comparison) -> Panel:
    shown = [entry for entry in found.rows if entry.model is not None]
    error = np.array([entry.error_percent for entry in shown])
    edge = min(float(error.max()), max(CUT * float(error.min()), 1e-12)) or 1.0
    rows = [
        Bar(
            entry.family,
            entry.error_percent,
            TRAIN if k == 0 else STATIC if entry.family == "static" else OTHER,
            f"{number(entry.error_percent)} %",
            hollow=not entry.invertible,
            ringed=entry.tied and k > 0,
        )
        for k, entry in enumerate(shown)
    ]
    words = ", ".join(f"{entry.family} {entry.error_percent:.3g} %" for entry in shown)
    draw = bars(rows, "RMS error on held-out loops [% of range]", edge=edge, beside=True)
    return Panel("Error on held-out loops", draw, f"Bars: {words}.", bar_heights(len(shown), beside=True))


def _loops(found: Comparison, rival: FamilyFit) -> tuple[Panel, Panel]:
    """Error over the input, and the loop, of the recording with the most samples held out."""
    k = int(np.argmax([mask.sum() for mask in found.masks]))
    record, mask = found.recordings[k], found.masks[k]
    x, y = record.input, record.output
    drawn = [(entry, token) for entry, token in ((rival, TEST), (found.chosen, MODEL)) if entry.predictions]
    lines, missed = [Line(x, y, DATA, "measured", 2.6, 0.6, mask=mask, breaks=record.breaks)], []
    for entry, token in drawn:
        line = Line(x, entry.predictions[k], token, entry.family, 0.9, mask=mask, breaks=record.breaks)
        lines.append(replace(line, outline=True, order=3.0))
        missed.append(replace(line, y=line.y - y))
    up = f"model less measured{bracketed(record.output_unit)}"
    words = f"{found.chosen.family} and {rival.family}"
    return (
        Panel(
            "Error over the input",
            chart(record.input_label, up, missed, zero=True),
            f"Error of {words} over the input.",
        ),
        Panel("Output over input", chart(record.input_label, record.output_label, lines), f"{words}."),
    )


HEAD = (
    "family",
    "held out [%]",
    "fitted [%]",
    "inverse [%]",
    "parameters",
    "fit [s]",
    "inverse exists",
    "exported",
    "start",
    "seed",
)


def _table(found: Comparison) -> Table:
    """All families."""
    rows = tuple(
        (
            f"{entry.family}{' *' if entry.tied else ''}",
            _percent(entry.test),
            _percent(entry.train),
            "" if entry.inverse_percent is None else number(entry.inverse_percent),
            str(entry.parameters),
            f"{entry.seconds:.2f}",
            "yes" if entry.invertible else "no",
            "yes" if entry.exportable else "no: Python only",
            entry.start,
            "" if entry.seed is None else str(entry.seed),
        )
        for entry in found.rows
        if entry.model is not None
    )
    note = "* within noise of the best. Percent of the output's range, for the inverse of the input's."
    return Table(f"{len(rows)} {'family' if len(rows) == 1 else 'families'}", HEAD, rows, note)


def _percent(score: Score | None) -> str:
    return "" if score is None else number(score.rmse_percent)
