"""Tables of explanation/speed.md and benchmarks/README.md, from the run that lies in benchmarks/results/speed.json.

    python benchmarks/speed.py --json benchmarks/results/speed.json

takes some minutes on a machine that does nothing else, so it is not run with the other pages.
"""

from __future__ import annotations

import json
import sys
from functools import cache
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
RESULT = ROOT / "benchmarks" / "results" / "speed.json"
COMMAND = "python benchmarks/speed.py --json benchmarks/results/speed.json"
PICTURE = (
    "![Time of evaluation a sample over the number of operators: a loop in numpy, numba, dehyst for three signals, and",
    "copying the signal.](../images/speed.svg)",
)
sys.path.insert(0, str(ROOT / "benchmarks"))

from speed import table  # noqa: E402 - found through the path above


@cache
def result() -> dict[str, Any]:
    """The run."""
    found: dict[str, Any] = json.loads(RESULT.read_text(encoding="utf-8"))
    return found


def page() -> str:
    """Both kinds of tables in Markdown, with the machine."""
    if not RESULT.exists():
        return f"(Not run yet: `{COMMAND}`)"
    machine, how, *_ = table.head(result())
    return "\n".join(
        [f"{how[0].upper()}{how[1:]}; {machine}.", "", *PICTURE, "", *_limits(), *_times()]
    )


def console() -> str:
    """What the command prints."""
    if not RESULT.exists():
        return f"(Not run yet: `{COMMAND}`)"
    return "\n".join(
        ["```text no-run", *(line.rstrip() for line in table.console(result())), "```"]
    )


def times(group: str, method: str, signal: str) -> float:
    """ns a sample of one method."""
    return next(
        float(entry["methods"][method]["ns"])
        for entry in result()["times"]
        if (entry["group"], entry["signal"]) == (group, signal)
    )


def _limits() -> list[str]:
    lines = ["| figure | signal | measured | limit | |", "|---|---|---:|---:|---|"]
    for row in result()["limits"]:
        measured = "not measured" if row["measured"] is None else table.number(row["measured"])
        bound = f"{'≤' if row['sense'] == '<=' else '≥'} {table.number(row['limit'])}"
        verdict = {True: "", False: "missed", None: ""}[row["ok"]]
        lines.append(f"| {row['what']} | {row['signal']} | {measured} | {bound} | {verdict} |")
    return lines


def _times() -> list[str]:
    lines: list[str] = []
    for group, (unit, signals, rows) in table.groups(result()).items():
        lines += [
            "",
            f"| {group} [{unit}] | {' | '.join(signals)} |",
            "|---|" + "---:|" * len(signals),
        ]
        lines += [f"| {name} | {' | '.join(cells)} |" for name, cells in rows.items()]
    return lines
