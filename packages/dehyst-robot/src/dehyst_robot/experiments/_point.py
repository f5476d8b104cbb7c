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
from dehyst.models import HysteresisModel
from dehyst_robot.arm import Arm, Robot, load_robot
from dehyst_robot.control import RampedCompensator
from dehyst_robot.control import kit as control_kit
from dehyst_robot.experiments._calibration import (
    SPACING,
    calibrate,
    excite,
    home,
    home_from_zero,
)
from dehyst_robot.experiments._equipment import (
    Equipment,
    backbones_of,
    equip,
    refuse_learning,
    under_controller,
)
from dehyst_robot.experiments._identification import identify_compensators
from dehyst_robot.experiments._output import joint_figures
from dehyst_robot.experiments._path import PlannedPath, plan_path
from dehyst_robot.experiments._policy import POLICY
from dehyst_robot.experiments._recipes import Recipe, recipe
from dehyst_robot.experiments._results import (
    RUN_SETTINGS,
    Characteristic,
    JointIdentification,
    RunSettings,
)
from dehyst_robot.experiments._trials import learned_trial
from dehyst_robot.fields import checked_table

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
        "off" is run too; ``"paper/declined"``, 1 where its model explains too little of unseen loops, so that the
        trials run without it; ``"nonzero_weights"``, ``"inverse_rms_ratio_unseen"``.

    Raises
    ------
    ParameterError
        If a key, name or setting does not exist.
    """
    settings = {**RUN_SETTINGS, **checked_table(RunSettings, run_settings or {}, "run settings")}
    if experiment not in ("joint", "arm"):
        raise ParameterError(f"experiment '{experiment}' does not exist; there are: joint, arm.")
    conditions = settings["conditions"]
    robot = load_robot(changes=changes, conditions=conditions)
    # The path does not depend on what the sweep changes of the muscles.
    path = _path(
        load_robot(changes=_without(changes, ("hysteresis", "tolerance", "controller.pole_1_s")))
    )
    run_on = _at_mean_pressure(robot, settings["run_mean_pressure_bar"])
    known_changes = _without_plant(changes)
    if settings["identified_on"] == "here":
        known_changes = dict(changes)
    recipes = {name: _recipe(name, settings) for name in compensators}
    moving = tuple(robot.joints)
    if experiment == "joint":
        moving = (joint,)
    # The robot as the controllers know it, which may be another one than runs.
    known_robot = _at_mean_pressure(
        load_robot(changes=known_changes, conditions=conditions), settings["run_mean_pressure_bar"]
    )
    # What only trials need is left out, so that calibrations are shared.
    base = load_robot(changes=_without(known_changes, _LATER), conditions=conditions)
    prepared = _prepared(known_robot, base, recipes, joint, experiment, seed)
    figures: dict[str, float] = {}
    for name, chosen in recipes.items():
        equipment, identified = prepared[name]
        history = _HISTORIES[settings["initial_state"]]
        if chosen.direct and history is _unknown_history:
            history = _unseen_history
        if chosen.odd and history is home:
            history = home_from_zero
        equipment = replace(equipment, loads={joint: settings["load_Nm"]}, history=history)
        if settings["identified_on"] != "here":
            equipment = replace(equipment, known=known_robot)
        if settings["initial_state"] == "ramped":
            equipment = ramped(equipment)
        # Without compensator there is nothing to learn.
        passes = chosen.passes
        if name == "off":
            passes = 0
        refuse_learning(settings["controller"], name, passes)
        used, equipment = under_controller(run_on, equipment, settings["controller"])
        for trial in trials:
            run, _ = learned_trial(used, path, equipment, trial, name, moving, passes=passes)
            for key, value in joint_figures(run, joint).items():
                figures[f"{trial}/{name}/{key}"] = value
        if name != "off":
            figures[f"{name}/declined"] = float(not identified[joint].accepted)
            figures["nonzero_weights"] = float(identified[joint].nonzero_weights)
            figures["inverse_rms_ratio_unseen"] = identified[joint].inverse_rms_ratio
    return figures | _ratios(figures, trials, compensators)


def _recipe(name: str, settings: Mapping[str, Any]) -> Recipe:
    """The recipe of a name with what the run settings change of it."""
    # Without compensator a run stands on the paper's characteristic.
    if name == "off":
        name = "paper"
    chosen = recipe(name)
    factor, passes = settings["time_constants_factor"], settings["passes"]
    if factor != 1.0:
        scaled = tuple(factor * tau for tau in chosen.time_constants)
        chosen = replace(chosen, time_constants=scaled)
    if chosen.passes and passes >= 0:
        chosen = replace(chosen, passes=passes)
    return chosen


def _at_mean_pressure(robot: Robot, mean_bar: float) -> Robot:
    if mean_bar <= 0:
        return robot
    return robot.with_changes({"controller.mean_pressure_bar": mean_bar})


def _prepared(
    robot: Robot, base: Robot, recipes: Mapping[str, Recipe], joint: int, experiment: str, seed: int
) -> dict[str, tuple[Equipment, dict[int, JointIdentification]]]:
    """Calibrate and identify on the base, and make controllers for the robot that is known, for every compensator."""
    moving, compensated = robot.pneumatic, robot.compensated
    if experiment == "joint":
        moving = compensated = (joint,)
    calibrated = {n: _calibrated(base, n, seed) for n in moving}
    # A tuple, for what is identified stays in a cache under it.
    named_recipes = tuple(recipes.items())
    by_joint = {n: _identified(base, n, seed, named_recipes) for n in compensated}
    prepared = {}
    for name, chosen in recipes.items():
        identified = {n: by_joint[n][name] for n in compensated}
        backbones = backbones_of(base, calibrated, chosen)
        used = robot.with_changes(chosen.changes)
        equipment = equip(used, backbones, identified, seed, adaptive=chosen.adaptive)
        prepared[name] = equipment, identified
    return prepared


@lru_cache(maxsize=64)
def _calibrated(robot: Robot, number: int, seed: int) -> Characteristic:
    return calibrate(robot, number, seed=seed)


@lru_cache(maxsize=64)
def _identified(
    robot: Robot, number: int, seed: int, recipes: tuple[tuple[str, Recipe], ...]
) -> dict[str, JointIdentification]:
    calibrated = {number: _calibrated(robot, number, seed)}
    with_backbones = {}
    for name, chosen in recipes:
        with_backbones[name] = (chosen, backbones_of(robot, calibrated, chosen)[number])
    with tempfile.TemporaryDirectory() as folder:
        return identify_compensators(robot, number, with_backbones, Path(folder), seed=seed)


@lru_cache(maxsize=16)
def _path(robot: Robot) -> PlannedPath:
    return plan_path(robot)


def _without(changes: Mapping[str, object], tables: Sequence[str]) -> dict[str, object]:
    """Changes outside of some tables or keys."""
    prefixes = tuple(f"{table}." for table in tables)
    return {key: value for key, value in changes.items() if not f"{key}.".startswith(prefixes)}


def _without_plant(changes: Mapping[str, object]) -> dict[str, object]:
    """Changes of what is done with the robot; which mechanism its muscles have is kept, and whole tables are.

    Whole tables are another robot's file, not a change of it.
    """
    remaining = {}
    for key, value in changes.items():
        of_plant = key != "hysteresis.mechanism" and key.split(".")[0] not in _NOT_PLANT
        if isinstance(value, Mapping) or not of_plant:
            remaining[key] = value
    return remaining


def _ratios(
    figures: Mapping[str, float], trials: Sequence[str], compensators: Sequence[str]
) -> dict[str, float]:
    ratios: dict[str, float] = {}
    if "off" not in compensators:
        return ratios
    for trial, name in itertools.product(trials, compensators):
        if name != "off":
            for key in ("rms", "max"):
                on, off = figures[f"{trial}/{name}/{key}_deg"], figures[f"{trial}/off/{key}_deg"]
                ratios[f"{trial}/{name}/ratio_{key}"] = on / off
    return ratios


def _unknown_history(arm: Arm, characteristics: Mapping[int, Characteristic]) -> None:
    """Strokes of random size, ending somewhere near zero: what a joint did before it was asked."""
    # The same strokes for all compensators of a seed.
    draw = np.random.default_rng(1000 + arm.seed)
    tips = np.concatenate([[0.0], draw.uniform(-0.8, 0.8, 5), [0.0]])
    stroke = 0.5 - 0.5 * np.cos(np.linspace(0, np.pi, round(2.0 / SPACING)))
    shape = (tips[:-1, None] + stroke * np.diff(tips)[:, None]).ravel()
    share = np.zeros(len(arm.moving))
    for k, number in enumerate(arm.moving):
        # A joint without characteristic cannot be led.
        if number in characteristics:
            share[k] = arm.robot.joint(number).range
    excite(arm, shape[:, None] * share, characteristics, every_s=1.0)


def _unseen_history(arm: Arm, characteristics: Mapping[int, Characteristic]) -> None:
    """The same, and a controller that is switched on only then: a direct inverse would have followed the strokes."""
    _unknown_history(arm, characteristics)
    arm.restart()


_HISTORIES = {"homed": home, "unknown": _unknown_history, "ramped": _unknown_history}


def ramped(equipment: Equipment) -> Equipment:
    """Return the same equipment with compensators that know that their memory is not known; direct inverses do."""
    own = {}
    direct = {}
    for number, compensator in equipment.compensators.items():
        if compensator.core == control_kit.DIRECT:
            direct[number] = compensator
            continue
        inverse = cast(HysteresisModel, compensator)
        controller, card = equipment.controllers[number], inverse.card.input
        past = None
        if card.low is not None and card.high is not None:
            past = (POLICY.usual_past * card.low, POLICY.usual_past * card.high)
        own[number] = RampedCompensator(
            inverse, controller.shear, controller.compensator_unit, past
        )
    return replace(equipment, compensators=direct, own=own)
