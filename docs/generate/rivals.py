"""Tables and figure of explanation/rivals.md, from what benchmarks/rivals.py measured; it takes hours, so its results
lie beside this file."""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Callable
from functools import partial
from pathlib import Path
from statistics import median

import numpy as np
from matplotlib.figure import Figure
from scipy.stats import wilcoxon

RESULT = Path(__file__).with_name("rivals.csv")
UNEXPLAINED = Path(__file__).with_name("unexplained.csv")
AIR = Path(__file__).with_name("rivals_air.csv")
MODEL_TRIALS = (
    "fast",
    "slow",
    "slow_no_integrator",
    "moves",
)  # what one pole has beside the late commands
JOINT_COLOURS = {"1": "#0072b2", "2": "#007a5a", "4": "#d55e00"}
TUNING = "tuning"
TRIALS = ("fast", "slow", "slow_no_integrator", "moves", "fast_late")
HEADS = ("fast", "slow", "slow, no integrator", "other moves, fast", "fast, 5 ms later")
LOST = 1e6  # error that stands for a lost trial where ranks are compared
TITLES = {
    "off": "off: feedback linearisation, pole 6",
    "paper": "**paper**",
    "best": "**best**",
    "pole": "off, pole at its margins",
    "best at that pole": "**best** at that pole",
    "disturbance observer": "disturbance observer",
    "adapted scale": "paper's model, k = 10, scale adapted",
    "sliding-mode": "sliding mode",
    "vo-minh": "Vo-Minh's cascade, Maxwell slip",
    "one-valve": "one valve",
    "pid": "PID",
    "iterative learning": "iterative learning",
    "iterative learning over best": "iterative learning over best's model",
    "gaussian process": "Gaussian process",
    "recurrent network": "recurrent network",
    "predictive": "model predictive control",
}
Row = dict[str, str]
Cells = dict[tuple[str, str, str], Row]  # rival, trial, draw -> row


def rows() -> list[Row]:
    """Return all rows of the file."""
    with RESULT.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def joints() -> list[str]:
    """Return the joints of the file."""
    return sorted({row["joint"] for row in rows()})


def cells_of(joint: str) -> Cells:
    """Return the rows of a joint's draws that every rival was run on."""
    cells = {}
    for row in rows():
        if row["joint"] == joint and row["draw"] != TUNING:
            cells[row["rival"], row["trial"], row["draw"]] = row
    complete = set(draws_of(cells, "off"))
    for name in TITLES:
        complete &= set(draws_of(cells, name))
    return {key: row for key, row in cells.items() if key[2] in complete}


def draws_of(cells: Cells, name: str) -> list[str]:
    """Return the draws of a rival."""
    draws = {key[2] for key in cells if key[0] == name and key[1] == TRIALS[-1]}
    return sorted(draws, key=int)


def errors_of(cells: Cells, name: str, trial: str, column: str = "rms_mdeg") -> list[float]:
    """Return the errors of a rival over the draws; infinite where the trial was lost. [mdeg]"""
    errors = []
    for draw in draws_of(cells, "off"):
        text = cells[name, trial, draw][column]
        errors.append(float(text) if text else math.inf)
    return errors


def ratios_to(cells: Cells, name: str, trial: str, other: str) -> list[float]:
    """Return the rms errors of a rival over those of another one, draw by draw where the other one was not lost."""
    pairs = zip(errors_of(cells, name, trial), errors_of(cells, other, trial), strict=True)
    return [one / two for one, two in pairs if two < math.inf]


def errors() -> str:
    """Rms and largest error of every rival, medians over the draws."""
    lines = []
    for joint in joints():
        cells = cells_of(joint)
        count = len(draws_of(cells, "off"))
        title = f"Joint {joint}, {count} draws: rms, largest error [mdeg], medians over draws."
        lines += table(title, partial(error_text, cells))
    return "\n".join(lines).rstrip()


def error_text(cells: Cells, name: str, trial: str) -> str:
    """One cell of the table of errors."""
    rms = median(errors_of(cells, name, trial))
    if rms == math.inf:
        return "lost"
    return f"{digits(rms)}, {digits(median(errors_of(cells, name, trial, 'max_mdeg')))}"


def ratios() -> str:
    """Rms error of every rival over that of `off`: median and quantiles over the draws."""
    lines = []
    for joint in joints():
        cells = cells_of(joint)
        count = len(draws_of(cells, "off"))
        title = f"Joint {joint}, {count} draws: rms error over that of off, median (10 % to 90 % quantile)."
        lines += table(title, partial(ratio_text, cells), "off")
    return "\n".join(lines).rstrip()


def table(title: str, cell: Callable[[str, str], str], left_out: str = "") -> list[str]:
    """Return the lines of a table with a row for each rival and a column for each trial."""
    lines = [title, "", *head("rival", HEADS)]
    for name, named in TITLES.items():
        if name != left_out:
            texts = [cell(name, trial) for trial in TRIALS]
            lines.append(f"| {named} | {' | '.join(texts)} |")
    return [*lines, ""]


def ratio_text(cells: Cells, name: str, trial: str) -> str:
    """One cell of the table of ratios."""
    values = ratios_to(cells, name, trial, "off")
    failures = values.count(math.inf)
    if 2 * failures >= len(values):
        return f"{failures} of {len(values)} lost"
    low, high = np.quantile(np.minimum(values, LOST), (0.1, 0.9))
    top = f"{failures} lost" if failures else f"{high:.3f}"
    return f"{median(values):.3f} ({low:.3f}-{top})"


def pairs() -> str:
    """Every rival against both rows of `best`, draw by draw: median ratio, draws it won, and the paired test."""
    lines = []
    for joint in joints():
        cells = cells_of(joint)
        for other in ("best", "best at that pole"):
            title = (
                f"Joint {joint}, against {TITLES[other]}: median of the ratios of rms errors, draws with a smaller "
                f"error, p of Wilcoxon's signed-rank test (both sides)."
            )
            lines += table(title, partial(pair_text, cells, other), other)
    return "\n".join(lines).rstrip()


def pair_text(cells: Cells, other: str, name: str, trial: str) -> str:
    """One cell of the table of pairs."""
    values = np.minimum(ratios_to(cells, name, trial, other), LOST)
    wins = int(np.sum(values < 1.0))
    p = float(wilcoxon(np.log(values)).pvalue)
    middle = float(np.median(values))
    text = digits(middle) if middle < 100 else "lost"
    return f"{text}, {wins}/{values.size}, {p:.2g}"


def mechanisms() -> str:
    """`best` over `off` and over `paper` by the mechanism of the muscles, and what both models leave unexplained."""
    with UNEXPLAINED.open(encoding="utf-8", newline="") as file:
        left = {(row["joint"], row["plant"].split("; ")[0]): row for row in csv.DictReader(file)}
    names = ("fast", "slow", "slow, no integrator", "other moves, fast")
    lines = head("joint, muscles", (*names, "best, paper leave unexplained"))
    for joint in joints():
        cells = cells_of(joint)
        of_mechanism: dict[str, list[str]] = {}
        for draw in draws_of(cells, "off"):
            name = cells["off", "fast", draw]["plant"].split("; ")[0]
            of_mechanism.setdefault(name, []).append(draw)
        for name, chosen in of_mechanism.items():
            texts = []
            for trial in MODEL_TRIALS:
                over_off = ratios_in(cells, chosen, trial, "off")
                over_paper = ratios_in(cells, chosen, trial, "paper")
                texts.append(f"{median(over_off):.3f}, {median(over_paper):.2f}")
            row = left[joint, name]
            texts.append(f"{float(row['best']):.3f}, {float(row['paper']):.3f}")
            lines.append(f"| {joint}, {name} ({len(chosen)}) | {' | '.join(texts)} |")
    return "\n".join(lines)


def ratios_in(cells: Cells, chosen: list[str], trial: str, other: str) -> list[float]:
    """Return the rms errors of `best` over those of another row, in some draws."""
    ratios = []
    for draw in chosen:
        one, two = cells["best", trial, draw], cells[other, trial, draw]
        ratios.append(float(one["rms_mdeg"]) / float(two["rms_mdeg"]))
    return ratios


def figure() -> Figure:
    """Rms error over that of off: a row for each rival, a dot for each joint, a line from 10 to 90 % of the draws."""
    drawn = Figure(figsize=(12.0, 6.6), layout="constrained")
    panels = drawn.subplots(1, len(MODEL_TRIALS), sharey=True)
    names = [name for name in TITLES if name != "off"]
    places = np.arange(len(names))
    for axes, trial, title in zip(panels, MODEL_TRIALS, HEADS, strict=False):
        for k, joint in enumerate(joints()):
            cells = cells_of(joint)
            spread = np.array([quantiles(cells, name, trial) for name in names])
            at = places + 0.24 * (k - 0.5 * (len(joints()) - 1))
            colour = JOINT_COLOURS[joint]
            axes.hlines(at, spread[:, 0], spread[:, 2], color=colour, lw=1.2)
            axes.plot(spread[:, 1], at, "o", ms=4.5, color=colour, label=f"joint {joint}")
        axes.axvline(1.0, color="#8a939e", lw=0.8)
        axes.set_xscale("log")
        axes.set_xlim(0.008, 4.0)
        axes.set_title(title)
        axes.set_xlabel("rms error over that of off")
    panels[0].set_yticks(places, [TITLES[name].replace("**", "") for name in names])
    panels[0].invert_yaxis()
    panels[-1].legend(loc="lower right")
    return drawn


def quantiles(cells: Cells, name: str, trial: str) -> list[float]:
    """Return 10 %, middle and 90 % of the errors over those of `off`; a lost trial counts as a very large one."""
    values = np.minimum(ratios_to(cells, name, trial, "off"), LOST)
    return [float(value) for value in np.quantile(values, (0.1, 0.5, 0.9))]


def budgets() -> str:
    """What every rival took: rig, tries, numbers, processor; the setting that its tries chose."""
    lines = []
    every = rows()
    with AIR.open(encoding="utf-8", newline="") as file:
        litres = {(row["joint"], row["rival"]): row["air_l"] for row in csv.DictReader(file)}
    for joint in joints():
        cells = cells_of(joint)
        first = draws_of(cells, "off")[0]
        lines += [f"Joint {joint}.", ""]
        lines += head(
            "rival",
            (
                "rig, fast trial [min]",
                "air, fast trial [l]",
                "tries",
                "chosen",
                "numbers",
                "a period [us]",
                "runs in",
                "trials lost",
            ),
        )
        for name, title in TITLES.items():
            settings = set()
            for row in every:
                if (row["joint"], row["draw"], row["rival"]) == (joint, TUNING, name):
                    settings.add(row["setting"])
            row = measured_row(cells, name)
            draws = draws_of(cells, "off")
            lost = sum(errors_of(cells, name, t).count(math.inf) for t in TRIALS)
            chosen = cells[name, "fast", first]["setting"] or "-"
            texts = [
                f"{float(row['rig_min']):.1f}",
                digits(float(litres[joint, name])) if litres[joint, name] else "-",
                str(len(settings) or "-"),
                chosen,
                row["numbers"],
                digits(float(row["step_us"])),
                row["runs_in"],
                f"{lost} of {len(TRIALS) * len(draws)}",
            ]
            lines.append(f"| {title} | {' | '.join(texts)} |")
        lines.append("")
    return "\n".join(lines).rstrip()


def measured_row(cells: Cells, name: str) -> Row:
    """Return the row of a rival's first fast trial that was not lost, with the least disturbed time of a period."""
    there = [row for key, row in cells.items() if key[0] == name and row["rms_mdeg"]]
    fast = [row for row in there if row["trial"] == "fast"]
    if not fast:
        return {"rig_min": "nan", "numbers": "-", "step_us": "nan", "runs_in": "-"}
    least = min(float(row["step_us"]) for row in there)
    return {**fast[0], "step_us": str(least)}


def draws() -> str:
    """What was drawn for the first joint; the file has the others."""
    joint = joints()[0]
    cells = cells_of(joint)
    lines = head(
        f"joint {joint}, draw",
        ("muscles", "static map", "slipping force", "pulley", "masses", "valve delay"),
    )
    for draw in draws_of(cells, "off"):
        words = cells["off", "fast", draw]["plant"].split("; ")
        lines.append(f"| {draw} | {' | '.join(words)} |")
    return "\n".join(lines)


def lost() -> str:
    """Why trials were lost, each reason once a rival."""
    lines = []
    for joint in joints():
        cells = cells_of(joint)
        for name, title in TITLES.items():
            reasons: dict[str, int] = {}
            for key, row in cells.items():
                if key[0] == name and row["failed"]:
                    reason = shortened(row["failed"])
                    reasons[reason] = reasons.get(reason, 0) + 1
            for reason, count in reasons.items():
                lines.append(f'- Joint {joint}, {title}: {count} trials, "{reason}".')
    return "\n".join(lines) or "No trial was lost."


def shortened(reason: str) -> str:
    """Return what happened, without the number of that run and without the cure."""
    sentence = reason.partition(". ")[0].partition(": what is simulated")[0]
    return re.sub(r"went to -?\d+ deg, its range ends at -?\d+ deg", "left its range", sentence)


def head(first: str, names: tuple[str, ...]) -> list[str]:
    """Return the two lines on top of a table."""
    return [f"| {first} | {' | '.join(names)} |", "|---" * (1 + len(names)) + "|"]


def digits(value: float) -> str:
    """Return a number with three digits."""
    return f"{value:.0f}" if value >= 100 else f"{value:.3g}"
