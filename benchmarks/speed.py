"""What a sample costs, against what one would use otherwise, and whether the limits of the engine hold.

python benchmarks/speed.py [--samples 10000000] [--rounds 5] [--quick] [--json [FILE]] [--only evaluation,program]

One thread; every ratio is of minima of processor time, of runs that took turns in this process. Ends with status 1 and
a list if a limit is missed. --quick: five million samples, methods with a limit only, and a quarter of each ratio is
enough; shorter signals would be copied within the cache of large processors, and every ratio to memcpy be another one.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from result_files import save
from speed import (
    accuracy,
    commands,
    engine,
    evaluation,
    normal_equations,
    overhead,
    program,
    sums,
    table,
)
from speed.figures import Figures
from startup import machine
from threadpoolctl import threadpool_limits

from dehyst import _native

PACKAGES = ("dehyst", "numpy", "scipy")
ALTERNATIVES = ("numba", "quadprog", "daqp", "casadi")


def versions() -> dict[str, str]:
    """Versions of the alternatives; what is missing is said, not hidden."""
    found = {}
    for name in ALTERNATIVES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "not installed"
    return found


def measure(samples: int, rounds: int, quick: bool, only: set[str]) -> dict[str, Any]:
    """Run every part and return what was found."""
    figures = Figures()
    parts: dict[str, Callable[[], None]] = {
        "evaluation": lambda: evaluation.run(samples, rounds, figures, quick),
        "normal": lambda: normal_equations.run(samples, rounds, figures, quick),
        "program": lambda: program.run(rounds, figures, quick),
        "accuracy": lambda: accuracy.run(samples, figures),
        "sums": lambda: sums.run(rounds, figures),
        "overhead": lambda: overhead.run(rounds, figures),
        "commands": lambda: commands.run(min(rounds, 3), figures, quick),
    }
    for name, part in parts.items():
        if not only or name in only:
            part()
    here = machine(PACKAGES)
    here["system"] = ".".join(str(here["system"]).split(".")[:2])
    return {
        "machine": {**here, **versions(), "instructions": engine.LEVELS[_native.engine_level()]},
        "samples": samples,
        "rounds": rounds,
        "quick": quick,
        "limits": figures.rows(quick, bool(only)),
        "figures": figures.extra(),
        "times": [
            {"group": g, "signal": s, "methods": methods}
            for (g, s), methods in figures.groups.items()
        ],
    }


def main() -> None:
    """Measure, print, and fail if a limit is missed."""
    parser = argparse.ArgumentParser(
        description="What a sample costs, against numpy, numba, BLAS and solvers."
    )
    parser.add_argument("--samples", type=int, help="of every signal; 1e7, or 5e6 with --quick")
    parser.add_argument("--rounds", type=int, default=5, help="repetitions of every method")
    parser.add_argument(
        "--quick", action="store_true", help="a short run; a quarter of each ratio is asked for"
    )
    parser.add_argument(
        "--only",
        default="",
        help="parts, by comma: evaluation, normal, program, accuracy, sums, overhead, commands",
    )
    parser.add_argument(
        "--json",
        nargs="?",
        const="-",
        metavar="FILE",
        help="JSON, to a file or instead of the tables",
    )
    options = parser.parse_args()
    samples = options.samples or (5_000_000 if options.quick else 10_000_000)
    rounds = options.rounds
    only = {name for name in options.only.split(",") if name}
    with threadpool_limits(limits=1, user_api="blas"):
        result = measure(samples, rounds, options.quick, only)
    if options.json == "-":
        print(json.dumps(result, indent=1))
    else:
        print("\n".join(table.console(result)))
        if options.json:
            save(Path(options.json), result)
    missed = [f"{row['what']} ({row['signal']})" for row in result["limits"] if row["ok"] is False]
    if missed:
        sys.exit("missed:\n  " + "\n  ".join(missed))


if __name__ == "__main__":
    main()
