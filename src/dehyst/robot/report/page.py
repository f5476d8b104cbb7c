"""A reproduction -> one self-contained HTML page."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from markupsafe import Markup

from dehyst.arrays import Array
from dehyst.files import write_atomically
from dehyst.report.figures.panel import says
from dehyst.report.page import make_folder
from dehyst.report.rendering import rendered
from dehyst.report.tables import Table
from dehyst.report.text import count, number, short
from dehyst.report.theme import TEST, TRAIN
from dehyst.robot.experiments.results import PlantResult, Reproduction, TrialRun
from dehyst.robot.report.about import Logs, about_tables, command, honesty
from dehyst.robot.report.arm import scene
from dehyst.robot.report.compared import compared_plate, compared_table, errors_plate
from dehyst.robot.report.hysteresis import hysteresis_plate, inverse_plate, play_plate
from dehyst.robot.report.hysteresis import others_plate as other_loops
from dehyst.robot.report.lines import Line, over_time
from dehyst.robot.report.numbers import (
    OFF,
    Spread,
    joints_of,
    left_off,
    trial_figure,
    trial_name,
    trial_ratio,
    trials_of,
)
from dehyst.robot.report.overview import overview_plate
from dehyst.robot.report.picture import Picture, Plate, picture_svg, write_plate
from dehyst.robot.report.studies import (
    REST,
    Study,
    column,
    harm_studies,
    nothing_to_study,
    other_studies,
    subject_words,
)
from dehyst.robot.report.tables import acceptance, largest_errors, plant_tables
from dehyst.robot.report.tool_words import tool_words
from dehyst.robot.report.trials import OFF_LABEL, ON_LABEL, joint_plate, tool_plate
from dehyst.robot.report.trials import others_plate as other_trials
from dehyst.robot.report.words import UNCHANGED, about_plant, headline_of, lead, shares, worse

# Numbers of the figures in the paper.
IN_THE_PAPER = {"hysteresis": "3", "play": "4", "inverse": "5", "trials": "7", "tool": "8"}


# Bits of the flags, as in core/dehyst.h.
PRESSURE, VALVE = 16, 32
FAULTS = 1 | 2 | 4 | 8 | 64 | 128
KINDS = (
    (PRESSURE, "the desired pressure was limited"),
    (VALVE, "a valve was limited"),
    (FAULTS, "a fault was flagged"),
)


Tile = tuple[str, str, str, str]


# Two drifts are called equal when they differ by less than this share of the larger one.
EQUAL = 0.2


def rest_study(result: Reproduction) -> Study | None:
    """Return "At rest: integrator and compensator", or None if it was not measured."""
    columns = result.studies.get(REST)
    if columns is None or nothing_to_study(result):
        return None
    t, off, on = (column(columns, REST, name) for name in ("time_s", "integrator_off_Nm", "integrator_on_Nm"))
    levels = [float(np.mean(torque)) for torque in (off, on)]
    slopes = [float(np.polyfit(t - t[0], torque, 1)[0]) for torque in (off, on)]
    pair = (Line(off, TEST, OFF_LABEL, 1.5), Line(on, TRAIN, ON_LABEL, 1.5))
    moved = tuple(Line(line.y - line.y[0], line.token, line.label, line.width) for line in pair)
    apart, torque = abs(levels[0] - levels[1]), "integrator [Nm]"
    plate = Plate(
        "rest",
        "At rest: integrator and compensator",
        f"{subject_words(result)} The joint has stopped on a loop and stands still; the integrator holds its angle. "
        "Both runs are the same but for the compensator.".strip(),
        (
            Picture(
                "Torque of the integrator",
                (over_time(t, pair, "time at rest [s]", torque),),
                says(f"Levels {number(apart)} Nm apart."),
            ),
            Picture(
                "Its change since the stop",
                (over_time(t, moved, "time at rest [s]", "change [Nm]"),),
                says(f"Drifts {number(slopes[0])} and {number(slopes[1])} Nm/s."),
            ),
        ),
    )
    words = (
        f"Level: {number(levels[0])} Nm without and {number(levels[1])} Nm with compensator, {number(apart)} Nm apart. "
        "The difference is the torque that the compensator adds there, and the integrator therefore need not.",
        f"{_drift(*slopes)}{_slowing(t, off)}",
    )
    rows = tuple(
        (label, number(level), number(slope), number(float(np.ptp(torque_))))
        for label, level, slope, torque_ in zip((OFF_LABEL, ON_LABEL), levels, slopes, (off, on), strict=True)
    )
    return Study(plate, words, Table("At rest", ("", "mean [Nm]", "drift [Nm/s]", "range [Nm]"), rows))


def _slowing(t: Array, torque: Array) -> str:
    """Whether the drift of the first half is faster than that of the second, as that of creep is."""
    half = t.size // 2
    early, late = (float(np.polyfit(t[part], torque[part], 1)[0]) for part in (slice(0, half), slice(half, None)))
    if abs(late) >= 0.8 * abs(early) or early * late < 0.0:
        return ""
    return (
        f" It slows down, from {number(early)} Nm/s in the first {number(float(t[half] - t[0]), 2)} s to "
        f"{number(late)} Nm/s after them (without compensator), as creep does."
    )


def _drift(off: float, on: float) -> str:
    text = f"Drift: {number(off)} Nm/s without and {number(on)} Nm/s with compensator"
    if abs(off - on) <= EQUAL * max(abs(off), abs(on)):
        within = max(1, math.ceil(100 * abs(off - on) / max(abs(off), abs(on), 1e-300)))
        return (
            f"{text}, equal to within {within} %. The angle stands still, so a model without time stands still, and a "
            "compensator cannot drift: it is the muscles that creep, and the integrator follows them in both cases."
        )
    return f"{text}: not equal, so more than the creep of the muscles is at work."


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


def tiles(result: Reproduction) -> tuple[tuple[Tile, ...], str]:
    """Return tiles (name, error without, error with compensator, remark), and what they show."""
    about = headline_of(result)
    if about is None:
        return (), ""
    joint, trial = about
    if len(result.plants) == 1:
        plant = next(iter(result.plants.values()))
        made = (_tile(trial_name(t).capitalize(), plant, joint, t, result.compensator) for t in trials_of(result))
        return tuple(made), f"Rms error of joint {joint} on plant {short(plant.plant, 30)}"
    made = (_tile(short(p.plant, 30), p, joint, trial, result.compensator) for p in result.plants.values())
    return tuple(made), f"Rms error of joint {joint} in the {trial_name(trial)} trial"


def _tile(name: str, plant: PlantResult, joint: int, trial: str, compensator: str) -> Tile:
    off, on = (trial_figure(plant, joint, trial, c, "rms_deg") for c in (OFF, compensator))
    if left_off(plant, joint):
        return name, _degrees(off), "", "model not accepted, compensator left off"
    ratio = trial_ratio(plant, joint, trial, compensator, "rms_deg")
    return name, _degrees(off), _degrees(on), "without compensator only" if ratio is None else _way(ratio)


def _way(ratio: Spread) -> str:
    percent = f"{number(100 * ratio.mean)} %"
    same = abs(ratio.mean - 1.0) <= UNCHANGED
    text = f"unchanged ({percent})" if same else f"{'down' if ratio.mean < 1.0 else 'up'} to {percent}"
    if ratio.seeds < 2:
        return text
    return f"{text} ({number(100 * ratio.low)}–{number(100 * ratio.high)}, {ratio.seeds} seeds)"


def _degrees(found: Spread | None) -> str:
    return "" if found is None else f"{number(found.mean)}°"


def limit_words(plant: PlantResult) -> str:
    """Say where limits were reached, or that they were not."""
    if not plant.runs:
        return ""
    found = [words for run in plant.runs for words in _of_run(run)]
    if not found:
        return "No pressure or valve was limited and no sensor fault flagged at any logged moment of the trials."
    return f"Limits and faults at the logged moments: {'; '.join(found)}."


def _of_run(run: TrialRun) -> list[str]:
    side = "without" if run.compensator == OFF else "with compensator"
    said = []
    for bits, words in KINDS:
        hit = (run.flags & bits) != 0
        if hit.any():
            joints = ", ".join(str(j + 1) for j in np.flatnonzero(hit.any(axis=0)).tolist())
            share = number(100 * float(hit.any(axis=1).mean()), 2)
            said.append(f"{trial_name(run.trial)} {side}: {words} in {share} % of the time (joint {joints})")
    return said


@dataclass(frozen=True)
class PlantPart:
    """What the page shows of one plant."""

    name: str
    about: str
    plates: tuple[Plate, ...]
    tables: tuple[Table, ...]
    tool: tuple[str, ...]
    limits: str
    largest: tuple[tuple[str, str, bool], ...]


def write_reproduction_report(
    result: Reproduction,
    path: str | os.PathLike[str],
    *,
    figures: str | os.PathLike[str] | None = None,
    logs: Logs | None = None,
) -> Path:
    """Write the page of the paper's experiment: one HTML file that needs nothing else.

    The page works offline, on a phone, in print, light and dark, without JavaScript; the picture of the arm moves
    unless the reader asked for less motion. Names are escaped, and the page forbids scripts and every request.

    Parameters
    ----------
    result
        What the experiment returned. Of ``result.settings`` these keys have a place of their own: ``parameters``
        (the parameter file's values, nested), ``sources`` (dotted name -> meaning and source), ``changes`` (dotted
        name -> value), ``versions`` (package -> version), ``command`` (the line to type); others are listed.
    path
        File to write, for example ``"report.html"``.
    figures
        Folder for every figure as SVG and PNG; made if it does not exist.
    logs
        Name of a run -> its log files, relative to the run's folder.

    Returns
    -------
    path
        The page.

    Raises
    ------
    OutputError
        If a file cannot be written. An earlier file of that name stays as it was.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as folder:
    ...     page = write_reproduction_report(Reproduction({}, "paper", {}), Path(folder) / "report.html")
    ...     page.read_text(encoding="utf-8")[:15]
    '<!DOCTYPE html>'
    """
    parts = tuple(_part(result, plant) for plant in result.plants.values())
    overview = overview_plate(result)
    compared = _compared(result)
    page = write_atomically(path, _render(result, overview, compared, parts, logs))
    if figures is not None:
        _write_figures(result, (overview, compared), parts, make_folder(figures))
    return page


def _part(result: Reproduction, plant: PlantResult) -> PlantPart:
    joints, trials = joints_of(result), trials_of(result)
    about = headline_of(result)
    first, tool_trial = (about[0] if about else 1), ("fast" if "fast" in trials else next(iter(trials), ""))
    joint = plant.identifications.get(first)
    behind = tuple(plant.identifications[j] for j in sorted(plant.identifications) if j != first)
    made = [
        *((hysteresis_plate(plant, joint), play_plate(joint), inverse_plate(plant, joint)) if joint else ()),
        other_loops(plant, behind),
        joint_plate(plant, first, trials, result.compensator),
        errors_plate(plant, first, result),
        other_trials(plant, [j for j in joints if j != first], trials, result.compensator),
        tool_plate(plant, tool_trial, result.compensator),
    ]
    return PlantPart(
        plant.plant,
        about_plant(plant.plant),
        tuple(plate for plate in made if plate is not None),
        (*plant_tables(result, plant), *filter(None, (controllers_table(result, plant),))),
        tool_words(result, plant),
        limit_words(plant),
        largest_errors(result, plant),
    )


def _compared(result: Reproduction) -> Plate | None:
    about = headline_of(result)
    return compared_plate(result, about[0]) if about else None


def _write_figures(
    result: Reproduction, whole: Iterable[Plate | None], parts: Iterable[PlantPart], folder: Path
) -> None:
    """Names: overview, compared, PLANT-figure-3-hysteresis, rest, ..."""
    for plate in filter(None, whole):
        write_plate(plate, folder, plate.key)
    for part in parts:
        stem = re.sub(r"[^a-z0-9]+", "-", part.name.lower()).strip("-") or "plant"
        for plate in part.plates:
            number = IN_THE_PAPER.get(plate.key)
            write_plate(plate, folder, f"{stem}-figure-{number}-{plate.key}" if number else f"{stem}-{plate.key}")
    rest = rest_study(result)
    for study in (*((rest,) if rest else ()), *harm_studies(result)):
        write_plate(study.plate, folder, study.plate.key)


def _drawn(plate: Plate | None, prefix: str = "") -> tuple[Plate, str, list[tuple[str, Markup]]] | None:
    """Figure, its number in the paper, titles and pictures; ids begin with the prefix and the figure's name."""
    if plate is None:
        return None
    pictures = [(p.title, Markup(picture_svg(p, f"{prefix}{plate.key}{k}"))) for k, p in enumerate(plate.pictures)]
    return plate, IN_THE_PAPER.get(plate.key, ""), pictures


def _render(
    result: Reproduction,
    overview: Plate | None,
    compared: Plate | None,
    parts: tuple[PlantPart, ...],
    logs: Logs | None,
) -> str:
    moving, rest = scene(result), rest_study(result)
    return rendered(
        "reproduction.html",
        relation=_relation(result),
        lead=lead(result),
        shares=shares(result),
        worse=worse(result),
        tiles=tiles(result)[0],
        tiles_show=tiles(result)[1],
        acceptance=acceptance(result),
        honesty=honesty(result),
        scene=moving,
        views=[] if moving is None else [(title, Markup(svg)) for title, svg in moving.views],
        overview=_drawn(overview),
        compared=_drawn(compared),
        compared_table=compared_table(result),
        plants=[(part, f"p{k}-", [_drawn(plate, f"p{k}-") for plate in part.plates]) for k, part in enumerate(parts)],
        rest=rest,
        rest_drawn=None if rest is None else _drawn(rest.plate),
        studied=subject_words(result),
        nothing=nothing_to_study(result),
        harm=[(study, _drawn(study.plate)) for study in harm_studies(result)],
        other_studies=other_studies(result),
        command=command(result),
        about_tables=about_tables(result, logs),
    )


def _relation(result: Reproduction) -> str:
    seeds = max((len(plant.figures) for plant in result.plants.values()), default=0)
    joints = ", ".join(map(str, joints_of(result)))
    under = controller_words(result)
    return (
        f"{under}{' · ' if under else ''}compensator “{short(result.compensator, 40)}”{_beside(result)} · "
        f"{count(len(result.plants), 'plant')} · {count(seeds, 'seed')} · joints {joints}"
    )


def _beside(result: Reproduction) -> str:
    """The other compensators that were run."""
    others = [short(name, 20) for name in result.compensators if name != result.compensator]
    return f", beside {', '.join(others)}" if others else ""
