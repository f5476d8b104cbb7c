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
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from dehyst.robot.muscles.arithmetic import Arithmetic
from dehyst.robot.muscles.base import MuscleModel, parameter
from dehyst.robot.muscles.braid import conical_limit, conical_pull, contracting_angle

_PAPER = "Tondu, Zagal 2006"


@dataclass(frozen=True)
class TonduZagal(MuscleModel):
    """Tondu-Zagal: geometry and a friction of the speed.

    Examples
    --------
    >>> rayon = TonduZagal.published("rayon")
    >>> rayon.drag / rayon.drag_speed
    1500.0
    """

    length: float = parameter(0.34, "m", 0.02, 10.0, "assumption: of the muscle at hand", "l_0, length at rest", False)
    radius: float = parameter(0.0095, "m", 1e-3, 0.1, "as tondu-lopez", "r_0, radius at rest")
    angle: float = parameter(math.radians(20.0), "rad", 0.12, 0.94, "as tondu-lopez", "theta_0, fibre angle at rest")
    shape: float = parameter(1.3, "1", 0.8, 2.0, "as tondu-lopez", "k of the conical ends")
    drag: float = parameter(300.0, "N", 0.0, 1e4, f"{_PAPER}, size low: calibrate", "a, friction at high speed")
    drag_speed: float = parameter(0.2, "m/s", 1e-3, 10.0, f"{_PAPER}, size low: calibrate", "b")
    viscosity: float = parameter(0.0, "N s/m", 0.0, 1e4, f"{_PAPER}, size low: calibrate", "B")

    name: ClassVar[str] = "tondu-zagal"
    dynamic: ClassVar[bool] = True
    SETS: ClassVar[Mapping[str, str]] = {
        "rayon": f"{_PAPER}: law of the rayon braid; a = 25 % of the force at 3 bar and b = 0.2 m/s, low",
        "iron": f"{_PAPER}: law of the iron braid; B = 50 N s/m is an assumption",
        "DMSP-40": "geometry of tondu-lopez's set of that name; a = 40 N and b = 0.2 m/s are assumptions",
    }
    _VALUES: ClassVar[Mapping[str, Mapping[str, Any]]] = {
        "rayon": {},
        "iron": {"drag": 0.0, "viscosity": 50.0},
        "DMSP-40": {
            "length": 0.4,
            "radius": 0.02 * math.sqrt(1.006),
            "angle": math.radians(25.0),
            "shape": 1.533,
            "drag": 40.0,
        },
    }

    def __post_init__(self) -> None:
        self._check("radius", "angle", "shape", "drag_speed")
        contracting_angle(self.angle)
        self._not_negative("drag", "viscosity")

    @property
    def limits(self) -> tuple[float, float]:
        """Fibres along the axis; and 1/k, beyond which the square rises again."""
        return 1.0 - 1.0 / math.cos(self.angle), min(0.9, 1.0 / self.shape)

    @property
    def largest_contraction(self) -> float:
        """At which it stops to pull."""
        return conical_limit(self.shape, self.angle)

    def _static(self, kappa: Any, pressure: Any, m: Arithmetic) -> Any:
        return pressure * conical_pull(kappa, self.shape, self.radius, self.angle)

    def _resistance(self, kappa: Any, pressure: Any, speed: Any, slip: Any, m: Arithmetic) -> Any:
        return (self.viscosity + self.drag / (self.drag_speed + abs(speed))) * speed


MUSCLE = TonduZagal
