"""The highest stable gains of position loops, found by one procedure with and without compensator."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import replace

import numpy as np

from dehyst.arrays import Array
from dehyst.errors import ParameterError, SimulationError
from dehyst_robot.arm import Reference, Robot
from dehyst_robot.arm import kit as arm_kit
from dehyst_robot.control import FLAGS
from dehyst_robot.experiments._calibration import OBSERVER_RATIO, SPACING, nominal_characteristic
from dehyst_robot.experiments._equipment import Equipment, equip
from dehyst_robot.experiments._policy import POLICY
from dehyst_robot.experiments._trials import trial_arm, trial_switches

QUIET = np.radians(POLICY.quiet_deg)
LOWEST, HIGHEST = 6.0, 80.0  # poles that are searched [1/s]
NEAR = 1.02  # ratio of a pole that has the margins to one that has not
ROUGHLY, SLOWEST = 1.1, 2.0  # the same ratio of `steady_pole`, and where its search ends [1/s]
SWING = np.radians(POLICY.swing_deg)
MOVE_S, HOLD_S, JUDGED_S = (
    1.0,
    4.0,
    1.5,
)  # of a move, of the hold behind it, and of its end, in which nothing may ring


def at_pole(equipment: Equipment, pole: float, joints: Collection[int] | None = None) -> Equipment:
    """Return the same equipment with the position loops of some joints (None: all) at another pole, and observers that
    are fast enough for it."""
    controllers = dict(equipment.controllers)
    for n, controller in equipment.controllers.items():
        if joints is None or n in joints:
            observer_pole = max(controller.observer_pole, OBSERVER_RATIO * pole)
            controllers[n] = replace(controller, pole=pole, observer_pole=observer_pole)
    return replace(equipment, controllers=controllers)


def highest_pole(
    robot: Robot,
    equipment: Equipment,
    joints: tuple[int, ...],
    compensator: str = "off",
    *,
    moving: tuple[int, ...] | None = None,
) -> float:
    r"""Return the largest pole of position loops that has both margins, by bisection to 2 %. [1/s]

    All gains of the loop are powers of the pole :math:`\lambda`: :math:`3 \lambda M, 3 \lambda^2 M, \lambda^3 M`; the
    observer follows. The joints move to half their range on either side and hold there, twice: once with all three
    gains doubled (the controllers are told twice the inertia M), once with commands that come 5 ms later than they do.
    The pole has the margins if they stand still at the end of each hold.

    Parameters
    ----------
    robot
        Its delays, valves, tendons and tolerances are those of the loop.
    equipment
        Of `equip`: what the trials get.
    joints
        Whose pole it is: one, or those of an arm that couple.
    compensator
        "off", or the name under which the compensators of `equipment` are switched on, learning included.
    moving
        With these, which are held by the gains that they have; the others are locked. None: `joints` alone.

    Raises
    ------
    ParameterError
        If a joint has no controller in `equipment`, or not even a pole of 6 1/s has the margins.

    Examples
    --------
    A joint that only its data sheets describe; 10 ms of transport delay cost more than half of the gain:

    >>> from dehyst_robot.arm import load_robot
    >>> from dehyst_robot.experiments import nominal_characteristic
    >>> from dehyst_robot.experiments import equip
    >>> kind = load_robot(conditions="kind")
    >>> late = kind.with_changes({"simulation.command_delay_s": 0.01})
    >>> nominal = {1: nominal_characteristic(late, 1)}
    >>> fast = highest_pole(kind, equip(kind, nominal, {}), (1,))
    >>> highest_pole(late, equip(late, nominal, {}), (1,)) < 0.5 * fast
    True
    """
    for number in joints:
        if number not in equipment.controllers:
            raise ParameterError(
                f"joint {number} has no controller in the equipment, only {sorted(equipment.controllers)}: there is no "
                f"loop whose gains could be raised. Pass equip(robot, {{{number}: calibrate(robot, {number})}}, {{}}).",
                joint=number,
            )
    low, high = LOWEST, HIGHEST
    if not has_margins(robot, at_pole(equipment, low, joints), joints, compensator, moving=moving):
        raise ParameterError(
            f"joint {arm_kit.numbers_text(joints)}: a pole of {low:g} 1/s oscillates already with "
            f"{POLICY.gain_margin:g} times the gain or a delay of {1e3 * POLICY.delay_margin_s:g} ms more: no position "
            f"loop of this kind holds. Make delays smaller, or lower controller.pressure_gain_1_s.",
            joints=joints,
        )
    # Bisection by the ratio, as a pole is a scale and no offset.
    while high / low > NEAR:
        middle = math.sqrt(low * high)
        if has_margins(
            robot, at_pole(equipment, middle, joints), joints, compensator, moving=moving
        ):
            low = middle
        else:
            high = middle
    return low


def steady_pole(robot: Robot, poles: Mapping[int, float] | None = None) -> float:
    """Return the pole that no position loop may pass for all of them together to be stable with both margins. [1/s]

    All joints move at once, as in `highest_pole`, with the gains that data sheets and the robot's file give them. Small
    swings, of valves that hunt, are no matter here. Searched to 10 %, from 2 1/s on.

    Parameters
    ----------
    robot
        From `load_robot`.
    poles
        Joint number -> what its loop is asked for; missing: that of the file.

    Returns
    -------
    pole : float
        Infinite if the poles have the margins as they are, 0 if not even 2 1/s has them.

    Examples
    --------
    >>> from dehyst_robot.arm import load_robot
    >>> steady_pole(load_robot(conditions="kind"))
    inf
    """
    joints = robot.pneumatic
    characteristics = {n: nominal_characteristic(robot, n) for n in joints}
    asked = {n: robot.joint(n).pole or robot.controller.pole for n in joints} | dict(poles or {})

    def holds(most: float) -> bool:
        changes = {f"joint.{n}.pole_1_s": min(pole, most) for n, pole in asked.items()}
        slower = robot.with_changes(changes)
        kit = equip(slower, characteristics, {})
        return has_margins(slower, kit, joints, moving=tuple(robot.joints), quiet=SWING)

    if not joints or holds(math.inf):
        return math.inf
    # Bisection by the ratio, as a pole is a scale and no offset.
    low, high = SLOWEST, max(asked.values())
    if not holds(low):
        return 0.0
    while high / low > ROUGHLY:
        middle = math.sqrt(low * high)
        if holds(middle):
            low = middle
        else:
            high = middle
    return low


def has_margins(
    robot: Robot,
    equipment: Equipment,
    joints: tuple[int, ...],
    compensator: str = "off",
    *,
    moving: tuple[int, ...] | None = None,
    quiet: float = QUIET,
) -> bool:
    """Whether loops, as their controllers are, stand still with doubled gains, and with 5 ms more delay."""
    moving = moving or joints
    controllers = dict(equipment.controllers)
    for n in joints:
        # All gains grow with the inertia that a controller reckons with.
        controllers[n] = replace(
            controllers[n], inertia=POLICY.gain_margin * controllers[n].inertia
        )
    tighter = replace(equipment, controllers=controllers)
    if not _quiet(robot, tighter, joints, compensator, moving, quiet):
        return False
    delay = robot.simulation.command_delay + POLICY.delay_margin_s
    later = robot.with_changes({"simulation.command_delay_s": delay})
    return _quiet(later, equipment, joints, compensator, moving, quiet)


def _quiet(
    robot: Robot,
    equipment: Equipment,
    joints: tuple[int, ...],
    compensator: str,
    moving: tuple[int, ...],
    quiet: float,
) -> bool:
    """Whether the joints stand still at the end of two holds."""
    arm = trial_arm(robot, equipment, "slow", moving)
    reach = np.zeros(len(moving))
    for k, number in enumerate(moving):
        if number in joints:
            reach[k] = 0.5 * robot.joint(number).range
    motion = _there_and_back(reach)
    switches = trial_switches(robot, moving, "slow", compensator, equipment.adaptations)
    load = arm.feedforward(*motion)
    mean = robot.controller.mean_pressure
    try:
        log = arm.run(Reference.motion(SPACING, motion, load, mean, switches), every_s=0.002)
    except SimulationError:
        # A joint left its range.
        return False
    if (log.flags & FLAGS["failed"]).any():
        return False
    columns = [moving.index(number) for number in joints]
    # Only the end of a hold: the beginning may still settle.
    for end in (MOVE_S + HOLD_S, 2 * (MOVE_S + HOLD_S)):
        judged = (log.time >= end - JUDGED_S) & (log.time < end)
        if not _rings(log.angle[judged][:, columns]) < quiet:
            return False
    return True


def _rings(hold: Array) -> float:
    """Largest rms of joints (T, n) about a parabola: creep and what is left of the move are no oscillation."""
    t = np.vander(np.linspace(-1.0, 1.0, len(hold)), 3)
    return float(np.std(hold - t @ np.linalg.lstsq(t, hold, rcond=None)[0], axis=0).max())


def _there_and_back(reach: Array) -> tuple[Array, Array, Array]:
    """Angle, velocity and acceleration, each (K, n), to +reach (n,) and to -reach, with a hold after each."""
    t = SPACING * np.arange(round(2 * (MOVE_S + HOLD_S) / SPACING) + 1)
    q, v, a = np.zeros((3, t.size))
    for begin, way in ((0.0, 1.0), (MOVE_S + HOLD_S, -2.0)):
        u = np.clip((t - begin) / MOVE_S, 0.0, 1.0)
        q += way * u**3 * (10 - 15 * u + 6 * u**2)
        v += way * 30 * u**2 * (1 - u) ** 2 / MOVE_S
        a += way * 60 * u * (1 - u) * (1 - 2 * u) / MOVE_S**2
    return q[:, None] * reach, v[:, None] * reach, a[:, None] * reach
