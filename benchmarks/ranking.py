"""Whether the compensator that `identify` takes by itself is the one that tracks best, on rigs that are no family.

    python benchmarks/ranking.py            # twenty rigs, five mechanisms, four seeds; some minutes
    python benchmarks/ranking.py --save     # the same into results/ranking.json

Each rig is logged, each candidate identified from the log with the same call, and its inverse asked for the demand of a
reference that was never logged. The rig is played with each demand, open loop; the error is the rms of the output less
the reference, percent of the output's range. Ends with status 1 if what `identify` takes errs more than 1.1 times the
best candidate in the median of the rigs, or more than 1.3 times on one of them.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
from result_files import save
from rigs import APPROACH, MECHANISMS, PERIOD, logged, played

import dehyst
from dehyst.errors import DehystError
from dehyst.families import ROW_NAMES

RESULTS = Path(__file__).parent / "results" / "ranking.json"
SHOWN = ("mechanism", "seed", "best", "over_best")  # of a rig, in the file
SEEDS = range(4)
CANDIDATES = (
    *(name for name in ROW_NAMES if name != "elements"),
    "pi",
    "modified-pi",
    "direct-inverse",
    "static",
)
AUTO = "auto"
MEDIAN, MOST = 1.1, 1.3


def ranked(mechanism: str, seed: int) -> dict[str, Any]:
    """Tracking errors of all candidates on one rig, percent of range."""
    rig, record, reference = logged(mechanism, seed)
    at = PERIOD * np.arange(reference.size)
    demands, found = {}, {}
    for name in (*CANDIDATES, AUTO):
        begun = time.process_time()
        try:
            fit = dehyst.identify(record, name)
            demand = fit.model.ahead(fit.model.inverse().simulate(reference, at), at)
        except DehystError as fault:
            found[name] = {"reason": str(fault)}
            continue
        demands[name] = np.clip(demand, record.input.min(), record.input.max())
        found[name] = {
            "family": fit.family, "test_percent": fit.test.rmse_percent,
            "seconds": round(time.process_time() - begun, 2),
        }  # fmt: skip
    outputs = played(rig, np.stack(list(demands.values())))[:, APPROACH:]
    for name, y in zip(demands, outputs, strict=True):
        found[name]["tracking_percent"] = float(100.0 * np.sqrt(np.mean((y - reference[APPROACH:]) ** 2)) /
                                                np.ptp(record.output))  # fmt: skip
    best = min(
        (name for name in demands if name != AUTO), key=lambda name: found[name]["tracking_percent"]
    )
    over = found[AUTO]["tracking_percent"] / found[best]["tracking_percent"]
    return {
        "mechanism": mechanism,
        "seed": seed,
        "best": best,
        "over_best": over,
        "candidates": found,
    }


def main() -> int:
    """Rank, print, save."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--save", action="store_true", help=f"write {RESULTS.name}")
    given = parser.parse_args()
    rigs = []
    for seed in SEEDS:
        for mechanism in MECHANISMS:
            one = ranked(mechanism, seed)
            rigs.append(one)
            auto, best = one["candidates"][AUTO], one["candidates"][one["best"]]
            print(
                f"{mechanism:27s} {seed}  taken {auto['family']:18s} {auto['tracking_percent']:5.2f} %   best "
                f"{one['best']:18s} {best['tracking_percent']:5.2f} %   {one['over_best']:4.2f}",
                flush=True,
            )
    over = np.array([one["over_best"] for one in rigs])
    summary = {"rigs": len(rigs), "median": float(np.median(over)), "most": float(over.max())}
    print(
        f"over the best of {len(CANDIDATES)} candidates: median {summary['median']:.2f}, most {summary['most']:.2f}"
    )
    if given.save:
        save(
            RESULTS,
            {"summary": summary, "rigs": [{key: rig[key] for key in SHOWN} for rig in rigs]},
        )
    return 0 if summary["median"] <= MEDIAN and summary["most"] <= MOST else 1


if __name__ == "__main__":
    sys.exit(main())
