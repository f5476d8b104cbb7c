"""Evaluation: excitations, ISO 9283 test paths and their timing, and what is measured along them."""

from dehyst.evaluation.iso9283 import TestCube, circle, line, rectangle, test_path
from dehyst.evaluation.paths import TRANSFER, Figure, TestPath
from dehyst.evaluation.slowing import slow_down_to
from dehyst.evaluation.timing import Timed, timed

__all__ = [
    "TRANSFER",
    "Figure",
    "TestCube",
    "TestPath",
    "Timed",
    "circle",
    "line",
    "rectangle",
    "slow_down_to",
    "test_path",
    "timed",
]
