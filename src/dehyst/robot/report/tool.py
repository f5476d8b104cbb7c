"""ISO 9283 figures of the tool: tables, and remarks on missing and increased values."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from dehyst.arrays import Array
from dehyst.errors import DehystError
from dehyst.report.parts import Table
from dehyst.report.text import count, listed, number
from dehyst.robot.experiments.results import PlantResult, Reproduction, TrialRun
from dehyst.robot.iso9283 import Figure, TestCube, cornering_deviation, test_path
from dehyst.robot.report.numbers import (
    OFF,
    Spread,
    cell,
    counted,
    joints_of,
    name_and_unit,
    run_of,
    tool_figures,
    trial_name,
    trials_of,
)
from dehyst.robot.report.reasons import Turn, figure_name, push_words, travelled, turn_before
from dehyst.shell import visible_lines as clean

CORNERS = "rectangle"  # name of the figure that has some
# Symbol -> name, meaning.
MEASURES = {
    "AT": ("path accuracy", "largest distance of the mean path from the desired one"),
    "RT": ("path repeatability", "how far the cycles lie apart"),
    "CR": ("corner rounding", "smallest distance from the ideal, sharp corner"),
    "CO": ("corner overshoot", "how far beyond the corner the tool goes"),
    "AV": ("speed accuracy", "mean speed against the commanded one"),
    "RV": ("speed repeatability", "how far the mean speeds of the cycles lie apart"),
    "FV": ("speed fluctuation", "largest less smallest deviation of the speed"),
}
LARGER = 1.02  # a figure that grows by less is not worth a word
DISTANCE = {
    "tracking_rms": "distance, rms",
    "tracking_max": "distance, largest",
    "tracking_p95": "distance, 95 % of the time below",
    "cycles": "cycles",
    "sections_missed": "share of sections not reached",
    "command_speed": "commanded speed",
    "share_at_command_speed": "share of the figure at it",
}
Columns = Mapping[tuple[str, str], Mapping[str, Spread]]


def tool_tables(result: Reproduction, plant: PlantResult, note: str) -> tuple[Table, ...]:
    """Return the tool's figures over all trials, worst figure of the path first, then each figure."""
    sides = (OFF, result.compensator)
    columns = {(t, side): tool_figures(plant, t, side) for t in trials_of(result) for side in sides}
    columns = {key: found for key, found in columns.items() if found}
    keys = list(dict.fromkeys(name for found in columns.values() for name in found))
    head = ("", *(f"{_broken(trial_name(trial))}\n{'off' if side == OFF else 'on'}" for trial, side in columns))
    whole, parts = ([k for k in keys if (", " in k) is nested] for nested in (False, True))
    said = f"{note} {_meanings(whole)} {_missing(plant)}".strip()
    made = []
    if whole:
        made.append(Table("Tool, the worst figure of the path", head, _rows(whole, columns), said))
    if parts:
        made.append(Table("Tool, every figure of the path", head, _rows(parts, columns), note, folded=True))
    return tuple(made)


def _rows(keys: list[str], columns: Columns) -> tuple[tuple[str, ...], ...]:
    rows = []
    for key in keys:
        found = [values.get(key) for values in columns.values()]
        if key == "sections_missed" and not any(value and value.high for value in found):
            continue
        write = counted if key == "cycles" else cell
        rows.append((row_name(key), *map(write, found)))
    return tuple(rows)


def _broken(name: str) -> str:
    """A name in two lines: three narrow columns stand beside each other better than two wide ones."""
    middle = name.find(" without ")
    return name if middle < 0 else f"{name[:middle]},\nno {name[middle + 9 :]}"


def row_name(key: str) -> str:
    """Return what a figure is called in the table.

    Examples
    --------
    >>> row_name("AT_mm"), row_name("tracking_rms_mm, line"), row_name("swing_deg")
    ('AT path accuracy [mm]', 'line: distance, rms [mm]', 'swing [°]')
    """
    head, _, part = key.partition(", ")
    name, unit = name_and_unit(head)
    symbol = head.partition("_")[0]
    if symbol in MEASURES:
        name = f"{symbol} {MEASURES[symbol][0]}"
    stem = next((s for s in DISTANCE if head == s or head.startswith(f"{s}_")), None)
    if stem is not None:
        name = DISTANCE[stem]
    return f"{part + ': ' if part else ''}{name}{f' [{unit}]' if unit else ''}"


def _meanings(keys: list[str]) -> str:
    known = [symbol for symbol in MEASURES if any(key.startswith(f"{symbol}_") for key in keys)]
    said = [f"{symbol}: {MEASURES[symbol][1]}" for symbol in known]
    if any(key.startswith("tracking") for key in keys):
        said.append("distance: from where the tool should be at that moment, ways between the figures included")
    return f"{'By ISO 9283. ' if known else ''}{'; '.join(said)}." if said else ""


def _missing(plant: PlantResult) -> str:
    """Why a figure is not there: "RT and RV of trial slow: needs two cycles or more."."""
    found: dict[tuple[str, tuple[str, ...]], list[str]] = {}
    for trial, reasons in _reasons(plant).items():
        by_reason: dict[str, list[str]] = {}
        for key, reason in reasons.items():
            by_reason.setdefault(clean(reason), []).append(key.partition("_")[0])
        for reason, keys in by_reason.items():
            found.setdefault((reason, tuple(keys)), []).append(trial_name(trial))
    return " ".join(
        f"No {listed(keys)} in {count(len(trials), 'trial').partition(' ')[2]} {listed(trials)}: {reason}."
        for (reason, keys), trials in found.items()
    )


def _reasons(plant: PlantResult) -> dict[str, dict[str, str]]:
    """Trial -> figure -> reason, of any seed and side."""
    found: dict[str, dict[str, str]] = {}
    for seed in plant.figures.values():
        for trial, sides in seed.get("tool", {}).items():
            for table in sides.values():
                reasons: Any = table.get("reasons") if isinstance(table, Mapping) else None
                if isinstance(reasons, Mapping):
                    found.setdefault(trial, {}).update({str(k): str(v) for k, v in reasons.items()})
    return found


def larger_figures(plant: PlantResult, trial: str, compensator: str) -> dict[str, str]:
    """Return symbol -> "FV 5.46 → 37.8 mm/s", of what grows with the compensator."""
    off, on = tool_figures(plant, trial, OFF), tool_figures(plant, trial, compensator)
    found = {}
    for key in off:
        symbol = key.partition("_")[0]
        if symbol in MEASURES and ", " not in key and key in on and abs(on[key].mean) > LARGER * abs(off[key].mean):
            unit = name_and_unit(key)[1]
            found[symbol] = f"{symbol} {number(off[key].mean)} → {number(on[key].mean)} {unit}"
    return found


@dataclass(frozen=True)
class Corner:
    """The corner that a run stays farthest from."""

    commanded_mm: float  # how near the commanded path comes to its worst corner
    sample: int  # of the run, where it is nearest to its own worst corner, first cycle


def worst_corner(result: Reproduction, run: TrialRun) -> Corner | None:
    """Return the worst corner of a run, or None if the path is not known from the settings."""
    figure = _figure(result)
    if figure is None or CORNERS not in run.figures:
        return None
    here = np.flatnonzero((run.figure == run.figures.index(CORNERS)) & (run.cycle == run.cycle[0]))
    if here.size < 2:
        return None
    try:
        found = cornering_deviation(figure, run.time[here], run.tool_desired[here], run.cycle[here])
    except DehystError:
        return None
    distance = np.linalg.norm(run.tool[here, None] - np.asarray(figure.corners)[None], axis=2)
    worst = int(np.argmax(distance.min(axis=0)))
    if np.isnan(found.rounding_error):
        return None
    return Corner(1e3 * found.rounding_error, int(here[np.argmin(distance[:, worst])]))


def _figure(result: Reproduction) -> Figure | None:
    """The figure with corners, from the settings' cube, or None."""
    parameters = result.settings.get("parameters")
    path = parameters.get("path") if isinstance(parameters, Mapping) else None
    if not isinstance(path, Mapping):
        return None
    try:
        figures = test_path(TestCube(path["cube_m"], path["center_m"]), path["rounding_m"]).figures
    except (KeyError, TypeError, DehystError):
        return None
    return next((figure for figure in figures if figure.name == CORNERS), None)


def tool_words(result: Reproduction, plant: PlantResult) -> tuple[str, ...]:
    """Return sentences: which figures grow, and why corner rounding and speed fluctuation do."""
    found = {trial: larger_figures(plant, trial, result.compensator) for trial in trials_of(result)}
    grown = {trial: keys for trial, keys in found.items() if keys}
    if not grown:
        return ()
    said = [f"{trial_name(trial)} {', '.join(words.values())}" for trial, words in grown.items()]
    corners, speeds = ([trial for trial, words in grown.items() if key in words] for key in ("CR", "FV"))
    told = (
        f"Taken over the path, these figures of the tool are larger with compensator: {'; '.join(said)}. On single "
        "figures of the path others can be, too: see the table of every figure.",
        _corner_words(result, plant, corners),
        _speed_words(result, plant, speeds),
        _overshoot_words(plant, result.compensator, [trial for trial, words in grown.items() if "CO" in words]),
    )
    return tuple(filter(None, told))


def _corner_words(result: Reproduction, plant: PlantResult, trials: Sequence[str]) -> str:
    """Corner rounding against that of the commanded path, and what the compensator did at the worst corner."""
    if not trials:
        return ""
    run = run_of(plant, trials[0], result.compensator)
    corner = None if run is None else worst_corner(result, run)
    if run is None or corner is None:
        return ""
    own, sides = corner.commanded_mm, []
    for trial in trials:
        off, on = (tool_figures(plant, trial, c)["CR_mm"].mean - own for c in (OFF, result.compensator))
        sides.append(f"{_signed(off)} mm without and {_signed(on)} mm with compensator ({trial_name(trial)})")
    text = (
        f"CR is measured from the ideal, sharp corner. The commanded path is rounded and itself passes it at "
        f"{number(own)} mm, and so does an arm without error; an arm that lags is carried past the corner and can come "
        f"nearer. What counts is the difference to the command: {'; '.join(sides)}."
    )
    pushes = _pushes(result, run, corner.sample)
    return f"{text} At its worst corner, {_push_story(run, corner.sample, pushes)}" if pushes else text


def _overshoot_words(plant: PlantResult, compensator: str, trials: Sequence[str]) -> str:
    """An arm that never reaches a corner cannot go beyond it."""
    for trial in trials:
        off, on = (tool_figures(plant, trial, c) for c in (OFF, compensator))
        if off["CO_mm"].high == 0.0 and {"CR_mm"} <= set(off) & set(on) and off["CR_mm"].mean > 2.0 * on["CR_mm"].mean:
            return (
                f"CO is 0 without compensator ({trial_name(trial)}) because the tool never comes to the corner: it "
                f"stays {number(off['CR_mm'].mean)} mm away."
            )
    return ""


def _signed(value: float) -> str:
    return f"{'+' if value > 0 else ''}{number(value, 2)}"


def _pushes(result: Reproduction, run: TrialRun, k: int) -> dict[int, Turn]:
    """Joint -> its last turn, of the joints that the compensator pushes at sample k."""
    turns = {joint: turn_before(run, joint, k) for joint in joints_of(result)}
    return {joint: turn for joint, turn in turns.items() if turn.is_push}


def _push_story(run: TrialRun, k: int, pushes: Mapping[int, Turn]) -> str:
    """What was pushed at sample k: "at 16 s, joint 4 has moved 0.01° since it turned or stopped 0.2 s before; ..."."""
    joint = max(pushes, key=lambda j: pushes[j].jump)
    turn = pushes[joint]
    also = [other for other in sorted(pushes) if other != joint]
    more = f" (joint{'s' if len(also) > 1 else ''} {listed(also)} alike)" if also else ""
    return (
        f"at {number(run.time[k])} s, joint {joint}{more} should have moved by {travelled(turn)} since it turned or "
        f"stopped {number(turn.since, 2)} s before; {push_words(turn)}"
    )


def _speed_words(result: Reproduction, plant: PlantResult, trials: Sequence[str]) -> str:
    """What the runs show where the tool's speed deviates most: a push after a turn, or nothing to be said."""
    for trial in trials:
        run = run_of(plant, trial, result.compensator)
        if run is None or not (run.figure >= 0).any():
            continue
        speed, wanted = (_speed(x, run.time) for x in (run.tool, run.tool_desired))
        k = int(np.argmax(np.where(run.figure >= 0, np.abs(speed - wanted), 0.0)))
        pushes = _pushes(result, run, k)
        if pushes:
            return (
                f"The speed deviates most in the {trial_name(trial)} trial in the {figure_name(run, k)}, "
                f"{number(speed[k])} instead of {number(wanted[k])} mm/s: {_push_story(run, k, pushes)}"
            )
    return ""


def _speed(place: Array, time: Array) -> Array:
    speed: Array = 1e3 * np.linalg.norm(np.gradient(place, time, axis=0), axis=1)
    return speed
