"""Report: a fit -> one self-contained HTML page."""

from dehyst.report.page import write_figures, write_report

__all__ = ["write_figures", "write_report"]
