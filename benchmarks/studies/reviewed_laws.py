"""Controllers of the literature on a joint: the gain that is tuned, and the time of a control period."""

from __future__ import annotations

import time
from dataclasses import fields, replace
from typing import cast

import numpy as np

from dehyst.errors import ParameterError
from dehyst_robot.arm import Robot
from dehyst_robot.control import SWITCHES, JointController, JointReference, Law
from dehyst_robot.control._reviewed import VoMinhController
from dehyst_robot.experiments import Equipment
from dehyst_robot.experiments._calibration import OBSERVER_RATIO
from dehyst_robot.experiments._equipment import under_controller
from studies.joint_models import Joint

OWN = {"paper": "paper", "vo-minh": "maxwell-slip", "sliding-mode": "", "one-valve": "", "pid": ""}
"""Controller -> the compensator that its publication has; "": none."""
TICKS = 20_000
REPEATS = 9


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


def period_cost(
    joint: Joint, controller: str, compensator: str, ticks: int = TICKS, repeats: int = REPEATS
) -> float:
    """Return the time of one control period in C: sensors, law, compensator, both pressure loops. [ns]

    The median of repeats along a desired sine with an encoder's noise: processor time of one thread.
    """
    _, equipment = under_controller(joint.robot, joint.equipped(compensator), controller)
    number = joint.number
    parameters = equipment.controllers[number]
    one = JointController(
        parameters,
        equipment.compensators.get(number),
        law=cast(Law | None, equipment.laws.get(number)),
    )
    t = parameters.period * np.arange(ticks)
    q = 0.3 * np.sin(t)
    noise = parameters.angle_step * np.random.default_rng(0).integers(-1, 2, ticks)
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
    seconds = []
    for _ in range(repeats):
        one.reset(0.0, mean, mean)
        begun = time.thread_time()
        one.run(q + noise, pressure, 2 * mean - pressure, reference, switches)
        seconds.append(time.thread_time() - begun)
    return 1e9 * float(np.median(seconds)) / ticks
