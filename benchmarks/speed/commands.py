"""What a user waits for: processor time of commands on a log, imports and reading included."""

from __future__ import annotations

import importlib.util
import os
import subprocess
import sys
import tempfile
from pathlib import Path

from startup import write_big_log

from .figures import Figures

SIGNALS = (
    "--input",
    "pressure_difference_bar",
    "--output",
    "angle_deg",
    "--time",
    "time_s",
    "--json",
)
READING = "import pandas, sys; pandas.read_csv(sys.argv[1])"
AUTO, COMPARE, FORMER, PANDAS = "identify", "compare", "identify --family pi", "reading with pandas"
LOG = "example log"


def run(rounds: int, figures: Figures, quick: bool) -> None:
    """Time the commands on the example log with 10 000 rows and, unless in a hurry, with a million."""
    for rows in (10_000,) if quick else (10_000, 1_000_000):
        with tempfile.TemporaryDirectory() as folder:
            log = str(write_big_log(Path(folder), rows))
            for name, command in commands(log).items():
                if name != COMPARE or rows > 10_000:
                    least = min(seconds(command) for _ in range(rounds))
                    figures.add(f"{name}, {rows} rows [s]", LOG, least)


def commands(log: str) -> dict[str, list[str]]:
    """Name -> what is typed."""
    dehyst = [sys.executable, "-m", "dehyst"]
    found = {
        AUTO: [*dehyst, "identify", log, *SIGNALS],
        FORMER: [*dehyst, "identify", log, *SIGNALS, "--family", "pi"],
        COMPARE: [*dehyst, "compare", log, *SIGNALS],
    }
    if importlib.util.find_spec("pandas"):
        found[PANDAS] = [sys.executable, "-c", READING, log]
    return found


def seconds(command: list[str]) -> float:
    """Processor time of a process and of all its threads. [s]"""
    before = os.times()
    subprocess.run(
        command, check=True, capture_output=True, env={**os.environ, "OMP_NUM_THREADS": "1"}
    )
    after = os.times()
    return (
        after.children_user + after.children_system - before.children_user - before.children_system
    )
