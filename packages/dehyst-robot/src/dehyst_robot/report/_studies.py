"""Report section on studies: a joint at rest, cases where compensation hurts, other tables."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from dehyst.arrays import Array
from dehyst.errors import ParameterError
from dehyst.report import Axes, Bar, Draw, PageFigure, PageTable, Panel, PanelLine, bars, chart
from dehyst.report import kit as report_kit
from dehyst_robot.experiments import Reproduction
from dehyst_robot.report._numbers import joints_of, left_off
from dehyst_robot.report._trials import OFF_LABEL, ON_LABEL

REST, SMALLER, DOUBLE, GAINS = "rest", "smaller hysteresis", "double compensation", "high gains"
WIDE = 10.0  # ratios that lie further apart are drawn over a logarithmic scale
RATIO = "error with / without compensator"

Columns = Mapping[str, Any]


def subject(result: Reproduction) -> tuple[str, int] | None:
    """Return plant and joint that the studies are of, the first of each; None without any."""
    joints = joints_of(result)
    if not result.plants or not joints:
        return None
    return next(iter(result.plants)), joints[0]


def subject_words(result: Reproduction) -> str:
    """Say what the studies are of: "Joint 1 alone on plant dahl."."""
    about = subject(result)
    if about is None:
        return ""
    plant, joint = about
    return f"Joint {joint} alone, plant {report_kit.short(plant, 40)}, first seed."


def nothing_to_study(result: Reproduction) -> str:
    """Say that the studies show nothing, because the compensator of their joint was left off; "" if it was not."""
    about = subject(result)
    if about is None or not result.studies:
        return ""
    plant, joint = about
    if not left_off(result.plants[plant], joint):
        return ""
    return (
        f"Not shown: the model of joint {joint} on plant {report_kit.short(plant, 40)} was not accepted, so its "
        "studies compare runs without compensator. Name a plant with hysteresis first to see them."
    )


def rest_study(result: Reproduction) -> PageFigure | None:
    """Return integrator and compensator at rest, or None if it was not measured."""
    columns = result.studies.get(REST)
    if columns is None or nothing_to_study(result):
        return None
    t = _column(columns, REST, "time_s")
    torques = {
        OFF_LABEL: _column(columns, REST, "integrator_off_Nm"),
        ON_LABEL: _column(columns, REST, "integrator_on_Nm"),
    }
    number = report_kit.number
    levels, slopes, rows = [], [], []
    for label, torque in torques.items():
        levels.append(float(np.mean(torque)))
        # A straight line: creep at rest is slow.
        slopes.append(float(np.polyfit(t - t[0], torque, 1)[0]))
        spread = float(np.ptp(torque))
        rows.append((label, number(levels[-1]), number(slopes[-1]), number(spread)))

    def pair(up: str, off: Array, on: Array) -> Draw:
        lines = [
            PanelLine(t, off, report_kit.TEST, OFF_LABEL, 1.5),
            PanelLine(t, on, report_kit.TRAIN, ON_LABEL, 1.5),
        ]
        return chart("time at rest [s]", up, lines)

    off, on = torques.values()
    return PageFigure(
        "rest",
        "At rest: integrator and compensator",
        f"{subject_words(result)} The joint has stopped on a loop and stands still; the integrator holds its angle. "
        "Both runs are the same but for the compensator.".strip(),
        (
            Panel(
                "Torque of the integrator",
                pair("integrator [Nm]", off, on),
                f"Levels {number(abs(levels[0] - levels[1]))} Nm apart.",
            ),
            Panel(
                "Its change since the stop",
                pair("change [Nm]", off - off[0], on - on[0]),
                f"Drifts {number(slopes[0])} and {number(slopes[1])} Nm/s.",
            ),
        ),
        table=PageTable("At rest", ("", "mean [Nm]", "drift [Nm/s]", "range [Nm]"), tuple(rows)),
    )


def harm_studies(result: Reproduction) -> tuple[PageFigure, ...]:
    """Return the parts of "Where compensation hurts" that were measured."""
    if nothing_to_study(result):
        return ()
    figures = []
    # In the order in which the page explains them.
    for name, make in ((SMALLER, _smaller), (DOUBLE, _double), (GAINS, _gains)):
        if name in result.studies:
            figures.append(make(result.studies[name]))
    return tuple(figures)


def _ratio_columns(columns: Columns, study: str) -> dict[str, Array]:
    """Columns that hold errors with compensator over errors without: "rms", "max"."""
    ratios = {}
    for name, values in columns.items():
        if name.startswith("ratio"):
            ratios[name.removeprefix("ratio").strip("_") or "rms"] = _numbers(values)
    # This says which column is missing.
    if not ratios:
        _column(columns, study, "ratio_rms")
    return ratios


def _over(columns: Columns, study: str, key: str) -> tuple[Array, dict[str, Array]]:
    """What was varied, rising, and the ratios in its order."""
    across = _column(columns, study, key)
    # The study may have been typed in any order.
    order = np.argsort(across)
    return across[order], {name: y[order] for name, y in _ratio_columns(columns, study).items()}


def _curves(across: Array, ratios: Mapping[str, Array], label: str, even: float | None) -> Draw:
    every = np.concatenate([*ratios.values(), [1.0]])
    low, high = float(every.min()), float(every.max())
    lines = []
    tokens = (report_kit.TRAIN, report_kit.FIFTH)
    for (name, y), token in zip(ratios.items(), tokens, strict=False):
        lines.append(PanelLine(across, y, token, name, 1.4, marker="o"))

    def more(axes: Axes) -> None:
        # A linear scale would press small ratios together.
        if low > 0.0 and high > WIDE * low:
            report_kit.logarithmic(axes, "y", low / 1.3, high * 1.3)
        axes.axhline(1.0, color=report_kit.MUTED.light, lw=1.1, ls=report_kit.DASHED)
        if even is not None:
            axes.axvline(even, color=report_kit.TEST.light, lw=1.1, ls=(0, (1, 1.5)))

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
    return float(
        across[k] + (1.0 - ratio[k]) / (ratio[k + 1] - ratio[k]) * (across[k + 1] - across[k])
    )


def _smaller(columns: Columns) -> PageFigure:
    scale, ratios = _over(columns, SMALLER, "scale")
    name, ratio = next(iter(ratios.items()))
    even = break_even(scale, ratio)
    caption = (
        ""
        if even is None
        else f"Break-even at {report_kit.number(even, 2)} times the identified hysteresis (dotted)."
    )
    draw = _curves(scale, ratios, "scale of the plant's hysteresis [1]", even)
    words = f"Error ratio, {name} first, over the plant's hysteresis. {caption}".strip()
    panel = Panel("Hysteresis of the plant over the identified one", draw, words)
    table = _table("Scale of the hysteresis", columns)
    return PageFigure(
        "smaller", "Another hysteresis than identified", caption, (panel,), table=table
    )


def _double(columns: Columns) -> PageFigure:
    ratios = _ratio_columns(columns, DOUBLE)
    name, ratio = next(iter(ratios.items()))
    rows = []
    for case, value in zip(_case_names(columns, ratio.size), ratio.tolist(), strict=False):
        # A bar beyond 1 does harm, and has the colour of the run without compensator.
        token = report_kit.TRAIN
        if value > 1.0:
            token = report_kit.TEST
        rows.append(Bar(report_kit.short(case, 50), value, token, report_kit.number(value)))
    draw = bars(rows, RATIO, edge=max(1.0, float(ratio.max())), level=1.0)
    height = max(1.2, 0.52 * ratio.size)
    panel = Panel("Who compensates", draw, f"Error ratio by case, {name}.", (height,))
    table = _table("Double compensation", columns)
    return PageFigure("double", "Compensated twice", "", (panel,), table=table)


def _case_names(columns: Columns, count: int) -> list[str]:
    """Names of the cases: the first column of words, else numbers."""
    for values in columns.values():
        if _are_words(values):
            return list(map(str, values))
    numbers = _numbers(columns.get("case", np.arange(count)))
    return [f"case {report_kit.number(number)}" for number in numbers]


def _gains(columns: Columns) -> PageFigure:
    pole, ratios = _over(columns, GAINS, "pole_1_s")
    name, ratio = next(iter(ratios.items()))
    even = break_even(pole, ratio)
    caption = ""
    if even is not None:
        caption = f"Break-even at {report_kit.number(even, 2)} 1/s (dotted)."
    words = f"Error ratio, {name} first, over the poles. {caption}".strip()
    panel = Panel("Poles of the position loop", _curves(pole, ratios, "λ [1/s]", even), words)
    table = _table("Poles of the position loop", columns)
    return PageFigure("gains", "A stiff position loop", caption, (panel,), table=table)


def other_studies(result: Reproduction) -> tuple[PageTable, ...]:
    """Return studies of other names as plain tables."""
    tables = []
    for name, columns in result.studies.items():
        if name not in (REST, SMALLER, DOUBLE, GAINS):
            tables.append(_table(report_kit.short(name, 80), columns, folded=False))
    return tuple(tables)


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


def _table(title: str, columns: Columns, *, folded: bool = True, limit: int = 60) -> PageTable:
    """The columns as a table of at most `limit` rows."""
    head, cells = [], []
    for name, values in columns.items():
        name = name.replace("_1_s", " [1/s]").replace("ratio_", "on/off, ").replace("_", " ")
        head.append(name)
        cells.append(list(map(_entry, values)))
    rows = tuple(zip(*cells, strict=False))[:limit]
    return PageTable(title, tuple(head), rows, folded=folded)


def _entry(value: str | float) -> str:
    if isinstance(value, str):
        return value
    return report_kit.number(float(value))
