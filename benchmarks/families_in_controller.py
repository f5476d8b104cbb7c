"""Every family of models in the paper's controller: one joint, its own log, seven mechanisms of its muscles.

    python benchmarks/families_in_controller.py [--mechanisms maxwell-slip ...] [--seeds 0 1] [--families pi ...]
        [--jobs 2] [--out docs/generate/families_in_controller.csv]

Joint 1 of the realistic arm moves alone, as `dehyst reproduce --quick` runs it. A family is fitted to the log of the
paper's experiment and computed along the desired path. Beside them: no compensator, and the compensators `paper` and
`best` of the experiment, in the controller. A mechanism and seed that the file has already is not run again.
docs/build.py makes table and figure of docs/explanation/families-in-the-controller.md from the file.
"""

from __future__ import annotations

import argparse
import csv
import math
import warnings
from concurrent.futures import ProcessPoolExecutor, as_completed
from itertools import product
from pathlib import Path

from studies.joint_models import (
    MECHANISMS,
    Joint,
    PathModel,
    errors,
    model_names,
    path_cost,
    path_model,
    prepared,
    with_model,
)

from dehyst.errors import SimulationError
from dehyst_robot.arm import load_robot
from dehyst_robot.commands._reproduce import QUICK
from dehyst_robot.experiments import Equipment

OUT = Path(__file__).parents[1] / "docs" / "generate" / "families_in_controller.csv"
COLUMNS = ("mechanism", "seed", "family", "way", "numbers", "unexplained", "fit_s", "sample_ns", "trial",
           "rms_mdeg", "max_mdeg", "reason")  # fmt: skip
TRIALS = ("fast", "slow", "slow_no_integrator")
OFF, RECIPES = "off", ("paper", "best")
NUMBER = 1  # of the joint
Row = dict[str, object]


def rows_of(mechanism: str, seed: int, families: tuple[str, ...]) -> list[Row]:
    """All trials of one mechanism with one seed."""
    # Families that extrapolate a little along the path say so; here their error says it.
    warnings.simplefilter("ignore", UserWarning)
    changes = {**QUICK, "hysteresis.mechanism": mechanism}
    joint = prepared(load_robot(conditions="realistic", changes=changes), NUMBER, seed, RECIPES)
    rows = _trials(joint, joint.equipped(), {"family": OFF}, on=False)
    for name in RECIPES:
        identification = joint.identified[name]
        about = {
            "family": name,
            "numbers": identification.model.nonzero_weights,
            "unexplained": _figure(identification.unexplained),
        }
        rows += _trials(joint, joint.equipped(name), about)
    for family in families:
        model = path_model(joint.identified["paper"], family)
        rows += _of_family(joint, family, model)
    return [{"mechanism": mechanism, "seed": seed, **row} for row in rows]


def _of_family(joint: Joint, family: str, model: PathModel) -> list[Row]:
    if model.compensator is None:
        return [{"family": family, "reason": model.reason}]
    about = {
        "family": family,
        "way": model.way,
        "numbers": model.parameters,
        "unexplained": _figure(model.unexplained),
        "fit_s": round(model.seconds, 2),
        "sample_ns": round(path_cost(model)),
    }
    return _trials(joint, with_model(joint, model), about)


def _trials(joint: Joint, equipment: Equipment, about: Row, on: bool = True) -> list[Row]:
    rows = []
    for trial in TRIALS:
        row = {**about, "trial": trial}
        try:
            degrees = errors(joint, equipment, trial, on)
            row["rms_mdeg"] = round(1e3 * degrees["rms_deg"], 2)
            row["max_mdeg"] = round(1e3 * degrees["max_deg"], 2)
        except SimulationError as fault:
            row["reason"] = str(fault)
        rows.append(row)
    return rows


def _figure(value: float) -> object:
    return round(value, 4) if math.isfinite(value) else ""


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    families = model_names()
    parser.add_argument("--mechanisms", nargs="+", default=list(MECHANISMS), choices=MECHANISMS)
    parser.add_argument("--seeds", nargs="+", type=int, default=[0, 1])
    parser.add_argument("--families", nargs="+", default=list(families), choices=families)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--out", type=Path, default=OUT)
    options = parser.parse_args()
    rows: list[Row] = []
    if options.out.exists():
        with options.out.open(encoding="utf-8", newline="") as file:
            rows = list(csv.DictReader(file))
    present = {(str(row["mechanism"]), str(row["seed"])) for row in rows}
    with ProcessPoolExecutor(options.jobs) as pool:
        running = []
        for seed, mechanism in product(options.seeds, options.mechanisms):
            if (mechanism, str(seed)) not in present:
                running.append(pool.submit(rows_of, mechanism, seed, tuple(options.families)))
        for done in as_completed(running):
            new = done.result()
            rows += new
            # In one order, whichever was ready first.
            rows.sort(
                key=lambda row: (MECHANISMS.index(str(row["mechanism"])), int(str(row["seed"])))
            )
            with options.out.open("w", encoding="utf-8", newline="") as file:
                writer = csv.DictWriter(file, COLUMNS, restval="", lineterminator="\n")
                writer.writeheader()
                writer.writerows(rows)
            for row in new:
                if row.get("trial", "slow") == "slow":
                    print(row["mechanism"], row["seed"], row["family"], row.get("way", ""),
                          row.get("rms_mdeg", row.get("reason")), flush=True)  # fmt: skip
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
