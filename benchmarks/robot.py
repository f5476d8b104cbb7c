"""How fast the robot is simulated: controllers, pneumatics and rigid body together, and the demo as a whole.

python benchmarks/robot.py [--runs 3] [--json]
"""

from __future__ import annotations

import argparse
import json
import statistics
import subprocess
import sys
import tempfile
import time
from typing import Any

from startup import machine

from dehyst import PrandtlIshlinskii
from dehyst_robot import Equipment, load_robot, plan_path, run_trial
from dehyst_robot.experiments import equip, nominal_characteristic

PACKAGES = ("dehyst", "numpy", "scipy", "mujoco", "mink")
MECHANISMS = ("none", "dahl", "preisach", "maxwell-slip")
WHAT = {"whole arm": tuple(load_robot().joints), "joint 1 alone": (1,)}
LEAST = 20.0  # real-time factor of the whole arm on one core
LEAST_REALISTIC = 40.0  # of the realistic one
LONGEST = 20.0  # `dehyst reproduce --quick` on two cores [s]
OPERATORS = 25  # with weight in a typical model


class Coulomb:
    """A hysteresis mechanism in Python, to see what that costs."""

    def reset(self, contraction: float) -> None:
        self.last = contraction
        self.value = 0.0

    def force(self, contraction: float, pressure: float, period: float) -> float:
        step = 6400.0 * (contraction - self.last)
        self.last = contraction
        self.value = min(max(self.value + step, -80.0), 80.0)
        return self.value


def factor(
    mechanism: str, moving: tuple[int, ...], runs: int, conditions: str = "kind"
) -> list[float]:
    """Simulated time over wall time of a trial with its homing, on one core."""
    built_in = mechanism if mechanism in MECHANISMS else "none"
    robot = load_robot(
        changes={"hysteresis.mechanism": built_in, "path.cycles_fast": 2}, conditions=conditions
    )
    path = plan_path(robot)
    joints = [n for n in moving if n in robot.pneumatic]
    backbones = {n: nominal_characteristic(robot, n) for n in joints}
    kit: Equipment = equip(
        robot, backbones, {}, mechanisms=None if built_in == mechanism else lambda *_: Coulomb()
    )
    model = PrandtlIshlinskii(
        [k / OPERATORS for k in range(OPERATORS)], [0.5] + [0.02] * (OPERATORS - 1)
    ).inverse()
    for n in set(joints) & {1, 2, 4}:
        kit.compensators[n] = model  # type: ignore[index]
    return [run_trial(robot, path, kit, "fast", "on", moving)[1] for _ in range(runs)]


def demo(runs: int) -> list[float]:
    """Wall time of `dehyst reproduce --quick`, as the shell starts it. [s]"""
    times = []
    for _ in range(runs):
        with tempfile.TemporaryDirectory() as folder:
            begin = time.perf_counter()
            command = [sys.executable, "-m", "dehyst", "reproduce", "--quick", "--out", folder]
            subprocess.run(command, check=True, capture_output=True)
            times.append(time.perf_counter() - begin)
    return times


def measure(runs: int) -> list[dict[str, Any]]:
    """Rows of the table."""
    rows: list[dict[str, Any]] = []
    for what, moving in WHAT.items():
        for mechanism in (*MECHANISMS, "in Python"):
            factors = factor(mechanism, moving, runs)
            least = LEAST if what == "whole arm" and mechanism in MECHANISMS else None
            rows.append({"what": what, "mechanism": mechanism, "best": max(factors),
                         "median": statistics.median(factors), "unit": "x", "least": least})  # fmt: skip
    for mechanism in MECHANISMS:
        factors = factor(mechanism, WHAT["whole arm"], runs, "realistic")
        rows.append({"what": "realistic arm", "mechanism": mechanism, "best": max(factors),
                     "median": statistics.median(factors), "unit": "x", "least": LEAST_REALISTIC})  # fmt: skip
    times = demo(runs)
    rows.append({"what": "dehyst reproduce --quick", "mechanism": "preisach", "best": min(times),
                 "median": statistics.median(times), "unit": "s", "most": LONGEST})  # fmt: skip
    return rows


def main() -> None:
    """Measure, print, and fail if a limit is missed."""
    parser = argparse.ArgumentParser(
        description="Real-time factor of the simulated robot; time of the demo."
    )
    parser.add_argument("--runs", type=int, default=3, help="repetitions")
    parser.add_argument("--json", action="store_true", help="print JSON and nothing else")
    options = parser.parse_args()
    rows = measure(options.runs)
    if options.json:
        print(json.dumps({"machine": machine(PACKAGES), "runs": options.runs, "results": rows}))
    else:
        print(", ".join(f"{key} {value}" for key, value in machine(PACKAGES).items()))
        print(f"{options.runs} runs each; x: simulated time over wall time, one core\n")
        for row in rows:
            limit = next(
                (f"limit {row[key]:g} {row['unit']}" for key in ("least", "most") if row.get(key)),
                "",
            )
            name = f"{row['what']}, {row['mechanism']}"
            print(
                f"{name:38} best {row['best']:7.1f} {row['unit']}  median {row['median']:7.1f} {row['unit']}  {limit}"
            )
    slow = [row["mechanism"] for row in rows if row.get("least") and row["best"] < row["least"]]
    slow += [row["what"] for row in rows if row.get("most") and row["best"] > row["most"]]
    if slow:
        sys.exit(f"over the limit: {', '.join(slow)}")


if __name__ == "__main__":
    main()
