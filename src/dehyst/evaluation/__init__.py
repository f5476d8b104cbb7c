"""Evaluation: excitations, ISO 9283 test paths and their timing, and what is measured along them."""

from dehyst.evaluation.cube import TestCube, circle, line, rectangle, test_path
from dehyst.evaluation.excitation import Excitation, decaying_cycles, decaying_loops, triangle_sweep, validation_loops
from dehyst.evaluation.paths import TRANSFER, Figure, TestPath
from dehyst.evaluation.slowing import slow_down_to
from dehyst.evaluation.timing import Timed, timed

__all__ = [
    "TRANSFER",
    "Excitation",
    "Figure",
    "TestCube",
    "TestPath",
    "Timed",
    "circle",
    "decaying_cycles",
    "decaying_loops",
    "line",
    "rectangle",
    "slow_down_to",
    "test_path",
    "timed",
    "triangle_sweep",
    "validation_loops",
]
