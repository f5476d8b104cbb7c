"""Table of explanation/adaptation.md, from what benchmarks/stale.py measured, which takes an hour."""

from __future__ import annotations

import csv
from collections import defaultdict
from pathlib import Path
from statistics import median

RESULT = Path(__file__).with_name("stale.csv")
COLUMNS = [
    (joint, trial, name)
    for joint in "14"
    for trial in ("slow", "fast")
    for name in ("paper", "best")
]


def table() -> str:
    """Rms error over that without compensator, the median of the seeds and the largest, and the flags of any."""
    off: dict[tuple[str, ...], float] = {}
    cells: dict[tuple[str, ...], list[tuple[float, str]]] = defaultdict(list)
    changes: dict[str, None] = {}
    with RESULT.open(encoding="utf-8", newline="") as file:
        for row in csv.DictReader(file):  # "off" stands before the others
            if row["conditions"] != "realistic":
                continue
            case, name = (
                (row["change"], row["joint"], row["trial"], row["seed"]),
                row["compensator"],
            )
            changes[row["change"]] = None
            if name == "off":
                off[case] = float(row["rms_mdeg"])
            else:
                said = "s" * bool(row["stale_s"]) + "o" * bool(row["shifted_s"])
                cells[(*case[:3], name)].append((float(row["rms_mdeg"]) / off[case], said))
    heads = [
        f"joint {joint} {trial}: paper" if name == "paper" else name
        for joint, trial, name in COLUMNS
    ]
    seeds = len({case[3] for case in off})
    lines = [f"Medians of {seeds} seeds, in brackets the largest.", ""]
    lines += [f"| change | {' | '.join(heads)} |", "|---" * (len(heads) + 1) + "|"]
    for change in changes:
        lines.append(
            f"| {change} | {' | '.join(_cell(cells[(change, *column)]) for column in COLUMNS)} |"
        )
    return "\n".join(lines)


def _cell(found: list[tuple[float, str]]) -> str:
    ratios, said = (
        [ratio for ratio, _ in found],
        "".join(flag for flag in "so" if any(flag in one for _, one in found)),
    )
    return f"{median(ratios):.2f} ({max(ratios):.2f}) {said}".rstrip()
