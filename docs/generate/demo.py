"""The runs behind the picture of README.md: two trials of `make demo`, on one of its plants."""

from __future__ import annotations

import tempfile
from functools import cache
from pathlib import Path

import numpy as np
import numpy.typing as npt

from dehyst_robot.arm import load_robot
from dehyst_robot.commands._reproduce import QUICK
from dehyst_robot.experiments import Reproduction, Request, reproduce
from dehyst_robot.experiments._results import TrialRun
from dehyst_robot.iso9283 import TestCube

Array = npt.NDArray[np.float64]

PLANT, COMPENSATOR, BEST = "preisach", "paper", "best"


@cache
def experiment(plant: str = PLANT, trials: tuple[str, ...] = ("fast", "slow")) -> Reproduction:
    """Return trials of the whole arm on a plant, as `dehyst reproduce --quick` runs them."""
    request = Request(
        plants=(plant,),
        compensators=(COMPENSATOR, BEST),
        seeds=(0,),
        trials=trials,
        studies=False,
    )
    with tempfile.TemporaryDirectory() as folder:
        return reproduce(load_robot(changes=QUICK), request, Path(folder))


def run(trial: str, compensator: str) -> TrialRun:
    """Return one run, "off", "paper" or "best"."""
    return next(
        r
        for r in experiment().plants[PLANT].runs
        if (r.trial, r.compensator) == (trial, compensator)
    )


def errors(result: Reproduction, trial: str) -> tuple[float, float, float]:
    """Rms error of joint 1 on the first plant without compensator, with the paper's and with the best one. [deg]"""
    plant = next(iter(result.plants.values()))
    found = plant.figures[0]["joints"]["1"]["trials"][trial]
    off, paper, best = (found[name]["rms_deg"] for name in ("off", COMPENSATOR, BEST))
    return off, paper, best


def in_test_plane(run: TrialRun, points: Array) -> Array:
    """Points (T, 3) of the tool as coordinates (T, 2) in the test plane: to the left, and up the plane. [mm]

    Only the second cycle; not a number on the ways between the figures, where a line shall break.
    """
    settings = load_robot().path
    cube = TestCube(settings.cube, settings.center)
    left, up, _ = cube.axes
    kept = run.cycle == 1
    away = (points - cube.origin)[kept]
    plane = 1e3 * np.stack([away @ left, away @ up], axis=1)
    return np.where((run.figure[kept] >= 0)[:, None], plane, np.nan)
