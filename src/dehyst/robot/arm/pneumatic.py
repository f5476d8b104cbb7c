"""One pneumatic joint in open loop: prescribed angle, commanded pressures."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from dehyst._native import PneumaticJoint
from dehyst.arrays import Array
from dehyst.errors import ParameterError
from dehyst.robot.arm.mechanisms import Mechanism


@dataclass(frozen=True, eq=False)
class Course:
    """What a joint did. The second axis of (T, 2) arrays is the muscle; positive angles shorten the first one.

    Attributes
    ----------
    time
        (T,), [s]
    angle
        (T,), as it was moved. [rad]
    torque
        (T,), on the joint. [Nm]
    pressure
        (T, 2), gauge. [Pa]
    contraction
        (T, 2), of the length at rest.
    force
        (T, 2), pull of the muscles, never negative. [N]
    friction
        (T, 2), hysteresis force that opposes contraction. [N]
    """

    time: Array
    angle: Array
    torque: Array
    pressure: Array
    contraction: Array
    force: Array
    friction: Array


def run_pressures(
    parameters: dict[str, Any],
    angle: npt.ArrayLike,
    pressure: npt.ArrayLike,
    period: float,
    *,
    mechanisms: Sequence[Mechanism] = (),
) -> Course:
    """Run a joint with ideal pressures in its muscles, in place of valves and chambers.

    Parameters
    ----------
    parameters
        Physics of the joint, see `dehyst.robot.arm.joints.pneumatic_joint_parameters`.
    angle
        (T,) angles, one a period, linear in between. [rad]
    pressure
        (T, 2) gauge pressures; those of the first sample are where nothing is remembered. [Pa]
    period
        Time from sample to sample, 0.5 ms on the robot. [s]
    mechanisms
        Two hysteresis mechanisms of one's own (`dehyst.robot.arm.mechanisms.Mechanism`); none: those of the parameters.

    Returns
    -------
    Course
        T samples, the first one the start.

    Raises
    ------
    ParameterError
        If lengths differ, or the physics are not complete.

    Examples
    --------
    A loop of the angle at 3 bar: the torque at its end is not the one at its start.

    >>> from dehyst.robot.arm import load_robot
    >>> from dehyst.robot.arm.joints import pneumatic_joint_parameters
    >>> physics = pneumatic_joint_parameters(load_robot(), 1, seed=0)
    >>> angle = 0.3 * np.sin(np.linspace(0.0, 2.0 * np.pi, 2001))
    >>> course = run_pressures(physics, angle, np.full((2001, 2), 3e5), period=0.01)
    >>> bool(4.0 < abs(course.torque[1000] - course.torque[2000]) < 24.0)
    True
    """
    q, p = _checked(angle, pressure, period)
    joint = _joint(parameters, mechanisms)
    joint.reset(float(q[0]), float(p[0, 0]), float(p[0, 1]), 0)
    first = joint.state
    signals = joint.run_imposed(q[:-1], np.diff(q) / period, p[1:], period)
    both = {name: np.vstack([first[name], signals[name]]) for name in ("pressure", "contraction", "force", "friction")}
    both["pressure"] = both["pressure"] - float(parameters["air"]["ambient"])
    force = both["force"]
    torque = np.concatenate(([float(parameters["radius"]) * (force[0, 0] - force[0, 1])], signals["torque"]))
    time: Array = np.arange(q.size, dtype=np.float64) * period
    return Course(time=time, angle=q, torque=torque, **both)


def _checked(angle: npt.ArrayLike, commands: npt.ArrayLike, period: float) -> tuple[Array, Array]:
    q, u = np.ascontiguousarray(angle, dtype=np.float64), np.ascontiguousarray(commands, dtype=np.float64)
    if q.ndim != 1 or q.size == 0 or u.shape != (q.size, 2):
        raise ParameterError(
            f"angles of shape {q.shape} and commands of shape {u.shape}: a joint takes (T,) and (T, 2), "
            "one row of commands an angle",
            angle=q.shape,
            commands=u.shape,
        )
    if not 0 < period < 10 or not np.all(np.isfinite(q)):
        raise ParameterError(
            f"period = {period} s, angles from {q.min()} to {q.max()} rad: a period lies between 0 and 10 s, "
            "0.0005 s on the robot; angles are finite, or the joint would stand still where they are not",
            period=period,
        )
    return q, u


def _joint(parameters: dict[str, Any], mechanisms: Sequence[Mechanism]) -> PneumaticJoint:
    if len(mechanisms) not in (0, 2):
        raise ParameterError(
            f"{len(mechanisms)} mechanisms for two muscles: give two, each with a memory of its own, or none",
            mechanisms=len(mechanisms),
        )
    try:
        joint = PneumaticJoint(parameters, 0)
    except ValueError as fault:
        raise ParameterError(
            f"the physics of the joint are not usable: {fault}. See dehyst.robot.arm.joints.pneumatic_joint_parameters"
        ) from None
    for muscle, mechanism in enumerate(mechanisms):
        joint.attach(muscle, mechanism)
    return joint
