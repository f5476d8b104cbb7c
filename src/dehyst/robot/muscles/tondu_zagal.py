r"""Friction that depends on the speed as in Hill's law (Tondu, Zagal 2006).

.. math:: F = F_{static} - \left[ B + \frac{a}{b + |v|} \right] v

with the static force of `dehyst.robot.muscles.tondu_lopez`. An iron braid was found viscous (B), a rayon braid to
follow a/(b + |v|): a damping a/b at first that saturates at the force a, a smooth Coulomb friction. For shortening that
is Hill's law, (F + a_H)(v + b) = (F_0 + a_H) b, with a = F_0 + a_H.

Source: Tondu, Zagal, BioRob 2006 (the law found in Kastner and others 2012, the identity computed); sizes low
confidence, a about 20 to 30 % of the force and b 0.1 to 0.3 m/s: calibrate.

Cannot show
-----------
Hysteresis: the friction vanishes with the speed and remembers nothing. Dependence of the friction on pressure.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from dehyst.robot.muscles.base import Arithmetic
from dehyst.robot.muscles.braid import ConicalMuscle
from dehyst.robot.muscles.parameters import angle_row, length_row, parameter, parameter_set

_PAPER = "Tondu, Zagal 2006"
_SIZE = f"{_PAPER}, size low: calibrate"
_LOPEZ = "as tondu-lopez"


@dataclass(frozen=True)
class TonduZagal(ConicalMuscle):
    """Tondu-Zagal: geometry and a friction of the speed.

    Examples
    --------
    >>> rayon = TonduZagal.published("rayon")
    >>> rayon.drag / rayon.drag_speed
    1500.0
    """

    name = "tondu-zagal"
    length: float = length_row(0.34)
    radius: float = parameter(0.0095, "m", 1e-3, 0.1, _LOPEZ, "r_0, radius at rest")
    angle: float = angle_row(math.radians(20.0), _LOPEZ)
    shape: float = parameter(1.3, "1", 0.8, 2.0, _LOPEZ, "k of the conical ends")
    drag: float = parameter(300.0, "N", 0.0, 1e4, _SIZE, "a, friction at high speed")
    drag_speed: float = parameter(0.2, "m/s", 1e-3, 10.0, _SIZE, "b")
    viscosity: float = parameter(0.0, "N s/m", 0.0, 1e4, _SIZE, "B")

    PUBLISHED = (
        parameter_set(
            "rayon", f"{_PAPER}: law of the rayon braid; a = 25 % of the force at 3 bar and b = 0.2 m/s, low"
        ),
        parameter_set(
            "iron", f"{_PAPER}: law of the iron braid; B = 50 N s/m is an assumption", drag=0.0, viscosity=50.0
        ),
        parameter_set(
            "DMSP-40", "geometry of tondu-lopez's set of that name; a = 40 N and b = 0.2 m/s are assumptions",
            length=0.4, radius=0.02 * math.sqrt(1.006), angle=math.radians(25.0), shape=1.533, drag=40.0,
        ),
    )  # fmt: skip

    def _static(self, kappa: Any, pressure: Any, m: Arithmetic) -> Any:
        return pressure * self.pull(kappa, pressure, m)

    def _resistance(self, kappa: Any, pressure: Any, speed: Any, slip: Any, m: Arithmetic) -> Any:
        return (self.viscosity + self.drag / (self.drag_speed + abs(speed))) * speed


MUSCLE = TonduZagal
