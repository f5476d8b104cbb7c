"""The ISO 9283 path as joint angles: inverse kinematics once, then any speed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from dehyst.evaluation import TestCube, Timed, slow_down_to, test_path, timed
from dehyst.experiments.limits import utilisation
from dehyst.experiments.nominal import controller_parameters, nominal_characteristic
from dehyst.plant.kinematics import JointSpline, joint_splines
from dehyst.plant.parameters import Robot
from dehyst.plant.rigid_body import arm_model, inverse_dynamics

KNOTS = 1500  # of the motion that is checked against the limits

Array = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class ArmPath:
    """A timed tool path and the joint angles that belong to it.

    Attributes
    ----------
    timing
        The fast motion; ``timing.slower(10)`` is the slow one.
    splines
        One a leg of the path: arc length within the leg -> angles.
    """

    timing: Timed
    splines: tuple[JointSpline, ...]

    @property
    def start(self) -> Array:
        """Angles where a cycle begins, (7,). [rad]"""
        return self.splines[0](np.zeros(1))[0][0]

    def state(self, timing: Timed, time: Array) -> tuple[Array, Array, Array]:
        """Angles, velocities and accelerations (T, 7) at times (T,) of a motion along this path."""
        motion = timing.motion(time)
        starts = self.timing.path.chain.starts
        leg = timing.leg[timing._phase(time)[0]]
        angle, velocity, acceleration = (np.empty((time.size, 7)) for _ in range(3))
        for index, spline in enumerate(self.splines):
            rows = leg == index
            q, dq, ddq = spline(motion.s[rows] - starts[index])
            v, a = motion.speed[rows, None], motion.acceleration[rows, None]
            angle[rows] = q
            velocity[rows] = dq * v
            acceleration[rows] = ddq * v**2 + dq * a
        return angle, velocity, acceleration


def plan_path(robot: Robot) -> ArmPath:
    """Inverse kinematics of the test path, and the fastest timing that pressures and valves allow.

    Parameters
    ----------
    robot
        Its [path] table: cube, speeds, rests.

    Returns
    -------
    path : ArmPath
    """
    settings = robot.path
    path = test_path(TestCube(settings.cube, settings.centre), settings.rounding)
    motion = timed(path, settings.fast_speed, settings.acceleration, settings.jerk, settings.rest)
    planned = ArmPath(motion, joint_splines(robot, [leg.curve for leg in path.legs]))
    model = arm_model(robot)
    plans = {n: nominal_characteristic(robot, n) for n in robot.pneumatic}
    controllers = {n: controller_parameters(robot, n, plan) for n, plan in plans.items()}

    def use(timing: Timed) -> float:
        time = np.linspace(0.0, timing.duration, KNOTS)
        angle, velocity, acceleration = planned.state(timing, time)
        torque = inverse_dynamics(model, angle, velocity, acceleration)
        return max(
            utilisation(robot, plans[n], controllers[n], angle[:, n - 1], torque[:, n - 1], time[1])
            for n in robot.pneumatic
        )

    return ArmPath(slow_down_to(motion, use), planned.splines)
