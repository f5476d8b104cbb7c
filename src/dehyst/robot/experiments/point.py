"""One point of a sweep: a robot with changed parameters, calibrated, identified and tested."""

from __future__ import annotations

import itertools
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any, cast

import numpy as np

from dehyst.errors import ParameterError
from dehyst.fields import checked
from dehyst.models import HysteresisModel
from dehyst.robot.arm.arm import Arm
from dehyst.robot.arm.parameters import Robot, load_robot
from dehyst.robot.control import RampedCompensator
from dehyst.robot.control.joint import DIRECT
from dehyst.robot.experiments.calibration import SPACING, calibrate, excite, home
from dehyst.robot.experiments.equipment import Equipment, backbones_of, equip, refuse_learning, under_controller
from dehyst.robot.experiments.identification import identify_compensators
from dehyst.robot.experiments.output import joint_figures
from dehyst.robot.experiments.path import PlannedPath, plan_path
from dehyst.robot.experiments.recipes import Recipe, recipe
from dehyst.robot.experiments.results import (
    RUN_SETTINGS,
    Characteristic,
    JointIdentification,
    RunSettings,
)
from dehyst.robot.experiments.trials import learned_trial

# Tables and keys that say what is done with the robot, not what it is made of.
_NOT_PLANT = ("controller", "compensator", "homing", "calibration", "identification", "path")
# What neither a calibration nor an identification depends on: a sweep over it repeats neither.
_LATER = ("controller.pole_1_s", "controller.windup_gain_1_s", "path")


def evaluate_point(
    changes: Mapping[str, object],
    *,
    experiment: str = "joint",
    joint: int = 1,
    seed: int = 0,
    trials: Sequence[str] = ("slow",),
    compensators: Sequence[str] = ("off", "paper"),
    run_settings: Mapping[str, object] | None = None,
) -> dict[str, float]:
    """Run one point: calibrate, identify, and follow the path with each compensator.

    Parameters
    ----------
    changes
        Dotted keys of the parameter file -> values.
    experiment
        "joint": one joint alone, the others locked; "arm": the whole arm, with the joints of
        ``compensator.joints`` compensated.
    joint
        The joint whose errors are returned, and which moves in "joint".
    seed
        Of noise and tolerances.
    trials, compensators
        What is run.
    run_settings
        Keys of `RunSettings` -> values.

    Returns
    -------
    figures : dict
        ``"slow/paper/rms_deg"``, ``"slow/paper/max_deg"``, ... and ``"slow/paper/ratio_rms"``, ``ratio_max`` where
        "off" is run too; ``"nonzero_weights"``, ``"inverse_rms_ratio_unseen"``.

    Raises
    ------
    ParameterError
        If a key, name or setting does not exist.
    """
    settings = {**RUN_SETTINGS, **checked(RunSettings, run_settings or {}, "run settings")}
    if experiment not in ("joint", "arm"):
        raise ParameterError(f"experiment '{experiment}' does not exist; there are: joint, arm.")
    conditions = settings["conditions"]
    robot = load_robot(changes=changes, conditions=conditions)
    path = _path(load_robot(changes=_without(changes, ("hysteresis", "tolerance", "controller.pole_1_s"))))
    run_on = _at_mean_pressure(robot, settings["run_mean_pressure_bar"])
    known = changes if settings["identified_on"] == "here" else _without_plant(changes)
    recipes = {name: _recipe(name, settings) for name in compensators}
    moving = (joint,) if experiment == "joint" else tuple(robot.joints)
    told = _at_mean_pressure(load_robot(changes=known, conditions=conditions), settings["run_mean_pressure_bar"])
    base = load_robot(changes=_without(known, _LATER), conditions=conditions)
    prepared = _prepared(told, base, recipes, joint, experiment, seed)
    figures: dict[str, float] = {}
    for name, chosen in recipes.items():
        equipment, found = prepared[name]
        history = _HISTORIES[settings["initial_state"]]
        if chosen.direct and history is _unknown_history:
            history = _unseen_history
        equipment = replace(equipment, loads={joint: settings["load_Nm"]}, history=history)
        if known is not changes:
            equipment = replace(equipment, known=told)
        if settings["initial_state"] == "ramped":
            equipment = ramped(equipment)
        passes = 0 if name == "off" else chosen.passes
        refuse_learning(settings["controller"], name, passes)
        used, equipment = under_controller(run_on, equipment, settings["controller"])
        for trial in trials:
            run, _ = learned_trial(used, path, equipment, trial, name, moving, passes=passes)
            figures |= {f"{trial}/{name}/{key}": value for key, value in joint_figures(run, joint).items()}
        if name != "off":
            figures["nonzero_weights"] = float(found[joint].nonzero_weights)
            figures["inverse_rms_ratio_unseen"] = found[joint].inverse_rms_ratio
    return figures | _ratios(figures, trials, compensators)


def _recipe(name: str, settings: Mapping[str, Any]) -> Recipe:
    """The recipe of a name with what the run settings change of it."""
    chosen = recipe("paper" if name == "off" else name)
    factor, passes = settings["time_constants_factor"], settings["passes"]
    if factor != 1.0:
        chosen = replace(chosen, time_constants=tuple(factor * tau for tau in chosen.time_constants))
    return replace(chosen, passes=passes) if chosen.passes and passes >= 0 else chosen


def _at_mean_pressure(robot: Robot, mean_bar: float) -> Robot:
    return robot.with_changes({"controller.mean_pressure_bar": mean_bar}) if mean_bar > 0 else robot


def _prepared(
    robot: Robot, base: Robot, recipes: Mapping[str, Recipe], joint: int, experiment: str, seed: int
) -> dict[str, tuple[Equipment, dict[int, JointIdentification]]]:
    """Calibrate and identify on the base, and make controllers for the robot that is known, for every compensator."""
    moving = (joint,) if experiment == "joint" else robot.pneumatic
    compensated = (joint,) if experiment == "joint" else robot.compensated
    calibrated = {n: _calibrated(base, n, seed) for n in moving}
    wanted = tuple(recipes.items())
    identified = {n: _identified(base, n, seed, wanted) for n in compensated}
    prepared = {}
    for name, chosen in wanted:
        found = {n: identified[n][name] for n in compensated}
        backbones = backbones_of(base, calibrated, chosen)
        used = robot.with_changes(chosen.changes)
        prepared[name] = equip(used, backbones, found, seed, adaptive=chosen.adaptive), found
    return prepared


@lru_cache(maxsize=64)
def _calibrated(robot: Robot, number: int, seed: int) -> Characteristic:
    return calibrate(robot, number, seed=seed)


@lru_cache(maxsize=64)
def _identified(
    robot: Robot, number: int, seed: int, wanted: tuple[tuple[str, Recipe], ...]
) -> dict[str, JointIdentification]:
    calibrated = {number: _calibrated(robot, number, seed)}
    told = {name: (chosen, backbones_of(robot, calibrated, chosen)[number]) for name, chosen in wanted}
    with tempfile.TemporaryDirectory() as folder:
        return identify_compensators(robot, number, told, Path(folder), seed=seed)


@lru_cache(maxsize=16)
def _path(robot: Robot) -> PlannedPath:
    return plan_path(robot)


def _without(changes: Mapping[str, object], tables: Sequence[str]) -> dict[str, object]:
    """Changes outside of some tables or keys."""
    return {key: value for key, value in changes.items() if not any(f"{key}.".startswith(f"{t}.") for t in tables)}


def _without_plant(changes: Mapping[str, object]) -> dict[str, object]:
    """Changes of what is done with the robot; which mechanism its muscles have is kept, and whole tables are.

    Whole tables are another robot's file, not a change of it.
    """
    return {
        key: value
        for key, value in changes.items()
        if key == "hysteresis.mechanism" or isinstance(value, Mapping) or key.split(".")[0] in _NOT_PLANT
    }


def _ratios(figures: Mapping[str, float], trials: Sequence[str], compensators: Sequence[str]) -> dict[str, float]:
    if "off" not in compensators:
        return {}
    return {
        f"{t}/{c}/ratio_{k}": figures[f"{t}/{c}/{k}_deg"] / figures[f"{t}/off/{k}_deg"]
        for t in trials
        for c in compensators
        if c != "off"
        for k in ("rms", "max")
    }


def _unknown_history(arm: Arm, characteristics: Mapping[int, Characteristic]) -> None:
    """Strokes of random size, ending somewhere near zero: what a joint did before it was asked."""
    draw = np.random.default_rng(1000 + arm.seed)
    tips = np.concatenate([[0.0], draw.uniform(-0.8, 0.8, 5), [0.0]])
    stroke = 0.5 - 0.5 * np.cos(np.linspace(0, np.pi, round(2.0 / SPACING)))
    shape = np.concatenate([a + stroke * (b - a) for a, b in itertools.pairwise(tips)])
    share = np.array([arm.robot.joint(n).range if n in characteristics else 0.0 for n in arm.moving])
    excite(arm, shape[:, None] * share, characteristics, every_s=1.0)


def _unseen_history(arm: Arm, characteristics: Mapping[int, Characteristic]) -> None:
    """The same, and a controller that is switched on only then: a direct inverse would have followed the strokes."""
    _unknown_history(arm, characteristics)
    arm.restart()


_HISTORIES = {"homed": home, "unknown": _unknown_history, "ramped": _unknown_history}
USUAL = 0.5  # share of the identified range within which a joint usually moved before


def ramped(equipment: Equipment) -> Equipment:
    """Return the same equipment with compensators that know that their memory is not known; direct inverses do."""
    own = {}
    direct = {n: one for n, one in equipment.compensators.items() if one.core == DIRECT}
    for number, one in equipment.compensators.items():
        if number in direct:
            continue
        inverse = cast(HysteresisModel, one)
        p, card = equipment.controllers[number], inverse.card.input
        past = None if card.low is None or card.high is None else (USUAL * card.low, USUAL * card.high)
        own[number] = RampedCompensator(inverse, p.shear, p.compensator_unit, past)
    return replace(equipment, compensators=direct, own=own)
