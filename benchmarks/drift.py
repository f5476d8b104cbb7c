"""How often `dehyst drift` raises a false alarm, and what it finds: rates over many generated logs.

    python benchmarks/drift.py                  # a quarter of an hour
    python benchmarks/drift.py --seeds 20       # a look

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

from drift_rig import Course, cycling_log

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
    seeds: int, cycles: int, family: str, referred: bool, minor: bool, logs: int, least: float | None
) -> dict[str, Any]:
    """Share of seeds in which an actuator that has not changed is called drifted."""
    alarms, begin = dict.fromkeys(PROMISES, 0), time.perf_counter()
    for seed in range(seeds):
        model, reference = identified(seed, min(cycles, 60), family, minor)
        later = [cycling_log(100 * seed + k, cycles, minor=minor) for k in range(logs)]
        for promise in PROMISES:
            found = dehyst.drift(
                model, later, reference=reference if referred else None, false_alarm=promise, least=least
            )
            alarms[promise] += found.status != "unchanged"
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
            model, cycling_log(seed, cycles, wear, minor=True), reference=reference if referred else None
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
    return {"wear": {k: v for k, v in wear.items() if not callable(v)}, "cycles": cycles, "accepted": count / seeds}


def beyond_chance(rate: float, seeds: int, promise: float) -> bool:
    """Whether so many alarms happen less than once in a thousand times if the promise is kept."""
    count = round(rate * seeds)
    tail = sum(math.comb(seeds, k) * promise**k * (1 - promise) ** (seeds - k) for k in range(count, seeds + 1))
    return tail < 1e-3


def main() -> int:
    """Run all, print rows, write them with --json."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=200)
    parser.add_argument("--json", type=Path, default=None)
    given = parser.parse_args()
    rows: list[dict[str, Any]] = []

    def add(work: Callable[[], dict[str, Any]]) -> None:
        rows.append(work())
        print(json.dumps(rows[-1]), flush=True)

    for cycles, family, referred, minor, logs, least in (
        (12, "auto", True, True, 1, 0.0), (12, "pi", True, False, 1, 0.0), (40, "auto", True, True, 1, 0.0),
        (12, "auto", True, True, 6, 0.0), (12, "auto", True, True, 1, None), (12, "auto", False, True, 1, None),
        (12, "pi", False, False, 1, None), (40, "auto", False, True, 1, None),
    ):  # fmt: skip
        add(lambda c=cycles, f=family, r=referred, m=minor, n=logs, d=least: quietly(given.seeds, c, f, r, m, n, d))
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
