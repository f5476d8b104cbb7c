"""How calibrated characteristics and identified compensators are put into the controllers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from dehyst.control import Adaptation
from dehyst.experiments.loops_run import BAR
from dehyst.experiments.nominal import controller_parameters
from dehyst.experiments.results import Characteristic, JointIdentification
from dehyst.experiments.trials import Equipment
from dehyst.plant.mechanisms import MechanismFactory
from dehyst.plant.parameters import Robot


def adaptation_of(found: JointIdentification) -> Adaptation:
    """How a direct inverse learns while it runs."""
    return Adaptation()


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
    >>> from dehyst.experiments.nominal import nominal_characteristic
    >>> from dehyst.plant.parameters import load_robot
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
        adaptations={n: adaptation_of(found) for n, found in accepted.items() if adaptive and found.direct is not None},
    )
