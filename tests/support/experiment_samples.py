"""The paper's experiment made short, kept for the whole session: what one test calibrates, the next one uses."""

import tempfile
from dataclasses import fields
from functools import cache
from pathlib import Path

import numpy as np

from dehyst_robot.arm import Arm, Reference, load_robot
from dehyst_robot.commands._reproduce import QUICK
from dehyst_robot.control import SWITCHES
from dehyst_robot.experiments import (
    calibrate,
    controller_parameters,
    equip,
    identify_joint,
    nominal_characteristic,
    plan_path,
    run_trial,
)

ALL_JOINTS = tuple(load_robot(conditions="kind").joints)
HOLDS = SWITCHES["position"] | SWITCHES["integrator"]
PLANTS = ("maxwell-slip", "preisach", "dahl")
FASTER = {
    "homing.cycles": 3,
    "homing.period_s": 2.0,
    "path.cycles_fast": 1,
    "path.slow_factor": 1.5,
}


@cache
def robot(mechanism="maxwell-slip"):
    """The arm with the settings of ``--quick``."""
    return load_robot(conditions="kind", changes={**QUICK, "hysteresis.mechanism": mechanism})


@cache
def path():
    return plan_path(robot())


@cache
def calibrated(number=1, mechanism="maxwell-slip"):
    return calibrate(robot(mechanism), number)


@cache
def folder(mechanism):
    return Path(tempfile.mkdtemp(prefix="dehyst-"))


@cache
def identified(number=1, mechanism="maxwell-slip"):
    """A joint's identification; its logs lie in `folder`."""
    return identify_joint(
        robot(mechanism), number, calibrated(number, mechanism), folder(mechanism)
    )


@cache
def equipment(mechanism="maxwell-slip"):
    """Joint 1 alone: calibrated, identified, compensated."""
    return equip(robot(mechanism), {1: calibrated(1, mechanism)}, {1: identified(1, mechanism)})


@cache
def trial(name, compensator, mechanism="maxwell-slip"):
    """A trial of joint 1 alone with the settings of ``--quick``."""
    return run_trial(robot(mechanism), path(), equipment(mechanism), name, compensator, (1,))[0]


def rms(run, number=1):
    return float(np.degrees(np.sqrt(np.mean(run.error[:, number - 1] ** 2))))


def controllers(arm, moving=ALL_JOINTS):
    """Controllers that know of the joints what data sheets tell."""
    numbers = [n for n in moving if n in arm.pneumatic]
    return {n: controller_parameters(arm, n, nominal_characteristic(arm, n)) for n in numbers}


def arm(moving=ALL_JOINTS, seed=0, mechanisms=None, **changes):
    """An arm with dots of the changed keys written as two underscores."""
    made = load_robot(
        conditions="kind", changes={key.replace("__", "."): value for key, value in changes.items()}
    )
    return Arm(
        made, moving=moving, controllers=controllers(made, moving), mechanisms=mechanisms, seed=seed
    )


def swing(arm, duration=2.0, spacing=0.01, amplitude=0.2, frequency=0.5, switches=HOLDS):
    """All joints from zero to the amplitude and back, over and over, with feedforward."""
    t, w = spacing * np.arange(round(duration / spacing) + 1), 2 * np.pi * frequency
    size = np.full(len(arm.moving), amplitude)
    shapes = (0.5 - 0.5 * np.cos(w * t), 0.5 * w * np.sin(w * t), 0.5 * w**2 * np.cos(w * t))
    motion = tuple(shape[:, None] * size for shape in shapes)
    return Reference.motion(spacing, motion, arm.feedforward(*motion), 3e5, switches)


def same_bits(one, other):
    return all(np.array_equal(getattr(one, f.name), getattr(other, f.name)) for f in fields(one))
