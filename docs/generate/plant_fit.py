"""Tables of explanation/validate-the-plant.md, from the run that lies in benchmarks/results/plant_fit.json.

python benchmarks/plant_fit.py --out benchmarks/results/plant_fit.json
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

RESULT = Path(__file__).resolve().parents[2] / "benchmarks" / "results" / "plant_fit.json"


def page() -> str:
    """Logs of the plant with known numbers; measured muscles and joints."""
    found = json.loads(RESULT.read_text(encoding="utf-8"))
    return "\n".join([*_generated(found["generated"]), "", *_real(found["real"])])


def _generated(runs: list[dict[str, Any]]) -> list[str]:
    heads = [f"{run['mechanism']}, {run['seeds']} logs" for run in runs]
    lines = [f"| number | {' | '.join(heads)} |", f"|---|{'---|' * len(runs)}"]
    for key in runs[0]["told"]:
        cells = [f"{run['told'][key]} of {run['of'][key]}, {run['held'][key]} hold" for run in runs]
        lines.append(f"| `{key}` | {' | '.join(cells)} |")
    total = [f"{sum(run['held'].values())} of {sum(run['told'].values())}" for run in runs]
    lines.append(f"| **intervals that hold the truth** | {' | '.join(total)} |")
    errors = [f"{run['before']:.3g} → {run['after']:.3g} N" for run in runs]
    return [*lines, f"| **rms error on held-out parts, median** | {' | '.join(errors)} |"]


def _real(runs: list[dict[str, Any]]) -> list[str]:
    lines = ["| log | range | before | after | bent | numbers told |", "|---|---|---|---|---|---|"]
    for run in runs:
        for log in run["logs"]:
            errors = [log["errors"][f"held_out_{when}"] for when in ("before", "after", "bent")]
            cells = [f"{error:.3g} ({100 * error / log['span']:.1f} %)" for error in errors]
            name = run["name"] if len(run["logs"]) == 1 else f"{run['name']}, {log['log']}"
            left = ", not fitted at all" if log["tested"] else ""
            told = f"{len(run['told'])} of {run['numbers']}"
            lines.append(
                f"| {name}{left} | {log['span']:.4g} {log['unit']} | {' | '.join(cells)} | {told} |"
            )
    return lines
