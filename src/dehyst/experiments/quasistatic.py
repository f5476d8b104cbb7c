"""Runs with pressures only: homing, calibration sweeps and identification loops.

A target angle is turned into a pressure difference by a characteristic: that shapes the excitation, it does not
control the angle. Where the joint really goes is what is measured.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt

from dehyst.evaluation import decaying_cycles
from dehyst.experiments.results import Characteristic
from dehyst.plant.arm import Arm, ArmLog, Reference
from dehyst.plant.parameters import Robot

Array = npt.NDArray[np.float64]

SPACING = 0.01  # of the knots of a pressure reference [s]


def known_torque(arm: Arm, angles: Array, loads: Mapping[int, float] | None = None) -> Array:
    """Torque (K, n) that the drives must give at rest: nominal gravity less the loads that were hung on. [Nm]"""
    hung = np.array([(loads or {}).get(number, 0.0) for number in arm.moving])
    return np.asarray(arm.gravity(angles) * (1 + arm.robot.controller.gravity_error) - hung)


def difference_along(
    arm: Arm,
    targets: Array,
    characteristics: Mapping[int, Characteristic],
    mean: float,
    loads: Mapping[int, float] | None = None,
) -> Array:
    """Pressure differences (K, n) that would bring the joints to the targets (K, n) if nothing had hysteresis. [Pa]"""
    torque = known_torque(arm, targets, loads)
    limit = pressure_room(arm.robot, mean)
    columns = [
        characteristics[number].difference(targets[:, i], mean, torque[:, i])
        if number in characteristics
        else np.zeros(targets.shape[0])
        for i, number in enumerate(arm.moving)
    ]
    return np.clip(np.stack(columns, axis=1), -limit, limit)


def pressure_room(robot: Robot, mean: float) -> float:
    """Largest |dp| that keeps both muscles within their limits at this mean pressure. [Pa]"""
    control = robot.controller
    return 2.0 * min(mean - control.pressure_low, control.pressure_high - mean)


def excite(
    arm: Arm,
    targets: Array,
    characteristics: Mapping[int, Characteristic],
    mean: float,
    every_s: float,
    loads: Mapping[int, float] | None = None,
) -> ArmLog:
    """Run pressure differences that belong to target angles (K, n) at knots of `SPACING`."""
    arm.hang(loads or {})
    difference = difference_along(arm, targets, characteristics, mean, loads)
    return arm.run(Reference.pressures(SPACING, difference, mean), every_s)


def home(arm: Arm, characteristics: Mapping[int, Characteristic]) -> ArmLog:
    """Decaying cycles of all pneumatic joints at once: afterwards the memory of every muscle is known to be spent."""
    robot = arm.robot
    homing = robot.homing
    cycle = decaying_cycles(homing.cycles, homing.decay, homing.period, SPACING).value
    share = np.array(
        [homing.range_share * robot.joint(n).range if n in characteristics else 0.0 for n in arm.moving]
    )
    mean = robot.controller.mean_pressure
    return excite(arm, cycle[:, None] * share, characteristics, mean, every_s=0.05)
