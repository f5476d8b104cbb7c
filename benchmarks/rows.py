"""Rows of elements, and what `identify --for simulate` takes, on 26 runs, against the seventeen families before them.

    python benchmarks/rows.py                # what identify takes on every run; a minute
    python benchmarks/rows.py --all          # every row by its name, too
    python benchmarks/rows.py --all --save   # the same into results/rows.json

Errors are held out, percent of range; those of the seventeen are kept in results/seventeen.json: five of them are rows
now (docs/decisions/0046). Ends with status 1 if what is taken errs more than the best of the seventeen by hindsight in
the median of the runs, or more than 0.60 of what `identify` chose in the geometric mean, or if a row errs more than
the family of its name did.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
from pathlib import Path
from typing import Any

from result_files import save

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
from compare import DATA, LOGS, MADE, recording

import dehyst
from dehyst import Recording
from dehyst.errors import DehystError
from dehyst.families import ROW_NAMES

RESULTS = Path(__file__).parent / "results" / "rows.json"
BEFORE = Path(__file__).parent / "results" / "seventeen.json"
CHOSEN = "auto"
OVER_BEST, OVER_IDENTIFY = 1.00, 0.60
DIGITS = 5  # of a ratio: errors of the seventeen are kept with six


def fitted(record: Recording, name: str) -> dict[str, Any]:
    """One row on one run, as plain numbers."""
    begun = time.process_time()
    try:
        fit = dehyst.identify(record, name, purpose="simulate")
    except DehystError as fault:
        return {"reason": str(fault)}
    assert fit.test is not None
    return {
        "test_percent": fit.test.rmse_percent, "input_percent": fit.input_error.rms_percent, "family": fit.family,
        "start": fit.certificate.initial_state, "weights": fit.certificate.nonzero_weights,
        "seconds": round(time.process_time() - begun, 2),
    }  # fmt: skip


def compared(names: tuple[str, ...], before: dict[str, Any]) -> dict[str, Any]:
    """Rows on the run of a committed comparison."""
    log = next(log for log in (*LOGS, *MADE) if log.name == before["log"])
    record = recording(log, before["run"], DATA)
    errors = {family: error for family, error in before["families"].items() if error is not None}
    best = min(errors, key=lambda family: errors[family])
    return {
        "log": before["log"], "run": before["run"], "samples": len(record), "best": best, "best_percent": errors[best],
        "identify_percent": before["identify"],
        "rows": {name: fitted(record, name) | {"before": before["families"].get(name)} for name in names},
    }  # fmt: skip


def summary(runs: list[dict[str, Any]], name: str = CHOSEN) -> dict[str, float]:
    """Ratios of a row's errors to those of today."""
    able = [run for run in runs if "test_percent" in run["rows"][name]]
    mine = np.array([run["rows"][name]["test_percent"] for run in able])
    best = mine / np.array([run["best_percent"] for run in able])
    identify = mine / np.array([run["identify_percent"] for run in able])
    same = [run["rows"][name] for run in able if run["rows"][name]["before"] is not None]
    before = np.array([row["test_percent"] / row["before"] for row in same] or [np.nan])
    return {
        "runs": len(able),
        "over_best_median": float(np.median(best)),
        "over_best_mean": float(np.exp(np.mean(np.log(best)))),
        "over_best_most": float(best.max()),
        "above_1.5": int(np.count_nonzero(best > 1.5)),
        "over_identify": float(np.exp(np.mean(np.log(identify)))),
        "over_before": float(np.exp(np.mean(np.log(before)))),
        "over_before_most": float(before.max()),
    }


def holds(found: dict[str, float]) -> bool:
    """Whether the choice is as good as promised."""
    return (
        round(found["over_best_median"], DIGITS) <= OVER_BEST
        and found["over_identify"] <= OVER_IDENTIFY
    )


def replaces(found: dict[str, float | None]) -> bool:
    """Whether a row errs no more than the family that it replaced, in the geometric mean; true if it replaced none."""
    return found["over_before"] is None or not found["over_before"] > 1.0


def main() -> int:
    """Compare, print, save."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--all", action="store_true", help="every row by its name")
    parser.add_argument("--save", action="store_true", help=f"write {RESULTS.name}")
    given = parser.parse_args()
    names = (CHOSEN, *ROW_NAMES) if given.all else (CHOSEN,)
    runs = []
    for before in json.loads(BEFORE.read_text(encoding="utf-8")):
        if not (DATA / before["log"]).is_dir() and before["log"] not in [log.name for log in MADE]:
            continue
        run = compared(names, before)
        runs.append(run)
        mine = run["rows"][CHOSEN]
        print(
            f"{run['log'] + '/' + run['run']:34s} best {run['best_percent']:5.2f} {run['best']:24s} identify "
            f"{run['identify_percent']:5.2f}  {mine['family']:18s}{mine['test_percent']:5.2f}  "
            f"{mine['test_percent'] / run['best_percent']:4.2f} of the best, {mine['seconds']:.2f} s",
            flush=True,
        )
    for name in names:
        found = summary(runs, name)
        print(f"{name:18s} " + ", ".join(f"{key} {value:.3g}" for key, value in found.items()))
    if given.save:
        save(RESULTS, {"summary": {name: summary(runs, name) for name in names}, "runs": runs})
    return 0 if holds(summary(runs)) and all(replaces(summary(runs, name)) for name in names) else 1


if __name__ == "__main__":
    sys.exit(main())
