"""Evaluation: excitations, ISO 9283 test paths and their timing, and what is measured along them."""

from dehyst.evaluation.cornering import CorneringFigures, cornering_deviation
from dehyst.evaluation.cube import TestCube, circle, line, rectangle, test_path
from dehyst.evaluation.excitation import UNSEEN_TIPS, Excitation, decaying_cycles, loops, triangle_sweep
from dehyst.evaluation.metrics import (
    ErrorSummary,
    VelocityFigures,
    error_summary,
    joint_errors,
    path_accuracy,
    path_repeatability,
    path_velocity,
    tracking_error,
)
from dehyst.evaluation.paths import TRANSFER, Figure, TestPath
from dehyst.evaluation.sections import Sections, sections
from dehyst.evaluation.slowing import slow_down_to
from dehyst.evaluation.summary import iso9283
from dehyst.evaluation.timing import Motion, Timed, timed

__all__ = [
    "TRANSFER",
    "UNSEEN_TIPS",
    "CorneringFigures",
    "ErrorSummary",
    "Excitation",
    "Figure",
    "Motion",
    "Sections",
    "TestCube",
    "TestPath",
    "Timed",
    "VelocityFigures",
    "circle",
    "cornering_deviation",
    "decaying_cycles",
    "error_summary",
    "iso9283",
    "joint_errors",
    "line",
    "loops",
    "path_accuracy",
    "path_repeatability",
    "path_velocity",
    "rectangle",
    "sections",
    "slow_down_to",
    "test_path",
    "timed",
    "tracking_error",
    "triangle_sweep",
]
