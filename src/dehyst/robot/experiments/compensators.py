"""Equips joint controllers with an identified characteristic and a compensator."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from dehyst.arrays import Array
from dehyst.control import Adaptation
from dehyst.robot.arm.mechanisms import MechanismFactory
from dehyst.robot.arm.parameters import Robot
from dehyst.robot.experiments.loops_run import BAR
from dehyst.robot.experiments.nominal import controller_parameters
from dehyst.robot.experiments.recipes import Recipe
from dehyst.robot.experiments.results import Characteristic, JointIdentification
from dehyst.robot.experiments.trials import Equipment


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
    >>> from dehyst.robot.experiments.nominal import nominal_characteristic
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
