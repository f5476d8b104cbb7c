"""Report section on studies: a joint at rest, cases where compensation hurts, other tables."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from dehyst.arrays import Array
from dehyst.errors import ParameterError
from dehyst.report.drawing import DASHED, Bar, Line, bars, chart, logarithmic
from dehyst.report.parts import Axes, Draw, Figure, Panel, Table
from dehyst.report.text import number, short
from dehyst.report.theme import FIFTH, MUTED, TEST, TRAIN
from dehyst.robot.experiments.results import Reproduction
from dehyst.robot.report.numbers import joints_of, left_off
from dehyst.robot.report.trials import OFF_LABEL, ON_LABEL

REST, SMALLER, DOUBLE, GAINS = "rest", "smaller hysteresis", "double compensation", "high gains"
WIDE = 10.0  # ratios that lie further apart are drawn over a logarithmic scale
ALIKE = 0.1  # twice is called as bad as never when its ratio is this close to 1
EQUAL = 0.2  # two drifts are called equal when they differ by less than this share of the larger one
RATIO = "error with / without compensator"

Columns = Mapping[str, Any]


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


def rest_study(result: Reproduction) -> Figure | None:
    """Return integrator and compensator at rest, or None if it was not measured."""
    columns = result.studies.get(REST)
    if columns is None or nothing_to_study(result):
        return None
    t, off, on = (_column(columns, REST, name) for name in ("time_s", "integrator_off_Nm", "integrator_on_Nm"))
    levels = [float(np.mean(torque)) for torque in (off, on)]
    slopes = [float(np.polyfit(t - t[0], torque, 1)[0]) for torque in (off, on)]
    apart = number(abs(levels[0] - levels[1]))

    def pair(up: str, *torques: Array) -> Draw:
        looks = zip(torques, (TEST, TRAIN), (OFF_LABEL, ON_LABEL), strict=True)
        lines = [Line(t, torque, token, label, 1.5) for torque, token, label in looks]
        return chart("time at rest [s]", up, lines)

    rows = tuple(
        (label, number(level), number(slope), number(float(np.ptp(torque))))
        for label, level, slope, torque in zip((OFF_LABEL, ON_LABEL), levels, slopes, (off, on), strict=True)
    )
    return Figure(
        "rest",
        "At rest: integrator and compensator",
        f"{subject_words(result)} The joint has stopped on a loop and stands still; the integrator holds its angle. "
        "Both runs are the same but for the compensator.".strip(),
        (
            Panel("Torque of the integrator", pair("integrator [Nm]", off, on), f"Levels {apart} Nm apart."),
            Panel(
                "Its change since the stop",
                pair("change [Nm]", off - off[0], on - on[0]),
                f"Drifts {number(slopes[0])} and {number(slopes[1])} Nm/s.",
            ),
        ),
        points=(
            f"Level: {number(levels[0])} Nm without and {number(levels[1])} Nm with compensator, {apart} Nm apart. "
            "The difference is the torque that the compensator adds there, and the integrator therefore need not.",
            f"{_drift(*slopes)}{_slowing(t, off)}",
        ),
        table=Table("At rest", ("", "mean [Nm]", "drift [Nm/s]", "range [Nm]"), rows),
    )


def _slowing(t: Array, torque: Array) -> str:
    """Whether the drift of the first half is faster than that of the second, as that of creep is."""
    half = t.size // 2
    early, late = (float(np.polyfit(t[part], torque[part], 1)[0]) for part in (slice(0, half), slice(half, None)))
    if abs(late) >= 0.8 * abs(early) or early * late < 0.0:
        return ""
    return (
        f" It slows down, from {number(early)} Nm/s in the first {number(float(t[half] - t[0]), 2)} s to "
        f"{number(late)} Nm/s after them (without compensator), as creep does."
    )


def _drift(off: float, on: float) -> str:
    text = f"Drift: {number(off)} Nm/s without and {number(on)} Nm/s with compensator"
    if abs(off - on) <= EQUAL * max(abs(off), abs(on)):
        within = max(1, math.ceil(100 * abs(off - on) / max(abs(off), abs(on), 1e-300)))
        return (
            f"{text}, equal to within {within} %. The angle stands still, so a model without time stands still, and a "
            "compensator cannot drift: it is the muscles that creep, and the integrator follows them in both cases."
        )
    return f"{text}: not equal, so more than the creep of the muscles is at work."


def harm_studies(result: Reproduction) -> tuple[Figure, ...]:
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
        _column(columns, study, "ratio_rms")
    return {name: _numbers(values) for name, values in found.items()}


def _over(columns: Columns, study: str, key: str) -> tuple[Array, dict[str, Array]]:
    """What was varied, rising, and the ratios in its order."""
    across = _column(columns, study, key)
    order = np.argsort(across)
    return across[order], {name: y[order] for name, y in _ratio_columns(columns, study).items()}


def _curves(across: Array, ratios: Mapping[str, Array], label: str, even: float | None) -> Draw:
    every = np.concatenate([*ratios.values(), [1.0]])
    lines = [
        Line(across, y, token, name, 1.4, marker="o")
        for (name, y), token in zip(ratios.items(), (TRAIN, FIFTH), strict=False)
    ]

    def more(axes: Axes) -> None:
        if every.min() > 0.0 and every.max() > WIDE * every.min():
            logarithmic(axes, "y", float(every.min()) / 1.3, float(every.max()) * 1.3)
        axes.axhline(1.0, color=MUTED.light, lw=1.1, ls=DASHED)
        if even is not None:
            axes.axvline(even, color=TEST.light, lw=1.1, ls=(0, (1, 1.5)))

    return chart(label, RATIO, lines, include=(0.0, 1.1), also=more)


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


def _smaller(columns: Columns) -> Figure:
    scale, ratios = _over(columns, SMALLER, "scale")
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
            f"%, where {number(100 * ratio[best], 2)} % of the {name} error is left."
        )
        if scale[0] == 0.0 and ratio[0] > 1.0:
            text += (
                f" Without any hysteresis the compensator makes the error {number(ratio[0], 2)} times as large: that "
                "is why a model is switched on only after it was tested."
            )
    title, draw = (
        "Another hysteresis than identified",
        _curves(scale, ratios, "scale of the plant's hysteresis [1]", even),
    )
    words = f"Error with over error without compensator, over the plant's hysteresis. {text}"
    panel = Panel("Hysteresis of the plant over the identified one", draw, words)
    return Figure("smaller", title, "", (panel,), points=(text,), table=_table("Scale of the hysteresis", columns))


def _double(columns: Columns) -> Figure:
    names = next(([str(v) for v in values] for values in columns.values() if _are_words(values)), None)
    ratios = _ratio_columns(columns, DOUBLE)
    name, ratio = next(iter(ratios.items()))
    names = names or [f"case {number(v)}" for v in _numbers(columns.get("case", np.arange(ratio.size)))]
    text = _double_words(dict(zip(names, ratio.tolist(), strict=False)), name)
    rows = [
        Bar(short(case, 50), value, TEST if value > 1.0 else TRAIN, number(value))
        for case, value in zip(names, ratio.tolist(), strict=False)
    ]
    draw = bars(rows, RATIO, edge=max(1.0, float(ratio.max())), level=1.0)
    panel = Panel("Who compensates", draw, f"Error ratio by case. {text}", (max(1.2, 0.52 * ratio.size),))
    table = _table("Double compensation", columns)
    return Figure("double", "Compensated twice", "", (panel,), points=(text,), table=table)


def _double_words(ratios: Mapping[str, float], name: str) -> str:
    once, twice = ratios.get("once"), ratios.get("twice")
    if once is None or twice is None:
        best, worst = (find(ratios, key=lambda case: ratios[case]) for find in (min, max))
        return (
            f"Least of the {name} error without compensator is left by “{short(best, 60)}”, "
            f"{number(100 * ratios[best])} %, most by “{short(worst, 60)}”, {number(100 * ratios[worst])} %."
        )
    text = (
        f"Compensated once, {number(100 * once)} % of the {name} error is left; once more by something that does not "
        f"know of the first, {number(100 * twice)} %."
    )
    if twice <= once:
        return f"{text} The second one does not hurt here."
    against = "as bad as no compensator" if abs(twice - 1.0) <= ALIKE else "worse than none" if twice > 1.0 else ""
    why = "the hysteresis that was taken away comes back with the opposite sign"
    return f"{text} That is {against}: {why}." if against else f"{text} Part of {why[4:]}."


def _gains(columns: Columns) -> Figure:
    pole, ratios = _over(columns, GAINS, "pole_1_s")
    name, ratio = next(iter(ratios.items()))
    rises = ratio[-1] > ratio[0]
    why = (
        "a stiffer position loop takes away by itself part of what a compensator could, and what the compensator "
        "does wrong stays."
        if rises
        else "the compensator is worth more in the stiffer loop here."
    )
    text = (
        f"From λ = {number(pole[0], 2)} to {number(pole[-1], 2)} 1/s the {name} error with compensator goes from "
        f"{number(100 * ratio[0])} to {number(100 * ratio[-1])} % of that without: {why}"
    )
    even = break_even(pole, ratio)
    if even is not None:
        text += f" Beyond {number(even, 2)} 1/s it is better left off." if rises else ""
    elif np.all(ratio < 1.0):
        text += " It pays at all of them."
    words = f"Error with over error without compensator, over the poles. {text}"
    panel = Panel("Poles of the position loop", _curves(pole, ratios, "λ [1/s]", even), words)
    table = _table("Poles of the position loop", columns)
    return Figure("gains", "A stiff position loop", "", (panel,), points=(text,), table=table)


def other_studies(result: Reproduction) -> tuple[Table, ...]:
    """Return studies of other names as plain tables."""
    known = {REST, SMALLER, DOUBLE, GAINS}
    others = {name: columns for name, columns in result.studies.items() if name not in known}
    return tuple(_table(short(name, 80), columns, folded=False) for name, columns in others.items())


def _are_words(values: Any) -> bool:
    return any(isinstance(value, str) for value in values)


def _numbers(values: Any) -> Array:
    return np.asarray(values, dtype=np.float64)


def _column(columns: Columns, study: str, name: str) -> Array:
    """A column by its name, (N,)."""
    if name not in columns:
        raise ParameterError(
            f"the study {study!r} has no column {name!r}; it has {', '.join(map(str, columns)) or 'none'}. The report "
            f"draws it over that column: add it, or give the study another name to have it shown as a table.",
            study=study,
            column=name,
        )
    return _numbers(columns[name])


def _table(title: str, columns: Columns, *, folded: bool = True, limit: int = 60) -> Table:
    """The columns as a table of at most `limit` rows."""
    rows = list(zip(*(list(values) for values in columns.values()), strict=False))[:limit]
    cells = tuple(tuple(value if isinstance(value, str) else number(float(value)) for value in row) for row in rows)
    head = tuple(name.replace("_1_s", " [1/s]").replace("ratio_", "on/off, ").replace("_", " ") for name in columns)
    return Table(title, head, cells, folded=folded)
