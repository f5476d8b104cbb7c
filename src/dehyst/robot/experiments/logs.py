"""Writes logs of the trials to disk: a CSV and an MCAP file per run."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from dehyst.arrays import Array
from dehyst.control import save_controller
from dehyst.errors import OutputError
from dehyst.io import write_csv, write_mcap
from dehyst.robot.experiments.loops_run import BAR
from dehyst.robot.experiments.results import JointIdentification, TrialRun
from dehyst.robot.experiments.trials import Equipment

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
