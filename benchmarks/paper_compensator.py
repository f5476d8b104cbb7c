"""The paper's compensator on joint 1 alone: at rest, on muscles that are compensated twice, and read in other ways.

python benchmarks/paper_compensator.py [--conditions realistic] [--seeds 0]

Writes results/paper_compensator.json, from which docs/build.py makes tables of docs/explanation/the-experiment.md. Some
minutes.
"""

from __future__ import annotations

import argparse
import tempfile
from itertools import product
from pathlib import Path
from statistics import mean
from typing import Any

import numpy as np
from result_files import save

from dehyst_robot.arm import load_robot
from dehyst_robot.experiments import calibrate, equip, evaluate_point, identify_joint, plan_path
from dehyst_robot.experiments._studies import StudyCase, compensated_twice, rest

PLANTS = ("maxwell-slip", "preisach", "dahl")
READINGS = ("paper", "literal", "scaled")
TRIALS = ("fast", "slow", "slow_no_integrator")
RESULTS = Path(__file__).parent / "results" / "paper_compensator.json"
JOINT = 1


def measured(plant: str, conditions: str, seed: int) -> dict[str, Any]:
    """All figures of a plant with one seed."""
    changes = {"hysteresis.mechanism": plant}
    robot = load_robot(conditions=conditions, changes=changes)
    characteristic = calibrate(robot, JOINT, seed=seed)
    with tempfile.TemporaryDirectory() as folder:
        model = identify_joint(robot, JOINT, characteristic, Path(folder), seed=seed)
    kit = equip(robot, {JOINT: characteristic}, {JOINT: model}, seed)
    case = StudyCase(robot, plan_path(robot), kit, JOINT)
    ratios = evaluate_point(
        changes,
        seed=seed,
        trials=TRIALS,
        compensators=("off", *READINGS),
        run_settings={"conditions": conditions},
    )
    return {
        "plant": plant,
        "conditions": conditions,
        "seed": seed,
        "rest": at_rest(case),
        "twice": compensated_twice(case)[0],
        "readings": {
            name: {trial: ratios[f"{trial}/{name}/ratio_rms"] for trial in TRIALS}
            for name in READINGS
        },
    }


def at_rest(case: StudyCase) -> dict[str, dict[str, float]]:
    """Mean of the integrator's torque in two minutes of rest, and its slope."""
    table = rest(case)
    time = np.asarray(table["time_s"], float)
    figures = {}
    for name in ("off", "on"):
        torque = np.asarray(table[f"integrator_{name}_Nm"], float)
        slope = float(np.polyfit(time, torque, 1)[0])
        figures[name] = {"level_Nm": float(torque.mean()), "drift_Nm_s": slope}
    return figures


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--conditions", default="realistic", choices=("realistic", "kind"))
    parser.add_argument("--seeds", nargs="+", type=int, default=[0])
    options = parser.parse_args()
    rows: list[dict[str, Any]] = []
    for plant, seed in product(PLANTS, options.seeds):
        rows.append(measured(plant, options.conditions, seed))
        save(RESULTS, {"runs": rows})
    for plant in PLANTS:
        runs = [row for row in rows if row["plant"] == plant]
        slow = {name: mean(row["readings"][name]["slow"] for row in runs) for name in READINGS}
        said = "  ".join(f"{name} {ratio:.2f}" for name, ratio in slow.items())
        print(f"{plant:13} twice {mean(row['twice'] for row in runs):.2f}  slow: {said}")


if __name__ == "__main__":
    main()
