"""Figures of runs, nested as in ``--json``, and logs of the trials on disk: a CSV and an MCAP file per run."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from dehyst.arrays import Array
from dehyst.errors import OutputError
from dehyst.io import write_csv, write_mcap
from dehyst_robot.control import save_controller
from dehyst_robot.experiments._equipment import Equipment
from dehyst_robot.experiments._results import (
    BAR,
    JointIdentification,
    PlantResult,
    Reproduction,
    TrialRun,
)
from dehyst_robot.iso9283 import Timed, Timing, iso9283, tracking_figures


def joint_figures(run: TrialRun, number: int) -> dict[str, float]:
    """Root mean square and largest error of a joint over a run. [deg]"""
    # Over all cycles, the first one included.
    error = np.degrees(run.error[:, number - 1])
    return {"rms_deg": float(np.sqrt(np.mean(error**2))), "max_deg": float(np.abs(error).max())}


def plant_figures(
    identifications: Mapping[str, Mapping[int, JointIdentification]],
    runs: Iterable[TrialRun],
    motions: Mapping[str, Timing],
    joints: Iterable[int],
) -> dict[str, Any]:
    """Everything measured on one plant with one seed.

    `identifications`: compensator -> joint number -> identification; the last one is the one that is explained. Trials
    that `motions` has not have no figures of the tool.
    """
    figures = trial_figures(runs, motions, joints)
    for number in joints:
        by_name: dict[str, Any] = {}
        explained: dict[str, Any] = {}
        for name, of_joint in identifications.items():
            by_name[name] = explained = _identification(of_joint[number])
        trials = figures["joints"][str(number)]
        figures["joints"][str(number)] = {
            "identification": explained,
            "identifications": by_name,
            **trials,
        }
    return figures


def trial_figures(
    runs: Iterable[TrialRun], motions: Mapping[str, Timing], joints: Iterable[int]
) -> dict[str, Any]:
    """Errors of joints and tool in all runs; parameters as for `plant_figures`."""
    of_joints: dict[str, Any] = {str(number): {"trials": {}} for number in joints}
    tool: dict[str, Any] = {}
    for run in runs:
        for number, of_joint in of_joints.items():
            sides = of_joint["trials"].setdefault(run.trial, {})
            sides[run.compensator] = joint_figures(run, int(number))
        motion = motions.get(run.trial)
        # With joints locked the tool goes elsewhere.
        if motion is None:
            continue
        # The norm's figures need a path with a speed of its own.
        if isinstance(motion, Timed):
            figures = iso9283(motion, run.time, run.tool, run.cycle, run.figure)
        else:
            figures = tracking_figures(run.tool_desired, run.tool)
        tool.setdefault(run.trial, {})[run.compensator] = figures
    return {"joints": of_joints, "tool": tool}


def _identification(identified: JointIdentification) -> dict[str, Any]:
    return {
        "nonzero_weights": identified.nonzero_weights,
        "inverse_rms_ratio_unseen": identified.inverse_rms_ratio,
        "unexplained_unseen": identified.unexplained,
        "accepted": identified.accepted,
        "calibration_residual_Nm": identified.characteristic.residual,
    }


FORMAT = "dehyst-reproduction"


def mean_figures(result: PlantResult) -> dict[str, Any]:
    """Return the figures of a plant, each the mean over its seeds; None where no seed gave a number."""
    mean: dict[str, Any] = _mean(list(result.figures.values()))
    return mean


def as_json(result: Reproduction) -> dict[str, Any]:
    """Return what ``dehyst reproduce --json`` writes.

    ``plants``: plant -> ``joints`` and ``tool`` (means over the seeds), ``seeds`` (the same for each) and ``remarks``;
    ``alone``: the same of the first joint alone; ``real_time_factor``: the slowest plant's; ``settings``, ``studies``.
    """
    return {
        "format": FORMAT,
        "plants": _plants_as_json(result.plants),
        "alone": _plants_as_json(result.alone),
        "real_time_factor": min(plant.real_time_factor for plant in result.plants.values()),
        "compensator": result.compensator,
        "compensators": list(result.compensators),
        "settings": _plain(result.settings),
        "studies": _plain(result.studies),
    }


def _plants_as_json(plants: Mapping[str, PlantResult]) -> dict[str, Any]:
    figures = {}
    for name, plant in plants.items():
        figures[name] = {
            **mean_figures(plant),
            "seeds": _plain(plant.figures),
            "remarks": list(plant.remarks),
        }
    return figures


def _mean(values: Sequence[Any]) -> Any:
    """Mean over seeds of numbers, of each entry of tables; of words the first."""
    present = [value for value in values if value is not None]
    if not present:
        return None
    first = present[0]
    if isinstance(first, Mapping):
        # A reason why a figure is missing may be one seed's alone.
        # Joined, in the order of the first seed.
        keys = dict.fromkeys(itertools.chain(*present))
        means = {}
        for key in keys:
            means[key] = _mean([value.get(key) for value in present])
        return means
    if isinstance(first, bool | np.bool_):
        return bool(all(present))
    numbers, counts = [], True
    for value in present:
        counts = counts and isinstance(value, int)
        if isinstance(value, int | float | np.number) and np.isfinite(float(value)):
            numbers.append(float(value))
    if not numbers:
        return _plain(first)
    mean = float(np.mean(numbers))
    # Counts that are the same in all seeds stay whole numbers.
    if counts and mean == round(mean):
        return round(mean)
    return mean


def _plain(value: Any) -> Any:
    """Values as JSON knows them: no arrays, no NaN."""
    if isinstance(value, Mapping):
        return {str(key): _plain(inner) for key, inner in value.items()}
    if isinstance(value, np.ndarray | list | tuple):
        return list(map(_plain, value))
    if isinstance(value, bool | np.bool_):
        return bool(value)
    if isinstance(value, np.integer):
        return int(value)
    if isinstance(value, float | np.floating):
        if not np.isfinite(value):
            return None
        return float(value)
    return value


MOST_ROWS = 4000  # of a log: its rows are 20 to 80 ms apart


def trial_columns(run: TrialRun) -> Mapping[str, Array]:
    """Columns of a run's log, with their units: what a rig would have logged, and the tool."""
    columns: dict[str, Array] = {}
    for i in range(run.desired.shape[1]):
        joint = f"joint{i + 1}"
        columns[f"{joint}_desired_deg"] = np.degrees(run.desired[:, i])
        columns[f"{joint}_angle_deg"] = np.degrees(run.angle[:, i])
        # An electric joint has no pressures.
        if not run.pressure[:, i].any():
            continue
        difference = run.pressure_difference[:, i] / BAR
        columns[f"{joint}_pressure_1_bar"] = run.pressure[:, i, 0] / BAR
        columns[f"{joint}_pressure_2_bar"] = run.pressure[:, i, 1] / BAR
        columns[f"{joint}_pressure_difference_desired_bar"] = difference
        columns[f"{joint}_compensation_bar"] = run.compensation[:, i] / BAR
        columns[f"{joint}_integrator_Nm"] = run.integrator[:, i]
        columns[f"{joint}_torque_error_Nm"] = run.torque_error[:, i]
        # A locked joint has no observer.
        if not run.scale[:, i].any():
            continue
        columns[f"{joint}_contact_Nm"] = run.contact[:, i]
        columns[f"{joint}_doubt_Nm"] = run.doubt[:, i]
        columns[f"{joint}_offset_Nm"] = run.offset[:, i]
        columns[f"{joint}_hysteresis_of_model"] = run.hysteresis[:, i]
        columns[f"{joint}_scale"] = run.scale[:, i]
        for g in range(run.scales.shape[2]):
            columns[f"{joint}_scale_{g + 1}"] = run.scales[:, i, g]
    for axis, name in enumerate("xyz"):
        columns[f"tool_desired_{name}_m"] = run.tool_desired[:, axis]
        columns[f"tool_{name}_m"] = run.tool[:, axis]
    columns["figure"] = run.figure.astype(np.float64)
    columns["cycle"] = run.cycle.astype(np.float64)
    return columns


def _channels(
    time: Array, columns: Mapping[str, Array]
) -> dict[str, tuple[Array, Mapping[str, Array]]]:
    """One topic a joint, one for the tool, one for the place on the path; fields without the topic's name."""
    channels: dict[str, dict[str, Array]] = {}
    for name, values in columns.items():
        topic, field = "path", name
        if name.startswith(("joint", "tool")):
            topic, _, field = name.partition("_")
        channels.setdefault(topic, {})[field] = values
    return {topic: (time, fields) for topic, fields in channels.items()}


def log_folder(folder: Path, plant: str, seed: int, beside: str = "") -> Path:
    """Make the folder for the logs of a plant and seed, in it `beside` for those of another controller."""
    place = folder / plant / f"seed{seed}" / beside
    try:
        place.mkdir(parents=True, exist_ok=True)
    except OSError as fault:
        raise OutputError(
            f"cannot make the folder '{place}' for the logs: {fault.strerror}. Name another one.",
            path=str(place),
        ) from None
    return place


def write_units(
    equipment: Equipment,
    identified: Mapping[int, JointIdentification],
    folder: Path,
    compensator: str = "paper",
) -> list[Path]:
    """Write model and controller of each compensated joint, for `dehyst export --what joint-controller`.

    The name of the compensator ends those of the files; the paper's have none.
    """
    written = []
    end = f"_{compensator}"
    if compensator == "paper":
        end = ""
    for number in equipment.compensators:
        model = identified[number].model
        written.append(model.save(folder / f"model_joint{number}{end}.json"))
        controller = folder / f"controller_joint{number}{end}.json"
        written.append(save_controller(equipment.controllers[number], controller, model=model))
    return written


def log_names(run: TrialRun) -> str:
    """Beginning of the names of a run's log files."""
    return f"{run.trial}_{run.compensator}"


def write_trial(run: TrialRun, folder: Path, mcap: bool = True) -> list[Path]:
    """Write a run's log, every n-th row so that there are `MOST_ROWS` at most; its name tells trial and compensator."""
    # A log of every sample would be too large to look at.
    thin = slice(None, None, -(-run.time.size // MOST_ROWS))
    time = run.time[thin]
    columns = {name: values[thin] for name, values in trial_columns(run).items()}
    stem = folder / log_names(run)
    written = [write_csv(stem.with_suffix(".csv"), {"time_s": time, **columns})]
    if mcap:
        written.append(write_mcap(stem.with_suffix(".mcap"), _channels(time, columns)))
    return written
