r"""Braid of strands with thickness, which limits motion and causes friction (Davis, Caldwell 2006).

.. math::

    F_{static} = \frac{\pi D_{90}^2 p}{4} (3 \cos^2\theta - 1), \qquad \cos\theta = (1 - \kappa) \cos\theta_0

    R = \mu\, p\, A(\theta) \left( \frac{p}{p_r} \right)^e s, \qquad A = 2 n N^2 \frac{(w d)^2}{\sin 2\theta}

N strands of thickness d wind each way; each crosses those of the other way 2 n times, and two contacts of width w d
that cross at 2 theta share a rhombus. Strands touch, and the braid locks, at

.. math:: \sin 2\theta_{min} = \frac{2 N d}{\pi D_{90}},

the longest muscle; the shortest is at 90 degrees less theta_min. The exponent e is 0 for a constant width and up to
2/3 where contacts widen as those of Hertz.

Source: Davis, Caldwell, IEEE Transactions on Robotics 22(6), 2006: friction as area of contact times pressure, and
packing (own knowledge, low to medium). Locking angle and area are derived here from the geometry of flat crossings;
mu 0.1 to 0.2 for nylon and the width w are low confidence: calibrate mu.

Cannot show
-----------
Rubber; loops inside loops, which need more than one slip strain; dependence on speed.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from dehyst.errors import ParameterError
from dehyst.robot.muscles.base import Arithmetic
from dehyst.robot.muscles.braid import BraidedMuscle
from dehyst.robot.muscles.parameters import AT_HAND, angle_row, length_row, parameter, parameter_set, presliding_row

_PAPER = "Davis, Caldwell 2006"
_CONTACT = "assumption: friction of 17 N at 3 bar"


@dataclass(frozen=True)
class DavisCaldwell(BraidedMuscle):
    """Davis-Caldwell: strands that lock and rub.

    Raises
    ------
    ParameterError
        If a value has no physical meaning, or the strands do not fit next to each other at rest.

    Examples
    --------
    >>> braid = DavisCaldwell.published("nylon")
    >>> round(math.degrees(braid.locking_angle), 1)
    7.0
    """

    name = "davis-caldwell"
    length: float = length_row(0.3)
    diameter: float = parameter(0.02, "m", 2e-3, 0.2, AT_HAND, "D_0, diameter at rest")
    angle: float = angle_row(math.radians(25.0))
    strands: float = parameter(60.0, "1", 2.0, 1000.0, AT_HAND, "N, each way", False)
    strand: float = parameter(3e-4, "m", 1e-5, 5e-3, AT_HAND, "d, thickness", False)
    friction: float = parameter(0.15, "1", 0.0, 2.0, f"{_PAPER}: 0.1 to 0.2 for nylon, low", "mu")
    contact: float = parameter(0.5, "1", 0.01, 1.0, _CONTACT, "w, width of contact", False)
    exponent: float = parameter(0.0, "1", 0.0, 2 / 3, "0: constant width; 2/3: Hertz", "e, of the pressure")
    reference_pressure: float = parameter(3e5, "Pa", 1e4, 1e6, "assumption", "p_r", False)
    presliding: float = presliding_row()

    PUBLISHED = (
        parameter_set("nylon", f"{_PAPER}: structure; dimensions are assumptions, friction 17 N at 3 bar"),
        parameter_set(
            "hertz", f"{_PAPER}: structure; as nylon, contacts that widen with the power 2/3 of the pressure",
            exponent=2 / 3,
        ),
        parameter_set(
            "DMSP-40", f"{_PAPER}: structure; fibre geometry of a DMSP-40 (Martens, Boblan 2017, found); strands are "
            "assumptions, friction 80 N at 3 bar", length=0.4, diameter=0.04, angle=math.radians(28.6), strands=100.0,
            strand=4.5e-4, presliding=1e-3,
        ),
    )  # fmt: skip

    def __post_init__(self) -> None:
        super().__post_init__()
        if self._packing >= 1 or not self.locking_angle < self.angle < math.pi / 2 - self.locking_angle:
            raise ParameterError(
                f"{self.strands:g} strands of {self.strand:g} m each way do not fit around {self.diameter:g} m at "
                f"{math.degrees(self.angle):g} degrees: they would overlap. Pass fewer or thinner ones.",
                packing=self._packing,
            )

    @property
    def affine_in_pressure(self) -> bool:  # type: ignore[override]
        """Whether friction is in proportion to pressure."""
        return self.exponent == 0.0

    @property
    def _packing(self) -> float:
        return 2.0 * self.strands * self.strand / (math.pi * self.braid.widest)

    @property
    def locking_angle(self) -> float:
        """theta_min, at which neighbouring strands touch. [rad]"""
        return 0.5 * math.asin(self._packing)

    @property
    def limits(self) -> tuple[float, float]:
        """Contractions at which the braid locks."""
        rest, least = math.cos(self.angle), self.locking_angle
        return 1.0 - math.cos(least) / rest, 1.0 - math.sin(least) / rest

    def contact_area(self, kappa: Any, m: Arithmetic) -> Any:
        """Return A, of all contacts together. [m^2]"""
        cosine = (1.0 - kappa) * math.cos(self.angle)
        crossing = (self.contact * self.strand) ** 2 / (2.0 * cosine * m.sqrt(1.0 - cosine * cosine))
        return 2.0 * self.braid.turns * self.strands**2 * crossing

    def _static(self, kappa: Any, pressure: Any, m: Arithmetic) -> Any:
        return pressure * self.braid.pull(kappa, 0.0, m)

    def _resistance(self, kappa: Any, pressure: Any, speed: Any, slip: Any, m: Arithmetic) -> Any:
        load = m.maximum(pressure, 0.0)
        if self.exponent:
            load = load * (load / self.reference_pressure) ** self.exponent
        return self.friction * load * self.contact_area(kappa, m) * slip


MUSCLE = DavisCaldwell
