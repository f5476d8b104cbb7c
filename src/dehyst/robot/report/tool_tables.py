"""Figures of the tool by ISO 9283: tables, what is missing and why, what grows with the compensator and why."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from dehyst.report.tables import Table
from dehyst.report.text import count, number
from dehyst.robot.experiments.results import PlantResult, Reproduction
from dehyst.robot.report.numbers import (
    OFF,
    Spread,
    cell,
    counted,
    listed,
    name_and_unit,
    tool_figures,
    trial_name,
    trials_of,
)
from dehyst.shell import visible_lines as clean

# Symbol -> name, meaning.
MEASURES = {
    "AT": ("path accuracy", "largest distance of the mean path from the desired one"),
    "RT": ("path repeatability", "how far the cycles lie apart"),
    "CR": ("corner rounding", "smallest distance from the ideal, sharp corner"),
    "CO": ("corner overshoot", "how far beyond the corner the tool goes"),
    "AV": ("speed accuracy", "mean speed against the commanded one"),
    "RV": ("speed repeatability", "how far the mean speeds of the cycles lie apart"),
    "FV": ("speed fluctuation", "largest less smallest deviation of the speed"),
}
LARGER = 1.02  # a figure that grows by less is not worth a word
DISTANCE = {
    "tracking_rms": "distance, rms",
    "tracking_max": "distance, largest",
    "tracking_p95": "distance, 95 % of the time below",
    "cycles": "cycles",
    "sections_missed": "share of sections not reached",
    "command_speed": "commanded speed",
    "share_at_command_speed": "share of the figure at it",
}
Columns = Mapping[tuple[str, str], Mapping[str, Spread]]


def tool_tables(result: Reproduction, plant: PlantResult, note: str) -> tuple[Table, ...]:
    """Return the tool's figures over all trials, worst figure of the path first, then each figure."""
    sides = (OFF, result.compensator)
    columns = {(t, side): tool_figures(plant, t, side) for t in trials_of(result) for side in sides}
    columns = {key: found for key, found in columns.items() if found}
    keys = list(dict.fromkeys(name for found in columns.values() for name in found))
    head = ("", *(f"{_broken(trial_name(trial))}\n{'off' if side == OFF else 'on'}" for trial, side in columns))
    whole, parts = ([k for k in keys if (", " in k) is nested] for nested in (False, True))
    said = f"{note} {_meanings(whole)} {_missing(plant)}".strip()
    made = []
    if whole:
        made.append(Table("Tool, the worst figure of the path", head, _rows(whole, columns), said))
    if parts:
        made.append(Table("Tool, every figure of the path", head, _rows(parts, columns), note, folded=True))
    return tuple(made)


def _rows(keys: list[str], columns: Columns) -> tuple[tuple[str, ...], ...]:
    rows = []
    for key in keys:
        found = [values.get(key) for values in columns.values()]
        if key == "sections_missed" and not any(value and value.high for value in found):
            continue
        write = counted if key == "cycles" else cell
        rows.append((row_name(key), *map(write, found)))
    return tuple(rows)


def _broken(name: str) -> str:
    """A name in two lines: three narrow columns stand beside each other better than two wide ones."""
    middle = name.find(" without ")
    return name if middle < 0 else f"{name[:middle]},\nno {name[middle + 9 :]}"


def row_name(key: str) -> str:
    """Return what a figure is called in the table.

    Examples
    --------
    >>> row_name("AT_mm"), row_name("tracking_rms_mm, line"), row_name("swing_deg")
    ('AT path accuracy [mm]', 'line: distance, rms [mm]', 'swing [°]')
    """
    head, _, part = key.partition(", ")
    name, unit = name_and_unit(head)
    symbol = head.partition("_")[0]
    if symbol in MEASURES:
        name = f"{symbol} {MEASURES[symbol][0]}"
    stem = next((s for s in DISTANCE if head == s or head.startswith(f"{s}_")), None)
    if stem is not None:
        name = DISTANCE[stem]
    return f"{part + ': ' if part else ''}{name}{f' [{unit}]' if unit else ''}"


def _meanings(keys: list[str]) -> str:
    known = [symbol for symbol in MEASURES if any(key.startswith(f"{symbol}_") for key in keys)]
    said = [f"{symbol}: {MEASURES[symbol][1]}" for symbol in known]
    if any(key.startswith("tracking") for key in keys):
        said.append("distance: from where the tool should be at that moment, ways between the figures included")
    return f"By ISO 9283. {'; '.join(said)}." if said else ""


def _missing(plant: PlantResult) -> str:
    """Why a figure is not there: "RT and RV of trial slow: needs two cycles or more."."""
    found: dict[tuple[str, tuple[str, ...]], list[str]] = {}
    for trial, reasons in _reasons(plant).items():
        by_reason: dict[str, list[str]] = {}
        for key, reason in reasons.items():
            by_reason.setdefault(clean(reason), []).append(key.partition("_")[0])
        for reason, keys in by_reason.items():
            found.setdefault((reason, tuple(keys)), []).append(trial_name(trial))
    return " ".join(
        f"No {listed(keys)} in {count(len(trials), 'trial').partition(' ')[2]} {listed(trials)}: {reason}."
        for (reason, keys), trials in found.items()
    )


def _reasons(plant: PlantResult) -> dict[str, dict[str, str]]:
    """Trial -> figure -> reason, of any seed and side."""
    found: dict[str, dict[str, str]] = {}
    for seed in plant.figures.values():
        for trial, sides in seed.get("tool", {}).items():
            for table in sides.values():
                reasons: Any = table.get("reasons") if isinstance(table, Mapping) else None
                if isinstance(reasons, Mapping):
                    found.setdefault(trial, {}).update({str(k): str(v) for k, v in reasons.items()})
    return found


def larger_figures(plant: PlantResult, trial: str, compensator: str) -> dict[str, str]:
    """Return symbol -> "FV 5.46 → 37.8 mm/s", of what grows with the compensator."""
    off, on = tool_figures(plant, trial, OFF), tool_figures(plant, trial, compensator)
    found = {}
    for key in off:
        symbol = key.partition("_")[0]
        if symbol in MEASURES and ", " not in key and key in on and abs(on[key].mean) > LARGER * abs(off[key].mean):
            unit = name_and_unit(key)[1]
            found[symbol] = f"{symbol} {number(off[key].mean)} → {number(on[key].mean)} {unit}"
    return found
