r"""Quick-release model with factors that depend on pressure and contraction (Kerscher and others 2005, 2006).

.. math::

    F_{static} = \mu(\kappa)\, \pi r_0^2 p \, [a (1 - \varepsilon(p) \kappa)^2 - b], \qquad
    \varepsilon = \varepsilon_0 + \varepsilon_1 e^{-p/1\,bar}, \quad \mu = \mu_0 + \mu_1 e^{-40 \kappa}

.. math:: R = (d_0 + d_1 p)\, v

with a and b of `dehyst.robot.muscles.tondu_lopez`. After a quick release the force drops by the damper's share at once,
in proportion to the speed and affine in the pressure; measured up to 0.9 m/s.

Source: Kerscher, Albiez, Zoellner, Dillmann, CLAWAR 2005 and BioRob 2006 (structure: own knowledge, medium). The
coefficients of the factors were fitted here to the map that Martens and Boblan measured on a DMSP-20 (79 N rms, 5 % of
its largest force: there is no term for rubber); d_0 and d_1 low confidence: calibrate.

Cannot show
-----------
Hysteresis at low speed; forces of the rubber without pressure.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from dehyst.robot.muscles.base import Arithmetic
from dehyst.robot.muscles.braid import ConicalMuscle
from dehyst.robot.muscles.parameters import angle_row, length_row, parameter, parameter_set

_PAPER = "Kerscher and others 2006"
_FIT = "fitted to the map of Martens, Boblan 2017"
_SIZE = f"{_PAPER}, size low: calibrate"
_RATE = 40.0


@dataclass(frozen=True)
class Kerscher(ConicalMuscle):
    """Kerscher: corrected geometry and a damper.

    Examples
    --------
    A release at 0.5 m/s and 3 bar takes 200 N at once:

    >>> muscle = Kerscher.published("DMSP-20")
    >>> _, still = muscle.run([0.1], 3e5, [0.0])
    >>> force = muscle.simulate([0.1, 0.1 + 0.5 * 0.001 / muscle.length], 3e5, [0.0, 0.001])
    >>> round(float(muscle.static_force(0.1 + 0.5 * 0.001 / muscle.length, 3e5) - force[1]))
    200
    """

    name = "kerscher"
    length: float = length_row(0.3, "DMSP-20-300")
    radius: float = parameter(0.01, "m", 1e-3, 0.1, "DMSP-20", "r_0, radius at rest", False)
    angle: float = angle_row(math.radians(28.6), "Martens, Boblan 2017", fitted=False)
    shape: float = parameter(1.3209, "1", 0.5, 3.0, _FIT, "epsilon_0")
    shape_pressure: float = parameter(2.0, "1", 0.0, 4.0, f"{_FIT}, bounded", "epsilon_1, without pressure")
    factor: float = parameter(1.14795, "1", 0.1, 3.0, _FIT, "mu_0")
    factor_long: float = parameter(0.44420, "1", -1.0, 3.0, _FIT, "mu_1, at rest length")
    damping: float = parameter(100.0, "N s/m", 0.0, 1e4, _SIZE, "d_0")
    damping_pressure: float = parameter(100e-5, "N s/(m Pa)", 0.0, 0.1, _SIZE, "d_1")

    PUBLISHED = (
        parameter_set("DMSP-20", f"{_PAPER}: structure; factors {_FIT}, 79 N rms; damper 400 N s/m at 3 bar, low"),
        parameter_set(
            "DMSP-40", f"{_PAPER}: structure; factors fitted to the maker's map of a DMSP-40 where it pulls, 180 N "
            "rms; damper 600 N s/m at 3 bar, low", length=0.4, radius=0.02, shape=1.44277, factor=1.48271,
            factor_long=-0.09027, damping=150.0, damping_pressure=150e-5,
        ),
    )  # fmt: skip

    def _static(self, kappa: Any, pressure: Any, m: Arithmetic) -> Any:
        factor = self.factor + self.factor_long * m.exp(-_RATE * kappa)
        return factor * pressure * self.pull(kappa, pressure, m)

    def _resistance(self, kappa: Any, pressure: Any, speed: Any, slip: Any, m: Arithmetic) -> Any:
        return (self.damping + self.damping_pressure * m.maximum(pressure, 0.0)) * speed


MUSCLE = Kerscher
