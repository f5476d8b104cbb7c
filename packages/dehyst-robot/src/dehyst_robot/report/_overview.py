"""Figures that compare plants: errors with and without compensator, and several compensators."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from functools import partial

import numpy as np

from dehyst.report import Axes, PageFigure, PageTable, Panel, PanelLine, ThemeColour, chart
from dehyst.report import kit as report_kit
from dehyst_robot.experiments import PlantResult, Reproduction
from dehyst_robot.experiments import kit as experiments_kit
from dehyst_robot.report._numbers import (
    OFF,
    Spread,
    cases_of,
    cell,
    first_cycle,
    joints_of,
    left_off,
    run_of,
    short_names,
    trial_figure,
    trial_name,
    trial_ratio,
    trials_of,
)
from dehyst_robot.report._words import FOREIGN, MECHANISMS

ROW = 0.205  # inch
NAMES = 1.18  # room for names left of the axes [inch]
FIGURES = ("rms_deg", "max_deg")
SHARES = (
    "Error of joint {joint} with each compensator over the error without; the scale is logarithmic, beyond the "
    "dashed line the error is larger than without."
)
Plants = Mapping[str, PlantResult]


def overview_figure(result: Reproduction) -> PageFigure | None:
    """Return rms errors without and with compensator, every plant, joint and trial; None without figures."""
    joints, trials = joints_of(result), trials_of(result)
    if not joints or not trials:
        return None
    caption = (
        "Rms error of the angle. The scale is logarithmic: equal lengths are equal factors, so the longer the line "
        "between the two points, the more the compensator does."
    )
    plants = result.plants.values()
    if any(left_off(plant, joint) for plant in plants for joint in joints):
        caption += " A point alone: the model was not accepted, and the compensator stayed off."
    seeds = max(len(plant.figures) for plant in plants)
    if seeds > 1:
        caption += f" Bars: smallest to largest of {seeds} seeds."
    height = ROW * len(plants) * (len(joints) + 1)
    panels = []
    for trial in trials:
        name = trial_name(trial)
        draw = partial(_draw_overview, result, trial, joints)
        words = (
            f"Trial {name}: rms error of each joint on each plant, without and with compensator."
        )
        panels.append(Panel(name.capitalize(), draw, words, (height,), left=NAMES))
    title = "All plants, joints and trials"
    return PageFigure("overview", title, caption, tuple(panels), columns=3)


def _draw_overview(result: Reproduction, trial: str, joints: Sequence[int], axes: Axes) -> None:
    values: list[float] = []
    places = _name_rows(axes, result.plants, [f"joint {joint}" for joint in joints], 0.1)
    for plant, row in zip(result.plants.values(), places, strict=True):
        for joint, y in zip(joints, row, strict=True):
            off = trial_figure(plant, joint, trial, OFF, "rms_deg")
            on = trial_figure(plant, joint, trial, result.compensator, "rms_deg")
            values += [*_positive_ends(off), *_positive_ends(on)]
            shown = [(off, report_kit.TEST, False), (on, report_kit.TRAIN, True)]
            # A compensator that stayed off has nothing to show.
            if left_off(plant, joint):
                shown.pop()
            points = []
            for spread, token, filled in shown:
                # A logarithmic scale has no place for zero.
                if spread is not None and spread.mean > 0:
                    points.append((spread, token, filled))
            _join(axes, y, [spread.mean for spread, *_ in points])
            for spread, token, filled in points:
                _mark(axes, y, spread, token, filled)
    low, high = min(values, default=0.01), max(values, default=1.0)
    # A fifth to both sides: no point lies on the frame.
    report_kit.logarithmic(axes, "x", low / 1.25, high * 1.25)
    axes.set_xlabel("rms error [°]")
    # Empty lines, for the legend alone.
    axes.plot([], [], **_dot(report_kit.TEST, False), ls="none", label="without")
    axes.plot([], [], **_dot(report_kit.TRAIN, True), ls="none", label="with compensator")


def _positive_ends(spread: Spread | None) -> list[float]:
    """Ends of a range that a logarithmic scale can show."""
    if spread is None:
        return []
    return [end for end in (spread.low, spread.high) if end > 0]


def _mark(axes: Axes, y: float, spread: Spread, token: ThemeColour, filled: bool) -> None:
    """A point at the mean, over a bar from the smallest to the largest of the seeds."""
    if spread.seeds > 1 and spread.high > spread.low > 0:
        ends = [spread.low, spread.high]
        axes.plot(ends, [y, y], color=token.light, lw=3.2, alpha=0.55, zorder=3)
    axes.plot([spread.mean], [y], **_dot(token, filled), zorder=4)


def _name_rows(axes: Axes, plants: Plants, names: Sequence[str], gap: float) -> list[list[float]]:
    """Name the rows: plants below each other, each with its names; return the heights of the rows, plant by plant."""
    y = 0.0
    places = []
    # Names of plants stand left of the axes, in units of its width.
    left = -(NAMES - 0.06) / (report_kit.WIDTH - NAMES - 0.1)
    for plant in plants.values():
        axes.text(
            left,
            y,
            report_kit.short(plant.plant, 17),
            transform=axes.get_yaxis_transform(),
            color=report_kit.INK.light,
            fontweight="bold",
            fontsize=9.8,
            va="center",
            clip_on=False,
        )
        # The name of the plant takes the row above those of its joints.
        places.append([y + 0.9 + k for k in range(len(names))])
        y += 0.9 + len(names) + gap
    # Upside down: the first plant stands at the top.
    axes.set_ylim(y - 0.2, -0.5)
    axes.set_yticks(list(itertools.chain(*places)), [*names] * len(plants))
    axes.tick_params(axis="y", length=0)
    axes.grid(axis="y", visible=False)
    axes.spines["left"].set_visible(False)
    return places


def _dot(token: ThemeColour, filled: bool) -> dict[str, object]:
    """How a point looks: a disk, or a ring."""
    look: dict[str, object] = {"marker": "o", "mec": token.light, "mew": 1.6}
    if filled:
        return look | {"ms": 6.0, "mfc": token.light}
    return look | {"ms": 5.6, "mfc": report_kit.PAPER.light}


def _join(axes: Axes, y: float, values: Sequence[float]) -> None:
    if len(values) > 1:
        axes.plot(values, [y] * len(values), color=report_kit.AXIS.light, lw=1.3, zorder=2)


def compared_figure(result: Reproduction, joint: int) -> PageFigure | None:
    """Return what each compensator leaves of a joint's errors on every plant; None for one compensator."""
    if len(result.compensators) < 2 or not trials_of(result):
        return None
    caption = SHARES.format(joint=joint)
    summaries = []
    for name in result.compensators:
        if name in experiments_kit.RECIPES:
            summary = experiments_kit.RECIPES[name].summary
            summaries.append(f"{report_kit.short(name, 30)}: {summary}")
    if summaries:
        caption += f" {'; '.join(summaries)}."
    table = _compared_table(result, result.plants, "Each compensator against none")
    panels = _compared_panels(result, result.plants, joint)
    return PageFigure(
        "compared", "Compensators side by side", caption, panels, columns=3, table=table
    )


def alone_figure(result: Reproduction, joint: int) -> PageFigure | None:
    """Return what each compensator leaves of a joint's errors on plants where it moved alone; None without these."""
    if not result.alone:
        return None
    caption = (
        f"The other joints are locked; all else is as with the plants above, with the first seed. "
        f"{SHARES.format(joint=joint)}"
    )
    foreign = [name for name in result.alone if name in FOREIGN]
    if foreign:
        caption += f" No compensator has the laws of {report_kit.listed(foreign)} among its terms."
    meanings = [f"{name}: {MECHANISMS[name]}" for name in result.alone if name in MECHANISMS]
    if meanings:
        caption += f" {'; '.join(meanings)}."
    title = f"Joint {joint} alone on other plants"
    table = _compared_table(result, result.alone, title)
    panels = _compared_panels(result, result.alone, joint)
    return PageFigure("alone", title, caption, panels, columns=3, table=table)


def _compared_panels(result: Reproduction, plants: Plants, joint: int) -> tuple[Panel, ...]:
    """A panel a trial: the share that each compensator leaves on each plant."""
    height = ROW * len(plants) * (len(result.compensators) + 1.1)
    panels = []
    for trial in trials_of(result):
        name = trial_name(trial)
        draw = partial(_draw_compared, result, plants, trial, joint)
        words = f"Trial {name}: share of joint {joint}'s error that each compensator leaves."
        panels.append(Panel(name.capitalize(), draw, words, (height,), left=NAMES))
    return tuple(panels)


def _draw_compared(
    result: Reproduction, plants: Plants, trial: str, joint: int, axes: Axes
) -> None:
    values = [1.0]
    names = short_names(result.compensators, 14)
    places = _name_rows(axes, plants, names, 0.2)
    for plant, row in zip(plants.values(), places, strict=True):
        for k, (name, y) in enumerate(zip(result.compensators, row, strict=True)):
            rms, largest = (trial_ratio(plant, joint, trial, name, figure) for figure in FIGURES)
            means = []
            for ratio, filled, order in ((rms, True, 4), (largest, False, 3)):
                values += _positive_ends(ratio)
                if ratio is not None and ratio.mean > 0:
                    axes.plot([ratio.mean], [y], **_dot(_token(k), filled), zorder=order)
                    means.append(ratio.mean)
            _join(axes, y, means)
    axes.axvline(1.0, color=report_kit.MUTED.light, lw=1.0, ls=report_kit.DASHED, zorder=1)
    report_kit.logarithmic(axes, "x", min(values) / 1.35, max(values) * 1.35)
    axes.set_xlabel("error with / without compensator")
    for filled, label in ((True, "rms"), (False, "largest")):
        axes.plot([], [], **_dot(report_kit.MUTED, filled), ls="none", label=label)


def _token(k: int) -> ThemeColour:
    return report_kit.CYCLE[k % len(report_kit.CYCLE)]


def _compared_table(result: Reproduction, plants: Plants, title: str) -> PageTable | None:
    """Every joint, trial and plant with the share that each compensator leaves."""
    rows = []
    for plant in plants.values():
        plant_name = report_kit.short(plant.plant, 20)
        for joint, trial in cases_of(result):
            rms, largest = (trial_figure(plant, joint, trial, OFF, name) for name in FIGURES)
            # A trial that was lost has no row.
            if rms is None:
                continue
            case = f"{plant_name}, joint {joint}, {trial_name(trial)}"
            shares = [_share(plant, joint, trial, name) for name in result.compensators]
            rows.append((case, f"{cell(rms)} | {cell(largest)}", *shares))
    if not rows:
        return None
    head = ("", "off, rms | max [°]", *short_names(result.compensators, 20))
    note = "Each compensator: its rms error over the one without | the same of the largest error; mean of the seeds."
    return PageTable(title, head, tuple(rows), note)


def _share(plant: PlantResult, joint: int, trial: str, compensator: str) -> str:
    shares = []
    for name in FIGURES:
        ratio = trial_ratio(plant, joint, trial, compensator, name)
        if ratio is None:
            shares.append("–")
        else:
            shares.append(report_kit.number(ratio.mean, 2))
    return " | ".join(shares)


def errors_figure(plant: PlantResult, joint: int, result: Reproduction) -> PageFigure | None:
    """Return the errors with every compensator below each other, all on one scale; None for one compensator."""
    if len(result.compensators) < 2:
        return None
    panels = []
    for trial in trials_of(result):
        runs = []
        for name in result.compensators:
            run = run_of(plant, trial, name)
            if run is not None:
                runs.append(run)
        if runs:
            panels.append(_errors(trial, joint, runs))
    if not panels:
        return None
    title = "What each compensator leaves over"
    caption = f"Error of joint {joint} over the first cycle; all compensators of a trial on the same scale."
    return PageFigure("compared-errors", title, caption, tuple(panels), columns=3)


def _errors(trial: str, joint: int, runs: Sequence[experiments_kit.TrialRun]) -> Panel:
    lines, reach = [], 1e-9
    for k, run in enumerate(runs):
        part = first_cycle(run)
        error = np.rad2deg(run.error[part, joint - 1])
        # One scale for all compensators of a trial: only then are they comparable.
        reach = max(reach, 1.06 * float(np.max(np.abs(error))))
        name = report_kit.short(run.compensator, 20)
        lines.append(PanelLine(run.time[part], error, _token(k), name, 1.1))
    names, rows = [], []
    for run, line in zip(runs, lines, strict=True):
        names.append(run.compensator)
        up = f"{report_kit.short(run.compensator, 12)} [°]"
        rows.append(chart("time [s]", up, [line], zero=True, reach=reach))
    alt = f"Trial {trial_name(trial)}: errors of joint {joint} over time with {', '.join(names)}."
    heights = (0.7,) * len(rows)
    return Panel(trial_name(trial).capitalize(), tuple(rows), alt, heights, legend=False)
