"""The ISO 9283 path as joint angles, with the speed that pressures and valves allow."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array
from dehyst.control import JointControllerParameters
from dehyst.robot.arm.kinematics import JointPath, joint_path
from dehyst.robot.arm.parameters import Robot
from dehyst.robot.arm.rigid_body import arm_model, inverse_dynamics
from dehyst.robot.experiments.nominal import controller_parameters, nominal_characteristic
from dehyst.robot.experiments.quasistatic import pressure_room
from dehyst.robot.experiments.results import Characteristic
from dehyst.robot.iso9283 import TestCube, Timed, slow_down_to, test_path, timed

KNOTS = 1500  # of the motion that is checked against the limits


@dataclass(frozen=True, eq=False)
class ArmPath:
    """A timed tool path and the joint angles that belong to it.

    Attributes
    ----------
    timing
        The fast motion; ``timing.slower(10)`` is the slow one.
    joints
        Arc length -> angles.
    """

    timing: Timed
    joints: JointPath

    @property
    def start(self) -> Array:
        """Angles where a cycle begins, (7,). [rad]"""
        return np.asarray(self.joints.angles(0.0)[0])

    def motion(self, timing: Timed, time: Array) -> tuple[Array, Array, Array]:
        """Angles, velocities and accelerations (T, 7) at times (T,) of a motion along this path."""
        along = timing.motion(time)
        return self.joints.motion(along.s, along.speed, along.acceleration)


def plan_path(robot: Robot) -> ArmPath:
    """Inverse kinematics of the test path, and the fastest timing that pressures and valves allow.

    Parameters
    ----------
    robot
        Its [path] table: cube, speeds, rests.

    Returns
    -------
    path : ArmPath

    Raises
    ------
    ParameterError
        If the arm cannot reach the path; says where, and what to change.

    Examples
    --------
    >>> from dehyst.robot.arm.parameters import load_robot
    >>> path = plan_path(load_robot())
    >>> [figure.name for figure in path.timing.path.figures], round(path.timing.duration)
    (['line', 'large circle', 'small circle', 'rectangle'], 28)
    """
    settings = robot.path
    path = test_path(TestCube(settings.cube, settings.center), settings.rounding)
    motion = timed(path, settings.fast_speed, settings.acceleration, settings.jerk, settings.rest)
    planned = ArmPath(motion, joint_path(robot, path))
    model = arm_model(robot)
    plans = {n: nominal_characteristic(robot, n) for n in robot.pneumatic}
    controllers = {n: controller_parameters(robot, n, plan) for n, plan in plans.items()}

    def use(timing: Timed) -> float:
        time = np.linspace(0.0, timing.duration, KNOTS)
        angle, velocity, acceleration = planned.motion(timing, time)
        torque = inverse_dynamics(model, angle, velocity, acceleration)
        return max(
            utilisation(robot, plans[n], controllers[n], angle[:, n - 1], torque[:, n - 1], time[1])
            for n in robot.pneumatic
        )

    return ArmPath(slow_down_to(motion, use), planned.joints)


SHARE = 0.85  # of pressures and of valve flow that a path may use: the rest is for the controller


def largest_flow(controller: JointControllerParameters, pressure: Array, fills: npt.NDArray[np.bool_]) -> Array:
    """Mass flow of the fully open nominal valve at absolute muscle pressures, ISO 6358. [kg/s]"""
    air = controller.pneumatics
    supply = np.asarray(air.supply)
    upstream = np.where(fills, supply, pressure)
    downstream = np.where(fills, pressure, air.ambient)
    ratio = np.clip(downstream / upstream, air.ratio, 1.0)
    psi = np.sqrt(np.maximum(0.0, 1 - ((ratio - air.ratio) / (1 - air.ratio)) ** 2))
    return np.asarray(air.conductance * air.reference_density * upstream * psi)


def utilisation(
    robot: Robot,
    characteristic: Characteristic,
    controller: JointControllerParameters,
    angle: Array,
    torque: Array,
    spacing: float,
) -> float:
    """Largest share of the allowed pressure difference and valve flow that a joint needs along a motion.

    Parameters
    ----------
    robot
        The arm.
    characteristic, controller
        Of the joint.
    angle, torque
        (K,) of the joint, with the whole inverse dynamics. [rad, Nm]
    spacing
        Of the samples. [s]

    Returns
    -------
    use : float
        1 where `SHARE` of a limit is reached.
    """
    flow = flow_share(robot, characteristic, controller, angle, torque, spacing)
    return max(pressure_share(robot, characteristic, angle, torque), flow) / SHARE


def pressure_share(robot: Robot, characteristic: Characteristic, angle: Array, torque: Array) -> float:
    """Largest |dp| along a motion (K,) [rad, Nm] by the one that the muscles' limits allow."""
    mean = robot.controller.mean_pressure
    difference = characteristic.difference(angle, mean, torque)
    return float(np.abs(difference).max() / pressure_room(robot, mean))


def flow_share(
    robot: Robot,
    characteristic: Characteristic,
    controller: JointControllerParameters,
    angle: Array,
    torque: Array,
    spacing: float,
) -> float:
    """Largest mass flow along a motion (K,) [rad, Nm, s] by that of the open nominal valve at its pressures."""
    mean = robot.controller.mean_pressure
    difference = characteristic.difference(angle, mean, torque)
    air, use = controller.pneumatics, 0.0
    for side, volume in zip((0.5, -0.5), controller.volume, strict=True):
        pressure = mean + side * difference + air.ambient
        chamber = np.polynomial.polynomial.polyval(angle, volume)
        flow = chamber / (air.polytropic * air.gas_temperature) * np.gradient(pressure, spacing)
        flow += pressure / air.gas_temperature * np.gradient(chamber, spacing)
        room = largest_flow(controller, pressure, flow > 0)
        use = max(use, float(np.max(np.abs(flow) / np.maximum(room, 1e-9))))
    return use
