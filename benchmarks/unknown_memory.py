"""Unknown memory: how many random histories stay within the guaranteed interval, how far it over-estimates, what it
costs.

python benchmarks/unknown_memory.py [--histories 10000] [--samples 200] [--json]

Histories begin in an arbitrary admissible state and make strokes of all sizes; the plays that follow them are plain
numpy (tests/support/unknown_histories.py). Ends with status 1 if a single one leaves the interval.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

from dehyst import PrandtlIshlinskii, StopOperatorModel
from dehyst.models import HysteresisModel, ShearedPrandtlIshlinskii
from unknown_histories import contained, turning_path


def models() -> dict[str, HysteresisModel]:
    """A model of each kind, with thresholds of different density."""
    radii = np.array([0.0, *np.geomspace(0.02, 1.6, 14)])
    weights = np.geomspace(1.0, 0.05, radii.size)
    play = PrandtlIshlinskii(radii, weights)
    signs = np.where(np.arange(radii.size) % 3 == 1, -0.4, 1.0)
    return {
        "pi": play,
        "inverse of pi": play.inverse(),
        "stop": StopOperatorModel(radii, np.append(0.0, weights[1:]), slope=0.7),
        "weights of both signs": PrandtlIshlinskii(radii, weights * signs),
        "compensator of a sheared loop": ShearedPrandtlIshlinskii(play, shear=2.0).inverse(),
    }


def overestimate(model: HysteresisModel, samples: int) -> float:
    """Width if each play is taken by itself, over that of the interval, median over the samples where it is open."""
    x = turning_path(np.random.default_rng(5), samples, 0.6)
    low, high = model.interval(x)
    plays, _, _ = model._plays()
    bottom, top = (
        np.stack([_play(x - plays.center, r, s) for r in plays.thresholds], 1) for s in (-1.0, 1.0)
    )
    naive = np.abs(top - bottom) @ np.abs(plays.weights)
    wide = high - low > 1e-9
    return float(np.median(naive[wide] / (high - low)[wide]))


def _play(x: np.ndarray, r: float, side: float) -> np.ndarray:
    z, out = x[0] + side * r, np.empty(x.size)
    for k, value in enumerate(x):
        z = max(value - r, min(value + r, z))
        out[k] = z
    return out


def main() -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--histories", type=int, default=10_000)
    parser.add_argument("--samples", type=int, default=200)
    parser.add_argument("--json", action="store_true")
    given = parser.parse_args()
    rows: dict[str, Any] = {}
    for name, model in models().items():
        x = turning_path(np.random.default_rng(5), 20_000, 0.6)
        begin = time.perf_counter()
        model.interval(x)
        spent = time.perf_counter() - begin
        rows[name] = {
            "contained": contained(model, given.histories, given.samples, seed=1),
            "histories": given.histories,
            "play by play over interval": round(overestimate(model, given.samples), 2),
            "ms for 20 000 samples": round(1e3 * spent, 1),
        }
    if given.json:
        print(json.dumps(rows, indent=1))
    else:
        for name, row in rows.items():
            print(f"{name:30s} " + ", ".join(f"{key}: {value}" for key, value in row.items()))
    return int(any(row["contained"] < given.histories for row in rows.values()))


if __name__ == "__main__":
    sys.exit(main())
