"""Tables of a plant on the page of the experiment: trials, identification, controllers, accepted models."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from dehyst.findings import Grade
from dehyst.report.parts import Cell, Section, Table
from dehyst.report.text import between, count, listed, number, short
from dehyst.robot.experiments.results import ACCEPTABLE, PlantResult, Reproduction
from dehyst.robot.report.numbers import (
    NO_HYSTERESIS,
    OFF,
    Spread,
    accepted_of,
    cell,
    counted,
    identification_figure,
    joints_of,
    left_off,
    pair_of,
    same_run,
    trial_figure,
    trial_name,
    trial_ratio,
    trials_of,
)
from dehyst.robot.report.tool import tool_tables


def plant_tables(result: Reproduction, plant: PlantResult) -> tuple[Table, ...]:
    """Return the tables of a plant: joints, tool, identification, controllers."""
    made = (
        _trials(result, plant),
        *tool_tables(result, plant, spread_note(plant)),
        _identification(result, plant),
        _controllers(result, plant),
    )
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


def _controllers(result: Reproduction, plant: PlantResult) -> Table | None:
    """Return rms errors of every joint and trial under each controller, off and on; None if the paper's ran alone."""
    names = [str(name) for name in result.settings.get("controllers", ())]
    rows = []
    for joint in joints_of(result) if names else ():
        for trial in trials_of(result):
            cells = [_off_and_on(plant, name, joint, trial, result.compensator) for name in names]
            rows.append((f"joint {joint}, {trial_name(trial)}", *cells))
    tuned = [_tuned(plant, name) for name in names]
    if not rows or None in tuned:
        return None
    rows.append(("numbers to tune", *map(str, tuned)))
    note = "Each controller: rms error in degrees without compensator | with it; mean of the seeds."
    return Table("Controllers side by side", ("", *(short(name, 20) for name in names)), tuple(rows), note)


def _tuned(plant: PlantResult, name: str) -> int | str | None:
    told = (one.get("controllers", {}).get(name) for one in plant.figures.values())
    return next((one.get("tuned", "its own") for one in told if one), None)


def _off_and_on(plant: PlantResult, name: str, joint: int, trial: str, compensator: str) -> str:
    said = []
    for which in (OFF, compensator):
        found = []
        for one in plant.figures.values():
            trials = one.get("controllers", {}).get(name, {}).get("joints", {}).get(str(joint), {}).get("trials", {})
            found += [trials[trial][which]["rms_deg"]] if which in trials.get(trial, {}) else []
        said.append(number(float(np.mean(found)), 3) if found else "–")
    return " | ".join(said)


def acceptance(result: Reproduction) -> Section | None:
    """Return which models were accepted, and what followed where one was not; None if that is not known of any."""
    joints = joints_of(result)
    rows = tuple((short(p.plant, 40), *(_cell(p, joint) for joint in joints)) for p in result.plants.values())
    if not any(isinstance(cell, Cell) for row in rows for cell in row):
        return None
    rule = (
        "Before a compensator is switched on, its model is tested on loops that it was not fitted to. Shown is what it "
        "leaves unexplained: the standard deviation of measured hysteresis − inverse model, in percent of that of the "
        f"hysteresis. With more than {100 * ACCEPTABLE:.0f} % the compensator stays off."
    )
    if any(one.direct is not None for plant in result.plants.values() for one in plant.identifications.values()):
        rule += " Of a direct inverse only the terms without time are tested, on loops alone: creep is not hysteresis."
    words = filter(None, (_consequence(result, plant, joints) for plant in result.plants.values()))
    table = Table("", ("plant", *(f"joint {joint}" for joint in joints)), rows)
    return Section("accepted", "Which models were accepted", (table, *words), rule)


def _cell(plant: PlantResult, joint: int) -> str | Cell:
    accepted, known = accepted_of(plant, joint)
    if not known:
        return "–"
    some = f"accepted in {accepted} of {count(known, 'seed')}"
    verdict = "accepted" if accepted == known else "not accepted" if accepted == 0 else some
    grade = Grade.GOOD if accepted == known else Grade.CARE
    return Cell(percent_of(unexplained_of(plant, joint)), verdict, grade)


def unexplained_of(plant: PlantResult, joint: int) -> Spread | None:
    """Return the unexplained share of unseen loops over the seeds."""
    found = identification_figure(plant, joint, "unexplained_unseen")
    if found is None and joint in plant.identifications:
        value = plant.identifications[joint].unexplained
        found = Spread(value, value, value, 1)
    return found


def percent_of(found: Spread | None) -> str:
    """Return a share in percent, with its range over the seeds in brackets."""
    if found is None:
        return "–"
    text, ends = f"{number(100 * found.mean)} %", between(100 * found.low, 100 * found.high)
    return text if found.seeds < 2 or "–" not in ends else f"{text} ({ends})"


def _consequence(result: Reproduction, plant: PlantResult, joints: Sequence[int]) -> str:
    """Say plainly what it means that a model was not accepted; "" where all were."""
    off = [joint for joint in joints if left_off(plant, joint)]
    if not off:
        return ""
    which = f"joint{'s' if len(off) > 1 else ''} {listed(off)}"
    text = f"Plant {short(plant.plant, 40)}: the compensator of {which} was never switched on."
    if plant.plant == NO_HYSTERESIS:
        text += (
            " There is no hysteresis to compensate; what loops there are come from creep and viscosity, which a model "
            "without time does not explain."
        )
    if len(off) == len(joints) and _all_equal(result, plant):
        text += (
            " Its runs “without” and “with compensator” are therefore the same, equal to the last bit: no benefit is "
            "claimed there, and no harm was done."
        )
    return text


def _all_equal(result: Reproduction, plant: PlantResult) -> bool:
    pairs = [pair_of(plant, trial, result.compensator) for trial in trials_of(result)]
    complete = [pair for pair in pairs if None not in pair]
    return bool(complete) and all(same_run(*pair) for pair in complete)
