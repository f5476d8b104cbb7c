"""Memory of reading and identifying logs of any length: written, identified in a process of its own, deleted.

python benchmarks/memory.py [--rows 1e6,1e7,1e8] [--family pi] [--folder DIR] [--json]

The log is an NPZ of two columns, 16 bytes a row: a noisy sine of changing amplitude at 2 kHz through an operator. The
largest resident memory of the process is what the system tells. Ends with status 1 if one exceeds 400 MB.
"""

from __future__ import annotations

import argparse
import json
import resource
import subprocess
import sys
import tempfile
import time
import zipfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import IO, Any

import numpy as np
import numpy.typing as npt
from startup import machine

import dehyst

Array = npt.NDArray[np.float64]

MOST = 400e6  # bytes, resident, of family pi
PART = 1 << 18
RATE = 2000.0
OPERATORS = 12


def inputs(rows: int) -> Iterator[Array]:
    """Input in parts: sine of 20 s, amplitude between half and one, 1 % noise."""
    rng = np.random.default_rng(0)
    for begin in range(0, rows, PART):
        t = np.arange(begin, min(begin + PART, rows)) / RATE
        swing = 0.75 + 0.25 * np.sin(t / 1000.0)
        yield swing * np.sin(2 * np.pi * t / 20.0) + 0.01 * rng.uniform(-1.0, 1.0, t.size)


def outputs(rows: int) -> Iterator[Array]:
    """What an operator and a noisy sensor make of it."""
    rng = np.random.default_rng(1)
    model = dehyst.PrandtlIshlinskii(np.arange(OPERATORS) / 20.0, [1.0, *[0.2] * (OPERATORS - 1)])
    step = model.stepper("dense")
    for x in inputs(rows):
        yield step.simulate(x)[0] + 0.005 * rng.uniform(-1.0, 1.0, x.size)


def write_log(path: Path, rows: int) -> None:
    """Write the log in parts, as numpy.savez would."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_STORED) as archive:
        for name, signal in (("pressure_bar", inputs), ("angle_deg", outputs)):
            with archive.open(f"{name}.npy", "w", force_zip64=True) as member:
                _write(member, signal, rows)


def _write(member: IO[bytes], signal: Callable[[int], Iterator[Array]], rows: int) -> None:
    header = {"descr": "<f8", "fortran_order": False, "shape": (rows,)}
    np.lib.format.write_array_header_1_0(member, header)
    for part in signal(rows):
        member.write(part.tobytes())


def identify(path: str, family: str) -> dict[str, Any]:
    """Read and identify in this process; seconds, largest memory [bytes], the answer."""
    begin = time.perf_counter()
    log = dehyst.read_log(path, "pressure", "angle", dt=1.0 / RATE)
    read = time.perf_counter()
    fit = dehyst.identify(log, family)
    end = time.perf_counter()
    scale = 1 if sys.platform == "darwin" else 1024
    return {
        "rows": log.samples,
        "kept": len(log),
        "read_seconds": round(read - begin, 2),
        "identify_seconds": round(end - read, 2),
        "resident": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * scale,
        "family": fit.family,
        "percent": round((fit.test or fit.train).rmse_percent, 4),
    }


def measure(rows: int, folder: Path | None, family: str) -> dict[str, Any]:
    """Write, identify in a process of its own, delete."""
    with tempfile.TemporaryDirectory(dir=folder) as place:
        path = Path(place) / "log.npz"
        write_log(path, rows)
        child = [sys.executable, __file__, "--identify", str(path), "--family", family]
        answer = subprocess.run(child, check=True, stdout=subprocess.PIPE, text=True)
    row: dict[str, Any] = json.loads(answer.stdout)
    return row


def main() -> None:
    """Measure, print, and fail if the limit is missed."""
    parser = argparse.ArgumentParser(
        description="Memory of an identification, for logs of different lengths."
    )
    parser.add_argument("--rows", default="1e6,1e7,1e8", help="lengths, by comma")
    parser.add_argument("--family", default="pi")
    parser.add_argument(
        "--folder", type=Path, help="where logs are written; the system's temporary folder"
    )
    parser.add_argument("--json", action="store_true", help="print JSON and nothing else")
    parser.add_argument("--identify", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.identify:
        print(json.dumps(identify(options.identify, options.family)))
        return
    rows = [
        measure(int(float(size)), options.folder, options.family)
        for size in options.rows.split(",")
    ]
    if options.json:
        print(json.dumps({"machine": machine(("dehyst", "numpy")), "results": rows}))
    else:
        print(", ".join(f"{key} {value}" for key, value in machine(("dehyst", "numpy")).items()))
        print(f"{'rows':>10} {'kept':>8} {'reading':>9} {'identify':>9} {'resident':>9}  answer")
        for row in rows:
            print(
                f"{row['rows']:10.3g} {row['kept']:8} {row['read_seconds']:7.1f} s {row['identify_seconds']:7.1f} s "
                f"{row['resident'] / 1e6:6.0f} MB  {row['family']}, {row['percent']} % of range"
            )
    resident = [row["resident"] for row in rows]
    if options.family == "pi" and max(resident) > MOST:
        sys.exit(f"too much memory: {[f'{value / 1e6:.0f} MB' for value in resident]}")


if __name__ == "__main__":
    main()
