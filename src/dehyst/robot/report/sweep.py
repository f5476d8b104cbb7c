"""Picture of a sweep: figures over each parameter, one dot per run, medians joined."""

from __future__ import annotations

import itertools
import math
import statistics
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from os import PathLike
from pathlib import Path
from typing import Any

from dehyst.report.drawing import legend_label
from dehyst.report.parts import Axes, Figure, Panel
from dehyst.report.svg import write_picture
from dehyst.report.text import short
from dehyst.report.theme import CYCLE, INK, MUTED

TITLE = "dehyst sweep: "  # by which a picture is known that may be drawn anew
WIDTH, HEIGHT = 3.3, 1.5  # of a panel and of its axes [inch]
NARROWEST = 5.2  # of the whole [inch]
MOST_ROWS = 24  # of panels; more would be no picture
MOST_COLUMNS = 9
NO_EFFECT = 1.0  # ratio at which a compensator changes nothing
MARKERS = "osD^vP"
MOST_TICKS = 7
KEY = "lines: medians; small dots: runs; bars: lowest to highest; dashed: 1, no effect"


@dataclass(frozen=True, eq=False)
class Curve:
    """One panel: a figure over a parameter, a value a run."""

    study: str
    parameter: str  # across
    figure: str  # up
    x: Sequence[Any]  # of the parameter, numbers or texts
    y: Sequence[float | None]  # of the figure, None where there is none
    group: Sequence[str]  # name of the line each run belongs to; "" for a single line
    scattered: bool = False  # whether the parameter was drawn at random: dots only, nothing to join


def write_sweep_figure(path: str | PathLike[str], name: str, curves: Sequence[Curve]) -> Path:
    """Write the picture of a sweep: a row for each study's parameter, a column for each figure."""
    return write_picture(sweep_figure(name, curves), path, f"{TITLE}{name}", headed=True)


def sweep_figure(name: str, curves: Sequence[Curve]) -> Figure:
    """Return the picture: a group has the same colour in every panel, and is named where it first appears."""
    rows = list(dict.fromkeys((curve.study, curve.parameter) for curve in curves))[:MOST_ROWS]
    columns = list(dict.fromkeys(curve.figure for curve in curves))[:MOST_COLUMNS]
    groups = {group: k for k, group in enumerate(dict.fromkeys(group for curve in curves for group in curve.group))}
    tops = {figure: 1.1 * _highest(curves, figure) for figure in columns}
    placed = {(curve.study, curve.parameter, curve.figure): curve for curve in curves}
    panels, named = [], set[str]()
    for row in rows:
        for figure in columns:
            curve = placed.get((*row, figure))
            if curve is None:
                panels.append(Panel("", (), "", ()))
                continue
            new = not named.issuperset(curve.group) and len(groups) > 1
            named |= set(curve.group)
            draw = partial(_draw, curve, groups, tops[figure])
            panels.append(Panel("", draw, f"{figure} over {curve.parameter}", (HEIGHT,), legend=new))
    return Figure(
        "sweep",
        f"sweep {name}",
        KEY,
        tuple(panels),
        columns=len(columns),
        width=max(WIDTH, NARROWEST / max(len(columns), 1)),
    )


def _highest(curves: Sequence[Curve], figure: str) -> float:
    """The largest number of a figure in all panels; they share their range."""
    return max((y for curve in curves if curve.figure == figure for y in _told(curve)), default=NO_EFFECT)


def _told(curve: Curve) -> list[float]:
    return [y for y in curve.y if y is not None and math.isfinite(y)]


def _draw(curve: Curve, groups: Mapping[str, int], top: float, axes: Axes) -> None:
    axes.set_title(short(curve.figure, 42), color=INK.light, fontsize=9.5)
    axes.set_xlabel(short(f"{curve.parameter} ({curve.study})", 44), color=MUTED.light, fontsize=9.5)
    places, apart = _abscissa(axes, curve)
    axes.axhline(NO_EFFECT, color=MUTED.light, lw=0.8, ls=(0, (4, 3)), zorder=1)
    here = list(dict.fromkeys(curve.group))
    for k, group in enumerate(here):
        aside = 0.0 if curve.scattered else apart * (k - (len(here) - 1) / 2)
        dots = [
            (x + aside, y)
            for x, y, g in zip(places, curve.y, curve.group, strict=True)
            if g == group and y is not None and math.isfinite(y)
        ]
        colour, marker = CYCLE[groups[group] % len(CYCLE)].light, MARKERS[groups[group] % len(MARKERS)]
        _line(axes, dots, colour, marker, curve.scattered, legend_label(group))
    axes.set_ylim(0.0, max(top, 1.05 * NO_EFFECT))


def _abscissa(axes: Axes, curve: Curve) -> tuple[list[float], float]:
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


def _line(
    axes: Axes, dots: Sequence[tuple[float, float]], colour: str, marker: str, scattered: bool, label: str
) -> None:
    """Dots of all runs; medians joined and their range as a bar, unless the parameter was drawn at random."""
    x, y = [dot[0] for dot in dots], [dot[1] for dot in dots]
    if scattered:
        axes.plot(x, y, marker, color=colour, ms=3.0, mew=0.0, alpha=0.6, label=label)
        return
    axes.plot(x, y, marker, color=colour, ms=2.6, mew=0.0, alpha=0.45)
    places = sorted(set(x))
    runs = [[b for a, b in dots if a == place] for place in places]
    axes.vlines(places, [min(run) for run in runs], [max(run) for run in runs], color=colour, lw=1.0, alpha=0.6)
    medians = [statistics.median(run) for run in runs]
    axes.plot(places, medians, color=colour, marker=marker, ms=4.5, mew=0.0, lw=1.4, label=label)
