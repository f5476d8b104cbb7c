"""The Bouc-Wen benchmark: every model of `oscillator`, hysteresis inside an oscillator, beside the published errors.

    python benchmarks/bouc_wen.py               # a minute or two on one core
    python benchmarks/bouc_wen.py --json        # the same for programs; docs/build.py draws from results/bouc_wen.json

The data are generated from the published equations (oscillator.benchmark), not downloaded. Ends with
status 1 if the white box misses 9e-6 m on the multisine test.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from pathlib import Path
from typing import Any

from result_files import save

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
from oscillator.benchmark import NOISE, PERIOD, PUBLISHED, RATE, SWEEP, SYSTEM, Row, run
from oscillator.model import BoucWenOscillator, HystereticOscillator

RESULTS = Path(__file__).parent / "results" / "bouc_wen.json"
LIMIT = 9e-6  # of the white box [m]


def loop(oscillator: Any, samples: int = 75) -> dict[str, list[float]]:
    """Force of spring and element over the position in the steady state of a sine of 10 Hz."""
    time = np.arange(samples) / RATE
    motion = oscillator.motion(
        120.0 * np.sin(2 * np.pi * 10.0 * time), time, periodic=True, steps=20
    )
    force = oscillator.stiffness * motion.position + motion.hysteretic_force
    if isinstance(oscillator, HystereticOscillator):
        force = force + oscillator.cubic * motion.position**3
    return {
        "position_mm": (1e3 * motion.position).round(5).tolist(),
        "force_N": force.round(3).tolist(),
    }


def slopes(oscillator: Any, reach: float = 250.0) -> dict[str, list[float]]:
    """dz/dy over z signed with the direction, where a model has such a curve."""
    x = np.linspace(-reach, reach, 101)
    if isinstance(oscillator, BoucWenOscillator):
        o = oscillator
        y = o.alpha - o.beta * (o.gamma * np.sign(x) + o.delta) * np.abs(x) ** o.nu
    elif oscillator.slopes:
        y = np.interp(
            x,
            np.linspace(-1, 1, len(oscillator.slopes)) * oscillator.slope_range,
            oscillator.slopes,
        )
    else:
        return {}
    return {"force_N": x.round(6).tolist(), "slope_N_per_m": np.round(y, 1).tolist()}


def entry(row: Row) -> dict[str, Any]:
    """A row as plain numbers."""
    return {
        "model": row.model, "kind": row.kind, "parameters": row.parameters, "rms_error_m": row.errors,
        "seconds": round(row.seconds, 2), **row.details, "loop": loop(row.oscillator), "slopes": slopes(row.oscillator),
    }  # fmt: skip


def line(row: Row) -> str:
    """A row of the printed table."""
    multisine, swept = row.errors["multisine"], row.errors["sweep"]
    return f"{row.model:34s}{row.kind:12s}{row.parameters:4d}{multisine:12.2e}{swept:12.2e}{row.seconds:9.1f}"


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--json", action="store_true", help="print the result for programs")
    parser.add_argument(
        "--out", type=Path, help=f"write that to a file too, such as {RESULTS.name}"
    )
    parser.add_argument(
        "--seed", type=int, default=1, help="of the estimation multisines and their noise"
    )
    parser.add_argument("--samples", type=int, default=PERIOD, help="a period; 2048 for a look")
    parser.add_argument("--swept", type=int, default=SWEEP[3], help="samples of the sweep")
    options = parser.parse_args()
    if not options.json:
        print(
            f"{'model':34s}{'kind':12s}{'par.':>4s}{'multisine':>12s}{'sweep':>12s}{'seconds':>9s}   [rms error, m]"
        )
    rows = run(
        seed=options.seed, samples=options.samples, swept=options.swept,
        report=None if options.json else lambda row: print(line(row), flush=True),
    )  # fmt: skip
    found = {
        "noise_m": NOISE, "published_multisine_m": PUBLISHED, "seed": options.seed,
        "samples": options.samples, "system": {"loop": loop(SYSTEM), "slopes": slopes(SYSTEM)},
        "models": [entry(row) for row in rows],
    }  # fmt: skip
    if options.out:
        save(options.out, found)
    if options.json:
        print(json.dumps(found, indent=1))
    else:
        print(f"\npublished on the multisine test (noise of the estimation data {NOISE:.0e} m):")
        for name, error in PUBLISHED.items():
            print(f"{name:50s}{error:12.2e}")
    return 0 if rows[-1].errors["multisine"] <= LIMIT else 1


if __name__ == "__main__":
    sys.exit(main())
