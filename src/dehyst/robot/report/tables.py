"""Tables of the reproduction: figures with their spread over seeds, accepted models, words about largest errors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from dehyst.report.tables import Table
from dehyst.report.text import count, number, short
from dehyst.robot.experiments.results import ACCEPTABLE, PlantResult, Reproduction, TrialRun
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
    listed,
    run_of,
    same_run,
    seed_figure,
    trial_figure,
    trial_name,
    trial_ratio,
    trials_of,
)
from dehyst.robot.report.reasons import in_words, largest_error
from dehyst.robot.report.tool_tables import tool_tables


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


ACCEPTED, REFUSED = "accepted", "not accepted"


@dataclass(frozen=True)
class Cell:
    """What the table says of one joint of one plant: the unexplained share, and what followed from it."""

    share: str
    verdict: str
    good: bool


@dataclass(frozen=True)
class Acceptance:
    """The part of the page.

    Attributes
    ----------
    rule
        What is tested and where the limit lies.
    head
        Names of the columns.
    rows
        Plant -> one cell a joint, None for a joint that was not identified there.
    words
        What followed on the plants where a model was not accepted.
    """

    rule: str
    head: tuple[str, ...]
    rows: tuple[tuple[str, tuple[Cell | None, ...]], ...]
    words: tuple[str, ...]


def acceptance(result: Reproduction) -> Acceptance | None:
    """Return what was accepted, or None if that is not known of any model."""
    joints = joints_of(result)
    rows = tuple((short(p.plant, 40), tuple(_cell(p, j) for j in joints)) for p in result.plants.values())
    if not any(cell for _, cells in rows for cell in cells):
        return None
    rule = (
        "Before a compensator is switched on, its model is asked for loops that it was not fitted to. Shown is what it "
        "leaves unexplained: the standard deviation of measured hysteresis − inverse model, in percent of that of the "
        f"hysteresis. With more than {100 * ACCEPTABLE:.0f} % the compensator stays off."
    )
    if any(one.direct is not None for plant in result.plants.values() for one in plant.identifications.values()):
        rule += " Of a direct inverse only the terms without time count, and only loops: creep is no hysteresis."
    words = tuple(filter(None, (_consequence(result, plant, joints) for plant in result.plants.values())))
    return Acceptance(rule, tuple(f"joint {joint}" for joint in joints), rows, words)


def _cell(plant: PlantResult, joint: int) -> Cell | None:
    accepted, known = accepted_of(plant, joint)
    if not known:
        return None
    some = f"accepted in {accepted} of {count(known, 'seed')}"
    verdict = ACCEPTED if accepted == known else REFUSED if accepted == 0 else some
    return Cell(_percent(unexplained_of(plant, joint)), verdict, accepted == known)


def unexplained_of(plant: PlantResult, joint: int) -> Spread | None:
    """Return the unexplained share of unseen loops over the seeds."""
    found = identification_figure(plant, joint, "unexplained_unseen")
    if found is None and joint in plant.identifications:
        value = plant.identifications[joint].unexplained
        found = Spread(value, value, value, 1)
    return found


def _percent(found: Spread | None) -> str:
    if found is None:
        return "–"
    text = f"{number(100 * found.mean)} %"
    low, high = number(100 * found.low), number(100 * found.high)
    return text if found.seeds < 2 or low == high else f"{text} ({low}–{high})"


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
    pairs = [(run_of(plant, t, OFF), run_of(plant, t, result.compensator)) for t in trials_of(result)]
    complete = [(off, on) for off, on in pairs if off is not None and on is not None]
    return bool(complete) and all(same_run(off, on) for off, on in complete)
