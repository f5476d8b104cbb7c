"""ISO 9283: test paths, and the figures measured along them."""

from dehyst.robot.iso9283.cube import TestCube, circle, line, rectangle, test_path
from dehyst.robot.iso9283.metrics import (
    cornering_deviation,
    error_summary,
    path_accuracy,
    path_repeatability,
    path_velocity,
    tracking_error,
)
from dehyst.robot.iso9283.paths import Figure, TestPath
from dehyst.robot.iso9283.sections import sections
from dehyst.robot.iso9283.slowing import slow_down_to
from dehyst.robot.iso9283.summary import iso9283
from dehyst.robot.iso9283.timing import Timed, timed

__all__ = [
    "Figure",
    "TestCube",
    "TestPath",
    "Timed",
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
]
