"""dehyst reproduce: the paper's experiment, its report, logs and figures."""

from __future__ import annotations

import json
import warnings
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TaskID, TextColumn, TimeElapsedColumn
from rich.table import Column

from dehyst.app.targets import PAGE, REPRODUCTION, refuse_existing, refuse_unwritable
from dehyst.app.terminal import progress_bar, table, tell, terminal
from dehyst.errors import ParameterError
from dehyst.files import write_atomically
from dehyst.robot.arm.parameters import Robot, changes_from_packaged, load_robot
from dehyst.robot.commands.requests import ReproduceRequest
from dehyst.robot.control import FLAGS
from dehyst.robot.control.reviewed import PAPER
from dehyst.robot.experiments.output import as_json, log_folder, log_names, mean_figures
from dehyst.robot.experiments.reproduce import PLANTS, Request, reproduce
from dehyst.robot.experiments.results import Reproduction
from dehyst.robot.report import write_reproduction_report
from dehyst.robot.report.words import WHY, grown, run_on
from dehyst.shell import command

MOST_REMARKS = 12  # on the terminal
LONG = 0.2  # share of a trial at a limit that is worth a warning
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


def run_reproduce(request: ReproduceRequest) -> None:
    """Run, write everything, print what came out."""
    page, figures_file = request.out / "report.html", request.out / "figures.json"
    refuse_existing(page, request.overwrite, own=PAGE)
    for path in filter(None, (figures_file, request.json)):
        refuse_existing(path, request.overwrite, own=REPRODUCTION)
    for folder in filter(None, (request.out / "logs", request.figures)):
        refuse_unwritable(folder, folder=True)
    if request.json is not None and request.json.parent != request.out:
        refuse_unwritable(request.json)
    robot, experiment = _robot(request), _experiment(request)
    file = {} if request.robot is None else {"robot_file": request.robot.name}
    with _shown_progress() as progress, warnings.catch_warnings():
        warnings.filterwarnings("ignore", r"\w+ trial, compensator ")  # said below, with plant and seed
        result = reproduce(robot, experiment, request.out / "logs", progress)
        result = replace(result, settings={**file, **result.settings, "command": _line(request)})
        progress.stage("report", 1)
        write_reproduction_report(result, page, figures=request.figures, logs=_logs(result, request.out))
        progress.step()
    figures = as_json(result)
    for path in filter(None, (figures_file, request.json)):
        write_atomically(path, json.dumps(figures, indent=2, allow_nan=False) + "\n")
    _print(result)
    _print_grown(result)
    _print_limits(result)
    tell(f"\nOpen {page} in a browser; logs and figures.json lie beside it.")


def _robot(request: ReproduceRequest) -> Robot:
    robot = load_robot(request.robot, conditions=request.conditions)
    said = changes_from_packaged(robot)  # what the user's file asks for is not overridden
    changes = {key: value for key, value in QUICK.items() if key not in said} if request.quick else {}
    if request.cycles is not None:
        changes |= {"path.cycles_fast": request.cycles, "path.cycles_slow": request.cycles}
    return robot.with_changes(changes)


def _experiment(request: ReproduceRequest) -> Request:
    default = ("preisach",) if request.quick else PLANTS
    plants = default if request.plant is None else PLANTS if request.plant == "all" else tuple(request.plant.split(","))
    joints = () if request.joint == "all" else tuple(_number(word) for word in request.joint.split(","))
    first = request.seed or 0
    seeds = (first,) if request.quick or request.seed is not None else (0, 1, 2)
    names = tuple(dict.fromkeys(word for words in request.compensator for word in words.split(",")))
    controllers = tuple(dict.fromkeys(request.controller.split(",")))
    return Request(plants, joints, names, seeds, studies=not request.quick, controllers=controllers,
                   reference=request.reference)  # fmt: skip


def _number(word: str) -> int:
    try:
        return int(word)
    except ValueError:
        raise ParameterError(f"--joint '{word}' is not a joint. Type a number or all; several as 1,2.") from None


def _line(request: ReproduceRequest) -> str:
    """The command of the page; of a path from the root only its end: a page that is passed on tells no more."""
    typed: dict[str, object] = {"quick": request.quick}
    for option in ("plant", "joint", "compensator", "seed", "cycles", "robot", "conditions", "reference", "out"):
        value = getattr(request, option)
        value = ",".join(value) if isinstance(value, tuple) else value
        if isinstance(value, Path) and value.is_absolute():
            value = value.name
        typed[option] = None if value == "all" and option != "plant" else value
    typed["controller"] = None if request.controller == PAPER else request.controller
    return command("reproduce", **typed)


def _logs(result: Reproduction, out: Path) -> Mapping[str, list[str]]:
    """Run -> its log files, relative to the folder of the report."""
    logs: dict[str, list[str]] = {}
    for name, plant in result.plants.items():
        for seed in plant.figures:
            folder = log_folder(out / "logs", name, seed)
            told = sorted(file.stem for file in folder.glob("*_joint*.csv"))
            for stem in (*told, *(log_names(run) for run in plant.runs)):
                files = sorted(file.relative_to(out).as_posix() for file in folder.glob(f"{stem}.*"))
                logs[f"{name}, seed {seed}, {stem}"] = files
    return logs


class _Stages:
    """A bar a stage, or where there is no terminal a line."""

    def __init__(self, bars: Progress | None) -> None:
        self._bars, self._task = bars, TaskID(0)

    def stage(self, name: str, total: int) -> None:
        if self._bars is None:
            tell(f"{name} ({total})")
        else:
            self._task = self._bars.add_task(name, total=total)

    def step(self) -> None:
        if self._bars is not None:
            self._bars.advance(self._task)


@contextmanager
def _shown_progress() -> Iterator[_Stages]:
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with progress_bar(*columns, keep=True) as bars:
        yield _Stages(bars)


def _print(result: Reproduction) -> None:
    """One table: rms error off and on, and their ratio, of every plant, joint, trial, controller and compensator."""
    names, out = result.compensators, terminal()
    controllers = result.settings.get("controllers", [])
    several = len(names) > 1
    whose = "s" if several else f" {names[0]!r}"
    trial = Column("trial", min_width=len("slow_no_integrator"))  # headings break before this does
    more = [*(["controller"] if controllers else []), *(["with"] if several else [])]
    heads: list[str | Column] = ["plant", ">joint", trial, *more]
    heads += [">off", ">on" if several else f">{names[0]}", ">ratio", ">max ratio"]
    rows = []
    for plant, found in result.plants.items():
        mean = mean_figures(found)
        for controller in controllers or [""]:
            joints = mean["controllers"][controller]["joints"] if controller else mean["joints"]
            for first, run, name in _rows(joints, names):
                off, on = run.get("off"), run.get(name)
                figures = ("lost" if one is None else f"{one['rms_deg']:.3f}" for one in (off, on))
                shares = (_share(on[key], off[key]) if on and off else "" for key in ("rms_deg", "max_deg"))
                who = [*([controller] if controllers else []), *([name] if several else [])]
                rows.append((plant, *first, *who, *figures, *shares))
    out.print(table(heads, rows, title=f"rms error in degrees without and with the compensator{whose}"))
    if on := run_on(result):
        out.print(f"on the {on}")
    for plant, found in result.plants.items():
        for name, one in found.identified.items():
            left_off = [str(n) for n, joint in one.items() if not joint.accepted]
            where = f"{plant}, {name}" if several else plant
            if left_off:
                out.print(
                    f"{where}: the model of joint {', '.join(left_off)} was not switched on: it does not explain loops "
                    f"that it was not fitted to, so there is nothing to compensate."
                )


def _rows(joints: Any, names: tuple[str, ...]) -> Iterator[tuple[tuple[str, str], Any, str]]:
    """Joint and trial, the figures of its runs, and a compensator."""
    for joint, values in joints.items():
        for trial, run in values["trials"].items():
            for name in names:
                yield (joint, trial), run, name


def _print_grown(result: Reproduction) -> None:
    """Say where a compensator costs, with its joint, trial and ratio: nobody looks for that in a table of gains."""
    said = grown(result)
    for text in said:
        terminal(stderr=True).print(f"warning: {text}")
    if said:
        terminal(stderr=True).print(f"Why: “Where it gets worse” in the report, and {WHY}.")


def _print_limits(result: Reproduction) -> None:
    """Say what joints met, and which had a valve or pressure at its limit for long: figures of a saturated loop."""
    names = FLAGS["valve-limit"], FLAGS["pressure-limit"]
    remarks = [f"warning: {plant}, {said}" for plant, found in result.plants.items() for said in found.remarks]
    more = len(remarks) - MOST_REMARKS
    for text in remarks[:MOST_REMARKS] + ([f"warning: and {more} more, in the report."] if more > 0 else []):
        terminal(stderr=True).print(text)
    for plant, found in result.plants.items():
        for run in found.runs:
            share = ((run.flags & (names[0] | names[1])) != 0).mean(axis=0)
            for index in np.flatnonzero(share > LONG):
                terminal(stderr=True).print(
                    f"warning: {plant}, {run.trial}, {run.compensator}: joint {index + 1} was at a limit of its valves "
                    f"or pressures in {100 * share[index]:.0f} % of the samples. Its loop oscillates or is overloaded; "
                    f"lower payload.mass_kg, path.fast_speed_m_s or the joint's pole_1_s."
                )


def _share(value: float, of: float) -> str:
    return f"{value / of:.2f}" if of > 0 else ""
