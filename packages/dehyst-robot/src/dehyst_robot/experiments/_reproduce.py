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
from dehyst.version import __version__
from dehyst_robot.arm import MechanismFactory, Robot, changes_from_packaged, sources
from dehyst_robot.arm import kit as arm_kit
from dehyst_robot.control import Compensator, Controller
from dehyst_robot.control import kit as control_kit
from dehyst_robot.experiments._calibration import calibrate, home_from_zero
from dehyst_robot.experiments._equipment import (
    Equipment,
    backbones_of,
    equip,
    refuse_learning,
    tuned_numbers,
    under_controller,
)
from dehyst_robot.experiments._identification import identify_compensators
from dehyst_robot.experiments._output import (
    log_folder,
    plant_figures,
    trial_figures,
    write_trial,
    write_units,
)
from dehyst_robot.experiments._path import PlannedPath, plan_path
from dehyst_robot.experiments._recipes import NAMES, Recipe, recipe
from dehyst_robot.experiments._results import (
    TRIALS,
    Characteristic,
    JointIdentification,
    PlantResult,
    Reproduction,
    TrialRun,
)
from dehyst_robot.experiments._studies import StudyCase, Table, study_jobs, study_tables
from dehyst_robot.experiments._trials import learned_trial, trial_motion
from dehyst_robot.iso9283 import Timing

ENGINES = ("mujoco", "mink", "numpy", "scipy")
OFF = "off"
ALONE = "alone"  # folder of logs

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
        Hysteresis mechanisms of the simulated muscles, of `dehyst_robot.arm.kit.PLANTS` or of `foreign`.
    joints
        Joints that are identified, compensated and listed; empty: those of the robot that get a compensator.
    compensators
        Names, of `dehyst_robot.experiments._recipes.NAMES`: all are run beside "off", and the report is about the last
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
        Plant name -> what makes hysteresis mechanisms of one's own, in Python; see `dehyst_robot.arm._mechanisms`.
    own
        Makes a compensator of one's own for a joint from what was identified on it; see
        `dehyst_robot.control.Compensator`. None: the recipe's, in the controller.
    controllers
        Of the trials, of `dehyst_robot.control._reviewed.CONTROLLERS` or `laws`: all are run, and the report is about
        the first one. Calibration and identification are the same for all.
    laws
        Name of a controller -> what makes one of one's own for a joint, by its number: a `dehyst_robot.Controller`, one
        a run, for it has a memory, or None, which leaves the paper's in that joint.
    reference
        Log of angles that the joints shall follow, see `dehyst_robot.experiments._reference.read_moves`; None: what the
        robot's file says.
    alone
        Further plants, on which the first of the joints is calibrated, identified and run with the other joints locked,
        with the first seed: a third of the time of a plant with the whole arm. The trials are not logged.

    Examples
    --------
    >>> Request(plants=("dahl",), seeds=(0,), studies=False).trials
    ('fast', 'slow', 'slow_no_integrator')
    """

    plants: tuple[str, ...] = arm_kit.PLANTS
    joints: tuple[int, ...] = ()
    compensators: tuple[str, ...] = ("paper",)
    seeds: tuple[int, ...] = (0, 1, 2)
    trials: tuple[str, ...] = TRIALS
    studies: bool = True
    workers: int | None = None
    foreign: Mapping[str, MechanismFactory] = field(default_factory=dict)
    own: Callable[[JointIdentification], Compensator] | None = None
    controllers: tuple[str, ...] = (control_kit.PAPER,)
    laws: Mapping[str, Callable[[int], Controller | None]] = field(default_factory=dict)
    reference: Path | None = None
    alone: tuple[str, ...] = ()


def reproduce(
    robot: Robot, request: Request, folder: Path, progress: Progress | None = None
) -> Reproduction:
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
    >>> from dehyst_robot.arm import load_robot
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
    # The path is the same on all plants: they have the same nominal arm.
    path = plan_path(robot, request.reference)
    show.step()
    with ThreadPoolExecutor(request.workers or os.cpu_count() or 1) as pool:
        crew = _Crew(pool, show)
        done = _run(crew, robot, request, path, folder)
        studies = _studies(crew, done, path, request)
        # The page's headline is about the same joint.
        first = (min(request.joints),)
        of_joint = replace(request, plants=request.alone, joints=first, seeds=request.seeds[:1])
        done_alone = _Done()
        if request.alone:
            crew = replace(crew, of=f", joint {first[0]} alone")
            done_alone = _run(crew, robot, of_joint, path, folder / ALONE, first)
    # Figures are judged against the motion that was asked for; where joints are locked the tool has none.
    motions = {trial: trial_motion(robot, path, trial) for trial in request.trials}
    return Reproduction(
        plants=_plant_results(request, done, motions, robot),
        compensator=request.compensators[-1],
        settings=_settings(robot, request),
        studies=studies,
        compensators=request.compensators,
        alone=_plant_results(of_joint, done_alone, {}, robot),
    )


@dataclass(frozen=True, order=True)
class Case:
    """One plant with one seed."""

    plant: str
    seed: int


Backbones = Mapping[tuple[Case, str], Mapping[int, Characteristic]]
Identified = Mapping[tuple[Case, str], Mapping[int, JointIdentification]]
Kits = Mapping[tuple[Case, str], Equipment]
Outcomes = Mapping[str, Mapping[Case, Sequence["Outcome"]]]


@dataclass(frozen=True)
class Lost:
    """A trial that ended early: a joint left its range, or a controller failed safe."""

    trial: str
    compensator: str
    fault: SimulationError


# A run and the times that it went faster than real time, or why there is none.
Outcome = tuple[TrialRun, float] | Lost


@dataclass(frozen=True)
class _Done:
    """What was made and run: robots, equipment, models by case, and outcomes by controller and case."""

    cases: Mapping[Case, Robot] = field(default_factory=dict)
    kits: Kits = field(default_factory=dict)
    identified: Identified = field(default_factory=dict)
    runs: Outcomes = field(default_factory=dict)


@dataclass(frozen=True)
class _Crew:
    """Runs independent jobs on threads: the simulation does not hold Python's lock."""

    pool: ThreadPoolExecutor
    show: Progress
    # Behind the names of the stages.
    of: str = ""

    def do(self, stage: str, jobs: Mapping[Key, Callable[[], Value]]) -> dict[Key, Value]:
        """Return what the jobs return, in their order; the first fault stops the rest."""
        self.show.stage(f"{stage}{self.of}", len(jobs))
        futures = {self.pool.submit(job): key for key, job in jobs.items()}
        results: dict[Key, Value] = {}
        try:
            for future in as_completed(futures):
                results[futures[future]] = future.result()
                self.show.step()
        finally:
            # After a fault the jobs that wait are not begun.
            for future in futures:
                future.cancel()
        return {key: results[key] for key in jobs}


def _run(
    crew: _Crew,
    robot: Robot,
    request: Request,
    path: PlannedPath,
    folder: Path,
    moving: tuple[int, ...] | None = None,
) -> _Done:
    """Calibrate, identify and run all plants; only the joints `moving` move, None: all."""
    cases = {}
    for plant, seed in itertools.product(request.plants, request.seeds):
        changes = {"hysteresis.mechanism": _built_in(plant)}
        cases[Case(plant, seed)] = robot.with_changes(changes)
    # Calibration and identification are the same for all controllers.
    calibrated = _calibrations(crew, cases, request, moving or robot.pneumatic)
    backbones = _backbones(calibrated, cases, request)
    identified = _identifications(crew, cases, backbones, request, folder)
    kits = _equipment(cases, backbones, identified, request)
    for (case, name), kit in kits.items():
        logs = log_folder(folder, case.plant, case.seed)
        write_units(kit, identified[case, name], logs, name)
    done = _Done(cases, kits, identified)
    runs = {}
    for name in request.controllers:
        runs[name] = _trials(crew, done, path, request, folder, name, moving)
    return replace(done, runs=runs)


def _built_in(plant: str) -> str:
    """The robot's own mechanism under a foreign one is none."""
    if plant in arm_kit.PLANTS:
        return plant
    return "none"


def _recipe(request: Request, name: str) -> Recipe:
    """A compensator of the user is made from what is identified for the paper's."""
    if request.own:
        return recipe("paper")
    return recipe(name)


def _calibrations(
    crew: _Crew, cases: Mapping[Case, Robot], request: Request, joints: tuple[int, ...]
) -> dict[Case, dict[int, Characteristic]]:
    jobs = {}
    for case, robot in cases.items():
        # A plant of the user brings a mechanism of its own.
        mechanisms = request.foreign.get(case.plant)
        for n in joints:
            jobs[case, n] = partial(calibrate, robot, n, seed=case.seed, mechanisms=mechanisms)
    by_case: dict[Case, dict[int, Characteristic]] = {case: {} for case in cases}
    for (case, n), characteristic in crew.do("calibration sweeps", jobs).items():
        by_case[case][n] = characteristic
    return by_case


def _backbones(
    calibrated: Mapping[Case, Mapping[int, Characteristic]],
    cases: Mapping[Case, Robot],
    request: Request,
) -> Backbones:
    backbones = {}
    for case, robot in cases.items():
        for name in request.compensators:
            backbones[case, name] = backbones_of(robot, calibrated[case], _recipe(request, name))
    return backbones


def _identifications(
    crew: _Crew, cases: Mapping[Case, Robot], backbones: Backbones, request: Request, folder: Path
) -> Identified:
    """A job a joint: its compensators share logs."""
    jobs = {}
    for case, robot in cases.items():
        logs = log_folder(folder, case.plant, case.seed)
        for n in request.joints:
            recipes = {}
            for name in request.compensators:
                recipes[name] = (_recipe(request, name), backbones[case, name][n])
            jobs[case, n] = partial(
                identify_compensators,
                robot,
                n,
                recipes,
                logs,
                seed=case.seed,
                mechanisms=request.foreign.get(case.plant),
            )
    by_compensator: dict[tuple[Case, str], dict[int, JointIdentification]] = {}
    for (case, n), identifications in crew.do("identification", jobs).items():
        for name in request.compensators:
            by_compensator.setdefault((case, name), {})[n] = identifications[name]
    return by_compensator


def _equipment(
    cases: Mapping[Case, Robot], backbones: Backbones, identified: Identified, request: Request
) -> Kits:
    kits = {}
    for case, robot in cases.items():
        for name in request.compensators:
            used = _recipe(request, name)
            # A compensator of the user takes the place of the identified ones.
            models: Mapping[int, JointIdentification] = {}
            if not request.own:
                models = identified[case, name]
            kit = equip(
                robot.with_changes(used.changes),
                backbones[case, name],
                models,
                case.seed,
                request.foreign.get(case.plant),
                adaptive=used.adaptive,
            )
            if used.odd:
                kit = replace(kit, history=home_from_zero)
            kits[case, name] = kit
    return kits


def _trials(
    crew: _Crew,
    done: _Done,
    path: PlannedPath,
    request: Request,
    folder: Path,
    controller: str,
    moving: tuple[int, ...] | None,
) -> dict[Case, list[Outcome]]:
    # Without the package there are tables alone.
    mcap = find_spec("rosbags") is not None
    without = _without(request)
    # The logs of every controller but the first have a folder of their own.
    beside, stage = controller, f"trials, {controller}"
    if controller == request.controllers[0]:
        beside = ""
    if request.controllers == (control_kit.PAPER,):
        stage = "trials"

    def run(case: Case, robot: Robot, trial: str, name: str) -> Outcome:
        compensator, passes = name, 0
        if name == OFF:
            compensator = without
        else:
            passes = _recipe(request, name).passes
        identified = done.identified[case, request.compensators[0]]
        kit = _with_own(done.kits[case, compensator], identified, request)
        used, kit = _under(robot, kit, controller, request)
        try:
            trial_run, speed = learned_trial(
                used, path, kit, trial, name, moving=moving, passes=passes
            )
        except SimulationError as fault:
            # The other trials may hold.
            return Lost(trial, name, fault)
        # Written here, while other threads simulate; of a joint alone the figures are enough.
        if moving is None:
            write_trial(trial_run, log_folder(folder, case.plant, case.seed, beside), mcap)
        return trial_run, speed

    jobs = {}
    for case, robot in done.cases.items():
        for trial, name in itertools.product(request.trials, (OFF, *request.compensators)):
            jobs[case, trial, name] = partial(run, case, robot, trial, name)
    by_case: dict[Case, list[Outcome]] = {case: [] for case in done.cases}
    lost = []
    for (case, _, _), outcome in crew.do(stage, jobs).items():
        by_case[case].append(outcome)
        if isinstance(outcome, Lost):
            lost.append(outcome)
    # Nothing is left to report: the first fault is the answer.
    if len(lost) == len(jobs):
        raise lost[0].fault
    return by_case


def _with_own(
    kit: Equipment, identified: Mapping[int, JointIdentification], request: Request
) -> Equipment:
    """The equipment with new compensators of the user: one a run, for each has a memory."""
    if request.own is None:
        return kit
    own = {n: request.own(identification) for n, identification in identified.items()}
    return replace(kit, own=own)


def _under(
    robot: Robot, kit: Equipment, controller: str, request: Request
) -> tuple[Robot, Equipment]:
    """Robot and equipment under a controller of the literature, or of the user."""
    make = request.laws.get(controller)
    if make is None:
        return under_controller(robot, kit, controller)
    laws = {}
    for n in robot.pneumatic:
        law = make(n)
        # None leaves the paper's controller in the joint.
        if law is not None:
            laws[n] = law
    return robot, replace(kit, laws=laws)


def _without(request: Request) -> str:
    """The compensator whose controllers run without it: one on the calibrated characteristic, if there is one."""
    for name in request.compensators:
        if not _recipe(request, name).local:
            return name
    return request.compensators[0]


def _studies(crew: _Crew, done: _Done, path: PlannedPath, request: Request) -> dict[str, Table]:
    """Of the last compensator on the first plant with hysteresis that is built in; the studies change its size.

    They are about the paper's controller: where the report is not, there are none.
    """
    if not request.studies or request.own or request.controllers[0] != control_kit.PAPER:
        return {}
    name, joint = request.compensators[-1], request.joints[0]
    for case, robot in done.cases.items():
        if done.identified[case, name][joint].accepted and case.plant in arm_kit.PLANTS:
            changed = robot.with_changes(_recipe(request, name).changes)
            study = StudyCase(changed, path, done.kits[case, name], joint)
            return study_tables(crew.do("studies", study_jobs(study)))
    return {}


def _plant_results(
    request: Request, done: _Done, motions: Mapping[str, Timing], robot: Robot
) -> dict[str, PlantResult]:
    results = {}
    for plant in request.plants:
        results[plant] = _plant_result(plant, request, done, motions, robot)
    return results


def _plant_result(
    plant: str, request: Request, done: _Done, motions: Mapping[str, Timing], robot: Robot
) -> PlantResult:
    identified, under = done.identified, done.runs
    # Curves and pictures are of the first seed.
    first = Case(plant, request.seeds[0])
    main = under[request.controllers[0]]
    figures: dict[int, dict[str, Any]] = {}
    factors: list[float] = []
    for seed in request.seeds:
        case = Case(plant, seed)
        runs = {name: _finished(of_case[case]) for name, of_case in under.items()}
        models = {name: identified[case, name] for name in request.compensators}
        main_runs = runs[request.controllers[0]]
        figures[seed] = plant_figures(models, main_runs, motions, request.joints)
        figures[seed] |= _controllers(request, runs, motions)
        factors += [outcome[1] for outcome in main[case] if not isinstance(outcome, Lost)]
    remarks = []
    for name, of_case in under.items():
        # Where only one controller ran, its name says nothing.
        controller = f"{name}, "
        if len(under) == 1:
            controller = ""
        for seed in request.seeds:
            for remark in _remarks(robot, of_case[Case(plant, seed)], seed):
                remarks.append(f"{controller}{remark}")
    return PlantResult(
        plant=plant,
        identifications=identified[first, request.compensators[-1]],
        runs=tuple(_finished(main[first])),
        figures=figures,
        real_time_factor=float(np.median(factors or [0.0])),
        identified={name: identified[first, name] for name in request.compensators},
        remarks=tuple(remarks),
    )


def _finished(outcomes: Sequence[Outcome]) -> list[TrialRun]:
    """The runs of the trials that were not lost."""
    return [outcome[0] for outcome in outcomes if not isinstance(outcome, Lost)]


def _remarks(robot: Robot, outcomes: Sequence[Outcome], seed: int) -> Iterator[str]:
    """What joints met in the trials of a seed: trials that ended early, ranges left, models that do not fit."""
    for outcome in outcomes:
        if isinstance(outcome, Lost):
            yield f"seed {seed}, {outcome.trial}, {outcome.compensator}: lost, {outcome.fault}"
            continue
        run = outcome[0]
        label = f"seed {seed}, {run.trial}, {run.compensator}: "
        largest = np.degrees(np.abs(run.angle).max(axis=0))
        for reached, (number, joint) in zip(largest, robot.joints.items(), strict=False):
            allowed = np.degrees(joint.range)
            if reached > allowed:
                yield f"{label}joint {number} went to {reached:.1f} deg, beyond its range of {allowed:.3g} deg."
        for text in run.warnings:
            yield f"{label}{text}"


def _controllers(
    request: Request, runs: Mapping[str, list[TrialRun]], motions: Mapping[str, Timing]
) -> dict[str, Any]:
    """Figures by controller, where another one than the paper's was asked for."""
    if request.controllers == (control_kit.PAPER,):
        return {}
    figures = {}
    for name, of_controller in runs.items():
        tuned = {}
        # How many numbers a user's controller has to tune is not known.
        if name not in request.laws:
            tuned["tuned"] = tuned_numbers(name)
        figures[name] = tuned | trial_figures(of_controller, motions, request.joints)
    return {"controllers": figures}


def _settings(robot: Robot, request: Request) -> dict[str, Any]:
    """What was set; a change that a recipe makes is told where it is the only compensator."""
    # Several recipes may ask for different changes: then none is shown.
    used = robot.with_changes({})
    if len(request.compensators) == 1:
        used = robot.with_changes(_recipe(request, request.compensators[0]).changes)
    settings = {
        "robot": used.name,
        "conditions": arm_kit.conditions_of(used),
        "parameters": used.values,
        "sources": sources(),
        "changes": changes_from_packaged(used),
        "versions": {"dehyst": __version__} | {name: version(name) for name in ENGINES},
        "fingerprint": used.fingerprint,
        "plants": list(request.plants),
        "alone": list(request.alone),
        "joints": list(request.joints),
        "compensator": request.compensators[-1],
        "compensators": list(request.compensators),
        "seeds": list(request.seeds),
        "trials": list(request.trials),
    }
    if request.controllers != (control_kit.PAPER,):
        settings["controllers"] = list(request.controllers)
    return settings


def _check(robot: Robot, request: Request) -> None:
    known_plants = (*arm_kit.PLANTS, *request.foreign)
    _check_known("plant", request.plants, known_plants)
    if request.alone:
        _check_known("plant", request.alone, known_plants)
    _check_known("joint", request.joints, robot.compensator.joints or tuple(robot.joints))
    _check_known("trial", request.trials, TRIALS)
    for number in request.joints:
        if number not in robot.pneumatic:
            raise ParameterError(
                f"joint {number} of this robot is electric: no muscle, no hysteresis, nothing to compensate. Name "
                f"joints with muscles, e.g. joints={robot.compensated}, or change "
                f"joint.{number}.drive.",
                joint=number,
            )
    built_in = [name for name in request.foreign if name in arm_kit.PLANTS]
    if built_in:
        raise ParameterError(
            f"the mechanism '{built_in[0]}' of `foreign` has the name of a built-in one; the report could not tell "
            f"them apart. Name it 'my-{built_in[0]}'.",
            built_in=built_in,
        )
    used = (*request.plants, *request.alone)
    unused = [name for name in request.foreign if name not in used]
    if unused:
        raise ParameterError(
            f"the mechanism '{unused[0]}' of `foreign` is in none of the plants {used}: it would not be run. "
            f"Type plants=('{unused[0]}',), or plants=('preisach', '{unused[0]}').",
            unused=unused,
        )
    _check_names(request)
    _check_controllers(request)
    if not request.seeds or not all(map(_is_seed, request.seeds)):
        raise ParameterError(
            f"seeds {request.seeds} are not whole numbers from 0 to 2**32 - 1; pass at least one."
        )


def _check_known(noun: str, values: Sequence[Any], choices: Sequence[Any]) -> None:
    """Refuse no values, and those that are none of the choices."""
    unknown = [value for value in values if value not in choices]
    if values and not unknown:
        return
    problem = "was named"
    if unknown:
        problem = str(unknown[0])
    raise ParameterError(
        f"no {noun} {problem}. There are: {', '.join(map(str, choices))}.", unknown=unknown
    )


def _is_seed(seed: object) -> bool:
    return isinstance(seed, int) and 0 <= seed < 2**32


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
    unused = [name for name in request.laws if name in control_kit.CONTROLLERS or name not in names]
    if unused:
        raise ParameterError(
            f"the controller '{unused[0]}' of `laws` is not among the controllers {names}, or has the name of one that "
            f"is built in: it would not be run. Type controllers=('paper', 'mine'), laws={{'mine': ...}}.",
            name=unused[0],
        )
    for name, make in request.laws.items():
        if not callable(make):
            raise ParameterError(
                f"laws['{name}'] is a {type(make).__name__}, and each joint and run needs a "
                f"controller of its own. Pass what makes one: laws={{'{name}': lambda joint: MyController()}}.",
                name=name,
            )
    for name in names:
        if name not in (*control_kit.CONTROLLERS, *request.laws):
            raise ParameterError(
                f"no controller '{name}'. There are: {', '.join(control_kit.CONTROLLERS)}.",
                name=name,
            )
        for compensator in request.compensators:
            refuse_learning(name, compensator, _recipe(request, compensator).passes)
