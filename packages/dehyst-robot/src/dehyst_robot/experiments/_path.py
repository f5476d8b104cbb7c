"""The ISO 9283 path as joint angles, and excitations of a joint, as fast as pressures and valves allow."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array
from dehyst.design import ExcitationPlan, design_excitation, limits_of
from dehyst.errors import ParameterError
from dehyst.units import convert
from dehyst_robot.arm import JointPath, Robot, arm_model, bias_torque
from dehyst_robot.arm import kit as arm_kit
from dehyst_robot.control import JointControllerParameters
from dehyst_robot.experiments._calibration import (
    SPACING,
    controller_parameters,
    nominal_characteristic,
    pressure_room,
)
from dehyst_robot.experiments._policy import POLICY
from dehyst_robot.experiments._reference import JointSpacePath, drawn_moves, read_moves
from dehyst_robot.experiments._results import Characteristic
from dehyst_robot.iso9283 import TestCube, Timed, Timing, slow_down_to, test_path, timed

KNOTS = 1500  # of the motion that is checked against the limits


class PlannedPath(Protocol):
    """What trials ask of a path: an `ArmPath`, or a `JointSpacePath`."""

    @property
    def timing(self) -> Any:
        """The fast motion, a `Timing`."""

    @property
    def start(self) -> Array:
        """Angles where a cycle begins, (n,). [rad]"""

    def motion(self, timing: Any, time: Array, /) -> tuple[Array, Array, Array]:
        """Angles, velocities and accelerations (T, n) at times (T,) of a motion along this path."""


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
        """Angles where a cycle begins, (n,). [rad]"""
        return np.asarray(self.joints.angles(0.0)[0])

    def motion(self, timing: Timed, time: Array) -> tuple[Array, Array, Array]:
        """Angles, velocities and accelerations (T, n) at times (T,) of a motion along this path."""
        along = timing.motion(time)
        return self.joints.motion(along.s, along.speed, along.acceleration)


def plan_path(robot: Robot, reference: str | Path | None = None) -> PlannedPath:
    """Inverse kinematics of the test path, or moves of the joints, at most as fast as pressures and valves allow.

    Parameters
    ----------
    robot
        Its [path] table: cube, speeds, rests. With a [reference], or without ``path.center_m``, the joints follow a
        reference of their own.
    reference
        Log of angles that the joints shall follow instead, see `read_moves`.

    Returns
    -------
    path : PlannedPath
        An `ArmPath`, or a `JointSpacePath`.

    Raises
    ------
    ParameterError
        If the arm cannot reach the path; says where, and what to change. If pressures cannot hold it anywhere.

    Examples
    --------
    >>> from dehyst_robot.arm import load_robot
    >>> path = plan_path(load_robot())
    >>> [figure.name for figure in path.timing.path.figures], round(path.timing.duration)
    (['line', 'large circle', 'small circle', 'rectangle'], 28)
    """
    planned: Any = _planned(robot, reference)
    model = arm_model(robot)
    plans = {n: nominal_characteristic(robot, n) for n in robot.pneumatic}
    controllers = {n: controller_parameters(robot, n, plan) for n, plan in plans.items()}

    def use(timing: Timing) -> float:
        time = np.linspace(0.0, timing.duration, KNOTS)
        angle, velocity, acceleration = planned.motion(timing, time)
        torque = arm_kit.inverse_dynamics(model, angle, velocity, acceleration)
        largest = 0.0
        for n, plan in plans.items():
            q, load = angle[:, n - 1], torque[:, n - 1]
            largest = max(largest, utilisation(robot, plan, controllers[n], q, load, time[1]))
        return largest

    slowed: PlannedPath = replace(planned, timing=slow_down_to(planned.timing, use))
    return slowed


def _planned(robot: Robot, reference: str | Path | None) -> ArmPath | JointSpacePath:
    """The path that is asked for, as fast as wanted."""
    settings, moves = robot.path, robot.reference
    if reference is None and moves is not None and moves.file is not None:
        reference = robot.beside(moves.file)
    if reference is not None:
        return JointSpacePath(read_moves(robot, reference))
    if settings.center is None or moves is not None:
        return JointSpacePath(drawn_moves(robot))
    path = test_path(TestCube(settings.cube, settings.center), settings.rounding)
    motion = timed(path, settings.fast_speed, settings.acceleration, settings.jerk, settings.rest)
    return ArmPath(motion, arm_kit.joint_path(robot, path))


def largest_flow(
    controller: JointControllerParameters, pressure: Array, fills: npt.NDArray[np.bool_]
) -> Array:
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
        1 where `planned_share` of a limit is reached.
    """
    flow = flow_share(robot, characteristic, controller, angle, torque, spacing)
    return max(pressure_share(robot, characteristic, angle, torque), flow) / POLICY.planned_share


def pressure_share(
    robot: Robot, characteristic: Characteristic, angle: Array, torque: Array
) -> float:
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


TRIES = 12  # to find a rate that the valves can follow
SLOWER = 0.8


@dataclass(frozen=True, eq=False)
class JointExcitation:
    """Excitation of a joint, and what it needs of pressures and valves by the nominal model.

    Attributes
    ----------
    number
        Of the joint.
    plan
        Angles, in its unit.
    difference
        (T,) nominal pressure difference at the plan's samples. [Pa]
    mean, room
        Mean pressure, and the largest |dp| that the muscles' limits leave at it. [Pa]
    pressure_share
        Largest |dp| by the allowed one, in 0..1.
    flow_share
        Largest mass flow by that of the open valve, in 0..1.
    inertia_torque
        Largest torque that acceleration takes; the log of an identification does not tell it from hysteresis. [Nm]
    """

    number: int
    plan: ExcitationPlan
    difference: Array
    mean: float
    room: float
    pressure_share: float
    flow_share: float
    inertia_torque: float


def design_joint(
    robot: Robot,
    number: int,
    *,
    low: float | None = None,
    high: float | None = None,
    rate: float | None = None,
    acceleration: float | None = None,
    time_limit: float = 600.0,
    period: float = 0.02,
    unit: str = "rad",
    motion: Callable[..., ExcitationPlan] = design_excitation,
) -> JointExcitation:
    """Return the excitation to run on a joint of the robot for an identification.

    What is not given is taken from the robot: the range from ``identification.range_share``; the acceleration so that
    the joint's inertia takes 0.2 % of the largest torque at most, which a quasi-static identification takes for
    hysteresis; the rate as fast as pressures and valves follow with a margin of 15 %, a stroke over the range in 4 s
    at most. Nothing of the simulated truth is used: the characteristic is that of a published bench map.

    Parameters
    ----------
    robot
        The arm.
    number
        Of a pneumatic joint.
    low, high
        Range within that of the joint; None: +-``identification.range_share`` of it. [rad]
    rate, acceleration
        Limits; None: from the robot. [rad/s, rad/s^2]
    time_limit
        Longest duration. [s]
    period
        Of the samples. [s]
    unit
        Of the angles of the plan, rad or deg; what is passed is in rad.
    motion
        Designs it: `design_excitation`, or `design_drift_motion`.

    Raises
    ------
    ParameterError
        If the joint is electric, the range leaves the joint's, pressures or valves cannot follow, or time is short.

    Examples
    --------
    >>> from dehyst_robot.arm import load_robot
    >>> found = design_joint(load_robot(), 7)
    >>> np.degrees([found.plan.low, found.plan.high]).round(1).tolist(), found.pressure_share < 0.85
    ([-17.5, 17.5], True)
    """
    joint = robot.joint(number)
    if not joint.pneumatic:
        raise ParameterError(
            f"joint {number} is electric: it has no muscles whose hysteresis could be identified. "
            f"Choose one of {', '.join(map(str, robot.pneumatic))}.",
            joint=number,
        )
    reach = robot.identification.range_share * joint.range
    if low is None:
        low = -reach
    if high is None:
        high = reach
    _refuse_outside(number, low, high, joint.range)
    characteristic = nominal_characteristic(robot, number)
    controller = controller_parameters(robot, number, characteristic)
    if acceleration is None:
        acceleration = _quiet_acceleration(robot, controller, characteristic, low, high, rate)
    shown = float(convert(1.0, "rad", unit))
    tried_rate = None
    if rate is not None:
        tried_rate = shown * rate
    for attempt in range(TRIES):
        plan = motion(
            shown * low,
            shown * high,
            rate=tried_rate,
            acceleration=shown * acceleration,
            time_limit=time_limit,
            period=period,
            unit=unit,
        )
        design = _needs(robot, number, plan, characteristic, controller)
        if max(design.pressure_share, design.flow_share) <= POLICY.planned_share:
            return design
        # Slower helps the valves alone, and a rate that was typed stays.
        if rate is not None or design.pressure_share > POLICY.planned_share or attempt == TRIES - 1:
            break
        tried_rate = shown * (SLOWER * plan.limits.rate / shown)
    raise _cannot_follow(design)


def _refuse_outside(number: int, low: float, high: float, largest: float) -> None:
    if not -largest <= low < high <= largest:
        a, b, c = np.degrees([low, high, largest])
        raise ParameterError(
            f"a range of {a:g} to {b:g} deg does not lie within joint {number}'s +-{c:g} deg. Pass --range LO HI "
            f"inside it, or change joint.{number}.range_deg in the robot's file.",
            joint=number,
        )


def _quiet_acceleration(
    robot: Robot, controller: JointControllerParameters, characteristic: Characteristic, low: float, high: float,
    rate: float | None,
) -> float:  # fmt: skip
    """Acceleration whose torque is small beside what the muscles give, and no more than strokes of that range need."""
    torque = float(characteristic.b[0] * pressure_room(robot, robot.controller.mean_pressure))
    return min(
        POLICY.inertia_share * torque / controller.inertia,
        limits_of(low, high, rate, None).acceleration,
    )


def _needs(
    robot: Robot,
    number: int,
    plan: ExcitationPlan,
    characteristic: Characteristic,
    controller: JointControllerParameters,
) -> JointExcitation:
    """Pressures and flow along the plan by the nominal model: weight, inertia, characteristic, valve."""
    scale = float(convert(1.0, plan.unit, "rad"))
    angle, coarse = (scale * plan.signal(period)[1] for period in (SPACING, plan.period))
    acceleration = np.gradient(np.gradient(angle, SPACING), SPACING)
    torque = _weight(robot, number, angle) + controller.inertia * acceleration
    mean = robot.controller.mean_pressure
    return JointExcitation(
        number,
        plan,
        characteristic.difference(coarse, mean, _weight(robot, number, coarse)),
        mean,
        float(pressure_room(robot, mean)),
        pressure_share(robot, characteristic, angle, torque),
        flow_share(robot, characteristic, controller, angle, torque, SPACING),
        float(controller.inertia * scale * plan.peak_acceleration),
    )


def _weight(robot: Robot, number: int, angle: Array) -> Array:
    """Nominal torque that holds the arm still with this joint turned, (T,). [Nm]"""
    places, inverse = np.unique(angle, return_inverse=True)
    grid = np.linspace(places[0], places[-1], 201)
    torque = bias_torque(arm_model(robot, moving=(number,)), grid[:, None])[:, 0]
    torque = torque * (1 + robot.controller.gravity_error)
    return np.asarray(np.interp(places, grid, torque)[inverse])


def _cannot_follow(design: JointExcitation) -> ParameterError:
    plan = design.plan
    a, b, rate = convert([plan.low, plan.high, plan.limits.rate], plan.unit, "deg")
    if design.pressure_share > POLICY.planned_share:
        still = float(np.abs(design.difference).max() / design.room)
        cure = "Pass a smaller --range, or change controller.mean_pressure_bar."
        if still <= POLICY.planned_share:
            cure = (
                f"At rest it would be {100 * still:.0f} %: pass a lower --acceleration or --rate."
            )
        return ParameterError(
            f"joint {design.number} from {a:.4g} to {b:.4g} deg takes {100 * design.pressure_share:.0f} % of the "
            f"pressure difference that the muscles' limits leave at {design.mean / 1e5:g} bar mean pressure; "
            f"{100 * POLICY.planned_share:.0f} % may be planned with. {cure}",
            joint=design.number,
            pressure_share=design.pressure_share,
        )
    return ParameterError(
        f"joint {design.number} at {rate:.4g} deg/s takes {100 * design.flow_share:.0f} % of the flow of its valves; "
        f"{100 * POLICY.planned_share:.0f} % may be planned with: the pressures would not follow. Pass a lower --rate "
        f"or a smaller --range.",
        joint=design.number,
        flow_share=design.flow_share,
    )
