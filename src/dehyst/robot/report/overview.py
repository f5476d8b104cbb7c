"""Figures that compare plants: errors with and without compensator, and several compensators."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np

from dehyst.report.drawing import DASHED, Line, chart, logarithmic
from dehyst.report.parts import WIDTH, Axes, Figure, Panel, Table
from dehyst.report.text import number, short
from dehyst.report.theme import AXIS, CYCLE, INK, MUTED, PAPER, TEST, TRAIN, Token
from dehyst.robot.experiments.recipes import RECIPES
from dehyst.robot.experiments.results import PlantResult, Reproduction, TrialRun
from dehyst.robot.report.numbers import (
    OFF,
    Spread,
    cell,
    first_cycle,
    joints_of,
    left_off,
    run_of,
    trial_figure,
    trial_name,
    trial_ratio,
    trials_of,
)

ROW = 0.205  # inch
NAMES = 1.18  # room for names left of the axes [inch]
FIGURES = ("rms_deg", "max_deg")


def overview_figure(result: Reproduction) -> Figure | None:
    """Return rms errors without and with compensator, every plant, joint and trial; None without figures."""
    joints, trials = joints_of(result), trials_of(result)
    if not joints or not trials:
        return None
    seeds = max(len(plant.figures) for plant in result.plants.values())
    refused = any(left_off(plant, joint) for plant in result.plants.values() for joint in joints)
    return Figure(
        "overview",
        "All plants, joints and trials",
        "Rms error of the angle. The scale is logarithmic: equal lengths are equal factors, so the longer the line "
        "between the two points, the more the compensator does."
        + (" A point alone: the model was not accepted, and the compensator stayed off." if refused else "")
        + (f" Bars: smallest to largest of {seeds} seeds." if seeds > 1 else ""),
        tuple(
            Panel(
                trial_name(trial).capitalize(),
                partial(_draw_overview, result, trial, joints),
                f"Trial {trial_name(trial)}: rms error of each joint on each plant, without and with compensator.",
                (ROW * len(result.plants) * (len(joints) + 1),),
                left=NAMES,
            )
            for trial in trials
        ),
        columns=3,
    )


def _draw_overview(result: Reproduction, trial: str, joints: Sequence[int], axes: Axes) -> None:
    values: list[float] = []
    places = _name_rows(axes, result, [f"joint {joint}" for joint in joints], 0.1)
    for plant, row in zip(result.plants.values(), places, strict=True):
        for joint, y in zip(joints, row, strict=True):
            off, on = (trial_figure(plant, joint, trial, name, "rms_deg") for name in (OFF, result.compensator))
            both = [(off, TEST, False), (None if left_off(plant, joint) else on, TRAIN, True)]
            told = [(found, token, filled) for found, token, filled in both if found is not None and found.mean > 0]
            _join(axes, y, [found.mean for found, *_ in told])
            for found, token, filled in told:
                if found.seeds > 1 and found.high > found.low > 0:
                    axes.plot([found.low, found.high], [y, y], color=token.light, lw=3.2, alpha=0.55, zorder=3)
                axes.plot([found.mean], [y], **_dot(token, filled), zorder=4)
            values += [v for found in (off, on) if found for v in (found.low, found.high) if v > 0]
    logarithmic(axes, "x", min(values, default=0.01) / 1.25, max(values, default=1.0) * 1.25)
    axes.set_xlabel("rms error [°]")
    for token, label, filled in ((TEST, "without", False), (TRAIN, "with compensator", True)):
        axes.plot([], [], **_dot(token, filled), ls="none", label=label)


def _name_rows(axes: Axes, result: Reproduction, names: Sequence[str], gap: float) -> list[list[float]]:
    """Name the rows: plants below each other, each with its names; return the heights of the rows, plant by plant."""
    y, places = 0.0, []
    for plant in result.plants.values():
        axes.text(
            -(NAMES - 0.06) / (WIDTH - NAMES - 0.1), y, short(plant.plant, 17), transform=axes.get_yaxis_transform(),
            color=INK.light, fontweight="bold", fontsize=9.8, va="center", clip_on=False,
        )  # fmt: skip
        places.append([y + 0.9 + k for k in range(len(names))])
        y += 0.9 + len(names) + gap
    axes.set_ylim(y - 0.2, -0.5)
    axes.set_yticks([place for row in places for place in row], [*names] * len(result.plants))
    axes.tick_params(axis="y", length=0)
    axes.grid(axis="y", visible=False)
    axes.spines["left"].set_visible(False)
    return places


def _dot(token: Token, filled: bool) -> dict[str, object]:
    """How a point looks: a disk, or a ring."""
    face = token.light if filled else PAPER.light
    return {"marker": "o", "ms": 6.0 if filled else 5.6, "mfc": face, "mec": token.light, "mew": 1.6}


def _join(axes: Axes, y: float, values: Sequence[float]) -> None:
    if len(values) > 1:
        axes.plot(values, [y] * len(values), color=AXIS.light, lw=1.3, zorder=2)


def compared_figure(result: Reproduction, joint: int) -> Figure | None:
    """Return what each compensator leaves of a joint's errors on every plant; None for one compensator."""
    trials = trials_of(result)
    if len(result.compensators) < 2 or not trials:
        return None
    told = [f"{short(name, 30)}: {RECIPES[name].summary}" for name in result.compensators if name in RECIPES]
    return Figure(
        "compared",
        "Compensators side by side",
        f"Error of joint {joint} with each compensator over the error without; the scale is logarithmic, beyond the "
        f"dashed line the error is larger than without. {'; '.join(told)}{'.' if told else ''}",
        tuple(
            Panel(
                trial_name(trial).capitalize(),
                partial(_draw_compared, result, trial, joint),
                f"Trial {trial_name(trial)}: share of joint {joint}'s error that each compensator leaves.",
                (ROW * len(result.plants) * (len(result.compensators) + 1.1),),
                left=NAMES,
            )
            for trial in trials
        ),
        columns=3,
        table=_compared_table(result),
    )


def _draw_compared(result: Reproduction, trial: str, joint: int, axes: Axes) -> None:
    values = [1.0]
    places = _name_rows(axes, result, [short(name, 14) for name in result.compensators], 0.2)
    for plant, row in zip(result.plants.values(), places, strict=True):
        for k, (name, y) in enumerate(zip(result.compensators, row, strict=True)):
            found = [trial_ratio(plant, joint, trial, name, figure) for figure in FIGURES]
            _join(axes, y, [one.mean for one in found if one and one.mean > 0])
            for one, filled in zip(found, (True, False), strict=True):
                if one is not None and one.mean > 0:
                    axes.plot([one.mean], [y], **_dot(_token(k), filled), zorder=4 if filled else 3)
            values += [share for one in found if one for share in (one.low, one.high) if share > 0]
    axes.axvline(1.0, color=MUTED.light, lw=1.0, ls=DASHED, zorder=1)
    logarithmic(axes, "x", min(values) / 1.35, max(values) * 1.35)
    axes.set_xlabel("error with / without compensator")
    for filled, label in ((True, "rms"), (False, "largest")):
        axes.plot([], [], **_dot(MUTED, filled), ls="none", label=label)


def _token(k: int) -> Token:
    return CYCLE[k % len(CYCLE)]


def _compared_table(result: Reproduction) -> Table | None:
    """Every joint, trial and plant with the share that each compensator leaves."""
    rows = []
    for plant in result.plants.values():
        for joint in joints_of(result):
            for trial in trials_of(result):
                off = [trial_figure(plant, joint, trial, OFF, name) for name in FIGURES]
                if off[0] is not None:
                    named = f"{short(plant.plant, 20)}, joint {joint}, {trial_name(trial)}"
                    shares = (_share(plant, joint, trial, name) for name in result.compensators)
                    rows.append((named, " | ".join(map(cell, off)), *shares))
    head = ("", "off, rms | max [°]", *(short(name, 20) for name in result.compensators))
    note = "Each compensator: its rms error over the one without | the same of the largest error; mean of the seeds."
    return Table("Each compensator against none", head, tuple(rows), note) if rows else None


def _share(plant: PlantResult, joint: int, trial: str, compensator: str) -> str:
    found: list[Spread | None] = [trial_ratio(plant, joint, trial, compensator, name) for name in FIGURES]
    return " | ".join("–" if one is None else number(one.mean, 2) for one in found)


def errors_figure(plant: PlantResult, joint: int, result: Reproduction) -> Figure | None:
    """Return the errors with every compensator below each other, all on one scale; None for one compensator."""
    if len(result.compensators) < 2:
        return None
    found = {
        trial: [run for name in result.compensators if (run := run_of(plant, trial, name)) is not None]
        for trial in trials_of(result)
    }
    panels = tuple(_errors(trial, joint, runs) for trial, runs in found.items() if runs)
    caption = f"Error of joint {joint} over the first cycle; all compensators of a trial on the same scale."
    return (
        Figure("compared-errors", "What each compensator leaves over", caption, panels, columns=3) if panels else None
    )


def _errors(trial: str, joint: int, runs: Sequence[TrialRun]) -> Panel:
    errors = [np.rad2deg(run.error[first_cycle(run), joint - 1]) for run in runs]
    reach = max(1.06 * max(float(np.max(np.abs(error))) for error in errors), 1e-9)
    rows = tuple(
        chart(
            "time [s]",
            f"{short(run.compensator, 12)} [°]",
            [Line(run.time[first_cycle(run)], error, _token(k), short(run.compensator, 20), 1.1)],
            zero=True,
            reach=reach,
        )
        for k, (run, error) in enumerate(zip(runs, errors, strict=True))
    )
    names = ", ".join(run.compensator for run in runs)
    alt = f"Trial {trial_name(trial)}: errors of joint {joint} over time with {names}."
    return Panel(trial_name(trial).capitalize(), rows, alt, (0.7,) * len(rows), legend=False)
