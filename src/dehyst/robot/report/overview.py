"""The overview: rms errors without and with compensator, every plant, joint and trial in one figure."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

from dehyst.report.figures.panel import Axes, says
from dehyst.report.text import number, short
from dehyst.report.theme import AXIS, INK, MUTED, PAPER, TEST, TRAIN, Token
from dehyst.robot.experiments.results import PlantResult, Reproduction
from dehyst.robot.report.numbers import OFF, Spread, joints_of, left_off, trial_figure, trial_name, trials_of
from dehyst.robot.report.picture import Picture, Plate

ROW = 0.205  # inch
NAMES = 1.18


def overview_plate(result: Reproduction) -> Plate | None:
    """Return the overview, or None without figures."""
    joints, trials = joints_of(result), trials_of(result)
    if not joints or not trials:
        return None
    lines = [(plant, joint) for plant in result.plants for joint in joints]
    seeds = max(len(plant.figures) for plant in result.plants.values())
    height = ROW * (len(lines) + len(result.plants))
    pictures = tuple(
        Picture(
            trial_name(trial).capitalize(),
            (partial(_draw, result, trial, joints),),
            says(f"Trial {trial_name(trial)}: rms error of each joint on each plant, without and with compensator."),
            (height,),
            left=NAMES,
        )
        for trial in trials
    )
    spread = f" Bars: smallest to largest of {seeds} seeds." if seeds > 1 else ""
    return Plate(
        "overview",
        "All plants, joints and trials",
        "Rms error of the angle. The scale is logarithmic: equal lengths are equal factors, so the longer the line "
        f"between the two points, the more the compensator does.{_refused_words(result, joints)}{spread}",
        pictures,
        columns=3,
    )


def _refused_words(result: Reproduction, joints: tuple[int, ...]) -> str:
    if not any(left_off(plant, joint) for plant in result.plants.values() for joint in joints):
        return ""
    return " A point alone: the model was not accepted, and the compensator stayed off."


def _draw(result: Reproduction, trial: str, joints: tuple[int, ...], axes: Axes) -> None:
    values: list[float] = []

    def row(plant: PlantResult, k: int, y: float) -> None:
        off = trial_figure(plant, joints[k], trial, OFF, "rms_deg")
        on = trial_figure(plant, joints[k], trial, result.compensator, "rms_deg")
        _dumbbell(axes, y, off, None if left_off(plant, joints[k]) else on)
        values.extend(v for s in (off, on) if s is not None for v in (s.low, s.high) if v > 0)

    draw_rows(axes, result, [f"joint {joint}" for joint in joints], row, 0.1)
    _logarithmic(axes, values)
    axes.set_xlabel("rms error [°]")
    for token, label, filled in ((TEST, "without", False), (TRAIN, "with compensator", True)):
        axes.plot([], [], **dot(token, filled), ls="none", label=label)


def draw_rows(
    axes: Axes, result: Reproduction, names: Sequence[str], row: Callable[[PlantResult, int, float], None], gap: float
) -> None:
    """Draw plants under each other, each with a row a name: `row` draws the k-th one of a plant at a height."""
    y, ticks = 0.0, []
    for plant in result.plants.values():
        axes.text(
            -(NAMES - 0.06) / (4.7 - NAMES - 0.1), y, short(plant.plant, 17), transform=axes.get_yaxis_transform(),
            color=INK.light, fontweight="bold", fontsize=9.8, va="center", clip_on=False,
        )  # fmt: skip
        y += 0.9
        for k in range(len(names)):
            row(plant, k, y)
            ticks.append(y)
            y += 1.0
        y += gap
    axes.set_ylim(y - 0.2, -0.5)
    axes.set_yticks(ticks, [*names] * len(result.plants))
    axes.tick_params(axis="y", length=0)
    axes.grid(axis="y", visible=False)
    axes.spines["left"].set_visible(False)


def dot(token: Token, filled: bool) -> dict[str, object]:
    """Return how a point looks: a disk, or a ring."""
    face = token.light if filled else PAPER.light
    return {"marker": "o", "ms": 6.0, "mfc": face, "mec": token.light, "mew": 1.6}


def _dumbbell(axes: Axes, y: float, off: Spread | None, on: Spread | None) -> None:
    if off is not None and on is not None and off.mean > 0 and on.mean > 0:
        axes.plot([off.mean, on.mean], [y, y], color=AXIS.light, lw=1.3, zorder=2)
    for found, token, filled in ((off, TEST, False), (on, TRAIN, True)):
        if found is None or found.mean <= 0:
            continue
        if found.seeds > 1 and found.high > found.low > 0:
            axes.plot([found.low, found.high], [y, y], color=token.light, lw=3.2, alpha=0.55, zorder=3)
        axes.plot([found.mean], [y], **dot(token, filled), zorder=4)


def _logarithmic(axes: Axes, values: list[float]) -> None:
    axes.set_xscale("log")
    low, high = (min(values), max(values)) if values else (0.01, 1.0)
    low, high = low / 1.25, high * 1.25
    axes.set_xlim(low, high)
    ticks = [m * 10.0**e for e in range(-9, 7) for m in (1, 2, 5)]
    shown = [t for t in ticks if low <= t <= high]
    if len(shown) > 7:
        shown = [t for t in shown if np.isclose(np.log10(t) % 1.0, 0.0) or np.isclose(np.log10(t) % 1.0, 1.0)]
    axes.set_xticks(shown, [number(t, 1) for t in shown], color=MUTED.light)
    axes.minorticks_off()
