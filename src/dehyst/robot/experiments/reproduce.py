"""The paper's experiment on one or more plants: calibrate, identify, invert, run trials with and without."""

from __future__ import annotations

import itertools
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass, field, replace
from functools import partial
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Protocol, TypeVar

import numpy as np

from dehyst.errors import ParameterError, SimulationError
from dehyst.robot.arm.mechanisms import MechanismFactory
from dehyst.robot.arm.parameters import Robot, changes_from_packaged, conditions_of, sources
from dehyst.robot.control import Compensator, Controller
from dehyst.robot.control.reviewed import CONTROLLERS, PAPER
from dehyst.robot.experiments.calibration import calibrate
from dehyst.robot.experiments.equipment import (
    Equipment,
    backbones_of,
    equip,
    refuse_learning,
    tuned_numbers,
    under_controller,
)
from dehyst.robot.experiments.identification import identify_compensators
from dehyst.robot.experiments.output import log_folder, plant_figures, trial_figures, write_trial, write_units
from dehyst.robot.experiments.path import PlannedPath, plan_path
from dehyst.robot.experiments.recipes import NAMES, Recipe, recipe
from dehyst.robot.experiments.results import (
    TRIALS,
    Characteristic,
    JointIdentification,
    PlantResult,
    Reproduction,
    TrialRun,
)
from dehyst.robot.experiments.studies import Case as StudyCase
from dehyst.robot.experiments.studies import Table, study_jobs, study_tables
from dehyst.robot.experiments.trials import learned_trial, trial_motion
from dehyst.robot.iso9283 import Timing
from dehyst.version import __version__

ENGINES = ("mujoco", "mink", "numpy", "scipy")
PLANTS = ("maxwell-slip", "preisach", "dahl", "none")

OFF = "off"

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
        Hysteresis mechanisms of the simulated muscles, of `PLANTS` or of `foreign`.
    joints
        Joints that are identified, compensated and listed; empty: those of the robot that get a compensator.
    compensators
        Names, of `dehyst.robot.experiments.recipes.NAMES`: all are run beside "off", and the report is about the last
        one. Any one name with `own`.
    seeds
        Each repeats everything with other noise and other muscles of the same make.
    trials
        Of "fast", "slow", "slow_no_integrator".
    studies
        Whether the studies of rest and of where compensation hurts are run.
    workers
        Threads; None: one a core.
    foreign
        Plant name -> what makes hysteresis mechanisms of one's own, in Python; see `dehyst.robot.arm.mechanisms`.
    own
        Makes a compensator of one's own for a joint from what was identified on it; see
        `dehyst.robot.control.Compensator`. None: the recipe's, in the controller.
    controllers
        Of the trials, of `dehyst.robot.control.reviewed.CONTROLLERS` or `laws`: all are run, and the report is about
        the first one. Calibration and identification are the same for all.
    laws
        Name of a controller -> what makes one of one's own for a joint, by its number: a `dehyst.Controller`, one a
        run, for it has a memory, or None, which leaves the paper's in that joint.
    reference
        Log of angles that the joints shall follow, see `dehyst.robot.experiments.reference.read_moves`; None: what the
        robot's file says.

    Examples
    --------
    >>> Request(plants=("dahl",), seeds=(0,), studies=False).trials
    ('fast', 'slow', 'slow_no_integrator')
    """

    plants: tuple[str, ...] = PLANTS
    joints: tuple[int, ...] = ()
    compensators: tuple[str, ...] = ("paper",)
    seeds: tuple[int, ...] = (0, 1, 2)
    trials: tuple[str, ...] = TRIALS
    studies: bool = True
    workers: int | None = None
    foreign: Mapping[str, MechanismFactory] = field(default_factory=dict)
    own: Callable[[JointIdentification], Compensator] | None = None
    controllers: tuple[str, ...] = (PAPER,)
    laws: Mapping[str, Callable[[int], Controller | None]] = field(default_factory=dict)
    reference: Path | None = None


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
    MissingExtraError
        If mujoco or mink is not installed.

    Examples
    --------
    One trial of the whole arm on one plant, everything as short as it goes:

    >>> from tempfile import TemporaryDirectory
    >>> from dehyst.robot.arm.parameters import load_robot
    >>> short = {"mean_pressures_bar": [2.2, 3.8], "loads_bar": [-0.8, 0.8], "sweep_s": 8.0, "degree": 3}
    >>> short = {"calibration": short, "identification.loop_s": 6.0, "homing.cycles": 3, "path.cycles_fast": 1}
    >>> request = Request(plants=("dahl",), joints=(1,), seeds=(0,), trials=("fast",), studies=False)
    >>> with TemporaryDirectory() as folder:
    ...     result = reproduce(load_robot(changes=short), request, Path(folder))
    >>> found = result.plants["dahl"].figures[0]["joints"]["1"]["trials"]["fast"]
    >>> found["paper"]["rms_deg"] < 0.5 * found["off"]["rms_deg"]
    True
    """
    request = replace(request, joints=request.joints or robot.compensated)
    _check(robot, request)
    show = progress or _Silent()
    show.stage("path and its timing", 1)
    path = plan_path(robot, request.reference)
    show.step()
    cases = {
        Case(plant, seed): robot.with_changes({"hysteresis.mechanism": _built_in(plant)})
        for plant, seed in itertools.product(request.plants, request.seeds)
    }
    with ThreadPoolExecutor(request.workers or os.cpu_count() or 1) as pool:
        crew = _Crew(pool, show)
        backbones = _backbones(_calibrations(crew, cases, request), cases, request)
        found = _identifications(crew, cases, backbones, request, folder)
        kits = _equipment(cases, backbones, found, request)
        for (case, name), kit in kits.items():
            write_units(kit, found[case, name], log_folder(folder, case.plant, case.seed), name)
        runs = {name: _trials(crew, cases, kits, found, path, request, folder, name) for name in request.controllers}
        studies = _studies(crew, cases, kits, found, path, request)
    motions = {trial: trial_motion(robot, path, trial) for trial in request.trials}
    return Reproduction(
        plants={plant: _plant_result(plant, request, found, runs, motions, robot) for plant in request.plants},
        compensator=request.compensators[-1],
        settings=_settings(robot, request),
        studies=studies,
        compensators=request.compensators,
    )


@dataclass(frozen=True, order=True)
class Case:
    """One plant with one seed."""

    plant: str
    seed: int


Backbones = Mapping[tuple[Case, str], Mapping[int, Characteristic]]
Identified = Mapping[tuple[Case, str], Mapping[int, JointIdentification]]
Kits = Mapping[tuple[Case, str], Equipment]


@dataclass(frozen=True)
class Lost:
    """A trial that ended early: a joint left its range, or a controller failed safe."""

    trial: str
    compensator: str
    fault: SimulationError


@dataclass(frozen=True)
class _Crew:
    """Runs independent jobs on threads: the simulation does not hold Python's lock."""

    pool: ThreadPoolExecutor
    show: Progress

    def do(self, stage: str, jobs: Mapping[Key, Callable[[], Value]]) -> dict[Key, Value]:
        """Return what the jobs return, in their order; the first fault stops the rest."""
        self.show.stage(stage, len(jobs))
        futures = {self.pool.submit(job): key for key, job in jobs.items()}
        found: dict[Key, Value] = {}
        try:
            for future in as_completed(futures):
                found[futures[future]] = future.result()
                self.show.step()
        finally:
            for future in futures:
                future.cancel()
        return {key: found[key] for key in jobs}


def _built_in(plant: str) -> str:
    """The robot's own mechanism under a foreign one is none."""
    return plant if plant in PLANTS else "none"


def _recipe(request: Request, name: str) -> Recipe:
    """One's own compensator is made from what is identified for the paper's."""
    return recipe("paper" if request.own else name)


def _calibrations(crew: _Crew, cases: Mapping[Case, Robot], request: Request) -> dict[Case, dict[int, Characteristic]]:
    jobs = {
        (case, n): partial(calibrate, robot, n, seed=case.seed, mechanisms=request.foreign.get(case.plant))
        for case, robot in cases.items()
        for n in robot.pneumatic
    }
    found = crew.do("calibration sweeps", jobs)
    return {case: {n: found[case, n] for n in robot.pneumatic} for case, robot in cases.items()}


def _backbones(
    calibrated: Mapping[Case, Mapping[int, Characteristic]], cases: Mapping[Case, Robot], request: Request
) -> Backbones:
    return {
        (case, name): backbones_of(robot, calibrated[case], _recipe(request, name))
        for case, robot in cases.items()
        for name in request.compensators
    }


def _identifications(
    crew: _Crew, cases: Mapping[Case, Robot], backbones: Backbones, request: Request, folder: Path
) -> Identified:
    """A job a joint: its compensators share logs."""
    recipes = {name: _recipe(request, name) for name in request.compensators}
    jobs = {
        (case, n): partial(
            identify_compensators,
            robot,
            n,
            {name: (one, backbones[case, name][n]) for name, one in recipes.items()},
            log_folder(folder, case.plant, case.seed),
            seed=case.seed,
            mechanisms=request.foreign.get(case.plant),
        )
        for case, robot in cases.items()
        for n in request.joints
    }
    found = crew.do("identification", jobs)
    return {
        (case, name): {n: found[case, n][name] for n in request.joints}
        for case in cases
        for name in request.compensators
    }


def _equipment(cases: Mapping[Case, Robot], backbones: Backbones, found: Identified, request: Request) -> Kits:
    return {
        (case, name): equip(
            robot.with_changes(_recipe(request, name).changes),
            backbones[case, name],
            {} if request.own else found[case, name],
            case.seed,
            request.foreign.get(case.plant),
            adaptive=_recipe(request, name).adaptive,
        )
        for case, robot in cases.items()
        for name in request.compensators
    }


def _trials(
    crew: _Crew,
    cases: Mapping[Case, Robot],
    kits: Kits,
    identified: Identified,
    path: PlannedPath,
    request: Request,
    folder: Path,
    controller: str,
) -> dict[Case, list[tuple[TrialRun, float] | Lost]]:
    mcap = find_spec("rosbags") is not None
    without = _without(request)
    beside = "" if controller == request.controllers[0] else controller  # folder of the logs of another controller

    def run(case: Case, robot: Robot, trial: str, name: str) -> tuple[TrialRun, float] | Lost:
        kit = kits[case, without if name == OFF else name]
        if request.own is not None:  # one a run: it has a memory
            own = {n: request.own(one) for n, one in identified[case, request.compensators[0]].items()}
            kit = replace(kit, own=own)
        passes = 0 if name == OFF else _recipe(request, name).passes
        if make := request.laws.get(controller):
            made = {n: make(n) for n in robot.pneumatic}
            used, kit = robot, replace(kit, laws={n: one for n, one in made.items() if one is not None})
        else:
            used, kit = under_controller(robot, kit, controller)
        try:
            found, speed = learned_trial(used, path, kit, trial, name, passes=passes)
        except SimulationError as fault:  # the others may hold
            return Lost(trial, name, fault)
        write_trial(found, log_folder(folder, case.plant, case.seed, beside), mcap)  # while another thread simulates
        return found, speed

    names = (OFF, *request.compensators)
    jobs = {
        (case, trial, name): partial(run, case, robot, trial, name)
        for case, robot in cases.items()
        for trial in request.trials
        for name in names
    }
    found = crew.do("trials" if request.controllers == (PAPER,) else f"trials, {controller}", jobs)
    lost = [one for one in found.values() if isinstance(one, Lost)]
    if len(lost) == len(found):
        raise lost[0].fault
    return {case: [found[case, t, name] for t in request.trials for name in names] for case in cases}


def _without(request: Request) -> str:
    """The compensator whose controllers run without it: one on the calibrated characteristic, if there is one."""
    plain = (name for name in request.compensators if not _recipe(request, name).local)
    return next(plain, request.compensators[0])


def _studies(
    crew: _Crew, cases: Mapping[Case, Robot], kits: Kits, found: Identified, path: PlannedPath, request: Request
) -> dict[str, Table]:
    """Of the last compensator on the first plant with hysteresis that is built in; the studies change its size.

    They are about the paper's controller: where the report is not, there are none.
    """
    name, joint = request.compensators[-1], request.joints[0]
    fit = (case for case in cases if found[case, name][joint].accepted and case.plant in PLANTS)
    studied = next(fit, None)
    if not request.studies or request.own or studied is None or request.controllers[0] != PAPER:
        return {}
    robot = cases[studied].with_changes(_recipe(request, name).changes)
    return study_tables(crew.do("studies", study_jobs(StudyCase(robot, path, kits[studied, name], joint))))


def _plant_result(
    plant: str,
    request: Request,
    found: Identified,
    under: Mapping[str, Mapping[Case, list[tuple[TrialRun, float] | Lost]]],
    motions: Mapping[str, Timing],
    robot: Robot,
) -> PlantResult:
    cases = {seed: Case(plant, seed) for seed in request.seeds}
    first = cases[request.seeds[0]]
    done = {
        name: {case: [one for one in of[case] if not isinstance(one, Lost)] for case in cases.values()}
        for name, of in under.items()
    }
    runs = done[request.controllers[0]]
    return PlantResult(
        plant=plant,
        identifications=found[first, request.compensators[-1]],
        runs=tuple(run for run, _ in runs[first]),
        figures={
            seed: plant_figures(
                {name: found[case, name] for name in request.compensators},
                [run for run, _ in runs[case]],
                motions,
                request.joints,
            )
            | _controllers(request, {name: [run for run, _ in one[case]] for name, one in done.items()}, motions)
            for seed, case in cases.items()
        },
        real_time_factor=float(np.median([factor for of in runs.values() for _, factor in of] or [0.0])),
        identified={name: found[first, name] for name in request.compensators},
        remarks=tuple(
            f"{'' if len(under) == 1 else f'{name}, '}{said}"
            for name, of in under.items()
            for seed, case in cases.items()
            for said in _remarks(robot, of[case], seed)
        ),
    )


def _remarks(robot: Robot, runs: Sequence[tuple[TrialRun, float] | Lost], seed: int) -> Iterator[str]:
    """What joints met in the trials of a seed: trials that ended early, ranges left, models that do not fit."""
    for one in runs:
        if isinstance(one, Lost):
            yield f"seed {seed}, {one.trial}, {one.compensator}: lost, {one.fault}"
            continue
        run = one[0]
        where = f"seed {seed}, {run.trial}, {run.compensator}: "
        for k, (number, joint) in enumerate(robot.joints.items()):
            reached, allowed = np.degrees(np.abs(run.angle[:, k]).max()), np.degrees(joint.range)
            if reached > allowed:
                yield f"{where}joint {number} went to {reached:.1f} deg, beyond its range of {allowed:.3g} deg."
        yield from (f"{where}{text}" for text in run.warnings)


def _controllers(request: Request, runs: Mapping[str, list[TrialRun]], motions: Mapping[str, Timing]) -> dict[str, Any]:
    """Figures by controller, where another one than the paper's was asked for."""
    if request.controllers == (PAPER,):
        return {}
    return {
        "controllers": {
            name: ({} if name in request.laws else {"tuned": tuned_numbers(name)})
            | trial_figures(one, motions, request.joints)
            for name, one in runs.items()
        }
    }


def _settings(robot: Robot, request: Request) -> dict[str, Any]:
    """What was set; a change that a recipe makes is told where it is the only compensator."""
    alone = len(request.compensators) == 1
    used = robot.with_changes(_recipe(request, request.compensators[0]).changes if alone else {})
    return {
        "robot": used.name,
        "conditions": conditions_of(used),
        "parameters": used.values,
        "sources": sources(),
        "changes": changes_from_packaged(used),
        "versions": {"dehyst": __version__} | {name: version(name) for name in ENGINES},
        "fingerprint": used.fingerprint,
        "plants": list(request.plants),
        "joints": list(request.joints),
        "compensator": request.compensators[-1],
        "compensators": list(request.compensators),
        "seeds": list(request.seeds),
        "trials": list(request.trials),
        **({} if request.controllers == (PAPER,) else {"controllers": list(request.controllers)}),
    }


def _check(robot: Robot, request: Request) -> None:
    for what, values, known in (
        ("plant", request.plants, (*PLANTS, *request.foreign)),
        ("joint", request.joints, robot.compensator.joints or tuple(robot.joints)),
        ("trial", request.trials, TRIALS),
    ):
        unknown = [value for value in values if value not in known]
        if unknown or not values:
            raise ParameterError(
                f"no {what} {unknown[0] if unknown else 'was named'}. There are: {', '.join(map(str, known))}.",
                unknown=unknown,
            )
    electric = [number for number in request.joints if number not in robot.pneumatic]
    if electric:
        raise ParameterError(
            f"joint {electric[0]} of this robot is electric: no muscle, no hysteresis, nothing to compensate. Name "
            f"joints with muscles, e.g. joints={robot.compensated}, or change "
            f"joint.{electric[0]}.drive.",
            joint=electric[0],
        )
    unused = [name for name in request.foreign if name not in request.plants]
    if unused:
        raise ParameterError(
            f"the mechanism '{unused[0]}' of `foreign` is in none of the plants {request.plants}: it would not be run. "
            f"Type plants=('{unused[0]}',), or plants=(*PLANTS, '{unused[0]}').",
            unused=unused,
        )
    _check_names(request)
    _check_controllers(request)
    if not request.seeds or any(not isinstance(seed, int) or not 0 <= seed < 2**32 for seed in request.seeds):
        raise ParameterError(f"seeds {request.seeds} are not whole numbers from 0 to 2**32 - 1; pass at least one.")


def _check_names(request: Request) -> None:
    names = request.compensators
    if isinstance(names, str) or not names or len(set(names)) < len(names):
        raise ParameterError(
            f"compensators {names!r} are not names, each once; pass a tuple such as compensators=('paper', 'best')."
        )
    if request.own is None:
        for name in names:
            recipe(name)
        return
    if len(names) > 1 or names[0] in (OFF, *NAMES):
        raise ParameterError(
            f"a compensator of one's own cannot be called '{', '.join(names)}': figures and logs would not tell it "
            f"from those of that name. Type compensators=('mine',)."
        )


def _check_controllers(request: Request) -> None:
    names = request.controllers
    if isinstance(names, str) or not names or len(set(names)) < len(names):
        raise ParameterError(
            f"controllers {names!r} are not names, each once; pass a tuple such as controllers=('paper', 'pid')."
        )
    unused = [name for name in request.laws if name in CONTROLLERS or name not in names]
    if unused:
        raise ParameterError(
            f"the controller '{unused[0]}' of `laws` is not among the controllers {names}, or has the name of one that "
            f"is built in: it would not be run. Type controllers=('paper', 'mine'), laws={{'mine': ...}}.",
            name=unused[0],
        )
    wrong = [name for name, make in request.laws.items() if not callable(make)]
    if wrong:
        raise ParameterError(
            f"laws['{wrong[0]}'] is a {type(request.laws[wrong[0]]).__name__}, and each joint and run needs a "
            f"controller of its own. Pass what makes one: laws={{'{wrong[0]}': lambda joint: MyController()}}.",
            name=wrong[0],
        )
    for name in names:
        if name not in (*CONTROLLERS, *request.laws):
            raise ParameterError(f"no controller '{name}'. There are: {', '.join(CONTROLLERS)}.", name=name)
        for compensator in request.compensators:
            refuse_learning(name, compensator, _recipe(request, compensator).passes)
