"""Several compensators side by side: what each leaves of every error, in pictures and in a table."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np

from dehyst.report.figures.panel import Axes, says
from dehyst.report.tables import Table
from dehyst.report.text import number, short
from dehyst.report.theme import AXIS, CYCLE, MUTED, Token
from dehyst.robot.experiments.recipes import RECIPES
from dehyst.robot.experiments.results import PlantResult, Reproduction, TrialRun
from dehyst.robot.report.lines import Line, over_time
from dehyst.robot.report.numbers import (
    OFF,
    Spread,
    cell,
    joints_of,
    run_of,
    trial_figure,
    trial_name,
    trial_ratio,
    trials_of,
)
from dehyst.robot.report.overview import NAMES, ROW, dot, draw_rows
from dehyst.robot.report.picture import Picture, Plate
from dehyst.robot.report.trials import TIME, first_cycle

LEGIBLE = 1.35  # the scale ends this much beyond the points


def compared_plate(result: Reproduction, joint: int) -> Plate | None:
    """Return what each compensator leaves of a joint's errors on every plant, or None for one compensator."""
    trials = trials_of(result)
    if len(result.compensators) < 2 or not trials:
        return None
    height = ROW * (len(result.plants) * (len(result.compensators) + 1.1))
    pictures = tuple(
        Picture(
            trial_name(trial).capitalize(),
            (partial(_draw, result, trial, joint),),
            says(f"Trial {trial_name(trial)}: share of joint {joint}'s error that each compensator leaves."),
            (height,),
            left=NAMES,
        )
        for trial in trials
    )
    return Plate(
        "compared",
        "Compensators side by side",
        f"Error of joint {joint} with each compensator over the error without; the scale is logarithmic, beyond the "
        f"dashed line the error is larger than without. {_summaries(result.compensators)}",
        pictures,
        columns=3,
    )


def _summaries(names: Sequence[str]) -> str:
    told = [f"{short(name, 30)}: {RECIPES[name].summary}" for name in names if name in RECIPES]
    return f"{'; '.join(told)}." if told else ""


def _draw(result: Reproduction, trial: str, joint: int, axes: Axes) -> None:
    values = [1.0]

    def row(plant: PlantResult, k: int, y: float) -> None:
        name = result.compensators[k]
        found = [trial_ratio(plant, joint, trial, name, figure) for figure in ("rms_deg", "max_deg")]
        values.extend(share for one in found if one is not None for share in (one.low, one.high) if share > 0)
        _points(axes, y, found, _token(k))

    draw_rows(axes, result, [short(name, 14) for name in result.compensators], row, 0.2)
    axes.axvline(1.0, color=MUTED.light, lw=1.0, ls=(0, (5, 3)), zorder=1)
    axes.set_xscale("log")
    axes.set_xlim(min(values) / LEGIBLE, max(values) * LEGIBLE)
    shown = [
        t for t in (0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0) if min(values) / LEGIBLE <= t <= 5 * max(values)
    ]
    axes.set_xticks(shown, [number(t, 1) for t in shown], color=MUTED.light)
    axes.minorticks_off()
    axes.set_xlim(min(values) / LEGIBLE, max(values) * LEGIBLE)
    axes.set_xlabel("error with / without compensator")
    for filled, label in ((True, "rms"), (False, "largest")):
        axes.plot([], [], **_dot(MUTED, filled), ls="none", label=label)


def _token(k: int) -> Token:
    return CYCLE[k % len(CYCLE)]


def _dot(token: Token, filled: bool) -> dict[str, object]:
    return {**dot(token, filled), "ms": 6.0 if filled else 5.0, "mew": 1.5}


def _points(axes: Axes, y: float, found: Sequence[Spread | None], token: Token) -> None:
    told = [one for one in found if one is not None and one.mean > 0]
    if len(told) > 1:
        axes.plot([one.mean for one in told], [y] * len(told), color=AXIS.light, lw=1.3, zorder=2)
    for one, filled in zip(found, (True, False), strict=True):
        if one is not None and one.mean > 0:
            axes.plot([one.mean], [y], **_dot(token, filled), zorder=4 if filled else 3)


def errors_plate(plant: PlantResult, joint: int, result: Reproduction) -> Plate | None:
    """Return the errors with every compensator under each other, all on one scale, or None for one compensator."""
    if len(result.compensators) < 2:
        return None
    pictures = []
    for trial in trials_of(result):
        runs = [run for name in result.compensators if (run := run_of(plant, trial, name)) is not None]
        if runs:
            pictures.append(_errors(trial, joint, runs))
    if not pictures:
        return None
    return Plate(
        "compared-errors",
        "What each compensator leaves over",
        f"Error of joint {joint} over the first cycle; all compensators of a trial on the same scale.",
        tuple(pictures),
        columns=3,
    )


def _errors(trial: str, joint: int, runs: Sequence[TrialRun]) -> Picture:
    errors = [np.rad2deg(run.error[first_cycle(run), joint - 1]) for run in runs]
    reach = 1.06 * max(float(np.max(np.abs(error))) for error in errors)
    rows = tuple(
        over_time(
            run.time[first_cycle(run)],
            (Line(error, _token(k), short(run.compensator, 20), 1.1),),
            TIME,
            f"{short(run.compensator, 12)} [°]",
            reach=max(reach, 1e-9),
        )
        for k, (run, error) in enumerate(zip(runs, errors, strict=True))
    )
    alt = says(
        f"Trial {trial_name(trial)}: errors of joint {joint} over time with {', '.join(r.compensator for r in runs)}."
    )
    return Picture(trial_name(trial).capitalize(), rows, alt, (0.7,) * len(rows), legends=0)


def compared_table(result: Reproduction) -> Table | None:
    """Return every joint, trial and plant with the share that each compensator leaves, or None for one compensator."""
    if len(result.compensators) < 2:
        return None
    rows = []
    for plant in result.plants.values():
        for joint in joints_of(result):
            for trial in trials_of(result):
                off = [trial_figure(plant, joint, trial, OFF, name) for name in ("rms_deg", "max_deg")]
                if off[0] is None:
                    continue
                shares = (_pair(plant, joint, trial, name) for name in result.compensators)
                named = f"{short(plant.plant, 20)}, joint {joint}, {trial_name(trial)}"
                rows.append((named, " | ".join(map(cell, off)), *shares))
    head = ("", "off, rms | max [°]", *(short(name, 20) for name in result.compensators))
    note = "Each compensator: its rms error over the one without | the same of the largest error; mean of the seeds."
    return Table("Compensators side by side", head, tuple(rows), note) if rows else None


def _pair(plant: PlantResult, joint: int, trial: str, compensator: str) -> str:
    found = [trial_ratio(plant, joint, trial, compensator, name) for name in ("rms_deg", "max_deg")]
    return " | ".join("–" if one is None else number(one.mean, 2) for one in found)
