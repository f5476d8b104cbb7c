"""HTML pages and pictures of results: a fit, a comparison of families, a check for drift."""

from dehyst.lazy import lazy_names

TYPE_CHECKING = False
if TYPE_CHECKING:
    from dehyst.report._compare import write_comparison_figure as write_comparison_figure
    from dehyst.report._compare import write_comparison_report as write_comparison_report
    from dehyst.report._drawing import Bar as Bar
    from dehyst.report._drawing import PanelLine as PanelLine
    from dehyst.report._drawing import bars as bars
    from dehyst.report._drawing import chart as chart
    from dehyst.report._drawn import as_html as as_html
    from dehyst.report._drawn import plot as plot
    from dehyst.report._drift import write_drift_report as write_drift_report
    from dehyst.report._fit import write_figures as write_figures
    from dehyst.report._fit import write_report as write_report
    from dehyst.report._parts import Axes as Axes
    from dehyst.report._parts import Block as Block
    from dehyst.report._parts import Cell as Cell
    from dehyst.report._parts import Draw as Draw
    from dehyst.report._parts import Page as Page
    from dehyst.report._parts import PageFigure as PageFigure
    from dehyst.report._parts import PageSection as PageSection
    from dehyst.report._parts import PageTable as PageTable
    from dehyst.report._parts import Panel as Panel
    from dehyst.report._parts import Step as Step
    from dehyst.report._parts import Tile as Tile
    from dehyst.report._svg import require_picture_name as require_picture_name
    from dehyst.report._theme import ThemeColour as ThemeColour
    from dehyst.report._thin import Window as Window

__getattr__, __dir__, __all__ = lazy_names(
    "dehyst.report",
    {
        "_compare": "write_comparison_figure write_comparison_report",
        "_drawing": "Bar PanelLine bars chart",
        "_drawn": "as_html plot",
        "_drift": "write_drift_report",
        "_fit": "write_figures write_report",
        "_parts": "Axes Block Cell Draw Page PageFigure PageSection PageTable Panel Step Tile",
        "_svg": "require_picture_name",
        "_theme": "ThemeColour",
        "_thin": "Window",
    },
)
