"""Figures of the report, one file each, in the order of the page."""

from __future__ import annotations

from dehyst.identification.fit import Fit
from dehyst.report.figures.arranged import arranged_figure
from dehyst.report.figures.candidates import candidates_figure
from dehyst.report.figures.loop import loop_figure
from dehyst.report.figures.model_inverse import model_figure
from dehyst.report.figures.panel import Figure, Panel
from dehyst.report.figures.play import play_figure
from dehyst.report.figures.residual import residual_figure
from dehyst.report.figures.settings import settings_figure
from dehyst.report.figures.structure import structure_figure
from dehyst.report.figures.weights import terms_figure, weights_figure

__all__ = ["Figure", "Panel", "all_figures"]

_MAKERS = (
    loop_figure,
    arranged_figure,
    play_figure,
    model_figure,
    residual_figure,
    structure_figure,
    weights_figure,
    terms_figure,
    candidates_figure,
    settings_figure,
)


def all_figures(fit: Fit) -> tuple[Figure, ...]:
    """Return the figures of a fit; those it has no content for are left out."""
    made = (maker(fit) for maker in _MAKERS)
    return tuple(figure for figure in made if figure is not None)
