"""The paper's experiment on one plant or several: calibrate, identify, invert, and run the trials off and on."""

from __future__ import annotations

import itertools
import os
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Protocol, TypeVar

from dehyst.errors import ParameterError
from dehyst.experiments.calibration import calibrate
from dehyst.experiments.compensators import NAMES, equip
from dehyst.experiments.loops_run import identify_joint
from dehyst.experiments.path import ArmPath, plan_path
from dehyst.experiments.results import (
    TRIALS,
    Characteristic,
    JointIdentification,
    PlantResult,
    Reproduction,
    TrialRun,
)
from dehyst.experiments.scores import plant_figures
from dehyst.experiments.studies import run_studies
from dehyst.experiments.trials import run_trial
from dehyst.plant.parameters import Robot

PLANTS = ("maxwell-slip", "preisach", "dahl", "none")
COMPENSATED = (1, 2, 4)  # joints that the large muscles drive

Key = TypeVar("Key")
Value = TypeVar("Value")


class Progress(Protocol):
    """What shows how far a long run is."""

    def stage(self, name: str, total: int) -> None:
        """A stage of `total` steps begins."""

    def step(self) -> None:
        """One step is done."""


class _Silent:
    def stage(self, name: str, total: int) -> None:
        """Nothing to show."""

    def step(self) -> None:
        """Nothing to show."""


@dataclass(frozen=True)
class Request:
    """What to reproduce.

    Attributes
    ----------
    plants
        Hysteresis mechanisms of the simulated muscles, of `PLANTS`.
    joints
        Joints that are identified, compensated and listed, of 1, 2 and 4.
    compensator
        Its name, of `dehyst.experiments.compensators.NAMES`.
    seeds
        Each repeats everything with other noise and other muscles of the same make.
    trials
        Of "fast", "slow", "slow_no_integrator".
    studies
        Whether the studies of rest and of where compensation hurts are run.
    workers
        Threads; None: one a core.
    """

    plants: tuple[str, ...] = PLANTS
    joints: tuple[int, ...] = COMPENSATED
    compensator: str = "paper"
    seeds: tuple[int, ...] = (0, 1, 2)
    trials: tuple[str, ...] = TRIALS
    studies: bool = True
    workers: int | None = None


def reproduce(robot: Robot, request: Request, folder: Path, progress: Progress | None = None) -> Reproduction:
    """Run the whole experiment.

    Parameters
    ----------
    robot
        The arm; its hysteresis mechanism is replaced by those of the request.
    request
        What to run.
    folder
        Where the logs go.
    progress
        What shows it.

    Returns
    -------
    result : Reproduction

    Raises
    ------
    ParameterError
        If the request names what does not exist.
    """
    _check(request)
    show = progress or _Silent()
    path = plan_path(robot)
    cases = {
        (plant, seed): robot.with_changes({"hysteresis.mechanism": plant})
        for plant, seed in itertools.product(request.plants, request.seeds)
    }
    with ThreadPoolExecutor(request.workers or os.cpu_count() or 1) as pool:

        def run(name: str, jobs: Mapping[Key, Callable[[], Value]]) -> dict[Key, Value]:
            show.stage(name, len(jobs))
            futures = {pool.submit(job): key for key, job in jobs.items()}
            found: dict[Key, Value] = {}
            try:
                for future in as_completed(futures):
                    found[futures[future]] = future.result()
                    show.step()
            finally:
                for future in futures:
                    future.cancel()
            return {key: found[key] for key in jobs}

        backbones = run("calibration sweeps", {
            (*case, n): lambda r=r, n=n, case=case: calibrate(r, n, seed=case[1])
            for case, r in cases.items() for n in r.pneumatic
        })
        identified = run("identification", {
            (*case, n): lambda r=r, n=n, case=case: identify_joint(
                r, n, backbones[*case, n], _folder(folder, *case), seed=case[1])
            for case, r in cases.items() for n in request.joints
        })
        ...
    raise NotImplementedError
