"""Tables of explanation/the-experiment.md, from the run in benchmarks/results/paper_compensator.json.

python benchmarks/paper_compensator.py
"""

from __future__ import annotations

import json
from collections import defaultdict
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from statistics import median
from typing import Any

RESULT = Path(__file__).resolve().parents[2] / "benchmarks" / "results" / "paper_compensator.json"
TITLES = {"maxwell-slip": "Maxwell slip", "preisach": "Preisach", "dahl": "Dahl"}
READINGS = ("paper", "literal", "scaled")
TRIALS = ("fast", "slow", "slow_no_integrator")


@cache
def runs() -> dict[str, list[dict[str, Any]]]:
    """Plant -> its runs, a seed each."""
    found: dict[str, list[dict[str, Any]]] = defaultdict(list)
    for run in json.loads(RESULT.read_text(encoding="utf-8"))["runs"]:
        found[run["plant"]].append(run)
    return found


def at_rest() -> str:
    """Level and drift of the integrator's torque at rest, medians over the seeds."""
    lines = [
        "| muscles | level without | level with | drift without | drift with |",
        "|---|---|---|---|---|",
    ]
    for plant, of in runs().items():
        cells = []
        for key, factor, unit in (("level_Nm", 1.0, "Nm"), ("drift_Nm_s", 1e3, "mNm/s")):
            for name in ("off", "on"):
                values = [factor * run["rest"][name][key] for run in of]
                cells.append(f"{_ranged(values)} {unit}")
        lines.append(f"| {TITLES[plant]} | {' | '.join(cells)} |")
    return "\n".join(lines)


def twice() -> str:
    """What is left of the error on muscles that are compensated twice."""
    lines = ["| muscles | error over that without compensator |", "|---|---|"]
    for plant, of in runs().items():
        lines.append(f"| {TITLES[plant]} | {_ranged([run['twice'] for run in of])} |")
    return "\n".join(lines)


def readings() -> str:
    """Error over that without compensator with the paper's compensator read in three ways."""
    heads = [trial.replace("_", " ") for trial in TRIALS]
    lines = [f"| compensator | {' | '.join(heads)} |", "|---|---|---|---|"]
    for name in READINGS:
        cells = []
        for trial in TRIALS:
            ratios = [[run["readings"][name][trial] for run in of] for of in runs().values()]
            cells.append(" / ".join(f"{median(one):.2f}" for one in ratios))
        lines.append(f"| `{name}` | {' | '.join(cells)} |")
    plants = " / ".join(TITLES[plant] for plant in runs())
    return "\n".join([f"Each cell: {plants}.", "", *lines])


def _ranged(values: Sequence[float]) -> str:
    """The median, and the range of several."""
    spread = f" ({min(values):.2f} to {max(values):.2f})" if len(values) > 1 else ""
    return f"{median(values):.2f}{spread}"
