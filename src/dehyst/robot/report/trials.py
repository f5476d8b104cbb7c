"""Figures 7 and 8 of the paper: the trials without and with compensator, in the joints and at the tool."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial

import numpy as np

from dehyst.arrays import Array
from dehyst.report.drawing import Line, chart
from dehyst.report.parts import Axes, Draw, Figure, Panel
from dehyst.report.text import number, short
from dehyst.report.theme import INK, MUTED, TEST, TRAIN
from dehyst.robot.experiments.results import PlantResult, TrialRun
from dehyst.robot.report.numbers import (
    OFF,
    Pair,
    first_cycle,
    pair_of,
    same_run,
    tool_figures,
    trial_figure,
    trial_name,
)

TIME = "time [s]"
ON_LABEL, OFF_LABEL, SAME_LABEL = "with compensator", "without", "without; with it the same, left off"
SIDES = ((TEST, OFF_LABEL), (TRAIN, ON_LABEL))


def trial_figures(plant: PlantResult, joint: int, others: Sequence[int], pairs: Mapping[str, Pair]) -> list[Figure]:
    """Return figure 7 of a joint, and the errors of the other joints; nothing without runs.

    `pairs` holds the runs of each trial without and with compensator.
    """
    pairs = {trial: pair for trial, pair in pairs.items() if any(pair)}
    if not pairs:
        return []
    run = next(run for pair in pairs.values() for run in pair if run)
    found = [
        Figure(
            "trials",
            "Trials: angle, error and integrator",
            f"Joint {joint}, first cycle. {_band_words(run)} Every panel has its own scale. "
            f"{_integrator_words(pairs, joint)}",
            tuple(_three_rows(plant, joint, trial, pair) for trial, pair in pairs.items()),
            columns=3,
            number="7",
        )
    ]
    if others:
        same = all(same_run(*pair) for pair in pairs.values())
        found.append(
            Figure(
                "trials-others",
                f"The same trials, joint{'s' if len(others) > 1 else ''} {' and '.join(map(str, others))}",
                f"All joints move {'' if same else 'and are compensated '}at once; the paper left these open. Every "
                "panel has its own scale.",
                tuple(_error_rows(others, trial, pair) for trial, pair in pairs.items()),
                columns=3,
            )
        )
    return found


def _integrator_words(pairs: Mapping[str, Pair], joint: int) -> str:
    """What the integrator has to do in each trial, over all cycles."""
    said = []
    for trial, (off, on) in pairs.items():
        if off is None or on is None or not (off.integrator[:, joint - 1].any() or on.integrator[:, joint - 1].any()):
            continue
        rms = [number(float(np.sqrt(np.mean(run.integrator[:, joint - 1] ** 2)))) for run in (off, on)]
        both = f"{rms[0]} Nm without, {rms[1]} Nm with compensator"
        said.append(f"{trial_name(trial)} {f'{rms[0]} Nm' if same_run(off, on) else both}")
    return f"Torque of the integrator, rms: {'; '.join(said)}." if said else ""


def _lines(pair: Pair, values: Sequence[Array | None]) -> list[Line]:
    """Both sides over time; one line where they are the same run."""
    off, on = (None if run is None else run.time[first_cycle(run)] for run in pair)
    if same_run(*pair) and off is not None and values[0] is not None:  # the second would hide the first
        return [Line(off, values[0], TEST, SAME_LABEL, 1.3)]
    return [
        Line(t, value, token, label, 1.3)
        for t, value, (token, label) in zip((off, on), values, SIDES, strict=True)
        if t is not None and value is not None
    ]


def _rows(pair: Pair, up: str, value: Callable[[TrialRun], Array], reach: float | None = None) -> Draw:
    """A value of both runs over the first cycle, the figures of the path shaded."""
    values = [None if run is None else value(run)[first_cycle(run)] for run in pair]
    return chart(TIME, up, _lines(pair, values), zero=True, reach=reach, bands=_bands(pair))


def _band_words(run: TrialRun) -> str:
    if len(run.figures) == 1 and not (run.figure < 0).any():
        return ""
    order = ", ".join(short(name, 30) for name in run.figures)
    if (run.figure < 0).any():
        return f"Grey bands: figures of the path, in the order {order}; between them the way to the next."
    return f"The path's figures are {order}; grey bands mark every other one."


def _bands(pair: Pair) -> list[tuple[float, float]]:
    """From when to when a figure of the path is followed; of figures without a way between them, every other one."""
    run = next(run for run in pair if run is not None)
    figure, t = run.figure[first_cycle(run)], run.time[first_cycle(run)]
    starts = np.concatenate([[0], np.flatnonzero(np.diff(figure)) + 1, [figure.size]]).astype(np.int64)
    pieces = list(zip(starts[:-1].tolist(), starts[1:].tolist(), strict=True))
    shown = [piece for piece in pieces if figure[piece[0]] >= 0] if (figure < 0).any() else pieces[1::2]
    return [(float(t[a]), float(t[b - 1])) for a, b in shown]


def _three_rows(plant: PlantResult, joint: int, trial: str, pair: Pair) -> Panel:
    j = joint - 1
    run = next(run for run in pair if run is not None)
    t = run.time[first_cycle(run)]
    wanted = Line(t, np.rad2deg(run.desired[first_cycle(run), j]), INK, "desired", 1.15)
    idle = all(each is None or not each.integrator[first_cycle(each), j].any() for each in pair)
    rows = (
        chart(TIME, "q_d [°]", [wanted], bands=_bands(pair)),
        _rows(pair, "error [°]", partial(_error_deg, joint)),
        _switched_off(t, pair) if idle else _rows(pair, "integrator [Nm]", lambda each: each.integrator[:, j]),
    )
    told = [
        f" Rms {label}: {figure.mean:.3g} degrees."
        for each, (_, label) in zip(pair, SIDES, strict=True)
        if each and (figure := trial_figure(plant, joint, trial, each.compensator, "rms_deg"))
    ]
    alt = f"Trial {trial_name(trial)}, joint {joint}: desired angle, error and integrator over time.{''.join(told)}"
    return Panel(trial_name(trial).capitalize(), rows, alt, (0.95, 1.65, 1.3))


def _switched_off(t: Array, pair: Pair) -> Draw:
    def told(axes: Axes) -> None:
        axes.set_yticks([0.0], ["0"])
        axes.text(0.5, 0.68, "switched off", transform=axes.transAxes, ha="center", va="center", color=MUTED.light)

    flat = [Line(t, np.zeros_like(t), MUTED)]
    return chart(TIME, "integrator [Nm]", flat, zero=True, reach=1.0, bands=_bands(pair), also=told)


def _error_deg(joint: int, run: TrialRun) -> Array:
    return np.rad2deg(run.error[:, joint - 1])


def _tool_error_mm(axis: int, run: TrialRun) -> Array:
    return 1e3 * (run.tool_desired - run.tool)[:, axis]


def _error_rows(joints: Sequence[int], trial: str, pair: Pair) -> Panel:
    rows = tuple(_rows(pair, f"error of joint {joint} [°]", partial(_error_deg, joint)) for joint in joints)
    words = ", ".join(map(str, joints))
    alt = f"Trial {trial_name(trial)}: errors of joints {words} over time, without and with compensator."
    return Panel(trial_name(trial).capitalize(), rows, alt, (1.2,) * len(rows))


def tool_figure(plant: PlantResult, trial: str, compensator: str) -> Figure | None:
    """Return figure 8, or None without runs of the trial."""
    pair = pair_of(plant, trial, compensator)
    if not any(pair):
        return None
    errors = [1e3 * np.max(np.abs((run.tool_desired - run.tool)[first_cycle(run)])) for run in pair if run]
    reach = 1.06 * float(max(errors))
    panels = tuple(
        Panel(
            f"{axis}, {direction}",
            _rows(pair, f"error in {axis} [mm]", partial(_tool_error_mm, k), reach),
            f"Error of the tool in {axis} over time, {trial_name(trial)} trial, without and with compensator.",
            (1.9,),
        )
        for k, (axis, direction) in enumerate((("x", "forward"), ("y", "left"), ("z", "up")))
    )
    return Figure(
        "tool",
        "Errors of the tool",
        f"{trial_name(trial).capitalize()} trial, first cycle, desired less reached at the same moment; the same scale "
        f"for all three directions. {_tool_words(plant, trial, compensator)}",
        panels,
        columns=3,
        number="8",
    )


def _tool_words(plant: PlantResult, trial: str, compensator: str) -> str:
    off, on = (tool_figures(plant, trial, name).get("tracking_rms_mm") for name in (OFF, compensator))
    if off is None or on is None:
        return ""
    same = same_run(*pair_of(plant, trial, compensator))
    both = "; the compensator was left off" if same else f" without, {on} mm with compensator"
    return f"Distance from where the tool should be, rms over all cycles: {off} mm{both}."
