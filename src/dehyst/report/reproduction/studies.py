"""Integrator and compensator at rest, and where compensation hurts: figures, and sentences computed from the data."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from dehyst.errors import ParameterError
from dehyst.experiments.results import Reproduction
from dehyst.report.figures.panel import Axes, label_axes, says
from dehyst.report.reproduction.lines import Line, over_time
from dehyst.report.reproduction.picture import Picture, Plate
from dehyst.report.reproduction.trials import OFF_LABEL, ON_LABEL
from dehyst.report.tables import Table
from dehyst.report.text import number, short
from dehyst.report.theme import FIFTH, MUTED, TEST, TRAIN, Token
from dehyst.report.thin import Window

Array = npt.NDArray[np.float64]
Columns = Mapping[str, Any]

REST, SMALLER, DOUBLE, GAINS = "rest", "smaller hysteresis", "double compensation", "high gains"
# Two drifts are called equal when they differ by less than this share of the larger one.
EQUAL = 0.2


@dataclass(frozen=True)
class Study:
    """A part of the page: a figure, sentences about it, a table."""

    plate: Plate
    words: tuple[str, ...]
    table: Table | None = None


def rest_study(result: Reproduction) -> Study | None:
    """Return "At rest: integrator and compensator", or None if it was not measured."""
    columns = result.studies.get(REST)
    if columns is None:
        return None
    t, off, on = (_column(columns, REST, name) for name in ("time_s", "integrator_off_Nm", "integrator_on_Nm"))
    levels = [float(np.mean(torque)) for torque in (off, on)]
    slopes = [float(np.polyfit(t - t[0], torque, 1)[0]) for torque in (off, on)]
    pair = (Line(off, TEST, OFF_LABEL, 1.5), Line(on, TRAIN, ON_LABEL, 1.5))
    moved = tuple(Line(line.y - line.y[0], line.token, line.label, line.width) for line in pair)
    apart, torque = abs(levels[0] - levels[1]), "integrator [Nm]"
    plate = Plate(
        "rest",
        "At rest: integrator and compensator",
        "The arm stands still at a point of the path, its angle held by the integrator.",
        (
            Picture(
                "Torque of the integrator",
                (over_time(t, pair, "time at rest [s]", torque),),
                says(f"Levels {number(apart)} Nm apart."),
            ),
            Picture(
                "Its change since the stop",
                (over_time(t, moved, "time at rest [s]", "change [Nm]"),),
                says(f"Drifts {number(slopes[0])} and {number(slopes[1])} Nm/s."),
            ),
        ),
    )
    words = (
        f"Level: {number(levels[0])} Nm without and {number(levels[1])} Nm with compensator, {number(apart)} Nm apart. "
        "The difference is the torque that the compensator adds there, and the integrator therefore need not.",
        _drift(*slopes),
    )
    rows = tuple(
        (label, number(level), number(slope), number(float(np.ptp(torque_))))
        for label, level, slope, torque_ in zip((OFF_LABEL, ON_LABEL), levels, slopes, (off, on), strict=True)
    )
    return Study(plate, words, Table("At rest", ("", "mean [Nm]", "drift [Nm/s]", "range [Nm]"), rows))


def _drift(off: float, on: float) -> str:
    text = f"Drift: {number(off)} Nm/s without and {number(on)} Nm/s with compensator"
    if abs(off - on) <= EQUAL * max(abs(off), abs(on)):
        within = max(1, math.ceil(100 * abs(off - on) / max(abs(off), abs(on), 1e-300)))
        return (
            f"{text}, equal to within {within} %. The angle stands still, so a model without time stands still, and a "
            "compensator cannot drift: it is the muscles that creep, and the integrator follows them in both cases."
        )
    return f"{text}: not equal, so more than the creep of the muscles is at work."


def harm_studies(result: Reproduction) -> tuple[Study, ...]:
    """Return the parts of "Where compensation hurts" that were measured."""
    makers = {SMALLER: _smaller, DOUBLE: _double, GAINS: _gains}
    return tuple(make(result.studies[name]) for name, make in makers.items() if name in result.studies)


def other_studies(result: Reproduction) -> tuple[Table, ...]:
    """Return studies of other names as plain tables."""
    known = {REST, SMALLER, DOUBLE, GAINS}
    return tuple(_table(short(name, 80), columns) for name, columns in result.studies.items() if name not in known)


def _numbers(values: Any) -> Array:
    return np.asarray(values, dtype=np.float64)


def _column(columns: Columns, study: str, name: str) -> Array:
    if name not in columns:
        raise ParameterError(
            f"the study {study!r} has no column {name!r}; it has {', '.join(map(str, columns)) or 'none'}. The report "
            f"draws it over that column: add it, or give the study another name to have it shown as a table.",
            study=study,
            column=name,
        )
    return _numbers(columns[name])


def _table(title: str, columns: Columns, limit: int = 60) -> Table:
    rows = list(zip(*(list(values) for values in columns.values()), strict=False))[:limit]
    cells = tuple(tuple(value if isinstance(value, str) else number(float(value)) for value in row) for row in rows)
    head = tuple(name.replace("_1_s", " [1/s]").replace("ratio_", "on/off, ").replace("_", " ") for name in columns)
    return Table(title, head, cells)


def _ratio_columns(columns: Columns, study: str) -> dict[str, Array]:
    """Columns that hold errors with compensator over errors without: "rms", "max"."""
    found = {
        name.removeprefix("ratio").strip("_") or "rms": v for name, v in columns.items() if name.startswith("ratio")
    }
    if not found:
        _column(columns, study, "ratio_rms")
    return {name: _numbers(values) for name, values in found.items()}


def _curves(across: Array, ratios: Mapping[str, Array], label: str, mark: float | None = None) -> Any:
    tokens: Sequence[Token] = (TRAIN, FIFTH)

    def draw(axes: Axes) -> None:
        window = Window.around(
            *((across, y) for y in ratios.values()), (across[:1], np.array([0.0])), (across[:1], np.array([1.1]))
        )
        label_axes(axes, window, label, "error with / without compensator")
        axes.axhline(1.0, color=MUTED.light, lw=1.1, ls=(0, (5, 3)))
        if mark is not None:
            axes.axvline(mark, color=TEST.light, lw=1.1, ls=(0, (1, 1.5)))
        for (name, y), token in zip(ratios.items(), tokens, strict=False):
            axes.plot(across, y, color=token.light, marker="o", ms=4.5, lw=1.4, label=name)

    return draw


def break_even(across: Array, ratio: Array) -> float | None:
    """Return where the ratio passes 1, by straight lines between the points; None if it never does.

    Examples
    --------
    >>> break_even(np.array([0.0, 0.5, 1.0]), np.array([2.0, 1.5, 0.5]))
    0.75
    """
    above = ratio > 1.0
    flips = np.flatnonzero(above[1:] != above[:-1])
    if flips.size == 0:
        return None
    k = int(flips[0])
    return float(across[k] + (1.0 - ratio[k]) / (ratio[k + 1] - ratio[k]) * (across[k + 1] - across[k]))


def _smaller(columns: Columns) -> Study:
    scale = _column(columns, SMALLER, "scale")
    order = np.argsort(scale)
    scale = scale[order]
    ratios = {name: y[order] for name, y in _ratio_columns(columns, SMALLER).items()}
    name, ratio = next(iter(ratios.items()))
    even = break_even(scale, ratio)
    best = int(np.argmin(ratio))
    tried = f"{number(scale[0])} to {number(scale[-1])} times the identified hysteresis"
    if even is None:
        side = "smaller" if np.all(ratio <= 1.0) else "larger"
        text = f"On plants with {tried} the {name} error is {side} with compensator than without."
    else:
        side = "less" if ratio[0] > 1.0 else "more"
        text = (
            f"Tried: {tried}. Break-even lies at {number(100 * even, 2)} %: a plant that has {side} is better left "
            f"alone. Most is gained at {number(100 * scale[best])} %, where {number(100 * ratio[best], 2)} % of the "
            f"{name} error are left."
        )
    picture = Picture(
        "Hysteresis of the plant over the identified one",
        (_curves(scale, ratios, "scale of the plant's hysteresis [1]", even),),
        says("Error with over error without compensator, over the plant's hysteresis.", text),
    )
    plate = Plate("smaller", "Another hysteresis than identified", "", (picture,))
    return Study(plate, (text,), _table("Scale of the hysteresis", columns))


def _double(columns: Columns) -> Study:
    names = next(([str(v) for v in values] for values in columns.values() if _are_words(values)), None)
    ratios = _ratio_columns(columns, DOUBLE)
    name, ratio = next(iter(ratios.items()))
    names = names or [f"case {number(v)}" for v in _numbers(columns.get("case", np.arange(ratio.size)))]
    worst, best = int(np.argmax(ratio)), int(np.argmin(ratio))
    text = (
        f"Least of the {name} error without compensator is left by “{short(names[best], 60)}”, "
        f"{number(100 * ratio[best])} %, most by “{short(names[worst], 60)}”, {number(100 * ratio[worst])} %."
    )
    if ratio[worst] > 1.0:
        text += " What is compensated twice is pushed to the other side: more is wrong than without any compensator."

    def draw(axes: Axes) -> None:
        y = np.arange(ratio.size)[::-1]
        axes.barh(y, ratio, height=0.5, color=[TEST.light if r > 1.0 else TRAIN.light for r in ratio])
        axes.axvline(1.0, color=MUTED.light, lw=1.1, ls=(0, (5, 3)))
        for k, value in enumerate(ratio.tolist()):
            axes.text(value, y[k], f" {number(value)}", va="center", ha="left", fontsize=9.8)
            axes.text(0.0, y[k] + 0.42, short(names[k], 50), va="center", ha="left", fontsize=9.8)
        label_axes(
            axes,
            Window(0.0, 1.18 * max(1.0, float(ratio.max())), -0.6, ratio.size - 0.25),
            "error with / without compensator",
            "",
        )
        axes.set_yticks([])
        axes.grid(axis="y", visible=False)
        axes.spines["left"].set_visible(False)

    height = max(1.2, 0.52 * ratio.size)
    picture = Picture("Who compensates", (draw,), says("Error ratio by case.", text), (height,), left=0.15, legends=0)
    plate = Plate("double", "Compensated twice", "", (picture,))
    return Study(plate, (text,), _table("Double compensation", columns))


def _are_words(values: Any) -> bool:
    return any(isinstance(value, str) for value in values)


def _gains(columns: Columns) -> Study:
    pole = _column(columns, GAINS, "pole_1_s")
    order = np.argsort(pole)
    ratios = {name: y[order] for name, y in _ratio_columns(columns, GAINS).items()}
    name, ratio = next(iter(ratios.items()))
    pole = pole[order]
    rises = ratio[-1] > ratio[0]
    text = (
        f"From λ = {number(pole[0], 2)} to {number(pole[-1], 2)} 1/s the {name} error with compensator goes from "
        f"{number(100 * ratio[0])} to {number(100 * ratio[-1])} % of that without: "
        + (
            "a stiff position loop takes away by itself what a compensator could."
            if rises
            else "the compensator is worth more in the stiffer loop here."
        )
    )
    even = break_even(pole, ratio)
    if even is not None:
        text += f" Beyond {number(even, 2)} 1/s it is better left off." if rises else ""
    picture = Picture(
        "Poles of the position loop",
        (_curves(pole, ratios, "λ [1/s]", even),),
        says("Error with over error without compensator, over the poles.", text),
    )
    plate = Plate("gains", "A stiff position loop", "", (picture,))
    return Study(plate, (text,), _table("Poles of the position loop", columns))
