"""A small GRU, a NARX, ridge and kernels on features, on the 26 runs of `rows.py`, beside what identify takes.

    python benchmarks/black_box.py           # all runs; a quarter of an hour on one core
    python benchmarks/black_box.py --quick   # one run of each log
    python benchmarks/black_box.py --save    # into results/black_box.json too

Every box is given the fitted half and nothing else: the held-out half of a run chooses none of its settings. It is
predicted from the input alone; the NARX begins at the last outputs of the fitted half, the others, as rows do, at the
first sample of the run. Needs jax: pip install --group bench.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
from collections.abc import Callable
from pathlib import Path
from statistics import median
from typing import Any

from result_files import save

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault(
    "XLA_FLAGS", "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1"
)

import numpy as np
from boxes.features import kernel, ridge
from boxes.narx import narx
from boxes.signals import Box, Half, Predictor, Run, run_of
from compare import DATA, recording, runs_of
from rows import CHOSEN
from rows import RESULTS as ROWS

RESULTS = Path(__file__).parent / "results" / "black_box.json"
STRETCH = (
    "pneumatic_arm_segment/oct28",
    "mr_damper/ensaio",
)  # where we want to err less than the GRU


def gru(half: Half) -> list[Predictor]:
    """Imported when it is asked for: the others do without jax."""
    from boxes.gru import gru as trained

    return trained(half)


def alone(box: Box) -> Callable[[Half], list[Predictor]]:
    """A box that has no seeds."""
    return lambda half: [box(half)]


BOXES = {"gru": gru, "narx": alone(narx), "ridge": alone(ridge), "kernel": alone(kernel)}


def scored(run: Run, box: Callable[[Half], list[Predictor]]) -> dict[str, Any]:
    """Held-out errors of a box, that of the median seed first; and what it costs."""
    begun = time.process_time()
    found = box(run.half)
    trained = time.process_time()
    errors = [run.held_out(predicted(run.x)) for predicted in found]
    compiled = time.process_time()
    found[0](run.x)
    spent = time.process_time() - compiled
    middle = sorted(errors)[len(errors) // 2]
    return {
        "test_percent": middle[0], "bias_percent": middle[1], "seeds": [rms for rms, _ in errors],
        "seconds": round((trained - begun) / len(found), 2),
        "microseconds_a_sample": round(1e6 * spent / run.x.size, 2),
    }  # fmt: skip


def key(run: dict[str, Any]) -> str:
    return f"{run['log']}/{run['run']}"


def beside(runs: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Each run with what `rows.py` kept of it: error of identify, and of the best of the seventeen by hindsight."""
    rows = {key(row): row for row in json.loads(ROWS.read_text(encoding="utf-8"))["runs"]}
    found = []
    for run in runs:
        row = rows[key(run)]
        errors = {name: box["test_percent"] for name, box in run["boxes"].items()}
        own = {"ours": row["rows"][CHOSEN]["test_percent"], "family": row["rows"][CHOSEN]["family"]}
        best = min(errors, key=lambda name: errors[name])
        found.append(
            {"run": key(run), **own, "seventeen": row["best_percent"], **errors, "best": best}
        )
    return found


def ratio(runs: list[dict[str, Any]], over: str) -> list[float]:
    """Our error over another on each run; over the best black box by hindsight where `over` is "best"."""
    return [run["ours"] / run[run["best"] if over == "best" else over] for run in runs]


def mean(ratios: list[float]) -> float:
    """Geometric mean."""
    return float(np.exp(np.mean(np.log(ratios))))


def summary(runs: list[dict[str, Any]]) -> str:
    """What is printed below the table."""
    able = beside(runs)
    lines = []
    for over in ("seventeen", *BOXES, "best"):
        ratios = ratio(able, over)
        less = sum(one < 1.0 for one in ratios)
        lines.append(
            f"ours over {over:9s} mean {mean(ratios):.2f}, median {median(ratios):.2f}, less on {less} runs"
        )
    for rig in STRETCH:
        of = [run for run in able if run["run"].startswith(rig)]
        shown = ", ".join(f"{run['ours']:.2f}/{run['gru']:.2f}" for run in of)
        lines.append(f"{rig}: ours/GRU {shown}: mean {mean(ratio(of, 'gru')):.2f}")
    return "\n".join(lines)


def main() -> int:
    """Train, print, save."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--quick", action="store_true", help="one run of each log")
    parser.add_argument("--save", action="store_true", help=f"write {RESULTS.name}")
    given = parser.parse_args()
    runs = []
    for log, name in runs_of(DATA, given.quick):
        run = run_of(recording(log, name, DATA))
        boxes = {box: scored(run, train) for box, train in BOXES.items()}
        runs.append({"log": log.name, "run": name, "samples": run.x.size, "boxes": boxes})
        own = beside(runs[-1:])[0]
        print(
            f"{own['run']:34s} seventeen {own['seventeen']:5.2f} ours {own['ours']:5.2f}  "
            + "  ".join(f"{box} {found['test_percent']:5.2f}" for box, found in boxes.items())
            + f"  seeds {', '.join(f'{e:.2f}' for e in boxes['gru']['seeds'])}  "
            + "/".join(f"{found['seconds']:.1f}" for found in boxes.values()) + " s",
            flush=True,
        )  # fmt: skip
    print(summary(runs))
    if given.save:
        save(RESULTS, {"runs": runs})
    return 0


if __name__ == "__main__":
    sys.exit(main())
