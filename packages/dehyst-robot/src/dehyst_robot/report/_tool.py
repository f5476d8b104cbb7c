"""ISO 9283 figures of the tool: tables, and why a figure is missing."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from typing import Any

from dehyst.report import PageTable
from dehyst.report import kit as report_kit
from dehyst.shell import visible_lines as clean
from dehyst_robot.experiments import PlantResult, Reproduction
from dehyst_robot.report._numbers import (
    OFF,
    Spread,
    cell,
    counted,
    name_and_unit,
    tool_figures,
    trial_name,
    trials_of,
)

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


def tool_tables(result: Reproduction, plant: PlantResult, note: str) -> tuple[PageTable, ...]:
    """Return the tool's figures over all trials, worst figure of the path first, then each figure."""
    columns = {}
    head = [""]
    for trial in trials_of(result):
        for side, label in ((OFF, "off"), (result.compensator, "on")):
            figures = tool_figures(plant, trial, side)
            if figures:
                columns[trial, side] = figures
                head.append(f"{_broken(trial_name(trial))}\n{label}")
    # Figures of a part of the path carry its name after a comma.
    whole: dict[str, None] = {}
    parts: dict[str, None] = {}
    for key in itertools.chain.from_iterable(columns.values()):
        if ", " in key:
            parts[key] = None
        else:
            whole[key] = None
    tables = []
    if whole:
        words = f"{note} {_meanings(list(whole))} {_missing(plant)}".strip()
        rows = _rows(list(whole), columns)
        tables.append(PageTable("Tool, the worst figure of the path", tuple(head), rows, words))
    if parts:
        rows = _rows(list(parts), columns)
        title = "Tool, every figure of the path"
        tables.append(PageTable(title, tuple(head), rows, note, folded=True))
    return tuple(tables)


def _rows(keys: list[str], columns: Columns) -> tuple[tuple[str, ...], ...]:
    rows = []
    for key in keys:
        spreads = [values.get(key) for values in columns.values()]
        # No row that says of every trial that no section was missed.
        if key == "sections_missed" and not any(spread and spread.high for spread in spreads):
            continue
        write = cell
        if key == "cycles":
            write = counted
        rows.append((row_name(key), *map(write, spreads)))
    return tuple(rows)


def _broken(name: str) -> str:
    """A name in two lines: three narrow columns stand beside each other better than two wide ones."""
    before, without, after = name.partition(" without ")
    if not without:
        return name
    return f"{before},\nno {after}"


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
    # Figures that the norm does not know have names of our own.
    for stem, words in DISTANCE.items():
        if head == stem or head.startswith(f"{stem}_"):
            name = words
            break
    if part:
        name = f"{part}: {name}"
    if unit:
        name = f"{name} [{unit}]"
    return name


def _meanings(keys: list[str]) -> str:
    meanings = []
    stems = {key.partition("_")[0] for key in keys if "_" in key}
    for symbol, (_, meaning) in MEASURES.items():
        if symbol in stems:
            meanings.append(f"{symbol}: {meaning}")
    source = ""
    if meanings:
        source = "By ISO 9283. "
    if any(key.startswith("tracking") for key in keys):
        meanings.append(
            "distance: from where the tool should be at that moment, ways between the figures included"
        )
    if not meanings:
        return ""
    return f"{source}{'; '.join(meanings)}."


def _missing(plant: PlantResult) -> str:
    """Why a figure is not there: "RT and RV of trial slow: needs two cycles or more."."""
    # Trials in which the same figures are missing for the same reason share a sentence.
    trials_of_reason: dict[tuple[str, tuple[str, ...]], list[str]] = {}
    for trial, reasons in _reasons(plant).items():
        # Symbols alone: "AT_mm, line" and "AT_mm" are one missing measure.
        by_reason: dict[str, list[str]] = {}
        for key, reason in reasons.items():
            by_reason.setdefault(clean(reason), []).append(key.partition("_")[0])
        for reason, keys in by_reason.items():
            trials_of_reason.setdefault((reason, tuple(keys)), []).append(trial_name(trial))
    sentences = []
    for (reason, figures), trials in trials_of_reason.items():
        noun = report_kit.count(len(trials), "trial").partition(" ")[2]
        where_not = f"{noun} {report_kit.listed(trials)}"
        sentences.append(f"No {report_kit.listed(figures)} in {where_not}: {reason}.")
    return " ".join(sentences)


def _reasons(plant: PlantResult) -> dict[str, dict[str, str]]:
    """Trial -> figure -> reason, of any seed and side."""
    by_trial: dict[str, dict[str, str]] = {}
    for seed in plant.figures.values():
        for trial, sides in seed.get("tool", {}).items():
            for table in sides.values():
                reasons: Any = None
                if isinstance(table, Mapping):
                    reasons = table.get("reasons")
                if isinstance(reasons, Mapping):
                    of_trial = by_trial.setdefault(trial, {})
                    for figure, reason in reasons.items():
                        of_trial[str(figure)] = str(reason)
    return by_trial
