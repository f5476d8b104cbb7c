"""Figures 7 and 8 of the paper: the trials without and with compensator, in the joints and at the tool."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial

import numpy as np

from dehyst.arrays import Array
from dehyst.report import Axes, Draw, PageFigure, Panel, PanelLine, chart
from dehyst.report import kit as report_kit
from dehyst_robot.experiments import PlantResult
from dehyst_robot.experiments import kit as experiments_kit
from dehyst_robot.report._numbers import (
    OFF,
    Pair,
    first_cycle,
    pair_of,
    same_run,
    short_names,
    tool_figures,
    trial_figure,
    trial_name,
)

TIME = "time [s]"
ON_LABEL, OFF_LABEL, SAME_LABEL = (
    "with compensator",
    "without",
    "without; with it the same, left off",
)
SIDES = ((report_kit.TEST, OFF_LABEL), (report_kit.TRAIN, ON_LABEL))


def trial_drawings(
    plant: PlantResult, joint: int, other_joints: Sequence[int], pairs: Mapping[str, Pair]
) -> list[PageFigure]:
    """Return figure 7 of a joint, and the errors of the other joints; nothing without runs.

    `pairs` holds the runs of each trial without and with compensator.
    """
    pairs = {trial: pair for trial, pair in pairs.items() if any(pair)}
    if not pairs:
        return []
    # The bands are the same in all trials: the first one explains them.
    words = _band_words(_first_run(next(iter(pairs.values()))))
    panels = [_four_rows(plant, joint, trial, pair) for trial, pair in pairs.items()]
    figures = [
        PageFigure(
            "trials",
            "Trials: angle, errors and integrator",
            f"Joint {joint}, first cycle. {words} Every panel has its own scale. Torque error: what the inverse "
            f"dynamics ask, less what the measured pressures give by characteristic and compensator. "
            f"{_integrator_words(pairs, joint)}",
            tuple(panels),
            columns=3,
            number="7",
        )
    ]
    if other_joints:
        noun = report_kit.count(len(other_joints), "joint").partition(" ")[2]
        # If no compensator was switched on, the sentence must not say that one was.
        compensated = "and are compensated "
        if all(same_run(*pair) for pair in pairs.values()):
            compensated = ""
        panels = [_error_rows(other_joints, trial, pair) for trial, pair in pairs.items()]
        figures.append(
            PageFigure(
                "trials-others",
                f"The same trials, {noun} {' and '.join(map(str, other_joints))}",
                f"All joints move {compensated}at once; the paper left these open. Every panel has its own scale.",
                tuple(panels),
                columns=3,
            )
        )
    return figures


def _first_run(pair: Pair) -> experiments_kit.TrialRun:
    """The run without compensator, or the one with it where that is missing."""
    run = pair[0] or pair[1]
    assert run is not None
    return run


def _integrator_words(pairs: Mapping[str, Pair], joint: int) -> str:
    """What the integrator has to do in each trial, over all cycles."""
    sentences = []
    for trial, (off, on) in pairs.items():
        if off is None or on is None:
            continue
        torques = off.integrator[:, joint - 1], on.integrator[:, joint - 1]
        # In one trial the integrator is switched off: there is nothing to say of it.
        if not torques[0].any() and not torques[1].any():
            continue
        without, with_it = (report_kit.number(float(np.sqrt(np.mean(y**2)))) for y in torques)
        words = f"{without} Nm"
        if not same_run(off, on):
            words = f"{without} Nm without, {with_it} Nm with compensator"
        sentences.append(f"{trial_name(trial)} {words}")
    if not sentences:
        return ""
    return f"Torque of the integrator, rms: {'; '.join(sentences)}."


def _rows(
    pair: Pair,
    up: str,
    value: Callable[[experiments_kit.TrialRun], Array],
    reach: float | None = None,
) -> Draw:
    """A value of both runs over the first cycle, the figures of the path shaded."""
    sides = list(zip(pair, SIDES, strict=True))
    # One line where both are the same run: the second would hide the first.
    if same_run(*pair):
        sides = [(pair[0], (report_kit.TEST, SAME_LABEL))]
    lines = []
    for run, (token, label) in sides:
        if run is not None:
            part = first_cycle(run)
            lines.append(PanelLine(run.time[part], value(run)[part], token, label, 1.3))
    return chart(TIME, up, lines, zero=True, reach=reach, bands=_bands(pair))


def _band_words(run: experiments_kit.TrialRun) -> str:
    # One figure without a way to it needs no band.
    if len(run.figures) == 1 and not (run.figure < 0).any():
        return ""
    order = ", ".join(short_names(run.figures, 30))
    if (run.figure < 0).any():
        return f"Grey bands: figures of the path, in the order {order}; between them the way to the next."
    return f"The path's figures are {order}; grey bands mark every other one."


def _bands(pair: Pair) -> list[tuple[float, float]]:
    """From when to when a figure of the path is followed; of figures without a way between them, every other one."""
    run = _first_run(pair)
    figure, t = run.figure[first_cycle(run)], run.time[first_cycle(run)]
    # A figure begins where its number changes; −1 is the way between two.
    starts = np.concatenate([[0], np.flatnonzero(np.diff(figure)) + 1]).astype(np.int64)
    ends = np.append(starts[1:], figure.size) - 1
    shown = figure[starts] >= 0
    if not (figure < 0).any():
        shown = np.arange(starts.size) % 2 == 1
    return list(zip(t[starts[shown]].tolist(), t[ends[shown]].tolist(), strict=True))


def _four_rows(plant: PlantResult, joint: int, trial: str, pair: Pair) -> Panel:
    j = joint - 1
    run = _first_run(pair)
    t, angle = run.time[first_cycle(run)], np.rad2deg(run.desired[first_cycle(run), j])
    desired = PanelLine(t, angle, report_kit.INK, "desired", 1.15)
    alt = f"Trial {trial_name(trial)}, joint {joint}: desired angle, error, torque error and integrator over time."
    # With the integrator off its panel says so, and shows no noise about zero.
    idle = True
    for side, (_, label) in zip(pair, SIDES, strict=True):
        if side is None:
            continue
        idle = idle and not side.integrator[first_cycle(side), j].any()
        rms = trial_figure(plant, joint, trial, side.compensator, "rms_deg")
        if rms is not None:
            alt += f" Rms {label}: {rms.mean:.3g} degrees."
    integrator = _rows(pair, "integrator [Nm]", lambda side: side.integrator[:, j])
    if idle:
        integrator = _switched_off(t, pair)
    rows = (
        chart(TIME, "q_d [°]", [desired], bands=_bands(pair)),
        _rows(pair, "error [°]", partial(_error_deg, joint)),
        _rows(pair, "torque error [Nm]", lambda side: side.torque_error[:, j]),
        integrator,
    )
    return Panel(trial_name(trial).capitalize(), rows, alt, (0.95, 1.65, 1.3, 1.3))


def _switched_off(t: Array, pair: Pair) -> Draw:
    def say_so(axes: Axes) -> None:
        axes.set_yticks([0.0], ["0"])
        axes.text(
            0.5,
            0.68,
            "switched off",
            transform=axes.transAxes,
            ha="center",
            va="center",
            color=report_kit.MUTED.light,
        )

    flat = [PanelLine(t, np.zeros_like(t), report_kit.MUTED)]
    bands = _bands(pair)
    return chart(TIME, "integrator [Nm]", flat, zero=True, reach=1.0, bands=bands, also=say_so)


def _error_deg(joint: int, run: experiments_kit.TrialRun) -> Array:
    return np.rad2deg(run.error[:, joint - 1])


def _tool_error_mm(axis: int, run: experiments_kit.TrialRun) -> Array:
    return 1e3 * (run.tool_desired - run.tool)[:, axis]


def _error_rows(joints: Sequence[int], trial: str, pair: Pair) -> Panel:
    rows = []
    for joint in joints:
        rows.append(_rows(pair, f"error of joint {joint} [°]", partial(_error_deg, joint)))
    words = ", ".join(map(str, joints))
    alt = f"Trial {trial_name(trial)}: errors of joints {words} over time, without and with compensator."
    return Panel(trial_name(trial).capitalize(), tuple(rows), alt, (1.2,) * len(rows))


def tool_figure(plant: PlantResult, trial: str, compensator: str) -> PageFigure | None:
    """Return figure 8, or None without runs of the trial."""
    pair = pair_of(plant, trial, compensator)
    if not any(pair):
        return None
    # All directions and both runs share a scale.
    reach = 0.0
    for run in pair:
        if run is not None:
            error = (run.tool_desired - run.tool)[first_cycle(run)]
            reach = max(reach, 1.06 * float(1e3 * np.max(np.abs(error))))
    name = trial_name(trial)
    panels = []
    for k, (axis, direction) in enumerate((("x", "forward"), ("y", "left"), ("z", "up"))):
        draw = _rows(pair, f"error in {axis} [mm]", partial(_tool_error_mm, k), reach)
        words = (
            f"Error of the tool in {axis} over time, {name} trial, without and with compensator."
        )
        panels.append(Panel(f"{axis}, {direction}", draw, words, (1.9,)))
    return PageFigure(
        "tool",
        "Errors of the tool",
        f"{name.capitalize()} trial, first cycle, desired less reached at the same moment; the same scale "
        f"for all three directions. {_tool_words(plant, trial, compensator)}",
        tuple(panels),
        columns=3,
        number="8",
    )


def _tool_words(plant: PlantResult, trial: str, compensator: str) -> str:
    off = tool_figures(plant, trial, OFF).get("tracking_rms_mm")
    on = tool_figures(plant, trial, compensator).get("tracking_rms_mm")
    if off is None or on is None:
        return ""
    both = f" without, {on} mm with compensator"
    if same_run(*pair_of(plant, trial, compensator)):
        both = "; the compensator was left off"
    return f"Distance from where the tool should be, rms over all cycles: {off} mm{both}."
