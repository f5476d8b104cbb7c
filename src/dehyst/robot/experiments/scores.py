"""Figures of runs, nested as in ``--json``, and their means over the seeds."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from dehyst.robot.experiments.results import JointIdentification, PlantResult, Reproduction, TrialRun
from dehyst.robot.iso9283 import Timed, iso9283


def joint_figures(run: TrialRun, number: int) -> dict[str, float]:
    """Root mean square and largest error of a joint over a run. [deg]"""
    error = np.degrees(run.error[:, number - 1])
    return {"rms_deg": float(np.sqrt(np.mean(error**2))), "max_deg": float(np.abs(error).max())}


def plant_figures(
    identifications: Mapping[str, Mapping[int, JointIdentification]],
    runs: Iterable[TrialRun],
    motions: Mapping[str, Timed],
    joints: Iterable[int],
) -> dict[str, Any]:
    """Everything measured on one plant with one seed.

    `identifications`: compensator -> joint number -> identification; the last one is the one that is explained.
    """
    found = trial_figures(runs, motions, joints)
    for number in joints:
        told = {name: _identification(one[number]) for name, one in identifications.items()}
        first = {"identification": [*told.values()][-1], "identifications": told}
        found["joints"][str(number)] = first | found["joints"][str(number)]
    return found


def trial_figures(runs: Iterable[TrialRun], motions: Mapping[str, Timed], joints: Iterable[int]) -> dict[str, Any]:
    """Errors of joints and tool in all runs; parameters as for `plant_figures`."""
    listed: dict[str, Any] = {str(number): {"trials": {}} for number in joints}
    tool: dict[str, Any] = {}
    for run in runs:
        for number, one in listed.items():
            one["trials"].setdefault(run.trial, {})[run.compensator] = joint_figures(run, int(number))
        tool.setdefault(run.trial, {})[run.compensator] = iso9283(
            motions[run.trial], run.time, run.tool, run.cycle, run.figure
        )
    return {"joints": listed, "tool": tool}


def _identification(found: JointIdentification) -> dict[str, Any]:
    return {
        "nonzero_weights": found.nonzero_weights,
        "inverse_rms_ratio_unseen": found.inverse_rms_ratio,
        "unexplained_unseen": found.unexplained,
        "accepted": found.accepted,
        "calibration_residual_Nm": found.characteristic.residual,
    }


FORMAT = "dehyst-reproduction"


def mean_figures(result: PlantResult) -> dict[str, Any]:
    """Return the figures of a plant, each the mean over its seeds; None where no seed gave a number."""
    mean: dict[str, Any] = _mean(list(result.figures.values()))
    return mean


def as_json(result: Reproduction) -> dict[str, Any]:
    """Return what ``dehyst reproduce --json`` writes.

    ``plants``: plant -> ``joints`` and ``tool`` (means over the seeds) and ``seeds`` (the same for each);
    ``real_time_factor``: the slowest plant's; ``settings``, ``studies``.
    """
    plants = {
        name: {**mean_figures(plant), "seeds": {str(seed): _plain(one) for seed, one in plant.figures.items()}}
        for name, plant in result.plants.items()
    }
    return {
        "format": FORMAT,
        "plants": plants,
        "real_time_factor": min(plant.real_time_factor for plant in result.plants.values()),
        "compensator": result.compensator,
        "compensators": list(result.compensators),
        "settings": _plain(result.settings),
        "studies": _plain(result.studies),
    }


def _mean(values: Sequence[Any]) -> Any:
    given = [value for value in values if value is not None]
    if not given:
        return None
    first = given[0]
    if isinstance(first, Mapping):
        keys = dict.fromkeys(key for value in given for key in value)  # a reason may be one seed's alone
        return {key: _mean([value.get(key) for value in given]) for key in keys}
    if isinstance(first, bool | np.bool_):
        return bool(all(given))
    numbers = [float(v) for v in given if isinstance(v, int | float | np.number) and np.isfinite(float(v))]
    if numbers:
        mean = float(np.mean(numbers))
        return round(mean) if all(isinstance(v, int) for v in given) and mean == round(mean) else mean
    return _plain(first)


def _plain(value: Any) -> Any:
    """Values as JSON knows them: no arrays, no NaN."""
    if isinstance(value, Mapping):
        return {str(key): _plain(one) for key, one in value.items()}
    if isinstance(value, np.ndarray | list | tuple):
        return [_plain(one) for one in value]
    if isinstance(value, bool | np.bool_):
        return bool(value)
    if isinstance(value, np.integer):
        return int(value)
    if isinstance(value, float | np.floating):
        return float(value) if np.isfinite(value) else None
    return value
