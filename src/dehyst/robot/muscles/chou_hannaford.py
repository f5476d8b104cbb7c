r"""Inextensible braid by virtual work, and Coulomb friction (Chou, Hannaford 1994, 1996).

.. math::

    F_{static} = -p \frac{dV}{dl} = \frac{\pi D_{90}^2 p}{4} (3 \cos^2\theta - 1)
        + \pi p \left[ D_{90}\, t \left( 2 \sin\theta - \frac{1}{\sin\theta} \right) - t^2 \right],
    \qquad \cos\theta = (1 - \kappa) \cos\theta_0

.. math:: R = F_c \, s

D_90 = D_0/sin(theta_0) is the diameter with fibres at right angles to the axis, t the thickness of the wall. Without
wall the force is zero at 54.7 degrees, arccos(1/sqrt 3), whatever the pressure.

Source: Chou, Hannaford, IEEE Transactions on Robotics and Automation 12(1), 1996 (own knowledge, high confidence). They
measured hysteresis that is Coulomb friction, hardly dependent on rate, and gave no model: a constant band F_c of 2 to
5 N for braided muscles of 15 mm (low confidence: calibrate).

Cannot show
-----------
Rubber that resists contraction: a geometric muscle is some 4 % of the largest force off. Friction that grows with
pressure; loops inside loops.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from dehyst.robot.muscles.base import Arithmetic
from dehyst.robot.muscles.braid import NEUTRAL, BraidedMuscle
from dehyst.robot.muscles.parameters import AT_HAND, angle_row, length_row, parameter, parameter_set, presliding_row

_PAPER = "Chou, Hannaford 1996"


@dataclass(frozen=True)
class ChouHannaford(BraidedMuscle):
    """Chou-Hannaford: geometry and a Coulomb band.

    Examples
    --------
    >>> braid = ChouHannaford.published("braid-15")
    >>> neutral = 1 - math.cos(NEUTRAL) / math.cos(braid.angle)
    >>> abs(float(braid.static_force(neutral, 4e5))) < 1e-9
    True
    """

    name = "chou-hannaford"
    length: float = length_row(0.2)
    diameter: float = parameter(0.015, "m", 2e-3, 0.2, AT_HAND, "D_0, diameter at rest")
    angle: float = angle_row(math.radians(23.0))
    wall: float = parameter(0.0, "m", 0.0, 0.01, f"{_PAPER}: option", "t, thickness of the wall")
    band: float = parameter(3.0, "N", 0.0, 1e3, f"{_PAPER}, 2 to 5 N; own knowledge, low", "F_c, Coulomb friction")
    presliding: float = presliding_row()

    PUBLISHED = (
        parameter_set(
            "braid-15", "braided muscle of 15 mm: dimensions are assumptions, band 2 to 5 N (own knowledge, low)"
        ),
        parameter_set(
            "DMSP-40", "fibre geometry of a DMSP-40, 28.6 degrees and 40 mm (Martens, Boblan 2017, found); band 80 N "
            "(assumption)", length=0.4, diameter=0.04, angle=math.radians(28.6), band=80.0,
        ),
    )  # fmt: skip

    @property
    def largest_contraction(self) -> float:
        """At 54.7 degrees, where a muscle without wall stops to pull."""
        return 1.0 - math.cos(NEUTRAL) / math.cos(self.angle)

    def _static(self, kappa: Any, pressure: Any, m: Arithmetic) -> Any:
        return pressure * self.braid.pull(kappa, self.wall, m)

    def _resistance(self, kappa: Any, pressure: Any, speed: Any, slip: Any, m: Arithmetic) -> Any:
        return self.band * slip


MUSCLE = ChouHannaford
