"""Draws a recording or a result into matplotlib axes of one's own, and as HTML where a notebook shows it."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping
from html import escape
from typing import Any

from dehyst.data import Loops, Recording
from dehyst.data import kit as data_kit
from dehyst.errors import ParameterError
from dehyst.identification import Comparison, Fit
from dehyst.monitoring import Drift
from dehyst.report._compare import comparison_figures
from dehyst.report._drawing import PanelLine, break_times, chart, time_of
from dehyst.report._drift import drift_figures
from dehyst.report._figures.loops import loop_figure
from dehyst.report._loops import loops_figure
from dehyst.report._parts import Axes, PageFigure, Panel
from dehyst.report._sensor import sheet_figure
from dehyst.report._svg import panel_svg
from dehyst.report._text import short
from dehyst.report._theme import FIFTH, PAPER, TRAIN, settings, style, variables


def _recording(rec: Recording) -> PageFigure:
    t, across = time_of(rec)
    loop = chart(
        rec.input_label,
        rec.output_label,
        [PanelLine(rec.input, rec.output, TRAIN, width=1.0, breaks=rec.breaks)],
    )
    # The output stands above the input, as in the loop beside them.
    rows = []
    for y, label, token in (
        (rec.output, rec.output_label, TRAIN),
        (rec.input, rec.input_label, FIFTH),
    ):
        line = PanelLine(t, y, token, breaks=rec.breaks)
        rows.append(chart(across, label, [line], marks=break_times(rec, t)))
    caption = f"{rec.output_label} and {rec.input_label}"
    panels = (
        Panel("Output over input", loop, caption),
        Panel("Over time", tuple(rows), caption, heights=(1.2, 1.2)),
    )
    return PageFigure("recording", rec.name, "", panels)


# What shows each kind of object; the first panel is the one that `plot` draws. Others offer `_figure()`.
FIGURES: Mapping[type, Callable[[Any], PageFigure]] = {
    Recording: _recording,
    Loops: loops_figure,
    data_kit.DataSheet: sheet_figure,
    Fit: loop_figure,
    Comparison: lambda comparison: comparison_figures(comparison)[0],
    Drift: lambda drift: drift_figures(drift)[0],
}

_SHOWN = itertools.count()  # names of pictures, which a page must not hold twice


def figure_of(thing: object) -> PageFigure:
    """Return the figure that shows an object.

    Raises
    ------
    ParameterError
        If there is none for it.
    """
    draw: Callable[[Any], PageFigure] | None = FIGURES.get(type(thing)) or getattr(
        type(thing), "_figure", None
    )
    if draw is None:
        raise ParameterError(
            f"a {type(thing).__name__} has no picture. What can be drawn: a Recording, its Loops, a data sheet, the "
            f"Fit of identify, a Comparison, a Drift and the run of a trial."
        )
    return draw(thing)


def plot(thing: object, ax: Axes = None) -> Axes:
    """Draw what an object has to show: the loop, or the errors of the families.

    Parameters
    ----------
    thing
        A `Recording`, its `Loops`, the data sheet of a sensor, the `Fit` of identify, a `Comparison`, a `Drift` or the
        run of a trial.
    ax
        Matplotlib axes to draw into; None: a new figure.

    Returns
    -------
    ax
        The axes, to add to or to save: ``ax.figure.savefig("loop.png")``.

    Raises
    ------
    ParameterError
        If there is no picture of such an object.

    Examples
    --------
    >>> import dehyst
    >>> from dehyst.io import example_recording
    >>> ax = dehyst.plot(example_recording())
    >>> ax.get_xlabel(), ax.get_title(loc="left")
    ('pressure_difference [bar]', 'angle [deg]')
    """
    panel = figure_of(thing).panels[0]
    if ax is None:
        import matplotlib.pyplot as pyplot

        # Outside the settings: their end would take back what the first figure of a notebook sets for the next ones.
        figure = pyplot.figure(layout="constrained")
    with settings(style()):
        if ax is None:
            ax = figure.subplots()
        panel.rows[0](ax)
        if panel.legend and ax.get_legend_handles_labels()[1]:
            ax.legend(loc="best")
    return ax


def as_html(thing: object) -> str:
    """Return what a notebook shows of an object: its verdict, and its panels side by side as SVG.

    Parameters and errors are those of `plot`.

    Examples
    --------
    >>> from dehyst.io import example_recording
    >>> "<svg" in as_html(example_recording())
    True
    """
    figure, shown = figure_of(thing), next(_SHOWN)
    drawn = ""
    for k, panel in enumerate(figure.panels):
        # Ids in a notebook must differ between its cells, or one picture would use parts of another.
        picture = panel_svg(panel, f"{figure.key}{shown}-{k}")
        drawn += f'<div style="flex:1 1 20em;max-width:34em">{picture}</div>'
    caption = getattr(thing, "verdict", "") or getattr(thing, "name", "") or type(thing).__name__
    look = f"{variables(dark=False)}background: {PAPER.light}; color: var(--ink); padding: 0.5em; font: 14px sans-serif"
    flex = "display:flex;flex-wrap:wrap"
    return f'<div style="{look}"><p>{escape(short(caption, 400))}</p><div style="{flex}">{drawn}</div></div>'
