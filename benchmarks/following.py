"""An offset that follows the last cycle, on the 26 runs of `rows.py`: the error with it over that without.

    python benchmarks/following.py           # what identify --for simulate takes, on every run; a minute
    python benchmarks/following.py --save    # into results/following.json, too

Each model is fitted on the first half of a run. On the second half the offset begins at 0 with no turning point seen,
and no sample depends on a measurement of its own or later. Errors are rms, percent of the output's range.
"""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path
from typing import Any

from result_files import save

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
from compare import DATA, Log, recording, runs_of

import dehyst
from dehyst.models._offset import following, offset_numbers, range_width

RESULTS = Path(__file__).parent / "results" / "following.json"
LIMITS = (0.02, 0.1)  # of the output's range


def measured(log: Log, name: str) -> dict[str, Any]:
    """Errors of the held-out half of a run, without an offset and within each limit."""
    record = recording(log, name, DATA)
    fit = dehyst.identify(record, purpose="simulate")
    half = fit.test_masks[0]
    said, seen, card = fit.predictions[0][half], record.output[half], fit.model.card
    span = (
        fit.test.rmse / fit.test.rmse_percent
    )  # a percent of the range that errors of this fit are scored by
    sizes = range_width(card.output, seen), range_width(card.input, record.input[half])

    def error(answer: np.ndarray) -> float:
        return float(np.sqrt(np.mean((answer - seen) ** 2))) / span

    return {
        "log": log.name,
        "run": name,
        "bias_percent": float(np.mean(seen - said)) / span,
        "without": error(said),
        "with": {
            str(limit): error(
                following(record.input[half], said, seen, offset_numbers(limit, *sizes))
            )
            for limit in LIMITS
        },
    }


def ratios(runs: list[dict[str, Any]], limit: float) -> np.ndarray:
    """Error with the offset over that without, run by run."""
    return np.array([run["with"][str(limit)] / run["without"] for run in runs])


def summary(runs: list[dict[str, Any]], limit: float) -> tuple[float, float, float]:
    """Geometric mean of the ratios, least and most."""
    found = ratios(runs, limit)
    return float(np.exp(np.mean(np.log(found)))), float(found.min()), float(found.max())


def main() -> int:
    """Measure, print, save."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--save", action="store_true", help=f"write {RESULTS.name}")
    given = parser.parse_args()
    runs = []
    for log, name in runs_of(DATA):
        run = measured(log, name)
        runs.append(run)
        shown = "  ".join(f"{limit}: {error:6.3f}" for limit, error in run["with"].items())
        print(
            f"{log.name + '/' + name:34s} bias {run['bias_percent']:6.2f}  without {run['without']:6.3f}  {shown}"
        )
    for limit in LIMITS:
        mean, least, most = summary(runs, limit)
        print(
            f"within {limit}: {mean:.2f} of the error in the geometric mean, {least:.2f} to {most:.2f}"
        )
    if given.save:
        save(RESULTS, {"runs": runs})
    return 0


if __name__ == "__main__":
    sys.exit(main())
