"""A comparison of families -> one picture, and one self-contained HTML page."""

from __future__ import annotations

import os
from functools import partial
from pathlib import Path

import numpy as np

from dehyst.families.comparison import POOR, Comparison
from dehyst.families.fitting import FamilyFit
from dehyst.files import write_atomically
from dehyst.findings import Grade
from dehyst.identification.certify import GOOD_PERCENT
from dehyst.identification.fit import Score
from dehyst.report.figures.panel import Axes, Figure, Panel, add_legend, draw_path, label_axes, path_of, says
from dehyst.report.rendering import Sheet, sheet_page
from dehyst.report.svg import write_picture
from dehyst.report.tables import Table
from dehyst.report.text import number, short
from dehyst.report.theme import DATA, INK, MODEL, MUTED, OTHER, STATIC, TEST, TRAIN
from dehyst.report.thin import Window

TITLE = "dehyst compare: "  # by which a picture is known that may be drawn anew
# Bars longer than this many times the error of the best one are cut.
CUT = 8.0
BARS = 12  # that fill a panel of the usual height


def write_comparison_report(found: Comparison, path: str | os.PathLike[str]) -> Path:
    """Write the page of a comparison: one HTML file that needs nothing else and runs nothing.

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
    return write_atomically(path, comparison_page(found))


def write_comparison_figure(found: Comparison, path: str | os.PathLike[str]) -> Path:
    """Write the picture of a comparison, ``.svg`` or ``.png``.

    Raises
    ------
    OutputError
        If the file cannot be written or has another ending.
    """
    names = short(", ".join(record.name for record in found.recordings), 60)
    return write_picture(comparison_figures(found)[0], path, f"{TITLE}{names}")


def comparison_page(found: Comparison) -> str:
    """Return the text of the page."""
    first = found.recordings[0]
    return sheet_page(
        Sheet(
            kind="Which model for this loop?",
            title=short(", ".join(record.name for record in found.recordings), 80),
            relation=f"{short(first.input_label, 60)} → {short(first.output_label, 60)}",
            subject="families",
            badge=found.chosen.family,
            grade=grade_of_comparison(found),
            lead=found.verdict,
            figures=comparison_figures(found),
            warnings=found.auto.warnings,
            warnings_of=f"Warnings of identify, whose choice is {found.auto.family}",
            tables=tables_of(found),
            notes=found.notes,
        )
    )


def grade_of_comparison(found: Comparison) -> Grade:
    """Good where the best family follows the loop and can be inverted, bad where none does."""
    error = found.chosen.error_percent
    if error > POOR:
        return Grade.BAD
    return Grade.GOOD if error <= GOOD_PERCENT and found.chosen.invertible else Grade.CARE


def comparison_figures(found: Comparison) -> tuple[Figure, ...]:
    """Return the pictures: errors of all families; the loop with the best one and what identify chooses."""
    rival = _beside(found)
    loop = Panel(
        "Output over input", partial(_draw_loop, found, rival), says(f"{found.chosen.family} and {rival.family}.")
    )
    caption = "Samples that no fit has seen, with the best family and what identify chooses (or the next one)."
    return (
        Figure("families", "Every family on this log", _ERRORS, (_errors(found), _misses(found, rival))),
        Figure("loop", "The loop, held out", caption, (loop,)),
    )


_ERRORS = (
    "RMS error of the output on samples that no fit has seen, percent of its range. A ring marks errors that differ "
    "from the smallest one by less than the scatter between parts of the held-out samples: another log may turn their "
    "order. Open bars are models without an inverse, which cannot become a compensator."
)


def _errors(found: Comparison) -> Panel:
    shown = [entry for entry in found.entries if entry.model is not None]
    words = ", ".join(f"{entry.family} {entry.error_percent:.3g} %" for entry in shown)
    tall = max(1.0, len(shown) / BARS)
    return Panel("Error on held-out loops", partial(_draw_errors, shown), says(f"Bars: {words}."), tall)


def _misses(found: Comparison, rival: FamilyFit) -> Panel:
    words = says(f"Error of {found.chosen.family} and {rival.family} over the input.")
    return Panel("Error over the input", partial(_draw_misses, found, rival), words)


def _beside(found: Comparison) -> FamilyFit:
    """What is drawn beside the best one: what identify chooses, or the next one if that is the best."""
    if found.chosen.family != found.auto.family:
        return found.auto_entry
    others = [entry for entry in found.entries[1:] if entry.model is not None]
    return others[0] if others else found.chosen


def _draw_errors(shown: list[FamilyFit], axes: Axes) -> None:
    place = np.arange(len(shown))
    error = np.array([entry.error_percent for entry in shown])
    edge = min(float(error.max()), max(CUT * float(error.min()), 1e-12)) or 1.0
    for k, entry in enumerate(shown):
        colour = TRAIN.light if k == 0 else STATIC.light if entry.family == "static" else OTHER.light
        face = colour if entry.invertible else "none"
        axes.barh([k], [min(error[k], edge)], height=0.62, color=face, edgecolor=colour, linewidth=1.2, zorder=2)
        if entry.tied and k:
            axes.plot([min(error[k], edge)], [k], "o", mfc="none", mec=INK.light, ms=6.0, mew=1.0, zorder=3)
        if error[k] > edge:
            axes.plot([edge * 1.015], [k], marker=">", markersize=7.0, color=colour, ls="none", zorder=2)
        where = min(error[k], edge) + edge * 0.05
        axes.text(where, k, f"{number(error[k])} %", va="center", fontsize=8.0, color=MUTED.light)
    axes.set_yticks(place, [entry.family for entry in shown], fontsize=8.5)
    axes.set_ylim(len(shown) - 0.4, -0.6)
    axes.set_xlim(0.0, edge * 1.25)
    axes.grid(visible=False, axis="y")
    axes.spines["left"].set_visible(False)
    axes.set_xlabel("RMS error on held-out loops [% of range]")


def _draw_loop(found: Comparison, rival: FamilyFit, axes: Axes) -> None:
    k = int(np.argmax([mask.sum() for mask in found.masks]))
    record, mask = found.recordings[k], found.masks[k]
    x, y = record.input, record.output
    drawn = [(entry, token) for entry, token in ((found.chosen, MODEL), (rival, TEST)) if entry.predictions]
    window = Window.around((x[mask], y[mask]), *((x[mask], entry.predictions[k][mask]) for entry, _ in drawn))
    label_axes(axes, window, record.input_label, record.output_label)
    path = path_of(record, x)
    draw_path(axes, path, path_of(record, y, mask), window, DATA, label="measured", width=2.6, alpha=0.6)
    for entry, token in reversed(drawn):
        line = path_of(record, entry.predictions[k], mask)
        draw_path(axes, path, line, window, token, label=entry.family, width=0.9, outline=True, order=3)
    add_legend(axes)


def _draw_misses(found: Comparison, rival: FamilyFit, axes: Axes) -> None:
    k = int(np.argmax([mask.sum() for mask in found.masks]))
    record, mask = found.recordings[k], found.masks[k]
    drawn = [(entry, token) for entry, token in ((rival, TEST), (found.chosen, MODEL)) if entry.predictions]
    missed = [entry.predictions[k] - record.output for entry, _ in drawn]
    window = Window.around((record.input[:1], np.zeros(1)), *((record.input[mask], miss[mask]) for miss in missed))
    unit = f" [{record.output_unit}]" if record.output_unit else ""
    label_axes(axes, window, record.input_label, f"model less measured{unit}")
    axes.axhline(0.0, color=MUTED.light, lw=0.8, zorder=1)
    for (entry, token), miss in zip(drawn, missed, strict=True):
        path = path_of(record, miss, mask)
        draw_path(axes, path_of(record, record.input), path, window, token, label=entry.family, width=0.9)
    add_legend(axes)


HEAD = (
    "family",
    "held out [%]",
    "fitted [%]",
    "inverse [%]",
    "parameters",
    "fit [s]",
    "inverse exists",
    "start",
    "seed",
)


def tables_of(found: Comparison) -> tuple[Table, ...]:
    """Return the table of all families."""
    rows = tuple(
        (
            f"{entry.family}{' *' if entry.tied else ''}",
            _percent(entry.test),
            _percent(entry.train),
            "" if entry.inverse_percent is None else number(entry.inverse_percent),
            str(entry.parameters),
            f"{entry.seconds:.2f}",
            "yes" if entry.invertible else "no",
            entry.start,
            "" if entry.seed is None else str(entry.seed),
        )
        for entry in found.entries
        if entry.model is not None
    )
    note = "* within noise of the best. Percent of the output's range, for the inverse of the input's."
    return (Table(f"{len(rows)} {'family' if len(rows) == 1 else 'families'}", HEAD, rows, note),)


def _percent(score: Score | None) -> str:
    return "" if score is None else number(score.rmse_percent)
