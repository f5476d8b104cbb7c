"""The compensators that the experiment knows by name, and how they are put into the controllers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np
import numpy.typing as npt

from dehyst.errors import ParameterError
from dehyst.experiments.loops_run import BAR
from dehyst.experiments.nominal import controller_parameters
from dehyst.experiments.results import Characteristic, JointIdentification
from dehyst.experiments.trials import Equipment
from dehyst.models import HysteresisModel, PrandtlIshlinskii
from dehyst.plant.mechanisms import MechanismFactory
from dehyst.plant.parameters import Robot

Array = npt.NDArray[np.float64]

MOST_DEGREE = 7  # of a polynomial in the controller: DEHYST_DEGREE - 1 of core/dehyst.h


@dataclass(frozen=True)
class Recipe:
    """How a compensator is identified.

    Attributes
    ----------
    summary
        One line for ``--help`` and the report.
    changes
        Settings that differ from the robot's file.
    local
        The backbone is the polynomial through the loop at the mean pressure, not the calibrated A, B, C.
    """

    summary: str
    changes: Mapping[str, object]
    local: bool = False


RECIPES: Mapping[str, Recipe] = MappingProxyType(
    {
        "paper": Recipe("the paper's, on the calibrated characteristic A, B, C", {}),
        "literal": Recipe("the paper read literally, on a polynomial through the loop at 3 bar", {}, local=True),
        "scaled": Recipe("the paper's with k = 10 bar/rad instead of 1", {"compensator.shear_bar_rad": 10.0}),
    }
)
NAMES = tuple(RECIPES)


def recipe(name: str) -> Recipe:
    """Return the recipe of a compensator.

    Raises
    ------
    ParameterError
        If there is none of that name.
    """
    if name not in RECIPES:
        raise ParameterError(
            f"no compensator '{name}'. There are: {', '.join(NAMES)}; one of your own goes through Python: "
            f"run_trial(..., Equipment(own={{1: my_compensator}})).",
            name=name,
        )
    return RECIPES[name]


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


def pruned_inverse(found: JointIdentification) -> HysteresisModel:
    """The inverse of a joint's model without operators of zero weight: the same output, in a tenth of the time."""
    return pruned_model(found).inverse()


def pruned_model(found: JointIdentification) -> HysteresisModel:
    """A joint's model without operators of zero weight."""
    model = found.fit.model
    return model.pruned() if isinstance(model, PrandtlIshlinskii) else model


def equip(
    robot: Robot,
    characteristics: Mapping[int, Characteristic],
    identifications: Mapping[int, JointIdentification],
    seed: int = 0,
    mechanisms: MechanismFactory | None = None,
) -> Equipment:
    """Put the calibrated characteristics and the accepted inverse models into the joint controllers.

    Parameters
    ----------
    robot
        Whose [controller] table the controllers follow.
    characteristics
        Joint number -> what `calibrate` found.
    identifications
        Joint number -> what `identify_joint` found; a model that is not accepted is left out.
    seed
        Of noise and tolerances in the trials.
    mechanisms
        Makes hysteresis mechanisms of one's own, instead of the robot's.

    Returns
    -------
    equipment : Equipment
        What `run_trial` takes.

    Examples
    --------
    >>> from dehyst.experiments.nominal import nominal_characteristic
    >>> from dehyst.plant.parameters import load_robot
    >>> robot = load_robot()
    >>> sorted(equip(robot, {1: nominal_characteristic(robot, 1)}, {}).controllers)
    [1]
    """
    controllers = {n: controller_parameters(robot, n, found) for n, found in characteristics.items()}
    accepted = {n: found for n, found in identifications.items() if found.accepted}
    for n, found in accepted.items():
        controllers[n] = replace(controllers[n], shear=found.shear * BAR, compensator_unit=BAR)
    models = {n: pruned_inverse(found) for n, found in accepted.items()}
    return Equipment(controllers, characteristics, models, mechanisms=mechanisms, seed=seed)
