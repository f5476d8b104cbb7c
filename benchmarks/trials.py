"""Error with each compensator over that without, against what it must be; on one joint of the kind arm alone.

python benchmarks/trials.py [--plants maxwell-slip preisach dahl] [--seed 0]
    [--only best gravity inertia times pressure]

best: joint 1, all trials, every compensator. gravity: joints 2 and 4. inertia: the fast trial with the exact inertia.
times: creep with time constants three times too long and too short. pressure: trials at 2 and 4 bar, weights fixed at
3 bar or scheduled. Status 1 if a figure is not as it must be.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from itertools import product
from typing import Any

from dehyst_robot.experiments import _point as point

TRIALS = ("slow", "slow_no_integrator", "fast")
COMPARED = ("off", "paper", "scaled", "direct", "creep", "best", "ilc")
SLOW = {"maxwell-slip": 0.10, "preisach": 0.10, "dahl": 0.15}
Row = tuple[str, float, float | None]


def evaluate_point(
    changes: dict[str, object], run_settings: dict[str, object] | None = None, **more: Any
) -> Any:
    """A point of the kind plant, on which these bounds were set."""
    return point.evaluate_point(
        changes, run_settings={"conditions": "kind", **(run_settings or {})}, **more
    )


def best(plant: str, seed: int) -> Iterator[Row]:
    found = evaluate_point(
        {"hysteresis.mechanism": plant}, trials=TRIALS, compensators=COMPARED, seed=seed
    )
    rms = {"slow": SLOW[plant], "slow_no_integrator": 0.10, "fast": 0.40}
    for trial, name in product(TRIALS, COMPARED[1:]):
        judged = name == "best"
        yield (
            f"{trial}, {name}, rms",
            found[f"{trial}/{name}/ratio_rms"],
            rms[trial] if judged else None,
        )
        most = 0.35 if judged and trial == "slow" else None
        yield f"{trial}, {name}, max", found[f"{trial}/{name}/ratio_max"], most
    alone = evaluate_point(
        {"hysteresis.mechanism": plant}, trials=("slow",), compensators=("off", "best"), seed=seed
    )
    yield (
        "inverse error over hysteresis on unseen loops, best",
        alone["inverse_rms_ratio_unseen"],
        0.10,
    )


def gravity(plant: str, seed: int) -> Iterator[Row]:
    for joint in (2, 4):
        found = evaluate_point(
            {"hysteresis.mechanism": plant}, joint=joint, compensators=("off", "best"), seed=seed
        )
        yield f"joint {joint}, slow, best, rms", found["slow/best/ratio_rms"], 0.25


def inertia(plant: str, seed: int) -> Iterator[Row]:
    changes = {"hysteresis.mechanism": plant, "controller.inertia_error": 0.0}
    found = evaluate_point(changes, trials=("fast",), compensators=("off", "best"), seed=seed)
    yield "fast, best, exact inertia, rms", found["fast/best/ratio_rms"], 0.10


def times(plant: str, seed: int) -> Iterator[Row]:
    for factor in (3.0, 1 / 3):
        found = evaluate_point(
            {"hysteresis.mechanism": plant},
            compensators=("off", "creep"),
            run_settings={"time_constants_factor": factor},
            seed=seed,
        )
        yield (
            f"slow, creep, time constants x {factor:.2g}, rms",
            found["slow/creep/ratio_rms"],
            0.20,
        )


def pressure(plant: str, seed: int) -> Iterator[Row]:
    for bar in (2.0, 4.0):
        found = evaluate_point(
            {"hysteresis.mechanism": plant},
            compensators=("off", "creep", "scheduled"),
            run_settings={"run_mean_pressure_bar": bar},
            seed=seed,
        )
        fixed, scheduled = (found[f"slow/{name}/ratio_rms"] for name in ("creep", "scheduled"))
        yield f"slow, {bar:g} bar, fixed, rms", fixed, None
        yield f"slow, {bar:g} bar, scheduled, rms", scheduled, fixed / 1.5


PARTS: dict[str, Callable[[str, int], Iterator[Row]]] = {
    "best": best,
    "gravity": gravity,
    "inertia": inertia,
    "times": times,
    "pressure": pressure,
}


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--plants", nargs="+", default=list(SLOW), choices=list(SLOW))
    parser.add_argument("--only", nargs="+", default=list(PARTS), choices=list(PARTS))
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    jobs = list(product(options.plants, options.only))
    good = True
    with ThreadPoolExecutor() as pool:  # the simulation does not hold Python's lock
        for (plant, _), rows in zip(
            jobs, pool.map(lambda job: list(PARTS[job[1]](job[0], options.seed)), jobs), strict=True
        ):
            for name, value, most in rows:
                fits = most is None or value <= most
                good = good and fits
                said = "" if most is None else f"  at most {most:.3f}{'' if fits else '  MISSED'}"
                print(f"{plant:13} {name:55} {value:6.3f}{said}", flush=True)
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
