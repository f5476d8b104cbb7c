"""Tables and figure of explanation/reviewed-controllers.md, from the run in benchmarks/results/reviewed.json.

python benchmarks/reviewed.py
"""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from statistics import mean
from typing import Any

from matplotlib.figure import Figure

RESULT = Path(__file__).resolve().parents[2] / "benchmarks" / "results" / "reviewed.json"
PLANTS = {
    "maxwell-slip": "Maxwell slip",
    "preisach": "Preisach",
    "dahl": "Dahl",
    "bouc-wen": "Bouc-Wen",
}
CONTROLLERS = {
    "paper": "the paper's",
    "vo-minh": "Vo-Minh's cascade",
    "sliding-mode": "sliding mode",
    "one-valve": "one valve",
    "pid": "PID",
}
OWN = {
    "vo-minh": "maxwell-slip"
}  # what a controller was published with; the others without a compensator
GREY, BLUE, GREEN = "#8a939e", "#0072b2", "#007a5a"
Row = dict[str, Any]


@cache
def result() -> Row:
    """The run."""
    found: Row = json.loads(RESULT.read_text(encoding="utf-8"))
    return found


def runs(
    plant: str, controller: str, compensator: str, trial: str = "slow", tuned: bool = False
) -> list[Row]:
    """Runs of all seeds; `tuned`: with the gain that the ladder chose."""
    factor = result()["tuning"]["chosen"][controller] if tuned else 1.0
    wanted = {
        "plant": plant,
        "controller": controller,
        "compensator": compensator,
        "trial": trial,
        "factor": factor,
    }
    return [
        row
        for row in result()["controllers"]
        if all(row[key] == value for key, value in wanted.items())
    ]


def _derived() -> list[Row]:
    return [
        row for row in result()["controllers"] if row["factor"] == 1.0 and row["trial"] == "slow"
    ]


def figures(found: list[Row]) -> tuple[float, float] | None:
    """rms and largest error, means over the seeds; None if nothing was run or a run ended early."""
    if not found or any("failed" in row for row in found):
        return None
    return mean(row["rms_deg"] for row in found), mean(row["max_deg"] for row in found)


def cell(found: list[Row]) -> str:
    """Rms and largest error as written."""
    told = figures(found)
    return (
        "failed"
        if any("failed" in row for row in found)
        else ""
        if told is None
        else f"{told[0]:.4f}, {told[1]:.3f}"
    )


def table(head: list[str], rows: list[list[str]]) -> list[str]:
    """Lines of a table."""
    return [
        f"| {' | '.join(head)} |",
        "|---" * len(head) + "|",
        *(f"| {' | '.join(row)} |" for row in rows),
    ]


def page() -> str:
    """All tables."""
    parts = [controllers(), tuned(), other_trials(), *([models()] if result()["models"] else [])]
    return "\n\n".join("\n".join([title, "", *lines]) for title, lines in parts)


def run_on(found: list[Row]) -> list[str]:
    """Plants that there are runs of."""
    return [plant for plant in PLANTS if any(row["plant"] == plant for row in found)]


def seeds(found: list[Row]) -> str:
    """How many seeds each plant was run with, in words."""
    told = {
        title: len({row["seed"] for row in found if row["plant"] == plant})
        for plant, title in PLANTS.items()
    }
    return ", ".join(f"{title} {count}" for title, count in told.items() if count)


def controllers() -> tuple[str, list[str]]:
    """Derived gains."""
    rows, plants = [], run_on(_derived())
    for name, title in CONTROLLERS.items():
        for one in ("off", "paper", *(("maxwell-slip",) if name in ("paper", "vo-minh") else ())):
            rows.append([title, one, *(cell(runs(plant, name, one)) for plant in plants)])
    head = ["controller", "compensator", *(PLANTS[plant] for plant in plants)]
    said = f"Slow trial, gains derived by formula: rms, largest error [deg], means over seeds: {seeds(_derived())}."
    return said, table(head, rows)


def tuned() -> tuple[str, list[str]]:
    """What choosing takes, and what it gives."""
    told = result()["tuning"]
    rows = []
    for name, title in CONTROLLERS.items():
        own = told["with"][name]
        ladder = ", ".join(
            "failed" if rms is None else f"{rms:.4f}" for _, rms, _ in told["ladders"][name]
        )
        after = [figures(runs(plant, name, own, tuned=True)) for plant in list(PLANTS)[:3]]
        said = ["failed" if one is None else f"{one[0]:.4f}" for one in after]
        cost = result()["period_ns"][name]
        rows.append([title, own, str(told["numbers"][name]), ladder, f"{told['chosen'][name]:g}", *said,
                     f"{cost['off']:.0f}", f"{cost[own if own != 'off' else 'paper']:.0f}"])  # fmt: skip
    factors = ", ".join(f"{factor:g}" for factor, _, _ in told["ladders"]["paper"])
    plants = [f"{title}, tuned" for title in list(PLANTS.values())[:3]]
    head = [
        "controller",
        "as published with",
        "numbers to choose",
        f"rms [deg] at gains x {factors}",
        "chosen",
    ]
    head += [*plants, "ns a period, off", "on"]
    return (
        "Effort: five slow trials on a joint that is not among those of the tables, then rms [deg] on these.",
        table(head, rows),
    )


def other_trials() -> tuple[str, list[str]]:
    """Without integrator, fast, and with creep in the compensator: first seed."""
    rows = []
    for name, title in CONTROLLERS.items():
        for trial, one in (
            ("slow_no_integrator", "off"),
            ("slow_no_integrator", "paper"),
            ("fast", "off"),
            ("fast", "paper"),
            ("slow", "creep"),
        ):
            found = [
                [row for row in runs(plant, name, one, trial) if row["seed"] == 0]
                for plant in list(PLANTS)[:3]
            ]
            rows.append([title, trial.replace("_", " "), one, *map(cell, found)])
    head = ["controller", "trial", "compensator", *list(PLANTS.values())[:3]]
    return "Other trials, seed 0: rms, largest error [deg].", table(head, rows)


def models() -> tuple[str, list[str]]:
    """Families in the paper's controller."""
    found = result()["models"]
    rows, plants = [], run_on(found)
    for name in dict.fromkeys(row["model"] for row in found):
        mine = [row for row in found if row["model"] == name]
        fitted = [row for row in mine if "errors" in row]
        if not fitted:
            rows.append([name, "none", *[""] * (5 + len(plants))])
            continue
        errors = []
        for plant in plants:
            of = [row["errors"]["slow"] for row in fitted if row["plant"] == plant]
            errors.append(cell(of))
        bare = [
            row["errors"]["slow_no_integrator"]
            for row in fitted
            if "slow_no_integrator" in row["errors"]
        ]
        without = figures(bare)
        ways = "/".join(dict.fromkeys(row["way"] for row in fitted))
        costs = [row["sample_ns"] for row in fitted if row["sample_ns"]]
        rows.append([
            name, ways, f"{mean(row['parameters'] for row in fitted):.0f}",
            f"{mean(row['unexplained'] for row in fitted):.3f}", *errors,
            "" if without is None else f"{without[0]:.3f}",
            f"{mean(row['seconds'] for row in fitted):.1f}", f"{mean(costs):.0f}" if costs else "",
        ])  # fmt: skip
    rows.sort(key=_slow)
    titles = [PLANTS[plant] for plant in plants]
    head = [
        "model",
        "way",
        "values",
        "left on unseen loops",
        *titles,
        "no integrator, rms",
        "fit [s]",
        "ns a sample",
    ]
    said = f"Models in the paper's controller, slow trial: rms, largest error [deg]; seeds: {seeds(found)}."
    return said, table(head, rows)


def _slow(row: list[str]) -> float:
    """Mean rms error of a row of `models` on the plants with all three trials, for their order."""
    told = [float(one.partition(",")[0]) for one in row[4:7] if "," in one]
    return mean(told) if told else float("inf")


def figure() -> Figure:
    """Slow trial, all controllers and plants: off, with the paper's compensator, and Vo-Minh's with its own."""
    drawn = Figure(figsize=(9.6, 4.2), layout="constrained")
    plants = run_on(_derived())
    panels = drawn.subplots(1, len(plants), sharey=True, sharex=True)
    lines = {
        "off": ("without compensator", GREY),
        "paper": ("the paper's", BLUE),
        "maxwell-slip": ("Maxwell slip", GREEN),
    }
    for axes, plant in zip(panels, plants, strict=True):
        for row, name in enumerate(CONTROLLERS):
            for shift, (one, (label, colour)) in enumerate(lines.items()):
                told = figures(runs(plant, name, one))
                if told is not None:
                    y = -row - 0.22 * (shift - 1)
                    axes.plot(told, (y, y), color=colour, lw=1.2, alpha=0.6)
                    axes.plot(
                        told[0], y, "o", color=colour, ms=6, label=label if row == 0 else None
                    )
                    axes.plot(told[1], y, "|", color=colour, ms=9, mew=2)
        axes.set(title=PLANTS[plant], xscale="log", xlabel="error [deg]")
        axes.set_yticks([-row for row in range(len(CONTROLLERS))], list(CONTROLLERS.values()))
    drawn.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return drawn
