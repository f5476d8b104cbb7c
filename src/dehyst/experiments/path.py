"""The ISO 9283 path as joint angles: inverse kinematics once, then any speed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from dehyst.arrays import Array
from dehyst.evaluation import TestCube, Timed, slow_down_to, test_path, timed
from dehyst.experiments.limits import utilisation
from dehyst.experiments.nominal import controller_parameters, nominal_characteristic
from dehyst.plant.joint_path import JointPath, joint_path
from dehyst.plant.parameters import Robot
from dehyst.plant.rigid_body import arm_model, inverse_dynamics

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
    >>> from dehyst.plant.parameters import load_robot
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
