"""What a controller of the literature costs: numbers that are chosen, runs that choosing takes, time of a period."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import cast

import numpy as np

from dehyst.arrays import rank
from dehyst.errors import ParameterError, SimulationError
from dehyst_robot.arm import Robot
from dehyst_robot.control import SWITCHES, JointController, JointReference, Law
from dehyst_robot.control._reviewed import VoMinhController
from dehyst_robot.experiments import Equipment
from dehyst_robot.experiments._calibration import OBSERVER_RATIO
from dehyst_robot.experiments._equipment import under_controller
from studies.side_by_side import Joint, errors

FACTORS = (1.0, 2.0, 4.0, 6.0, 8.0)
OWN = {"paper": "paper", "vo-minh": "maxwell-slip", "sliding-mode": "", "one-valve": "", "pid": ""}
"""Controller -> the compensator that its publication has; "": none."""
TICKS = 20_000
REPEATS = 9


@dataclass(frozen=True)
class Rung:
    """A run of a ladder: what its one gain was multiplied by, and the errors; infinite where the controller failed."""

    factor: float
    rms_deg: float
    max_deg: float


def with_factor(
    robot: Robot, equipment: Equipment, controller: str, factor: float
) -> tuple[Robot, Equipment]:
    """Return robot and equipment under a controller whose one tuning gain is multiplied.

    It is the pole of the error where the law has one (of the sliding mode the surface's and the observer's at once),
    and both gains of Vo-Minh's PI. 1 is what `dehyst_robot.control._reviewed` derives.

    Raises
    ------
    ParameterError
        If the factor is not positive.
    """
    if not (np.isfinite(factor) and factor > 0):
        raise ParameterError(
            f"factor = {factor} of a gain must be a positive number; 1 is the derived one."
        )
    if controller != VoMinhController.name:
        equipment = replace(
            equipment,
            controllers={
                n: replace(
                    one,
                    pole=factor * one.pole,
                    observer_pole=max(one.observer_pole, OBSERVER_RATIO * factor * one.pole),
                )
                for n, one in equipment.controllers.items()
            },
        )
        return under_controller(robot, equipment, controller)
    robot, equipment = under_controller(robot, equipment, controller)
    laws = {
        n: VoMinhController(factor * law.proportional, factor * law.integral)
        for n, law in equipment.laws.items()
        if isinstance(law, VoMinhController)
    }
    return robot, replace(equipment, laws=laws)


def ladder(
    joint: Joint, controller: str, compensator: str, factors: Sequence[float] = FACTORS
) -> tuple[Rung, ...]:
    """Run the slow trial once for each factor of a controller's gain."""
    return tuple(_rung(joint, controller, compensator, factor) for factor in factors)


def best(rungs: Sequence[Rung]) -> float:
    """Return the factor with the smallest rms error.

    Examples
    --------
    >>> best([Rung(1.0, 0.3, 0.5), Rung(2.0, 0.2, 0.9)])
    2.0
    """
    return min(rungs, key=lambda rung: rank(rung.rms_deg)).factor


def _rung(joint: Joint, controller: str, compensator: str, factor: float) -> Rung:
    robot, equipment = with_factor(joint.robot, joint.equipped(compensator), controller, factor)
    try:
        found = errors(joint, equipment, "slow", bool(compensator), robot)
    except SimulationError:
        return Rung(factor, float("inf"), float("inf"))
    return Rung(factor, found["rms_deg"], found["max_deg"])


def period_cost(
    joint: Joint, controller: str, compensator: str, ticks: int = TICKS, repeats: int = REPEATS
) -> float:
    """Return the time of one control period in C: sensors, law, compensator, both pressure loops. [ns]

    The median of repeats along a desired sine with an encoder's noise: processor time of one thread.
    """
    _, equipment = under_controller(joint.robot, joint.equipped(compensator), controller)
    number = joint.number
    told = equipment.controllers[number]
    one = JointController(
        told, equipment.compensators.get(number), law=cast(Law | None, equipment.laws.get(number))
    )
    t = told.period * np.arange(ticks)
    q = 0.3 * np.sin(t)
    noise = told.angle_step * np.random.default_rng(0).integers(-1, 2, ticks)
    mean = joint.robot.controller.mean_pressure
    zero = np.zeros(ticks)
    names = [entry.name for entry in fields(JointReference)]
    columns = {
        "angle": q,
        "velocity": 0.3 * np.cos(t),
        "acceleration": -q,
        "mean_pressure": zero + mean,
    }
    reference = np.stack([columns.get(name, zero) for name in names], axis=1)
    on = (
        SWITCHES["position"]
        | SWITCHES["integrator"]
        | (SWITCHES["compensator"] if compensator else 0)
    )
    switches = np.full(ticks, on)
    pressure = mean + 1e4 * np.sin(3 * t)
    spent = []
    for _ in range(repeats):
        one.reset(0.0, mean, mean)
        begun = time.thread_time()
        one.run(q + noise, pressure, 2 * mean - pressure, reference, switches)
        spent.append(time.thread_time() - begun)
    return 1e9 * float(np.median(spent)) / ticks
