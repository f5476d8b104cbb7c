"""Tables of the reproduction: every figure with its spread over seeds, and words about the largest errors."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from dehyst.experiments.results import PlantResult, Reproduction, TrialRun
from dehyst.report.reproduction.numbers import (
    OFF,
    Spread,
    counted,
    identification_figure,
    joints_of,
    name_and_unit,
    run_of,
    seed_figure,
    tool_figures,
    trial_figure,
    trial_name,
    trial_ratio,
    trials_of,
)
from dehyst.report.reproduction.reasons import in_words, largest_error
from dehyst.report.tables import Table
from dehyst.report.text import number

MEANINGS = {
    "AT": "path accuracy: largest distance of the mean path from the desired one",
    "RT": "path repeatability",
    "CR": "corner rounding: smallest distance from the corner",
    "CO": "corner overshoot",
    "AV": "accuracy of the path velocity",
    "RV": "repeatability of the path velocity",
    "FV": "fluctuation of the path velocity",
    "tracking": "distance from where the tool should be at that moment",
}


def plant_tables(result: Reproduction, plant: PlantResult) -> tuple[Table, ...]:
    """Return the tables of a plant: joints, identification, tool."""
    made = (_trials(result, plant), _tool(result, plant), _identification(result, plant))
    return tuple(table for table in made if table is not None)


def cell(found: Spread | None) -> str:
    """Return a figure as a cell."""
    return "–" if found is None else str(found)


def spread_note(plant: PlantResult) -> str:
    """Return what the brackets mean."""
    if len(plant.figures) < 2:
        return "One seed."
    return f"Mean of {len(plant.figures)} seeds, in brackets the smallest and the largest."


def _trials(result: Reproduction, plant: PlantResult) -> Table | None:
    rows = []
    for joint in joints_of(result):
        for trial in trials_of(result):
            cells = []
            for name in ("rms_deg", "max_deg"):
                cells += [cell(trial_figure(plant, joint, trial, c, name)) for c in (OFF, result.compensator)]
                cells.append(cell(trial_ratio(plant, joint, trial, result.compensator, name)))
            if any(text != "–" for text in cells):
                rows.append((f"joint {joint}, {trial_name(trial)}", *cells))
    head = ("", "rms off [°]", "rms on [°]", "on/off", "max off [°]", "max on [°]", "on/off")
    return Table("Angles in the trials", head, tuple(rows), spread_note(plant)) if rows else None


def _identification(result: Reproduction, plant: PlantResult) -> Table | None:
    rows = []
    for joint in joints_of(result):
        weights = identification_figure(plant, joint, "nonzero_weights")
        ratio = identification_figure(plant, joint, "inverse_rms_ratio_unseen")
        if weights is None and ratio is None:
            continue
        found = plant.identifications.get(joint)
        shear = "–" if found is None else number(found.shear)
        residual = "–" if found is None else number(found.characteristic.residual)
        gain = "–" if found is None else number(found.fit.certificate.inverse_gain)
        rows.append((f"joint {joint}", counted(weights), cell(ratio), shear, gain, residual))
    head = (
        "",
        "weights",
        "inverse error, unseen loops",
        "k [bar/rad]",
        "slope of inverse [bar/rad]",
        "residual of A, B, C [Nm]",
    )
    note = (
        f"{spread_note(plant)} Weights: operators that carry some. Inverse error: rms(measured − inverse) over "
        "rms(measured hysteresis), on loops not used in the fit."
    )
    return Table("Identification", head, tuple(rows), note) if rows else None


def _tool(result: Reproduction, plant: PlantResult) -> Table | None:
    """All trials beside each other: a figure a row."""
    sides = (OFF, result.compensator)
    columns = {(t, side): tool_figures(plant, t, side) for t in trials_of(result) for side in sides}
    columns = {key: found for key, found in columns.items() if found}
    rows = []
    for key in dict.fromkeys(name for found in columns.values() for name in found):
        name, unit = name_and_unit(key)
        rows.append((f"{name} [{unit}]" if unit else name, *(cell(found.get(key)) for found in columns.values())))
    head = ("", *(f"{trial_name(trial)}, {'off' if side == OFF else 'on'}" for trial, side in columns))
    note = f"{spread_note(plant)} {_meanings([row[0] for row in rows])}"
    return Table("Tool", head, tuple(rows), note) if rows else None


def _meanings(names: Sequence[str]) -> str:
    said = [f"{key}: {words}" for key, words in MEANINGS.items() if any(name.startswith(key) for name in names)]
    return f"ISO 9283, {'; '.join(said)}." if said else ""


def largest_errors(result: Reproduction, plant: PlantResult) -> tuple[tuple[str, str, bool], ...]:
    """Return for every joint and trial of the first seed: its name, words about the largest error, whether it rose."""
    found = []
    for joint in joints_of(result):
        for trial in trials_of(result):
            off, on = run_of(plant, trial, OFF), run_of(plant, trial, result.compensator)
            if off is None or on is None:
                continue
            place = largest_error(off, on, joint)
            sizes = [_largest(plant, run, joint) for run in (off, on)]
            found.append((f"Joint {joint}, {trial_name(trial)}", in_words(place, *sizes), sizes[1] > sizes[0]))
    return tuple(found)


def _largest(plant: PlantResult, run: TrialRun, joint: int) -> float:
    """Largest error as the tables have it; from the run itself if its seed has no figures. [deg]"""
    told = seed_figure(plant, run.seed, joint, run.trial, run.compensator, "max_deg")
    return float(np.rad2deg(np.max(np.abs(run.error[:, joint - 1])))) if told is None else told
