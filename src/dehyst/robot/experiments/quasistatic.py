"""Quasi-static runs with commanded pressures: homing, calibration sweeps, identification loops.

A target angle is turned into a pressure difference by a characteristic: that shapes the excitation, it does not
control the angle. Where the joint really goes is what is measured.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from dehyst.arrays import Array
from dehyst.control import FLAGS, SWITCHES
from dehyst.design import decaying_cycles
from dehyst.errors import SimulationError
from dehyst.robot.arm.arm import Arm, ArmLog, Reference
from dehyst.robot.arm.parameters import Robot
from dehyst.robot.experiments.results import Characteristic

SPACING = 0.01  # of the knots of a pressure reference [s]
QUIET_S = 2.0  # after homing, for what still rings


def known_torque(arm: Arm, angles: Array, hung: Array | float = 0.0) -> Array:
    """Torque (K, n) that the drives must give at rest: nominal gravity less what is hung on the joints. [Nm]"""
    return np.asarray(arm.gravity(angles) * (1 + arm.robot.controller.gravity_error) - hung)


def pressure_room(robot: Robot, mean: Array | float) -> Array:
    """Largest |dp| that keeps both muscles within their limits at this mean pressure. [Pa]"""
    control = robot.controller
    return np.asarray(2.0 * np.minimum(mean - control.pressure_low, control.pressure_high - mean))


def excite(
    arm: Arm,
    targets: Array,
    characteristics: Mapping[int, Characteristic],
    every_s: float,
    mean: Array | None = None,
    hung: Array | None = None,
    switches: int = 0,
) -> ArmLog:
    """Run the pressure differences that belong to target angles.

    Parameters
    ----------
    arm
        Where it is.
    targets
        (K, n) angles at knots of `SPACING`. [rad]
    characteristics
        Joint number -> what turns an angle into a pressure difference; other joints stand still.
    every_s
        Of the log. [s]
    mean
        (K, n) mean pressures; None: the controller's. [Pa]
    hung
        (K, n) known torques on the joints; None: none. [Nm]
    switches
        What is on besides: ``SWITCHES["adapt"]`` lets direct inverses learn.

    Raises
    ------
    SimulationError
        If a controller failed safe on the way: the log would be of a joint that is switched off.
    """
    mean = np.full(targets.shape, arm.robot.controller.mean_pressure) if mean is None else mean
    hung = np.zeros(targets.shape) if hung is None else hung
    torque = known_torque(arm, targets, hung)
    difference = np.zeros(targets.shape)
    for i, number in enumerate(arm.moving):
        if number in characteristics:
            wanted = characteristics[number].difference(targets[:, i], mean[:, i], torque[:, i])
            room = pressure_room(arm.robot, mean[:, i])
            difference[:, i] = np.clip(wanted, -room, room)
    log = arm.run(Reference.pressures(SPACING, difference, mean, hung, switches), every_s)
    refuse_failed(arm, log)
    return log


def refuse_failed(arm: Arm, log: ArmLog) -> None:
    """Refuse a log in which a controller failed safe: from there on it is of a joint that is switched off."""
    failed = np.flatnonzero((log.flags & FLAGS["failed"]).any(axis=0))
    if failed.size:
        raise SimulationError(
            f"the controller of joint {arm.moving[failed[0]]} failed safe: a sensor reading was not credible (flags "
            f"{int(log.flags[-1, failed[0]])}). Raise controller.angle_jump_deg or pressure_jump_bar, or run slower.",
            joint=arm.moving[failed[0]],
        )


def home(arm: Arm, characteristics: Mapping[int, Characteristic]) -> ArmLog:
    """Decaying cycles of all pneumatic joints at once: afterwards the memory of muscles and compensators is spent."""
    return _homed(arm, characteristics, 0)


def home_and_learn(arm: Arm, characteristics: Mapping[int, Characteristic]) -> ArmLog:
    """Home while direct inverses learn what their actuators have become: the cycles excite every term."""
    return _homed(arm, characteristics, SWITCHES["adapt"])


def _homed(arm: Arm, characteristics: Mapping[int, Characteristic], switches: int) -> ArmLog:
    homing = arm.robot.homing
    cycle = decaying_cycles(homing.cycles, homing.decay, homing.period, SPACING).value
    cycle = np.concatenate([cycle, np.zeros(round(QUIET_S / SPACING))])
    share = [homing.range_share * arm.robot.joint(n).range if n in characteristics else 0.0 for n in arm.moving]
    log = excite(arm, cycle[:, None] * np.array(share), characteristics, every_s=0.05, switches=switches)
    arm.forget()
    return log
