"""Figures of the direct inverse on a joint that is not as it was identified, against what they must be.

python benchmarks/compensators.py [--plants maxwell-slip preisach dahl] [--only contact holding]
    [--joint 1] [--seed 0] [--change KEY=VALUE ...] [--quick] [--json]

Parts: other_hysteresis, cold_start, no_hysteresis, contact, holding, endurance. --change: a key of the parameter file,
for another robot. Status 1 if a figure is not as it must be. --quick: 200 s of faults instead of 10 000.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from functools import partial

from studies import robustness
from studies.alone import Alone, identified_alone
from studies.robustness import Figure

from dehyst_robot.arm import load_robot
from dehyst_robot.experiments import plan_path

PLANTS = ("maxwell-slip", "preisach", "dahl")
OTHER = 2  # joint whose model is tried on the first one
Part = Callable[[Alone], Iterator[Figure]]


def parts(quick: bool) -> dict[str, Part]:
    """What is measured on a plant with hysteresis."""
    return {
        "other_hysteresis": robustness.other_hysteresis,
        "cold_start": robustness.cold_start,
        "contact": robustness.contact,
        "holding": robustness.holding,
        "endurance": partial(robustness.endurance, seconds=200.0 if quick else 10_000.0),
    }


def prepared(plant: str, options: argparse.Namespace, number: int) -> Alone:
    """A joint of a plant, calibrated and identified."""
    changes = {
        key: json.loads(value) for key, value in (change.split("=", 1) for change in options.change)
    }
    robot = load_robot(conditions="kind", changes={"hysteresis.mechanism": plant, **changes})
    return identified_alone(robot, plan_path(load_robot(conditions="kind")), number, options.seed)


def measured(plant: str, options: argparse.Namespace) -> list[Figure]:
    """All figures of a plant."""
    joint = prepared(plant, options, options.joint)
    if plant == "none":
        return list(robustness.no_hysteresis(joint))
    chosen = {
        name: part
        for name, part in parts(options.quick).items()
        if not options.only or name in options.only
    }
    found = [figure for part in chosen.values() for figure in part(joint)]
    if "cold_start" in chosen and not options.quick:
        found += robustness.cold_start(
            joint, prepared(plant, options, OTHER), f" with the model of joint {OTHER}"
        )
    return found


def show(plant: str, figures: list[Figure]) -> None:
    print(plant)
    for f in figures:
        limit = "" if f.most is None else f"  <= {f.most:g}  {'ok' if f.good else 'NOT'}"
        print(f"  {f.value:9.3f}{limit:18s}  {f.name}", flush=True)


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--plants", nargs="+", default=list(PLANTS))
    parser.add_argument("--only", nargs="+", default=[], choices=[*parts(True), "no_hysteresis"])
    parser.add_argument("--joint", type=int, default=1)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument(
        "--change", action="append", default=[], help="KEY=VALUE of the parameter file"
    )
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    plants = [plant for plant in options.plants if options.only != ["no_hysteresis"]]
    if not options.only or "no_hysteresis" in options.only:
        plants.append("none")
    with ThreadPoolExecutor() as pool:  # the simulation does not hold Python's lock
        found = {}
        for plant, figures in zip(
            plants, pool.map(lambda plant: measured(plant, options), plants), strict=True
        ):
            found[plant] = figures
            if not options.json:
                show(plant, figures)
    if options.json:
        print(
            json.dumps(
                {
                    plant: {f.name: [f.value, f.most] for f in figures}
                    for plant, figures in found.items()
                }
            )
        )
    return int(not all(f.good for figures in found.values() for f in figures))


if __name__ == "__main__":
    sys.exit(main())
