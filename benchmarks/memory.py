"""Memory of an identification from logs of very different lengths: generated ones, so that no disk is needed.

python benchmarks/memory.py [--gigabytes 0.1,1,10] [--json]

The log is a noisy sine and the outputs of an operator with noise, 16 bytes a sample, made anew in every pass as a file
would be read anew. Each length runs in a process of its own, whose largest resident memory the system tells. Ends with
status 1 if it exceeds 1 GB, or if the longest log takes more than 1.1 times the memory of the shortest.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import time
from collections.abc import Iterator
from typing import Any

import numpy as np
import numpy.typing as npt
from speed import engine
from speed.signals import PERIOD, RANGE, RATE, operator, smooth
from startup import machine

from dehyst import identify_stream

Array = npt.NDArray[np.float64]

CHUNK = 1 << 17
MOST = 1e9  # bytes, resident
GROWTH = 1.1
OPERATORS = 100
TURN = int(PERIOD * RATE)  # samples


class Generated:
    """A log that exists only while it is read, the same in every pass."""

    name = "generated"

    def __init__(self, samples: int) -> None:
        self.samples = samples
        rng = np.random.default_rng(1)
        self.noise = rng.uniform(-0.01 * RANGE, 0.01 * RANGE, 2 * CHUNK)
        self.error = 1e-3 * rng.standard_normal(2 * CHUNK)
        self.wave = smooth(CHUNK + TURN)
        self.passes = 0

    def __iter__(self) -> Iterator[tuple[None, Array, Array]]:
        """Chunks from the first sample on."""
        self.passes += 1
        hysteresis = engine.evaluator(*operator(OPERATORS))
        places = np.random.default_rng(2)
        for begin in range(0, self.samples, CHUNK):
            count = min(CHUNK, self.samples - begin)
            a, b = places.integers(0, CHUNK, 2)
            phase = begin % TURN
            x = self.wave[phase : phase + count] + self.noise[a : a + count]
            yield None, x, hysteresis.run(x) + self.error[b : b + count]


def child(samples: int) -> None:
    """Identify one log and print what it took."""
    import resource

    log = Generated(samples)
    begin = time.perf_counter()
    identify_stream(log, "pi", n=OPERATORS)
    seconds = time.perf_counter() - begin
    scale = 1 if sys.platform == "darwin" else 1024
    resident = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * scale
    row = {"samples": samples, "gigabytes": 16e-9 * samples, "seconds": round(seconds, 2), "passes": log.passes,
           "ns": round(1e9 * seconds / samples, 1), "resident": resident}  # fmt: skip
    print(json.dumps(row))


def measure(gigabytes: list[float]) -> list[dict[str, Any]]:
    """One process for each length."""
    rows = []
    for size in gigabytes:
        command = [sys.executable, __file__, "--samples", str(int(size * 1e9 / 16))]
        done = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True)
        rows.append(json.loads(done.stdout))
    return rows


def main() -> None:
    """Measure, print, and fail if a limit is missed."""
    parser = argparse.ArgumentParser(description="Memory of an identification, for logs of different lengths.")
    parser.add_argument("--gigabytes", default="0.1,1,10", help="lengths, by comma")
    parser.add_argument("--samples", type=int, help="identify one log of so many samples in this process")
    parser.add_argument("--json", action="store_true", help="print JSON and nothing else")
    options = parser.parse_args()
    if options.samples:
        child(options.samples)
        return
    rows = measure([float(size) for size in options.gigabytes.split(",")])
    if options.json:
        print(json.dumps({"machine": machine(("dehyst", "numpy")), "results": rows}))
    else:
        print(", ".join(f"{key} {value}" for key, value in machine(("dehyst", "numpy")).items()))
        print(f"dehyst.identify_stream, family pi, n = {OPERATORS}; reading is generating here\n")
        print(f"{'log':>8} {'samples':>10} {'passes':>7} {'time':>8} {'a sample':>9} {'resident':>9}")
        for row in rows:
            print(
                f"{row['gigabytes']:5.1f} GB {row['samples']:10.3g} {row['passes']:7} {row['seconds']:6.1f} s "
                f"{row['ns']:6.1f} ns {row['resident'] / 1e6:6.0f} MB"
            )
    resident = [row["resident"] for row in rows]
    if max(resident) > MOST or resident[-1] > GROWTH * resident[0]:
        sys.exit(f"too much memory: {[f'{value / 1e6:.0f} MB' for value in resident]}")


if __name__ == "__main__":
    main()
