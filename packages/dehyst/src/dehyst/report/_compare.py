"""The page and the picture of a comparison of model families on one log."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

import numpy as np

from dehyst.identification import ComparedFamily, Comparison, Score
from dehyst.report._drawing import Bar, PanelLine, bar_heights, bars, chart
from dehyst.report._page import write_page
from dehyst.report._parts import (
    Axes,
    Page,
    PageFigure,
    PageTable,
    Panel,
    notes_section,
    numbered,
    tables_section,
    warnings_section,
)
from dehyst.report._svg import write_picture
from dehyst.report._text import YES_NO, bracketed, number, short
from dehyst.report._theme import DATA, INK, MODEL, OTHER, STATIC, TEST, TRAIN

TITLE = "dehyst compare: "  # by which a picture is known that may be drawn anew
# Bars longer than this many times the error of the best one are cut.
CUT = 8.0


def write_comparison_report(comparison: Comparison, path: str | os.PathLike[str]) -> Path:
    """Write the page of a comparison: one HTML file that needs nothing else.

    Parameters
    ----------
    comparison
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
    first = comparison.recordings[0]
    # Without a fit, none of the families could be identified, and there is nothing to judge.
    grade = None
    if comparison.chosen.fit is not None:
        grade = comparison.chosen.fit.grade
    page = Page(
        kind="Which model for this loop?",
        title=short(_names(comparison), 80),
        relation=f"{short(first.input_label, 60)} → {short(first.output_label, 60)}",
        subject="families",
        badge=comparison.chosen.family,
        grade=grade,
        lead=comparison.verdict,
        sections=(
            *comparison_figures(comparison),
            *warnings_section(
                comparison.auto.warnings,
                f"Warnings of identify, whose choice is {comparison.auto.family}",
            ),
            tables_section(_table(comparison)),
            *notes_section(comparison.notes),
        ),
    )
    return write_page(page, path)


def write_comparison_figure(comparison: Comparison, path: str | os.PathLike[str]) -> Path:
    """Write the picture of a comparison, ``.svg`` or ``.png``.

    Raises
    ------
    OutputError
        If the file cannot be written or has another ending.
    """
    return write_picture(
        comparison_figures(comparison)[0], path, f"{TITLE}{short(_names(comparison), 60)}"
    )


def _names(comparison: Comparison) -> str:
    """Names of the logs."""
    return ", ".join(record.name for record in comparison.recordings)


_ERRORS = (
    "RMS error of the output on samples that no fit has seen, percent of its range. The line at the end of a bar holds "
    "90 % of the errors if other samples were held out: ten parts of them, drawn anew 2000 times. A ring marks errors "
    "that may be the smallest on another log: their order turns in more than one of twenty redraws. Open bars are "
    "models without an inverse, which cannot become a compensator."
)


_SIZES = (
    "On the right the same errors over the number of parameters: a smaller model usually takes less time on a target. "
    "The line joins the best of each size among those that a target can run; crosses run in Python only."
)


def comparison_figures(comparison: Comparison) -> tuple[PageFigure, ...]:
    """Return the pictures: errors of all families; the loop with the best one and what identify chooses."""
    rival = _beside(comparison)
    caption = "Samples that no fit has seen, with the best family and what identify chooses (or the next one)."
    panels = (_errors(comparison), _sizes(comparison))
    return numbered(
        (
            PageFigure("families", "Every family on this log", f"{_ERRORS} {_SIZES}", panels),
            PageFigure("loop", "The loop, held out", caption, _loops(comparison, rival)),
        )
    )


def _beside(comparison: Comparison) -> ComparedFamily:
    """What is drawn beside the best one: what identify chooses, or the next one if that is the best."""
    if comparison.chosen.family != comparison.auto.family:
        return comparison.auto_entry
    for entry in comparison.rows[1:]:
        if entry.model is not None:
            return entry
    return comparison.chosen


def _errors(comparison: Comparison) -> Panel:
    """A bar for the error of each family that could be identified, the best one first."""
    shown = _identified(comparison)
    error = np.array([entry.error_percent for entry in shown])
    # Bars that are many times longer than the best one would leave no room for it.
    edge = min(float(error.max()), max(CUT * float(error.min()), 1e-12)) or 1.0
    rows, words = [], []
    for k, entry in enumerate(shown):
        colour = OTHER
        if k == 0:
            colour = TRAIN
        elif entry.family == "static":
            colour = STATIC
        bar = Bar(
            entry.family,
            entry.error_percent,
            colour,
            f"{number(entry.error_percent)} %",
            interval=entry.interval_percent,
            hollow=not entry.invertible,
            ringed=entry.tied and k > 0,
        )
        rows.append(bar)
        words.append(f"{entry.family} {entry.error_percent:.3g} %")
    draw = bars(rows, "RMS error on held-out loops [% of range]", edge=edge, beside=True)
    height = bar_heights(len(shown), beside=True)
    return Panel("Error on held-out loops", draw, f"Bars: {', '.join(words)}.", height)


def _sizes(comparison: Comparison) -> Panel:
    """Error of each family over its number of parameters, both logarithmic, with the front of those to be exported."""
    shown = [entry for entry in _identified(comparison) if entry.error_percent > 0.0]
    front = [entry for entry in comparison.front if entry.error_percent > 0.0]

    def draw(axes: Axes) -> None:
        for entry in shown:
            marker = "o" if entry.exportable else "x"
            axes.plot(entry.parameters, entry.error_percent, marker, ms=5.0, color=OTHER.light)
        sizes = [entry.parameters for entry in front]
        errors = [entry.error_percent for entry in front]
        axes.step(sizes, errors, where="post", color=TRAIN.light, lw=1.2)
        axes.plot(sizes, errors, "o", ms=6.0, color=TRAIN.light)
        for entry in front:
            axes.annotate(
                entry.family,
                (entry.parameters, entry.error_percent),
                xytext=(5.0, 4.0),
                textcoords="offset points",
                fontsize=8.0,
            )
        axes.set_xscale("log")
        axes.set_yscale("log")
        axes.margins(x=0.15, y=0.12)
        for axis in (axes.xaxis, axes.yaxis):
            axis.set_major_formatter(lambda value, _: f"{value:g}")
            axis.set_minor_formatter(lambda *_: "")
        axes.set_xlabel("parameters")
        axes.set_title("RMS error [% of range], x: Python only", color=INK.light)

    words = ", ".join(
        f"{entry.family} {entry.parameters} with {entry.error_percent:.3g} %" for entry in front
    )
    height = bar_heights(len(_identified(comparison)), beside=True)
    return Panel("Error over size", draw, f"Front: {words}.", height)


def _loops(comparison: Comparison, rival: ComparedFamily) -> tuple[Panel, Panel]:
    """Error over the input, and the loop, of the recording with the most samples held out."""
    k = int(np.argmax(list(map(np.count_nonzero, comparison.masks))))
    record, mask = comparison.recordings[k], comparison.masks[k]
    x, y = record.input, record.output
    lines = [PanelLine(x, y, DATA, "measured", 2.6, 0.6, mask=mask, breaks=record.breaks)]
    errors = []
    for entry, token in ((rival, TEST), (comparison.chosen, MODEL)):
        if entry.fit is None:
            continue
        line = PanelLine(
            x, entry.fit.predictions[k], token, entry.family, 0.9, mask=mask, breaks=record.breaks
        )
        # Over a long log the model is an outline, or it would hide the measured loop below it.
        lines.append(replace(line, outline=True, order=3.0))
        errors.append(replace(line, y=line.y - y))
    up = f"model less measured{bracketed(record.output_unit)}"
    words = f"{comparison.chosen.family} and {rival.family}"
    return (
        Panel(
            "Error over the input",
            chart(record.input_label, up, errors, zero=True),
            f"Error of {words} over the input.",
        ),
        Panel(
            "Output over input", chart(record.input_label, record.output_label, lines), f"{words}."
        ),
    )


HEAD = (
    "family",
    "held out [%]",
    "interval [%]",
    "fitted [%]",
    "inverse [%]",
    "parameters",
    "fit [s]",
    "inverse exists",
    "exported",
    "start",
    "seed",
)


def _table(comparison: Comparison) -> PageTable:
    """All families."""
    rows = tuple(map(_row, _identified(comparison)))
    note = (
        "* as good as the best, within the doubt that the interval shows: 90 % of the errors if other samples were "
        "held out, ten parts of them drawn anew 2000 times. Percent of the output's range, for the inverse of the "
        "input's."
    )
    title = f"{len(rows)} families"
    if len(rows) == 1:
        title = "1 family"
    return PageTable(title, HEAD, rows, note)


def _identified(comparison: Comparison) -> list[ComparedFamily]:
    """Families that have a model, the best one first; the notes say why the others have none."""
    return [entry for entry in comparison.rows if entry.model is not None]


def _row(entry: ComparedFamily) -> tuple[str, ...]:
    """A family in the table, under `HEAD`."""
    name, inverse, seed = entry.family, "", ""
    exported = "no: Python only"
    if entry.tied:
        name += " *"
    if entry.inverse_percent is not None:
        inverse = number(entry.inverse_percent)
    if entry.seed is not None:
        seed = str(entry.seed)
    if entry.exportable:
        exported = "yes"
    redraws = ""
    if entry.interval_percent is not None:
        low, high = entry.interval_percent
        redraws = f"{number(low)} to {number(high)}"
    return (
        name,
        _percent(entry.test),
        redraws,
        _percent(entry.train),
        inverse,
        str(entry.parameters),
        f"{entry.seconds:.2f}",
        YES_NO[entry.invertible],
        exported,
        entry.start,
        seed,
    )


def _percent(score: Score | None) -> str:
    """Error of a score, "" where there is none."""
    if score is None:
        return ""
    return number(score.rmse_percent)
