"""The page of the paper's experiment: figures, tables, a moving picture of the arm."""

from dehyst.robot.report.page import write_reproduction_report

__all__ = ["write_reproduction_report"]
