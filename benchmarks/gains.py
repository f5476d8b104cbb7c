"""Gain or compensator: rms error of joints over the pole of their loops, up to the highest that has its margins.

python benchmarks/gains.py [--conditions kind realistic] [--mechanisms maxwell-slip preisach dahl] [--seeds 0]
    [--moving 1 2 4 | --moving 1+2+4] [--poles 6 12 18 24 36] [--trials slow ...] [--without EFFECT ...] [--once]
    [--jobs 2] [--out docs/generate/gains.csv]

Calibrated, identified and run as `dehyst reproduce --quick` does, without compensator, with the paper's and with the
best, in three trials; a joint alone, or joints with + between them together, the others locked. Poles beyond the
highest one are run up to 1.5 times it; nan: a joint left its range or failed safe. --without: an effect of the
realistic plant that is switched off, see EFFECTS. A case that the file has already is not run again. docs/build.py
makes the tables of docs/explanation/gain-or-compensator.md from the file.
"""

from __future__ import annotations

import argparse
import csv
import itertools
import tempfile
import warnings
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from dehyst.errors import ParameterError, SimulationError
from dehyst_robot.arm import Robot, load_robot
from dehyst_robot.commands._reproduce import QUICK
from dehyst_robot.experiments import (
    Equipment,
    JointIdentification,
    calibrate,
    equip,
    plan_path,
    run_trial,
)
from dehyst_robot.experiments._gains import at_pole, highest_pole
from dehyst_robot.experiments._identification import identify_compensators
from dehyst_robot.experiments._output import joint_figures
from dehyst_robot.experiments._recipes import recipe
from dehyst_robot.experiments._results import TRIALS

OUT = Path(__file__).parents[1] / "docs" / "generate" / "gains.csv"
COLUMNS = (
    "conditions",
    "mechanism",
    "moving",
    "seed",
    "joint",
    "compensator",
    "pole_1_s",
    "highest",
    "trial",
    "rms_mdeg",
)
BEYOND = 1.5  # times the highest pole: what is beyond is no loop that anybody would run
VALVES, MUSCLES, JOINTS = ("mpye", "mpye_small"), ("dmsp40", "dmsp20"), (1, 2, 4, 6, 7)
EFFECTS: dict[str, list[str]] = {
    "delays": [
        *(f"valve.{v}.delay_s" for v in VALVES),
        *(f"sensors.{s}_{d}_s" for s in ("angle", "pressure") for d in ("delay", "jitter")),
        *(f"simulation.command_{d}_s" for d in ("delay", "jitter")),
    ],
    "tubes": [f"valve.{v}.tube_length_m" for v in VALVES],
    "tendons": [f"muscle.{m}.tendon_N_m" for m in MUSCLES],
    "backlash": [f"joint.{n}.backlash_deg" for n in JOINTS],
    "valves": [
        *(f"valve.{v}.{k}" for v in VALVES for k in ("bits", "hysteresis")),
        "tolerance.dead_band",
        "tolerance.middle",
    ],
    "supply": ["air.supply_volume_l"],
    "sensors": [
        "sensors.angle_offset_deg",
        "sensors.pressure_offset_bar",
        "sensors.pressure_drift_bar",
    ],
    "warmth": [f"muscle.{m}.warming_K_W" for m in MUSCLES],
    "scatter": ["hysteresis.scatter"],
    "pressure loops": ["hysteresis.pressure_strain_1_bar"],
    "unlike pairs": ["tolerance.shape", "tolerance.contraction"],
}
Case = tuple[str, str, str, int]  # conditions, mechanism, joints that move such as "1+2+4", seed
Row = tuple[str, str, str, int, int, str, float, int, str, float]


def robot_of(conditions: str, mechanism: str) -> Robot:
    """Return the robot of a name such as "realistic without tendons", with the settings of --quick."""
    base, _, effect = conditions.partition(" without ")
    off: dict[str, object] = dict.fromkeys(EFFECTS[effect], 0) if effect else {}
    return load_robot(conditions=base, changes={**QUICK, "hysteresis.mechanism": mechanism, **off})


def equipped(robot: Robot, joints: tuple[int, ...], seed: int) -> dict[str, Equipment]:
    """Return compensator -> what a trial with it needs, all from one calibration and one set of logs."""
    calibrated = {n: calibrate(robot, n, seed=seed) for n in joints}
    identified: dict[str, dict[int, JointIdentification]] = {name: {} for name in ("paper", "best")}
    for n, found in calibrated.items():
        wanted = {name: (recipe(name), found) for name in identified}
        with tempfile.TemporaryDirectory() as folder:
            for name, one in identify_compensators(
                robot, n, wanted, Path(folder), seed=seed
            ).items():
                identified[name][n] = one
                if not one.accepted:
                    print(
                        f"joint {n}, seed {seed}: '{name}' is refused, it leaves {one.unexplained:.2f}",
                        flush=True,
                    )
    kits = {
        name: equip(robot, calibrated, x, seed, adaptive=recipe(name).adaptive)
        for name, x in identified.items()
    }
    return {"off": equip(robot, calibrated, {}, seed), **kits}


def measured(case: Case, poles: list[float], trials: list[str], once: bool) -> Iterator[Row]:
    """Rows of a case: at the given poles, and at the highest one with and without compensator, or `once`: without."""
    conditions, mechanism, moving, seed = case
    joints = tuple(map(int, moving.split("+")))
    robot = robot_of(conditions, mechanism)
    path = plan_path(load_robot(changes=QUICK))  # the same for all
    highest = float("nan")  # not even the default pole has the margins
    for name, kit in equipped(robot, joints, seed).items():
        if not once or name == "off":
            try:
                highest = highest_pole(robot, kit, joints, name)
            except ParameterError:
                highest = float("nan")
        for pole in [*(pole for pole in poles if not pole > BEYOND * highest), highest]:
            for trial in trials:
                try:
                    run, _ = run_trial(robot, path, at_pole(kit, pole), trial, name, moving=joints)
                    rms = {n: 1e3 * joint_figures(run, n)["rms_deg"] for n in joints}
                except (SimulationError, ParameterError):
                    rms = dict.fromkeys(joints, float("nan"))
                for n in joints:
                    yield (
                        *case,
                        n,
                        name,
                        round(pole, 2),
                        int(pole == highest),
                        trial,
                        round(rms[n], 3),
                    )


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--conditions", nargs="+", default=["kind", "realistic"], choices=["kind", "realistic"]
    )
    parser.add_argument("--mechanisms", nargs="+", default=["maxwell-slip", "preisach", "dahl"])
    parser.add_argument(
        "--moving", nargs="+", default=["1", "2", "4"], help="joints alone, or together: 1+2+4"
    )
    parser.add_argument("--seeds", nargs="+", type=int, default=[0])
    parser.add_argument("--poles", nargs="+", type=float, default=[6.0, 12.0, 18.0, 24.0, 36.0])
    parser.add_argument("--trials", nargs="+", default=list(TRIALS), choices=TRIALS)
    parser.add_argument(
        "--without", nargs="+", default=[], choices=list(EFFECTS), help="of the realistic plant"
    )
    parser.add_argument(
        "--once", action="store_true", help="search the highest pole without compensator, for all"
    )
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--out", type=Path, default=OUT)
    options = parser.parse_args()
    warnings.simplefilter(
        "ignore", UserWarning
    )  # of trials at gains at which something is wrong on purpose
    conditions = [f"realistic without {effect}" for effect in options.without] or options.conditions
    cases = itertools.product(options.seeds, conditions, options.mechanisms, options.moving)
    done = set()
    if options.out.exists():
        with options.out.open(encoding="utf-8", newline="") as file:
            done = {
                (r["conditions"], r["mechanism"], r["moving"], int(r["seed"]))
                for r in csv.DictReader(file)
            }
    else:
        options.out.write_text(",".join(COLUMNS) + "\n", encoding="utf-8")
    wanted = [case for seed, c, m, n in cases if (case := (c, m, n, seed)) not in done]
    with ThreadPoolExecutor(options.jobs) as pool:  # the simulation does not hold Python's lock
        for rows in pool.map(
            lambda case: list(measured(case, options.poles, options.trials, options.once)), wanted
        ):
            with options.out.open("a", encoding="utf-8", newline="") as file:
                csv.writer(file, lineterminator="\n").writerows(rows)
            print(*rows[0][:4], "done", flush=True)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
