"""Instructions a sample of the engine, counted by callgrind: the same on a busy machine, so a gate that never flickers.

python benchmarks/instructions.py [--json]

Compiles benchmarks/speed/driver.c with engine/ and core/ by $CC (cc) with the flags of CMakeLists.txt and counts what
one call executes. Ends with status 1 if a limit is missed, 1.5 times what gcc 12 makes of it; without valgrind or a
compiler it says so and ends with status 0.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
KERNEL = ROOT / "packages" / "dehyst"
DRIVER = ROOT / "benchmarks" / "speed" / "driver.c"
FLAGS = ("-O3", "-std=c11", "-ffp-contract=off")
LEVELS: dict[str, tuple[str, ...]] = {
    "portable": ("-DLANES_LEVEL=0",),
    "avx2": ("-DLANES_LEVEL=1", "-mavx2", "-mfma"),
}
COUNTED = {
    "evaluate": "engine_evaluator_run",
    "gram": "engine_gram_add",
    "plays": "engine_plays",
    "lugre": "engine_lugre_run",
}
SAMPLES = 200_000

SIGNALS = ("smooth", "noisy", "white")

# (what, level, n): most instructions a sample for each of the signals
LIMITS: dict[tuple[str, str, int], tuple[float, ...]] = {
    ("evaluate", "portable", 14): (16, 95, 130),
    ("evaluate", "portable", 100): (18, 100, 530),
    ("evaluate", "portable", 1000): (40, 260, 550),
    ("evaluate", "avx2", 14): (8, 45, 47),
    ("evaluate", "avx2", 100): (10, 50, 215),
    ("evaluate", "avx2", 1000): (30, 130, 515),
    ("gram", "portable", 100): (30, 435),
    ("gram", "avx2", 100): (13, 145),
    ("gram", "avx2", 1000): (64,),
    ("plays", "portable", 14): (43, 55, 307),
    ("plays", "portable", 100): (50, 182, 359),
    ("lugre", "portable", 4): (355,),
}


def build(folder: Path) -> tuple[Path, list[str]]:
    """Compile the driver; return it and the levels it has."""
    compiler = os.environ.get("CC", "cc")
    x86 = platform.machine().lower() in ("x86_64", "amd64")
    levels = [level for level in LEVELS if level == "portable" or x86]
    include = [
        f"-I{ROOT / 'packages' / 'dehyst' / 'engine'}",
        f"-I{ROOT / 'packages' / 'dehyst' / 'core'}",
    ]
    has = [f"-DENGINE_HAS_{level.upper()}" for level in levels]
    objects = []

    def compile_one(source: Path, name: str, *extra: str) -> None:
        target = folder / f"{name}.o"
        subprocess.run(
            [compiler, *FLAGS, *include, *extra, "-c", str(source), "-o", str(target)], check=True
        )
        objects.append(str(target))

    for source in [
        DRIVER,
        *sorted((KERNEL / "engine").glob("*.c")),
        *sorted((KERNEL / "core").glob("*.c")),
    ]:
        compile_one(source, f"{source.parent.name}_{source.stem}", *has)
    for level in levels:
        for source in sorted((KERNEL / "engine" / "lanes").glob("*.c")):
            compile_one(source, f"{level}_{source.stem}", *LEVELS[level])
    driver = folder / "driver"
    subprocess.run([compiler, *objects, "-o", str(driver), "-lm"], check=True)
    return driver, levels


def count(driver: Path, what: str, level: str, n: int, signal: str, samples: int) -> float:
    """Instructions a sample within the one function that is counted."""
    tool = [
        "valgrind",
        "--tool=callgrind",
        "--callgrind-out-file=/dev/null",
        "--collect-atstart=no",
    ]
    tool.append(f"--toggle-collect={COUNTED[what]}")
    arguments = [what, str(list(LEVELS).index(level)), str(n), signal, str(samples)]
    done = subprocess.run(
        [*tool, f"--toggle-collect={COUNTED[what]}", str(driver), *arguments],
        capture_output=True,
        text=True,
        check=True,
    )
    found = re.search(r"Collected : (\d+)", done.stderr)
    if found is None:
        raise RuntimeError(f"callgrind says nothing about instructions:\n{done.stderr}")
    return int(found[1]) / samples


def measure(samples: int) -> list[dict[str, Any]]:
    """Rows of the table."""
    rows = []
    with tempfile.TemporaryDirectory() as place:
        driver, levels = build(Path(place))
        for (what, level, n), most in LIMITS.items():
            for signal, limit in zip(SIGNALS, most, strict=False):
                if level not in levels:
                    continue
                found = round(count(driver, what, level, n, signal, samples), 1)
                rows.append({"what": what, "level": level, "n": n, "signal": signal, "instructions": found,
                             "limit": limit, "ok": found <= limit})  # fmt: skip
    return rows


def main() -> None:
    """Count, print, and fail if a limit is missed."""
    parser = argparse.ArgumentParser(
        description="Instructions a sample of the engine, by callgrind."
    )
    parser.add_argument("--samples", type=int, default=SAMPLES, help="of every signal")
    parser.add_argument("--json", action="store_true", help="print JSON and nothing else")
    options = parser.parse_args()
    for tool in ("valgrind", os.environ.get("CC", "cc")):
        if shutil.which(tool) is None:
            print(f"instructions are not counted: {tool} is not installed", file=sys.stderr)
            return
    rows = measure(options.samples)
    if options.json:
        print(json.dumps({"samples": options.samples, "results": rows}))
    else:
        print(f"instructions a sample, {options.samples} samples\n")
        print(f"{'':10} {'level':10} {'n':>6} {'signal':8} {'counted':>9} {'limit':>9}")
        for row in rows:
            print(
                f"{row['what']:10} {row['level']:10} {row['n']:6} {row['signal']:8} {row['instructions']:9.1f} "
                f"{row['limit']:9.0f}  {'ok' if row['ok'] else 'MISSED'}"
            )
    missed = [
        f"{row['what']} {row['level']} n = {row['n']} {row['signal']}"
        for row in rows
        if not row["ok"]
    ]
    if missed:
        sys.exit("too many instructions:\n  " + "\n  ".join(missed))


if __name__ == "__main__":
    main()
