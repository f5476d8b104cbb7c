"""Evaluation: excitations and their design, homing, ISO 9283 test paths, and what is measured along them."""

from dehyst.evaluation.cornering import CorneringFigures, cornering_deviation
from dehyst.evaluation.cube import TestCube, circle, line, rectangle, test_path
from dehyst.evaluation.design import design_excitation
from dehyst.evaluation.drift_motion import design_drift_motion
from dehyst.evaluation.excitation import UNSEEN_TIPS, Excitation, decaying_cycles, loops, triangle_sweep
from dehyst.evaluation.homing import Homing, shortest_homing
from dehyst.evaluation.homing_model import home_model
from dehyst.evaluation.homing_search import admissible
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
from dehyst.evaluation.plan import ExcitationPlan, Section
from dehyst.evaluation.sections import Sections, sections
from dehyst.evaluation.separability import Separability, separability
from dehyst.evaluation.slowing import slow_down_to
from dehyst.evaluation.strokes import Limits
from dehyst.evaluation.summary import iso9283
from dehyst.evaluation.timing import Motion, Timed, timed

__all__ = [
    "TRANSFER",
    "UNSEEN_TIPS",
    "CorneringFigures",
    "ErrorSummary",
    "Excitation",
    "ExcitationPlan",
    "Figure",
    "Homing",
    "Limits",
    "Motion",
    "Section",
    "Sections",
    "Separability",
    "TestCube",
    "TestPath",
    "Timed",
    "VelocityFigures",
    "admissible",
    "circle",
    "cornering_deviation",
    "decaying_cycles",
    "design_drift_motion",
    "design_excitation",
    "error_summary",
    "home_model",
    "iso9283",
    "joint_errors",
    "line",
    "loops",
    "path_accuracy",
    "path_repeatability",
    "path_velocity",
    "rectangle",
    "sections",
    "separability",
    "shortest_homing",
    "slow_down_to",
    "test_path",
    "timed",
    "tracking_error",
    "triangle_sweep",
]
