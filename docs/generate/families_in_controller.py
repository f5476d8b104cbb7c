"""Table and figure of explanation/families-in-the-controller.md, from benchmarks/families_in_controller.py.

The benchmark takes a quarter of an hour, so its results lie beside this file.
"""

from __future__ import annotations

import csv
from pathlib import Path
from statistics import median

import numpy as np
from matplotlib.figure import Figure

RESULT = Path(__file__).with_name("families_in_controller.csv")
OFF, RECIPES = "off", ("paper", "best")
TRIALS = {"slow": "slow", "fast": "fast", "slow_no_integrator": "slow, no integrator"}
WORST_SHOWN = 1.0  # colours end where a compensator leaves the whole error
Row = dict[str, str]


def rows() -> list[Row]:
    """Return all rows of the file."""
    with RESULT.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def mechanisms() -> list[str]:
    """Return the mechanisms in the order of the file."""
    return list(dict.fromkeys(row["mechanism"] for row in rows()))


def families() -> list[str]:
    """Return what ran beside no compensator: the smallest median of the slow trial first, those without fit last."""
    names = dict.fromkeys(row["family"] for row in rows())
    del names[OFF]
    return sorted(names, key=lambda name: median(ratios(name, "slow") or [np.inf]))


def ratios(family: str, trial: str, mechanism: str = "") -> list[float]:
    """Return rms errors over those without a compensator, a ratio for each mechanism and seed, or for those of one.

    A trial that ended early counts as infinite.
    """
    of_trial = [row for row in rows() if row["trial"] == trial]
    off = {}
    for row in of_trial:
        if row["family"] == OFF:
            off[row["mechanism"], row["seed"]] = float(row["rms_mdeg"])
    values = []
    for row in of_trial:
        if row["family"] == family and mechanism in ("", row["mechanism"]):
            error = float(row["rms_mdeg"]) if row["rms_mdeg"] else np.inf
            values.append(error / off[row["mechanism"], row["seed"]])
    return values


def _median(family: str, column: str, form: str) -> str:
    values = [float(row[column]) for row in rows() if row["family"] == family and row[column]]
    return format(median(values), form) if values else ""


def _ways(family: str) -> str:
    ways = dict.fromkeys(row["way"] for row in rows() if row["family"] == family and row["way"])
    return " or ".join(ways) or "in the controller"


def table() -> str:
    """Return the lines of the table."""
    seeds = {row["seed"] for row in rows()}
    heads = ["family", "way", "weights", "left of unseen loops", *TRIALS.values()]
    heads += ["fit [s]", "ns a sample"]
    lines = [
        f"Rms over that without a compensator: median of {len(mechanisms())} mechanisms with {len(seeds)} seeds each, "
        f"in brackets the largest.",
        "",
        f"| {' | '.join(heads)} |",
        "|---" * len(heads) + "|",
    ]
    for family in families():
        name = f"**{family}**" if family in RECIPES else family
        cells = [name, _ways(family)]
        cells += [_median(family, "numbers", ".0f"), _median(family, "unexplained", ".2f")]
        for trial in TRIALS:
            values = ratios(family, trial)
            cells.append(f"{median(values):.3f} ({max(values):.2f})" if values else "no fit")
        cells += [_median(family, "fit_s", ".1f"), _median(family, "sample_ns", ".0f")]
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines)


def figure() -> Figure:
    """Slow trial: what each family leaves of the error on each mechanism, as colours and numbers."""
    names = [name for name in families() if ratios(name, "slow")]
    columns = mechanisms()
    left = np.array([[median(ratios(name, "slow", one)) for one in columns] for name in names])
    drawn = Figure(figsize=(8.4, 0.29 * len(names) + 1.4), layout="constrained")
    axes = drawn.subplots()
    shown = np.clip(left, None, WORST_SHOWN)
    image = axes.imshow(np.log10(shown), cmap="viridis_r", aspect="auto")
    ink_turns = 0.5 * sum(image.get_clim())
    for i in range(len(names)):
        for j in range(len(columns)):
            dark = np.log10(shown[i, j]) > ink_turns
            axes.text(
                j, i, f"{left[i, j]:.2f}", ha="center", va="center", fontsize=8,
                color="white" if dark else "black",
            )  # fmt: skip
    axes.set_xticks(range(len(columns)), columns)
    axes.set_yticks(range(len(names)), names)
    for label in axes.get_yticklabels():
        label.set_fontweight("bold" if label.get_text() in RECIPES else "normal")
    axes.xaxis.tick_top()
    axes.set_title("slow trial: rms error over that without a compensator", fontsize=10)
    return drawn
