"""Lines with as few points as the eye needs: a page of a hundred axes stays small and quick."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from dehyst.arrays import Array
from dehyst.report.figures.panel import Axes, label_axes, legend_label
from dehyst.report.theme import GRID, MUTED, Token
from dehyst.report.thin import Window, thin_path, thin_series

Draw = Callable[[Axes], None]
Dashes = str | tuple[float, tuple[float, ...]]

# Points of a line over time before straight stretches are joined; the extremes of every stretch are kept.
POINTS = 1500
# A point is left out when it is closer than this to the straight line between its neighbours. [cells of the panel]
FLAT, PASSES = 0.3, 6


@dataclass(frozen=True)
class Line:
    """One line of a picture: its ordinate (T,), its colour, its name in the legend."""

    y: Array
    token: Token
    label: str
    width: float = 1.15
    alpha: float = 1.0
    dashes: Dashes = "solid"


def joined(x: Array, y: Array, window: Window) -> tuple[Array, Array]:
    """Return a path without the points that lie on the straight line between their neighbours.

    In every pass each second point is tried, so no point moves the line by more than `PASSES` times `FLAT`. The first,
    the last and the extreme points stay.

    Examples
    --------
    >>> x = np.linspace(0.0, 1.0, 1000)
    >>> kept = joined(x, np.abs(x - 0.5), Window(0.0, 1.0, 0.0, 1.0))
    >>> kept[0].size < 40, bool(kept[1].min() == np.abs(x - 0.5).min())
    (True, True)
    """
    u, v = window.cells(x, y)
    kept = np.arange(x.size)
    extremes = {int(f(s)) for s in (x, y) for f in (np.nanargmin, np.nanargmax)} if x.size else set()
    fixed = np.zeros(x.size, dtype=np.bool_)
    fixed[list(extremes)] = True
    for _ in range(PASSES):
        if kept.size < 3:
            break
        middle = np.arange(1, kept.size - 1, 2)
        a, m, b = kept[middle - 1], kept[middle], kept[middle + 1]
        du, dv = u[b] - u[a], v[b] - v[a]
        length = np.hypot(du, dv)
        off = np.abs(du * (v[m] - v[a]) - dv * (u[m] - u[a])) / np.maximum(length, 1e-9)
        # A point beyond its neighbours is a turn, however close to their line.
        along = ((u[m] - u[a]) * du + (v[m] - v[a]) * dv) / np.maximum(length, 1e-9) ** 2
        flat = (off < FLAT) & (along >= 0.0) & (along <= 1.0) & ~fixed[m]
        kept = np.delete(kept, middle[flat])
    return x[kept], y[kept]


def draw_line(axes: Axes, t: Array, line: Line, window: Window) -> None:
    """Draw one line over a rising abscissa."""
    kept = thin_series(line.y, POINTS)
    _plot(axes, *joined(t[kept], line.y[kept], window), line)


def draw_loop(axes: Axes, x: Array, line: Line, window: Window) -> None:
    """Draw one line over an abscissa that goes back and forth."""
    path = thin_path(x, line.y, window)
    _plot(axes, *joined(*(path if path is not None else (x, line.y)), window), line)


def _plot(axes: Axes, x: Array, y: Array, line: Line) -> None:
    axes.plot(
        x,
        y,
        color=line.token.light,
        lw=line.width,
        alpha=line.alpha,
        ls=line.dashes,
        label=legend_label(line.label),
    )


def over_time(t: Array, lines: Sequence[Line], x_label: str, y_label: str, *, reach: float | None = None) -> Draw:
    """Return what draws lines over time.

    Parameters
    ----------
    t
        (T,) abscissa.
    lines
        (T,) each; the last one lies on top.
    x_label, y_label
        With their units.
    reach
        Where the ordinate ends on both sides of zero, to compare pictures; by default the lines fill it.
    """

    def draw(axes: Axes) -> None:
        window = Window.around(*((t, line.y) for line in lines), margin=0.06)
        if reach is not None:
            window = Window(window.x_low, window.x_high, -reach, reach)
        span = float(t[-1] - t[0]) if t.size > 1 else 1.0
        window = Window(float(t[0]) - 0.01 * span, float(t[-1]) + 0.01 * span, window.y_low, window.y_high)
        label_axes(axes, window, x_label, y_label)
        axes.locator_params(axis="y", nbins=4)
        if window.y_low < 0.0 < window.y_high:
            axes.axhline(0.0, color=MUTED.light, lw=0.7, zorder=1)
        for line in lines:
            draw_line(axes, t, line, window)

    return draw


def over_angle(x: Array, lines: Sequence[Line], x_label: str, y_label: str) -> Draw:
    """Return what draws loops over one abscissa, (T,) each."""

    def draw(axes: Axes) -> None:
        window = Window.around(*((x, line.y) for line in lines))
        label_axes(axes, window, x_label, y_label)
        for line in lines:
            draw_loop(axes, x, line, window)

    return draw


def shaded(draw: Draw, stretches: Sequence[tuple[float, float]]) -> Draw:
    """Return what draws the same over bands that mark stretches of time."""

    def draw_both(axes: Axes) -> None:
        for start, end in stretches:
            axes.axvspan(start, end, color=GRID.light, alpha=0.55, lw=0, zorder=0)
        draw(axes)

    return draw_both
