"""Draws a recording or a result into matplotlib axes of one's own, and as HTML where a notebook shows it."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping
from html import escape
from typing import Any

from dehyst.data.recording import Recording
from dehyst.errors import ParameterError
from dehyst.families import Comparison
from dehyst.identification.fit import Fit
from dehyst.monitoring import Drift
from dehyst.report.compare import comparison_figures
from dehyst.report.drawing import Line, break_times, chart, time_of
from dehyst.report.drift import drift_figures
from dehyst.report.figures.loops import loop_figure
from dehyst.report.parts import Axes, Figure, Panel
from dehyst.report.svg import panel_svg
from dehyst.report.text import short
from dehyst.report.theme import FIFTH, PAPER, TRAIN, settings, style, variables


def _recording(rec: Recording) -> Figure:
    t, across = time_of(rec)
    loop = chart(rec.input_label, rec.output_label, [Line(rec.input, rec.output, TRAIN, width=1.0, breaks=rec.breaks)])
    rows = tuple(
        chart(across, label, [Line(t, y, token, breaks=rec.breaks)], marks=break_times(rec, t))
        for y, label, token in ((rec.output, rec.output_label, TRAIN), (rec.input, rec.input_label, FIFTH))
    )
    said = f"{rec.output_label} and {rec.input_label}"
    panels = (Panel("Output over input", loop, said), Panel("Over time", rows, said, heights=(1.2, 1.2)))
    return Figure("recording", rec.name, "", panels)


# What shows each kind of object; the first panel is the one that `plot` draws. Others offer `_figure()`.
FIGURES: Mapping[type, Callable[[Any], Figure]] = {
    Recording: _recording,
    Fit: loop_figure,
    Comparison: lambda found: comparison_figures(found)[0],
    Drift: lambda found: drift_figures(found)[0],
}

_SHOWN = itertools.count()  # names of pictures, which a page must not hold twice


def figure_of(thing: object) -> Figure:
    """Return the figure that shows an object.

    Raises
    ------
    ParameterError
        If there is none for it.
    """
    found: Callable[[Any], Figure] | None = FIGURES.get(type(thing)) or getattr(type(thing), "_figure", None)
    if found is None:
        raise ParameterError(
            f"a {type(thing).__name__} has no picture. What can be drawn: a Recording, the Fit of identify, a "
            f"Comparison, a Drift and the run of a trial."
        )
    return found(thing)


def plot(thing: object, ax: Axes = None) -> Axes:
    """Draw what an object has to show: the loop, or the errors of the families.

    Parameters
    ----------
    thing
        A `Recording`, the `Fit` of identify, a `Comparison`, a `Drift` or the run of a trial.
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
        ax = figure.subplots() if ax is None else ax
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
    drawn = "".join(
        f'<div style="flex:1 1 20em;max-width:34em">{panel_svg(panel, f"{figure.key}{shown}-{k}")}</div>'
        for k, panel in enumerate(figure.panels)
    )
    said = getattr(thing, "verdict", "") or getattr(thing, "name", "") or type(thing).__name__
    look = f"{variables(dark=False)}background: {PAPER.light}; color: var(--ink); padding: 0.5em; font: 14px sans-serif"
    flex = "display:flex;flex-wrap:wrap"
    return f'<div style="{look}"><p>{escape(short(said, 400))}</p><div style="{flex}">{drawn}</div></div>'
