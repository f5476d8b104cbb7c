"""Motions of the joints where no tool's path is to be followed: drawn moves with rests, or those of a file."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import numpy.typing as npt
from scipy.interpolate import BPoly, make_interp_spline

from dehyst.arrays import Array, Rows
from dehyst.errors import ParameterError
from dehyst.io import LogColumns, read_columns
from dehyst.units import convert
from dehyst_robot.arm import Drawn, Robot
from dehyst_robot.experiments._policy import POLICY

CLOSED = math.radians(POLICY.closed_deg)
LEAST_SAMPLES = 6  # of a file: what a quintic needs


@dataclass(frozen=True, eq=False)
class Moves:
    """Angles of all joints over time; cycles repeat for ever.

    Attributes
    ----------
    curve
        Times (T,) within a cycle [s] and order of the derivative -> (T, n). [rad, rad/s, rad/s^2]
    cycle_time
        Duration of one cycle at factor 1. [s]
    factor
        Times are this much longer.
    """

    curve: Callable[[Array, int], Array]
    cycle_time: float
    factor: float = 1.0

    @property
    def duration(self) -> float:
        """Duration of one cycle. [s]"""
        return self.factor * self.cycle_time

    @property
    def figure_names(self) -> tuple[str, ...]:
        """Of parts that are judged apart: there is one."""
        return ("moves",)

    def slower(self, factor: float) -> Moves:
        """Return the same motion, `factor` times as long as this one."""
        return replace(self, factor=self.factor * factor)

    def at(self, t: npt.ArrayLike) -> tuple[Array, Array, Array]:
        """Return angles, velocities and accelerations, (T, n) each, at times t (T,)."""
        tau = np.mod(
            np.maximum(np.atleast_1d(np.asarray(t, np.float64)), 0.0) / self.factor, self.cycle_time
        )
        q, v, a = (np.asarray(self.curve(tau, order)) / self.factor**order for order in range(3))
        return q, v, a

    def figure(self, t: npt.ArrayLike) -> Rows:
        """Return 0 for every time (T,)."""
        return np.zeros(np.size(t), np.int64)

    def cycle(self, t: npt.ArrayLike) -> Rows:
        """Return the number of the cycle at times t (T,), from 0."""
        elapsed = np.maximum(np.atleast_1d(np.asarray(t, np.float64)), 0.0) / self.factor
        return np.floor_divide(elapsed, self.cycle_time).astype(np.int64)


@dataclass(frozen=True, eq=False)
class JointSpacePath:
    """Moves in the place of an `ArmPath`: the same trials run on it."""

    timing: Moves

    @property
    def start(self) -> Array:
        """Angles where a cycle begins, (n,). [rad]"""
        return np.asarray(self.timing.at(0.0)[0][0])

    def motion(self, timing: Moves, time: Array) -> tuple[Array, Array, Array]:
        """Angles, velocities and accelerations (T, n) at times (T,)."""
        return timing.at(time)


def drawn_moves(robot: Robot) -> Moves:
    """Minimum-jerk moves of all joints at once from target to target, with a rest after each, from zero and back to it.

    The targets are drawn so that each joint comes once into every part of its range: of M targets, one in every M-th.
    Between two rests the angles are polynomials of degree five with no speed and no acceleration at their ends.

    Examples
    --------
    >>> from dehyst_robot.arm import load_robot
    >>> moves = drawn_moves(load_robot())
    >>> q, v, _ = moves.at(np.linspace(0.0, moves.duration, 1000))
    >>> q.shape, bool((np.ptp(q, axis=0) > 0.8 * 2 * 0.6 * np.array([0.7, 0.7, 2, 0.7, 2, 0.4, 0.4])).all())
    ((1000, 7), True)
    """
    drawn = robot.reference or Drawn()
    rng, count = np.random.default_rng(drawn.seed), drawn.moves
    reach = drawn.range_share * np.array([joint.range for joint in robot.joints.values()])
    parts = np.stack([rng.permutation(count) for _ in reach], axis=1)
    targets = (2 * (parts + rng.uniform(size=parts.shape)) / count - 1) * reach
    home = np.zeros_like(reach)
    # Each place stands twice: when it is reached, and when it is left.
    stops = np.repeat(np.vstack([home, targets, home]), 2, axis=0)[:-1]
    times = np.concatenate([[0.0], np.cumsum([*[robot.path.rest, drawn.move] * (count + 1)])])
    still = np.zeros_like(stops)
    curve = BPoly.from_derivatives(times, np.stack([stops, still, still], axis=1))
    return Moves(curve, float(times[-1]))


def read_moves(robot: Robot, file: str | Path) -> Moves:
    """Read a reference from a log: a time column, and one a joint, ``joint1_deg``, or its ``body_joint`` in its place.

    Where it ends elsewhere than it began, a minimum-jerk move leads back, for cycles to repeat. It is at rest at both
    ends, and a spline of degree five in between.

    Raises
    ------
    LogError
        If the file cannot be read; ColumnError if a joint has no column.
    ParameterError
        If there is no time, too little of it, time that repeats or runs back, or an angle beyond the joint's range.

    Warns
    -----
    UserWarning
        If angles look like radians in a column of degrees, or times like milliseconds in one of seconds.
    """
    names = {f"joint {n}": joint.body_joint or f"joint{n}" for n, joint in robot.joints.items()}
    table = read_columns(file, names)
    if table.time is None or table.time.size < LEAST_SAMPLES:
        raise ParameterError(
            f"{table.name} is no reference: it needs a column time_s and {LEAST_SAMPLES} rows or more.",
            file=table.name,
        )
    for finding in table.findings:
        if finding.code.endswith("-time"):
            raise ParameterError(
                f"{table.name} is no reference: {finding.message} A motion is followed as it is written: put its rows "
                f"in the order of time, each time once.",
                file=table.name,
            )
    angle = np.empty((table.time.size, len(names)))
    for k, name in enumerate(names):
        angle[:, k] = convert(table.values[name], table.units[name] or "deg", "rad")
    for k, (number, joint) in enumerate(robot.joints.items()):
        largest = float(np.abs(angle[:, k]).max())
        if largest > joint.range:
            raise ParameterError(
                f"{table.name} asks joint {number} for {np.degrees(largest):.4g} deg, its range ends at "
                f"{np.degrees(joint.range):.4g} deg. Make the reference smaller, or joint.{number}.range_deg larger.",
                joint=number,
            )
    _warn_of_units(robot, table, names)
    time = table.time - table.time[0]
    end = time[-1]
    zero = np.zeros(angle.shape[1])
    # Velocity and acceleration are zero at both ends.
    at_rest = [(1, zero), (2, zero)]
    forward = make_interp_spline(time, angle, k=5, bc_type=(at_rest, at_rest))
    if np.abs(angle[-1] - angle[0]).max() <= CLOSED:
        return Moves(forward, float(end))
    way_back_s = (robot.reference or Drawn()).move
    ends = [[angle[-1], zero, zero], [angle[0], zero, zero]]
    back = BPoly.from_derivatives([end, end + way_back_s], ends)

    def curve(t: Array, order: int) -> Array:
        on_the_way = (t <= end)[:, None]
        return np.asarray(np.where(on_the_way, forward(np.minimum(t, end), order), back(t, order)))

    return Moves(curve, float(end + way_back_s))


def _warn_of_units(robot: Robot, table: LogColumns, names: Mapping[str, str]) -> None:
    """Warn of radians in columns of degrees, and of milliseconds in a column of seconds."""
    assert table.time is not None
    small, moves_more = [], False
    for name, joint in zip(names, robot.joints.values(), strict=True):
        largest = float(np.abs(table.values[name]).max())
        if table.units[name] not in (None, "", "deg", "°"):
            continue
        # Radians in place of degrees leave the robot all but still.
        if 0.0 < largest <= math.pi and largest < POLICY.likely_radians * math.degrees(joint.range):
            small.append(largest)
        elif largest:
            moves_more = True
    if small and not moves_more:
        warnings.warn(
            f"{table.name} turns no joint by more than {max(small):.3g} deg, as if radians "
            f"stood in a column of degrees. If they do, call the columns joint1_rad, ...",
            UserWarning,
            stacklevel=2,
        )
    step = float(np.median(np.diff(table.time)))
    if step >= POLICY.likely_milliseconds:
        warnings.warn(
            f"{table.name} has a row every {step:.4g} s, as if milliseconds stood in a column of seconds. If they do, "
            f"call it time_ms.",
            UserWarning,
            stacklevel=2,
        )
