"""Figures 7 and 8 of the paper: the trials, compensator off and on, in the joints and at the tool."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from dehyst.arrays import Array
from dehyst.report.figures.panel import Axes, says
from dehyst.report.text import number, short
from dehyst.report.theme import INK, MUTED, TEST, TRAIN, Token
from dehyst.robot.experiments.results import PlantResult, TrialRun
from dehyst.robot.report.lines import Draw, Line, over_time, shaded
from dehyst.robot.report.numbers import OFF, run_of, same_run, tool_figures, trial_figure, trial_name
from dehyst.robot.report.picture import Picture, Plate

TIME = "time [s]"
ON_LABEL, OFF_LABEL, SAME_LABEL = "with compensator", "without", "without; with it the same, left off"
SIDES: tuple[tuple[bool, Token, str, float], ...] = ((False, TEST, OFF_LABEL, 1.3), (True, TRAIN, ON_LABEL, 1.3))


def first_cycle(run: TrialRun) -> slice:
    """Return the samples of the first cycle."""
    return slice(0, int(np.searchsorted(run.cycle, run.cycle[0] + 1)) if run.cycle.size else 0)


def pair_of(plant: PlantResult, trial: str, compensator: str) -> tuple[TrialRun | None, TrialRun | None]:
    """Return the runs of a trial without and with compensator."""
    return run_of(plant, trial, OFF), run_of(plant, trial, compensator)


def joint_plate(plant: PlantResult, joint: int, trials: Sequence[str], compensator: str) -> Plate | None:
    """Return figure 7, or None without runs."""
    pairs = {trial: pair_of(plant, trial, compensator) for trial in trials}
    pictures = [_three_rows(plant, joint, trial, *pair, compensator) for trial, pair in pairs.items() if any(pair)]
    if not pictures:
        return None
    return Plate(
        "trials",
        "Trials: angle, error and integrator",
        f"Joint {joint}, first cycle. {band_words(next(r for pair in pairs.values() for r in pair if r))} Every "
        f"picture has its own scale. {_integrator_words(pairs, joint)}",
        tuple(pictures),
        columns=3,
    )


def _integrator_words(pairs: Mapping[str, Sequence[TrialRun | None]], joint: int) -> str:
    """What the integrator has to do in each trial, over all cycles."""
    said = []
    for trial, (off, on) in pairs.items():
        if off is None or on is None or not (off.integrator[:, joint - 1].any() or on.integrator[:, joint - 1].any()):
            continue
        rms = [number(float(np.sqrt(np.mean(run.integrator[:, joint - 1] ** 2)))) for run in (off, on)]
        both = f"{rms[0]} Nm without, {rms[1]} Nm with compensator"
        said.append(f"{trial_name(trial)} {f'{rms[0]} Nm' if same_run(off, on) else both}")
    return f"Torque of the integrator, rms: {'; '.join(said)}." if said else ""


def _lines(pair: Sequence[TrialRun | None], values: Sequence[Array | None]) -> list[Line]:
    if same_run(*pair):  # the second would hide the first
        return [Line(values[0], TEST, SAME_LABEL, 1.3)] if values[0] is not None else []
    return [
        Line(value, token, label, width)
        for run, value, (_, token, label, width) in zip(pair, values, SIDES, strict=True)
        if run is not None and value is not None
    ]


def band_words(run: TrialRun) -> str:
    """Say what the grey bands are."""
    order = ", ".join(short(name, 30) for name in run.figures)
    if (run.figure < 0).any():
        return f"Grey bands: figures of the path, in the order {order}; between them the way to the next."
    return f"The path's figures are {order}; grey bands mark every other one."


def _bands(run: TrialRun, part: slice) -> list[tuple[float, float]]:
    """From when to when a figure of the path is followed; of figures without a way between them, every other one."""
    figure, t = run.figure[part], run.time[part]
    starts = np.concatenate([[0], np.flatnonzero(np.diff(figure)) + 1, [figure.size]]).astype(np.int64)
    pieces = list(zip(starts[:-1].tolist(), starts[1:].tolist(), strict=True))
    shown = [piece for piece in pieces if figure[piece[0]] >= 0] if (figure < 0).any() else pieces[1::2]
    return [(float(t[a]), float(t[b - 1])) for a, b in shown]


def _three_rows(
    plant: PlantResult, joint: int, trial: str, off: TrialRun | None, on: TrialRun | None, compensator: str
) -> Picture:
    pair = (off, on)
    run = off or on
    assert run is not None
    part, j = first_cycle(run), joint - 1
    t, bands = run.time[part], _bands(run, part)
    wanted = Line(np.rad2deg(run.desired[part, j]), INK, "desired")
    errors = [None if r is None else np.rad2deg(r.error[first_cycle(r), j]) for r in pair]
    torques = [None if r is None else r.integrator[first_cycle(r), j] for r in pair]
    still = all(torque is None or not torque.any() for torque in torques)
    rows: tuple[Draw, ...] = (
        over_time(t, (wanted,), TIME, "q_d [°]"),
        over_time(t, _lines(pair, errors), TIME, "error [°]"),
        _switched_off(t) if still else over_time(t, _lines(pair, torques), TIME, "integrator [Nm]"),
    )
    alt = says(
        f"Trial {trial_name(trial)}, joint {joint}: desired angle, error and integrator over time.",
        _rms_words(plant, joint, trial, compensator),
    )
    shown = _with_legend(rows, _lines(pair, errors))
    return Picture(trial_name(trial).capitalize(), tuple(shaded(row, bands) for row in shown), alt, (0.95, 1.65, 1.3))


def _rms_words(plant: PlantResult, joint: int, trial: str, compensator: str) -> str:
    found = [
        (label, trial_figure(plant, joint, trial, name, "rms_deg"))
        for label, name in ((OFF_LABEL, OFF), (ON_LABEL, compensator))
    ]
    return " ".join(f"Rms {label}: {number(value.mean)} degrees." for label, value in found if value is not None)


def _with_legend(rows: tuple[Draw, ...], lines: Sequence[Line]) -> tuple[Draw, ...]:
    """The first row has its own line only; the legend names those of the rows below."""

    def first(axes: Axes) -> None:
        rows[0](axes)
        for line in lines:
            axes.plot([], [], color=line.token.light, lw=line.width, label=line.label)

    return (first, *rows[1:])


def _switched_off(t: Array) -> Draw:
    flat = over_time(t, (Line(np.zeros_like(t), MUTED, "integrator"),), TIME, "integrator [Nm]", reach=1.0)

    def draw(axes: Axes) -> None:
        flat(axes)
        axes.set_yticks([0.0], ["0"])
        axes.text(0.5, 0.68, "switched off", transform=axes.transAxes, ha="center", va="center", color=MUTED.light)

    return draw


def others_plate(plant: PlantResult, joints: Sequence[int], trials: Sequence[str], compensator: str) -> Plate | None:
    """Return the errors of the other joints as small pictures, or None without runs."""
    pairs = {trial: pair_of(plant, trial, compensator) for trial in trials}
    pictures = [_error_rows(joints, trial, pair) for trial, pair in pairs.items() if any(pair) and joints]
    if not pictures:
        return None
    words = " and ".join(map(str, joints))
    return Plate(
        "trials-others",
        f"The same trials, joints {words}" if len(joints) > 1 else f"The same trials, joint {words}",
        f"{_at_once(pairs.values())}; the paper left these open. Every picture has its own scale.",
        tuple(pictures),
        columns=3,
    )


def _at_once(pairs: Iterable[Sequence[TrialRun | None]]) -> str:
    if all(same_run(*pair) for pair in pairs):
        return "All joints move at once"
    return "All joints move and are compensated at once"


def _error_rows(joints: Sequence[int], trial: str, pair: Sequence[TrialRun | None]) -> Picture:
    run = next(r for r in pair if r is not None)
    part = first_cycle(run)
    t, bands = run.time[part], _bands(run, part)
    rows = []
    for joint in joints:
        errors = [None if r is None else np.rad2deg(r.error[first_cycle(r), joint - 1]) for r in pair]
        rows.append(shaded(over_time(t, _lines(pair, errors), TIME, f"error of joint {joint} [°]"), bands))
    alt = says(f"Trial {trial_name(trial)}: errors of joints {', '.join(map(str, joints))} over time, off and on.")
    return Picture(trial_name(trial).capitalize(), tuple(rows), alt, (1.2,) * len(rows))


def tool_plate(plant: PlantResult, trial: str, compensator: str) -> Plate | None:
    """Return figure 8, or None without runs of the trial."""
    pair = pair_of(plant, trial, compensator)
    if not any(pair):
        return None
    run = next(r for r in pair if r is not None)
    part = first_cycle(run)
    t, bands = run.time[part], _bands(run, part)
    errors = [None if r is None else 1e3 * (r.tool_desired - r.tool)[first_cycle(r)] for r in pair]
    reach = 1.06 * max(float(np.max(np.abs(e))) for e in errors if e is not None)
    pictures = []
    for k, axis in enumerate("xyz"):
        lines = _lines(pair, [None if e is None else e[:, k] for e in errors])
        row = shaded(over_time(t, lines, TIME, f"error in {axis} [mm]", reach=reach), bands)
        alt = says(f"Error of the tool in {axis} over time, {trial_name(trial)} trial, off and on.")
        pictures.append(Picture(f"{axis}, {('forward', 'left', 'up')[k]}", (row,), alt, (1.9,)))
    return Plate(
        "tool",
        "Errors of the tool",
        f"{trial_name(trial).capitalize()} trial, first cycle, desired less reached at the same moment; the same scale "
        f"for all three directions. {_tool_words(plant, trial, compensator)}",
        tuple(pictures),
        columns=3,
    )


def _tool_words(plant: PlantResult, trial: str, compensator: str) -> str:
    found = {c: tool_figures(plant, trial, c).get("tracking_rms_mm") for c in (OFF, compensator)}
    off, on = found[OFF], found[compensator]
    if off is None or on is None:
        return ""
    if same_run(*pair_of(plant, trial, compensator)):
        return f"Distance from where the tool should be, rms over all cycles: {off} mm; the compensator was left off."
    return f"Distance from where the tool should be, rms over all cycles: {off} mm without, {on} mm with compensator."
