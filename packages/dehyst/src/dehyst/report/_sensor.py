"""The picture and the page of `dehyst sensor`: deviation from the line, with each figure where it is measured."""

from __future__ import annotations

import os
from functools import partial
from pathlib import Path

import numpy as np

from dehyst.arrays import Array
from dehyst.data import kit as data_kit
from dehyst.report._drawing import DASHED, PanelLine, chart, double_arrow
from dehyst.report._page import write_page
from dehyst.report._parts import Axes, Page, PageFigure, PageSection, PageTable, Panel
from dehyst.report._svg import write_picture
from dehyst.report._text import short
from dehyst.report._theme import BAD, FIFTH, MODEL, MUTED, PAPER, TEST, TRAIN, ThemeColour

SENSOR = "dehyst sensor: "  # by which a picture is known that may be drawn anew
ROOM = 0.12  # above and below the curves, share of their range
ASIDE = 0.006  # of the range: arrows at one place stand beside each other


def write_data_sheet(
    sheet: data_kit.DataSheet,
    path: str | os.PathLike[str],
    corrected: data_kit.DataSheet | None = None,
) -> Path:
    """Write the picture of a data sheet, ``.svg`` or ``.png``, or a page with its tables, ``.html``.

    Parameters
    ----------
    sheet
        Result of `dehyst.data.sensor_data_sheet`.
    path
        File to write.
    corrected
        That of the corrected reading, to be drawn beside it.

    Raises
    ------
    OutputError
        If the file cannot be written or has another ending.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> import numpy as np
    >>> from dehyst.data import Recording, sensor_data_sheet
    >>> x = 1.0 - np.cos(np.linspace(0.0, 20.0, 2000))
    >>> sheet = sensor_data_sheet(Recording(2.0 * x + 0.01 * x**2, x))
    >>> path = write_data_sheet(sheet, pathlib.Path(tempfile.mkdtemp()) / "sheet.svg")
    >>> path.read_text(encoding="utf-8").count("non-linearity") > 0
    True
    """
    panels = list(sheet_figure(sheet).panels)
    if corrected is not None:
        panels += sheet_figure(corrected).panels
    figure = PageFigure(
        "sensor", "Data sheet of the sensor", sheet.caption, tuple(panels), width=6.4
    )
    if Path(path).suffix.lower() == ".html":
        return write_page(_page(sheet, corrected, figure), path)
    return write_picture(figure, path, f"{SENSOR}{short(sheet.name, 60)}", headed=True)


def sheet_figure(sheet: data_kit.DataSheet) -> PageFigure:
    """Return the deviation from the line over the quantity, both directions, with the figures in it."""
    lines = []
    rising, falling = sheet.deviation(sheet.mean)
    for curves, mean, colour, word in (
        (sheet.rising, rising, TRAIN, "rising"),
        (sheet.falling, falling, TEST, "falling"),
    ):
        if not len(curves):
            continue
        for deviation in sheet.deviation(curves):
            lines.append(PanelLine(sheet.places, deviation, colour, width=0.7, alpha=0.45))
        lines.append(PanelLine(sheet.places, mean, colour, f"{word}, mean", 1.8))
    if len(sheet.rising) and len(sheet.falling):
        middle = 0.5 * (rising + falling)
        lines.append(PanelLine(sheet.places, middle, MUTED, "mean of both", 1.4, dashes=DASHED))
    every = np.concatenate([line.y for line in lines])
    low, high = float(np.min(every)), float(np.max(every))
    if sheet.holds.size:
        ends = sheet.holds[:, 1:]
        low, high = min(low, float(np.min(ends))), max(high, float(np.max(ends)))
    room = ROOM * (high - low)
    panel = Panel(
        f"{short(sheet.reading_name, 40)}: deviation from the {sheet.line_name} line",
        chart(
            sheet.quantity_label,
            "deviation [% FS]",
            lines,
            zero=True,
            include=(low - room, high + room),
            also=partial(_annotate, sheet),
        ),
        f"{sheet.reading_label} over {sheet.quantity_label}: {sheet.words}.",
        heights=(4.0,),
    )
    return PageFigure("sensor", "Data sheet of the sensor", sheet.caption, (panel,), width=6.4)


def _annotate(sheet: data_kit.DataSheet, axes: Axes) -> None:
    """Draw the figures into the axes: each between what it is the difference of."""
    rising, falling = sheet.deviation(sheet.mean)

    def at(curve: Array, place: float) -> float:
        return float(np.interp(place, sheet.places, curve))

    if sheet.line_name == "terminal":
        place = sheet.figures["terminal"].place
        middle = np.nanmean([at(rising, place), at(falling, place)])
        _arrow(sheet, axes, "terminal", (0.0, float(middle)), MODEL)
    if not sheet.figures["hysteresis"].why:
        place = sheet.figures["hysteresis"].place
        _arrow(sheet, axes, "hysteresis", (at(rising, place), at(falling, place)), FIFTH)
    figure = sheet.figures["repeatability"]
    if not figure.why:
        curves = {"rising": sheet.rising, "falling": sheet.falling}[figure.direction]
        values = [at(curve, figure.place) for curve in sheet.deviation(curves)]
        _arrow(sheet, axes, "repeatability", (min(values), max(values)), BAD)
    for level, first, last in sheet.holds.tolist():
        axes.plot([level, level], [first, last], color=MODEL.light, lw=2.4, zorder=4)
        axes.plot([level], [last], "o", color=MODEL.light, ms=3.5, mew=0.0, zorder=5)
    for name in ("creep_upper", "creep_lower"):
        figure = sheet.figures[name]
        if not figure.why:
            nearest = np.argmin(np.abs(sheet.holds[:, 0] - figure.place))
            _label(
                sheet, axes, f"creep {figure.value}", (figure.place, sheet.holds[nearest, 2]), MODEL
            )


def _arrow(
    sheet: data_kit.DataSheet, axes: Axes, name: str, ends: tuple[float, float], colour: ThemeColour
) -> None:
    figure = sheet.figures[name]
    order = ("terminal", "hysteresis", "repeatability").index(name) - 1
    place = figure.place + order * ASIDE * (sheet.high - sheet.low)
    double_arrow(axes, (place, ends[0]), (place, ends[1]), colour)
    words = f"{data_kit.label_of(name).partition(',')[0]} {figure.value}".replace("+-", "±")
    _label(sheet, axes, words, (place, 0.5 * (ends[0] + ends[1])), colour)


def _label(
    sheet: data_kit.DataSheet,
    axes: Axes,
    words: str,
    place: tuple[float, float],
    colour: ThemeColour,
) -> None:
    """Name beside a place, towards the middle of the axes."""
    shift, across = 6, "left"
    if place[0] > 0.5 * (sheet.low + sheet.high):
        shift, across = -6, "right"
    axes.annotate(
        words.replace("+-", "±"),
        place,
        (shift, 0),
        textcoords="offset points",
        ha=across,
        va="center",
        fontsize=9,
        color=colour.light,
        zorder=6,
        bbox={"facecolor": PAPER.light, "alpha": 0.75, "edgecolor": "none", "pad": 1.0},
    )


def _page(
    sheet: data_kit.DataSheet, corrected: data_kit.DataSheet | None, figure: PageFigure
) -> Page:
    tables = [_table(sheet)]
    if corrected is not None:
        tables.append(_table(corrected))
    return Page(
        kind="Data sheet of a sensor",
        title=short(sheet.name, 80),
        relation=f"{short(sheet.reading_name, 60)} → {short(sheet.quantity_name, 60)}",
        subject="sensor",
        lead=sheet.words.replace("+-", "±"),
        sections=(figure, PageSection("tables", "Tables", tuple(tables))),
    )


def _table(sheet: data_kit.DataSheet) -> PageTable:
    rows = []
    for label, value, worst, where in sheet.rows:
        rows.append((label, value.replace("+-", "±"), worst, where))
    return PageTable(
        sheet.reading_name,
        ("figure", "mean of cycles", "worst (cycle)", "where"),
        tuple(rows),
        ". ".join([sheet.basis, *sheet.lacking, *sheet.notes]) + ".",
        words=True,
    )
