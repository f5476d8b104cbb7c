"""Static force maps fitted to measurements: the maker's sizing tool, Sarosi, Aschemann-Schindele."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from dehyst.robot.muscles.base import Arithmetic, MuscleModel, polynomial
from dehyst.robot.muscles.parameters import ParameterSet, length_row, parameter, parameter_set

_BOLEN = "maker's tool as fitted by Bolen, found"
_GROWS = f"{_BOLEN}; force grows with the length"


@dataclass(frozen=True)
class Maker(MuscleModel):
    r"""Force map of the manufacturer's sizing tool.

    .. math::

        F = F_m \left[ a_0 (e^{-a_1 \kappa/\kappa_m} - 1) + \frac{p}{p_r} e^{-a_3 (\kappa/\kappa_m)^2} \right],
        \qquad F_m = F_\infty \arctan(c\,(l_0 - l_e)) \quad \text{or } F_\infty \text{ where } c = 0

    What the tool for sizing DMSP muscles answers, fitted by B. Bolen, Portland State University (repository
    Agile-and-Adaptive-Robotics/Bipedal_Robot): exact coefficients of that fit, high confidence. Affine in the pressure,
    defined for small stretches as well.

    Cannot show
    -----------
    Hysteresis, speed, creep: it is a static map. A bench muscle differs from it by 10 to 20 %
    (`sarosi`).

    Examples
    --------
    >>> Maker.published("DMSP-40").static_force([0.0, 0.1, 0.2], 3e5).round().tolist()
    [3096.0, 1469.0, 65.0]
    """

    name = "maker"
    length: float = length_row(0.4)
    force: float = parameter(6398.4, "N", 10.0, 1e5, _BOLEN, "F_infinity, scale of all forces")
    length_rate: float = parameter(0.0, "1/m", 0.0, 100.0, _BOLEN, "c, how the force grows with the length", False)
    end_length: float = parameter(0.0, "m", 0.0, 0.1, _BOLEN, "l_e, length that does not pull", False)
    passive: float = parameter(0.122366, "1", 0.0, 2.0, _BOLEN, "a_0, share that rubber takes")
    decay: float = parameter(10.47143, "1", 0.1, 40.0, _BOLEN, "a_1, how soon it does so", least=0.0)
    bell: float = parameter(2.023288, "1", 0.0, 10.0, _BOLEN, "a_3, how the pull of pressure falls")
    contraction: float = parameter(0.25, "1", 0.05, 0.5, _BOLEN, "kappa_m, largest contraction", False)
    reference_pressure: float = parameter(620e3, "Pa", 1e4, 1e6, _BOLEN, "p_r", False)

    PUBLISHED = (
        parameter_set("DMSP-40", f"{_BOLEN}; length independent"),
        parameter_set(
            "DMSP-20", _GROWS, length=0.25, force=620 * 1.4877, length_rate=620 * 0.0248, end_length=0.0075,
            passive=0.257853, decay=6.476614, bell=1.320877,
        ),
        parameter_set(
            "DMSP-10", _GROWS, length=0.25, force=620 * 0.4895, length_rate=620 * 0.03068, end_length=0.0075,
            passive=0.568208, decay=4.254425, bell=0.559728,
        ),
    )  # fmt: skip

    @cached_property
    def largest_force(self) -> float:
        """F_m, at rest length and reference pressure. [N]"""
        rate = self.length_rate
        return self.force * (math.atan(rate * (self.length - self.end_length)) if rate else 1.0)

    @property
    def limits(self) -> tuple[float, float]:
        """Beyond it the exponential answers with forces no muscle has."""
        return -0.5 * self.contraction, 2.0 * self.contraction

    def _static(self, kappa: Any, pressure: Any, m: Arithmetic) -> Any:
        k = kappa / self.contraction
        pull = pressure / self.reference_pressure * m.exp(-self.bell * k * k)
        return self.largest_force * (self.passive * (m.exp(-self.decay * k) - 1.0) + pull)


_BENCH = "bench fit of a DMSP-40 of 1 m, repository droll23/Semester_project, found"
_SAROSI = "Sarosi, found in ModelComparison2.m, bar and per cent converted"
_MAP = "fitted to the map measured by Martens and Boblan 2017 on a DMSP-20, 7.5 N rms where it pulls"


def _converted(name: str, source: str, length: float, *numbers: float) -> ParameterSet:
    """Take a set for p in bar and kappa in per cent to SI."""
    a, b, c, d, e, f = numbers
    return parameter_set(name, source, length=length, a1=a * 1e-5, a2=b, a3=c * 1e2, a4=d * 1e-3, a5=e * 1e-5, a6=f)


@dataclass(frozen=True)
class Sarosi(MuscleModel):
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
            "DMSP-20-200N", f"{_SAROSI}; loads up to 200 N", 0.25,
            -4.00180705, 292.4620246, -0.32930845, -9.33564098, 294.0538256, -280.498151,
        ),
        _converted(
            "DMSP-20-400N", f"{_SAROSI}; loads up to 400 N", 0.25,
            -4.35573, 281.22370, -0.32866, -9.27035, 302.20107, -263.69185,
        ),
        _converted(
            "DMSP-10", _SAROSI, 0.25, -9.2194029, 203.7012413, -0.34221042, -3.2255991, 109.2038216, -208.372034
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


_SEE_SETS = "fitted, see SETS"
_PULL = (1036.8e-5, -237.8e-5, -35150e-5, 86649e-5)
_RUBBER = (67.1, 20759.0, -214268.0, 939766.0, -1494522.0)


@dataclass(frozen=True)
class AschemannSchindele(MuscleModel):
    r"""Polynomials in the contraction, affine in the pressure (Aschemann, Schindele 2008; Hildebrandt and others 2005).

    .. math::

        F = p \sum_{m=0}^{3} a_m \kappa^m - \sum_{n=0}^{4} b_n \kappa^n - b_r\, \mathrm{sgn}(\kappa) |\kappa|^{2/3}

    b_r = 0 is the form of Aschemann and Schindele; three coefficients a, four b and the root are that of Hildebrandt,
    Sawodny, Neumann and Hartmann (ACC 2005).

    Structure: own knowledge, high confidence; the power 2/3 of the variant low. The coefficients here were fitted to
    the maps of `maker` and `sarosi` from 0.5 to 6 bar and 0 to 0.25.

    Cannot show
    -----------
    Hysteresis, speed, creep: it is a static map. Polynomials leave the data quickly outside the range of the fit.

    Examples
    --------
    >>> AschemannSchindele.published("DMSP-40-maker").static_force([0.0, 0.1, 0.2], 3e5).round().tolist()
    [3043.0, 1454.0, 54.0]
    """

    name = "aschemann-schindele"
    length: float = length_row(0.4)
    a: tuple[float, ...] = parameter(_PULL, "N/Pa", -10.0, 10.0, _SEE_SETS, "a_m, pull of pressure")
    b: tuple[float, ...] = parameter(_RUBBER, "N", -1e8, 1e8, _SEE_SETS, "b_n, rubber")
    root: float = parameter(0.0, "N", -1e6, 1e6, _SEE_SETS, "b_r, of the two-thirds power", False)

    PUBLISHED = (
        parameter_set("DMSP-40-maker", "fitted to the maker's map of a DMSP-40, 25 N rms"),
        parameter_set(
            "DMSP-40-bench", "fitted to Sarosi's map of a DMSP-40 on a bench, 8.5 N rms", length=1.0,
            a=(947.9e-5, -3460.1e-5, 3033.5e-5, -6777.6e-5), b=(189.6, 10683.9, -117893.0, 552851.0, -924496.0),
        ),
        parameter_set(
            "DMSP-40-hildebrandt", "variant with the power 2/3, fitted to the maker's map of a DMSP-40, 49 N rms",
            a=(1.10283e-2, -3.53599e-2, -2.22996e-2), b=(202.298, -21098.34, 90378.51, -229170.2), root=9054.04,
        ),
    )  # fmt: skip

    @property
    def limits(self) -> tuple[float, float]:
        """Fitted on 0 to 0.25."""
        return -0.05, 0.35

    def _static(self, kappa: Any, pressure: Any, m: Arithmetic) -> Any:
        rubber = polynomial(self.b, kappa)
        if self.root:
            size = abs(kappa) ** (2.0 / 3.0)
            rubber = rubber + self.root * m.where(kappa < 0.0, -size, size)
        return pressure * polynomial(self.a, kappa) - rubber
