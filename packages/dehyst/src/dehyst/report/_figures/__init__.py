"""The figures of a fit, in the order of its page."""

from __future__ import annotations

from dehyst.identification import Fit
from dehyst.report._figures.choices import candidates_figure, settings_figure
from dehyst.report._figures.loops import arranged_figure, loop_figure, model_figure
from dehyst.report._figures.operators import play_figure, terms_figure, weights_figure
from dehyst.report._figures.residuals import residual_figure, structure_figure
from dehyst.report._parts import PageFigure, numbered

MAKERS = (
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


def all_figures(fit: Fit) -> tuple[PageFigure, ...]:
    """Return the figures of a fit, numbered; those it has no content for are left out."""
    return numbered([figure for maker in MAKERS if (figure := maker(fit)) is not None])
