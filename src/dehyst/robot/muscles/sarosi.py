r"""Six-parameter exponential (Sarosi).

.. math:: F = (a_1 p + a_2) e^{a_3 \kappa} + a_4 \kappa p + a_5 p + a_6

Affine in the pressure, and therefore inverted in closed form,

.. math:: p = \frac{F - a_2 e^{a_3 \kappa} - a_6}{a_1 e^{a_3 \kappa} + a_4 \kappa + a_5}.

Source of the form: Sarosi, static models of Fluidic Muscles, 2009 to 2015; coefficients found in two public
repositories and converted to SI (those of 10 and 20 mm were published for bar and per cent).

Cannot show
-----------
Hysteresis, speed, creep: it is a static map. The coefficients are of one muscle each: the bench's set comes with a
second one, 1.612 times smaller, for the muscles of the same rig in use.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from dehyst.robot.muscles.base import Arithmetic, MuscleModel
from dehyst.robot.muscles.parameters import ParameterSet, length_row, parameter, parameter_set

_BENCH = "bench fit of a DMSP-40 of 1 m, repository droll23/Semester_project, found"
_PAPER = "Sarosi, found in ModelComparison2.m, bar and per cent converted"
_MAP = "fitted to the map measured by Martens and Boblan 2017 on a DMSP-20, 7.5 N rms where it pulls"


def _converted(name: str, source: str, length: float, *numbers: float) -> ParameterSet:
    """Take a set for p in bar and kappa in per cent to SI."""
    a, b, c, d, e, f = numbers
    return parameter_set(name, source, length=length, a1=a * 1e-5, a2=b, a3=c * 1e2, a4=d * 1e-3, a5=e * 1e-5, a6=f)


@dataclass(frozen=True)
class Sarosi(MuscleModel):
    """Exponential map with six parameters.

    Examples
    --------
    >>> Sarosi.published("DMSP-40-bench").static_force([0.0, 0.1, 0.2], 3e5).round().tolist()
    [2673.0, 1342.0, 420.0]
    """

    name = "sarosi"
    length: float = length_row(1.0, _BENCH)
    a1: float = parameter(0.0002, "N/Pa", -0.1, 0.1, _BENCH, "pressure, where the muscle is long")
    a2: float = parameter(369.27, "N", -1e4, 1e4, _BENCH, "rubber, where the muscle is long")
    a3: float = parameter(-37.51, "1", -200.0, -1.0, _BENCH, "rate of the exponential")
    a4: float = parameter(-0.0304, "N/Pa", -1.0, 0.0, _BENCH, "pull of pressure lost with contraction")
    a5: float = parameter(0.0093, "N/Pa", 0.0, 0.1, _BENCH, "pull of pressure", least=-math.inf)
    a6: float = parameter(-546.02, "N", -1e4, 1e4, _BENCH, "rubber")

    PUBLISHED = (
        parameter_set("DMSP-40-bench", _BENCH),
        parameter_set(
            "DMSP-40-installed", f"{_BENCH}; forces divided by 1.612, as its authors do for the muscles in use",
            a1=0.0002 / 1.612, a2=369.27 / 1.612, a4=-0.0304 / 1.612, a5=0.0093 / 1.612, a6=-546.02 / 1.612,
        ),
        _converted(
            "DMSP-20-200N", f"{_PAPER}; loads up to 200 N", 0.25,
            -4.00180705, 292.4620246, -0.32930845, -9.33564098, 294.0538256, -280.498151,
        ),
        _converted(
            "DMSP-20-400N", f"{_PAPER}; loads up to 400 N", 0.25,
            -4.35573, 281.22370, -0.32866, -9.27035, 302.20107, -263.69185,
        ),
        _converted(
            "DMSP-10", _PAPER, 0.25, -9.2194029, 203.7012413, -0.34221042, -3.2255991, 109.2038216, -208.372034
        ),
        _converted("DMSP-20-map", _MAP, 0.296, 6.0078, 197.06, -0.5591, -8.5853, 256.07, -309.60),
    )  # fmt: skip

    @property
    def limits(self) -> tuple[float, float]:
        """Identified on 0 to 0.25; beyond -0.05 the exponential explodes."""
        return -0.05, 0.4

    def _static(self, kappa: Any, pressure: Any, m: Arithmetic) -> Any:
        rubber = (self.a1 * pressure + self.a2) * m.exp(self.a3 * kappa)
        return rubber + (self.a4 * kappa + self.a5) * pressure + self.a6


MUSCLE = Sarosi
