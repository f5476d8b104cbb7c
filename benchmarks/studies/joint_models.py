"""A joint that moves alone, calibrated and identified, and any family of models as the compensator of its path."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import cast

import numpy as np
import numpy.typing as npt

from dehyst import identify
from dehyst.arrays import rank
from dehyst.data import Recording
from dehyst.errors import DehystError
from dehyst.families import names
from dehyst.models import Model
from dehyst_robot.arm import Robot
from dehyst_robot.arm import kit as arm_kit
from dehyst_robot.control import Compensator, LoopCompensator
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
MECHANISMS = tuple(name for name in arm_kit.PLANTS if name != "none")
# Choices of `dehyst.identify` that the register of families does not name; auto is what it does where none is named.
CHOICES = ("auto", "pi", "pi-cumulative", "modified-pi", "stop")


@dataclass(frozen=True, eq=False)
class Joint:
    """A joint alone, calibrated, and what was identified from its log.

    Attributes
    ----------
    robot, path, number, seed
        What is run.
    characteristic
        Calibrated A, B, C.
    identified
        Recipe of the experiment -> its identification; that of "paper" holds the log of the decaying loops.
    """

    robot: Robot
    path: PlannedPath
    number: int
    seed: int
    characteristic: Characteristic
    identified: Mapping[str, JointIdentification]

    def equipped(self, name: str = "") -> Equipment:
        """Return the joint with a recipe's compensator, which learns if the recipe does; without a name with none."""
        compensators = {self.number: self.identified[name]} if name else {}
        return equip(
            self.robot,
            {self.number: self.characteristic},
            compensators,
            self.seed,
            adaptive=recipe(name).adaptive if name else False,
        )


@dataclass(frozen=True, eq=False)
class PathModel:
    """A family that was fitted to the joint's log, ready to be switched on.

    Attributes
    ----------
    way
        "inverted": identified from pressure to angle and inverted; "as it is": from angle to pressure.
    compensator
        None if there is none; `reason` says why.
    parameters
        Number of identified values that are not zero.
    seconds
        Processor time of the fit. [s]
    unexplained
        Share of the hysteresis that it leaves on loops that it has not seen, std over std.
    """

    way: str = ""
    compensator: Compensator | None = None
    parameters: int = 0
    seconds: float = 0.0
    unexplained: float = float("inf")
    reason: str = ""


def prepared(robot: Robot, number: int, seed: int, recipes: Sequence[str]) -> Joint:
    """Calibrate a joint, run its log, and identify the compensators of the experiment.

    Parameters
    ----------
    robot
        The plant.
    number
        Of the joint.
    seed
        Of noise and tolerances.
    recipes
        Names of compensators, "paper" among them.
    """
    characteristic = calibrate(robot, number, seed=seed)
    wanted = {name: (recipe(name), characteristic) for name in recipes}
    with tempfile.TemporaryDirectory() as folder:
        identified = identify_compensators(robot, number, wanted, Path(folder), seed=seed)
    return Joint(robot, plan_path(robot), number, seed, characteristic, identified)


def model_names() -> tuple[str, ...]:
    """Families that are tried in the controller: of `dehyst.identify`, then those of the register.

    Examples
    --------
    >>> model_names()[:5]
    ('auto', 'pi', 'pi-cumulative', 'modified-pi', 'stop')
    """
    return (*CHOICES, *(name for name in names() if name not in CHOICES))


def path_model(
    identification: JointIdentification, family: str, seed: int = 0, way: str = ""
) -> PathModel:
    """Fit a family to a joint's log, both ways round, and return the one that explains more of the log's hysteresis.

    The choice is made on the log of the fit; `unexplained` is measured on other loops.

    Parameters
    ----------
    identification
        What the paper's compensator was identified from.
    family
        Of `model_names`.
    seed
        Of searches.
    way
        "inverted" or "as it is"; "": both.
    """
    fits, reasons = [], []
    for one in (way,) if way else (INVERTED, AS_IT_IS):
        try:
            fits.append(_one_way(identification, family, seed, one))
        except DehystError as fault:
            reasons.append(f"{one}: {' '.join(str(fault).split())}")
    if not fits:
        return PathModel(reason=" ".join(reasons))
    seconds = sum(model.seconds for _, model in fits)
    return replace(min(fits, key=lambda pair: rank(pair[0]))[1], seconds=seconds)


def _one_way(
    identification: JointIdentification, family: str, seed: int, way: str
) -> tuple[float, PathModel]:
    """Fit one way round; the share of the log's hysteresis that is left, and the model."""
    columns, units = (OUTPUT, INPUT), ("rad", "bar")
    if way == INVERTED:
        columns, units = (INPUT, OUTPUT), ("bar", "rad")
    x, q = (identification.log[column] for column in columns)
    t = identification.log[TIME]
    record = Recording(input=x, output=q, time=t, input_unit=units[0], output_unit=units[1])
    begun = time.thread_time()
    fit = identify(record, family, train_fraction=1.0, seed=seed)
    model: Model = fit.model.inverse() if way == INVERTED else fit.model
    seconds = time.thread_time() - begun
    compensator = LoopCompensator(model, shear=BAR * identification.shear, period=5e-4)
    logs = (identification.log, identification.unseen)
    seen, unseen = (unexplained(compensator, log) for log in logs)
    return seen, PathModel(way, compensator, fit.model.nonzero_weights, seconds, unseen)


def unexplained(compensator: LoopCompensator, log: Mapping[str, Array]) -> float:
    """Return the share of a log's hysteresis that a compensator leaves, std over std."""
    measured = log[HYSTERESIS]
    computed = compensator.over(log[OUTPUT], np.zeros(measured.size), log[TIME]) / BAR
    return float(np.std(measured - computed) / np.std(measured))


def with_model(joint: Joint, model: PathModel) -> Equipment:
    """Return the joint with a compensator along its desired path, and none in the controller."""
    assert model.compensator is not None
    return replace(joint.equipped(), own={joint.number: model.compensator})


def errors(joint: Joint, equipment: Equipment, trial: str, on: bool = True) -> dict[str, float]:
    """Run a trial of the joint alone; its rms and largest error. [deg]"""
    switch = "on" if on else "off"
    run, _ = run_trial(joint.robot, joint.path, equipment, trial, switch, moving=(joint.number,))
    return joint_figures(run, joint.number)


def path_cost(model: PathModel, samples: int = 2000, repeats: int = 3) -> float:
    """Return the processor time of a sample of a compensator along a path. [ns]"""
    compensator, t = cast(LoopCompensator, model.compensator), np.linspace(0.0, 12.0, samples)
    seconds = []
    for _ in range(repeats):
        begun = time.thread_time()
        compensator.over(0.3 * np.sin(t), 0.3 * np.cos(t), t)
        seconds.append(time.thread_time() - begun)
    return 1e9 * float(np.median(seconds)) / samples
