"""Draws panels: line charts of signals and loops, horizontal bars, stems, logarithmic axes."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from dehyst.arrays import Array, Mask
from dehyst.data.recording import Recording
from dehyst.report.parts import HEIGHT, Axes, Draw
from dehyst.report.text import number, power_of_ten, short
from dehyst.report.theme import BAD, GRID, INK, MUTED, Token
from dehyst.report.thin import Window, interrupted, joined, occupancy, thin_path, thin_series

LABEL_LENGTH = 46
# Axes whose largest value lies in this range are labelled as they are, others in powers of ten.
PLAIN = (1e-2, 1e5)
# A clock that starts later than this many lengths of the log is set to zero at its first sample.
FAR_AWAY = 20.0
MARKS = 100  # of interruptions, at most
DASHED = (0.0, (5.0, 3.0))
NO_LABEL = "_nolegend_"  # matplotlib leaves this one out of the legend

Dashes = str | tuple[float, tuple[float, ...]]


@dataclass(frozen=True, eq=False, slots=True)
class Line:
    """One line of a panel, (T,) samples in the order of time: x rises for a series, and turns for a loop."""

    x: Array
    y: Array
    token: Token
    label: str = ""  # in the legend
    width: float = 1.2  # [point]; 0 for dots alone
    alpha: float = 1.0
    dashes: Dashes = "solid"
    marker: str = ""
    order: float = 2.0  # a higher one lies on top
    outline: bool = False  # a loop of too many samples for a line shows its border only, to lie over another one
    mask: Mask | None = None  # samples to draw
    breaks: tuple[int, ...] = ()  # first samples after a gap: the line is interrupted there

    @property
    def samples(self) -> tuple[Array, Array]:
        """What is drawn, without interruptions."""
        return (self.x, self.y) if self.mask is None else (self.x[self.mask], self.y[self.mask])


def chart(
    across: str,
    up: str,
    lines: Sequence[Line],
    *,
    zero: bool = False,
    include: Sequence[float] = (),
    reach: float | None = None,
    window: Window | None = None,
    square: bool = False,
    bands: Sequence[tuple[float, float]] = (),
    marks: Sequence[float] = (),
    also: Callable[[Axes], object] | None = None,
) -> Draw:
    """Return what draws lines over each other; the later ones lie on top.

    Parameters
    ----------
    across, up
        Names of both axes with their units; the upper one stands above its axis.
    lines
        What is drawn.
    zero
        Whether to draw a line at zero, which is then within the range of the ordinate.
    include
        Further values that the ordinate must hold.
    reach
        Where the ordinate ends on both sides of zero, to compare panels; by default the lines fill it.
    window
        Range of both axes, if it is not to be that of the lines.
    square
        Whether both axes have the same scale.
    bands
        Stretches of the abscissa that are shaded.
    marks
        Places on the abscissa where something is missing.
    also
        Draws more into the same axes.
    """

    def draw(axes: Axes) -> None:
        shown = window or _window(lines, (*include, *((0.0,) if zero else ())), reach)
        label_axes(axes, shown, across, up)
        if square:
            axes.set_aspect("equal", anchor="W")
            axes.locator_params(axis="both", nbins=5)
        for start, end in bands:
            axes.axvspan(start, end, color=GRID.light, alpha=0.55, lw=0, zorder=0)
        if zero:
            axes.axhline(0.0, color=MUTED.light, lw=0.8, zorder=1)
        for line in lines:
            draw_line(axes, line, shown)
        for mark in marks[:MARKS]:
            axes.axvline(mark, color=BAD.light, lw=1.4, ls=(0, (1, 1.5)), zorder=2.5)
        if also is not None:
            also(axes)

    return draw


def _window(lines: Sequence[Line], include: Sequence[float], reach: float | None) -> Window:
    pairs = [line.samples for line in lines]
    pairs += [(x[:1], np.array([value])) for value in include for x, _ in pairs[:1] if x.size]
    found = Window.around(*pairs)
    low, high = (found.y_low, found.y_high) if reach is None else (-reach, reach)
    return Window(found.x_low, found.x_high, low, high)


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
    axis.unit = 10.0**exponent
    axis.set_major_formatter(lambda value, _: f"{value / 10.0**exponent:.6g}".replace("-", "−"))
    factor = power_of_ten(exponent)
    head, bracket, unit = label.rpartition(" [")
    if not bracket:
        return f"{short(label, LABEL_LENGTH - 6)} [{factor}]"
    return f"{short(head, LABEL_LENGTH - 12)} [{factor} {short(unit, 16)}"


def legend_label(text: str) -> str:
    """Return a legend entry; matplotlib would hide one that begins with an underscore."""
    line = short(text, 40)
    return NO_LABEL if not line else f"\u00a0{line}" if line.startswith("_") else line


def draw_line(axes: Axes, line: Line, window: Window) -> None:
    """Draw a line with no more points than the eye needs; as the area it visits when there are too many for a line."""
    if line.marker:  # every dot counts
        path: tuple[Array, Array] | None = line.samples
    elif line.x.size < 2 or bool(np.all(np.diff(line.x) >= 0.0)):
        t, y = _path(line)
        kept = thin_series(y)
        path = joined(t[kept], y[kept], window)
    else:
        path = thin_path(*_path(line), window)
        path = None if path is None else joined(*path, window)
    look = {"color": line.token.light, "label": legend_label(line.label), "alpha": line.alpha, "zorder": line.order}
    if path is not None:
        dots = {"marker": line.marker, "ms": 4.5, "mew": 1.1 if line.marker == "x" else 0.0} if line.marker else {}
        axes.plot(*path, lw=line.width, ls=line.dashes if line.width else "none", **look, **dots)
        return
    columns, rows, visited = occupancy(*_path(line), window)
    if line.outline:
        border = {"colors": [line.token.light], "linewidths": 0.7, "zorder": line.order}
        axes.contour(columns, rows, visited, levels=[0.5], **border)
    else:
        fill = {"colors": [line.token.light], "alpha": 0.8 * line.alpha, "zorder": line.order}
        axes.contourf(columns, rows, visited, levels=[0.5, 2.0], **fill)
    axes.plot([], [], lw=line.width if line.outline else 3.0, ls=line.dashes, **look)


def _path(line: Line) -> tuple[Array, Array]:
    return interrupted(line.x, line.breaks), interrupted(line.y, line.breaks, line.mask)


def time_of(recording: Recording) -> tuple[Array, str]:
    """Return abscissa and label of a recording: time, or sample numbers when there is none."""
    t = recording.time
    if t is None:
        return np.arange(len(recording), dtype=np.float64), "sample number"
    if abs(float(t[0])) > FAR_AWAY * float(np.ptp(t)):  # seconds since 1970, say: the axis would show one number
        return t - t[0], "time since the first sample [s]"
    return t, "time [s]"


def break_times(recording: Recording, t: Array) -> list[float]:
    """Return where the memory was interrupted: the first sample after each break."""
    return [float(t[k]) for k in recording.breaks]


@dataclass(frozen=True, slots=True)
class Bar:
    """A horizontal bar."""

    name: str  # above the bar, or before it
    value: float  # its length
    token: Token
    text: str  # behind the bar
    spread: float = 0.0  # half of the interval around its end
    own: float | None = None  # part of it that is drawn darker
    bold: bool = False  # the name
    hollow: bool = False
    ringed: bool = False  # at its end


def bars(rows: Sequence[Bar], across: str, *, edge: float, beside: bool = False, level: float | None = None) -> Draw:
    """Return what draws bars under each other, names above them or `beside`; longer ones than `edge` end in an arrow.

    A dashed line marks `level`.
    """

    def draw(axes: Axes) -> None:
        for k, bar in enumerate(rows):
            _draw_bar(axes, k, bar, edge, beside)
        if level is not None:
            axes.axvline(level, color=MUTED.light, lw=1.1, ls=DASHED, zorder=1)
        axes.set_xlim(0.0, edge * 1.22)
        axes.set_ylim(len(rows) - 0.4, -0.6 if beside else -0.8)
        axes.set_yticks(np.arange(len(rows)) if beside else [], [bar.name for bar in rows] if beside else [])
        axes.tick_params(axis="y", length=0, labelsize=8.5)
        axes.grid(visible=False, axis="y")
        axes.spines["left"].set_visible(False)
        axes.locator_params(axis="x", nbins=6)
        axes.set_xlabel(across)

    return draw


def _draw_bar(axes: Axes, k: int, bar: Bar, edge: float, beside: bool) -> None:
    colour, length, cut = bar.token.light, min(bar.value, edge), bar.value > edge
    height = 0.62 if beside else 0.34
    if bar.hollow:
        axes.barh(k, length, height, color="none", edgecolor=colour, linewidth=1.2, zorder=2)
    else:
        axes.barh(k, length, height, color=colour, alpha=1.0 if bar.own is None else 0.4, zorder=2)
    if bar.own is not None:
        axes.barh(k, bar.own, height, color=colour, zorder=3)
    end = length if cut else min(bar.value + bar.spread, edge)
    if bar.spread and not cut:
        low, high = min(bar.spread, bar.value), end - bar.value
        axes.errorbar(
            bar.value, k, xerr=[[low], [high]], fmt="none", color=INK.light, elinewidth=1.1, capsize=2.5, zorder=3
        )
    if bar.ringed:
        axes.plot([length], [k], "o", mfc="none", mec=INK.light, ms=6.0, mew=1.0, zorder=3)
    if cut:  # it goes on: an arrow, and the number
        axes.plot([edge * 1.012], [k], marker=">", markersize=8.0, color=colour, ls="none", zorder=2)
    after = end + edge * (0.05 if cut or bar.ringed else 0.015)
    axes.text(after, k, bar.text, va="center", fontsize=8.0 if beside else 9.5, color=MUTED.light)
    if not beside:
        weight = "bold" if bar.bold else "normal"
        axes.text(0.0, k - 0.22, bar.name, va="bottom", fontsize=10.0, color=INK.light, fontweight=weight)


def bar_heights(count: int, beside: bool = False) -> tuple[float]:
    """Return the height of axes that hold so many bars. [inch]"""
    return (max(HEIGHT, (0.22 if beside else 0.36) * count),)


def stems(axes: Axes, x: Array, y: Array, token: Token, label: str) -> None:
    """Draw values as dots on stalks from zero."""
    axes.vlines(x, 0.0, y, color=token.light, lw=1.6, zorder=2)
    axes.plot(x, y, "o", color=token.light, ms=4.5, mew=0.0, label=label, zorder=3)


def logarithmic(axes: Axes, which: str, low: float, high: float) -> None:
    """Make an axis logarithmic from `low` to `high`, with plain numbers at 1, 2 and 5, or at powers of ten alone."""
    getattr(axes, f"set_{which}scale")("log")
    getattr(axes, f"set_{which}lim")(low, high)
    ticks = [m * 10.0**e for e in range(-9, 7) for m in (1, 2, 5) if low <= m * 10.0**e <= high]
    if len(ticks) > 7:
        ticks = [tick for tick in ticks if f"{tick:e}".startswith("1.0")]
    getattr(axes, f"set_{which}ticks")(ticks, [number(tick, 1) for tick in ticks], color=MUTED.light)
    axes.minorticks_off()
