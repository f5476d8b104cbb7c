"""Tables of explanation/which-model-when.md on rigs of foreign physics, from the scores in benchmarks/results/zoo.

python benchmarks/zoo_of_rigs.py --rigs all --fresh -j 2
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

BENCHMARKS = Path(__file__).resolve().parents[2] / "benchmarks"
sys.path.insert(0, str(BENCHMARKS))

from zoo.rigs import DESIGN, JUDGE, RIGS  # noqa: E402 - found through the path above
from zoo.scores import AUTO, rows, summary  # noqa: E402

SCORES = BENCHMARKS / "results" / "zoo"
LENGTH = "usual"
GROUPS = {"the rules were chosen on these": DESIGN, "these judge them": JUDGE}


def page() -> str:
    """The figures over all rigs, and a table of each half."""
    parts = [_figures()]
    for title, names in GROUPS.items():
        parts.append(_table(title, names))
    return "\n\n".join(parts)


def scores_of(name: str) -> dict[str, Any]:
    """Return the scores of the usual log of a rig."""
    saved = json.loads((SCORES / f"{name}-0.json").read_text(encoding="utf-8"))
    return {"rig": name, "length": LENGTH, "entries": saved[LENGTH]["entries"]}


def _figures() -> str:
    lines = [
        "| rigs | over the best family: mean | worst | within 10 % | over the curve: mean | worst | predicted within "
        "a factor of 1.5 |",
        "|---|---|---|---|---|---|---|",
    ]
    for title, names in GROUPS.items():
        figures = summary([scores_of(name) for name in names])
        best, curve = figures["over_best"], figures["over_curve"]
        predicted = figures["predicted_at_its_speed"]
        lines.append(
            f"| {len(names)}: {title} | {best['mean']:.2f} | {best['worst']:.2f} | "
            f"{100 * best['within_10_percent']:.0f} % | {curve['mean']:.2f} | {curve['worst']:.2f} | "
            f"{100 * predicted['within_1_5']:.0f} % |"
        )
    return "\n".join(lines)


def _table(title: str, names: tuple[str, ...]) -> str:
    lines = [
        f"| {title} | taken (numbers) | scan | rests | twice as fast |",
        "|---|---|---|---|---|",
    ]
    for name in names:
        scores = scores_of(name)
        entry = scores["entries"][AUTO]
        errors = []
        for row in rows(scores):
            errors.append(f"{row['error']:.2f}, {row['over_best']:.2f} x {row['best']}")
        lines.append(
            f"| {name}: {RIGS[name].physics} | {entry['family']} ({entry['parameters']}) | "
            f"{' | '.join(errors)} |"
        )
    return "\n".join(lines)
