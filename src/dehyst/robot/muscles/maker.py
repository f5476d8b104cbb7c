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
(`dehyst.robot.muscles.sarosi`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from dehyst.robot.muscles.base import Arithmetic, MuscleModel
from dehyst.robot.muscles.parameters import length_row, parameter, parameter_set

_BOLEN = "maker's tool as fitted by Bolen, found"
_GROWS = f"{_BOLEN}; force grows with the length"


@dataclass(frozen=True)
class Maker(MuscleModel):
    """Map of the maker's tool.

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


MUSCLE = Maker
