"""Tables of the reproduction: every figure with its spread over seeds, and words about the largest errors."""

from __future__ import annotations

import numpy as np

from dehyst.experiments.results import PlantResult, Reproduction, TrialRun
from dehyst.report.reproduction.acceptance import unexplained_of
from dehyst.report.reproduction.numbers import (
    OFF,
    cell,
    counted,
    identification_figure,
    joints_of,
    left_off,
    listed,
    run_of,
    same_run,
    seed_figure,
    trial_figure,
    trial_name,
    trial_ratio,
    trials_of,
)
from dehyst.report.reproduction.reasons import in_words, largest_error
from dehyst.report.reproduction.tool_tables import tool_tables
from dehyst.report.tables import Table
from dehyst.report.text import number


def plant_tables(result: Reproduction, plant: PlantResult) -> tuple[Table, ...]:
    """Return the tables of a plant: joints, identification, tool."""
    made = (_trials(result, plant), *tool_tables(result, plant, spread_note(plant)), _identification(result, plant))
    return tuple(table for table in made if table is not None)


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
                ratio = trial_ratio(plant, joint, trial, result.compensator, name)
                cells.append("left off" if left_off(plant, joint) and ratio is not None else cell(ratio))
            if any(text != "–" for text in cells):
                rows.append((f"joint {joint}, {trial_name(trial)}", *cells))
    head = ("", "rms off [°]", "rms on [°]", "on/off", "max off [°]", "max on [°]", "on/off")
    note = f"{spread_note(plant)}{_left_off_note(result, plant)}"
    return Table("Angles in the trials", head, tuple(rows), note) if rows else None


def _left_off_note(result: Reproduction, plant: PlantResult) -> str:
    off = [joint for joint in joints_of(result) if left_off(plant, joint)]
    if not off:
        return ""
    which = f"Joint{'s' if len(off) > 1 else ''} {listed(off)}"
    return f" {which}: the model was not accepted, so “on” is without compensator too."


def _identification(result: Reproduction, plant: PlantResult) -> Table | None:
    rows = []
    for joint in joints_of(result):
        weights = identification_figure(plant, joint, "nonzero_weights")
        ratio = identification_figure(plant, joint, "inverse_rms_ratio_unseen")
        if weights is None and ratio is None:
            continue
        found = plant.identifications.get(joint)
        shear, gain = "–", "–"
        if found is not None and found.plays is not None:
            shear, gain = number(found.shear), number(found.plays.certificate.inverse_gain)
        residual = identification_figure(plant, joint, "calibration_residual_Nm")
        unexplained = unexplained_of(plant, joint)
        rows.append((f"joint {joint}", counted(weights), cell(ratio), cell(unexplained), shear, gain, cell(residual)))
    head = (
        "",
        "weights",
        "inverse error, unseen loops",
        "unexplained",
        "k [bar/rad]",
        "largest slope of inverse [bar/rad]",
        "residual of A, B, C [Nm]",
    )
    note = (
        f"{spread_note(plant)} Weights: operators that carry some. Inverse error: rms(measured − inverse) over "
        "rms(measured hysteresis), on loops not used in the fit; unexplained: the same without the means."
    )
    return Table("Identification", head, tuple(rows), note) if rows else None


def largest_errors(result: Reproduction, plant: PlantResult) -> tuple[tuple[str, str, bool], ...]:
    """Return for every joint and trial of the first seed: its name, words about the largest error, whether it rose."""
    found = []
    for joint in joints_of(result):
        for trial in trials_of(result):
            off, on = run_of(plant, trial, OFF), run_of(plant, trial, result.compensator)
            if off is None or on is None or same_run(off, on):
                continue
            place = largest_error(off, on, joint)
            sizes = [_largest(plant, run, joint) for run in (off, on)]
            found.append((f"Joint {joint}, {trial_name(trial)}", in_words(place, *sizes), sizes[1] > sizes[0]))
    return tuple(found)


def _largest(plant: PlantResult, run: TrialRun, joint: int) -> float:
    """Largest error as the tables have it; from the run itself if its seed has no figures. [deg]"""
    told = seed_figure(plant, run.seed, joint, run.trial, run.compensator, "max_deg")
    return float(np.rad2deg(np.max(np.abs(run.error[:, joint - 1])))) if told is None else told
