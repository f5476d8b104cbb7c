"""Equips joint controllers: characteristic, compensator, and controllers of the literature in the paper's place."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

import dehyst.robot._native as _native
from dehyst.arrays import Array
from dehyst.errors import ParameterError
from dehyst.models import DirectInverse, HysteresisModel
from dehyst.robot.arm.arm import Arm
from dehyst.robot.arm.mechanisms import MechanismFactory
from dehyst.robot.arm.parameters import Robot
from dehyst.robot.control import Adaptation, Compensator, JointControllerParameters
from dehyst.robot.control.controller import Controller
from dehyst.robot.control.reviewed import PAPER, TUNED, Law, OneValveController, derived_law
from dehyst.robot.experiments.calibration import BAR, controller_parameters, home
from dehyst.robot.experiments.recipes import Recipe
from dehyst.robot.experiments.results import Characteristic, JointIdentification


@dataclass(frozen=True, eq=False)
class Equipment:
    """What a trial needs besides the robot: controllers, compensators, plants.

    Attributes
    ----------
    controllers
        Joint number -> parameters of its controller, compensator's shear and unit included.
    characteristics
        Joint number -> calibrated backbone, for the homing.
    compensators
        Joint number -> what runs in the controller: an inverse model q_d -> x, or a direct inverse q_d -> torque.
    own
        Joint number -> a compensator of one's own, evaluated along the desired path before the run.
    mechanisms
        Makes hysteresis mechanisms of one's own, instead of the robot's.
    loads
        Joint number -> constant torque that pulls on it, unknown to the controller. [Nm]
    history
        What the arm went through before: `home`, or something that leaves it with an unknown memory.
    seed
        Of noise and tolerances.
    adaptations
        Joint number -> how the direct inverse of that joint learns while it runs.
    learned
        Joint number -> torque along one cycle of the path, (K,) at equal spacing from its start to its end, added while
        the compensator is on. [Nm]
    laws
        Joint number -> a controller of the literature instead of the paper's, see `dehyst.robot.control.reviewed`, or a
        `dehyst.Controller` of one's own.
    known
        The robot whose weight and inertia are fed forward, where the trial's has changed since; None: the trial's own.

    Examples
    --------
    Made by `equip`, changed by `dataclasses.replace`; here 20 Nm pull on joint 1 that no controller knows of:

    >>> from dataclasses import replace
    >>> from dehyst.robot.experiments.equipment import equip
    >>> from dehyst.robot.arm.parameters import load_robot
    >>> plain = equip(load_robot(), {}, {})
    >>> replace(plain, loads={1: -20.0}).loads
    {1: -20.0}
    """

    controllers: Mapping[int, JointControllerParameters]
    characteristics: Mapping[int, Characteristic]
    compensators: Mapping[int, HysteresisModel | DirectInverse] = field(default_factory=dict)
    own: Mapping[int, Compensator] = field(default_factory=dict)
    mechanisms: MechanismFactory | None = None
    loads: Mapping[int, float] = field(default_factory=dict)
    history: Callable[[Arm, Mapping[int, Characteristic]], object] = home
    seed: int = 0
    adaptations: Mapping[int, Adaptation] = field(default_factory=dict)
    learned: Mapping[int, Array] = field(default_factory=dict)
    laws: Mapping[int, Law | Controller] = field(default_factory=dict)
    known: Robot | None = None


def equip(
    robot: Robot,
    characteristics: Mapping[int, Characteristic],
    identifications: Mapping[int, JointIdentification],
    seed: int = 0,
    mechanisms: MechanismFactory | None = None,
    *,
    adaptive: bool = False,
) -> Equipment:
    """Put the calibrated characteristics and the accepted compensators into the joint controllers.

    Parameters
    ----------
    robot
        Whose [controller] table the controllers follow.
    characteristics
        Joint number -> what `calibrate` found.
    identifications
        Joint number -> what `identify_joint` found; what is not accepted is left out.
    seed
        Of noise and tolerances in the trials.
    mechanisms
        Makes hysteresis mechanisms of one's own, instead of the robot's.
    adaptive
        Whether direct inverses learn while they run.

    Returns
    -------
    equipment : Equipment
        What `run_trial` takes.

    Examples
    --------
    >>> from dehyst.robot.experiments.calibration import nominal_characteristic
    >>> from dehyst.robot.arm.parameters import load_robot
    >>> robot = load_robot()
    >>> sorted(equip(robot, {1: nominal_characteristic(robot, 1)}, {}).controllers)
    [1]
    """
    controllers = {n: controller_parameters(robot, n, found) for n, found in characteristics.items()}
    accepted = {n: found for n, found in identifications.items() if found.accepted}
    for n, found in accepted.items():
        if found.direct is None:
            controllers[n] = replace(controllers[n], shear=found.shear * BAR, compensator_unit=BAR)
    return Equipment(
        controllers,
        characteristics,
        {n: found.compensator for n, found in accepted.items()},
        mechanisms=mechanisms,
        seed=seed,
        adaptations={n: Adaptation() for n, found in accepted.items() if adaptive and found.direct is not None},
    )


MOST_DEGREE = 7  # of a polynomial in the controller: DEHYST_DEGREE - 1 of core/dehyst.h


def backbones_of(robot: Robot, calibrated: Mapping[int, Characteristic], chosen: Recipe) -> dict[int, Characteristic]:
    """Return joint number -> characteristic that a recipe's compensator stands on."""
    return {n: local_characteristic(robot, one) if chosen.local else one for n, one in calibrated.items()}


def local_characteristic(robot: Robot, found: Characteristic) -> Characteristic:
    """Return the characteristic bent to the polynomial dp(q) through the loop at the mean pressure without load.

    It reaches that mean pressure's loop exactly, and swallows part of its hysteresis: the polynomial bends towards the
    loop's tips. Only C is changed. If there is no sweep at the mean pressure, it is the loop of the nearest one.
    """
    q, dp, mean, torque = _unloaded_sweep(found, robot.controller.mean_pressure).T
    degree = robot.calibration.degree
    value = np.polynomial.polynomial.polyval
    fitted = np.polynomial.polynomial.polyfit(q, dp, degree)
    c = torque - value(q, found.a) * mean - value(q, found.b) * value(q, fitted)
    return replace(found, c=np.polynomial.polynomial.polyfit(q, c, min(degree + 2, MOST_DEGREE)))


def _unloaded_sweep(found: Characteristic, mean: float) -> Array:
    """The sweep nearest to the mean pressure and, among those, with the smallest torque."""

    def distance(sweep: Array) -> tuple[int, float]:
        return round(abs(float(sweep[:, 2].mean()) - mean) / (0.1 * BAR)), float(np.abs(sweep[:, 3]).mean())

    return min(found.sweeps, key=distance)


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
    >>> from dehyst.robot.experiments.equipment import equip
    >>> from dehyst.robot.experiments.calibration import nominal_characteristic
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
    >>> from dehyst.robot.control.reviewed import CONTROLLERS
    >>> {name: tuned_numbers(name) for name in CONTROLLERS}
    {'paper': 1, 'vo-minh': 2, 'sliding-mode': 4, 'one-valve': 3, 'pid': 4}
    """
    return TUNED[controller]
