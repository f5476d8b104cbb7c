"""Controllers of the literature in place of the paper's: same joint, path and compensator."""

from __future__ import annotations

from dataclasses import replace

import dehyst._native as _native
from dehyst.control.reviewed import PAPER, TUNED, Law, OneValveController, derived_law
from dehyst.errors import ParameterError
from dehyst.robot.arm.parameters import Robot
from dehyst.robot.experiments.trials import Equipment

BAR = 1e5
SPARE = 1e3  # of the supply over the largest pressure that is asked for, [Pa]
BOUND = 3.0  # the unknown torque is at most this many times the rms residual of the calibration sweeps


def joint_law(robot: Robot, equipment: Equipment, name: str, number: int) -> Law | None:
    """Return the record of a controller for a joint, from what its calibration found; None for the paper's."""
    residual = equipment.characteristics[number].residual
    told = {"disturbance": BOUND * residual} if residual > 0 else {}
    return derived_law(name, equipment.controllers[number], robot.controller.mean_pressure, **told)


def under_controller(robot: Robot, equipment: Equipment, name: str) -> tuple[Robot, Equipment]:
    """Return robot and equipment of a trial under another controller: every pneumatic joint gets the law of that name.

    With one valve a joint its supply is set by `resting_supply`, so that all controllers run at the same mean pressure
    and no muscle beyond its rating; nothing else of the robot changes, and of the paper's nothing at all.

    Examples
    --------
    >>> from dehyst.robot.experiments.compensators import equip
    >>> from dehyst.robot.experiments.nominal import nominal_characteristic
    >>> from dehyst.robot.arm.parameters import load_robot
    >>> robot = load_robot()
    >>> kit = equip(robot, {1: nominal_characteristic(robot, 1)}, {})
    >>> same, changed = under_controller(robot, kit, "sliding-mode")
    >>> changed.laws[1].surface, same is robot
    (6.0, True)
    """
    laws = {number: joint_law(robot, equipment, name, number) for number in equipment.controllers}
    equipment = replace(equipment, laws={number: law for number, law in laws.items() if law is not None})
    if name != OneValveController.name:
        return robot, equipment
    supply = max(resting_supply(robot, number) for number in equipment.controllers)
    highest = min(robot.controller.pressure_high, supply - SPARE)
    lower = {"air.supply_bar": supply / BAR, "controller.pressure_high_bar": highest / BAR}
    told = {
        number: replace(
            one, pressure_high=highest, pneumatics=replace(one.pneumatics, supply=supply + robot.air.ambient)
        )
        for number, one in equipment.controllers.items()
    }
    return robot.with_changes(lower), replace(equipment, controllers=told)


def resting_supply(robot: Robot, number: int) -> float:
    r"""Return the supply [Pa, gauge] at which one valve leaves both muscles at the robot's mean pressure.

    Through a spool in the middle as much leaks in as out, whatever the leak: :math:`p_S \psi(p/p_S) = p\,\psi(p_A/p)`
    at absolute pressures, :math:`\psi` the flow function of ISO 6358. Nothing else holds the mean pressure of a joint
    with one valve; at the supply of two valves it would rest where the muscles are stiff and near their rating.

    Examples
    --------
    >>> from dehyst.robot.arm.parameters import load_robot
    >>> round(resting_supply(load_robot(), 1) / 1e5, 2)
    4.29
    """
    ratio = robot.valve(robot.joint(number).valve).ratio
    ambient = robot.air.ambient
    mean = robot.controller.mean_pressure + ambient
    out = mean * _native.flow_function(ambient / mean, ratio)
    low, high = mean, 20 * mean  # the flow in grows with the supply
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if middle * _native.flow_function(mean / middle, ratio) < out else (low, middle)
    return high - ambient


def refuse_learning(controller: str, compensator: str, passes: int) -> None:
    """Refuse iterative learning under a controller of the literature."""
    if passes and controller != PAPER:
        raise ParameterError(
            f"the compensator '{compensator}' learns from what the paper's position law answered to an error, and "
            f"'{controller}' answers otherwise: it would learn something else than the missing torque. Leave "
            f"'{compensator}' out, or type --controller paper.",
            controller=controller,
        )


def tuned_numbers(controller: str) -> int:
    """Return how many numbers of a controller somebody has to choose, on a joint that is calibrated.

    Examples
    --------
    >>> from dehyst.control.reviewed import CONTROLLERS
    >>> {name: tuned_numbers(name) for name in CONTROLLERS}
    {'paper': 1, 'vo-minh': 2, 'sliding-mode': 4, 'one-valve': 3, 'pid': 4}
    """
    return TUNED[controller]
