"""One real-time step of the core, dense and in O(log n): the slowest single call, and instructions by callgrind.

python benchmarks/step.py [--runs 15] [--repeat 5] [--instructions] [--json]

Compiles benchmarks/step.c with core/ by $CC (cc) with the flags of CMakeLists.txt. A step's latency is its minimum over
the runs, the worst step that of the slowest sample, the least of several repetitions: what remains is the program, not
the machine's other work. Ends with status 1 if the worst logarithmic step at n = 10 000 takes more than 200 ns, or one
at n <= 1 000 more than 300 instructions (those need valgrind; clang's code has about 15 % more of them than gcc's).
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

ROOT = Path(__file__).resolve().parents[1]
KERNEL = ROOT / "packages" / "dehyst"
FLAGS = ("-O3", "-std=c11", "-ffp-contract=off")
SIGNALS = ("sine", "noisy", "white", "wiped", "torn")  # fill() of step.c says what they are
SIZES = (14, 100, 1000, 10000)
NANOSECONDS = 200.0  # of the worst logarithmic step at n = 10 000
INSTRUCTIONS = 300  # of the worst logarithmic step at n <= 1 000
STEP = {"dense": "dehyst_model_step", "logarithmic": "dehyst_stack_step"}


def build(folder: Path, compiler: str | None = None) -> Path:
    """Compile the driver with the core; return the program."""
    program = folder / "step"
    sources = [ROOT / "benchmarks" / "step.c", *sorted((KERNEL / "core").glob("*.c"))]
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


def latency(
    program: Path, method: str, n: int, signal: str, runs: int, repeat: int
) -> dict[str, Any]:
    """Median, worst and back-to-back time of a step [ns]."""
    samples = 4 * n + 4000 if method == "logarithmic" else min(4 * n + 4000, 5_000_000 // n)
    arguments = [str(program), "latency", method, str(n), signal, str(samples), str(runs)]
    tries = []
    for _ in range(repeat):
        done = subprocess.run(arguments, capture_output=True, text=True, check=True)
        tries.append([float(word) for word in done.stdout.split()[:3]])
    median, worst, back_to_back = (min(column) for column in zip(*tries, strict=True))
    return {"median": median, "worst": worst, "back_to_back": back_to_back}


def instructions(program: Path, method: str, n: int, signal: str, samples: int) -> dict[str, Any]:
    """Mean and largest number of instructions of a step; callgrind dumps its counters before every call."""
    name = STEP[method]
    with tempfile.TemporaryDirectory() as place:
        tool = ["valgrind", "--tool=callgrind", f"--callgrind-out-file={place}/out"]
        tool += [f"--toggle-collect={name}", f"--dump-before={name}"]
        steps = [str(program), "steps", method, str(n), signal, str(samples), "1"]
        subprocess.run([*tool, *steps], capture_output=True, check=True)
        found = [
            re.search(r"(?m)^totals: (\d+)", path.read_text()) for path in Path(place).iterdir()
        ]
    counts = [
        int(match[1]) for match in found if match and int(match[1])
    ]  # the dump before the first call is empty
    if len(counts) != samples:
        raise RuntimeError(f"callgrind counted {len(counts)} steps instead of {samples}")
    return {"mean": sum(counts) / samples, "most": max(counts)}


def measure(runs: int, repeat: int, timed: bool) -> list[dict[str, Any]]:
    """Rows of the table."""
    rows = []
    counted = shutil.which("valgrind") is not None
    with tempfile.TemporaryDirectory() as place:
        program = build(Path(place))
        for n in SIZES:
            for method in STEP:
                for signal in SIGNALS if method == "logarithmic" else ("sine", "white"):
                    row: dict[str, Any] = {"n": n, "method": method, "signal": signal}
                    if timed:
                        row |= latency(program, method, n, signal, runs, repeat)
                    if counted and n <= 1000:
                        row |= instructions(
                            program,
                            method,
                            n,
                            signal,
                            2 * n + 1000 if method == "logarithmic" else 300,
                        )
                    rows.append(row)
    return rows


def missed(rows: list[dict[str, Any]]) -> list[str]:
    """Say which limits are."""
    found = []
    for row in (row for row in rows if row["method"] == "logarithmic"):
        name = f"n = {row['n']} {row['signal']}"
        if row["n"] == 10_000 and row.get("worst", 0.0) > NANOSECONDS:
            found.append(f"{name}: worst step {row['worst']:.0f} ns > {NANOSECONDS:.0f}")
        if row.get("most", 0) > INSTRUCTIONS:
            found.append(f"{name}: {row['most']} instructions > {INSTRUCTIONS}")
    return found


def main() -> None:
    """Measure, print, and fail if a limit is missed."""
    parser = argparse.ArgumentParser(
        description="Worst single step of the core, dense and in O(log n)."
    )
    parser.add_argument(
        "--runs", type=int, default=15, help="over the signal; a sample's fastest counts"
    )
    parser.add_argument(
        "--repeat", type=int, default=5, help="repetitions of that; the least counts"
    )
    parser.add_argument(
        "--instructions", action="store_true", help="count only: the same on a busy machine"
    )
    parser.add_argument("--json", action="store_true", help="print JSON and nothing else")
    options = parser.parse_args()
    if shutil.which(os.environ.get("CC", "cc")) is None:
        print("steps are not measured: there is no C compiler", file=sys.stderr)
        return
    rows = measure(options.runs, options.repeat, not options.instructions)
    if options.json:
        print(
            json.dumps(
                {
                    "machine": machine(),
                    "runs": options.runs,
                    "repeat": options.repeat,
                    "results": rows,
                }
            )
        )
    else:
        print(", ".join(f"{key} {value}" for key, value in machine().items()))
        print(
            f"{options.repeat} repetitions of {options.runs} runs; the clock's resolution is some nanoseconds\n"
        )
        columns = {
            "median": "median ns",
            "worst": "worst ns",
            "back_to_back": "b2b ns",
            "mean": "instr.",
            "most": "most",
        }
        print(
            f"{'n':>6} {'step':12} {'signal':7}"
            + "".join(f"{title:>11}" for title in columns.values())
        )
        for row in rows:
            figures = (f"{row[key]:11.0f}" if key in row else f"{'-':>11}" for key in columns)
            print(f"{row['n']:6} {row['method']:12} {row['signal']:7}" + "".join(figures))
    faults = missed(rows)
    if faults:
        sys.exit("over the limit: " + "; ".join(faults))


if __name__ == "__main__":
    main()
