"""Sixteen changes of a joint after its identification: rms error with a compensator over that without.

python benchmarks/stale.py [--joint 1] [--seed 0] [--conditions realistic] [--only "hysteresis gone" "payload 2 kg"]

Identified on the arm as it is; then the plant changes and the controller is told nothing. Slow trial at a fifth of
the speed, fast trial with two cycles. Beside each figure: what the controller says there is of the hysteresis, and its
flags: S (stale), with when it was raised, and O (an offset). Status 1 if `best` is above 1.05 of off.
"""

from __future__ import annotations

import argparse
import sys
import warnings
from dataclasses import replace

import numpy as np

from dehyst.control.joint import FLAGS
from dehyst.robot.arm.parameters import Robot, load_robot
from dehyst.robot.experiments import point
from dehyst.robot.experiments.path import plan_path
from dehyst.robot.experiments.recipes import recipe
from dehyst.robot.experiments.trials import run_trial

SHORT = {"path.cycles_fast": 2, "path.slow_factor": 5.0}
TOOL = (6398.4, 0.122366, 10.47143, 2.023288, 0.25, 620000.0)
CHANGES: dict[str, dict[str, object]] = {
    "none": {},
    "hysteresis x 0.7": {"hysteresis.scale": 0.7},
    "hysteresis x 1.3": {"hysteresis.scale": 1.3},
    "hysteresis gone": {"hysteresis.scale": 0.0},
    "force x 0.9": {"map.tool.coefficients": [0.9 * TOOL[0], *TOOL[1:]]},
    "payload 1 kg": {"payload.mass_kg": 1.0},
    "payload 2 kg": {"payload.mass_kg": 2.0},
    "mean pressure 2 bar": {"controller.mean_pressure_bar": 2.0},
    "mean pressure 4 bar": {"controller.mean_pressure_bar": 4.0},
    "pressure sensors off by 20 mbar rms": {"sensors.pressure_offset_bar": 0.02},
    "pressure sensors off by 100 mbar rms": {"sensors.pressure_offset_bar": 0.1},
    "dead band x 3": {"valve.mpye.dead_band": 0.09},
    "sensor lag 7 ms": {"sensors.pressure_lag_s": 0.007},
    "creep x 2": {"hysteresis.creep": 2.0},
    "tolerances 20 % and 5 %": {"tolerance.hysteresis": 0.2, "tolerance.force": 0.05},
    "supply - 10 %": {"air.supply_bar": 6.3},
}
TOLD = ("controller.",)  # what a controller is told of
RAISED = {"S": "stale", "O": "shifted"}  # letter -> flag


def _over(error: np.ndarray, without: np.ndarray) -> float:
    return float(np.sqrt(np.mean(error**2) / np.mean(without**2)))


def measured(known: Robot, name: str, number: int, seed: int) -> list[str]:
    changes = CHANGES[name]
    plant = known.with_changes(changes)
    told = known.with_changes({key: value for key, value in changes.items() if key.startswith(TOLD)})
    wanted = {one: recipe(one) for one in ("paper", "best")}
    prepared = point._prepared(told, told, wanted, number, "joint", seed)
    path, cells = plan_path(known), []
    for trial in ("slow", "fast"):
        without = np.zeros(0)
        for compensator in ("off", "paper", "best"):
            equipment = replace(prepared["paper" if compensator == "off" else compensator][0], known=told)
            run, _ = run_trial(plant, path, equipment, trial, compensator, (number,))
            error, flags = run.error[:, number - 1], run.flags[:, number - 1]
            if compensator == "off":
                without = error
                continue
            said = "".join(f" {letter}" for letter, flag in RAISED.items() if (flags & FLAGS[flag]).any())
            stale = np.flatnonzero(flags & FLAGS["stale"])
            if stale.size:
                said += f" from {run.time[stale[0]]:.0f} s"
            cells.append(f"{_over(error, without):.3f} ({run.hysteresis[-1, number - 1]:.2f}{said})")
    return cells


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--joint", type=int, default=1)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--conditions", default="realistic", choices=["kind", "realistic"])
    parser.add_argument("--only", nargs="+", default=list(CHANGES), choices=list(CHANGES))
    options = parser.parse_args()
    warnings.simplefilter("ignore", UserWarning)  # flags are in the table
    known, bad = load_robot(changes=SHORT, conditions=options.conditions), False
    print(f"{options.conditions}, joint {options.joint} | slow: paper | best | fast: paper | best")
    for name in options.only:
        cells = measured(known, name, options.joint, options.seed)
        bad = bad or max(float(cell.split()[0]) for cell in cells[1::2]) > 1.05
        print(" | ".join([name, *cells]), flush=True)
    return int(bad)


if __name__ == "__main__":
    sys.exit(main())
