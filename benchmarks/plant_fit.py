"""`dehyst rig fit` on logs of the plant with known numbers, on a measured map, and on two real joints.

python benchmarks/plant_fit.py [--seeds 8] [--out benchmarks/results/plant_fit.json]

Generated logs: a muscle on a bench with loops at two pressures, holds and steps of pressure, 2 N and 2.5 mbar rms of
noise; its numbers drawn, 25 % rms about the file's. Counted are intervals that hold the truth. Real logs stand beside
the project (../shared/data); without them their rows are left out. Three of ten parts of each log are not fitted.
"""

from __future__ import annotations

import argparse
import gzip
import json
import math
from pathlib import Path
from typing import Any

import numpy as np
from result_files import save

from dehyst_robot.arm import Robot, load_robot
from dehyst_robot.experiments import PlantFit, RigLog
from dehyst_robot.experiments._plant_fit import ALIKE, ALL, UNITS, fit_plant, respond
from dehyst_robot.muscles import kit as muscles_kit

DATA = Path(__file__).resolve().parents[2] / "shared" / "data"
FILE = load_robot(conditions="kind")
DRAWN = (
    "map.tool.coefficients", "muscle.dmsp40.hysteresis_N", "hysteresis.pressure_share", "hysteresis.asymmetry",
    "muscle.dmsp40.viscous_force_N", "muscle.dmsp40.creep_force_N", "muscle.dmsp40.creep_pressure_N_bar",
)  # fmt: skip
PSI = 6894.757293168361
SOFT = {"joint.6.contraction": 0.005, "joint.6.range_deg": 10.0}
SAROSI = [
    -4.35573e-5,
    281.2237,
    -32.866,
    -9.27035e-3,
    302.20107e-5,
    -263.69185,
]  # DMSP-20-400N of dehyst muscle


def value(robot: Robot, key: str) -> Any:
    found: Any = robot.raw
    for part in key.split("."):
        found = found[part]
    return found


def drawn(seed: int, mechanism: str) -> Robot:
    rng, changes = np.random.default_rng(seed), dict[str, object](ALIKE)
    for key in DRAWN:
        old = value(FILE, key)
        if key.startswith("map."):
            changes[key] = [*(np.exp(rng.normal(0.0, 0.25, 4)) * old[:4]), *old[4:]]
        else:
            factor = min(float(np.exp(rng.normal(0.0, 0.25))), 1.4)
            changes[key] = (
                [factor * each for each in old] if isinstance(old, list) else factor * old
            )
    return FILE.with_changes(changes | {"hysteresis.mechanism": mechanism})


def bench(true: Robot, seed: int) -> RigLog:
    rng, period = np.random.default_rng([seed, 1]), 0.02
    swing = 0.1 - 0.09 * np.cos(np.linspace(0.0, 4 * np.pi, 2000))
    k = np.concatenate([swing, np.full(1500, swing[-1])] * 2 + [np.full(1000, 0.05)])
    bar = np.concatenate([np.repeat([2.0, 4.0], 3500), np.repeat([2.0, 5.0, 2.0, 5.0], 250)])
    pressure = 1e5 * np.stack([bar, bar], axis=1)
    log = RigLog("bench", "force", np.zeros(k.size), pressure, k, period * np.arange(k.size))
    force = respond(true, 1, log) + rng.normal(0.0, 2.0, k.size)
    return RigLog(
        "bench", "force", force, pressure + rng.normal(0.0, 250.0, pressure.shape), k, log.time
    )


def generated(mechanism: str, seeds: int) -> dict[str, Any]:
    told, held, before, after = {}, {}, [], []
    for seed in range(seeds):
        true = drawn(seed, mechanism)
        found = fit_plant(FILE, 1, [bench(true, seed)])
        errors = found.logs[0].errors
        before.append(errors["held_out_before"])
        after.append(errors["held_out_after"])
        for number in found.numbers:
            truth, file = value(true, number.key), value(FILE, number.key)
            if number.place is not None:
                truth = truth[0] / file[0] if number.place == ALL else truth[number.place]
            told.setdefault(number.key, []).append(number.told)
            held.setdefault(number.key, []).append(
                bool(number.told and abs(number.found - truth) <= number.interval)
            )
    return {
        "mechanism": mechanism, "seeds": seeds, "before": float(np.median(before)), "after": float(np.median(after)),
        "told": {key: sum(each) for key, each in told.items()}, "of": {key: len(each) for key, each in told.items()},
        "held": {key: sum(each) for key, each in held.items()},
    }  # fmt: skip


def scored(name: str, found: PlantFit) -> dict[str, Any]:
    logs = []
    for each in found.logs:
        factor, unit = UNITS[each.log.quantity]
        errors = {key: factor * rms for key, rms in each.errors.items() if math.isfinite(rms)}
        span = factor * float(np.ptp(each.log.response))
        logs.append(
            {
                "log": each.log.name,
                "tested": each.log.tested,
                "unit": unit,
                "span": span,
                "errors": errors,
            }
        )
    told = [
        [number.key, number.place, number.found, number.interval]
        for number in found.numbers
        if number.told
    ]
    return {"name": name, "logs": logs, "told": told, "numbers": len(found.numbers)}


def measured_map(form: str) -> dict[str, Any]:
    changes: dict[str, object] = {"muscle.dmsp20.length_m": 0.296}
    if form == "exponential":
        changes |= {
            "map.sarosi20": {"form": form, "coefficients": SAROSI},
            "muscle.dmsp20.map": "sarosi20",
        }
    k, p = (
        each.ravel()
        for each in np.meshgrid(
            1 - muscles_kit.MEASURED_LENGTH / 0.296, muscles_kit.MEASURED_PRESSURE
        )
    )
    log = RigLog(
        "DMSP-20-300", "force", muscles_kit.MEASURED_FORCE.ravel(), np.stack([p, p], axis=1), k
    )
    return scored(f"measured map, form {form}", fit_plant(FILE.with_changes(changes), 6, [log]))


def table(name: str) -> Any:
    with gzip.open(DATA / name / "data.csv.gz", "rt") as stream:
        return np.genfromtxt(stream, delimiter=",", names=True, dtype=None, encoding=None)


def wrist() -> dict[str, Any]:
    rows = table("pam_wrist_joint")
    pressure = np.stack([1e6 * rows["pressure_mpa"], np.full(rows.size, 2e5)], axis=1).clip(min=0.0)
    log = RigLog("wrist", "angle", np.radians(rows["angle_deg"]), pressure, np.zeros(rows.size), rows["time_s"],
                 of_joint=True)  # fmt: skip
    return scored("pam_wrist_joint", fit_plant(FILE, 6, [log]))


def segment() -> dict[str, Any]:
    """Pouches, no braided muscles: they pull at a tenth of a bar, so that the start is a joint all but uncontracted.

    Tilts of a run count from whatever its first sample was: here from the run's mean.
    """
    rows, logs = table("pneumatic_arm_segment"), []
    for k, run in enumerate(("oct28_exp1", "oct28_exp5", "oct28_exp9")):
        part = rows[(rows["run"] == run) & (rows["time_s"] > 12.0)]
        pressure = PSI * np.stack(
            [part["pressure_interp_psi"], part["pressure_seg1_pouch1_psi"]], axis=1
        )
        tilt = part["tilt_rad"] * np.sign(
            np.corrcoef(part["pressure_interp_psi"], part["tilt_rad"])[0, 1]
        )
        logs.append(RigLog(run, "angle", tilt - tilt.mean(), pressure.clip(min=0.0), np.zeros(part.size),
                           part["time_s"], of_joint=True, tested=k > 0))  # fmt: skip
    return scored("pneumatic_arm_segment", fit_plant(FILE.with_changes(SOFT), 6, logs))


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seeds", type=int, default=8)
    parser.add_argument("--out", type=Path)
    given = parser.parse_args()
    found = {
        "generated": [
            generated(mechanism, given.seeds) for mechanism in ("maxwell-slip", "preisach", "dahl")
        ],
        "real": [measured_map("tool"), measured_map("exponential")],
    }
    for name, run in (("pam_wrist_joint", wrist), ("pneumatic_arm_segment", segment)):
        if (DATA / name).is_dir():
            found["real"].append(run())
        else:
            print(f"{name} is not in {DATA.parent.name}/{DATA.name} beside the project: left out")
    if given.out is not None:
        save(given.out, found)
    print(json.dumps(found, indent=1))


if __name__ == "__main__":
    main()
