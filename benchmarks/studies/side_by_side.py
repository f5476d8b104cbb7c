"""Every model of the literature in the controller, on one joint and its own log: identified, switched on, measured."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType
from typing import cast

import numpy as np
import numpy.typing as npt

from dehyst import identify
from dehyst.arrays import rank
from dehyst.data import Recording
from dehyst.errors import DehystError, ParameterError
from dehyst.families import names, title_of
from dehyst.families._bouc_wen import BoucWen
from dehyst.models import Model
from dehyst_robot.arm import MechanismFactory, Robot, load_robot
from dehyst_robot.control import Compensator, LoopCompensator, ModelMechanism
from dehyst_robot.experiments import (
    Equipment,
    JointIdentification,
    calibrate,
    equip,
    plan_path,
    run_trial,
)
from dehyst_robot.experiments._identification import (
    HYSTERESIS,
    INPUT,
    OUTPUT,
    TIME,
    identify_compensators,
)
from dehyst_robot.experiments._output import joint_figures
from dehyst_robot.experiments._path import PlannedPath
from dehyst_robot.experiments._recipes import recipe
from dehyst_robot.experiments._results import BAR, Characteristic

Array = npt.NDArray[np.float64]

INVERTED, AS_IT_IS = "inverted", "as it is"
OF_IDENTIFY = (
    "pi",
    "pi-cumulative",
    "modified-pi",
    "stop",
)  # families of `dehyst.identify`; the rest has its own room
NATIVE = (
    "paper",
    "maxwell-slip",
    "direct",
    "creep",
)  # recipes that run in the joint's controller, period by period
SIZES: Mapping[int, float] = MappingProxyType(
    {1: 80.0, 2: 80.0, 4: 80.0}
)  # [N] of large muscles; small ones: 20


def bouc_wen_muscle(joint: int, muscle: int) -> ModelMechanism:
    """A muscle whose hysteresis is none of the built-in ones: Bouc-Wen, sharper before it slips, harder after a turn.

    Its slipping force is that of the built-in mechanisms; 90 % of it are reached at a strain of 0.019.
    """
    zero, one = np.zeros(1), np.ones(1)
    model = BoucWen(curve=zero, beta=0.7 * one, gamma=0.3 * one, power=1.5 * one, weights=one)
    return ModelMechanism(model, SIZES.get(joint, 20.0), 0.0125)


PLANTS: Mapping[str, MechanismFactory | None] = MappingProxyType(
    {"maxwell-slip": None, "preisach": None, "dahl": None, "bouc-wen": bouc_wen_muscle}
)
"""Plant -> what makes the hysteresis of its muscles; None: built in, of that name."""


@dataclass(frozen=True, eq=False)
class Joint:
    """A joint alone, calibrated, with its logs and what the controller's own compensators were identified from them.

    Attributes
    ----------
    robot, path, number, seed
        What is run.
    mechanisms
        Of its muscles; None: the robot's.
    characteristic
        Calibrated A, B, C.
    found
        Compensator of `NATIVE` -> its identification; that of "paper" holds the log of the decaying loops.
    """

    robot: Robot
    path: PlannedPath
    number: int
    seed: int
    mechanisms: MechanismFactory | None
    characteristic: Characteristic
    found: Mapping[str, JointIdentification]

    def equipped(self, compensator: str = "") -> Equipment:
        """Return the joint with a compensator of `NATIVE` in its controller, or with none."""
        chosen = {self.number: self.found[compensator]} if compensator else {}
        return equip(
            self.robot, {self.number: self.characteristic}, chosen, self.seed, self.mechanisms
        )


@dataclass(frozen=True, eq=False)
class Learned:
    """A family on the joint's own log, ready to be switched on.

    Attributes
    ----------
    family, title
        Its name, and as written.
    way
        "inverted": identified from pressure to angle and inverted; "as it is": from angle to pressure.
    compensator
        None if there is none; `reason` says why.
    parameters
        Number of identified values.
    seconds
        Processor time of the fit. [s]
    unexplained
        Share of the hysteresis that it leaves on loops that it has not seen, std over std.
    reason
        Why nothing came of it, in the words of the fault.
    """

    family: str
    title: str
    way: str = ""
    compensator: Compensator | None = None
    parameters: int = 0
    seconds: float = 0.0
    unexplained: float = float("inf")
    reason: str = ""


def prepared(
    plant: str,
    seed: int = 0,
    *,
    number: int = 1,
    compensators: Sequence[str] = ("paper",),
    changes: Mapping[str, object] | None = None,
) -> Joint:
    """Calibrate a joint of a plant, run its logs, and identify what runs in its controller.

    Parameters
    ----------
    plant
        Of `PLANTS`.
    seed
        Of noise and tolerances.
    number
        Of the joint.
    compensators
        Recipes that are identified, "paper" among them.
    changes
        Dotted keys of the parameter file -> values.

    Raises
    ------
    ParameterError
        If there is no such plant.
    """
    if plant not in PLANTS:
        raise ParameterError(f"no plant '{plant}'. There are: {', '.join(PLANTS)}.", plant=plant)
    factory = PLANTS[plant]
    named = {} if factory else {"hysteresis.mechanism": plant}
    robot = load_robot(conditions="kind", changes={**named, **(changes or {})})
    characteristic = calibrate(robot, number, seed=seed, mechanisms=factory)
    wanted = {name: (recipe(name), characteristic) for name in compensators}
    with tempfile.TemporaryDirectory() as folder:
        found = identify_compensators(
            robot, number, wanted, Path(folder), seed=seed, mechanisms=factory
        )
    return Joint(robot, plan_path(robot), number, seed, factory, characteristic, found)


def model_names() -> tuple[str, ...]:
    """Families that are tried in the controller: of `dehyst.identify`, then those of the registry.

    Examples
    --------
    >>> model_names()[:5]
    ('pi', 'pi-cumulative', 'modified-pi', 'stop', 'elements')
    """
    return (*OF_IDENTIFY, *(name for name in names() if name not in OF_IDENTIFY))


def learned(found: JointIdentification, name: str, seed: int = 0, way: str = "") -> Learned:
    """Identify a family on a joint's log, both ways round, and return the one that says more of the log's hysteresis.

    The choice is made on the log of the fit; `unexplained` is measured on other loops.

    Parameters
    ----------
    found
        What the paper's compensator was identified from.
    name
        Of `model_names`.
    seed
        Of searches.
    way
        "inverted" or "as it is"; "": both.
    """
    title = title_of(name)
    tried, reasons = [], []
    for one in (way,) if way else (INVERTED, AS_IT_IS):
        try:
            tried.append(_one_way(found, name, title, seed, one))
        except DehystError as fault:
            reasons.append(f"{one}: {' '.join(str(fault).split())}")
    if not tried:
        return Learned(name, title, reason=" ".join(reasons))
    seconds = sum(one.seconds for _, one in tried)
    return replace(min(tried, key=lambda pair: rank(pair[0]))[1], seconds=seconds)


def _one_way(
    found: JointIdentification, name: str, title: str, seed: int, way: str
) -> tuple[float, Learned]:
    """Fit one way round; what it leaves of the hysteresis of the log that it was fitted to, and the result."""
    x, q = (
        found.log[column] for column in ((INPUT, OUTPUT) if way == INVERTED else (OUTPUT, INPUT))
    )
    x_unit, q_unit = ("bar", "rad") if way == INVERTED else ("rad", "bar")
    record = Recording(
        input=x, output=q, time=found.log[TIME], input_unit=x_unit, output_unit=q_unit
    )
    begun = time.thread_time()
    fit = identify(record, name, train_fraction=1.0, seed=seed)
    parameters = fit.model.nonzero_weights
    told: Model = fit.model.inverse() if way == INVERTED else fit.model
    seconds = time.thread_time() - begun
    compensator = LoopCompensator(told, shear=BAR * found.shear, period=5e-4)
    seen, unseen = (unexplained(compensator, log) for log in (found.log, found.unseen))
    return seen, Learned(name, title, way, compensator, parameters, seconds, unseen)


def unexplained(compensator: LoopCompensator, log: Mapping[str, Array]) -> float:
    """Return the share of a log's hysteresis that a compensator leaves, std over std."""
    measured = log[HYSTERESIS]
    said = compensator.over(log[OUTPUT], np.zeros(measured.size), log[TIME]) / BAR
    return float(np.std(measured - said) / np.std(measured))


def with_model(joint: Joint, model: Learned) -> Equipment:
    """Return the joint with a learned compensator along its desired path, and none in the controller."""
    assert model.compensator is not None
    return replace(joint.equipped(), own={joint.number: model.compensator})


def errors(
    joint: Joint, equipment: Equipment, trial: str, on: bool = True, robot: Robot | None = None
) -> dict[str, float]:
    """Run a trial of the joint alone; its rms and largest error. [deg]"""
    run, _ = run_trial(
        robot or joint.robot,
        joint.path,
        equipment,
        trial,
        "on" if on else "off",
        moving=(joint.number,),
    )
    return joint_figures(run, joint.number)


def path_cost(model: Learned, samples: int = 2000, repeats: int = 3) -> float:
    """Return the time of a sample of a learned compensator along a path, processor time. [ns]"""
    compensator, t = cast(LoopCompensator, model.compensator), np.linspace(0.0, 12.0, samples)
    spent = []
    for _ in range(repeats):
        begun = time.thread_time()
        compensator.over(0.3 * np.sin(t), 0.3 * np.cos(t), t)
        spent.append(time.thread_time() - begun)
    return 1e9 * float(np.median(spent)) / samples
