"""Picture of a sweep: small multiples, a figure over a parameter, every run a dot, medians joined."""

from __future__ import annotations

import itertools
import math
import statistics
from collections.abc import Sequence
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure as Canvas

from dehyst.report.svg import paper, require_picture_name, write_drawn
from dehyst.report.text import short
from dehyst.report.theme import CYCLE, INK, MUTED, settings
from dehyst.shell import visible_lines as clean

TITLE = "dehyst sweep: "  # by which a picture is known that may be drawn anew
WIDTH, HEIGHT = 3.3, 2.3  # of one panel [inch]
MOST_ROWS = 24  # of panels; more would be no picture
WIDEST = 30.0  # [inch]
NO_EFFECT = 1.0  # ratio at which a compensator changes nothing
MARKERS = "osD^vP"
HEAD, LEGEND_LINE = 0.56, 0.22  # of title and key, of a line of the legend [inch]
NARROWEST = 5.2  # [inch]
ENTRY = 1.45  # of the legend [inch]
MOST_TICKS = 7
KEY = "lines: medians; small dots: runs; bars: lowest to highest; dashed: 1, no effect"


@dataclass(frozen=True, eq=False)
class Curve:
    """One panel: a figure over a parameter.

    Attributes
    ----------
    study, parameter, figure
        Which study, which parameter across, which figure up.
    x
        Values of the parameter, (n,), numbers or texts.
    y
        The figure, (n,), None where there is none.
    group
        Name of the line each run belongs to, (n,); "" for a single line.
    scattered
        Whether the parameter was drawn at random: dots only, nothing to join.
    """

    study: str
    parameter: str
    figure: str
    x: Sequence[Any]
    y: Sequence[float | None]
    group: Sequence[str]
    scattered: bool = False


def write_sweep_figure(path: str | PathLike[str], name: str, curves: Sequence[Curve]) -> Path:
    """Write the picture of a sweep: a row for each study's parameter, a column for each figure."""
    target = require_picture_name(path)
    rows = list(dict.fromkeys((curve.study, curve.parameter) for curve in curves))[:MOST_ROWS]
    columns = list(dict.fromkeys(curve.figure for curve in curves))[: int(WIDEST / WIDTH)]
    with settings(paper(clean(f"sweep {name}"))):
        width, height = max(WIDTH * len(columns), NARROWEST), HEIGHT * max(len(rows), 1)
        across = max(1, int(width / ENTRY))
        lines = math.ceil(len({group for curve in curves for group in curve.group}) / across)
        above = HEAD + LEGEND_LINE * max(lines, 1)
        canvas = Canvas(figsize=(width, height + above), layout="constrained")
        parts: Any = canvas.subfigures(2, 1, height_ratios=[above, height])
        handles = _draw(parts[1], rows, columns, curves) if rows and columns else {}
        _head(parts[0], name, handles, across, above)
        return write_drawn(canvas, target, f"{TITLE}{name}")


def _head(part: Any, name: str, handles: dict[str, Any], across: int, height: float) -> None:
    """Name of the sweep, what is drawn, and one legend for all panels."""
    title = short(f"sweep {name}", 70)
    part.text(0.012, 1 - 0.06 / height, title, va="top", fontsize=12.5, fontweight="bold", color=INK.light)
    part.text(0.012, 1 - 0.34 / height, KEY, va="top", fontsize=8.6, color=MUTED.light)
    if len(handles) > 1 or "" not in handles:
        part.legend(
            [*handles.values()],
            [short(group, 40) for group in handles],
            loc="lower left",
            bbox_to_anchor=(0.012, 0.02),
            ncols=across,
            fontsize=9.0,
        )


def _draw(
    part: Any, rows: Sequence[tuple[str, str]], columns: Sequence[str], curves: Sequence[Curve]
) -> dict[str, Any]:
    """Draw all panels; return their lines by name."""
    grid = part.subplots(len(rows), len(columns), squeeze=False, sharey="col")
    for axes in grid.ravel():
        axes.set_axis_off()
    handles: dict[str, Any] = {}
    for curve in curves:
        if (curve.study, curve.parameter) in rows and curve.figure in columns:
            axes = grid[rows.index((curve.study, curve.parameter)), columns.index(curve.figure)]
            axes.set_axis_on()
            handles = {**_panel(axes, curve), **handles}  # joined lines stand before scattered dots
    for axes in grid[0]:  # the others of a column share its range
        axes.set_ylim(bottom=0.0)
    return handles


def _panel(axes: Any, curve: Curve) -> dict[str, Any]:
    """Draw one panel; return its lines by name, for the one legend of the picture."""
    axes.set_title(short(curve.figure, 42), color=INK.light, fontsize=9.5)
    axes.set_xlabel(short(f"{curve.parameter} ({curve.study})", 44), color=MUTED.light, fontsize=9.5)
    places, apart = _abscissa(axes, curve)
    axes.axhline(NO_EFFECT, color=MUTED.light, lw=0.8, ls=(0, (4, 3)), zorder=1)
    handles = {}
    groups = list(dict.fromkeys(curve.group))
    for k, group in enumerate(groups):
        aside = 0.0 if curve.scattered else apart * (k - (len(groups) - 1) / 2)
        dots = [
            (x + aside, y)
            for x, y, g in zip(places, curve.y, curve.group, strict=True)
            if g == group and y is not None and math.isfinite(y)
        ]
        colour, marker = CYCLE[k % len(CYCLE)].light, MARKERS[k % len(MARKERS)]
        handles[group] = _line(axes, dots, colour, marker, curve.scattered)
    return handles


def _abscissa(axes: Any, curve: Curve) -> tuple[list[float], float]:
    """Set the ticks; return where each run stands, and how far groups stand apart so that none hides another."""
    texts = not all(isinstance(x, int | float) and not isinstance(x, bool) for x in curve.x)
    if texts:
        names = list(dict.fromkeys(str(x) for x in curve.x))
        axes.set_xticks(range(len(names)), [short(name, 14) for name in names])
        axes.set_xlim(-0.5, len(names) - 0.5)
        axes.grid(axis="x", visible=False)
        return [float(names.index(str(x))) for x in curve.x], 0.08
    places = [float(x) for x in curve.x]
    values = sorted({x for x in places if math.isfinite(x)})
    if not curve.scattered and len(values) <= MOST_TICKS:
        axes.set_xticks(values, [f"{value:g}".replace("-", "−") for value in values])
    steps = [b - a for a, b in itertools.pairwise(values)]
    span = values[-1] - values[0] if values else 0.0
    return places, min([0.012 * span, *(0.15 * step for step in steps)])


def _line(axes: Any, dots: Sequence[tuple[float, float]], colour: str, marker: str, scattered: bool) -> Any:
    """Dots of all runs; medians joined and their range as a bar, unless the parameter was drawn at random."""
    x, y = [dot[0] for dot in dots], [dot[1] for dot in dots]
    if scattered:
        return axes.plot(x, y, marker, color=colour, ms=3.0, mew=0.0, alpha=0.6)[0]
    axes.plot(x, y, marker, color=colour, ms=2.6, mew=0.0, alpha=0.45)
    places = sorted(set(x))
    runs = [[b for a, b in dots if a == place] for place in places]
    axes.vlines(places, [min(run) for run in runs], [max(run) for run in runs], color=colour, lw=1.0, alpha=0.6)
    medians = [statistics.median(run) for run in runs]
    return axes.plot(places, medians, color=colour, marker=marker, ms=4.5, mew=0.0, lw=1.4)[0]
