"""Memory of identification on a log larger than memory should hold: generated, identified in chunks, deleted.

python benchmarks/huge_log.py [--gigabytes 10] [--folder DIR] [--family auto] [--json]

The log is an NPZ of two columns, 16 bytes a sample: a noisy sine of changing amplitude at 2 kHz through an operator. A
process of its own identifies it. Ends with status 1 if that process ever held more than 1 GB.
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

LIMIT = 1e9  # bytes of resident memory
CHUNK = 1 << 18
RATE = 2000.0
OPERATORS = 12


def inputs(samples: int) -> Iterator[Array]:
    """Input in chunks: sine of 20 s, amplitude between half and one, 1 % noise."""
    rng = np.random.default_rng(0)
    for begin in range(0, samples, CHUNK):
        t = np.arange(begin, min(begin + CHUNK, samples)) / RATE
        swing = 0.75 + 0.25 * np.sin(t / 1000.0)
        yield swing * np.sin(2 * np.pi * t / 20.0) + 0.01 * rng.uniform(-1.0, 1.0, t.size)


def outputs(samples: int) -> Iterator[Array]:
    """What an operator and a noisy sensor make of it."""
    rng = np.random.default_rng(1)
    model = dehyst.PrandtlIshlinskii(np.arange(OPERATORS) / 20.0, [1.0, *[0.2] * (OPERATORS - 1)])
    step = model.stepper("dense")
    for x in inputs(samples):
        yield step.simulate(x)[0] + 0.005 * rng.uniform(-1.0, 1.0, x.size)


def write_log(path: Path, samples: int) -> None:
    """Write the log in chunks, as numpy.savez would."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_STORED) as archive:
        for name, signal in (("pressure_bar", inputs), ("angle_deg", outputs)):
            with archive.open(f"{name}.npy", "w", force_zip64=True) as member:
                _write(member, signal, samples)


def _write(member: IO[bytes], signal: Callable[[int], Iterator[Array]], samples: int) -> None:
    header = {"descr": "<f8", "fortran_order": False, "shape": (samples,)}
    np.lib.format.write_array_header_1_0(member, header)
    for part in signal(samples):
        member.write(part.tobytes())


def identify(path: str, family: str) -> dict[str, Any]:
    """Identify in this process; seconds by stage, peak memory [bytes], what was found."""
    begins: dict[str, float] = {}
    log = dehyst.open_chunks(path, "pressure", "angle")
    begin = time.perf_counter()
    fit = dehyst.identify_stream(
        log, family, progress=lambda now: begins.setdefault(now.stage, time.perf_counter() - begin)
    )
    ends = [*list(begins.values())[1:], time.perf_counter() - begin]
    return {
        "samples": fit.recordings[0].samples,
        "seconds": ends[-1],
        "stages": {name: end - at for (name, at), end in zip(begins.items(), ends, strict=True)},
        "peak_bytes": 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss,
        "family": fit.family,
        "nrmse": (fit.test or fit.train).nrmse,
    }


def run(gigabytes: float, folder: Path | None, family: str) -> dict[str, Any]:
    """Generate, identify in a process of its own, delete."""
    with tempfile.TemporaryDirectory(dir=folder) as place:
        path = Path(place) / "log.npz"
        begin = time.perf_counter()
        write_log(path, int(gigabytes * 1e9 / 16))
        written, size = time.perf_counter() - begin, path.stat().st_size
        child = [sys.executable, __file__, "--identify", str(path), "--family", family]
        done = subprocess.run(child, check=True, capture_output=True, text=True)
    return {"bytes": size, "generated_seconds": written, **json.loads(done.stdout)}


def main() -> None:
    """Print a table, or JSON."""
    parser = argparse.ArgumentParser(description="Resident memory of identification on a large log.")
    parser.add_argument("--gigabytes", type=float, default=10.0)
    parser.add_argument("--folder", type=Path, help="where the log is generated; the system's temporary folder")
    parser.add_argument("--family", default="auto")
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--identify", help=argparse.SUPPRESS)
    args = parser.parse_args()
    if args.identify:
        print(json.dumps(identify(args.identify, args.family)))
        return
    found = run(args.gigabytes, args.folder, args.family)
    ok = found["peak_bytes"] <= LIMIT
    if args.json:
        print(json.dumps({"machine": machine(), "limit_bytes": LIMIT, "ok": ok, **found}, indent=1))
    else:
        size, seconds = found["bytes"], found["seconds"]
        print(f"{size / 1e9:.1f} GB, {found['samples']} samples, generated in {found['generated_seconds']:.0f} s")
        print(f"identified ({found['family']}) in {seconds:.0f} s, {size / 1e6 / seconds:.0f} MB/s")
        for name, spent in found["stages"].items():
            print(f"  {name:<10} {spent:8.1f} s")
        print(f"largest resident memory {found['peak_bytes'] / 1e6:.0f} MB, limit {LIMIT / 1e6:.0f}")
    sys.exit(0 if ok else 1)


if __name__ == "__main__":
    main()
