"""Compensator x controller x plant on joint 1 of the kind arm alone: errors, numbers to tune, cost of a tick.

python benchmarks/controllers.py [--plants maxwell-slip preisach dahl none] [--seeds 0 1 2] [--trials slow ...]
    [--controllers paper vo-minh ...] [--compensators paper maxwell-slip best] [--joint 1] [--arm] [--json FILE]

All controllers run on the same calibrated joint, gains derived by the formulas of `dehyst_robot.control._reviewed`; rms
| max are means over the seeds, in degrees. --arm: the whole arm moves. Status 1 if the paper's controller with its
model is not below every reviewed controller as it was published (vo-minh with maxwell-slip, the others without
compensator) in the slow trial on a plant with hysteresis.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from dehyst_robot.control import SWITCHES, JointController, JointControllerParameters
from dehyst_robot.control._reviewed import CONTROLLERS, TUNED, derived_law
from dehyst_robot.experiments import evaluate_point

PLANTS = ("maxwell-slip", "preisach", "dahl", "none")
TRIALS = ("slow", "slow_no_integrator", "fast")
COMPENSATORS = ("paper", "maxwell-slip", "best")
PUBLISHED = {
    "vo-minh": "maxwell-slip"
}  # what each was published with; the others without compensator
TICKS = 20_000
REPEATS = 9
Table = dict[
    str, dict[str, dict[str, dict[str, dict[str, float]]]]
]  # plant, controller, trial, compensator


def cost_per_tick(name: str) -> float:
    """Shortest time of a period of a controller without compensator, of runs of `TICKS`. [us]"""
    parameters = JointControllerParameters()
    controller = JointController(parameters, law=derived_law(name, parameters))
    t = parameters.period * np.arange(TICKS)
    draw = np.random.default_rng(0)
    angle = np.round(0.2 * np.sin(2 * t) / parameters.angle_step) * parameters.angle_step
    first, second = (
        3e5 + sign * 8e4 * np.sin(2 * t) + draw.normal(0, 200, TICKS) for sign in (1, -1)
    )
    reference = np.zeros((TICKS, 7))
    reference[:, 0], reference[:, 1], reference[:, 4] = angle, 0.4 * np.cos(2 * t), 3e5
    on = np.full(TICKS, SWITCHES["position"] | SWITCHES["integrator"])
    spent = []
    for _ in range(REPEATS):
        controller.reset(0.0, 3e5, 3e5)
        begin = time.perf_counter()
        controller.run(angle, first, second, reference, on)
        spent.append(time.perf_counter() - begin)
    return 1e6 * min(spent) / TICKS


def measured(options: argparse.Namespace, plant: str, seed: int) -> dict[str, dict[str, float]]:
    """Controller -> figures of a plant with a seed, as `evaluate_point` names them."""
    found = {}
    for name in options.controllers:
        found[name] = evaluate_point(
            {"hysteresis.mechanism": plant},
            experiment="arm" if options.arm else "joint",
            joint=options.joint,
            seed=seed,
            trials=options.trials,
            compensators=("off", *options.compensators),
            run_settings={"controller": name, "conditions": "kind"},
        )
    return found


def table_of(options: argparse.Namespace) -> Table:
    """Means over the seeds: plant -> controller -> trial -> compensator -> rms_deg, max_deg."""
    cases = list(product(options.plants, options.seeds))
    with ThreadPoolExecutor(options.workers) as pool:  # the simulation does not hold Python's lock
        found = dict(
            zip(cases, pool.map(lambda case: measured(options, *case), cases), strict=True)
        )
    table: Table = {}
    for plant, name, trial, model in product(
        options.plants, options.controllers, options.trials, ("off", *options.compensators)
    ):
        mean = {
            key: float(
                np.mean(
                    [found[plant, seed][name][f"{trial}/{model}/{key}"] for seed in options.seeds]
                )
            )
            for key in ("rms_deg", "max_deg")
        }
        table.setdefault(plant, {}).setdefault(name, {}).setdefault(trial, {})[model] = mean
    return table


def show(table: Table) -> None:
    """A line a plant, trial and controller: rms | max of each compensator."""
    for plant, controllers in table.items():
        for trial in next(iter(controllers.values())):
            for name, trials in controllers.items():
                cells = (
                    f"{model} {x['rms_deg']:.4f} | {x['max_deg']:.3f}"
                    for model, x in trials[trial].items()
                )
                print(f"{plant:13}{trial:19}{name:13}" + "   ".join(cells))


def beaten(table: Table) -> list[str]:
    """Reviewed controllers, as published, that the paper's with its compensator does not beat in the slow trial."""
    lost = []
    for plant, controllers in table.items():
        if plant == "none" or "paper" not in controllers or "slow" not in controllers["paper"]:
            continue
        ours = controllers["paper"]["slow"].get("paper")
        for name, trials in controllers.items():
            theirs = trials["slow"].get(PUBLISHED.get(name, "off"))
            if ours and theirs and name != "paper" and theirs["rms_deg"] <= ours["rms_deg"]:
                lost.append(
                    f"{plant}, {name}: {theirs['rms_deg']:.4f} deg against {ours['rms_deg']:.4f}"
                )
    return lost


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--plants", nargs="+", default=list(PLANTS), choices=PLANTS)
    parser.add_argument("--seeds", nargs="+", type=int, default=[0, 1, 2])
    parser.add_argument("--trials", nargs="+", default=list(TRIALS), choices=TRIALS)
    parser.add_argument("--controllers", nargs="+", default=list(CONTROLLERS), choices=CONTROLLERS)
    parser.add_argument("--compensators", nargs="*", default=list(COMPENSATORS))
    parser.add_argument("--joint", type=int, default=1)
    parser.add_argument("--arm", action="store_true", help="the whole arm moves")
    parser.add_argument("--workers", type=int)
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    costs = {name: cost_per_tick(name) for name in options.controllers}
    for name, cost in costs.items():
        print(f"{name:13}{TUNED[name]} to tune, {cost:.3f} us a tick")
    table = table_of(options)
    show(table)
    if options.json:
        said: dict[str, Any] = {
            "table": table,
            "us_per_tick": costs,
            "tuned": {n: TUNED[n] for n in costs},
        }
        options.json.write_text(
            json.dumps({**said, "seeds": options.seeds}, indent=2) + "\n", encoding="utf-8"
        )
    lost = beaten(table)
    for line in lost:
        print(f"not beaten: {line}")
    return int(bool(lost))


if __name__ == "__main__":
    sys.exit(main())
