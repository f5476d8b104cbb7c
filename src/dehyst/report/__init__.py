"""HTML pages and pictures of results: a fit, a comparison of families, a check for drift."""

from dehyst.report import theme  # noqa: F401 - before anything that draws: it loads matplotlib without its lines
from dehyst.report.compare import write_comparison_figure, write_comparison_report
from dehyst.report.drawn import as_html, plot
from dehyst.report.drift import write_drift_report
from dehyst.report.fit import write_figures, write_report

__all__ = [
    "as_html",
    "plot",
    "write_comparison_figure",
    "write_comparison_report",
    "write_drift_report",
    "write_figures",
    "write_report",
]
