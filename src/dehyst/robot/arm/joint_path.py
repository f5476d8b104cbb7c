"""Converts a tool path to joint angles over arc length: solved at some hundred points, then splines."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Protocol

import numpy as np
import numpy.typing as npt
from scipy.interpolate import BSpline, make_interp_spline

from dehyst.arrays import Array
from dehyst.errors import ParameterError
from dehyst.robot.arm.kinematics import InverseKinematics
from dehyst.robot.arm.parameters import Robot
from dehyst.robot.arm.rigid_body import arm_model, tool_positions

DEGREE = 5  # angles are four times continuously differentiable within a leg
LEAST_KNOTS = 9  # of a leg
DEVIATION = 2e-6  # of the tool in the middle between two knots at which no more are set [m]
REFINEMENTS = 8


class ToolPath(Protocol):
    """What is needed of a path, e.g. of a `dehyst.design.TestPath`."""

    @property
    def rests(self) -> Array:
        """Arc lengths from 0 at which the path rests and may change its direction, its two ends included. [m]"""

    def position(self, s: Array, /) -> Array:
        """Return points (N, 3) at arc lengths (N,). [m]"""


@dataclass(frozen=True, eq=False)
class JointPath:
    """Angles of all joints over the arc length s of the tool's path.

    Attributes
    ----------
    rests
        (L + 1,) where the legs begin and end. [m]
    legs
        One spline a leg, from s to seven angles. [rad]
    deviation
        Largest distance of the tool from its path, in the middle between two knots, of all legs. [m]
    """

    rests: Array
    legs: tuple[BSpline, ...]
    deviation: float

    @property
    def knots(self) -> int:
        """Number of points at which the inverse kinematics was solved."""
        return sum(len(leg.c) for leg in self.legs)

    def angles(self, s: npt.ArrayLike, derivative: int = 0) -> Array:
        """Return the angles (T, 7) at arc lengths (T,), or their first to fourth derivative by s. [rad/m^n]

        At a rest the derivatives are those of the leg that begins there.
        """
        at = np.clip(np.atleast_1d(np.asarray(s, np.float64)), self.rests[0], self.rests[-1])
        leg = np.clip(np.searchsorted(self.rests, at, side="right") - 1, 0, len(self.legs) - 1)
        out = np.empty((at.size, 7))
        for index in np.unique(leg):
            here = leg == index
            out[here] = self.legs[index](at[here], nu=derivative)
        return out

    def motion(self, s: Array, speed: Array, acceleration: Array) -> tuple[Array, Array, Array]:
        """Angles, velocities and accelerations of a motion along the path.

            q = q(s),   qd = q' sd,   qdd = q'' sd^2 + q' sdd

        Parameters
        ----------
        s, speed, acceleration
            Arc length and its derivatives by time, (T,). [m, m/s, m/s^2]

        Returns
        -------
        tuple of ndarray
            (T, 7) each. [rad, rad/s, rad/s^2]
        """
        q, slope, bend = (self.angles(s, derivative) for derivative in range(3))
        v, a = np.asarray(speed)[:, None], np.asarray(acceleration)[:, None]
        return q, slope * v, bend * v**2 + slope * a


def joint_path(robot: Robot, path: ToolPath) -> JointPath:
    """Solve the inverse kinematics along a path and put splines through the solutions.

    Knots are set where they are needed: an interval is halved until the tool, in its middle, is within 2 um of the
    path.

    Parameters
    ----------
    robot
        From `load_robot`.
    path
        Of the tool, in the frame of the base.

    Raises
    ------
    ParameterError
        If the path leaves the arm's reach; says where.

    Examples
    --------
    >>> from dehyst.robot.iso9283 import TestCube, test_path
    >>> from dehyst.robot.arm import load_robot
    >>> robot = load_robot()
    >>> path = test_path(TestCube(robot.path.cube, robot.path.center), robot.path.rounding)
    >>> joints = joint_path(robot, path)
    >>> joints.angles([0.0, 1.0]).shape, joints.deviation < 20e-6
    ((2, 7), True)
    """
    rests = np.asarray(path.rests, np.float64)
    if rests.size < 2 or not (np.diff(rests) > 0).all():
        raise ParameterError(f"rests = {rests} are no legs: pass increasing arc lengths, both ends included.")
    solver = InverseKinematics(robot)
    model = arm_model(robot)
    legs, worst = [], 0.0
    for start, end in pairwise(rests):
        s = np.linspace(start, end, LEAST_KNOTS)
        q = solver.solve(path.position(s))
        for _ in range(REFINEMENTS):
            spline = make_interp_spline(s, q, k=DEGREE)
            middle = (s[:-1] + s[1:]) / 2
            points = path.position(middle)
            distance = np.linalg.norm(tool_positions(model, spline(middle)) - points, axis=1)
            coarse = distance > DEVIATION
            if not coarse.any():
                break
            s, order = _sorted(s, middle[coarse])
            q = np.concatenate([q, solver.solve(points[coarse])])[order]
        legs.append(make_interp_spline(s, q, k=DEGREE))
        worst = max(worst, float(distance.max()))
    return JointPath(rests, tuple(legs), worst)


def _sorted(s: Array, more: Array) -> tuple[Array, npt.NDArray[np.int64]]:
    both = np.concatenate([s, more])
    order = np.argsort(both)
    return both[order], order
