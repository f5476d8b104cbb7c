"""How often `dehyst drift` raises a false alarm, and what it finds: rates over many generated logs.

    python benchmarks/drift.py                  # a quarter of an hour
    python benchmarks/drift.py --seeds 20       # a look
    python benchmarks/drift.py --verdicts       # how often which verdict: the table of docs/how-to/watch-for-drift.md
    python benchmarks/drift.py --refits         # true errors of the old model, of --refit and of a fresh identification

Each seed is another actuator log: the model is identified from one log and judged on others. Ends with status 1 if
false alarms exceed what was promised beyond chance (binomial, one in a thousand).
"""

from __future__ import annotations

import argparse
import json
import math
import sys
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

import dehyst

sys.path.insert(0, str(Path(__file__).parent))

from drift_rig import Course, cycling_log, logged

PROMISES = (0.05, 0.01)
CHANGES: dict[str, tuple[str, dict[str, Course | float], float]] = {
    "hysteresis 5 % smaller": ("hysteresis", {"hysteresis": 0.95}, -5.0),
    "hysteresis 10 % smaller": ("hysteresis", {"hysteresis": 0.9}, -10.0),
    "hysteresis 20 % larger": ("hysteresis", {"hysteresis": 1.2}, 20.0),
    "offset 0.1 deg": ("offset", {"offset": 0.1}, 0.1),
    "gain 1 % smaller": ("gain", {"gain": 0.99}, -1.0),
}


def identified(seed: int, cycles: int, family: str, minor: bool) -> tuple[Any, dehyst.Recording]:
    """A model and the log that it is from."""
    log = cycling_log(10_000 + seed, cycles, minor=minor, name="new")
    return dehyst.identify(log, family, n=30).model, log


def quietly(
    seeds: int,
    cycles: int,
    family: str,
    referred: bool,
    minor: bool,
    logs: int,
    least: float | None,
) -> dict[str, Any]:
    """Share of seeds in which an actuator that has not changed is called drifted."""
    alarms, begin = dict.fromkeys(PROMISES, 0), time.perf_counter()
    for seed in range(seeds):
        model, reference = identified(seed, min(cycles, 60), family, minor)
        later = [cycling_log(100 * seed + k, cycles, minor=minor) for k in range(logs)]
        for promise in PROMISES:
            found = dehyst.drift(
                model,
                later,
                reference=reference if referred else None,
                false_alarm=promise,
                least=least,
            )
            alarms[promise] += found.status == "drifted"
    return {
        "cycles": cycles, "family": family, "reference": referred, "minor": minor, "logs": logs, "least": least,
        "seeds": seeds,
        "alarms": {str(promise): count / seeds for promise, count in alarms.items()},
        "seconds": time.perf_counter() - begin,
    }  # fmt: skip


def changed(seeds: int, cycles: int, name: str, referred: bool) -> dict[str, Any]:
    """Share of seeds in which a change is found, and how large it is said to be."""
    part, wear, truth = CHANGES[name]
    found, sizes, covered = 0, [], 0
    for seed in range(seeds):
        model, reference = identified(seed, min(cycles, 60), "auto", True)
        result = dehyst.drift(
            model,
            cycling_log(seed, cycles, wear, minor=True),
            reference=reference if referred else None,
        )
        change = result.change(part)
        found += change.drifted
        sizes.append(change.estimate)
        covered += change.low <= truth <= change.high
    return {
        "change": name, "cycles": cycles, "reference": referred, "seeds": seeds, "found": found / seeds,
        "estimate": float(np.mean(sizes)), "scatter": float(np.std(sizes)), "covered": covered / seeds,
    }  # fmt: skip


def accepted(seeds: int, cycles: int, wear: Mapping[str, Course | float]) -> dict[str, Any]:
    """Share of seeds in which a new model is accepted."""
    count = 0
    for seed in range(seeds):
        model, _ = identified(seed, 40, "auto", True)
        result = dehyst.drift(model, cycling_log(seed, cycles, wear, minor=True), refit=True)
        count += result.acceptance is not None and result.acceptance.accepted
    return {
        "wear": {k: v for k, v in wear.items() if not callable(v)},
        "cycles": cycles,
        "accepted": count / seeds,
    }


# Rigs of the table of verdicts, and how they are moved and compared.
RIGS: dict[str, dict[str, Course | float]] = {
    "unchanged": {},
    "loop 20 % narrower": {"hysteresis": 0.8},
    "gain 5 % higher": {"gain": 1.05},
    "both": {"hysteresis": 0.8, "gain": 1.05},
    "offset 0.3 deg (1 % of range)": {"offset": 0.3},
    "creep 3 times as large": {"creep": 3.0},
}
MOTIONS = (
    "designed for drift, reference",
    "12 cycles, reference",
    "12 cycles, no reference",
    "6 cycles, reference",
)


def moved(motion: str, seed: int, wear: Mapping[str, Course | float]) -> dehyst.Recording:
    """Log of a rig moved as a row of the table says."""
    if not motion.startswith("designed"):
        return cycling_log(seed, int(motion.split()[0]), wear, minor=True)
    plan = dehyst.design.design_drift_motion(-2.0, 2.0, rate=2.0, unit="bar")
    t, x, _ = plan.signal(0.1)
    return logged(np.random.default_rng(seed), x, t, wear)


def verdicts(motion: str, rig: str, seeds: int) -> dict[str, Any]:
    """How often which verdict, over so many rigs, each with a model of its own from another log of 24 cycles."""
    counts = dict.fromkeys(("drifted", "unchanged", "cannot tell", "not comparable"), 0)
    for seed in range(seeds):
        model = dehyst.identify(
            cycling_log(10_000 + seed, 24, minor=True), "modified-pi", n=20
        ).model
        reference = None if "no ref" in motion else moved(motion, 20_000 + seed, {})
        counts[dehyst.drift(model, moved(motion, seed, RIGS[rig]), reference=reference).status] += 1
    return {"motion": motion, "rig": rig, "seeds": seeds, **counts}


def renewed(motion: str, seed: int) -> tuple[bool, tuple[float, float, float]]:
    """Whether a new model is accepted for a loop 20 % narrower and a gain 5 % higher, and true errors in degrees.

    Of the old model, of the one to use after --refit with two logs, and of a fresh identification of both, on cycles
    that were not logged, without noise.
    """
    reference, worn = moved(motion, 20_000 + seed, {}), RIGS["both"]
    old = dehyst.identify(reference, "modified-pi", n=20).model
    logs = [moved(motion, 2 * seed + k, worn) for k in (0, 1)]
    found = dehyst.drift(old, logs, reference=reference, refit=True)
    fresh = dehyst.identify(logs, "modified-pi", n=20, train_fraction=1.0).model
    truth = cycling_log(30_000 + seed, 24, worn, minor=True, noise=0.0)
    misses = [
        model.simulate(truth.input)[200:] - truth.output[200:]
        for model in (old, found.model, fresh)
    ]
    accepted = found.acceptance is not None and found.acceptance.accepted
    return accepted, tuple(float(np.sqrt(np.mean(miss**2))) for miss in misses)  # type: ignore[return-value]


def refits(seeds: int) -> int:
    """Print true errors; 1 if a refit that was accepted is not level with a fresh identification."""
    print(
        "| motion | rigs | accepted | old | after --refit | fresh |\n|---|---:|---:|---:|---:|---:|",
        flush=True,
    )
    level = True
    for motion in (motion for motion in MOTIONS if "no ref" not in motion):
        found = [renewed(motion, seed) for seed in range(seeds)]
        old, new, fresh = np.median([errors for _, errors in found], axis=0)
        accepted = sum(yes for yes, _ in found)
        print(
            f"| {motion} | {seeds} | {accepted} | {old:.2f} deg | {new:.3f} deg | {fresh:.3f} deg |",
            flush=True,
        )
        level &= all(errors[1] <= 1.01 * errors[2] for yes, errors in found if yes)
    return int(not level)


def beyond_chance(rate: float, seeds: int, promise: float) -> bool:
    """Whether so many alarms happen less than once in a thousand times if the promise is kept."""
    count = round(rate * seeds)
    tail = sum(
        math.comb(seeds, k) * promise**k * (1 - promise) ** (seeds - k)
        for k in range(count, seeds + 1)
    )
    return tail < 1e-3


def table(seeds: int) -> int:
    """Print how often which verdict; 1 if false alarms are beyond what was promised, by more than chance."""
    print(
        "| motion | rig | drifted | cannot tell | unchanged |\n|---|---|---:|---:|---:|", flush=True
    )
    broken = False
    for motion in MOTIONS:
        for rig in RIGS:
            row = verdicts(motion, rig, seeds if rig == "unchanged" else max(5, seeds // 4))
            shares = " | ".join(
                f"{100 * row[key] / row['seeds']:.1f} %"
                for key in ("drifted", "cannot tell", "unchanged")
            )
            print(f"| {motion} | {rig} ({row['seeds']}) | {shares} |", flush=True)
            broken |= rig == "unchanged" and beyond_chance(row["drifted"] / seeds, seeds, 0.01)
    return int(broken)


def main() -> int:
    """Run all, print rows, write them with --json."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seeds", type=int, default=200)
    parser.add_argument("--json", type=Path, default=None)
    parser.add_argument(
        "--verdicts", action="store_true", help="only how often which verdict, as a table"
    )
    parser.add_argument(
        "--refits", action="store_true", help="only what a new model is worth, as a table"
    )
    given = parser.parse_args()
    if given.refits:
        return refits(given.seeds)
    if given.verdicts:
        return table(given.seeds)
    rows: list[dict[str, Any]] = []

    def add(work: Callable[[], dict[str, Any]]) -> None:
        rows.append(work())
        print(json.dumps(rows[-1]), flush=True)

    for cycles, family, referred, minor, logs, least in (
        (12, "auto", True, True, 1, 0.0), (12, "pi", True, False, 1, 0.0), (40, "auto", True, True, 1, 0.0),
        (12, "auto", True, True, 6, 0.0), (12, "auto", True, True, 1, None), (12, "auto", False, True, 1, None),
        (12, "pi", False, False, 1, None), (40, "auto", False, True, 1, None),
    ):  # fmt: skip
        add(
            lambda c=cycles, f=family, r=referred, m=minor, n=logs, d=least: quietly(
                given.seeds, c, f, r, m, n, d
            )
        )
    add(lambda: quietly(max(5, given.seeds // 4), 490, "auto", True, True, 1, None))
    for name in CHANGES:
        for referred in (True, False):
            add(lambda n=name, r=referred: changed(max(5, given.seeds // 4), 24, n, r))
    for wear in ({}, {"hysteresis": 0.8}, {"hysteresis": 0.8, "offset": 0.5}):
        add(lambda w=wear: accepted(max(5, given.seeds // 4), 60, w))
    if given.json is not None:
        given.json.write_text(json.dumps(rows, indent=1) + "\n", encoding="utf-8")
    broken = [
        row for row in rows for promise in PROMISES
        if "alarms" in row and beyond_chance(row["alarms"][str(promise)], row["seeds"], promise)
    ]  # fmt: skip
    return 1 if broken else 0


if __name__ == "__main__":
    sys.exit(main())
