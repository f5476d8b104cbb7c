"""Corner rounding of the commanded path itself, and where a run rounds its worst corner."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from dehyst.errors import DehystError
from dehyst.evaluation import Figure, TestCube, cornering_deviation, test_path
from dehyst.experiments.results import Reproduction, TrialRun

CORNERS = "rectangle"  # name of the figure that has some


@dataclass(frozen=True)
class Corner:
    """The corner that a run stays farthest from.

    Attributes
    ----------
    commanded_mm
        How near the commanded path comes to its worst corner.
    sample
        Of the run, where it is nearest to its own worst corner, first cycle.
    """

    commanded_mm: float
    sample: int


def worst_corner(result: Reproduction, run: TrialRun) -> Corner | None:
    """Return the worst corner of a run, or None if the path is not known from the settings."""
    figure = _figure(result)
    if figure is None or CORNERS not in run.figures:
        return None
    here = np.flatnonzero((run.figure == run.figures.index(CORNERS)) & (run.cycle == run.cycle[0]))
    if here.size < 2:
        return None
    try:
        found = cornering_deviation(figure, run.time[here], run.tool_desired[here], run.cycle[here])
    except DehystError:
        return None
    distance = np.linalg.norm(run.tool[here, None] - np.asarray(figure.corners)[None], axis=2)
    worst = int(np.argmax(distance.min(axis=0)))
    if np.isnan(found.rounding_error):
        return None
    return Corner(1e3 * found.rounding_error, int(here[np.argmin(distance[:, worst])]))


def _figure(result: Reproduction) -> Figure | None:
    """The figure with corners, from the settings' cube, or None."""
    parameters = result.settings.get("parameters")
    path = parameters.get("path") if isinstance(parameters, Mapping) else None
    if not isinstance(path, Mapping):
        return None
    try:
        figures = test_path(TestCube(path["cube_m"], path["center_m"]), path["rounding_m"]).figures
    except (KeyError, TypeError, DehystError):
        return None
    return next((figure for figure in figures if figure.name == CORNERS), None)
