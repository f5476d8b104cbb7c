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
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from dehyst.robot.muscles.arithmetic import Arithmetic
from dehyst.robot.muscles.base import MuscleModel, parameter
from dehyst.robot.muscles.braid import conical_limit, conical_pull, contracting_angle

_PAPER = "Tondu, Lopez 2000"


@dataclass(frozen=True)
class TonduLopez(MuscleModel):
    """Tondu-Lopez: geometry with conical ends, strand friction in proportion to pressure.

    Examples
    --------
    >>> muscle = TonduLopez.published("rubber-rayon")
    >>> round(muscle.largest_contraction, 3)
    0.297
    >>> abs(float(muscle.static_force(muscle.largest_contraction, 3e5))) < 1e-9
    True
    """

    length: float = parameter(0.34, "m", 0.01, 10.0, "assumption: of the muscle at hand", "l_0, length at rest", False)
    radius: float = parameter(0.0095, "m", 1e-3, 0.1, f"{_PAPER}, own knowledge, medium", "r_0, radius at rest")
    angle: float = parameter(
        math.radians(20.0), "rad", 0.12, 0.94, f"{_PAPER}, own knowledge, medium", "alpha_0, fibre angle at rest"
    )
    shape: float = parameter(1.3, "1", 0.8, 2.0, f"{_PAPER}: 1.25 to 1.35", "k_e of the conical ends")
    shape_pressure: float = parameter(0.0, "1", 0.0, 2.0, f"{_PAPER}, refined k(p)", "k_p, falling with pressure")
    friction_static: float = parameter(0.015, "1", 0.0, 1.0, "LAAS code and own knowledge, low", "f_s")
    friction_kinetic: float = parameter(0.0075, "1", 0.0, 1.0, "LAAS code and own knowledge, low", "f_k")
    friction_speed: float = parameter(0.15, "m/s", 1e-3, 10.0, "LAAS code, low", "v_s")
    presliding: float = parameter(
        1e-4, "1", 1e-6, 0.05, "assumption, numerical", "strain over which friction builds up", False
    )

    name: ClassVar[str] = "tondu-lopez"
    dynamic: ClassVar[bool] = True
    SETS: ClassVar[Mapping[str, str]] = {
        "rubber-rayon": "Tondu, Lopez 2000: structure; numbers own knowledge, low confidence",
        "DMSP-40": "geometry of 40 mm and 25 degrees; k fitted to the maker's map from 0.5 to 6 bar, 250 N rms; "
        "friction set to 80 N at 3 bar (assumption), presliding to 0.4 mm: the muscle is known not to stick and slip",
    }
    _VALUES: ClassVar[Mapping[str, Mapping[str, Any]]] = {
        "rubber-rayon": {},
        "DMSP-40": {
            "length": 0.4,
            "radius": 0.02 * math.sqrt(1.006),
            "angle": math.radians(25.0),
            "shape": 1.533,
            "friction_static": 0.00425,
            "friction_kinetic": 0.0034,
            "presliding": 1e-3,
        },
    }

    def __post_init__(self) -> None:
        self._check("radius", "angle", "shape", "friction_speed", "presliding")
        contracting_angle(self.angle)
        self._not_negative("shape_pressure", "friction_static", "friction_kinetic")

    @property
    def affine_in_pressure(self) -> bool:  # type: ignore[override]
        """Whether k is constant."""
        return self.shape_pressure == 0.0

    @property
    def limits(self) -> tuple[float, float]:
        """Fibres along the axis, and at right angles to it."""
        return 1.0 - 1.0 / math.cos(self.angle), min(1.0, 1.0 / (self.shape + self.shape_pressure))

    @property
    def largest_contraction(self) -> float:
        """At which it stops to pull, for a high pressure."""
        return conical_limit(self.shape, self.angle)

    def _static(self, kappa: Any, pressure: Any, m: Arithmetic) -> Any:
        k = self.shape + (self.shape_pressure * m.exp(-pressure / 1e5) if self.shape_pressure else 0.0)
        return pressure * conical_pull(kappa, k, self.radius, self.angle)

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
