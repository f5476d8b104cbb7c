"""Rivals on the realistic plant: every controller and compensator that a reviewer would name, one log, one budget.

python benchmarks/rivals.py [--joint 1] [--draws 20] [--rivals best ...] [--out docs/generate/rivals.csv]
python benchmarks/rivals.py --air                   # what each draws from the supply in the fast trial, packaged plant
python benchmarks/rivals.py --unexplained           # of each mechanism: what the models leave of loops not in their log

A joint alone, calibrated, identified and run as `dehyst reproduce --quick` does. Every draw is another plant: kind and
size of the hysteresis, static map, pulley, masses, delay of the valves, and by the seed tolerances and noise. A rival
with a number to choose gets five tries on a joint that is none of the draws. Rows that the file has are not run again.
docs/build.py makes the tables of docs/explanation/rivals.md from the file. Needs: pip install --group bench.
"""

from __future__ import annotations

import argparse
import csv
import math
import os
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault(
    "XLA_FLAGS", "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1"
)

import numpy as np
from studies.joint_models import MECHANISMS, Joint
from studies.joint_models import prepared as prepared_joint
from studies.learned_feedforward import (
    NETWORKS,
    PROCESSES,
    LearnedFeedforward,
    gaussian_process,
    recurrent_network,
)
from studies.reviewed_laws import OWN, period_cost, with_factor
from studies.rival_laws import (
    INTEGRATOR,
    POSITION,
    AdaptedScale,
    Around,
    DisturbanceObserver,
    PredictiveController,
    no_compensation,
)

from dehyst.errors import DehystError
from dehyst.models import DirectInverse
from dehyst_robot.arm import Robot, load_robot
from dehyst_robot.arm._rigid_body import moment_arms
from dehyst_robot.arm._routing import contraction
from dehyst_robot.commands._reproduce import QUICK
from dehyst_robot.control import InverseCompensator
from dehyst_robot.experiments import Equipment, JointIdentification, plan_path
from dehyst_robot.experiments._gains import HOLD_S, MOVE_S, at_pole, highest_pole
from dehyst_robot.experiments._identification import TIME
from dehyst_robot.experiments._output import joint_figures
from dehyst_robot.experiments._path import PlannedPath
from dehyst_robot.experiments._results import BAR
from dehyst_robot.experiments._trials import learned_trial

OUT = Path(__file__).parents[1] / "docs" / "generate" / "rivals.csv"
COLUMNS = (
    "joint",
    "draw",
    "plant",
    "rival",
    "setting",
    "trial",
    "rms_mdeg",
    "max_mdeg",
    "rig_min",
    "numbers",
    "step_us",
    "runs_in",
    "failed",
)
TRIALS = ("fast", "slow", "slow_no_integrator")
MOVES = "moves"  # drawn moves with rests, which no identification contains, at the speed of the fast trial
LATE = (
    "fast_late"  # the fast trial with commands that come 5 ms later: does the loop have the margin?
)
LATER_S = 0.005
DRAWS = 20  # of the table that is shipped
UNEXPLAINED = OUT.with_name("unexplained.csv")
AIR = OUT.with_name("rivals_air.csv")
AMBIENT = 101325.0  # [Pa]
STILL = 0.005  # changes of the air in a muscle below this share of its mean are noise of the sensor
TUNING = "tuning"  # in place of a draw: the packaged realistic plant, on which settings are chosen
NATIVE = ("paper", "best", "scaled", "maxwell-slip")
PASSES = 4
FACTORS = (1.0, 1.5, 2.0, 3.0, 4.0)  # of gains that are tuned: 1 is the default pole
MAPS = ("tool", "bench", "tondu-lopez")
LINKS = 7
Row = dict[str, object]


@dataclass(frozen=True, eq=False)
class Case:
    """A joint of a draw, calibrated and identified."""

    joint: Joint
    plant: str
    moves: PlannedPath
    poles: dict[str, float] = field(default_factory=dict)

    def pole(self) -> float:
        """Highest pole with both margins, without compensator. [1/s]"""
        if "off" not in self.poles:
            number = self.joint.number
            self.poles["off"] = highest_pole(self.joint.robot, self.joint.equipped(), (number,))
        return self.poles["off"]

    @property
    def log_min(self) -> float:
        """Length of the log that compensators are identified from. [min]"""
        return float(self.joint.identified["paper"].log[TIME][-1]) / 60.0


@dataclass(frozen=True, eq=False)
class Prepared:
    """A rival on a joint.

    Attributes
    ----------
    equipment, robot
        Of its trials; without a robot: the joint's.
    law
        Switches of a trial -> a controller in Python.
    on
        Whether the compensator is switched on.
    passes
        Repetitions of the motion that it learns from.
    rig_min
        Time on the rig before the trials, beside the calibration, which all have. [min]
    numbers
        Learned or chosen.
    native
        Controller and compensator whose period in C is measured.
    """

    equipment: Equipment
    robot: Robot | None = None
    law: Callable[[int], Around] | None = None
    on: bool = True
    passes: int = 0
    rig_min: float = 0.0
    numbers: int = 0
    native: tuple[str, str] = ("paper", "")


@dataclass(frozen=True)
class Rival:
    """How a rival is prepared, the settings that it may choose from, and whether they are gains of the loop."""

    prepare: Callable[[Case, Any], Prepared]
    settings: tuple[Any, ...] = ("",)
    gains: bool = False

    @property
    def tries(self) -> tuple[str, ...]:
        """Trials of each setting: gains have to stand a delay, too."""
        return (*TRIALS, LATE) if self.gains else TRIALS


def drawn(seed: int, number: int) -> tuple[dict[str, object], str]:
    """Return the changes of a draw to the realistic plant, and what they are in words."""
    rng = np.random.default_rng([seed, number])
    # Each mechanism comes once before one comes again.
    mechanism = MECHANISMS[seed % len(MECHANISMS)]
    static = str(rng.choice(MAPS))
    force, radius = rng.uniform(60.0, 180.0), 0.05 * rng.uniform(0.9, 1.1)
    mass, delay = rng.uniform(0.7, 1.3), rng.uniform(0.0005, 0.004)
    packaged = load_robot(conditions="realistic")
    changes: dict[str, object] = {
        "hysteresis.mechanism": mechanism,
        "muscle.dmsp40.map": static,
        "muscle.dmsp40.hysteresis_N": float(force),
        f"joint.{number}.radius_m": float(radius),
        "valve.mpye.delay_s": float(delay),
    }
    for link in range(1, LINKS + 1):
        key = f"joint.{link}.link_mass_kg"
        changes[key] = float(mass) * (packaged.joint(link).link_mass or 0.0)
    words = f"{mechanism}; {static}; {force:.0f} N; {1e3 * radius:.1f} mm; mass x {mass:.2f}; {1e3 * delay:.1f} ms"
    return changes, words


def case_of(draw: int | None, number: int) -> Case:
    """Calibrate and identify the joint of a draw; None: of the packaged realistic plant."""
    seed, words = 0, "packaged"
    changes: dict[str, object] = {}
    if draw is not None:
        seed = 1 + draw
        changes, words = drawn(draw, number)
    robot = load_robot(conditions="realistic", changes={**QUICK, **changes})
    moves = plan_path(load_robot(changes={**QUICK, "reference.seed": seed}))
    return Case(prepared_joint(robot, number, seed, NATIVE), words, moves)


def plain(case: Case, setting: Any) -> Prepared:
    """The paper's law, which is feedback linearisation with an integrator, and no compensator."""
    return Prepared(case.joint.equipped(), on=False, numbers=1)


def plain_at_pole(case: Case, setting: Any) -> Prepared:
    """The same at the highest pole that has its margins; eight poles are tried, twice each."""
    pole = case.pole()
    return Prepared(at_pole(case.joint.equipped(), pole), on=False, rig_min=margin_min(), numbers=1)


def margin_min() -> float:
    """Rig time of the search for the highest pole. [min]"""
    return 2 * 8 * 2 * (MOVE_S + HOLD_S) / 60.0


def with_recipe(case: Case, name: str) -> Prepared:
    """A compensator of the experiment, as `dehyst reproduce` runs it."""
    return Prepared(
        case.joint.equipped(name),
        rig_min=case.log_min,
        numbers=numbers_of(case.joint.identified[name]),
        native=("paper", name),
    )


def numbers_of(identified: JointIdentification) -> int:
    """Numbers of a compensator that are not zero: thresholds, weights, times, coefficients."""
    model = identified.model
    if not isinstance(model, DirectInverse):
        return 2 * identified.nonzero_weights
    count = int(model.radii.size + model.path_lengths.size + model.creep_weights.shape[-1])
    for name in ("stop_weights", "path_weights", "creep_weights", "viscous", "polynomial"):
        count += int(np.count_nonzero(getattr(model, name)))
    return count


def best_at_pole(case: Case, setting: Any) -> Prepared:
    """The best compensator at the highest pole that the loop without it has."""
    one = with_recipe(case, "best")
    equipment = at_pole(one.equipment, case.pole())
    return replace(one, equipment=equipment, rig_min=one.rig_min + margin_min())


def observed(case: Case, setting: Any) -> Prepared:
    """Disturbance observer alone; its filter's pole is tuned."""
    kit = case.joint.equipped()
    parameters = kit.controllers[case.joint.number]
    return Prepared(
        kit, law=lambda switches: DisturbanceObserver(parameters, switches, setting), numbers=1
    )


def adapted(case: Case, setting: Any) -> Prepared:
    """The paper's model with k = 10 bar/rad, its scale learned while it runs; the rate is tuned."""
    number = case.joint.number
    identified = case.joint.identified["scaled"]
    kit = case.joint.equipped()
    parameters = kit.controllers[number]
    inverse: Any = identified.compensator
    compensator = InverseCompensator(inverse, identified.shear * BAR, BAR)
    return Prepared(
        replace(kit, own={number: compensator}),
        law=lambda switches: AdaptedScale(parameters, switches, setting),
        rig_min=case.log_min,
        numbers=numbers_of(identified) + 2,
    )


def predictive(case: Case, setting: Any) -> Prepared:
    """Predictive controller; the frequency of its loop is tuned."""
    kit = case.joint.equipped()
    parameters = kit.controllers[case.joint.number]
    return Prepared(
        kit, law=lambda switches: PredictiveController(parameters, switches, setting), numbers=1
    )


def reviewed(name: str) -> Rival:
    """A controller of the literature with the compensator of its publication; one gain is tuned."""

    def prepare(case: Case, setting: Any) -> Prepared:
        kit = case.joint.equipped(OWN[name])
        robot, equipment = with_factor(case.joint.robot, kit, name, setting)
        return Prepared(
            equipment,
            robot,
            on=bool(OWN[name]),
            rig_min=case.log_min if OWN[name] else 0.0,
            numbers=TUNED_NUMBERS[name],
            native=(name, OWN[name]),
        )

    return Rival(prepare, FACTORS, gains=True)


TUNED_NUMBERS: Mapping[str, int] = {
    "sliding-mode": 4,
    "vo-minh": 2,
    "one-valve": 3,
    "pid": 4,
}


def repeated(model: bool) -> Callable[[Case, Any], Prepared]:
    """Iterative learning along the motion, over nothing or over the model of `best`."""

    def prepare(case: Case, setting: Any) -> Prepared:
        number = case.joint.number
        one = with_recipe(case, "best")
        compensators = one.equipment.compensators if model else {number: no_compensation()}
        equipment = replace(one.equipment, compensators=compensators, adaptations={})
        return Prepared(
            equipment,
            passes=PASSES,
            rig_min=case.log_min if model else 0.0,
            numbers=one.numbers if model else 0,
            native=("paper", "best"),
        )

    return prepare


def trained(train: Callable[..., LearnedFeedforward], settings: tuple[str, ...]) -> Rival:
    """A learned feedforward on the log that `paper` and `best` get; its features are tuned."""

    def prepare(case: Case, setting: Any) -> Prepared:
        compensator = train(case.joint.identified["paper"], setting)
        kit = replace(case.joint.equipped(), own={case.joint.number: compensator})
        return Prepared(kit, rig_min=case.log_min, numbers=compensator.parameters)

    return Rival(prepare, settings)


RIVALS: Mapping[str, Rival] = {
    "off": Rival(plain),
    "paper": Rival(lambda case, setting: with_recipe(case, "paper")),
    "best": Rival(lambda case, setting: with_recipe(case, "best")),
    "pole": Rival(plain_at_pole),
    "best at that pole": Rival(best_at_pole),
    "disturbance observer": Rival(observed, (2.5, 5.0, 10.0, 20.0, 40.0), gains=True),
    "adapted scale": Rival(adapted, (0.1, 0.3, 1.0, 3.0, 10.0)),
    "sliding-mode": reviewed("sliding-mode"),
    "vo-minh": reviewed("vo-minh"),
    "one-valve": reviewed("one-valve"),
    "pid": reviewed("pid"),
    "iterative learning": Rival(repeated(False)),
    "iterative learning over best": Rival(repeated(True)),
    "gaussian process": trained(gaussian_process, tuple(PROCESSES)),
    "recurrent network": trained(recurrent_network, tuple(NETWORKS)),
    "predictive": Rival(predictive, (6.0, 9.0, 12.0, 18.0, 24.0), gains=True),
}


def rows_of(case: Case, name: str, setting: Any, trials: tuple[str, ...]) -> list[Row]:
    """Run the trials of a rival; a trial that fails is a row with the reason."""
    head: Row = {"rival": name, "setting": setting, "plant": case.plant}
    try:
        prepared = RIVALS[name].prepare(case, setting)
    except DehystError as fault:
        reason = " ".join(str(fault).split())
        return [{**head, "trial": trial, "failed": reason} for trial in trials]
    rows = []
    for trial in trials:
        row = {**head, "trial": trial}
        try:
            rows.append({**row, **measured(case, prepared, trial)})
        except DehystError as fault:
            rows.append({**row, "failed": " ".join(str(fault).split())})
    return rows


def measured(case: Case, prepared: Prepared, trial: str) -> Row:
    """Run a trial: its errors, and what it took."""
    joint = case.joint
    path, kind, robot = joint.path, trial, prepared.robot or joint.robot
    if trial == MOVES:
        path, kind = case.moves, "fast"
    if trial == LATE:
        delay = robot.simulation.command_delay + LATER_S
        kind, robot = "fast", robot.with_changes({"simulation.command_delay_s": delay})
    law = None
    equipment = prepared.equipment
    if prepared.law is not None:
        switches = POSITION if kind == "slow_no_integrator" else POSITION | INTEGRATOR
        law = prepared.law(switches)
        equipment = replace(equipment, laws={joint.number: law})
    run, _ = learned_trial(
        robot,
        path,
        equipment,
        kind,
        "on" if prepared.on else "off",
        moving=(joint.number,),
        passes=prepared.passes,
    )
    figures = joint_figures(run, joint.number)
    rig_min = prepared.rig_min + prepared.passes * float(run.time[-1]) / 60.0
    numbers = prepared.numbers
    if prepared.passes:
        numbers += round(25.0 * float(run.time[-1]) / (1 + int(run.cycle.max())))
    step_us, runs_in = cost(case, prepared, law)
    return {
        "rms_mdeg": round(1e3 * figures["rms_deg"], 3),
        "max_mdeg": round(1e3 * figures["max_deg"], 3),
        "rig_min": round(rig_min, 2),
        "numbers": numbers,
        "step_us": round(step_us, 3),
        "runs_in": runs_in,
    }


def cost(case: Case, prepared: Prepared, law: Around | None) -> tuple[float, str]:
    """Time of a control period [us], and where it is spent."""
    if law is not None:
        return 1e6 * law.seconds / law.calls, "Python"
    period = 1e-3 * period_cost(case.joint, *prepared.native, ticks=4000, repeats=3)
    own = prepared.equipment.own.get(case.joint.number)
    if isinstance(own, LearnedFeedforward):
        return period + 1e6 * own.seconds / own.samples, "C, and Python along the path"
    return period, "C"


def chosen_settings(rows: list[Row], joint: int) -> dict[str, Any]:
    """Return rival -> the setting with the smallest geometric mean of the errors of its tries."""
    scores: dict[str, dict[str, float]] = {}
    for row in rows:
        if row["draw"] != TUNING or row["joint"] != joint:
            continue
        one = scores.setdefault(str(row["rival"]), {})
        error = row.get("rms_mdeg") or ""
        log = math.log(float(str(error))) if error else math.inf
        one[str(row["setting"])] = one.get(str(row["setting"]), 0.0) + log
    chosen = {}
    for name, rival in RIVALS.items():
        if len(rival.settings) == 1:
            chosen[name] = rival.settings[0]
        elif name in scores:
            of_rival = scores[name]
            chosen[name] = min(rival.settings, key=lambda s: of_rival.get(str(s), math.inf))
    return chosen


def air_of(case: Case, name: str, setting: Any) -> float:
    """Air that both muscles draw from the supply in the fast trial, at ambient pressure. [l]"""
    joint = case.joint
    prepared = RIVALS[name].prepare(case, setting)
    equipment = prepared.equipment
    if prepared.law is not None:
        law = prepared.law(POSITION | INTEGRATOR)
        equipment = replace(equipment, laws={joint.number: law})
    run, _ = learned_trial(
        prepared.robot or joint.robot,
        joint.path,
        equipment,
        "fast",
        "on" if prepared.on else "off",
        moving=(joint.number,),
        passes=prepared.passes,
    )
    place = joint.number - 1
    described = joint.robot.joint(joint.number)
    drawn = 0.0
    for muscle, arm in enumerate(moment_arms(joint.robot, joint.number)):
        kind = joint.robot.muscles[described.driven[muscle]]
        kappa = contraction(arm, kind.length, described.middle)(run.angle[:, place])
        volume = kind.dead_volume + kind.length * np.polynomial.polynomial.polyval(
            kappa, kind.volume
        )
        air = (1.0 + run.pressure[:, place, muscle] / AMBIENT) * volume
        drawn += rises_of(air, STILL * float(np.mean(air)))
    return 1e3 * drawn


def rises_of(signal: np.ndarray[Any, Any], band: float) -> float:
    """Sum of the rises of a signal from one turning point to the next; those smaller than a band are none."""
    total, low, high, rising = 0.0, float(signal[0]), float(signal[0]), False
    for value in signal.tolist():
        if rising:
            high = max(high, value)
            if value < high - band:
                total += high - low
                low, rising = value, False
        else:
            low = min(low, value)
            if value > low + band:
                high, rising = value, True
    return total + (high - low if rising else 0.0)


def air(path: Path, rows: list[Row]) -> None:
    """Write the air of each rival, with the setting that its tries chose, on the packaged realistic plant."""
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(("joint", "rival", "air_l"))
        for number in (1, 2, 4):
            case, settings = case_of(None, number), chosen_settings(rows, number)
            for name in RIVALS:
                try:
                    litres = f"{air_of(case, name, settings[name]):.3f}"
                except DehystError:
                    litres = ""
                writer.writerow((number, name, litres))
                print(number, name, litres, flush=True)


def unexplained(path: Path) -> None:
    """Write what `paper` and `best` leave of the hysteresis on loops that their log does not have, a draw a mechanism.

    It is std(hysteresis - model)/std(hysteresis): no controller and no trial is in it.
    """
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(("joint", "draw", "plant", "paper", "best"))
        for number in (1, 2, 4):
            for draw in range(len(MECHANISMS)):
                case = case_of(draw, number)
                identified = case.joint.identified
                left = [round(identified[name].unexplained, 4) for name in ("paper", "best")]
                writer.writerow((number, draw, case.plant, *left))
                print(number, draw, case.plant, *left, flush=True)


class Table:
    """The file of results: what is there is not run again, what is new is written at once."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.rows: list[Row] = []
        if path.exists():
            with path.open(encoding="utf-8", newline="") as file:
                self.rows = [{**row, "joint": int(row["joint"])} for row in csv.DictReader(file)]
        else:
            path.write_text(",".join(COLUMNS) + "\n", encoding="utf-8")

    def has(self, joint: int, draw: str, rival: str, setting: Any, trial: str) -> bool:
        """Whether a trial of a rival was run on a draw."""
        keys = ("joint", "draw", "rival", "setting", "trial")
        present = set()
        for row in self.rows:
            present.add(tuple(str(row[key]) for key in keys))
        return (str(joint), draw, rival, str(setting), trial) in present

    def add(self, rows: list[Row], joint: int, draw: str) -> None:
        """Write rows and show them."""
        with self.path.open("a", encoding="utf-8", newline="") as file:
            writer = csv.DictWriter(file, COLUMNS, restval="", lineterminator="\n")
            for row in rows:
                row |= {"joint": joint, "draw": draw}
                writer.writerow(row)
                print(joint, draw, row["rival"], row["setting"], row["trial"],
                      row.get("rms_mdeg", row.get("failed")), flush=True)  # fmt: skip
        self.rows += rows


def tune(table: Table, number: int, names: list[str]) -> None:
    """Run all settings of all rivals on the packaged plant."""
    case = None
    for name in names:
        settings = RIVALS[name].settings
        for setting in settings if len(settings) > 1 else ():
            missing = []
            for trial in RIVALS[name].tries:
                if not table.has(number, TUNING, name, setting, trial):
                    missing.append(trial)
            if missing:
                case = case or case_of(None, number)
                table.add(rows_of(case, name, setting, tuple(missing)), number, TUNING)


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--joint", type=int, default=1, choices=(1, 2, 4))
    parser.add_argument("--draws", type=int, default=DRAWS)
    parser.add_argument("--rivals", nargs="+", default=list(RIVALS), choices=list(RIVALS))
    parser.add_argument("--out", type=Path, default=OUT)
    parser.add_argument("--air", action="store_true")
    parser.add_argument("--unexplained", action="store_true")
    options = parser.parse_args()
    # Of trials of rivals, at gains at which something may be wrong.
    warnings.simplefilter("ignore", UserWarning)
    if options.unexplained:
        unexplained(UNEXPLAINED)
        return 0
    table = Table(options.out)
    if options.air:
        air(AIR, table.rows)
        return 0
    tune(table, options.joint, options.rivals)
    settings = chosen_settings(table.rows, options.joint)
    for draw in range(options.draws):
        case = None
        for name in options.rivals:
            if table.has(options.joint, str(draw), name, settings[name], LATE):
                continue
            case = case or case_of(draw, options.joint)
            rows = rows_of(case, name, settings[name], (*TRIALS, MOVES, LATE))
            table.add(rows, options.joint, str(draw))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
