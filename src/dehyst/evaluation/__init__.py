"""Evaluation: excitations and their design, homing, ISO 9283 test paths, and what is measured along them."""

from dehyst.evaluation.cube import TestCube, circle, line, rectangle, test_path
from dehyst.evaluation.design import design_excitation
from dehyst.evaluation.drift_motion import design_drift_motion
from dehyst.evaluation.excitation import UNSEEN_TIPS, decaying_cycles, loops, triangle_sweep
from dehyst.evaluation.homing import Homing, shortest_homing
from dehyst.evaluation.homing_model import home_model
from dehyst.evaluation.homing_search import admissible
from dehyst.evaluation.metrics import (
    cornering_deviation,
    error_summary,
    path_accuracy,
    path_repeatability,
    path_velocity,
    tracking_error,
)
from dehyst.evaluation.paths import Figure, TestPath
from dehyst.evaluation.plan import ExcitationPlan
from dehyst.evaluation.sections import sections
from dehyst.evaluation.separability import separability
from dehyst.evaluation.slowing import slow_down_to
from dehyst.evaluation.strokes import Limits
from dehyst.evaluation.summary import iso9283
from dehyst.evaluation.timing import Timed, timed

__all__ = [
    "UNSEEN_TIPS",
    "ExcitationPlan",
    "Figure",
    "Homing",
    "Limits",
    "TestCube",
    "TestPath",
    "Timed",
    "admissible",
    "circle",
    "cornering_deviation",
    "decaying_cycles",
    "design_drift_motion",
    "design_excitation",
    "error_summary",
    "home_model",
    "iso9283",
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
