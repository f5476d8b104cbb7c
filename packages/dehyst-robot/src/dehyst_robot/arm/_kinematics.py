"""Inverse kinematics of the redundant arm: from a path of the tool to splines of all joint angles over its length.

The angles depend on the tool's position x alone, not on how it got there:

    q(x) = argmin  sum_j w_j (q_j/range_j)^2   subject to   p(q) = x,  |q_j| <= range_j

with p the tool centre point and w the ``posture_weights`` of the file. A closed path of the tool is then a closed path
of the joints, and a smooth one a smooth one. Each step solves the quadratic program of the problem linearised at q.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from itertools import pairwise
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt
from scipy.interpolate import BSpline, make_interp_spline

from dehyst.arrays import Array
from dehyst.errors import ParameterError
from dehyst_robot.arm._parameters import Robot
from dehyst_robot.arm._rigid_body import arm_model, mink, mujoco, tool_positions, tool_site

STRIDE = (
    0.05  # of the tool between two solutions: beyond it the linearised problem is too far off [m]
)
STEPS = 60  # linearised problems for one point, at most
LARGEST = 0.2  # step of a joint: the linearised problem is valid near the present angles only [rad]
SETTLED = 1e-9  # change of the angles in a step at which it ends [rad]
REACHED = 1e-7  # distance from the point that counts as reached [m]
SOLVER = "daqp"
DEGREE = 5  # angles are four times continuously differentiable within a leg
LEAST_KNOTS = 9  # of a leg
DEVIATION = 2e-6  # of the tool in the middle between two knots at which no more are set [m]
REFINEMENTS = 8


class InverseKinematics:
    """Inverse kinematics of a robot; each solution starts from the one before.

    Parameters
    ----------
    robot
        Geometry and ranges of the joints, ``path.posture_weights``.

    Raises
    ------
    MissingExtraError
        If mujoco or mink is not installed.

    Examples
    --------
    >>> from dehyst_robot.arm import load_robot
    >>> from dehyst_robot.arm import arm_model
    >>> from dehyst_robot.arm.kit import tool_positions
    >>> robot = load_robot()
    >>> path = np.array(robot.path.center) + np.array([[0.0, 0.0, 0.0], [0.0, 0.1, 0.0]])
    >>> angles = InverseKinematics(robot).solve(path)
    >>> bool(np.abs(tool_positions(arm_model(robot), angles) - path).max() < 1e-6)
    True
    """

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        model = arm_model(robot)
        self._site = tool_site(model)
        self._configuration = mink().Configuration(model, np.zeros(model.nq))
        weights = robot.path.posture_weights or np.ones(model.nq)
        # mink squares the costs: the root makes them the weights w of the formula.
        cost = np.sqrt(weights) / [robot.joint(number).range for number in robot.joints]
        self._posture = mink().PostureTask(model, cost=cost)
        self._posture.set_target(np.zeros(model.nq))
        self._tool = _tool_task()(model)
        self._limits = [mink().ConfigurationLimit(model, gain=1.0)]

    def solve(self, points: Array) -> Array:
        """Return the angles for points of the tool.

        Parameters
        ----------
        points
            (N, 3) in the frame of the base, in the order of the path. [m]

        Returns
        -------
        angles : ndarray
            (N, n). [rad]

        Raises
        ------
        ParameterError
            If a point is not a finite number or out of reach; says which, how far, and what to change.
        """
        x = np.atleast_2d(np.asarray(points, np.float64))
        if x.ndim != 2 or x.shape[1] != 3 or not np.isfinite(x).all():
            raise ParameterError(
                f"points of shape {np.shape(points)} are no path: pass (N, 3), finite, in metres.",
                shape=np.shape(points),
            )
        angles = np.empty((x.shape[0], self._configuration.nq))
        for index, target in enumerate(x):
            self._approach(target)
            if not self._settle(target) and not self._settle_from_nearest(target):
                self._refuse(index, target)
            angles[index] = self._configuration.q
        return angles

    @property
    def _here(self) -> Array:
        return np.array(self._configuration.data.site_xpos[self._site])

    def _approach(self, target: Array) -> None:
        """Go near a far target in strides, none of which needs to be exact."""
        start = self._here
        strides = int(np.linalg.norm(target - start) // STRIDE)
        for share in np.linspace(0.0, 1.0, strides + 2)[1:-1]:
            self._tool.target = start + share * (target - start)
            if not self._step(exact=True):
                return

    def _settle(self, target: Array) -> bool:
        self._tool.target = target
        for _ in range(STEPS):
            before = self._configuration.q.copy()
            if not self._step(exact=True):
                return False
            if np.abs(self._configuration.q - before).max() < SETTLED:
                return float(np.linalg.norm(self._here - target)) < REACHED
        return False

    def _settle_from_nearest(self, target: Array) -> bool:
        """Try again from as near as possible: from far off, limits of joints can make the exact problem unsolvable."""
        for _ in range(STEPS):
            self._step(exact=False)
        nearest = self._configuration.q.copy()
        if self._settle(target):
            return True
        self._configuration.update(nearest)
        return False

    def _step(self, exact: bool) -> bool:
        """Solve the problem linearised at the present angles and go to its solution; return whether there is one.

        With `exact` the tool's position is a constraint, else it is an error that is minimised with the posture's.
        """
        lib = mink()
        tasks, constraints = [self._tool, self._posture], None
        if exact:
            tasks, constraints = [self._posture], [self._tool]
        try:
            velocity = lib.solve_ik(
                self._configuration,
                tasks,
                1.0,
                SOLVER,
                limits=self._limits,
                constraints=constraints,
            )
        except lib.NoSolutionFound:
            return False
        velocity *= min(1.0, LARGEST / max(float(np.abs(velocity).max()), LARGEST))
        ranges = self._configuration.model.jnt_range
        self._configuration.update(
            np.clip(self._configuration.q + velocity, ranges[:, 0], ranges[:, 1])
        )
        return True

    def _refuse(self, index: int, target: Array) -> None:
        distance = float(np.linalg.norm(self._here - target))
        at_end = []
        for number, q in zip(self._robot.joints, self._configuration.q, strict=True):
            if abs(q) > 0.999 * self._robot.joint(number).range:
                at_end.append(number)
        reason = "the arm is too short or folded"
        if at_end:
            reason = f"joints {at_end} are at the ends of their ranges"
        point = ", ".join(f"{coordinate:.3f}" for coordinate in target)
        center = ", ".join(f"{coordinate:g}" for coordinate in self._robot.path.center or ())
        raise ParameterError(
            f"point {index} of the path, ({point}) m, cannot be reached: the tool stays {1e3 * distance:.1f} mm away, "
            f"{reason}. Make path.cube_m smaller than {self._robot.path.cube:g}, move path.center_m = [{center}], or "
            f"change joint.J.range_deg or link_length_m.",
            point=index,
            target=tuple(target.tolist()),
            distance=distance,
            joints_at_end=at_end,
        )


@cache
def _tool_task() -> Any:
    """Return the task "tool at this point" for mink, whose own frame task fixes the orientation too."""

    class ToolPoint(mink().Task):  # type: ignore[misc]
        """p(q) - x, and its Jacobian."""

        def __init__(self, model: Any) -> None:
            super().__init__(cost=np.full(3, 1e3), lm_damping=1.0)
            self.target = np.zeros(3)
            self._jacobian = np.zeros((3, model.nv))

        def compute_error(self, configuration: Any) -> Array:
            return np.asarray(
                configuration.data.site_xpos[tool_site(configuration.model)] - self.target
            )

        def compute_jacobian(self, configuration: Any) -> Array:
            model, site = configuration.model, tool_site(configuration.model)
            mujoco().mj_jacSite(model, configuration.data, self._jacobian, None, site)
            return self._jacobian.copy()

    return ToolPoint


class ToolPath(Protocol):
    """Members of a path that `joint_path` uses, e.g. of a `dehyst_robot.iso9283.TestPath`."""

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
        One spline a leg, from s to the n angles. [rad]
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
        """Return the angles (T, n) at arc lengths (T,), or their first to fourth derivative by s. [rad/m^n]

        At a rest the derivatives are those of the leg that begins there.
        """
        # A sum of time steps may end a rounding error behind the path.
        at = np.clip(np.atleast_1d(np.asarray(s, np.float64)), self.rests[0], self.rests[-1])
        leg = np.clip(np.searchsorted(self.rests, at, side="right") - 1, 0, len(self.legs) - 1)
        out = np.empty((at.size, self.legs[0].c.shape[1]))
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
            (T, n) each. [rad, rad/s, rad/s^2]
        """
        q = self.angles(s)
        slope = self.angles(s, 1)
        bend = self.angles(s, 2)
        v = np.asarray(speed)[:, None]
        a = np.asarray(acceleration)[:, None]
        return q, slope * v, bend * v**2 + slope * a


def joint_path(robot: Robot, path: ToolPath) -> JointPath:
    """Solve the inverse kinematics along a path and put splines through the solutions.

    An interval between two knots is halved until the tool, in its middle, is within 2 um of the path.

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
    >>> from dehyst_robot.iso9283 import TestCube, test_path
    >>> from dehyst_robot.arm import load_robot
    >>> robot = load_robot()
    >>> path = test_path(TestCube(robot.path.cube, robot.path.center), robot.path.rounding)
    >>> joints = joint_path(robot, path)
    >>> joints.angles([0.0, 1.0]).shape, joints.deviation < 20e-6
    ((2, 7), True)
    """
    rests = np.asarray(path.rests, np.float64)
    if rests.size < 2 or not (np.diff(rests) > 0).all():
        raise ParameterError(
            f"rests = {rests} are no legs: pass increasing arc lengths, both ends included."
        )
    solver = InverseKinematics(robot)
    model = arm_model(robot)
    legs = []
    worst = 0.0
    # A leg for itself: at a rest the path may have a corner, which no spline follows.
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
            # Only the intervals that are too coarse get a knot in their middle.
            s, order = _sorted(s, middle[coarse])
            q = np.concatenate([q, solver.solve(points[coarse])])[order]
        legs.append(make_interp_spline(s, q, k=DEGREE))
        worst = max(worst, float(distance.max()))
    return JointPath(rests, tuple(legs), worst)


def _sorted(s: Array, more: Array) -> tuple[Array, npt.NDArray[np.int64]]:
    both = np.concatenate([s, more])
    order = np.argsort(both)
    return both[order], order
