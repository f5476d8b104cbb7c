"""A reproduction -> one self-contained HTML page."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from markupsafe import Markup

from dehyst.experiments.results import PlantResult, Reproduction
from dehyst.files import write_atomically
from dehyst.report.page import make_folder
from dehyst.report.rendering import rendered
from dehyst.report.reproduction.about import Logs, about_tables, command, honesty
from dehyst.report.reproduction.acceptance import acceptance
from dehyst.report.reproduction.arm import scene
from dehyst.report.reproduction.compared import compared_plate, compared_table, errors_plate
from dehyst.report.reproduction.controllers import controller_words, controllers_table
from dehyst.report.reproduction.hysteresis import hysteresis_plate, inverse_plate, play_plate
from dehyst.report.reproduction.hysteresis import others_plate as other_loops
from dehyst.report.reproduction.limits import limit_words
from dehyst.report.reproduction.numbers import joints_of, trials_of
from dehyst.report.reproduction.overview import overview_plate
from dehyst.report.reproduction.picture import Plate, picture_svg, write_plate
from dehyst.report.reproduction.studies import nothing_to_study, other_studies, subject_words
from dehyst.report.reproduction.study_harm import harm_studies
from dehyst.report.reproduction.study_rest import rest_study
from dehyst.report.reproduction.tables import largest_errors, plant_tables
from dehyst.report.reproduction.tiles import tiles
from dehyst.report.reproduction.tool_words import tool_words
from dehyst.report.reproduction.trials import joint_plate, tool_plate
from dehyst.report.reproduction.trials import others_plate as other_trials
from dehyst.report.reproduction.words import about_plant, headline_of, lead, shares, worse
from dehyst.report.tables import Table
from dehyst.report.text import count, short

# Numbers of the figures in the paper.
IN_THE_PAPER = {"hysteresis": "3", "play": "4", "inverse": "5", "trials": "7", "tool": "8"}


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
