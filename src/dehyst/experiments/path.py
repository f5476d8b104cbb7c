"""The ISO 9283 path as joint angles: inverse kinematics once, then any speed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from dehyst.evaluation import TestCube, Timed, slow_down_to, test_path, timed
from dehyst.plant.kinematics import JointSpline, joint_splines
from dehyst.plant.parameters import Robot

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
    """Inverse kinematics of the test path and the fastest timing that pressures and valves allow."""
    ...
