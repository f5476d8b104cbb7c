"""The sensitivity table of explanation/the-experiment.md, from the table that the sweep wrote.

    dehyst sweep examples/sensitivity.toml --out docs/generate/sensitivity.csv

takes some minutes, so it is not run with the other pages: its result lies beside this file. A result of another sweep
file is refused.
"""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

from dehyst_robot.experiments import Summary
from dehyst_robot.experiments._sweep.points import expand_points, summarise
from dehyst_robot.experiments._sweep.spec import load_sweep

SWEEP = Path(__file__).resolve().parents[2] / "examples" / "sensitivity.toml"
RESULT = Path(__file__).with_name("sensitivity.csv")
CROSSED = "hysteresis.mechanism"
COMMAND = "dehyst sweep examples/sensitivity.toml --out docs/generate/sensitivity.csv"


def table() -> str:
    """Return the table, or the line to type if the sweep was not run."""
    if not RESULT.exists():
        return f"(Not run yet: `{COMMAND}`)"
    spec = load_sweep(SWEEP)
    points = expand_points(spec)
    with RESULT.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    told = [(row["study"], int(row["seed"])) for row in rows]
    if told != [(point.study, point.seed) for point in points]:
        raise ValueError(f"{RESULT.name} is not of {SWEEP.name}. Type: {COMMAND} --overwrite")
    columns: dict[str, list[Any]] = {name: [_value(row[name]) for row in rows] for name in rows[0]}
    columns["error"] = [row["error"] for row in rows]
    found = summarise(spec, points, columns)
    mechanisms = list(spec.grid[CROSSED])
    labels = list(found[0].figures)
    head = ["study", "value", *(label.partition(",")[0].replace("_", " ") for label in labels)]
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    groups: dict[tuple[str, str], dict[str, Summary]] = {}
    for row in found:
        value = ", ".join(_short(v) for key, v in row.values.items() if key != CROSSED)
        groups.setdefault((row.study, value), {})[row.values[CROSSED]] = row
    for (study, value), of in groups.items():
        cells = [" / ".join(_median(of[m], label) for m in mechanisms) for label in labels]
        lines.append(f"| {study} | {value} | {' | '.join(cells)} |")
    return "\n".join([f"Each cell: {' / '.join(mechanisms)}.", "", *lines])


def _median(row: Summary, label: str) -> str:
    figure = row.figures[label]
    if figure is None:
        return "-"
    middle, low, high = figure
    return f"{middle:.2f}" + (f" ({low:.2f}-{high:.2f})" if row.study == "seeds" else "")


def _short(value: Any) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)


def _value(text: str) -> float | None:
    try:
        return float(text)
    except ValueError:
        return None
