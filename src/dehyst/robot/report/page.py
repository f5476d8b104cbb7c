"""The page of the paper's experiment: figures, tables, a moving picture of the arm."""

from __future__ import annotations

import os
import re
from pathlib import Path

from markupsafe import Markup

from dehyst.report.page import write_page
from dehyst.report.parts import Block, Figure, Page, Section, Table
from dehyst.robot.experiments.results import PlantResult, Reproduction
from dehyst.robot.report.about import Logs, about_section
from dehyst.robot.report.arm import scene
from dehyst.robot.report.baseline import baseline
from dehyst.robot.report.hysteresis import joint_figures
from dehyst.robot.report.hysteresis import others_figure as other_loops
from dehyst.robot.report.numbers import joints_of, pair_of, trials_of
from dehyst.robot.report.overview import compared_figure, errors_figure, overview_figure
from dehyst.robot.report.reasons import largest_errors, limit_words
from dehyst.robot.report.studies import harm_studies, nothing_to_study, other_studies, rest_study, subject_words
from dehyst.robot.report.tables import acceptance, plant_tables
from dehyst.robot.report.tool import tool_words
from dehyst.robot.report.trials import tool_figure, trial_figures
from dehyst.robot.report.words import about_plant, headline_of, lead, lost, met, relation, shares, tiles, worse


def write_reproduction_report(
    result: Reproduction,
    path: str | os.PathLike[str],
    *,
    figures: str | os.PathLike[str] | None = None,
    logs: Logs | None = None,
) -> Path:
    """Write the page of the paper's experiment: one HTML file that needs nothing else.

    The page works offline, on a phone, in print, light and dark, without JavaScript; the picture of the arm moves
    unless the reader asked for less motion. Names are escaped, and the page forbids every request and every script but
    its own.

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
    shown, note = tiles(result)
    page = Page(
        kind="The experiment of Kastner, Gattringer and Naderer (2012), in simulation",
        title="Hysteresis compensation of a pneumatic arm",
        relation=relation(result),
        subject="the experiment reproduced",
        lead=lead(result),
        more=tuple(filter(None, (lost(result), worse(result)))),
        summary=shares(result),
        tiles=shown,
        tiles_note=note,
        opening=Markup(scene(result) or ""),
        sections=_sections(result, logs),
    )
    return write_page(page, path, figures)


def _sections(result: Reproduction, logs: Logs | None) -> tuple[Section | Figure, ...]:
    about = headline_of(result)
    harm, other, nothing = harm_studies(result), other_studies(result), nothing_to_study(result)
    studied = (
        f"{subject_words(result)} Above the dashed line at 1 the error is larger with compensator than without; of the "
        "bars, beyond it."
    )
    found = (
        overview_figure(result),
        compared_figure(result, about[0]) if about else None,
        acceptance(result),
        baseline(result),
        Section("met", "What the joints met", met(result)) if met(result) else None,
        *(_plant(result, plant, k) for k, plant in enumerate(result.plants.values())),
        rest_study(result),
        Section("harm", "Where compensation hurts", harm, studied) if harm else None,
        Section("nothing", "At rest, and where compensation hurts", (nothing,)) if nothing else None,
        Section("studies", "Other studies", other) if other else None,
        about_section(result, logs),
    )
    return tuple(section for section in found if section is not None)


def _plant(result: Reproduction, plant: PlantResult, k: int) -> Section:
    """What the page shows of one plant, folded but for the first one."""
    joints, trials = joints_of(result), trials_of(result)
    about = headline_of(result)
    first, tool_trial = (about[0] if about else 1), ("fast" if "fast" in trials else next(iter(trials), ""))
    behind = tuple(plant.identifications[j] for j in sorted(plant.identifications) if j != first)
    pairs = {trial: pair_of(plant, trial, result.compensator) for trial in trials}
    figures = (
        *(joint_figures(plant, plant.identifications[first]) if first in plant.identifications else ()),
        other_loops(plant, behind),
        *trial_figures(plant, first, [j for j in joints if j != first], pairs),
        errors_figure(plant, first, result),
        tool_figure(plant, tool_trial, result.compensator),
    )
    tables = plant_tables(result, plant)
    blocks: list[Block | Section] = [figure for figure in figures if figure is not None]
    if tables:
        blocks.append(Section("tables", "Figures in numbers", tables))
    blocks += _errors(result, plant)
    files = re.sub(r"[^a-z0-9]+", "-", plant.plant.lower())[:60].strip("-") or "plant"
    words = about_plant(plant.plant)
    return Section(f"p{k}", f"Plant {plant.plant}", tuple(blocks), about=words, folds=k > 0, files=files)


def _errors(result: Reproduction, plant: PlantResult) -> tuple[Section, ...]:
    """Which errors grow with the compensator, and where the largest ones lie."""
    tool, limits, largest = tool_words(result, plant), limit_words(plant), largest_errors(result, plant)
    said = [*tool, limits] if limits else [*tool]
    rose, fell = ([(name, words) for name, words, grew in largest if grew is larger] for larger in (True, False))
    if largest:
        said.append(
            "In the runs of the first seed the compensator makes the largest error of a joint larger in "
            f"{len(rose) or 'none'} of {len(largest)} cases."
        )
    tables = [
        Table("Largest errors that are larger with compensator", (), tuple(rose)),
        Table("Largest errors that are smaller with compensator", (), tuple(fell), folded=True),
    ]
    title = "Where it gets worse, and where the largest errors lie" if largest or tool else "Limits"
    blocks: tuple[Block, ...] = (*said, *(table for table in tables if table.rows))
    return (Section("largest", title, blocks),) if blocks else ()
