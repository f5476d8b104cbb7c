"""Tables of explanation/gain-or-compensator.md, from what benchmarks/gains.py measured; it takes two hours, so its
result lies beside this file."""

from __future__ import annotations

import csv
import math
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from statistics import median

RESULT = Path(__file__).with_name("gains.csv")
CONDITIONS, NAMES, TRIALS = (
    ("realistic", "kind"),
    ("off", "paper", "best"),
    ("fast", "slow", "slow_no_integrator"),
)
PAPER = "6"  # its pole [1/s]
OFFSETS = "realistic without sensors"  # what no loop sees
HEAD = "fast | slow | slow, no integrator |"
Key = tuple[str, str, str, str, str]  # conditions, joints that move, joint, mechanism, seed
Cells = dict[tuple[str, str, str], float]  # compensator, pole or "highest", trial -> rms [mdeg]


def read() -> tuple[dict[Key, Cells], dict[Key, dict[str, float]]]:
    """Return case -> its errors, and case -> compensator -> highest pole."""
    cells: dict[Key, Cells] = defaultdict(dict)
    highest: dict[Key, dict[str, float]] = defaultdict(dict)
    with RESULT.open(encoding="utf-8", newline="") as file:
        for r in csv.DictReader(file):
            key, top = (
                (r["conditions"], r["moving"], r["joint"], r["mechanism"], r["seed"]),
                r["highest"] == "1",
            )
            pole = "highest" if top else f"{float(r['pole_1_s']):g}"
            cells[key][r["compensator"], pole, r["trial"]] = float(r["rms_mdeg"])
            if top:
                highest[key][r["compensator"]] = float(r["pole_1_s"])
    return cells, highest


def grouped(
    cells: dict[Key, Cells], parts: int, shown: tuple[str, ...] = CONDITIONS
) -> dict[Key, list[Key]]:
    """Cases of some plants by the first parts of their key: realistic first, joints alone first."""
    groups: dict[Key, list[Key]] = defaultdict(list)
    for key in sorted(
        cells, key=lambda k: (shown.index(k[0]) if k[0] in shown else 9, len(k[1]), k)
    ):
        if key[0] in shown:
            groups[key[:parts]].append(key)
    return groups


def over_poles() -> str:
    """Errors over the poles, medians over mechanisms and seeds."""
    lines = [f"| plant | joint | pole [1/s] | {HEAD} seeds |", "|---|---|---|---|---|---|---|"]
    for conditions, joint, pole, top, errors, seeds in _rows_over_poles():
        name = pole
        if pole == "highest":
            name = f"**{top:.1f}**, highest"
        elif float(pole) > top:
            name += " (no margins)"
        lines.append(f"| {conditions} | {joint} | {name} | {' | '.join(errors)} | {seeds} |")
    return "\n".join(lines)


def of_report() -> str:
    """The rows that the report of `dehyst reproduce` shows: the default pole and the highest one, as CSV."""
    lines = ["conditions,joint,pole_1_s,fast,slow,slow_no_integrator"]
    for conditions, joint, pole, top, errors, _ in _rows_over_poles():
        if pole == "highest":
            lines.append(",".join((conditions, joint, f"{top:.1f}", *errors)))
        elif pole == PAPER:
            lines.append(",".join((conditions, joint, pole, *errors)))
    return "\n".join(lines) + "\n"


def _rows_over_poles() -> Iterator[tuple[str, str, str, float, list[str], int]]:
    """Conditions, joint, pole, the highest pole, off, paper and best for each trial, and number of seeds."""
    cells, highest = read()
    for (conditions, moving, joint), keys in grouped(cells, 3).items():
        top = median(highest[key]["off"] for key in keys)
        poles = sorted({pole for key in keys for _, pole, _ in cells[key]} - {"highest"}, key=float)
        for pole in sorted([*poles, "highest"], key=lambda p: top if p == "highest" else float(p)):
            errors = [_three([cells[key] for key in keys], pole, trial) for trial in TRIALS]
            seeds = set()
            for key in keys:
                if any((name, pole) == at[:2] for at in cells[key] for name in NAMES):
                    seeds.add(key[4])
            yield conditions, _named(joint, moving), pole, top, errors, len(seeds)


def _named(joint: str, moving: str) -> str:
    return joint if joint == moving else f"{joint} of {moving}"


def _three(cases: list[Cells], pole: str, trial: str) -> str:
    found = [[c[name, pole, trial] for c in cases if (name, pole, trial) in c] for name in NAMES]
    return " → ".join(
        "lost" if not v or any(map(math.isnan, v)) else _digits(median(v)) for v in found
    )


def _digits(value: float) -> str:
    return f"{value:.0f}" if value >= 100 else f"{value:.3g}"


def ratios() -> str:
    """Best over off at the default pole and at the highest, for every plant; medians over seeds, with their range."""
    cells, highest = read()
    lines = [
        "| plant | joint | muscles | seeds | highest pole: off, paper, best | at 6: fast | slow | no integrator |"
        " highest: fast | slow | no integrator |",
        "|---|---|---|---|---|---|---|---|---|---|---|",
    ]
    seeds = defaultdict(
        list
    )  # of a plant without an effect only those rows that were run with all seeds
    for key in cells:
        seeds[key[:4]].append(key[4])
    told = {
        key: one for key, one in cells.items() if key[0] in CONDITIONS or len(seeds[key[:4]]) > 1
    }
    for (conditions, moving, joint, mechanism), keys in grouped(
        told, 4, (*CONDITIONS, OFFSETS)
    ).items():
        tops = ", ".join(f"{median(highest[key][name] for key in keys):.1f}" for name in NAMES)
        shown = " | ".join(
            _ratio([cells[key] for key in keys], pole, t)
            for pole in ("6", "highest")
            for t in TRIALS
        )
        lines.append(
            f"| {conditions} | {_named(joint, moving)} | {mechanism} | {len(keys)} | {tops} | {shown} |"
        )
    return "\n".join(lines)


def _ratio(cases: list[Cells], pole: str, trial: str) -> str:
    values = sorted(
        c["best", pole, trial] / c["off", pole, trial] for c in cases if ("off", pole, trial) in c
    )
    if not values:
        return "-"
    spread = f" ({values[0]:.2f}-{values[-1]:.2f})" if len(values) > 1 else ""
    return f"{median(values):.2f}{spread}"


def effects() -> str:
    """The realistic plant with one effect switched off, slow trial, between the two plants as they are."""
    cells, highest = read()
    of = [
        key
        for key in cells
        if " without " in key[0] and (key[1], *key[3:]) == ("2", "preisach", "0")
    ]
    lines = [
        "| realistic plant without | highest pole | slow at 6: off → paper → best | best/off | slow at the highest |"
        " best/off |",
        "|---|---|---|---|---|---|",
    ]
    for key in [("realistic", *of[0][1:]), *of, ("kind", *of[0][1:])]:
        name = {"realistic": "nothing", "kind": "all of it: kind"}.get(
            key[0], key[0].partition(" without ")[2]
        )
        shown = [
            f"{_three([cells[key]], p, 'slow')} | {_ratio([cells[key]], p, 'slow')}"
            for p in ("6", "highest")
        ]
        lines.append(f"| {name} | {highest[key]['off']:.1f} | {' | '.join(shown)} |")
    return "\n".join(lines)
