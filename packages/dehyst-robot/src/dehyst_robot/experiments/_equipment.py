"""Equips joint controllers: characteristic, compensator, and controllers of the literature in the paper's place."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

import dehyst_robot._native as _native
from dehyst.arrays import Array
from dehyst.errors import ParameterError
from dehyst.models import DirectInverse, HysteresisModel
from dehyst_robot.arm import Arm, MechanismFactory, Robot
from dehyst_robot.control import (
    Adaptation,
    Compensator,
    Controller,
    JointControllerParameters,
    Law,
    OneValveController,
)
from dehyst_robot.control import kit as control_kit
from dehyst_robot.experiments._calibration import controller_parameters, home
from dehyst_robot.experiments._policy import POLICY
from dehyst_robot.experiments._recipes import Recipe
from dehyst_robot.experiments._results import BAR, Characteristic, JointIdentification


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
        Joint number -> a controller of the literature instead of the paper's, see `dehyst_robot.control._reviewed`, or
        a `dehyst_robot.Controller` of one's own.
    known
        The robot whose weight and inertia are fed forward, where the trial's has changed since; None: the trial's own.
    missed
        Joint number -> largest torque that its compensator missed on loops on which nothing touched the joint. [Nm]

    Examples
    --------
    Made by `equip`, changed by `dataclasses.replace`; here 20 Nm pull on joint 1 that no controller knows of:

    >>> from dataclasses import replace
    >>> from dehyst_robot.experiments import equip
    >>> from dehyst_robot.arm import load_robot
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
    missed: Mapping[int, float] = field(default_factory=dict)


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
    >>> from dehyst_robot.experiments import nominal_characteristic
    >>> from dehyst_robot.arm import load_robot
    >>> robot = load_robot()
    >>> sorted(equip(robot, {1: nominal_characteristic(robot, 1)}, {}).controllers)
    [1]
    """
    controllers = {}
    for n, characteristic in characteristics.items():
        controllers[n] = controller_parameters(robot, n, characteristic)
    compensators, adaptations, missed = {}, {}, {}
    for n, identified in identifications.items():
        if not identified.accepted:
            continue
        compensators[n], missed[n] = identified.compensator, identified.missed
        if identified.direct is None:
            shear = identified.shear * BAR
            controllers[n] = replace(controllers[n], shear=shear, compensator_unit=BAR)
        elif adaptive:
            adaptations[n] = adaptation_of(identified.missed)
    return Equipment(
        controllers,
        characteristics,
        compensators,
        mechanisms=mechanisms,
        seed=seed,
        adaptations=adaptations,
        missed=missed,
    )


def adaptation_of(missed: float) -> Adaptation:
    """Return how a direct inverse learns that missed up to so much where nothing touched the joint. [Nm]

    Errors up to that are the model's own, and no contact. Of 42 trials that nothing touched 18 were flagged at the
    least limit, 12, 6 and 2 at 0.5, 0.75 and 1 times what the model missed.

    Examples
    --------
    >>> adaptation_of(5.0).most_error, adaptation_of(1.3).most_error, adaptation_of(0.1).most_error
    (2.0, 1.3, 0.5)
    """
    usual = Adaptation()
    return replace(usual, most_error=max(usual.most_error, min(missed, POLICY.most_own_error)))


# Of a polynomial in the controller: DEHYST_DEGREE - 1 of packages/dehyst/core/dehyst.h.
MOST_DEGREE = 7


def backbones_of(
    robot: Robot, calibrated: Mapping[int, Characteristic], chosen: Recipe
) -> dict[int, Characteristic]:
    """Return joint number -> characteristic that a recipe's compensator stands on."""
    backbones = dict(calibrated)
    if chosen.local:
        for n, characteristic in calibrated.items():
            backbones[n] = local_characteristic(robot, characteristic)
    return backbones


def local_characteristic(robot: Robot, characteristic: Characteristic) -> Characteristic:
    """Return the characteristic bent to the polynomial dp(q) through the loop at the mean pressure without load.

    It reaches that mean pressure's loop exactly, and swallows part of its hysteresis: the polynomial bends towards the
    loop's tips. Only C is changed. If there is no sweep at the mean pressure, it is the loop of the nearest one.
    """
    # Of all sweeps the one that is nearest to what the joint does later.
    q, dp, mean, torque = _unloaded_sweep(characteristic, robot.controller.mean_pressure).T
    degree = robot.calibration.degree
    value = np.polynomial.polynomial.polyval
    fitted = np.polynomial.polynomial.polyfit(q, dp, degree)
    c = torque - value(q, characteristic.a) * mean - value(q, characteristic.b) * value(q, fitted)
    return replace(
        characteristic, c=np.polynomial.polynomial.polyfit(q, c, min(degree + 2, MOST_DEGREE))
    )


def _unloaded_sweep(characteristic: Characteristic, mean: float) -> Array:
    """The sweep nearest to the mean pressure and, among those, with the smallest torque."""

    def distance(sweep: Array) -> tuple[int, float]:
        # Pressures within a tenth of a bar are the same.
        steps = round(abs(float(sweep[:, 2].mean()) - mean) / (0.1 * BAR))
        return steps, float(np.abs(sweep[:, 3]).mean())

    return min(characteristic.sweeps, key=distance)


SPARE = 1e3  # of the supply over the largest pressure that is asked for, [Pa]


def joint_law(robot: Robot, equipment: Equipment, name: str, number: int) -> Law | None:
    """Return the record of a controller for a joint, from what its calibration found; None for the paper's."""
    residual = equipment.characteristics[number].residual
    bounds = {}
    # A characteristic of data sheets has no residual, and its law the bound that it comes with.
    if residual > 0:
        bounds["disturbance"] = POLICY.unknown_torque * residual
    mean = robot.controller.mean_pressure
    return control_kit.derived_law(name, equipment.controllers[number], mean, **bounds)


def under_controller(robot: Robot, equipment: Equipment, name: str) -> tuple[Robot, Equipment]:
    """Return robot and equipment of a trial under another controller: every pneumatic joint gets the law of that name.

    With one valve a joint its supply is set by `resting_supply`, so that all controllers run at the same mean pressure
    and no muscle beyond its rating; nothing else of the robot changes, and of the paper's nothing at all.

    Examples
    --------
    >>> from dehyst_robot.experiments import equip
    >>> from dehyst_robot.experiments import nominal_characteristic
    >>> from dehyst_robot.arm import load_robot
    >>> robot = load_robot()
    >>> kit = equip(robot, {1: nominal_characteristic(robot, 1)}, {})
    >>> same, changed = under_controller(robot, kit, "sliding-mode")
    >>> changed.laws[1].surface, same is robot
    (6.0, True)
    """
    laws = {}
    for number in equipment.controllers:
        law = joint_law(robot, equipment, name, number)
        if law is not None:
            laws[number] = law
    equipment = replace(equipment, laws=laws)
    if name != OneValveController.name:
        return robot, equipment
    # All joints share a supply: the one that needs most decides.
    supply = max(resting_supply(robot, number) for number in equipment.controllers)
    highest = min(robot.controller.pressure_high, supply - SPARE)
    lower = {"air.supply_bar": supply / BAR, "controller.pressure_high_bar": highest / BAR}
    # The controllers reckon with the lower supply, too.
    absolute = supply + robot.air.ambient
    controllers = {}
    for number, controller in equipment.controllers.items():
        pneumatics = replace(controller.pneumatics, supply=absolute)
        controllers[number] = replace(controller, pressure_high=highest, pneumatics=pneumatics)
    return robot.with_changes(lower), replace(equipment, controllers=controllers)


def resting_supply(robot: Robot, number: int) -> float:
    r"""Return the supply [Pa, gauge] at which one valve leaves both muscles at the robot's mean pressure.

    Through a spool in the middle as much leaks in as out, whatever the leak: :math:`p_S \psi(p/p_S) = p\,\psi(p_A/p)`
    at absolute pressures, :math:`\psi` the flow function of ISO 6358. Nothing else holds the mean pressure of a joint
    with one valve; at the supply of two valves it would rest where the muscles are stiff and near their rating.

    Examples
    --------
    >>> from dehyst_robot.arm import load_robot
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
        low, high = (
            (middle, high)
            if middle * _native.flow_function(mean / middle, ratio) < out
            else (low, middle)
        )
    return high - ambient


def refuse_learning(controller: str, compensator: str, passes: int) -> None:
    """Refuse iterative learning under a controller of the literature."""
    if passes and controller != control_kit.PAPER:
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
    >>> from dehyst_robot.control.kit import CONTROLLERS
    >>> {name: tuned_numbers(name) for name in CONTROLLERS}
    {'paper': 1, 'vo-minh': 2, 'sliding-mode': 4, 'one-valve': 3, 'pid': 4}
    """
    return control_kit.TUNED[controller]
