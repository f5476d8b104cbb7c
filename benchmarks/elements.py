"""One step of a block of 10 or 40 elements, forward and inverse: nanoseconds, rounds, instructions.

python benchmarks/elements.py [--runs 200] [--instructions] [--json]

Compiles benchmarks/elements.c with core/ by $CC (cc) with the flags of CMakeLists.txt. Elements of all kinds, a third
of them with maps of six points; the time of a step is the least of many runs over 1000 samples. Instructions need
valgrind. Ends with status 1 if along the sine a step of 40 elements takes more than 0.3 us forward or 1 us back, or any
signal more instructions than it may: 1.7 times what gcc 12 makes of it (clang's code has two thirds more of them).
"""

from __future__ import annotations

import argparse
import itertools
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
MANY = 40
NANOSECONDS = {"forward": 300.0, "inverse": 1000.0}  # of that many elements along the sine
INSTRUCTIONS = {  # along the sine, and along any signal
    ("forward", 10): (1300, 1300),
    ("inverse", 10): (4900, 8000),
    ("forward", 40): (4000, 4000),
    ("inverse", 40): (16000, 27000),
}
STEP = "dehyst_element_block_step"


def build(folder: Path, compiler: str | None = None) -> Path:
    """Compile the driver with the core; return the program."""
    program = folder / "elements"
    sources = [
        ROOT / "benchmarks" / "elements.c",
        *sorted((ROOT / "packages" / "dehyst" / "core").glob("*.c")),
    ]
    chosen = compiler or os.environ.get("CC", "cc")
    command = [
        chosen,
        *FLAGS,
        f"-I{ROOT / 'packages' / 'dehyst' / 'core'}",
        *map(str, sources),
        "-o",
        str(program),
        "-lm",
    ]
    subprocess.run(command, check=True)
    return program


def instructions(program: Path, direction: str, n: int, signal: str) -> float:
    """Mean number of instructions of a step, by callgrind; the driver makes the outputs by steps forward first."""
    counts = []
    for runs in (1, 2):
        tool = [
            "valgrind",
            "--tool=callgrind",
            "--callgrind-out-file=/dev/null",
            f"--toggle-collect={STEP}",
        ]
        words = [str(program), direction, str(n), signal, str(SAMPLES), str(runs)]
        done = subprocess.run([*tool, *words], capture_output=True, text=True, check=True)
        found = re.search(r"Collected : (\d+)", done.stderr)
        assert found
        counts.append(int(found[1]))
    return (counts[1] - counts[0]) / SAMPLES


def measure(runs: int, timed: bool) -> list[dict[str, Any]]:
    """Rows of the table."""
    rows = []
    with tempfile.TemporaryDirectory() as place:
        program = build(Path(place))
        for (direction, n), signal in itertools.product(INSTRUCTIONS, SIGNALS):
            words = [str(program), direction, str(n), signal, str(SAMPLES), str(runs)]
            said = subprocess.run(words, capture_output=True, text=True, check=True).stdout.split()
            row: dict[str, Any] = {
                "step": direction,
                "n": n,
                "signal": signal,
                "rounds": float(said[1]),
            }
            row |= {"most rounds": int(said[2]), "error": float(said[3])}
            if timed:
                row["ns"] = float(said[0])
            if shutil.which("valgrind"):
                row["instructions"] = instructions(program, direction, n, signal)
            rows.append(row)
    return rows


def missed(rows: list[dict[str, Any]]) -> list[str]:
    """Say which limits are."""
    found = []
    for row in rows:
        sine, any_signal = INSTRUCTIONS[row["step"], row["n"]]
        limits = {"instructions": sine if row["signal"] == "sine" else any_signal}
        if row["n"] == MANY and row["signal"] == "sine":
            limits["ns"] = NANOSECONDS[row["step"]]
        found += [f"{row['step']} of {row['n']} elements, {row['signal']}: {row[key]:.0f} {key} > {most:.0f}"
                  for key, most in limits.items() if row.get(key, 0.0) > most]  # fmt: skip
    return found


def main() -> None:
    """Measure, print, and fail if a limit is missed."""
    parser = argparse.ArgumentParser(
        description="One step of a block of 10 or 40 elements, forward and inverse."
    )
    parser.add_argument("--runs", type=int, default=200, help="over the signal; the fastest counts")
    parser.add_argument(
        "--instructions", action="store_true", help="count only: the same on a busy machine"
    )
    parser.add_argument("--json", action="store_true", help="print JSON and nothing else")
    options = parser.parse_args()
    if shutil.which(os.environ.get("CC", "cc")) is None:
        print("steps are not measured: there is no C compiler", file=sys.stderr)
        return
    rows = measure(1 if options.instructions else options.runs, not options.instructions)
    if options.json:
        print(json.dumps({"machine": machine(), "results": rows}))
    else:
        print(", ".join(f"{key} {value}" for key, value in machine().items()))
        for row in rows:
            print(
                "  ".join(
                    f"{key} {value:.4g}" if not isinstance(value, str) else value
                    for key, value in row.items()
                )
            )
    faults = missed(rows)
    if faults:
        sys.exit("over the limit: " + "; ".join(faults))


if __name__ == "__main__":
    main()
