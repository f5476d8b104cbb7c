"""The page of the paper's experiment: figures, tables, a moving picture of the arm."""

from dehyst.report.reproduction.page import write_reproduction_report

__all__ = ["write_reproduction_report"]
