"""Tables of black boxes in explanation/which-model-when.md, from benchmarks/results/black_box.json and rows.json.

python benchmarks/black_box.py --save
"""

from __future__ import annotations

import json
import sys
from functools import cache
from pathlib import Path
from statistics import median
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "benchmarks"))

from black_box import BOXES, RESULTS, STRETCH, beside, mean, ratio  # noqa: E402 - found through the path above

NAMES = {"gru": "GRU", "narx": "NARX", "ridge": "ridge", "kernel": "kernel"}
HEADS = (
    {"seventeen": "best of the seventeen by hindsight"}
    | NAMES
    | {"best": "best black box by hindsight"}
)
RIGS = ("soft pneumatic arm", "magneto-rheological damper")  # of STRETCH


@cache
def runs() -> list[dict[str, Any]]:
    """What was measured of the boxes."""
    found: list[dict[str, Any]] = json.loads(RESULTS.read_text(encoding="utf-8"))["runs"]
    return found


def page() -> str:
    """All of it."""
    return "\n\n".join([_errors(), _ratios(), _costs()])


def _errors() -> str:
    """Held-out error of each, run by run; the smallest bold."""
    lines = [
        f"| run | `identify --for simulate` took | its error | {HEADS['seventeen']} | GRU, middle of three seeds "
        "| NARX | ridge | kernel |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for row, run in zip(beside(runs()), runs(), strict=True):
        seeds = run["boxes"]["gru"]["seeds"]
        least = min(row[name] for name in ("ours", "seventeen", *BOXES))
        shown = {name: f"{row[name]:.3g}" for name in ("ours", "seventeen", *BOXES)}
        shown = {
            name: f"**{text}**" if row[name] == least else text for name, text in shown.items()
        }
        shown["gru"] += f" ({min(seeds):.3g} to {max(seeds):.3g})"
        name = row["run"].rstrip("/").replace("_", " ").replace("/", ", ")
        lines.append(f"| {name} | {row['family']} | {' | '.join(shown.values())} |")
    return "\n".join(lines)


def _ratios() -> str:
    """Our error over that of each, log by log and on all runs: geometric means."""
    table = beside(runs())
    logs = {
        log: [row for row in table if row["run"].startswith(log + "/")]
        for log in (run["log"] for run in runs())
    }
    lines = [
        f"| our error over that of | {' | '.join(HEADS.values())} |",
        "|---|" + "---|" * len(HEADS),
    ]
    for name, rows in (*logs.items(), ("all runs", table)):
        cells = [f"{mean(ratio(rows, over)):.2f}" for over in HEADS]
        lines.append(f"| {name.replace('_', ' ')} ({len(rows)}) | {' | '.join(cells)} |")
    less = [f"{sum(one < 1.0 for one in ratio(table, over))} of {len(table)}" for over in HEADS]
    lines.append(f"| runs on which we err less | {' | '.join(less)} |")
    return "\n".join(lines)


def _costs() -> str:
    """The stretch, and processor time."""
    table, said = beside(runs()), []
    for prefix, kind in zip(STRETCH, RIGS, strict=True):
        rows = [row for row in table if row["run"].startswith(prefix)]
        pairs = ", ".join(f"{row['ours']:.2f} against {row['gru']:.2f}" for row in rows)
        said.append(f"{kind} {pairs}")
    seconds = {
        name: median(run["boxes"][key]["seconds"] for run in runs()) for key, name in NAMES.items()
    }
    micro = {
        name: median(run["boxes"][key]["microseconds_a_sample"] for run in runs())
        for key, name in NAMES.items()
    }
    trained = ", ".join(f"{name} {value:.2g} s" for name, value in seconds.items())
    played = ", ".join(f"{name} {value:.2g}" for name, value in micro.items())
    return (
        f"Ours against the GRU, percent: {'; '.join(said)}.\n\nProcessor time in the middle of the runs: to train "
        f"{trained} (a seed, a choice of settings); to play {played} microseconds a sample, batched on x86-64."
    )
