"""Eighteen changes of a joint after its identification: rms error without compensator, with the paper's, with the best.

python benchmarks/stale.py [--joints 1 4] [--seeds 0 1 2 3 4] [--conditions realistic] [--only "payload 2 kg" ...]
    [--jobs 2] [--out docs/generate/stale.csv]

Identified on the arm as it is; then the plant changes and the controller is told nothing. Slow trial at a fifth of
the speed, fast trial with two cycles. Beside each error: what the controller says there is of the hysteresis, and when
it raised its flags stale and shifted. A case that the file has already is not run again. docs/build.py makes the table
of docs/explanation/adaptation.md from the file. Status 1 if `best` is above 1.05 of off.
"""

from __future__ import annotations

import argparse
import csv
import itertools
import math
import sys
import warnings
from collections.abc import Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import numpy as np

from dehyst_robot.arm import Arm, load_robot
from dehyst_robot.control import FLAGS
from dehyst_robot.experiments import SPACING, excite, home, plan_path, run_trial
from dehyst_robot.experiments import _point as point
from dehyst_robot.experiments._recipes import recipe
from dehyst_robot.experiments._results import Characteristic

OUT = Path(__file__).parents[1] / "docs" / "generate" / "stale.csv"
COLUMNS = ("conditions", "change", "joint", "seed", "trial", "compensator", "rms_mdeg", "hysteresis", "stale_s",
           "shifted_s")  # fmt: skip
SHORT = {"path.cycles_fast": 2, "path.slow_factor": 5.0}
TOOL = (6398.4, 0.122366, 10.47143, 2.023288, 0.25, 620000.0)
WARM = "cold to warm"
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
    WARM: {},
    f"{WARM}, six times the warmth": {
        "muscle.dmsp40.warming_K_W": 12.0,
        "muscle.dmsp20.warming_K_W": 36.0,
    },
}
TOLD = ("controller.",)  # what a controller is told of
STROKES_S, STROKE_S, REACH = (
    1200.0,
    3.0,
    0.6,
)  # that warm muscles up: two time constants, period, share of the range


def warmed(arm: Arm, characteristics: Mapping[int, Characteristic]) -> None:
    """Strokes until the muscles are warm, then the homing; nobody tells the controllers."""
    t = SPACING * np.arange(round(STROKES_S / SPACING) + 1)
    reach = [REACH * arm.robot.joint(n).range if n in characteristics else 0.0 for n in arm.moving]
    excite(
        arm,
        np.sin(2 * np.pi / STROKE_S * t)[:, None] * np.array(reach),
        characteristics,
        every_s=1.0,
    )
    warmth = {n: [round(w, 1) for w in plant.state["warmth"]] for n, plant in arm._plants.items()}
    print("warmer than the room [K]:", warmth, flush=True)
    home(arm, characteristics)


def measured(conditions: str, name: str, number: int, seed: int) -> Iterator[tuple[object, ...]]:
    """Rows of a case."""
    known, changes = load_robot(changes=SHORT, conditions=conditions), CHANGES[name]
    plant = known.with_changes(changes)
    told = known.with_changes(
        {key: value for key, value in changes.items() if key.startswith(TOLD)}
    )
    prepared = point._prepared(
        told, told, {one: recipe(one) for one in ("paper", "best")}, number, "joint", seed
    )
    path = plan_path(known)
    for trial, compensator in itertools.product(("slow", "fast"), ("off", "paper", "best")):
        kit = replace(prepared["paper" if compensator == "off" else compensator][0], known=told)
        kit = replace(kit, history=warmed) if name.startswith(WARM) else kit
        run, _ = run_trial(plant, path, kit, trial, compensator, (number,))
        error, flags = run.error[:, number - 1], run.flags[:, number - 1]
        raised = (np.flatnonzero(flags & FLAGS[flag]) for flag in ("stale", "shifted"))
        since = [
            f"{run.time[when[0]]:.1f}" if when.size and compensator != "off" else ""
            for when in raised
        ]
        rms = 1e3 * math.degrees(math.sqrt(np.mean(error**2)))
        found = run.hysteresis[-1, number - 1]
        yield (
            conditions,
            name,
            number,
            seed,
            trial,
            compensator,
            f"{rms:.3f}",
            f"{found:.2f}",
            *since,
        )


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--joints", nargs="+", type=int, default=[1, 4])
    parser.add_argument("--seeds", nargs="+", type=int, default=[0, 1, 2, 3, 4])
    parser.add_argument("--conditions", default="realistic", choices=["kind", "realistic"])
    parser.add_argument("--only", nargs="+", default=list(CHANGES), choices=list(CHANGES))
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--out", type=Path, default=OUT)
    options = parser.parse_args()
    warnings.simplefilter("ignore", UserWarning)  # flags are in the table
    if not options.out.exists():
        options.out.write_text(",".join(COLUMNS) + "\n", encoding="utf-8")
    with options.out.open(encoding="utf-8", newline="") as file:
        done = {
            (r["conditions"], r["change"], int(r["joint"]), int(r["seed"]))
            for r in csv.DictReader(file)
        }
    cases = itertools.product(options.seeds, options.joints, options.only)
    wanted = [
        case for s, n, name in cases if (case := (options.conditions, name, n, s)) not in done
    ]
    bad = False
    with ThreadPoolExecutor(options.jobs) as pool:  # the simulation does not hold Python's lock
        for rows in pool.map(lambda case: list(measured(*case)), wanted):
            with options.out.open("a", encoding="utf-8", newline="") as file:
                csv.writer(file, lineterminator="\n").writerows(rows)
            off, paper, best = (np.array([float(row[6]) for row in rows[k::3]]) for k in range(3))
            bad = bad or bool((best > 1.05 * off).any())
            ratios = np.round([paper / off, best / off], 3).tolist()
            print(*rows[0][:4], "slow, fast: paper", ratios[0], "best", ratios[1], flush=True)
    return int(bad)


if __name__ == "__main__":
    sys.exit(main())
