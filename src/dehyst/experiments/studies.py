"""Studies on a joint alone: what happens at rest, and where compensation hurts."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import numpy.typing as npt

from dehyst.control import SWITCHES, InverseCompensator
from dehyst.experiments.path import ArmPath
from dehyst.experiments.quasistatic import home
from dehyst.experiments.results import TrialRun
from dehyst.experiments.scores import joint_figures
from dehyst.experiments.trials import Equipment, run_trial
from dehyst.plant.arm import Arm, Reference
from dehyst.plant.parameters import Robot

POSITION, INTEGRATOR, COMPENSATOR = (SWITCHES[name] for name in ("position", "integrator", "compensator"))

Array = npt.NDArray[np.float64]
Table = Mapping[str, Array | Sequence[str]]

SCALES = (0.0, 0.25, 0.5, 0.75, 1.0, 1.5)  # true hysteresis over the identified one
POLES = (4.0, 6.0, 8.0, 12.0, 16.0)  # lambda [1/s]
REST_ANGLE = np.radians(12.0)
REST_S = 60.0
STROKE_S = 2.0


@dataclass(frozen=True, eq=False)
class Case:
    """A joint alone with everything that was identified on it."""

    robot: Robot
    path: ArmPath
    equipment: Equipment
    number: int = 1

    def ratio(self, robot: Robot, equipment: Equipment, on: str = "paper") -> tuple[float, float]:
        """rms and largest error of the slow trial with the compensator over those without."""
        off, with_it = (
            joint_figures(self.run(robot, equipment, name), self.number) for name in ("off", on)
        )
        return with_it["rms_deg"] / off["rms_deg"], with_it["max_deg"] / off["max_deg"]

    def run(self, robot: Robot, equipment: Equipment, compensator: str) -> TrialRun:
        """One slow trial of the joint alone."""
        return run_trial(robot, self.path, equipment, "slow", compensator, moving=(self.number,))[0]


def rest(case: Case) -> Table:
    """Integrator's torque while the joint holds still after a stroke, compensator off and on.

    The compensator takes over the hysteresis' share, so the level differs; what is left is creep, which the model does
    not contain, so the drift does not.
    """
    series = {}
    for name, switch in (("off", 0), ("on", COMPENSATOR)):
        arm = Arm(
            case.robot,
            moving=(case.number,),
            controllers=case.equipment.controllers,
            compensators=case.equipment.compensators,
            seed=case.equipment.seed,
        )
        home(arm, case.equipment.characteristics)
        spacing = 0.01
        t = spacing * np.arange(round((2 * STROKE_S + 1 + REST_S) / spacing) + 1)
        angle, velocity, acceleration = _there_and_part_back(t, arm.angles[0])
        load = arm.gravity(angle) * (1 + case.robot.controller.gravity_error)
        switches = POSITION | INTEGRATOR | switch
        mean = case.robot.controller.mean_pressure
        log = arm.run(Reference.motion(spacing, (angle, velocity, acceleration), load, mean, switches), every_s=0.1)
        held = log.time >= 2 * STROKE_S + 1
        series["time_s"] = log.time[held] - log.time[held][0]
        series[f"integrator_{name}_Nm"] = log.integrator[held, 0]
    return series


def _there_and_part_back(t: Array, start: float) -> tuple[Array, Array, Array]:
    """Move to 1.5 times the rest angle and back to it, so that the rest begins on a loop. (K, 1) each."""
    angle = np.full(t.shape, start)
    velocity, acceleration = np.zeros_like(t), np.zeros_like(t)
    for begin, way in ((1.0, 1.5 * REST_ANGLE - start), (1.0 + STROKE_S, -0.5 * REST_ANGLE)):
        u = np.clip((t - begin) / STROKE_S, 0.0, 1.0)
        angle += way * u**3 * (10 - 15 * u + 6 * u**2)
        velocity += way * 30 * u**2 * (1 - u) ** 2 / STROKE_S
        acceleration += way * 60 * u * (1 - u) * (1 - 2 * u) / STROKE_S**2
    return angle[:, None], velocity[:, None], acceleration[:, None]


def smaller_hysteresis(case: Case) -> Table:
    """The plant's hysteresis is smaller or larger than the one that was identified."""
    ratios = [
        case.ratio(case.robot.with_changes({"hysteresis.scale": s * case.robot.hysteresis.scale}), case.equipment)
        for s in SCALES
    ]
    return _table("scale", SCALES, ratios)


def double_compensation(case: Case) -> Table:
    """The hysteresis is compensated twice: by the controller and once more by something that does not know of it."""
    n = case.number
    model = case.equipment.compensators[n]
    controller = case.equipment.controllers[n]
    again = InverseCompensator(model, shear=controller.shear, unit=controller.compensator_unit)
    twice = replace(case.equipment, own={n: again})
    return {
        "case": ["off", "once", "twice"],
        "ratio_rms": np.array([1.0, case.ratio(case.robot, case.equipment)[0], case.ratio(case.robot, twice)[0]]),
    }


def high_gains(case: Case) -> Table:
    """The position loop is faster or slower: what is left for a compensator."""
    ratios = []
    for pole in POLES:
        robot = case.robot.with_changes({"controller.pole_1_s": pole})
        controllers = {n: replace(c, pole=pole) for n, c in case.equipment.controllers.items()}
        ratios.append(case.ratio(robot, replace(case.equipment, controllers=controllers)))
    return _table("pole_1_s", POLES, ratios)


def _table(name: str, values: Sequence[float], ratios: Sequence[tuple[float, float]]) -> Table:
    rms, largest = np.array(ratios).T
    return {name: np.array(values), "ratio_rms": rms, "ratio_max": largest}


STUDIES: Mapping[str, Callable[[Case], Table]] = {
    "rest": rest,
    "smaller hysteresis": smaller_hysteresis,
    "double compensation": double_compensation,
    "high gains": high_gains,
}


def study_jobs(case: Case) -> dict[str, Callable[[], Table]]:
    """The studies as jobs, by name."""
    return {name: partial(study, case) for name, study in STUDIES.items()}
