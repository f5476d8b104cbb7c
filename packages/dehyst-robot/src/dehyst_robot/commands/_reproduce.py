"""dehyst reproduce: the paper's experiment, its report, logs and figures."""

from __future__ import annotations

import json
import warnings
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    TaskID,
    TextColumn,
    TimeElapsedColumn,
)
from rich.table import Column, Table

from dehyst.app import PAGE, progress_bar, refuse_existing, refuse_unwritable, table, tell
from dehyst.app import kit as app_kit
from dehyst.errors import ParameterError
from dehyst.files import write_atomically
from dehyst.shell import command
from dehyst_robot.arm import Robot, changes_from_packaged, load_robot
from dehyst_robot.arm import kit as arm_kit
from dehyst_robot.commands._policy import POLICY
from dehyst_robot.commands._requests import ReproduceRequest
from dehyst_robot.control import FLAGS
from dehyst_robot.control import kit as control_kit
from dehyst_robot.experiments import PlantResult, Reproduction, Request, reproduce
from dehyst_robot.experiments import kit as experiments_kit
from dehyst_robot.report import WHY, grown, run_on, write_reproduction_report

MOST_REMARKS = 12  # on the terminal
QUICK: dict[str, object] = {
    "calibration.mean_pressures_bar": [2.2, 3.8],
    "calibration.loads_bar": [-0.8, 0.8],
    "calibration.sweep_s": 14.0,
    "identification.loop_s": 12.0,
    "homing.cycles": 6,
    "path.cycles_fast": 2,
    "path.slow_factor": 4.0,
}
"""What ``--quick`` changes where the user's file does not: less of everything, nothing of the plant."""

# What else may be typed with --as-printed: what it sets anyway.
AS_PRINTED: dict[str, tuple[object, ...]] = {
    "compensator": ((), ("printed",)),
    "joint": (None, "1"),
    "controller": (control_kit.PAPER,),
}


def run_reproduce(request: ReproduceRequest) -> None:
    """Run, write everything, print what came out."""
    _refuse_contradictions(request)
    page = request.out / "report.html"
    figures_files = [request.out / "figures.json"]
    if request.json is not None:
        figures_files.append(request.json)
    # Everything that will be written is tried now: a run may take an hour.
    refuse_existing(page, request.overwrite, own=PAGE)
    for path in figures_files:
        refuse_existing(path, request.overwrite, own=app_kit.REPRODUCTION)
    refuse_unwritable(request.out / "logs", folder=True)
    if request.figures is not None:
        refuse_unwritable(request.figures, folder=True)
    if request.json is not None and request.json.parent != request.out:
        refuse_unwritable(request.json)
    robot, experiment = _robot(request), _experiment(request)
    settings: dict[str, Any] = {}
    if request.robot is not None:
        settings["robot_file"] = request.robot.name
    with _shown_progress() as progress, warnings.catch_warnings():
        # These are said below, with plant and seed.
        warnings.filterwarnings("ignore", r"\w+ trial, compensator ")
        result = reproduce(robot, experiment, request.out / "logs", progress)
        settings |= {**result.settings, "command": _line(request)}
        result = replace(result, settings=settings)
        progress.stage("report", 1)
        logs = _logs(result, request.out)
        write_reproduction_report(result, page, figures=request.figures, logs=logs)
        progress.step()
    figures = json.dumps(experiments_kit.as_json(result), indent=2, allow_nan=False)
    for path in figures_files:
        write_atomically(path, figures + "\n")
    _print(result)
    _print_grown(result)
    _print_remarks(result)
    _print_limits(result)
    tell(f"\nOpen {page} in a browser; logs and figures.json lie beside it.")


def _refuse_contradictions(request: ReproduceRequest) -> None:
    """Refuse options that ask for something else than ``--as-printed`` does."""
    if not request.as_printed:
        return
    for name, allowed in AS_PRINTED.items():
        value = getattr(request, name)
        if value in allowed:
            continue
        if isinstance(value, tuple):
            value = ",".join(value)
        raise ParameterError(
            f"--as-printed is the paper's controller with the compensator 'printed' in joint 1 alone, and "
            f"--{name} {value} asks for something else. Leave --{name} out; or leave --as-printed out and type what "
            f"you want of it, as in --compensator printed --joint 2.",
            option=name,
        )


def _robot(request: ReproduceRequest) -> Robot:
    robot = load_robot(request.robot, conditions=request.conditions)
    changes = {}
    if request.quick:
        # What the user's file asks for is not overridden.
        asked = changes_from_packaged(robot)
        changes = {key: value for key, value in QUICK.items() if key not in asked}
    if request.cycles is not None:
        changes |= {"path.cycles_fast": request.cycles, "path.cycles_slow": request.cycles}
    robot = robot.with_changes(changes)
    if request.as_printed:
        robot = robot.with_changes(_at_three_bar(robot))
    return robot


def _at_three_bar(robot: Robot) -> dict[str, object]:
    """The mean pressure of the paper's local calibration, and besides the file's own sweeps one there without load."""
    calibration = robot.values["calibration"]
    return {
        "controller.mean_pressure_bar": 3.0,
        "calibration.mean_pressures_bar": sorted({*calibration["mean_pressures_bar"], 3.0}),
        "calibration.loads_bar": sorted({*calibration["loads_bar"], 0.0}),
    }


def _experiment(request: ReproduceRequest) -> Request:
    plants: tuple[str, ...] = arm_kit.PLANTS
    if request.plant is None and request.quick:
        plants = ("preisach",)
    elif request.plant not in (None, "all"):
        plants = tuple(str(request.plant).split(","))
    alone: tuple[str, ...] = ()
    if request.alone:
        alone = _words([request.alone])
    joints: tuple[int, ...] = ()
    if request.joint not in (None, "all"):
        joints = tuple(map(_number, str(request.joint).split(",")))
    compensators = _words(request.compensator or ("paper",))
    if request.as_printed:
        joints, compensators = (1,), ("printed",)
    # Three seeds show how much of a figure is chance.
    seeds: tuple[int, ...] = (0, 1, 2)
    if request.quick or request.seed is not None:
        seeds = (request.seed or 0,)
    return Request(
        plants,
        joints,
        compensators,
        seeds,
        studies=not request.quick and not request.as_printed,
        controllers=_words([request.controller]),
        reference=request.reference,
        alone=alone,
    )


def _words(texts: Iterable[str]) -> tuple[str, ...]:
    """Names of lists with commas, each once."""
    return tuple(dict.fromkeys(",".join(texts).split(",")))


def _number(word: str) -> int:
    try:
        return int(word)
    except ValueError:
        raise ParameterError(
            f"--joint '{word}' is not a joint. Type a number or all; several as 1,2."
        ) from None


def _line(request: ReproduceRequest) -> str:
    """The command of the page; of a path from the root only its end: a page that is passed on tells no more."""
    typed: dict[str, object] = {
        "quick": request.quick,
        "as_printed": request.as_printed,
        "plant": request.plant,
        "alone": request.alone,
    }
    for option in (
        "joint",
        "compensator",
        "seed",
        "cycles",
        "robot",
        "conditions",
        "reference",
        "out",
    ):
        value = getattr(request, option)
        if isinstance(value, tuple):
            value = ",".join(value)
        if isinstance(value, Path) and value.is_absolute():
            # A path may hold the name of a person or of a customer.
            value = value.name
        # Nothing is typed for what runs without the option.
        if value in ("all", ""):
            value = None
        typed[option] = value
    typed["controller"] = None
    if request.controller != control_kit.PAPER:
        typed["controller"] = request.controller
    return command("reproduce", **typed)


def _logs(result: Reproduction, out: Path) -> Mapping[str, list[str]]:
    """Run -> its log files, relative to the folder of the report."""
    logs: dict[str, list[str]] = {}
    places = dict.fromkeys(result.plants, out / "logs")
    places |= {f"{name} alone": out / "logs" / experiments_kit.ALONE for name in result.alone}
    for name, plant in result.everything.items():
        for seed in plant.figures:
            folder = experiments_kit.log_folder(places[name], plant.plant, seed)
            stems = sorted(file.stem for file in folder.glob("*_joint*.csv"))
            # Logs of the identification come first, as they were made first.
            if name in result.plants:
                stems += map(experiments_kit.log_names, plant.runs)
            for stem in stems:
                files = [file.relative_to(out).as_posix() for file in folder.glob(f"{stem}.*")]
                logs[f"{name}, seed {seed}, {stem}"] = sorted(files)
    return logs


class _Stages:
    """A bar a stage, or where there is no terminal a line."""

    def __init__(self, bars: Progress | None) -> None:
        self._bars, self._task = bars, TaskID(0)

    def stage(self, name: str, total: int) -> None:
        # A log file shall hold no escape sequences.
        if self._bars is None:
            tell(f"{name} ({total})")
        else:
            self._task = self._bars.add_task(name, total=total)

    def step(self) -> None:
        if self._bars is not None:
            self._bars.advance(self._task)


@contextmanager
def _shown_progress() -> Iterator[_Stages]:
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
    )
    with progress_bar(*columns, keep=True) as bars:
        yield _Stages(bars)


def _print(result: Reproduction) -> None:
    """Print tables of errors, what they are of, and which compensators stayed off."""
    out = app_kit.terminal()
    out.print(_table(result, result.plants, "rms error in degrees"))
    if result.alone:
        joint = min(result.settings["joints"])
        title = f"joint {joint} alone, the others locked: rms error in degrees"
        out.print(_table(result, result.alone, title))
    on = run_on(result)
    if on:
        out.print(f"on the {on}")
    _print_left_off(result)


def _table(result: Reproduction, plants: Mapping[str, PlantResult], title: str) -> Table:
    """Rms error off and on, and their ratio, of every plant, joint, trial, controller and compensator."""
    compensators = result.compensators
    controllers = result.settings.get("controllers", [])
    several = len(compensators) > 1
    # The heading of this column breaks before its names do.
    trial = Column("trial", min_width=len("slow_no_integrator"))
    heads: list[str | Column] = ["plant", ">joint", trial]
    if controllers:
        heads.append("controller")
    if several:
        heads += ["with", ">off", ">on"]
        title += " without and with the compensators"
    else:
        heads += [">off", f">{compensators[0]}"]
        title += f" without and with the compensator {compensators[0]!r}"
    heads += [">ratio", ">max ratio"]
    rows = []
    for plant, plant_result in plants.items():
        mean = experiments_kit.mean_figures(plant_result)
        for controller in controllers or [""]:
            joints = mean["joints"]
            if controller:
                joints = mean["controllers"][controller]["joints"]
            for case, run, compensator in _rows(joints, compensators):
                row = [plant, *case]
                if controller:
                    row.append(controller)
                if several:
                    row.append(compensator)
                rows.append([*row, *_figures(run.get("off"), run.get(compensator))])
    return table(heads, rows, title=title)


def _figures(off: Any, on: Any) -> list[str]:
    """Errors without and with compensator, and their ratios; a lost trial has none."""
    errors = []
    for figures in (off, on):
        if figures is None:
            errors.append("lost")
        else:
            errors.append(f"{figures['rms_deg']:.3f}")
    if not off or not on:
        return [*errors, "", ""]
    ratios = [_share(on[key], off[key]) for key in ("rms_deg", "max_deg")]
    return [*errors, *ratios]


def _print_left_off(result: Reproduction) -> None:
    """Say which models were not accepted, so that their compensators stayed off."""
    for plant, plant_result in result.everything.items():
        for name, identifications in plant_result.identified.items():
            subject = plant
            if len(result.compensators) > 1:
                subject = f"{plant}, {name}"
            joints = [str(n) for n, joint in identifications.items() if not joint.accepted]
            if joints:
                app_kit.terminal().print(
                    f"{subject}: the model of joint {', '.join(joints)} was not switched on: it does not explain loops "
                    f"that it was not fitted to, so there is nothing to compensate."
                )


def _print_remarks(result: Reproduction) -> None:
    """Say what joints met."""
    remarks = []
    for plant, plant_result in result.everything.items():
        remarks += [f"warning: {plant}, {remark}" for remark in plant_result.remarks]
    for text in remarks[:MOST_REMARKS]:
        app_kit.terminal(stderr=True).print(text)
    more = len(remarks) - MOST_REMARKS
    if more > 0:
        app_kit.terminal(stderr=True).print(f"warning: and {more} more, in the report.")


def _rows(joints: Any, names: tuple[str, ...]) -> Iterator[tuple[tuple[str, str], Any, str]]:
    """Joint and trial, the figures of its runs, and a compensator."""
    for joint, values in joints.items():
        for trial, run in values["trials"].items():
            for name in names:
                yield (joint, trial), run, name


def _print_grown(result: Reproduction) -> None:
    """Warn where a compensator increases the error, with joint, trial and ratio: a table of gains hides that."""
    # On standard error, so that a pipe of the table keeps them visible.
    sentences = grown(result)
    for sentence in sentences:
        app_kit.terminal(stderr=True).print(f"warning: {sentence}")
    if sentences:
        app_kit.terminal(stderr=True).print(f"Why: {WHY}.")


def _print_limits(result: Reproduction) -> None:
    """Say which joints had a valve or pressure at its limit for long: figures of a saturated loop."""
    limits = FLAGS["valve-limit"] | FLAGS["pressure-limit"]
    for plant, plant_result in result.everything.items():
        for run in plant_result.runs:
            # Share of the samples, joint by joint.
            share = ((run.flags & limits) != 0).mean(axis=0)
            for index in np.flatnonzero(share > POLICY.long_at_limit):
                app_kit.terminal(stderr=True).print(
                    f"warning: {plant}, {run.trial}, {run.compensator}: joint {index + 1} was at a limit of its valves "
                    f"or pressures in {100 * share[index]:.0f} % of the samples. Its loop oscillates or is overloaded; "
                    f"lower payload.mass_kg, path.fast_speed_m_s or the joint's pole_1_s."
                )


def _share(value: float, of: float) -> str:
    if of <= 0:
        return ""
    return f"{value / of:.2f}"
