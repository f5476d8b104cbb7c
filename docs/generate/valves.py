"""Tables of how-to/valves.md, from what benchmarks/valves.py and benchmarks/closed_loop.py measured."""

from __future__ import annotations

import csv
from collections.abc import Iterable
from pathlib import Path
from statistics import median

RESULT = Path(__file__).with_name("valves.csv")
CLOSED = Path(__file__).with_name("closed_loop.csv")
Row = dict[str, str]
ANSWERS = {
    "sticking": "measurement, in automatic",
    "position": "position, in automatic",
    "manual": "measurement, test in manual",
}
VALVES = {"choudhury": "Choudhury", "kano": "Kano", "he": "He", "friction": "mass with friction"}


def _rows(path: Path) -> list[Row]:
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def sticking() -> str:
    """Return what was told of sticking valves: how often, errors, coverage."""
    rows = [row for row in _rows(RESULT) if row["valve"] != "linear"]
    heads = ("what answers", "valve", "loops", "sticks", "no sign", "not identifiable", "error of S, median (largest)",
             "S in its interval", "error of J, median", "J in its interval")  # fmt: skip
    lines = [f"| {' | '.join(heads)} |", "|---" * len(heads) + "|"]
    for group, answer in ANSWERS.items():
        for valve, name in VALVES.items():
            lines.append(_line(answer, name, _those(rows, group, valve)))
    everything = [row for row in rows if row["group"] in ANSWERS]
    lines.append(_line("all", "all", everything))
    return "\n".join(lines)


def _those(rows: Iterable[Row], group: str, valve: str) -> list[Row]:
    return [row for row in rows if row["group"] == group and row["valve"] == valve]


def _line(answer: str, name: str, rows: list[Row]) -> str:
    told = [row for row in rows if row["kind"] == "sticks"]
    cells = [
        answer,
        name,
        str(len(rows)),
        *(str(_count(rows, kind)) for kind in ("sticks", "no sign", "not identifiable")),
    ]
    for letter in "SJ":
        errors = [abs(float(row[f"{letter}_fit"]) - float(row[letter])) for row in told]
        inside = [
            float(row[f"{letter}_low"]) <= float(row[letter]) <= float(row[f"{letter}_high"])
            for row in told
        ]
        if not told:
            cells += ["", ""]
            continue
        error = f"{median(errors):.2f} %"
        if letter == "S":
            error = f"{error} ({max(errors):.2f} %)"
        cells += [error, f"{sum(inside)} of {len(told)}"]
    return f"| {' | '.join(cells)} |"


def _count(rows: Iterable[Row], kind: str) -> int:
    return sum(row["kind"] == kind for row in rows)


def controls() -> str:
    """Return what was told of loops whose valve follows, and of one with a small dead band."""
    rows = [row for row in _rows(RESULT) if row["group"] == "control" or row["valve"] == "linear"]
    lines = ["| loop | loops | sticks | no sign | not identifiable |", "|---" * 5 + "|"]
    cases: dict[str, list[Row]] = {}
    for row in rows:
        name = row["case"]
        if row["group"] != "control":
            name = f"valve that follows: {ANSWERS[row['group']]}"
        cases.setdefault(name, []).append(row)
    for name, those in cases.items():
        numbers = [str(_count(those, kind)) for kind in ("sticks", "no sign", "not identifiable")]
        lines.append(f"| {name} | {len(those)} | {' | '.join(numbers)} |")
    return "\n".join(lines)


def closed_loop() -> str:
    """Return how much worse fits of closed loops are, by reference and noise."""
    cases: dict[tuple[str, str], list[Row]] = {}
    for row in _rows(CLOSED):
        cases.setdefault((row["reference"], row["noise"]), []).append(row)
    heads = (
        "largest reference", "noise, rms", "share of the command's variance from noise", "error in closed loop, median",
        "in open loop, median", "gain in closed loop, lowest",
    )  # fmt: skip
    lines = [f"| {' | '.join(heads)} |", "|---" * len(heads) + "|"]
    for (reference, noise), rows in cases.items():
        share = max(float(row["from_noise"]) for row in rows)
        closed, planned = (
            median(float(row[name]) for row in rows) for name in ("closed_error", "open_error")
        )
        gain = min(float(row["closed_gain"]) for row in rows)
        lines.append(
            f"| {5.0 * float(reference):g} mm | {noise} mm | up to {100.0 * share:.2g} % | {closed:.2f} % | "
            f"{planned:.2f} % | {gain:.2f} |"
        )
    return "\n".join(lines)
