"""Every reviewed model and controller on the simulated joint 1: errors, numbers to choose, runs to choose them, cost.

    python benchmarks/reviewed.py [--only controllers models costs] [--plants ...] [--seeds 0 1 2]
        [--models NAME ...] [--quick] [--json]

controllers: each with no compensator, the paper's, and at the first seed a direct inverse with creep; Vo-Minh's and the
paper's with Maxwell slip, too; gains derived by formula, and tuned in five slow trials on a joint that is not tested.
models: each family on the joint's own log, in the paper's controller. Writes results/reviewed.json, from which
docs/build.py makes tables and figure of docs/explanation/reviewed-controllers.md; parts that are not run are kept.
About 20 minutes of processor time; --quick: one plant, one seed, three families, nothing written.
"""

from __future__ import annotations

import argparse
import json
import math
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
from itertools import product
from pathlib import Path
from typing import Any

from result_files import save
from studies.law_study import OWN, best, ladder, period_cost, with_factor
from studies.side_by_side import (
    PLANTS,
    Joint,
    Learned,
    errors,
    learned,
    model_names,
    path_cost,
    prepared,
    with_model,
)

from dehyst.errors import SimulationError
from dehyst_robot.control._reviewed import CONTROLLERS, TUNED

RESULTS = Path(__file__).parent / "results" / "reviewed.json"
TUNED_ON = {"plant": "maxwell-slip", "seed": 7}
TRIALS = ("slow", "slow_no_integrator", "fast")
FIRST = ("pi", "modified-pi", "dahl")  # of --quick
SLOW_PLANT = (
    "bouc-wen"  # its muscles are simulated in Python: the slow trial at the first seed only
)
PARTS = ("controllers", "models", "costs")
Row = dict[str, Any]


def tuning() -> Row:
    """Ladders of all controllers, each with the compensator of its publication."""
    joint = prepared(**TUNED_ON, compensators=("paper", "maxwell-slip"))
    rungs = {name: ladder(joint, name, OWN[name]) for name in CONTROLLERS}
    return {
        "on": TUNED_ON,
        "ladders": {
            n: [[r.factor, _number(r.rms_deg), _number(r.max_deg)] for r in one]
            for n, one in rungs.items()
        },
        "chosen": {name: best(one) for name, one in rungs.items()},
        "with": {name: own or "off" for name, own in OWN.items()},
        "numbers": dict(TUNED),
    }


def costs() -> dict[str, dict[str, float]]:
    """Processor time of a period of each controller, without and with compensators. [ns]"""
    names = ("paper", "maxwell-slip", "creep")
    joint = prepared(**TUNED_ON, compensators=names)
    return {
        c: {one or "off": period_cost(joint, c, one) for one in ("", *names)} for c in CONTROLLERS
    }


def controllers(plant: str, seed: int, first: bool) -> list[Row]:
    """All controllers on one plant with one seed: the slow trial; at the first seed all trials, and creep."""
    full = first and plant != SLOW_PLANT
    joint = prepared(
        plant, seed, compensators=("paper", "maxwell-slip", *(("creep",) if full else ()))
    )
    rows = []
    for name in CONTROLLERS:
        for one in ("", "paper"):
            rows += [
                _run(joint, name, one, trial, 1.0) for trial in (TRIALS if full else TRIALS[:1])
            ]
        if name in ("paper", "vo-minh"):
            rows.append(_run(joint, name, "maxwell-slip", "slow", 1.0))
        if full:
            rows.append(_run(joint, name, "creep", "slow", 1.0))
    return rows


def retuned(plant: str, seed: int, chosen: dict[str, float]) -> list[Row]:
    """The slow trial with the gains that the ladders chose: as published, with the paper's compensator, without."""
    joint = prepared(plant, seed, compensators=("paper", "maxwell-slip"))
    cases = {
        (name, one)
        for name in CONTROLLERS
        if chosen[name] != 1.0
        for one in (OWN[name], "paper", "")
    }
    return [_run(joint, name, one, "slow", chosen[name]) for name, one in sorted(cases)]


def models(plant: str, seed: int, first: bool, names: tuple[str, ...]) -> list[Row]:
    """All families in the paper's controller on one plant with one seed."""
    joint = prepared(plant, seed)
    trials = ("slow", "slow_no_integrator") if first and plant != SLOW_PLANT else ("slow",)
    rows = []
    for name in names:
        model = learned(joint.found["paper"], name)
        told = {"plant": plant, "seed": seed, "model": name, "title": model.title, "way": model.way}
        if model.compensator is None:
            rows.append({**told, "reason": model.reason})
            continue
        cost = path_cost(model) if first else None
        told |= {
            "parameters": model.parameters,
            "seconds": model.seconds,
            "unexplained": _number(model.unexplained),
        }
        rows.append(
            {**told, "sample_ns": cost, "errors": {t: _errors(joint, model, t) for t in trials}}
        )
    return rows


def _errors(joint: Joint, model: Learned, trial: str) -> Row:
    try:
        return errors(joint, with_model(joint, model), trial)
    except SimulationError as fault:
        return {"failed": str(fault)}


def _run(joint: Joint, controller: str, compensator: str, trial: str, factor: float) -> Row:
    robot, equipment = with_factor(joint.robot, joint.equipped(compensator), controller, factor)
    told = {
        "seed": joint.seed,
        "controller": controller,
        "compensator": compensator or "off",
        "trial": trial,
    }
    try:
        return {
            **told,
            "factor": factor,
            **errors(joint, equipment, trial, bool(compensator), robot),
        }
    except SimulationError as fault:
        return {**told, "factor": factor, "failed": str(fault)}


def _number(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _job(make: Callable[..., list[Row]], plant: str, more: tuple[Any, ...]) -> list[Row]:
    return [{"plant": plant, **row} for row in make(plant, *more)]


def cases(options: argparse.Namespace) -> Iterator[tuple[str, int, bool]]:
    """Plant, seed, and whether it is the first seed; the plant in Python has that one only."""
    first = options.first
    for seed, plant in product(options.seeds, options.plants):
        if plant != SLOW_PLANT or seed == first:
            yield plant, seed, seed == first


def measured(options: argparse.Namespace) -> Row:
    """All that was asked for, in the place of what is there already of the same case; written case by case."""
    found: Row = (
        json.loads(RESULTS.read_text(encoding="utf-8"))
        if RESULTS.exists() and not options.quick
        else {}
    )
    with ProcessPoolExecutor(options.workers) as pool:
        waiting = {}
        if "controllers" in options.only:
            waiting[pool.submit(tuning)] = "tuning"
            for plant, seed, first in cases(options):
                waiting[pool.submit(_job, controllers, plant, (seed, first))] = "controllers"
        if "costs" in options.only:
            waiting[pool.submit(costs)] = "period_ns"
        if "models" in options.only:
            for plant, seed, first in cases(options):
                waiting[pool.submit(_job, models, plant, (seed, first, tuple(options.models)))] = (
                    "models"
                )
        while waiting:
            done = next(as_completed(waiting))
            kind = waiting.pop(done)
            if kind in ("tuning", "period_ns"):
                found[kind] = done.result()
            if kind == "tuning":
                told = found[kind]["chosen"]
                plants = [plant for plant in options.plants if plant != SLOW_PLANT]
                waiting |= {
                    pool.submit(_job, retuned, plant, (options.first, told)): "controllers"
                    for plant in plants
                }
            elif kind != "period_ns":
                found[kind] = _merged(found.get(kind, []), done.result())
            if not options.quick:
                save(RESULTS, found)
    return found


def _merged(old: list[Row], new: list[Row]) -> list[Row]:
    """Rows with those that were measured again in the place of the old ones, in one order whoever was ready first."""
    keys = ("plant", "seed", "model", "controller", "compensator", "trial", "factor")

    def key(row: Row) -> tuple[str, ...]:
        return tuple(str(row.get(name, "")) for name in keys)

    rows = {key(row): row for row in (*old, *new)}
    return [rows[one] for one in sorted(rows)]


def show(found: Row) -> None:
    """The slow trial, a line a row."""
    for row in found.get("controllers", []):
        if row["trial"] == "slow" and "rms_deg" in row:
            name = f"{row['controller']} x{row['factor']:g}"
            print(
                f"{row['plant']:13} {row['seed']} {name:18} {row['compensator']:13} {row['rms_deg']:.4f} deg rms"
            )
    for row in found.get("models", []):
        rms = row.get("errors", {}).get("slow", {}).get("rms_deg", math.nan)
        print(
            f"{row['plant']:13} {row['seed']} {row['model']:24} {row.get('way', ''):9} {rms:.4f} deg rms"
        )


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--only", nargs="+", default=list(PARTS), choices=PARTS)
    parser.add_argument("--plants", nargs="+", default=list(PLANTS), choices=list(PLANTS))
    parser.add_argument("--seeds", nargs="+", type=int, default=[0, 1, 2])
    parser.add_argument(
        "--models", nargs="+", default=list(model_names()), choices=list(model_names())
    )
    parser.add_argument("--first", type=int, default=0, help="seed at which everything is measured")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    if options.quick:
        options.plants, options.seeds, options.models = (
            options.plants[:1],
            options.seeds[:1],
            list(FIRST),
        )
    found = measured(options)
    if not options.quick:
        save(RESULTS, found)
    if options.json:
        print(json.dumps(found))
    else:
        show(found)


if __name__ == "__main__":
    main()
