"""Controllers of the literature beside the paper's: what each leaves of every error, which one the page is about."""

from __future__ import annotations

import numpy as np

from dehyst.experiments.results import PlantResult, Reproduction
from dehyst.report.reproduction.numbers import OFF, joints_of, trial_name, trials_of
from dehyst.report.tables import Table
from dehyst.report.text import number, short


def controller_words(result: Reproduction) -> str:
    """Return which controllers were run, the one that the page is about first; nothing if it is the paper's alone."""
    names = [short(str(name), 20) for name in result.settings.get("controllers", ())]
    if not names:
        return ""
    return f"controller “{names[0]}”" + (f", beside {', '.join(names[1:])}" if names[1:] else "")


def controllers_table(result: Reproduction, plant: PlantResult) -> Table | None:
    """Return rms errors of every joint and trial under each controller, off and on; None if the paper's ran alone."""
    names = [str(name) for name in result.settings.get("controllers", ())]
    rows = []
    for joint in joints_of(result) if names else ():
        for trial in trials_of(result):
            cells = [_pair(plant, name, joint, trial, result.compensator) for name in names]
            rows.append((f"joint {joint}, {trial_name(trial)}", *cells))
    tuned = [_tuned(plant, name) for name in names]
    if not rows or None in tuned:
        return None
    rows.append(("numbers to tune", *map(str, tuned)))
    note = "Each controller: rms error in degrees without compensator | with it; mean of the seeds."
    return Table("Controllers side by side", ("", *(short(name, 20) for name in names)), tuple(rows), note)


def _tuned(plant: PlantResult, name: str) -> int | None:
    told = (one.get("controllers", {}).get(name) for one in plant.figures.values())
    return next((one["tuned"] for one in told if one), None)


def _pair(plant: PlantResult, name: str, joint: int, trial: str, compensator: str) -> str:
    said = []
    for which in (OFF, compensator):
        found = []
        for one in plant.figures.values():
            trials = one.get("controllers", {}).get(name, {}).get("joints", {}).get(str(joint), {}).get("trials", {})
            found += [trials[trial][which]["rms_deg"]] if which in trials.get(trial, {}) else []
        said.append(number(float(np.mean(found)), 3) if found else "–")
    return " | ".join(said)
