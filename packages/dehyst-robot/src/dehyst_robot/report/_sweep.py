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
from typing import Any, TypeGuard

from dehyst.report import Axes, PageFigure, Panel
from dehyst.report import kit as report_kit
from dehyst_robot.report._numbers import short_names

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
class SweepCurve:
    """One panel: a figure over a parameter, a value a run."""

    study: str
    parameter: str  # across
    figure: str  # up
    x: Sequence[Any]  # of the parameter, numbers or texts
    y: Sequence[float | None]  # of the figure, None where there is none
    group: Sequence[str]  # name of the line each run belongs to; "" for a single line
    scattered: bool = False  # whether the parameter was drawn at random: dots only, nothing to join


def write_sweep_figure(path: str | PathLike[str], name: str, curves: Sequence[SweepCurve]) -> Path:
    """Write the picture of a sweep: a row for each study's parameter, a column for each figure."""
    return report_kit.write_picture(sweep_figure(name, curves), path, f"{TITLE}{name}", headed=True)


def sweep_figure(name: str, curves: Sequence[SweepCurve]) -> PageFigure:
    """Return the picture: a group has the same colour in every panel, and is named where it first appears."""
    placed: dict[tuple[str, str, str], SweepCurve] = {}
    groups: dict[str, int] = {}
    # The keys of a dictionary are each row and column once, in the order of the curves.
    every_row: dict[tuple[str, str], None] = {}
    every_column: dict[str, None] = {}
    for curve in curves:
        placed[curve.study, curve.parameter, curve.figure] = curve
        every_row[curve.study, curve.parameter] = None
        every_column[curve.figure] = None
        for group in curve.group:
            groups.setdefault(group, len(groups))
    rows, columns = list(every_row)[:MOST_ROWS], list(every_column)[:MOST_COLUMNS]
    tops = {figure: 1.1 * _highest(curves, figure) for figure in columns}
    # The legend stands once for each group, where it first appears.
    panels, named = [], set[str]()
    for row in rows:
        for figure in columns:
            panel_curve = placed.get((*row, figure))
            # A study without this figure leaves its place in the grid empty.
            if panel_curve is None:
                panels.append(Panel("", (), "", ()))
                continue
            new = not named.issuperset(panel_curve.group) and len(groups) > 1
            named |= set(panel_curve.group)
            draw = partial(_draw, panel_curve, groups, tops[figure])
            words = f"{figure} over {panel_curve.parameter}"
            panels.append(Panel("", draw, words, (HEIGHT,), legend=new))
    return PageFigure(
        "sweep",
        f"sweep {name}",
        KEY,
        tuple(panels),
        columns=len(columns),
        width=max(WIDTH, NARROWEST / max(len(columns), 1)),
    )


def _highest(curves: Sequence[SweepCurve], figure: str) -> float:
    """The largest number of a figure in all panels; they share their range."""
    numbers: list[float] = []
    for curve in curves:
        if curve.figure == figure:
            numbers += filter(_is_drawn, curve.y)
    return max(numbers, default=NO_EFFECT)


def _is_drawn(y: float | None) -> TypeGuard[float]:
    return y is not None and math.isfinite(y)


def _draw(curve: SweepCurve, groups: Mapping[str, int], top: float, axes: Axes) -> None:
    axes.set_title(report_kit.short(curve.figure, 42), color=report_kit.INK.light, fontsize=9.5)
    axes.set_xlabel(
        report_kit.short(f"{curve.parameter} ({curve.study})", 44),
        color=report_kit.MUTED.light,
        fontsize=9.5,
    )
    places, apart = _abscissa(axes, curve)
    axes.axhline(NO_EFFECT, color=report_kit.MUTED.light, lw=0.8, ls=(0, (4, 3)), zorder=1)
    dots: dict[str, list[tuple[float, float]]] = {}
    for x, y, group in zip(places, curve.y, curve.group, strict=True):
        # A group whose runs all failed keeps its place beside the others.
        of_group = dots.setdefault(group, [])
        if _is_drawn(y):
            of_group.append((x, y))
    for k, group in enumerate(dots):
        # Groups stand beside each other, so that none hides another.
        aside = 0.0
        if not curve.scattered:
            aside = apart * (k - (len(dots) - 1) / 2)
        moved = [(x + aside, y) for x, y in dots[group]]
        colour = report_kit.CYCLE[groups[group] % len(report_kit.CYCLE)].light
        marker = MARKERS[groups[group] % len(MARKERS)]
        _line(axes, moved, colour, marker, curve.scattered, report_kit.legend_label(group))
    axes.set_ylim(0.0, max(top, 1.05 * NO_EFFECT))


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _abscissa(axes: Axes, curve: SweepCurve) -> tuple[list[float], float]:
    """Set the ticks; return where each run stands, and how far groups stand apart so that none hides another."""
    # Words, or numbers and words, stand beside each other in the order of the file.
    if not all(map(_is_number, curve.x)):
        texts = list(map(str, curve.x))
        names = list(dict.fromkeys(texts))
        axes.set_xticks(range(len(names)), short_names(names, 14))
        axes.set_xlim(-0.5, len(names) - 0.5)
        axes.grid(axis="x", visible=False)
        return [float(names.index(text)) for text in texts], 0.08
    places = list(map(float, curve.x))
    values = sorted(set(filter(math.isfinite, places)))
    if not curve.scattered and len(values) <= MOST_TICKS:
        axes.set_xticks(values, [f"{value:g}".replace("-", "−") for value in values])
    apart = 0.0
    if values:
        apart = 0.012 * (values[-1] - values[0])
    # Groups of one value must not reach into those of the next.
    for low, high in itertools.pairwise(values):
        apart = min(apart, 0.15 * (high - low))
    return places, apart


def _line(
    axes: Axes,
    dots: Sequence[tuple[float, float]],
    colour: str,
    marker: str,
    scattered: bool,
    label: str,
) -> None:
    """Dots of all runs; medians joined and their range as a bar, unless the parameter was drawn at random."""
    x, y = [], []
    for place, value in dots:
        x.append(place)
        y.append(value)
    # Of draws at random no two stand at one place: there is no median.
    if scattered:
        axes.plot(x, y, marker, color=colour, ms=3.0, mew=0.0, alpha=0.6, label=label)
        return
    axes.plot(x, y, marker, color=colour, ms=2.6, mew=0.0, alpha=0.45)
    runs: dict[float, list[float]] = {}
    for place, value in sorted(dots, key=lambda dot: dot[0]):
        runs.setdefault(place, []).append(value)
    places = list(runs)
    lows, highs = list(map(min, runs.values())), list(map(max, runs.values()))
    axes.vlines(places, lows, highs, color=colour, lw=1.0, alpha=0.6)
    medians = list(map(statistics.median, runs.values()))
    axes.plot(places, medians, color=colour, marker=marker, ms=4.5, mew=0.0, lw=1.4, label=label)
