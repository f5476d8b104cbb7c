"""Studies on the page: where compensation hurts, and those that nobody foresaw: figure, sentences, table."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from dehyst.arrays import Array
from dehyst.errors import ParameterError
from dehyst.report.figures.panel import Axes, label_axes, says
from dehyst.report.tables import Table
from dehyst.report.text import number, short
from dehyst.report.theme import FIFTH, MUTED, TEST, TRAIN, Token
from dehyst.report.thin import Window
from dehyst.robot.experiments.results import Reproduction
from dehyst.robot.report.numbers import joints_of, left_off
from dehyst.robot.report.picture import Picture, Plate

WIDE = 10.0  # ratios that lie further apart are drawn over a logarithmic scale
EQUAL = 0.1  # twice is called as bad as never when its ratio is this close to 1


def harm_studies(result: Reproduction) -> tuple[Study, ...]:
    """Return the parts of "Where compensation hurts" that were measured."""
    if nothing_to_study(result):
        return ()
    makers = {SMALLER: _smaller, DOUBLE: _double, GAINS: _gains}
    return tuple(make(result.studies[name]) for name, make in makers.items() if name in result.studies)


def _ratio_columns(columns: Columns, study: str) -> dict[str, Array]:
    """Columns that hold errors with compensator over errors without: "rms", "max"."""
    found = {
        name.removeprefix("ratio").strip("_") or "rms": v for name, v in columns.items() if name.startswith("ratio")
    }
    if not found:
        column(columns, study, "ratio_rms")
    return {name: numbers_of(values) for name, values in found.items()}


def _curves(across: Array, ratios: Mapping[str, Array], label: str, mark: float | None = None) -> Any:
    tokens: Sequence[Token] = (TRAIN, FIFTH)

    every = np.concatenate([*ratios.values(), [1.0]])
    wide = bool(every.min() > 0.0 and every.max() > WIDE * every.min())

    def draw(axes: Axes) -> None:
        window = Window.around(
            *((across, y) for y in ratios.values()), (across[:1], np.array([0.0])), (across[:1], np.array([1.1]))
        )
        label_axes(axes, window, label, "error with / without compensator")
        if wide:
            logarithmic(axes, float(every.min()), float(every.max()))
        axes.axhline(1.0, color=MUTED.light, lw=1.1, ls=(0, (5, 3)))
        if mark is not None:
            axes.axvline(mark, color=TEST.light, lw=1.1, ls=(0, (1, 1.5)))
        for (name, y), token in zip(ratios.items(), tokens, strict=False):
            axes.plot(across, y, color=token.light, marker="o", ms=4.5, lw=1.4, label=name)

    return draw


def logarithmic(axes: Axes, low: float, high: float) -> None:
    """Make the ordinate logarithmic, with plain numbers at 1, 2 and 5."""
    axes.set_yscale("log")
    axes.set_ylim(low / 1.3, high * 1.3)
    ticks = [m * 10.0**e for e in range(-6, 7) for m in (1, 2, 5) if low / 1.3 <= m * 10.0**e <= high * 1.3]
    axes.set_yticks(ticks, [f"{tick:g}" for tick in ticks], color=MUTED.light)
    axes.minorticks_off()


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
    scale = column(columns, SMALLER, "scale")
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
            f"Tried: {tried}. Break-even, by straight lines between the points, lies at {number(100 * even, 2)} % of "
            f"it (dotted): a plant that has {side} is better left alone. Most is gained at {number(100 * scale[best])} "
            f"%, where {number(100 * ratio[best], 2)} % of the {name} error are left."
        )
        if scale[0] == 0.0 and ratio[0] > 1.0:
            text += (
                f" Without any hysteresis the compensator makes the error {number(ratio[0], 2)} times as large: that "
                "is why a model is switched on only after it was tested."
            )
    picture = Picture(
        "Hysteresis of the plant over the identified one",
        (_curves(scale, ratios, "scale of the plant's hysteresis [1]", even),),
        says("Error with over error without compensator, over the plant's hysteresis.", text),
    )
    plate = Plate("smaller", "Another hysteresis than identified", "", (picture,))
    return Study(plate, (text,), replace(table_of("Scale of the hysteresis", columns), folded=True))


def _double(columns: Columns) -> Study:
    names = next(([str(v) for v in values] for values in columns.values() if _are_words(values)), None)
    ratios = _ratio_columns(columns, DOUBLE)
    name, ratio = next(iter(ratios.items()))
    names = names or [f"case {number(v)}" for v in numbers_of(columns.get("case", np.arange(ratio.size)))]
    text = _double_words(dict(zip(names, ratio.tolist(), strict=False)), name)

    def draw(axes: Axes) -> None:
        y = np.arange(ratio.size)[::-1]
        axes.barh(y, ratio, height=0.5, color=[TEST.light if r > 1.0 else TRAIN.light for r in ratio])
        axes.axvline(1.0, color=MUTED.light, lw=1.1, ls=(0, (5, 3)))
        for k, value in enumerate(ratio.tolist()):
            beside = 1.0 if 0.8 < value <= 1.0 else value  # the number stands clear of the dashed line
            axes.annotate(number(value), (beside, y[k]), (5, 0), textcoords="offset points", va="center", fontsize=9.8)
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
    return Study(plate, (text,), replace(table_of("Double compensation", columns), folded=True))


def _double_words(ratios: Mapping[str, float], name: str) -> str:
    once, twice = ratios.get("once"), ratios.get("twice")
    if once is None or twice is None:
        best, worst = (find(ratios, key=lambda case: ratios[case]) for find in (min, max))
        return (
            f"Least of the {name} error without compensator is left by “{short(best, 60)}”, "
            f"{number(100 * ratios[best])} %, most by “{short(worst, 60)}”, {number(100 * ratios[worst])} %."
        )
    text = (
        f"Compensated once, {number(100 * once)} % of the {name} error are left; once more by something that does not "
        f"know of the first, {number(100 * twice)} %."
    )
    if twice <= once:
        return f"{text} The second one does not hurt here."
    against = "as bad as no compensator" if abs(twice - 1.0) <= EQUAL else "worse than none" if twice > 1.0 else ""
    why = "the hysteresis that was taken away comes back with the opposite sign"
    return f"{text} That is {against}: {why}." if against else f"{text} Part of {why[4:]}."


def _are_words(values: Any) -> bool:
    return any(isinstance(value, str) for value in values)


def _gains(columns: Columns) -> Study:
    pole = column(columns, GAINS, "pole_1_s")
    order = np.argsort(pole)
    ratios = {name: y[order] for name, y in _ratio_columns(columns, GAINS).items()}
    name, ratio = next(iter(ratios.items()))
    pole = pole[order]
    rises = ratio[-1] > ratio[0]
    text = (
        f"From λ = {number(pole[0], 2)} to {number(pole[-1], 2)} 1/s the {name} error with compensator goes from "
        f"{number(100 * ratio[0])} to {number(100 * ratio[-1])} % of that without: "
        + (
            "a stiffer position loop takes away by itself part of what a compensator could, and what the compensator "
            "does wrong stays."
            if rises
            else "the compensator is worth more in the stiffer loop here."
        )
    )
    even = break_even(pole, ratio)
    if even is not None:
        text += f" Beyond {number(even, 2)} 1/s it is better left off." if rises else ""
    elif np.all(ratio < 1.0):
        text += " It pays at all of them."
    picture = Picture(
        "Poles of the position loop",
        (_curves(pole, ratios, "λ [1/s]", even),),
        says("Error with over error without compensator, over the poles.", text),
    )
    plate = Plate("gains", "A stiff position loop", "", (picture,))
    return Study(plate, (text,), replace(table_of("Poles of the position loop", columns), folded=True))


Columns = Mapping[str, Any]

REST, SMALLER, DOUBLE, GAINS = "rest", "smaller hysteresis", "double compensation", "high gains"


@dataclass(frozen=True)
class Study:
    """A part of the page: a figure, sentences about it, a table."""

    plate: Plate
    words: tuple[str, ...]
    table: Table | None = None


def subject(result: Reproduction) -> tuple[str, int] | None:
    """Return plant and joint that the studies are of, the first of each; None without any."""
    joints = joints_of(result)
    return (next(iter(result.plants)), joints[0]) if result.plants and joints else None


def subject_words(result: Reproduction) -> str:
    """Say what the studies are of: "Joint 1 alone on plant dahl."."""
    about = subject(result)
    return "" if about is None else f"Joint {about[1]} alone, plant {short(about[0], 40)}, first seed."


def nothing_to_study(result: Reproduction) -> str:
    """Say that the studies show nothing, because the compensator of their joint was left off; "" if it was not."""
    about = subject(result)
    if about is None or not result.studies or not left_off(result.plants[about[0]], about[1]):
        return ""
    return (
        f"The studies at rest and of where compensation hurts were run on joint {about[1]} of plant "
        f"{short(about[0], 40)}, whose model was not accepted: no compensator was switched on, so they would compare a "
        "run with itself. Name a plant with hysteresis first to see them."
    )


def other_studies(result: Reproduction) -> tuple[Table, ...]:
    """Return studies of other names as plain tables."""
    known = {REST, SMALLER, DOUBLE, GAINS}
    return tuple(table_of(short(name, 80), columns) for name, columns in result.studies.items() if name not in known)


def numbers_of(values: Any) -> Array:
    """Return a column as numbers, (N,)."""
    return np.asarray(values, dtype=np.float64)


def column(columns: Columns, study: str, name: str) -> Array:
    """Return a column by its name, (N,); raise `ParameterError` if the study has none of that name."""
    if name not in columns:
        raise ParameterError(
            f"the study {study!r} has no column {name!r}; it has {', '.join(map(str, columns)) or 'none'}. The report "
            f"draws it over that column: add it, or give the study another name to have it shown as a table.",
            study=study,
            column=name,
        )
    return numbers_of(columns[name])


def table_of(title: str, columns: Columns, limit: int = 60) -> Table:
    """Return the columns as a table of at most `limit` rows."""
    rows = list(zip(*(list(values) for values in columns.values()), strict=False))[:limit]
    cells = tuple(tuple(value if isinstance(value, str) else number(float(value)) for value in row) for row in rows)
    head = tuple(name.replace("_1_s", " [1/s]").replace("ratio_", "on/off, ").replace("_", " ") for name in columns)
    return Table(title, head, cells)
