"""The highest stable gains of a joint's position loop, found by one procedure with and without compensator."""

from __future__ import annotations

from dataclasses import replace
from math import sqrt

import numpy as np

from dehyst.arrays import Array
from dehyst.control import FLAGS, SWITCHES
from dehyst.errors import ParameterError, SimulationError
from dehyst.robot.arm.arm import Reference
from dehyst.robot.arm.parameters import Robot
from dehyst.robot.experiments.calibration import OBSERVER_RATIO, SPACING
from dehyst.robot.experiments.equipment import Equipment
from dehyst.robot.experiments.trials import trial_arm

GAIN = 2.0  # margin: the loop's gain may be this much higher, 6 dB
DELAY_S = 0.005  # margin: a command may come this much later
QUIET = np.radians(0.01)  # rms about its drift of an angle that is held, four ticks of the encoder: more is oscillation
LOWEST, HIGHEST = 6.0, 80.0  # poles that are searched [1/s]
NEAR = 1.02  # ratio of a pole that has the margins to one that has not
MOVE_S, HOLD_S, JUDGED_S = 1.0, 4.0, 1.5  # of a move, of the hold behind it, and of its end, in which nothing may ring


def at_pole(equipment: Equipment, pole: float) -> Equipment:
    """Return the same equipment with all position loops at another pole, and observers that are fast enough for it."""
    told = {
        n: replace(one, pole=pole, observer_pole=max(one.observer_pole, OBSERVER_RATIO * pole))
        for n, one in equipment.controllers.items()
    }
    return replace(equipment, controllers=told)


def highest_pole(robot: Robot, equipment: Equipment, number: int, compensator: str = "off") -> float:
    r"""Return the largest pole of a joint's position loop that has both margins, by bisection to 2 %. [1/s]

    All gains of the loop are powers of the pole :math:`\lambda`: :math:`3 \lambda M, 3 \lambda^2 M, \lambda^3 M`; the
    observer follows. The joint alone moves to half its range on either side and holds there, twice: once with all three
    gains doubled (the controller is told twice the inertia M), once with commands that come 5 ms later than they do.
    It has the margins if it stands still at the end of each hold.

    Parameters
    ----------
    robot
        Its delays, valves, tendons and tolerances are those of the loop.
    equipment
        Of `equip`: what the trials get.
    number
        Of the joint.
    compensator
        "off", or the name under which the compensators of `equipment` are switched on, learning included.

    Raises
    ------
    ParameterError
        If the joint has no controller in `equipment`, or not even a pole of 6 1/s has the margins.

    Examples
    --------
    A joint that only its data sheets describe; 10 ms of transport delay cost more than half of the gain:

    >>> from dehyst.robot.arm import load_robot
    >>> from dehyst.robot.experiments.calibration import nominal_characteristic
    >>> from dehyst.robot.experiments.equipment import equip
    >>> late = load_robot(changes={"simulation.command_delay_s": 0.01})
    >>> told = {1: nominal_characteristic(late, 1)}
    >>> kind, slow = (highest_pole(one, equip(one, told, {}), 1) for one in (load_robot(), late))
    >>> bool(slow < 0.5 * kind)
    True
    """
    if number not in equipment.controllers:
        raise ParameterError(
            f"joint {number} has no controller in the equipment, only {sorted(equipment.controllers)}: there is no "
            f"loop whose gains could be raised. Pass equip(robot, {{{number}: calibrate(robot, {number})}}, {{}}).",
            joint=number,
        )
    low, high = LOWEST, HIGHEST
    if not has_margins(robot, at_pole(equipment, low), number, compensator):
        raise ParameterError(
            f"joint {number} oscillates already at a pole of {low:g} 1/s with {GAIN:g} times the gain or a delay of "
            f"{1e3 * DELAY_S:g} ms more: no position loop of this kind holds it. Make delays smaller, or lower "
            f"controller.pressure_gain_1_s.",
            joint=number,
        )
    while high / low > NEAR:
        middle = sqrt(low * high)
        if has_margins(robot, at_pole(equipment, middle), number, compensator):
            low = middle
        else:
            high = middle
    return low


def has_margins(robot: Robot, equipment: Equipment, number: int, compensator: str = "off") -> bool:
    """Whether a joint's loop, as its controller is, stands still with doubled gain, and with 5 ms more delay."""
    own = equipment.controllers[number]
    tighter = replace(equipment, controllers={number: replace(own, inertia=GAIN * own.inertia)})
    later = robot.with_changes({"simulation.command_delay_s": robot.simulation.command_delay + DELAY_S})
    return all(_quiet(r, e, number, compensator) for r, e in ((robot, tighter), (later, equipment)))


def _quiet(robot: Robot, equipment: Equipment, number: int, compensator: str) -> bool:
    arm = trial_arm(robot, equipment, "slow", (number,))
    motion = _there_and_back(0.5 * robot.joint(number).range)
    switches = SWITCHES["position"] | SWITCHES["integrator"]
    if compensator != "off":
        switches |= SWITCHES["compensator"] | (SWITCHES["adapt"] if number in equipment.adaptations else 0)
    load = arm.feedforward(*motion)
    try:
        log = arm.run(Reference.motion(SPACING, motion, load, robot.controller.mean_pressure, switches), every_s=0.002)
    except SimulationError:  # beyond its range
        return False
    ends = [(k + 1) * (MOVE_S + HOLD_S) for k in range(2)]
    holds = [log.angle[(log.time >= end - JUDGED_S) & (log.time < end), 0] for end in ends]
    return not (log.flags & FLAGS["failed"]).any() and all(_rings(hold) < QUIET for hold in holds)


def _rings(hold: Array) -> float:
    """Rms about a parabola: creep and what is left of the move are no oscillation."""
    t = np.vander(np.linspace(-1.0, 1.0, hold.size), 3)
    return float(np.std(hold - t @ np.linalg.lstsq(t, hold, rcond=None)[0]))


def _there_and_back(reach: float) -> tuple[Array, Array, Array]:
    """Angle, velocity and acceleration, each (K, 1), to +reach and to -reach, with a hold after each."""
    t = SPACING * np.arange(round(2 * (MOVE_S + HOLD_S) / SPACING) + 1)
    q, v, a = np.zeros((3, t.size))
    for begin, way in ((0.0, reach), (MOVE_S + HOLD_S, -2 * reach)):
        u = np.clip((t - begin) / MOVE_S, 0.0, 1.0)
        q += way * u**3 * (10 - 15 * u + 6 * u**2)
        v += way * 30 * u**2 * (1 - u) ** 2 / MOVE_S
        a += way * 60 * u * (1 - u) * (1 - 2 * u) / MOVE_S**2
    return q[:, None], v[:, None], a[:, None]
