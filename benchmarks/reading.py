"""How fast a text log is read, against numpy.loadtxt on the same file in the same run.

python benchmarks/reading.py [--rows 1000000] [--runs 15] [--json]
"""

from __future__ import annotations

import argparse
import hashlib
import json
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from startup import machine, write_big_log

import dehyst
from dehyst.io import read_table
from dehyst.io._delimited import read_delimited

LEAST = 5.0  # times as fast as numpy.loadtxt: the file to columns, without its fingerprint


def jobs(log: Path) -> dict[str, Callable[[], Any]]:
    """Name -> what is measured."""
    pair = {"input": "pressure_difference_bar", "output": "angle_deg"}
    data = log.read_bytes()
    return {
        "numpy.loadtxt": lambda: np.loadtxt(log, delimiter=",", skiprows=1),
        "file to columns": lambda: read_delimited(log.read_bytes(), log.name),
        "bytes to columns": lambda: read_delimited(data, log.name),
        "sha256": lambda: hashlib.sha256(data).digest(),
        "read_table, with sha256": lambda: read_table(log),
        "read_log, with all checks": lambda: dehyst.read_log(log, **pair),
    }


def measure(work: dict[str, Callable[[], Any]], runs: int) -> dict[str, float]:
    """Shortest wall time of each job [s], taken in turns, so that all see the same machine."""
    best = dict.fromkeys(work, float("inf"))
    for _ in range(runs):
        for name, job in work.items():
            begin = time.perf_counter()
            job()
            best[name] = min(best[name], time.perf_counter() - begin)
    return best


def main() -> None:
    """Measure, print, and fail if the limit is missed."""
    parser = argparse.ArgumentParser(description="Reading a text log, against numpy.loadtxt.")
    parser.add_argument("--rows", type=int, default=1_000_000, help="rows of the log, of 3 columns")
    parser.add_argument(
        "--runs", type=int, default=15, help="repetitions, of which the shortest counts"
    )
    parser.add_argument("--json", action="store_true", help="print JSON and nothing else")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as place:
        log = write_big_log(Path(place), options.rows)
        size = log.stat().st_size
        best = measure(jobs(log), options.runs)
    slowest = best["numpy.loadtxt"]
    rows = [
        {
            "what": name,
            "seconds": seconds,
            "megabytes_per_second": size / seconds / 1e6,
            "ratio": slowest / seconds,
        }
        for name, seconds in best.items()
    ]
    if options.json:
        print(
            json.dumps({"machine": machine(), "rows": options.rows, "bytes": size, "results": rows})
        )
    else:
        print(", ".join(f"{key} {value}" for key, value in machine().items()))
        print(f"{options.rows} rows, {size / 1e6:.1f} MB\n")
        print(f"{'':26} {'time':>9} {'':>10}  times as fast as loadtxt")
        for row in rows:
            time_, speed = 1e3 * row["seconds"], row["megabytes_per_second"]
            print(f"{row['what']:26} {time_:6.1f} ms {speed:5.0f} MB/s {row['ratio']:9.1f}")
    if slowest / best["file to columns"] < LEAST:
        sys.exit(
            f"under the limit: {slowest / best['file to columns']:.1f} times as fast as loadtxt instead of {LEAST:g}"
        )


if __name__ == "__main__":
    main()
