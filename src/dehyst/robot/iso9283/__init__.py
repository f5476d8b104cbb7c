"""ISO 9283: test paths, and the figures measured along them."""

from dehyst.robot.iso9283.metrics import (
    cornering_deviation,
    error_summary,
    iso9283,
    path_accuracy,
    path_repeatability,
    path_velocity,
    tracking_error,
    tracking_figures,
)
from dehyst.robot.iso9283.paths import Figure, TestCube, TestPath, circle, line, rectangle, test_path
from dehyst.robot.iso9283.sections import sections
from dehyst.robot.iso9283.timing import Timed, Timing, slow_down_to, timed

__all__ = [
    "Figure",
    "TestCube",
    "TestPath",
    "Timed",
    "Timing",
    "circle",
    "cornering_deviation",
    "error_summary",
    "iso9283",
    "line",
    "path_accuracy",
    "path_repeatability",
    "path_velocity",
    "rectangle",
    "sections",
    "slow_down_to",
    "test_path",
    "timed",
    "tracking_error",
    "tracking_figures",
]
