r"""Cylinder with conical ends and friction at the contact of its strands (Tondu, Lopez 2000).

.. math::

    F_{static} = \pi r_0^2 p \, [a (1 - k \kappa)^2 - b], \qquad a = 3/\tan^2\alpha_0, \quad b = 1/\sin^2\alpha_0

    R = f(v) S_c(\kappa) \, p \, s, \qquad f(v) = f_k + (f_s - f_k) e^{-|v|/v_s}

    S_c = \frac{2 \pi r_0 l_0}{\sin\alpha_0} (1 - \kappa) \sqrt{1 - \cos^2\alpha_0 (1 - \kappa)^2}

k > 1 accounts for the ends, which do not stay cylindrical, and may depend on the pressure,
:math:`k = k_e + k_p e^{-p/10^5 Pa}`. The muscle pulls up to the contraction :math:`(1 - \sqrt{b/a})/k`. The friction
has the sign of the motion: s goes from -1 to 1 within twice the presliding strain after a reversal.

Source of the structure: Tondu, Lopez, IEEE Control Systems Magazine 20(2), 2000. The coefficients of friction and the
normalisation of the contact area differ between reprints (low confidence): calibrate f_s and f_k.

Cannot show
-----------
Loops inside loops (the friction remembers nothing but the direction), creep, a rubber that pulls back without pressure.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from dehyst.robot.muscles.base import Arithmetic
from dehyst.robot.muscles.braid import ConicalMuscle
from dehyst.robot.muscles.parameters import angle_row, length_row, parameter, parameter_set, presliding_row

_PAPER = "Tondu, Lopez 2000"
_MEDIUM = f"{_PAPER}, own knowledge, medium"
_LOW = "LAAS code and own knowledge, low"


@dataclass(frozen=True)
class TonduLopez(ConicalMuscle):
    """Tondu-Lopez: geometry with conical ends, strand friction in proportion to pressure.

    Examples
    --------
    >>> muscle = TonduLopez.published("rubber-rayon")
    >>> round(muscle.largest_contraction, 3)
    0.297
    >>> abs(float(muscle.static_force(muscle.largest_contraction, 3e5))) < 1e-9
    True
    """

    name = "tondu-lopez"
    length: float = length_row(0.34, low=0.01)
    radius: float = parameter(0.0095, "m", 1e-3, 0.1, _MEDIUM, "r_0, radius at rest")
    angle: float = angle_row(math.radians(20.0), _MEDIUM, "alpha_0")
    shape: float = parameter(1.3, "1", 0.8, 2.0, f"{_PAPER}: 1.25 to 1.35", "k_e of the conical ends")
    shape_pressure: float = parameter(0.0, "1", 0.0, 2.0, f"{_PAPER}, refined k(p)", "k_p, falling with pressure")
    friction_static: float = parameter(0.015, "1", 0.0, 1.0, _LOW, "f_s")
    friction_kinetic: float = parameter(0.0075, "1", 0.0, 1.0, _LOW, "f_k")
    friction_speed: float = parameter(0.15, "m/s", 1e-3, 10.0, "LAAS code, low", "v_s")
    presliding: float = presliding_row()

    PUBLISHED = (
        parameter_set("rubber-rayon", f"{_PAPER}: structure; numbers own knowledge, low confidence"),
        parameter_set(
            "DMSP-40", "geometry of 40 mm and 25 degrees; k fitted to the maker's map from 0.5 to 6 bar, 250 N rms; "
            "friction set to 80 N at 3 bar (assumption), presliding to 0.4 mm: the muscle is known not to stick and "
            "slip", length=0.4, radius=0.02 * math.sqrt(1.006), angle=math.radians(25.0), shape=1.533,
            friction_static=0.00425, friction_kinetic=0.0034, presliding=1e-3,
        ),
    )  # fmt: skip

    @property
    def limits(self) -> tuple[float, float]:
        """Fibres along the axis, and at right angles to it."""
        return super().limits[0], min(1.0, 1.0 / (self.shape + self.shape_pressure))

    def _static(self, kappa: Any, pressure: Any, m: Arithmetic) -> Any:
        return pressure * self.pull(kappa, pressure, m)

    def _resistance(self, kappa: Any, pressure: Any, speed: Any, slip: Any, m: Arithmetic) -> Any:
        f = self.friction_kinetic + (self.friction_static - self.friction_kinetic) * m.exp(
            -abs(speed) / self.friction_speed
        )
        return f * self.contact_area(kappa, m) * m.maximum(pressure, 0.0) * slip

    def contact_area(self, kappa: Any, m: Arithmetic) -> Any:
        """S_c, surface of the contact at a contraction. [m^2]"""
        rest = 2.0 * math.pi * self.radius * self.length / math.sin(self.angle)
        inside = 1.0 - (math.cos(self.angle) * (1.0 - kappa)) ** 2
        return rest * (1.0 - kappa) * m.sqrt(m.maximum(inside, 0.0))


MUSCLE = TonduLopez
