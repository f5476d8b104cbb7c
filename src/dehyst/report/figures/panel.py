"""What a figure is: a few panels with a caption; and how measured and modelled paths are drawn into a panel."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from dehyst.arrays import Array, Mask
from dehyst.data.recording import Recording
from dehyst.report.tables import Table
from dehyst.report.text import power_of_ten, short, width
from dehyst.report.theme import INK, Token
from dehyst.report.thin import Window, interrupted, occupancy, thin_path, thin_series
from dehyst.shell import visible_lines as clean

# matplotlib's classes carry no types; an Axes is what a panel draws into.
Axes = Any

LABEL_LENGTH = 46
# Axes whose largest value lies in this range are labelled as they are, others in powers of ten.
PLAIN = (1e-2, 1e5)
# Letters in a row of a legend, and how many of them the sample line of an entry takes.
LEGEND_WIDTH, LEGEND_KEY = 56, 5
# A clock that starts later than this many lengths of the log is set to zero at its first sample.
FAR_AWAY = 20.0
# matplotlib leaves this one out of the legend: one entry for several recordings drawn alike.
NO_LABEL = "_nolegend_"


@dataclass(frozen=True, slots=True)
class Panel:
    """One pair of axes.

    Attributes
    ----------
    title
        What the panel shows, a few words.
    draw
        Draws it into matplotlib axes.
    alt
        What a reader who cannot see it should know.
    tall
        Height, 1 for the usual one.
    """

    title: str
    draw: Callable[[Axes], None]
    alt: str
    tall: float = 1.0


@dataclass(frozen=True, slots=True)
class Figure:
    """A numbered figure of the report.

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
        Small table below the panels, or None.
    points
        Sentences beside the panels: what follows from them.
    """

    key: str
    title: str
    caption: str
    panels: tuple[Panel, ...]
    formula: str = ""
    table: Table | None = None
    points: tuple[str, ...] = ()


def label_axes(axes: Axes, window: Window, across: str, up: str) -> None:
    """Set range and ticks of a panel and name both axes with their units.

    The upper name reads horizontally, above its axis. Very large or small values are labelled in powers of ten, which
    stand with the unit: "force [10³ N]".
    """
    axes.set_xlim(window.x_low, window.x_high)
    axes.set_ylim(window.y_low, window.y_high)
    axes.locator_params(axis="both", nbins=6)
    axes.set_xlabel(_scaled(axes.xaxis, across, window.x_low, window.x_high))
    axes.set_title(_scaled(axes.yaxis, up, window.y_low, window.y_high), color=INK.light)


def _scaled(axis: Any, label: str, low: float, high: float) -> str:
    largest = max(abs(low), abs(high))
    if largest == 0.0 or PLAIN[0] <= largest < PLAIN[1]:
        return short(label, LABEL_LENGTH)
    exponent = 3 * math.floor(math.log10(largest) / 3)
    axis.set_major_formatter(lambda value, _: f"{value / 10.0**exponent:.6g}".replace("-", "−"))
    factor = power_of_ten(exponent)
    head, bracket, unit = label.rpartition(" [")
    if not bracket:
        return f"{short(label, LABEL_LENGTH - 6)} [{factor}]"
    return f"{short(head, LABEL_LENGTH - 12)} [{factor} {short(unit, 16)}"


def legend_label(text: str) -> str:
    """Return a legend entry; matplotlib would hide one that begins with an underscore."""
    if text is NO_LABEL:
        return text
    line = short(text, 40)
    return f"\u00a0{line}" if line.startswith("_") else line


def draw_path(
    axes: Axes,
    x: Array,
    y: Array,
    window: Window,
    token: Token,
    *,
    label: str,
    width: float = 1.3,
    alpha: float = 1.0,
    outline: bool = False,
    dashes: str | tuple[float, tuple[float, ...]] = "solid",
    order: float = 2.0,
) -> None:
    """Draw samples in time order; as the area they visit when there are too many for a line.

    With `outline` such an area is drawn as its border only, so that it can lie over another one.
    """
    path = thin_path(x, y, window)
    if path is not None:
        axes.plot(*path, color=token.light, lw=width, ls=dashes, alpha=alpha, label=legend_label(label), zorder=order)
        return
    columns, rows, visited = occupancy(x, y, window)
    if outline:
        axes.contour(columns, rows, visited, levels=[0.5], colors=[token.light], linewidths=0.7, zorder=order)
    else:
        fill = {"colors": [token.light], "alpha": 0.8 * alpha, "zorder": order}
        axes.contourf(columns, rows, visited, levels=[0.5, 2.0], **fill)
    shown = width if outline else 3.0
    axes.plot([], [], color=token.light, lw=shown, alpha=alpha, ls=dashes, label=legend_label(label))


def draw_series(
    axes: Axes,
    t: Array,
    y: Array,
    token: Token,
    *,
    label: str,
    width: float = 1.1,
    dashes: str | tuple[float, tuple[float, ...]] = "solid",
    order: float = 2.0,
) -> None:
    """Draw a series over time, extremes of every stretch kept."""
    kept = thin_series(y)
    axes.plot(t[kept], y[kept], color=token.light, lw=width, ls=dashes, label=legend_label(label), zorder=order)


def add_legend(axes: Axes) -> None:
    """Put the legend above the panel, over nothing, in as many columns as fit."""
    handles, labels = axes.get_legend_handles_labels()
    if not handles:
        return
    columns = next((n for n in range(len(labels), 1, -1) if _legend_width(labels, n) <= LEGEND_WIDTH), 1)
    legend = axes.legend(
        handles, labels, loc="lower left", bbox_to_anchor=(0.0, 1.115), ncols=columns, labelcolor=INK.light
    )
    for handle in legend.legend_handles:
        if handle is not None and hasattr(handle, "set_linewidth"):
            handle.set_linewidth(max(1.6, handle.get_linewidth()))


def _legend_width(labels: list[str], columns: int) -> int:
    """Letters across a legend that is filled column by column, the first columns one longer."""
    held = (chunk.tolist() for chunk in np.array_split(np.array([width(label) for label in labels]), columns))
    return sum(max(widths) + LEGEND_KEY for widths in held)


def path_of(recording: Recording, signal: Array, mask: Mask | None = None) -> Array:
    """Return a signal of a recording as a path that is interrupted at its breaks and outside a mask."""
    return interrupted(signal, recording.breaks, mask)


def time_of(recording: Recording) -> tuple[Array, str]:
    """Return abscissa and label of a recording: time, or sample numbers when there is none."""
    t = recording.time
    if t is None:
        return np.arange(len(recording), dtype=np.float64), "sample number"
    if abs(float(t[0])) > FAR_AWAY * float(np.ptp(t)):  # seconds since 1970, say: the axis would show one number
        return t - t[0], "time since the first sample [s]"
    return t, "time [s]"


def break_times(recording: Recording, t: Array) -> Array:
    """Return where the memory was interrupted, (m,): the first sample after each break."""
    return t[list(recording.breaks)] if recording.breaks else np.zeros(0)


def says(*parts: str) -> str:
    """Join sentences to an alternative text."""
    return clean(" ".join(part.strip() for part in parts if part))
