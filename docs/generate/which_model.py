"""Tables and figure of explanation/which-model-when.md, from the run that lies in benchmarks/results/compare.json.

python benchmarks/compare.py --out benchmarks/results/compare.json
"""

from __future__ import annotations

import itertools
import json
import sys
from collections import Counter
from functools import cache
from math import log
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure

BENCHMARKS = Path(__file__).resolve().parents[2] / "benchmarks"
sys.path.insert(0, str(BENCHMARKS))

from compare import carried  # noqa: E402 - found through the path above

RESULT = BENCHMARKS / "results" / "compare.json"
MUTED, INK = "#566170", "#1b2530"
COLOURS = ("#0a4a7a", "#5aa2d0", "#dbe9f3", "#f6d9bd", "#d55e00")
SAME = 1.005  # times another error, up to which the two are called the same
WORST = 10.0  # times the best error, where the colours end


@cache
def result() -> dict[str, Any]:
    """The run."""
    found: dict[str, Any] = json.loads(RESULT.read_text(encoding="utf-8"))
    return found


def page() -> str:
    """All tables."""
    return "\n\n".join([_families(), _gains(), _carried(), _together(), _seconds()])


def logs() -> dict[str, list[dict[str, Any]]]:
    """Log -> its runs, in the order of the benchmark."""
    found: dict[str, list[dict[str, Any]]] = {}
    for row in result()["logs"]:
        found.setdefault(row["log"], []).append(row)
    return found


def error(row: dict[str, Any], family: str) -> float:
    """Held-out error of a family on a run, percent of range; infinite where it could not be identified."""
    test = row["families"][family]["test"]
    return (
        float("inf")
        if test is None or test["rmse_percent"] is None
        else float(test["rmse_percent"])
    )


def families() -> list[str]:
    """Families, the one that is nearest to the best one in the middle of all logs first."""
    names = result()["logs"][0]["families"]

    def typical(name: str) -> float:
        return median(
            median(error(row, name) / _best(row) for row in rows) for rows in logs().values()
        )

    return sorted(names, key=typical)


def _best(row: dict[str, Any]) -> float:
    return error(row, row["chosen"])


def _families() -> str:
    """Median held-out error of each family on each log; the smallest bold, those that tie with it starred."""
    of = logs()
    heads = [
        f"{rows[0]['kind']}{f' ({len(rows)} runs)' if len(rows) > 1 else ''}"
        for rows in of.values()
    ]
    typical = {
        key: {name: median(error(row, name) for row in rows) for name in families()}
        for key, rows in of.items()
    }
    lines = [f"| family | {' | '.join(heads)} |", "|---|" + "---|" * len(of)]
    for name in families():
        cells = []
        for key, rows in of.items():
            value = typical[key][name]
            ties = sum(row["families"][name]["tied"] for row in rows)
            text = "-" if value == float("inf") else _three(value)
            text = f"**{text}**" if value == min(typical[key].values()) else text
            cells.append(f"{text} *" if 2 * ties >= len(rows) else text)
        lines.append(f"| {name} | {' | '.join(cells)} |")
    return "\n".join(lines)


def _gains() -> str:
    """What `compare` chooses, beside what `identify` does by itself."""
    lines = [
        "| log | orientation | chosen on its runs | its error | family of `identify` | its error | error saved |",
        "|---|---|---|---|---|---|---|",
    ]
    for rows in logs().values():
        mine = [_best(row) for row in rows]
        auto = [row["auto"]["test"]["rmse_percent"] for row in rows]
        saved = [100.0 * (1.0 - a / b) for a, b in zip(mine, auto, strict=True)]
        cells = [
            rows[0]["kind"], _counted(row["orientation"] for row in rows), _counted(row["chosen"] for row in rows),
            _three(median(mine)), _counted(row["auto"]["family"] for row in rows), _three(median(auto)),
            _span(saved, "{:.0f}", " %"),
        ]  # fmt: skip
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines)


def _carried() -> str:
    """What the family chosen on one run does on the others of the same log."""
    lines = [
        "| log | pairs of runs | best again | tied with the best | rank there | its error over the best one "
        "| over that of `identify` | worse than `identify` |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for name, rows in logs().items():
        pairs = [pair for pair in carried(result()["logs"]) if pair["log"] == name]
        if not pairs:
            continue
        n = len(pairs)
        errors = [float("inf") if pair["percent"] is None else pair["percent"] for pair in pairs]
        best = [mine / pair["best_percent"] for mine, pair in zip(errors, pairs, strict=True)]
        auto = [mine / pair["auto_percent"] for mine, pair in zip(errors, pairs, strict=True)]
        cells = [
            rows[0]["kind"], str(n), _share(sum(pair["rank"] == 1 for pair in pairs), n),
            _share(sum(pair["tied"] for pair in pairs), n), _span([pair["rank"] for pair in pairs], "{:.3g}"),
            _span(best, "{:.2f}"), _span(auto, "{:.2f}"), _share(sum(ratio > SAME for ratio in auto), n),
        ]  # fmt: skip
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines)


def left_out(rows: list[dict[str, Any]]) -> list[tuple[dict[str, Any], str]]:
    """Each run, with the family that is best on all other runs of its log: the smallest geometric mean of its error."""
    found = []
    for left in rows:
        means = {
            name: sum(log(error(row, name)) for row in rows if row is not left)
            for name in left["families"]
        }
        found.append((left, min(means, key=lambda name: means[name])))
    return found


def _together() -> str:
    """What the family does on a run that is best on all the other runs together."""
    lines = [
        "| log | best on the other runs together | its error on the one left out, over the best one "
        "| over that of `identify` | worse than `identify` |",
        "|---|---|---|---|---|",
    ]
    for rows in logs().values():
        if len(rows) < 2:
            continue
        found = left_out(rows)
        best = [error(row, name) / _best(row) for row, name in found]
        auto = [error(row, name) / row["auto"]["test"]["rmse_percent"] for row, name in found]
        cells = [
            rows[0]["kind"], _counted(name for _, name in found), _span(best, "{:.2f}"), _span(auto, "{:.2f}"),
            _share(sum(ratio > SAME for ratio in auto), len(found)),
        ]  # fmt: skip
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines)


def _seconds() -> str:
    spent = [row["processor_seconds"] for row in result()["logs"]]
    samples = [row["samples"] for row in result()["logs"]]
    return (
        f"{len(spent)} comparisons of {len(families())} families, {min(samples)} to {max(samples)} samples: "
        f"{min(spent):.0f} to {max(spent):.0f} s of processor time each, in the middle {median(spent):.0f} s."
    )


def _three(value: float) -> str:
    """Three digits."""
    return f"{value:.3g}" if value < 100.0 else f"{value:.0f}"


def _share(part: int, whole: int) -> str:
    return f"{part} of {whole}"


def _span(values: list[float], form: str, unit: str = "") -> str:
    """The middle value, and the range where there are several."""
    middle = form.format(median(values)) + unit
    if len(values) == 1:
        return middle
    low, high = form.format(min(values)), form.format(max(values))
    return f"{middle} ({low} to {high})"


def _counted(words: Any) -> str:
    """Each word with how often it comes, the most frequent first."""
    counts = Counter(words)
    if len(counts) == 1:
        return str(next(iter(counts)))
    return ", ".join(f"{word} {count}" for word, count in counts.most_common())


def figure() -> Figure:
    """Held-out error of every family on every run, over the best one there."""
    rows, names = result()["logs"], families()
    ratio = np.array([[error(row, name) / _best(row) for row in rows] for name in names])
    drawn = Figure(figsize=(9.6, 5.6), layout="constrained")
    axes = drawn.subplots()
    shades = LinearSegmentedColormap.from_list("loss", COLOURS)
    shades.set_bad("#ffffff")
    shown = np.ma.masked_invalid(
        np.log10(np.minimum(ratio, np.where(np.isfinite(ratio), WORST, np.inf)))
    )
    mesh = axes.pcolormesh(
        shown, cmap=shades, vmin=0.0, vmax=np.log10(WORST), edgecolors="white", linewidth=1.0
    )
    for y, name in enumerate(names):
        for x, row in enumerate(rows):
            entry = row["families"][name]
            if entry["test"] is None:
                axes.text(x + 0.5, y + 0.5, "-", ha="center", va="center", color=MUTED, fontsize=9)
            elif name == row["chosen"]:
                axes.plot(x + 0.5, y + 0.5, "s", color="white", ms=6)
            elif entry["tied"]:
                axes.plot(x + 0.5, y + 0.5, "o", color="white", ms=3)
    edges, at = [0], 0
    for runs in logs().values():
        at += len(runs)
        edges.append(at)
        axes.axvline(at, color=INK, lw=1.2)
    axes.set_xticks([(a + b) / 2 for a, b in itertools.pairwise(edges)])
    kinds = [runs[0]["kind"] for runs in logs().values()]
    axes.set_xticklabels(kinds, fontsize=9, rotation=28, ha="right", rotation_mode="anchor")
    axes.set_yticks(np.arange(len(names)) + 0.5, names)
    axes.invert_yaxis()
    axes.grid(visible=False)
    axes.tick_params(length=0)
    bar = drawn.colorbar(mesh, ax=axes, shrink=0.7, ticks=np.log10([1, 2, 5, 10]))
    bar.ax.set_yticklabels(["1", "2", "5", "10 and more"])
    bar.set_label("held-out error over the smallest one of the run")
    return drawn
