"""One point of a sweep: a robot with changed parameters, calibrated, identified and tried."""

from __future__ import annotations

import itertools
import math
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from dehyst.control import RampedCompensator
from dehyst.errors import ParameterError
from dehyst.experiments.calibration import calibrate
from dehyst.experiments.compensators import equip, local_characteristic, recipe
from dehyst.experiments.loops_run import identify_joint
from dehyst.experiments.path import ArmPath, plan_path
from dehyst.experiments.quasistatic import SPACING, excite, home
from dehyst.experiments.results import COMPENSATED, Characteristic, JointIdentification
from dehyst.experiments.scores import joint_figures
from dehyst.experiments.trials import Equipment, run_trial
from dehyst.plant.arm import Arm
from dehyst.plant.parameters import Robot, load_robot
from dehyst.plant.rigid_body import ALL_JOINTS

RUN_SETTINGS = ("load_Nm", "initial_state", "identified_on")
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
        "joint": one joint alone, the others locked; "arm": the whole arm, with joints 1, 2 and 4 compensated.
    joint
        The joint whose errors are returned, and which moves in "joint".
    seed
        Of noise and tolerances.
    trials, compensators
        What is run.
    run_settings
        ``load_Nm``: constant torque on the joint during the trials, unknown to the controller; ``initial_state``:
        "homed", "unknown" (no homing before the trials, and a random history; the compensator begins as if homed), or
        "ramped" (the same, and the compensator answers with the middle of what is possible); ``identified_on``: "here",
        or "default" (calibrated and identified on the robot without `changes` of single keys of the plant).

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
    settings = _run_settings(run_settings or {})
    if experiment not in ("joint", "arm"):
        raise ParameterError(f"experiment '{experiment}' does not exist; there are: joint, arm.")
    robot = load_robot(changes=changes)
    path = _path(load_robot(changes=_without(changes, ("hysteresis", "tolerance", "controller.pole_1_s"))))
    figures: dict[str, float] = {}
    for name in compensators:
        known = changes if settings["identified_on"] == "here" else _without_plant(changes)
        equipment, found = _prepared(robot, known, name, joint, experiment, seed)
        equipment = replace(
            equipment, loads={joint: settings["load_Nm"]}, history=_HISTORIES[settings["initial_state"]]
        )
        if settings["initial_state"] == "ramped":
            equipment = ramped(equipment)
        moving = (joint,) if experiment == "joint" else ALL_JOINTS
        for trial in trials:
            run, _ = run_trial(robot, path, equipment, trial, name, moving)
            figures |= {f"{trial}/{name}/{key}": value for key, value in joint_figures(run, joint).items()}
        if name != "off":
            figures["nonzero_weights"] = float(found[joint].nonzero_weights)
            figures["inverse_rms_ratio_unseen"] = found[joint].inverse_rms_ratio
    return figures | _ratios(figures, trials, compensators)


def _prepared(
    robot: Robot, known: Mapping[str, object], name: str, joint: int, experiment: str, seed: int
) -> tuple[Equipment, dict[int, JointIdentification]]:
    """Calibrate and identify on the robot that is known, and equip the one that is run."""
    chosen = recipe("paper" if name == "off" else name)
    base = load_robot(changes={**_without(known, _LATER), **chosen.changes})
    moving = (joint,) if experiment == "joint" else robot.pneumatic
    compensated = (joint,) if experiment == "joint" else COMPENSATED
    backbones = {n: _backbone(base, n, seed, chosen.local) for n in moving}
    found = {n: _identified(base, n, seed, chosen.local) for n in compensated}
    return equip(robot.with_changes(chosen.changes), backbones, found, seed), found


@lru_cache(maxsize=64)
def _backbone(robot: Robot, number: int, seed: int, local: bool) -> Characteristic:
    found = calibrate(robot, number, seed=seed)
    return local_characteristic(robot, found) if local else found


@lru_cache(maxsize=64)
def _identified(robot: Robot, number: int, seed: int, local: bool) -> JointIdentification:
    with tempfile.TemporaryDirectory() as folder:
        return identify_joint(robot, number, _backbone(robot, number, seed, local), Path(folder), seed=seed)


@lru_cache(maxsize=16)
def _path(robot: Robot) -> ArmPath:
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


def _run_settings(given: Mapping[str, object]) -> dict[str, Any]:
    settings: dict[str, Any] = {"load_Nm": 0.0, "initial_state": "homed", "identified_on": "here", **given}
    unknown = sorted(set(settings) - set(RUN_SETTINGS))
    words = {"initial_state": tuple(_HISTORIES), "identified_on": ("here", "default")}
    if unknown:
        raise ParameterError(f"no run setting '{unknown[0]}'; there are: {', '.join(RUN_SETTINGS)}.")
    for key, allowed in words.items():
        if settings[key] not in allowed:
            raise ParameterError(f"{key} = '{settings[key]}' is not one of {', '.join(allowed)}.")
    load = settings["load_Nm"]
    if isinstance(load, bool) or not isinstance(load, int | float) or not math.isfinite(load):
        raise ParameterError(f"load_Nm = {load!r} is no torque. Pass a finite number of Nm.")
    return settings


def _unknown_history(arm: Arm, characteristics: Mapping[int, Characteristic]) -> None:
    """Strokes of random size, ending somewhere near zero: what a joint did before it was asked."""
    draw = np.random.default_rng(1000 + arm.seed)
    tips = np.concatenate([[0.0], draw.uniform(-0.8, 0.8, 5), [0.0]])
    stroke = 0.5 - 0.5 * np.cos(np.linspace(0, np.pi, round(2.0 / SPACING)))
    shape = np.concatenate([a + stroke * (b - a) for a, b in itertools.pairwise(tips)])
    share = np.array([arm.robot.joint(n).range if n in characteristics else 0.0 for n in arm.moving])
    excite(arm, shape[:, None] * share, characteristics, every_s=1.0)


_HISTORIES = {"homed": home, "unknown": _unknown_history, "ramped": _unknown_history}
USUAL = 0.5  # share of the identified range within which a joint usually moved before


def ramped(equipment: Equipment) -> Equipment:
    """Return the same equipment with compensators that know that their memory is not known."""
    own = {}
    for number, inverse in equipment.compensators.items():
        p, card = equipment.controllers[number], inverse.card.input
        past = None if card.low is None or card.high is None else (USUAL * card.low, USUAL * card.high)
        own[number] = RampedCompensator(inverse, p.shear, p.compensator_unit, past)
    return replace(equipment, compensators={}, own=own)
