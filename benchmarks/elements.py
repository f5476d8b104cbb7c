"""One step of the element machine with 40 elements, forward and inverse: nanoseconds, rounds, instructions.

python benchmarks/elements.py [--runs 200] [--json]

Compiles benchmarks/elements.c with core/ by $CC (cc) with the flags of CMakeLists.txt. Elements of all kinds, a third
of them with maps of six points; the time of a step is the least of many runs over 1000 samples. Instructions need
valgrind. Ends with status 1 if along the sine a step forward takes more than 0.3 us or 4 000 instructions, or a step
back more than 1 us or 16 000 instructions (clang's code has two thirds more of them than gcc's).
"""

from __future__ import annotations

import argparse
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from startup import machine
from step import FLAGS, ROOT

SIGNALS = ("sine", "noisy", "white", "steps")  # fill() of elements.c says what they are
SAMPLES = 1000
NANOSECONDS = {"forward": 300.0, "inverse": 1000.0}
INSTRUCTIONS = {"forward": 4000.0, "inverse": 16000.0}
STEP = {"forward": "dehyst_elements_step", "inverse": "dehyst_elements_solve_step"}


def build(folder: Path) -> Path:
    """Compile the driver with the core; return the program."""
    program = folder / "elements"
    sources = [ROOT / "benchmarks" / "elements.c", *sorted((ROOT / "core").glob("*.c"))]
    command = [os.environ.get("CC", "cc"), *FLAGS, f"-I{ROOT / 'core'}", *map(str, sources), "-o", str(program), "-lm"]
    subprocess.run(command, check=True)
    return program


def instructions(program: Path, direction: str, signal: str) -> float:
    """Mean number of instructions of a step, by callgrind; the driver makes the outputs by steps forward first."""
    counts = []
    for runs in (1, 2):
        tool = ["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null", f"--toggle-collect={STEP[direction]}"]
        done = subprocess.run(
            [*tool, str(program), direction, signal, str(SAMPLES), str(runs)],
            capture_output=True,
            text=True,
            check=True,
        )
        found = re.search(r"Collected : (\d+)", done.stderr)
        assert found
        counts.append(int(found[1]))
    return (counts[1] - counts[0]) / SAMPLES


def measure(runs: int) -> list[dict[str, Any]]:
    """Rows of the table."""
    rows = []
    with tempfile.TemporaryDirectory() as place:
        program = build(Path(place))
        for direction in STEP:
            for signal in SIGNALS:
                words = [str(program), direction, signal, str(SAMPLES), str(runs)]
                said = subprocess.run(words, capture_output=True, text=True, check=True).stdout.split()
                row = {"step": direction, "signal": signal, "ns": float(said[0]), "rounds": float(said[1])}
                row |= {"most rounds": int(said[2]), "error": float(said[3])}
                if shutil.which("valgrind"):
                    row["instructions"] = instructions(program, direction, signal)
                rows.append(row)
    return rows


def missed(rows: list[dict[str, Any]]) -> list[str]:
    """Say which limits are, along the sine."""
    return [
        f"{row['step']} {row['signal']}: {row[key]:.0f} {key} > {limit[row['step']]:.0f}"
        for row in rows
        for key, limit in (("ns", NANOSECONDS), ("instructions", INSTRUCTIONS))
        if row["signal"] == "sine" and row.get(key, 0.0) > limit[row["step"]]
    ]


def main() -> None:
    """Measure, print, and fail if a limit is missed."""
    parser = argparse.ArgumentParser(description="One step of 40 elements, forward and inverse.")
    parser.add_argument("--runs", type=int, default=200, help="over the signal; the fastest counts")
    parser.add_argument("--json", action="store_true", help="print JSON and nothing else")
    options = parser.parse_args()
    rows = measure(options.runs)
    if options.json:
        print(json.dumps({"machine": machine(), "results": rows}))
    else:
        print(", ".join(f"{key} {value}" for key, value in machine().items()))
        for row in rows:
            print(
                "  ".join(f"{key} {value:.4g}" if not isinstance(value, str) else value for key, value in row.items())
            )
    faults = missed(rows)
    if faults:
        sys.exit("over the limit: " + "; ".join(faults))


if __name__ == "__main__":
    main()
