"""Report: a fit, or the paper's whole experiment, -> one self-contained HTML page."""

from dehyst.report.page import write_figures, write_report
from dehyst.report.reproduction import write_reproduction_report

__all__ = ["write_figures", "write_report", "write_reproduction_report"]
