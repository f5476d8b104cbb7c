"""Figures of runs, nested as in ``--json``, and logs of the trials on disk: a CSV and an MCAP file per run."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from dehyst.arrays import Array
from dehyst.errors import OutputError
from dehyst.io import write_csv, write_mcap
from dehyst.robot.control import save_controller
from dehyst.robot.experiments.calibration import BAR
from dehyst.robot.experiments.equipment import Equipment
from dehyst.robot.experiments.results import JointIdentification, PlantResult, Reproduction, TrialRun
from dehyst.robot.iso9283 import Timed, Timing, iso9283, tracking_figures


def joint_figures(run: TrialRun, number: int) -> dict[str, float]:
    """Root mean square and largest error of a joint over a run. [deg]"""
    error = np.degrees(run.error[:, number - 1])
    return {"rms_deg": float(np.sqrt(np.mean(error**2))), "max_deg": float(np.abs(error).max())}


def plant_figures(
    identifications: Mapping[str, Mapping[int, JointIdentification]],
    runs: Iterable[TrialRun],
    motions: Mapping[str, Timing],
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


def trial_figures(runs: Iterable[TrialRun], motions: Mapping[str, Timing], joints: Iterable[int]) -> dict[str, Any]:
    """Errors of joints and tool in all runs; parameters as for `plant_figures`."""
    listed: dict[str, Any] = {str(number): {"trials": {}} for number in joints}
    tool: dict[str, Any] = {}
    for run in runs:
        for number, one in listed.items():
            one["trials"].setdefault(run.trial, {})[run.compensator] = joint_figures(run, int(number))
        motion = motions[run.trial]
        tool.setdefault(run.trial, {})[run.compensator] = (
            iso9283(motion, run.time, run.tool, run.cycle, run.figure)
            if isinstance(motion, Timed)
            else tracking_figures(run.tool_desired, run.tool)
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

    ``plants``: plant -> ``joints`` and ``tool`` (means over the seeds), ``seeds`` (the same for each) and ``remarks``;
    ``real_time_factor``: the slowest plant's; ``settings``, ``studies``.
    """
    plants = {
        name: {
            **mean_figures(plant),
            "seeds": {str(seed): _plain(one) for seed, one in plant.figures.items()},
            "remarks": list(plant.remarks),
        }
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


MOST_ROWS = 4000  # of a log: its rows are 20 to 80 ms apart


def trial_columns(run: TrialRun) -> Mapping[str, Array]:
    """Columns of a run's log, with their units: what a rig would have logged, and the tool."""
    columns: dict[str, Array] = {}
    for number in range(1, run.desired.shape[1] + 1):
        i = number - 1
        columns[f"joint{number}_desired_deg"] = np.degrees(run.desired[:, i])
        columns[f"joint{number}_angle_deg"] = np.degrees(run.angle[:, i])
        if not run.pressure[:, i].any():
            continue  # electric
        columns[f"joint{number}_pressure_1_bar"] = run.pressure[:, i, 0] / BAR
        columns[f"joint{number}_pressure_2_bar"] = run.pressure[:, i, 1] / BAR
        columns[f"joint{number}_pressure_difference_desired_bar"] = run.pressure_difference[:, i] / BAR
        columns[f"joint{number}_compensation_bar"] = run.compensation[:, i] / BAR
        columns[f"joint{number}_integrator_Nm"] = run.integrator[:, i]
        if not run.scale[:, i].any():
            continue  # locked
        told = {"contact_Nm": run.contact, "doubt_Nm": run.doubt, "offset_Nm": run.offset}
        told |= {"hysteresis_of_model": run.hysteresis, "scale": run.scale}
        told |= {f"scale_{g + 1}": run.scales[:, :, g] for g in range(run.scales.shape[2])}
        columns |= {f"joint{number}_{name}": values[:, i] for name, values in told.items()}
    for axis, name in enumerate("xyz"):
        columns[f"tool_desired_{name}_m"] = run.tool_desired[:, axis]
        columns[f"tool_{name}_m"] = run.tool[:, axis]
    columns["figure"] = run.figure.astype(np.float64)
    columns["cycle"] = run.cycle.astype(np.float64)
    return columns


def _channels(time: Array, columns: Mapping[str, Array]) -> dict[str, tuple[Array, Mapping[str, Array]]]:
    """One topic a joint, one for the tool, one for the place on the path; fields without the topic's name."""
    channels: dict[str, dict[str, Array]] = {}
    for name, values in columns.items():
        topic, _, field = name.partition("_") if name.startswith(("joint", "tool")) else ("path", "", name)
        channels.setdefault(topic, {})[field] = values
    return {topic: (time, fields) for topic, fields in channels.items()}


def log_folder(folder: Path, plant: str, seed: int, beside: str = "") -> Path:
    """Make the folder for the logs of a plant and seed, in it `beside` for those of another controller."""
    place = folder / plant / f"seed{seed}" / beside
    try:
        place.mkdir(parents=True, exist_ok=True)
    except OSError as fault:
        raise OutputError(
            f"cannot make the folder '{place}' for the logs: {fault.strerror}. Name another one.", path=str(place)
        ) from None
    return place


def write_units(
    equipment: Equipment, found: Mapping[int, JointIdentification], folder: Path, compensator: str = "paper"
) -> list[Path]:
    """Write model and controller of each compensated joint, for `dehyst export --what joint-controller`.

    The name of the compensator ends those of the files; the paper's have none.
    """
    written = []
    end = "" if compensator == "paper" else f"_{compensator}"
    for number in equipment.compensators:
        model, controller = found[number].model, folder / f"controller_joint{number}{end}.json"
        written.append(model.save(folder / f"model_joint{number}{end}.json"))
        written.append(save_controller(equipment.controllers[number], controller, model=model))
    return written


def log_names(run: TrialRun) -> str:
    """Beginning of the names of a run's log files."""
    return f"{run.trial}_{run.compensator}"


def write_trial(run: TrialRun, folder: Path, mcap: bool = True) -> list[Path]:
    """Write a run's log, every n-th row so that there are `MOST_ROWS` at most; its name tells trial and compensator."""
    thin = slice(None, None, -(-run.time.size // MOST_ROWS))
    time, columns = run.time[thin], {name: values[thin] for name, values in trial_columns(run).items()}
    stem = folder / log_names(run)
    written = [write_csv(stem.with_suffix(".csv"), {"time_s": time, **columns})]
    if mcap:
        written.append(write_mcap(stem.with_suffix(".mcap"), _channels(time, columns)))
    return written
