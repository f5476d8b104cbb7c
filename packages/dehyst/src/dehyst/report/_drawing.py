"""Draws panels: line charts of signals and loops, horizontal bars, stems, logarithmic axes."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from dehyst.arrays import Array, Mask
from dehyst.data import Recording
from dehyst.report._parts import HEIGHT, Axes, Draw
from dehyst.report._text import number, power_of_ten, short
from dehyst.report._theme import BAD, GRID, INK, MUTED, ThemeColour
from dehyst.report._thin import Window, interrupted, joined, occupancy, thin_path, thin_series

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
class PanelLine:
    """One line of a panel, (T,) samples in the order of time: x rises for a series, and turns for a loop."""

    x: Array
    y: Array
    token: ThemeColour
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
        if self.mask is None:
            return self.x, self.y
        return self.x[self.mask], self.y[self.mask]


def chart(
    across: str,
    up: str,
    lines: Sequence[PanelLine],
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

    # The ordinate must reach the line at zero, or the line would not be seen.
    included = list(include)
    if zero:
        included.append(0.0)

    def draw(axes: Axes) -> None:
        shown = window or _window(lines, included, reach)
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


def _window(lines: Sequence[PanelLine], include: Sequence[float], reach: float | None) -> Window:
    pairs = [line.samples for line in lines]
    # A value to include is a point at the begin of the first line, so that it does not change the abscissa.
    if pairs and pairs[0][0].size:
        begin = pairs[0][0][:1]
        for value in include:
            pairs.append((begin, np.array([value])))
    window = Window.around(*pairs)
    if reach is None:
        return window
    return Window(window.x_low, window.x_high, -reach, reach)


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
    if not line:
        return NO_LABEL
    # A space that does not break, and that nobody sees, hides the underscore from matplotlib.
    if line.startswith("_"):
        return f"\u00a0{line}"
    return line


def draw_line(axes: Axes, line: PanelLine, window: Window) -> None:
    """Draw a line with no more points than the eye needs; as the area it visits when there are too many for a line."""
    if line.marker:  # every dot counts
        path: tuple[Array, Array] | None = line.samples
    elif line.x.size < 2 or bool(np.all(np.diff(line.x) >= 0.0)):
        t, y = _path(line)
        drawn = thin_series(y)
        path = joined(t[drawn], y[drawn], window)
    else:
        path = thin_path(*_path(line), window)
        if path is not None:
            path = joined(*path, window)
    look = {
        "color": line.token.light,
        "label": legend_label(line.label),
        "alpha": line.alpha,
        "zorder": line.order,
    }
    if path is not None:
        dots: dict[str, Any] = {}
        if line.marker:
            dots = {"marker": line.marker, "ms": 4.5, "mew": 0.0}
        # A cross has no area: without an edge it would not be seen.
        if line.marker == "x":
            dots["mew"] = 1.1
        dashes: Dashes = "none"
        if line.width:
            dashes = line.dashes
        axes.plot(*path, lw=line.width, ls=dashes, **look, **dots)
        return
    columns, rows, visited = occupancy(*_path(line), window)
    if line.outline:
        border = {"colors": [line.token.light], "linewidths": 0.7, "zorder": line.order}
        axes.contour(columns, rows, visited, levels=[0.5], **border)
        legend_width = line.width
    else:
        fill = {"colors": [line.token.light], "alpha": 0.8 * line.alpha, "zorder": line.order}
        axes.contourf(columns, rows, visited, levels=[0.5, 2.0], **fill)
        legend_width = 3.0
    # Areas have no legend entry of their own: an empty line stands for them.
    axes.plot([], [], lw=legend_width, ls=line.dashes, **look)


def _path(line: PanelLine) -> tuple[Array, Array]:
    return interrupted(line.x, line.breaks), interrupted(line.y, line.breaks, line.mask)


def time_of(recording: Recording) -> tuple[Array, str]:
    """Return abscissa and label of a recording: time, or sample numbers when there is none."""
    t = recording.time
    if t is None:
        return np.arange(len(recording), dtype=np.float64), "sample number"
    # Seconds since 1970, for example: all ticks of the axis would show the same digits.
    if abs(float(t[0])) > FAR_AWAY * float(np.ptp(t)):
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
    token: ThemeColour
    text: str  # behind the bar
    spread: float = 0.0  # half of the interval around its end
    interval: tuple[float, float] | None = None  # the interval, where its end is not in the middle
    dark: float | None = None  # part of it that is drawn darker
    bold: bool = False  # the name
    hollow: bool = False
    ringed: bool = False  # at its end


def bars(
    rows: Sequence[Bar],
    across: str,
    *,
    edge: float,
    beside: bool = False,
    level: float | None = None,
) -> Draw:
    """Return what draws bars under each other, names above them or `beside`; longer ones than `edge` end in an arrow.

    A dashed line marks `level`.
    """

    def draw(axes: Axes) -> None:
        for k, bar in enumerate(rows):
            _draw_bar(axes, k, bar, edge, beside)
        if level is not None:
            axes.axvline(level, color=MUTED.light, lw=1.1, ls=DASHED, zorder=1)
        axes.set_xlim(0.0, edge * 1.22)
        if beside:
            axes.set_ylim(len(rows) - 0.4, -0.6)
            axes.set_yticks(np.arange(len(rows)), [bar.name for bar in rows])
        else:
            # The name above the first bar needs more room than the bar itself.
            axes.set_ylim(len(rows) - 0.4, -0.8)
            axes.set_yticks([], [])
        axes.tick_params(axis="y", length=0, labelsize=8.5)
        axes.grid(visible=False, axis="y")
        axes.spines["left"].set_visible(False)
        axes.locator_params(axis="x", nbins=6)
        axes.set_xlabel(across)

    return draw


def _draw_bar(axes: Axes, k: int, bar: Bar, edge: float, beside: bool) -> None:
    colour = bar.token.light
    length = min(bar.value, edge)
    cut = bar.value > edge
    # Bars with their names beside them fill the row; a name above needs the other half of it.
    height, font_size = 0.34, 9.5
    if beside:
        height, font_size = 0.62, 8.0
    if bar.hollow:
        axes.barh(k, length, height, color="none", edgecolor=colour, linewidth=1.2, zorder=2)
    elif bar.dark is None:
        axes.barh(k, length, height, color=colour, alpha=1.0, zorder=2)
    else:
        axes.barh(k, length, height, color=colour, alpha=0.4, zorder=2)
    if bar.dark is not None:
        axes.barh(k, bar.dark, height, color=colour, zorder=3)
    # A cut bar has no end that an interval could lie around.
    end = length
    lowest, highest = bar.interval or (bar.value - bar.spread, bar.value + bar.spread)
    if not cut:
        end = min(highest, edge)
    if highest > lowest and not cut:
        low, high = bar.value - max(lowest, 0.0), end - bar.value
        axes.errorbar(
            bar.value,
            k,
            xerr=[[low], [high]],
            fmt="none",
            color=INK.light,
            elinewidth=1.1,
            capsize=2.5,
            zorder=3,
        )
    if bar.ringed:
        axes.plot([length], [k], "o", mfc="none", mec=INK.light, ms=6.0, mew=1.0, zorder=3)
    # An arrow shows that the bar goes on; its text gives the number.
    if cut:
        axes.plot(
            [edge * 1.012], [k], marker=">", markersize=8.0, color=colour, ls="none", zorder=2
        )
    # The text must not touch the arrow or the ring.
    gap = 0.015
    if cut or bar.ringed:
        gap = 0.05
    axes.text(end + edge * gap, k, bar.text, va="center", fontsize=font_size, color=MUTED.light)
    if not beside:
        weight = "normal"
        if bar.bold:
            weight = "bold"
        axes.text(
            0.0, k - 0.22, bar.name, va="bottom", fontsize=10.0, color=INK.light, fontweight=weight
        )


def bar_heights(count: int, beside: bool = False) -> tuple[float, ...]:
    """Return the height of axes that hold so many bars. [inch]"""
    if beside:
        return (max(HEIGHT, 0.22 * count),)
    return (max(HEIGHT, 0.36 * count),)


def stems(axes: Axes, x: Array, y: Array, token: ThemeColour, label: str) -> None:
    """Draw values as dots on stalks from zero."""
    axes.vlines(x, 0.0, y, color=token.light, lw=1.6, zorder=2)
    axes.plot(x, y, "o", color=token.light, ms=4.5, mew=0.0, label=label, zorder=3)


def logarithmic(axes: Axes, which: str, low: float, high: float) -> None:
    """Make an axis logarithmic from `low` to `high`, with plain numbers at 1, 2 and 5, or at powers of ten alone."""
    getattr(axes, f"set_{which}scale")("log")
    getattr(axes, f"set_{which}lim")(low, high)
    ticks = _ticks_between(low, high, (1, 2, 5))
    # Over several decades the labels would overlap.
    if len(ticks) > 7:
        ticks = _ticks_between(low, high, (1,))
    labels = [number(tick, 1) for tick in ticks]
    getattr(axes, f"set_{which}ticks")(ticks, labels, color=MUTED.light)
    axes.minorticks_off()


def _ticks_between(low: float, high: float, multiples: Sequence[int]) -> list[float]:
    """Multiples of the powers of ten from 1e-9 to 1e6 that lie in a range, in rising order."""
    ticks = []
    for exponent in range(-9, 7):
        for multiple in multiples:
            tick = multiple * 10.0**exponent
            if low <= tick <= high:
                ticks.append(tick)
    return ticks


def double_arrow(
    axes: Axes, begin: tuple[float, float], end: tuple[float, float], colour: ThemeColour
) -> None:
    """Draw a distance between two places."""
    look = {"arrowstyle": "<->", "color": colour.light, "lw": 1.4, "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", end, begin, arrowprops=look, zorder=5)
