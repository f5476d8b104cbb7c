"""The page of the paper's experiment: figures, tables, a moving picture of the arm."""

from __future__ import annotations

import os
import re
from pathlib import Path

from markupsafe import Markup

from dehyst.report import Block, Page, PageFigure, PageSection
from dehyst.report import kit as report_kit
from dehyst_robot.experiments import PlantResult, Reproduction
from dehyst_robot.report._about import Logs, about_section
from dehyst_robot.report._arm import scene
from dehyst_robot.report._baseline import baseline
from dehyst_robot.report._hysteresis import hysteresis_figures
from dehyst_robot.report._hysteresis import others_figure as other_loops
from dehyst_robot.report._numbers import joints_of, pair_of, trials_of
from dehyst_robot.report._overview import (
    alone_figure,
    compared_figure,
    errors_figure,
    overview_figure,
)
from dehyst_robot.report._studies import (
    harm_studies,
    nothing_to_study,
    other_studies,
    rest_study,
    subject_words,
)
from dehyst_robot.report._tables import acceptance, plant_tables
from dehyst_robot.report._trials import tool_figure, trial_drawings
from dehyst_robot.report._words import (
    about_plant,
    error_tiles,
    headline_of,
    lead,
    lost,
    met,
    relation,
    shares_table,
    worse,
)


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
    # The tiles say in two numbers what the page is about.
    shown, note = error_tiles(result)
    page = Page(
        kind="The experiment of Kastner, Gattringer and Naderer (2012), in simulation",
        title="Hysteresis compensation of a pneumatic arm",
        relation=relation(result),
        subject="the experiment reproduced",
        lead=lead(result),
        more=tuple(filter(None, (lost(result), worse(result)))),
        summary=shares_table(result),
        tiles=shown,
        tiles_note=note,
        opening=Markup(scene(result) or ""),
        sections=_sections(result, logs),
    )
    return report_kit.write_page(page, path, figures)


def _sections(result: Reproduction, logs: Logs | None) -> tuple[PageSection | PageFigure, ...]:
    """Sections in the order of the page; those without anything to show are left out."""
    about = headline_of(result)
    sections: list[PageSection | PageFigure | None] = [overview_figure(result)]
    if about is not None:
        sections += [compared_figure(result, about[0]), alone_figure(result, about[0])]
    sections += [acceptance(result), baseline(result)]
    remarks = met(result)
    if remarks:
        sections.append(PageSection("met", "What the joints met", remarks))
    # The first plant is open, the others are folded.
    for k, plant in enumerate(result.plants.values()):
        sections.append(_plant(result, plant, k))
    sections.append(rest_study(result))
    harm, more_tables, nothing = (
        harm_studies(result),
        other_studies(result),
        nothing_to_study(result),
    )
    if harm:
        words = (
            f"{subject_words(result)} Above the dashed line at 1 the error is larger with compensator than without; of "
            "the bars, beyond it."
        )
        sections.append(PageSection("harm", "Where compensation hurts", harm, words))
    if nothing:
        title = "At rest, and where compensation hurts"
        sections.append(PageSection("nothing", title, (nothing,)))
    if more_tables:
        sections.append(PageSection("studies", "Other studies", more_tables))
    sections.append(about_section(result, logs))
    return tuple(filter(None, sections))


def _plant(result: Reproduction, plant: PlantResult, k: int) -> PageSection:
    """What the page shows of one plant, folded but for the first one."""
    joints, trials = joints_of(result), trials_of(result)
    first, tool_trial = 1, next(iter(trials), "")
    about = headline_of(result)
    if about is not None:
        first = about[0]
    # The tool is farthest off where it is fast.
    if "fast" in trials:
        tool_trial = "fast"
    identified = plant.identifications
    other_joints = [joint for joint in joints if joint != first]
    others_identified = tuple(identified[j] for j in sorted(identified) if j != first)
    pairs = {trial: pair_of(plant, trial, result.compensator) for trial in trials}
    # The paper's figures in the paper's order.
    figures: list[PageFigure | None] = []
    if first in identified:
        figures += hysteresis_figures(plant, identified[first])
    figures += [
        other_loops(plant, others_identified),
        *trial_drawings(plant, first, other_joints, pairs),
        errors_figure(plant, first, result),
        tool_figure(plant, tool_trial, result.compensator),
    ]
    blocks: list[Block | PageSection] = [*filter(None, figures)]
    tables = plant_tables(result, plant)
    if tables:
        blocks.append(PageSection("tables", "Figures in numbers", tables))
    # Names of plants may be the user's, and those of files may not hold everything.
    files = re.sub(r"[^a-z0-9]+", "-", plant.plant.lower())[:60].strip("-") or "plant"
    words = about_plant(plant.plant)
    return PageSection(
        f"p{k}", f"Plant {plant.plant}", tuple(blocks), about=words, folds=k > 0, files=files
    )
