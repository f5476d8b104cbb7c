"""Table of explanation/proofs.md, from the run that lies in proofs/results.json.

    make proofs

takes a quarter of an hour, so it is not run with the other pages.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
KERNEL = ROOT / "packages" / "dehyst"
RESULT = ROOT / "proofs" / "results.json"
WORDS = {True: "", False: "**does not hold**: ", None: ""}


def table() -> str:
    """Every proof of the run: claim, tool, extent, result, time."""
    if not RESULT.exists():
        return "(Not run yet: `make proofs`)"
    entries: list[dict[str, Any]] = json.loads(RESULT.read_text(encoding="utf-8"))["proofs"]
    lines = [
        "| proof | claim | tool | extent | result | s | core, date |",
        "|---|---|---|---|---|---:|---|",
    ]
    lines += [_row(entry) for entry in entries]
    return "\n".join(lines)


def _row(entry: dict[str, Any]) -> str:
    result = WORDS[entry["ok"]] + entry["result"] + (" (small numbers)" if entry["quick"] else "")
    of = f"{entry.get('core', '?')}, {entry.get('date', '?')}"
    cells = (
        f"`{entry['name']}`",
        entry["claim"],
        entry["tool"],
        entry["extent"],
        result,
        f"{entry['seconds']:.0f}",
        of,
    )
    return "| " + " | ".join(cell.replace("|", "\\|").replace("\n", " ") for cell in cells) + " |"


def page() -> str:
    """Both tables."""
    return f"{table()}\n\nDeviations from MISRA C 2012, as cppcheck's addon counts them:\n\n{deviations()}"


def deviations() -> str:
    """Every rule of MISRA C 2012, and every other note of cppcheck, from which the core deviates, with the reason."""
    listed = json.loads((KERNEL / "core" / "misra.json").read_text(encoding="utf-8"))
    lines = ["| rule | places | reason |", "|---|---:|---|"]
    for rule, entry in listed.items():
        lines.append(f"| {rule} | {sum(entry['files'].values())} | {entry['reason']} |")
    return "\n".join(lines)
