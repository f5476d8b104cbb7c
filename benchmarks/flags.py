"""Which flags a joint raises that is as it was identified, and one whose hysteresis has changed: joint 1 alone.

python benchmarks/flags.py [--mechanisms dahl lugre ...] [--seeds 0 1] [--scales 1.0] [--joint 1]

Calibrated, identified and run as `dehyst reproduce --quick` does, with the compensators paper and best, and touched by
nothing. Prints, by mechanism, scale of the hysteresis since the identification, and compensator: in how many trials
each flag was up, touched for more than 0.01 of the trial, and in how many trials the run warns of a contact.
Twelve seconds of processor time for a mechanism and seed.
"""

from __future__ import annotations

import argparse
import itertools
import warnings
from collections import Counter

import numpy as np

from dehyst_robot.arm import kit as arm_kit
from dehyst_robot.arm import load_robot
from dehyst_robot.commands._reproduce import QUICK
from dehyst_robot.control import FLAGS
from dehyst_robot.experiments import _point as point
from dehyst_robot.experiments import plan_path, run_trial
from dehyst_robot.experiments._recipes import recipe
from dehyst_robot.experiments.kit import POLICY, TRIALS

NAMES = ("paper", "best")
SHOWN = ("stale", "shifted", "touched", "warned of a contact")


def counted(mechanism: str, seed: int, scale: float, joint: int) -> dict[str, Counter[str]]:
    """Compensator -> how many trials had a flag up."""
    robot = load_robot(changes={**QUICK, "hysteresis.mechanism": mechanism})
    plant = robot.with_changes({"hysteresis.scale": scale})
    path = plan_path(robot)
    recipes = {name: recipe(name) for name in NAMES}
    prepared = point._prepared(robot, robot, recipes, joint, "joint", seed)
    counts = {name: Counter[str]() for name in NAMES}
    for trial, name in itertools.product(TRIALS, NAMES):
        run, _ = run_trial(plant, path, prepared[name][0], trial, name, (joint,))
        count = counts[name]
        count["trials"] += 1
        for flag in ("stale", "shifted"):
            count[flag] += bool(np.any(run.flags & FLAGS[flag]))
        up = (run.flags[:, joint - 1] & FLAGS["touched"]) != 0
        count["touched"] += bool(np.mean(up) > POLICY.touched)
        count["warned of a contact"] += any("a hand" in text for text in run.warnings)
    return counts


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    mechanisms = [name for name in arm_kit.PLANTS if name != "none"]
    parser.add_argument("--mechanisms", nargs="+", default=mechanisms, choices=mechanisms)
    parser.add_argument("--seeds", nargs="+", type=int, default=[0, 1])
    parser.add_argument("--scales", nargs="+", type=float, default=[1.0])
    parser.add_argument("--joint", type=int, default=1)
    options = parser.parse_args()
    warnings.simplefilter("ignore", UserWarning)  # flags are counted
    for mechanism, scale in itertools.product(options.mechanisms, options.scales):
        totals = {name: Counter[str]() for name in NAMES}
        for seed in options.seeds:
            for name, count in counted(mechanism, seed, scale, options.joint).items():
                totals[name] += count
        for name, count in totals.items():
            shown = ", ".join(f"{flag} {count[flag]}" for flag in SHOWN)
            print(f"{mechanism} x {scale:g}, {name}, {count['trials']} trials: {shown}", flush=True)


if __name__ == "__main__":
    main()
