"""Tables of a plant on the page of the experiment: trials, identification, controllers, accepted models."""

from __future__ import annotations

import numpy as np

from dehyst.findings import Grade
from dehyst.report import Cell, PageSection, PageTable
from dehyst.report import kit as report_kit
from dehyst_robot.experiments import PlantResult, Reproduction
from dehyst_robot.experiments import kit as experiments_kit
from dehyst_robot.report._numbers import (
    OFF,
    Spread,
    accepted_of,
    cases_of,
    cell,
    counted,
    identification_figure,
    joints_of,
    left_off,
    of_seeds,
    pair_of,
    same_run,
    short_names,
    spread_over_seeds,
    trial_figure,
    trial_name,
    trial_ratio,
)
from dehyst_robot.report._tool import tool_tables

# Column -> bits of the flags, as in packages/dehyst/core/dehyst.h.
FLAGS = {"pressure limited": 16, "valve limited": 32, "fault": 1 | 2 | 4 | 8 | 64 | 128}


def plant_tables(result: Reproduction, plant: PlantResult) -> tuple[PageTable, ...]:
    """Return the tables of a plant: joints, tool, identification, controllers, largest errors, limits."""
    tables = (
        _trials(result, plant),
        *tool_tables(result, plant, spread_note(plant)),
        _identification(result, plant),
        _controllers(result, plant),
        largest_errors_table(result, plant),
        limits_table(plant),
    )
    return tuple(filter(None, tables))


def _case_name(joint: int, trial: str) -> str:
    return f"joint {joint}, {trial_name(trial)}"


def spread_note(plant: PlantResult) -> str:
    """Return what the brackets mean."""
    if len(plant.figures) < 2:
        return "One seed."
    return f"Mean of {len(plant.figures)} seeds, in brackets the smallest and the largest."


def _trials(result: Reproduction, plant: PlantResult) -> PageTable | None:
    rows = []
    for joint, trial in cases_of(result):
        cells = _off_on_ratio(result, plant, joint, trial, "rms_deg")
        cells += _off_on_ratio(result, plant, joint, trial, "max_deg")
        # A case that nobody ran has no row.
        if set(cells) != {"–"}:
            rows.append((_case_name(joint, trial), *cells))
    if not rows:
        return None
    head = ("", "rms off [°]", "rms on [°]", "on/off", "max off [°]", "max on [°]", "on/off")
    note = f"{spread_note(plant)}{_left_off_note(result, plant)}"
    return PageTable("Angles in the trials", head, tuple(rows), note)


def _off_on_ratio(
    result: Reproduction, plant: PlantResult, joint: int, trial: str, name: str
) -> list[str]:
    """A figure without compensator, with it, and their ratio, as cells."""
    compensator = result.compensator
    off = trial_figure(plant, joint, trial, OFF, name)
    on = trial_figure(plant, joint, trial, compensator, name)
    ratio = trial_ratio(plant, joint, trial, compensator, name)
    # Both runs are then the same, and a ratio of 1 would be read as "the compensator does nothing".
    if ratio is not None and left_off(plant, joint):
        return [cell(off), cell(on), "left off"]
    return [cell(off), cell(on), cell(ratio)]


def _left_off_note(result: Reproduction, plant: PlantResult) -> str:
    joints = [joint for joint in joints_of(result) if left_off(plant, joint)]
    if not joints:
        return ""
    # "Joint 1" or "Joints 1 and 2".
    noun = report_kit.count(len(joints), "Joint").partition(" ")[2]
    which = f"{noun} {report_kit.listed(joints)}"
    return f" {which}: the model was not accepted, so “on” is without compensator too."


def _identification(result: Reproduction, plant: PlantResult) -> PageTable | None:
    rows = []
    for joint in joints_of(result):
        weights = identification_figure(plant, joint, "nonzero_weights")
        ratio = identification_figure(plant, joint, "inverse_rms_ratio_unseen")
        # A joint that was not identified has no row.
        if weights is None and ratio is None:
            continue
        # Shear and slope are those of the first seed, and only a model of plays has them.
        shear, gain = "–", "–"
        identified = plant.identifications.get(joint)
        if identified is not None and identified.plays is not None:
            shear = report_kit.number(identified.shear)
            gain = report_kit.number(identified.plays.certificate.inverse_gain)
        row = (
            f"joint {joint}",
            counted(weights),
            cell(ratio),
            cell(unexplained_of(plant, joint)),
            shear,
            gain,
            cell(identification_figure(plant, joint, "calibration_residual_Nm")),
        )
        rows.append(row)
    if not rows:
        return None
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
    return PageTable("Identification", head, tuple(rows), note)


def _controllers(result: Reproduction, plant: PlantResult) -> PageTable | None:
    """Return rms errors of every joint and trial under each controller, off and on; None if the paper's ran alone."""
    names = [str(name) for name in result.settings.get("controllers", ())]
    tuned = [_tuned(plant, name) for name in names]
    # The settings may name a controller that the figures of an older run do not hold.
    if not names or None in tuned:
        return None
    rows = []
    for joint, trial in cases_of(result):
        cells = [_off_and_on(plant, name, joint, trial, result.compensator) for name in names]
        rows.append((_case_name(joint, trial), *cells))
    if not rows:
        return None
    # Fewer numbers to tune are worth something, too: they stand below the errors.
    rows.append(("numbers to tune", *map(str, tuned)))
    head = ("", *short_names(names, 20))
    note = "Each controller: rms error in degrees without compensator | with it; mean of the seeds."
    return PageTable("Controllers side by side", head, tuple(rows), note)


def _tuned(plant: PlantResult, name: str) -> int | str | None:
    """How many numbers of a controller are tuned, as the first seed with this controller says."""
    for figures in plant.figures.values():
        controller = figures.get("controllers", {}).get(name)
        if controller:
            tuned: int | str = controller.get("tuned", "its own")
            return tuned
    return None


def _off_and_on(plant: PlantResult, name: str, joint: int, trial: str, compensator: str) -> str:
    means = []
    for which in (OFF, compensator):
        keys = ("controllers", name, "joints", str(joint), "trials", trial, which, "rms_deg")
        errors = [value for value in of_seeds(plant, *keys) if value is not None]
        mean = None
        if errors:
            mean = float(np.mean(errors))
        means.append(report_kit.number(mean, 3))
    return " | ".join(means)


def acceptance(result: Reproduction) -> PageSection | None:
    """Return which models were accepted, and what followed where one was not; None if that is not known of any."""
    joints = joints_of(result)
    rows = []
    judged, direct = False, False
    for plant in result.plants.values():
        row: list[str | Cell] = [report_kit.short(plant.plant, 40)]
        for joint in joints:
            verdict = _cell(plant, joint)
            judged = judged or isinstance(verdict, Cell)
            row.append(verdict)
        rows.append(tuple(row))
        for identified in plant.identifications.values():
            direct = direct or identified.direct is not None
    # A result without any verdict says nothing of acceptance.
    if not judged:
        return None
    rule = (
        "Before a compensator is switched on, its model is tested on loops that it was not fitted to. Shown is what it "
        "leaves unexplained: the standard deviation of measured hysteresis − inverse model, in percent of that of the "
        f"hysteresis. With more than {100 * experiments_kit.POLICY.acceptable:.0f} % the compensator stays off."
    )
    if direct:
        rule += " Of a direct inverse only the terms without time are tested, on loops alone: creep is not hysteresis."
    table = PageTable("", ("plant", *(f"joint {joint}" for joint in joints)), tuple(rows))
    return PageSection("accepted", "Which models were accepted", (table,), rule)


def _cell(plant: PlantResult, joint: int) -> str | Cell:
    accepted, seeds = accepted_of(plant, joint)
    if not seeds:
        return "–"
    share = percent_of(unexplained_of(plant, joint))
    if accepted == seeds:
        return Cell(share, "accepted", Grade.GOOD)
    if accepted == 0:
        return Cell(share, "not accepted", Grade.CARE)
    verdict = f"accepted in {accepted} of {report_kit.count(seeds, 'seed')}"
    return Cell(share, verdict, Grade.CARE)


def unexplained_of(plant: PlantResult, joint: int) -> Spread | None:
    """Return the unexplained share of unseen loops over the seeds."""
    spread = identification_figure(plant, joint, "unexplained_unseen")
    if spread is None and joint in plant.identifications:
        return spread_over_seeds([plant.identifications[joint].unexplained])
    return spread


def percent_of(spread: Spread | None) -> str:
    """Return a share in percent, with its range over the seeds in brackets."""
    if spread is None:
        return "–"
    mean = f"{report_kit.number(100 * spread.mean)} %"
    ends = report_kit.between(100 * spread.low, 100 * spread.high)
    # No brackets where both ends are printed as the same number.
    if spread.seeds < 2 or "–" not in ends:
        return mean
    return f"{mean} ({ends})"


def largest_errors_table(result: Reproduction, plant: PlantResult) -> PageTable | None:
    """Return when in the path each joint's error with compensator is largest, in the runs of the first seed."""
    rows = []
    for joint, trial in cases_of(result):
        off, on = pair_of(plant, trial, result.compensator)
        if off is None or on is None or same_run(off, on):
            continue
        # The moment at which the error with compensator is largest.
        sample = int(np.argmax(np.abs(on.error[:, joint - 1])))
        # The runs are logged at moments of their own.
        without = np.interp(on.time[sample], off.time, off.error[:, joint - 1])
        followed = int(on.figure[sample])
        place = "between two"
        if 0 <= followed < len(on.figures):
            place = on.figures[followed]
        row = (
            _case_name(joint, trial),
            report_kit.number(float(np.rad2deg(abs(on.error[sample, joint - 1])))),
            report_kit.number(float(np.rad2deg(abs(without)))),
            report_kit.number(float(on.time[sample] - on.time[0])),
            place,
        )
        rows.append(row)
    if not rows:
        return None
    head = ("", "largest on [°]", "off at that moment [°]", "at [s]", "figure of the path")
    return PageTable("Where the largest errors lie", head, tuple(rows), "First seed.", folded=True)


def limits_table(plant: PlantResult) -> PageTable | None:
    """Return in which share of the logged moments a limit or a fault was flagged, and on which joints."""
    rows = []
    for run in plant.runs:
        # Several compensators may have run: the name tells which one.
        side = "off"
        if run.compensator != OFF:
            side = f"on, {report_kit.short(run.compensator, 20)}"
        cells = [_flagged(run, bits) for bits in FLAGS.values()]
        rows.append((f"{trial_name(run.trial)}, {side}", *cells))
    if not rows:
        return None
    note = "Share of the logged moments in percent, with the joints in brackets; first seed."
    return PageTable("Limits and faults", ("", *FLAGS), tuple(rows), note, folded=True)


def _flagged(run: experiments_kit.TrialRun, bits: int) -> str:
    # (T, n): a moment counts once, however many joints it hits.
    hit = (run.flags & bits) != 0
    if not hit.any():
        return "0"
    joints = ", ".join(map(str, np.flatnonzero(hit.any(axis=0)) + 1))
    return f"{report_kit.number(100 * float(hit.any(axis=1).mean()), 2)} ({joints})"
