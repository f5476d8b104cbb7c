"""Static force maps fitted to measurements: the maker's sizing tool, Sarosi, Aschemann-Schindele."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from dehyst_robot.muscles._base import Arithmetic, MuscleModel, polynomial


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
    Hysteresis, speed, creep: it is a static map. A bench muscle differs from it by -14 % to +38 %
    up to a contraction of 16 %, and is five times as strong at 20 % (`sarosi`, 3 bar).

    Examples
    --------
    >>> Maker.published("DMSP-40").static_force([0.0, 0.1, 0.2], 3e5).round().tolist()
    [3096.0, 1469.0, 65.0]
    """

    name = "maker"
    length: float
    force: float
    length_rate: float
    end_length: float
    passive: float
    decay: float
    bell: float
    contraction: float
    reference_pressure: float

    @cached_property
    def largest_force(self) -> float:
        """F_m, at rest length and reference pressure. [N]"""
        # The ends of a short muscle do not pull; without a rate the force belongs to one length.
        if not self.length_rate:
            return self.force * 1.0
        return self.force * math.atan(self.length_rate * (self.length - self.end_length))

    @property
    def limits(self) -> tuple[float, float]:
        """Beyond these the exponential gives forces that no muscle has."""
        return -0.5 * self.contraction, 2.0 * self.contraction

    def _static(self, kappa: Any, pressure: Any, m: Arithmetic) -> Any:
        # m holds the functions of arrays or of floats: one formula for logs and for simulations.
        k = kappa / self.contraction
        pull = pressure / self.reference_pressure * m.exp(-self.bell * k * k)
        return self.largest_force * (self.passive * (m.exp(-self.decay * k) - 1.0) + pull)


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
    length: float
    a1: float
    a2: float
    a3: float
    a4: float
    a5: float
    a6: float

    @property
    def limits(self) -> tuple[float, float]:
        """Contractions that are accepted: the map was identified on 0 to 0.25, and it explodes below -0.05."""
        return -0.05, 0.4

    def _static(self, kappa: Any, pressure: Any, m: Arithmetic) -> Any:
        rubber = (self.a1 * pressure + self.a2) * m.exp(self.a3 * kappa)
        return rubber + (self.a4 * kappa + self.a5) * pressure + self.a6


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
    length: float
    a: tuple[float, ...]
    b: tuple[float, ...]
    root: float

    @property
    def limits(self) -> tuple[float, float]:
        """Fitted on 0 to 0.25."""
        return -0.05, 0.35

    def _static(self, kappa: Any, pressure: Any, m: Arithmetic) -> Any:
        rubber = polynomial(self.b, kappa)
        # Its slope at 0 is infinite, so that it is left out where it has no part.
        if self.root:
            size = abs(kappa) ** (2.0 / 3.0)
            rubber = rubber + self.root * m.where(kappa < 0.0, -size, size)
        return pressure * polynomial(self.a, kappa) - rubber
