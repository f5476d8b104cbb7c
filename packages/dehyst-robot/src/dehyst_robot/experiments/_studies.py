"""Studies on a single joint: behaviour at rest, and cases where compensation hurts."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, cast

import numpy as np

from dehyst.arrays import Array
from dehyst.models import DirectInverse, HysteresisModel
from dehyst_robot.arm import Arm, Reference, Robot
from dehyst_robot.control import SWITCHES, InverseCompensator
from dehyst_robot.control import kit as control_kit
from dehyst_robot.experiments._calibration import home
from dehyst_robot.experiments._equipment import Equipment
from dehyst_robot.experiments._gains import at_pole
from dehyst_robot.experiments._output import joint_figures
from dehyst_robot.experiments._path import PlannedPath
from dehyst_robot.experiments._trials import run_trial

POSITION, INTEGRATOR = SWITCHES["position"], SWITCHES["integrator"]
COMPENSATOR = SWITCHES["compensator"]

Table = Mapping[str, Array | Sequence[str]]

SCALES = (0.0, 0.25, 0.5, 0.75, 1.0, 1.5)  # true hysteresis over the identified one
POLES = (4.0, 6.0, 8.0, 12.0, 16.0)  # lambda [1/s]
REST_ANGLE = np.radians(12.0)
REST_S = 120.0
SETTLE_S = 6.0  # for the position loop to end its transient
STROKE_S = 2.0


@dataclass(frozen=True, eq=False)
class StudyCase:
    """A joint alone with everything that was identified on it."""

    robot: Robot
    path: PlannedPath
    equipment: Equipment
    number: int = 1


Job = Callable[[], Any]
SLOW_FACTOR = (
    5.0  # of the trials of the studies: half of the slow trial's, as there are two dozen of them
)
Key = tuple[str, float | str]


def ratio(case: StudyCase, robot: Robot, equipment: Equipment) -> tuple[float, float]:
    """rms and largest error of a slow trial with the compensator over those without."""
    robot = robot.with_changes({"path.slow_factor": SLOW_FACTOR})
    figures = {}
    for name in ("off", "on"):
        run, _ = run_trial(robot, case.path, equipment, "slow", name, moving=(case.number,))
        figures[name] = joint_figures(run, case.number)
    off, on = figures["off"], figures["on"]
    return on["rms_deg"] / off["rms_deg"], on["max_deg"] / off["max_deg"]


def rest(case: StudyCase) -> Table:
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
            adaptations=case.equipment.adaptations,
            seed=case.equipment.seed,
        )
        home(arm, case.equipment.characteristics)
        spacing = 0.01
        t = np.asarray(spacing * np.arange(round((2 * STROKE_S + SETTLE_S + REST_S) / spacing) + 1))
        angle, velocity, acceleration = there_and_part_back(t, arm.encoder_angles[0])
        load = arm.gravity(angle) * (1 + case.robot.controller.gravity_error)
        switches = POSITION | INTEGRATOR | switch
        mean = case.robot.controller.mean_pressure
        log = arm.run(
            Reference.motion(spacing, (angle, velocity, acceleration), load, mean, switches),
            every_s=0.1,
        )
        at_rest = log.time >= 2 * STROKE_S + SETTLE_S
        series["time_s"] = log.time[at_rest] - log.time[at_rest][0]
        series[f"integrator_{name}_Nm"] = log.integrator[at_rest, 0]
    return series


def there_and_part_back(t: Array, start: float) -> tuple[Array, Array, Array]:
    """Move to 1.5 times the rest angle and back to it, so that the rest begins on a loop. (K, 1) each."""
    angle = np.full(t.shape, start)
    velocity, acceleration = np.zeros_like(t), np.zeros_like(t)
    for begin, way in ((1.0, 1.5 * REST_ANGLE - start), (1.0 + STROKE_S, -0.5 * REST_ANGLE)):
        u = np.clip((t - begin) / STROKE_S, 0.0, 1.0)
        angle += way * u**3 * (10 - 15 * u + 6 * u**2)
        velocity += way * 30 * u**2 * (1 - u) ** 2 / STROKE_S
        acceleration += way * 60 * u * (1 - u) * (1 - 2 * u) / STROKE_S**2
    return angle[:, None], velocity[:, None], acceleration[:, None]


def smaller_hysteresis(case: StudyCase, scale: float) -> tuple[float, float]:
    """The plant's hysteresis is `scale` times the one that was identified."""
    return ratio(
        case,
        case.robot.with_changes({"hysteresis.scale": scale * case.robot.hysteresis.scale}),
        case.equipment,
    )


def compensated_twice(case: StudyCase) -> tuple[float, float]:
    """The hysteresis is compensated once more by something that does not know of the first."""
    n = case.number
    controller = case.equipment.controllers[n]
    model = case.equipment.compensators.get(n)
    if model is None:
        return ratio(case, case.robot, case.equipment)
    if model.core == control_kit.DIRECT:
        twice = {**case.equipment.compensators, n: _twice(cast(DirectInverse, model))}
        return ratio(case, case.robot, replace(case.equipment, compensators=twice))
    again = InverseCompensator(
        cast(HysteresisModel, model), shear=controller.shear, unit=controller.compensator_unit
    )
    return ratio(case, case.robot, replace(case.equipment, own={n: again}))


def _twice(model: DirectInverse) -> DirectInverse:
    """Twice the torque."""
    card = model.card
    low, high = (None if end is None else 2 * end for end in (card.input.low, card.input.high))
    return replace(
        model,
        stop_weights=2 * model.stop_weights,
        path_weights=2 * model.path_weights,
        creep_weights=2 * model.creep_weights,
        polynomial=2 * model.polynomial,
        viscous=2 * model.viscous,
        card=replace(card, input=replace(card.input, low=low, high=high)),
    )


def high_gains(case: StudyCase, pole: float) -> tuple[float, float]:
    """The position loop is faster or slower: what is left for a compensator."""
    return ratio(case, case.robot, at_pole(case.equipment, pole))


def study_jobs(case: StudyCase) -> dict[Key, Job]:
    """Every point of every study as a job of its own."""
    jobs: dict[Key, Job] = {("rest", ""): partial(rest, case)}
    # `study_tables` takes the results in this order: the scales and the poles as they stand above.
    for scale in SCALES:
        jobs["smaller hysteresis", scale] = partial(smaller_hysteresis, case, scale)
    jobs["double compensation", "twice"] = partial(compensated_twice, case)
    for pole in POLES:
        jobs["high gains", pole] = partial(high_gains, case, pole)
    return jobs


def study_tables(results: Mapping[Key, Any]) -> dict[str, Table]:
    """The tables of the report from what the jobs returned."""

    def ratios(study: str) -> Table:
        rows = np.array([value for (name, _), value in results.items() if name == study])
        return {"ratio_rms": rows[:, 0], "ratio_max": rows[:, 1]}

    once = results["smaller hysteresis", 1.0][0]
    twice = results["double compensation", "twice"][0]
    return {
        "rest": results["rest", ""],
        "smaller hysteresis": {"scale": np.array(SCALES), **ratios("smaller hysteresis")},
        "double compensation": {
            "case": ["off", "once", "twice"],
            "ratio_rms": np.array([1.0, once, twice]),
        },
        "high gains": {"pole_1_s": np.array(POLES), **ratios("high gains")},
    }
