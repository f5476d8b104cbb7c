"""How long a user waits for the first command: processes as the shell starts them, log file included.

python benchmarks/startup.py [--runs 5] [--rows 100000] [--json]
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import statistics
import subprocess
import sys
import tempfile
import time
from importlib.metadata import version
from pathlib import Path
from typing import Any

from dehyst.io import example_recording, write_csv

PACKAGES = ("dehyst", "numpy", "typer")
EXAMPLE_SECONDS = 144.0


def write_big_log(folder: Path, rows: int) -> Path:
    """Write the example log at the rate that gives so many rows."""
    rec = example_recording(rate=(rows - 0.5) / EXAMPLE_SECONDS)
    assert rec.time is not None and len(rec) == rows
    columns = {"time_s": rec.time, "pressure_difference_bar": rec.input, "angle_deg": rec.output}
    return write_csv(folder / "big.csv", columns)


def commands(log: Path, folder: Path) -> dict[str, tuple[list[str], float]]:
    """Name -> (arguments, limit in seconds)."""
    pair = ["--input", "pressure_difference_bar", "--output", "angle_deg"]
    model = folder / "model.json"
    return {
        "dehyst --help": (["--help"], 0.3),
        "dehyst inspect": (["inspect", str(log)], 2.0),
        "dehyst identify": (["identify", str(log), *pair, "--save", str(model)], 2.0),
        "dehyst identify --family pi": (["identify", str(log), *pair, "--family", "pi"], 2.0),
        "dehyst simulate": (
            ["simulate", str(model), str(log), *pair[:2], "--out", str(folder / "out.csv")],
            2.0,
        ),
    }


def measure(arguments: list[str], runs: int) -> list[float]:
    """Wall time of fresh processes [s]; the first one, which fills the caches of the disk, does not count."""
    times = []
    for _ in range(runs + 1):
        begin = time.perf_counter()
        subprocess.run(
            [sys.executable, "-m", "dehyst", *arguments], check=True, capture_output=True
        )
        times.append(time.perf_counter() - begin)
    return times[1:]


def machine(packages: tuple[str, ...] = PACKAGES) -> dict[str, Any]:
    """Where the figures come from."""
    cpu = platform.processor() or platform.machine()
    info = Path("/proc/cpuinfo")
    if info.is_file():
        cpu = next(
            (
                line.split(":")[1].strip()
                for line in info.read_text().splitlines()
                if "model name" in line
            ),
            cpu,
        )
    return {
        "cpu": cpu,
        "cores": os.cpu_count(),
        "load": round(os.getloadavg()[0], 2) if hasattr(os, "getloadavg") else None,
        "system": f"{platform.system()} {platform.release()}",
        "python": platform.python_version(),
        **{name: version(name) for name in packages},
    }


def main() -> None:
    """Measure, print, and fail if a limit is missed."""
    parser = argparse.ArgumentParser(description="Wall time of first commands, start-up included.")
    parser.add_argument("--runs", type=int, default=5, help="processes per command")
    parser.add_argument("--rows", type=int, default=100_000, help="rows of the log")
    parser.add_argument("--json", action="store_true", help="print JSON and nothing else")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        log = write_big_log(folder, options.rows)
        results = []
        for name, (arguments, limit) in commands(log, folder).items():
            times = measure(arguments, options.runs)
            results.append(
                {
                    "command": name,
                    "minimum": min(times),
                    "median": statistics.median(times),
                    "limit": limit,
                }
            )
    if options.json:
        print(
            json.dumps(
                {
                    "machine": machine(),
                    "rows": options.rows,
                    "runs": options.runs,
                    "results": results,
                }
            )
        )
    else:
        print(", ".join(f"{key} {value}" for key, value in machine().items()))
        print(f"{options.rows} rows, {options.runs} processes each\n")
        print(f"{'command':30} {'minimum':>9} {'median':>9} {'limit':>9}")
        for row in results:
            print(
                f"{row['command']:30} {row['minimum']:7.2f} s {row['median']:7.2f} s {row['limit']:7.2f} s"
            )
    slow = [row["command"] for row in results if row["median"] > row["limit"]]
    if slow:
        sys.exit(f"over the limit: {', '.join(slow)}")


if __name__ == "__main__":
    main()
