"""Tables of explanation/rivals.md, from what benchmarks/rivals.py measured; it takes an hour, so its result lies beside
this file."""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Callable
from functools import partial
from pathlib import Path
from statistics import median

import numpy as np
from scipy.stats import wilcoxon

RESULT = Path(__file__).with_name("rivals.csv")
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


def budgets() -> str:
    """What every rival took: rig, tries, numbers, processor; the setting that its tries chose."""
    lines = []
    every = rows()
    for joint in joints():
        cells = cells_of(joint)
        first = draws_of(cells, "off")[0]
        lines += [f"Joint {joint}.", ""]
        lines += head(
            "rival",
            (
                "rig, fast trial [min]",
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
    """What was drawn."""
    lines = []
    for joint in joints():
        cells = cells_of(joint)
        lines += head(
            f"joint {joint}, draw",
            ("muscles", "static map", "slipping force", "pulley", "masses", "valve delay"),
        )
        for draw in draws_of(cells, "off"):
            words = cells["off", "fast", draw]["plant"].split("; ")
            lines.append(f"| {draw} | {' | '.join(words)} |")
        lines.append("")
    return "\n".join(lines).rstrip()


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
