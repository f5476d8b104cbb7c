r"""Braid with a wall of rubber, from dimensions and one modulus (Boblan 2009; Martens, Boblan 2017).

.. math::

    F = -p \frac{dV}{dL} + \sigma_D H_0 L \pi \frac{dD}{dL} - \sigma_L H_0 \pi D, \qquad
    \sigma_L = E \frac{L - L_0}{L_0}, \quad \sigma_D = E \frac{D - D_0}{D_0}

    V = \frac{L (L_f^2 - L^2)}{4 \pi n^2}, \quad D = \frac{\sqrt{L_f^2 - L^2}}{n \pi}, \quad
    L_f = \frac{L_0}{\cos\theta_0}, \quad n = \frac{L_0 \tan\theta_0}{\pi D_0}, \quad E(L) = \sum_{i=0}^3 c_i L^i

L = l_0 (1 - kappa) in metres: the modulus E(L) belongs to muscles of one length. The sign of the last term is the one
that was found and that reproduces the measured map: 16 N rms where a DMSP-20 of 300 mm pulls, 1.1 % of its largest
force.

Source: Martens, Boblan, Actuators 6(4), 2017, as found in ModelComparison2.m: structure and coefficients found; the
angle is 28.6 degrees and an offset of -0.073 and -0.1 rad. Lightly damped and without hysteresis: Boblan neglected the
latter for lack of data.

Cannot show
-----------
Hysteresis, speed, creep: it is a static map. Muscles of another length or diameter without another E(L).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from dehyst.robot.muscles.base import Arithmetic
from dehyst.robot.muscles.braid import BraidedMuscle
from dehyst.robot.muscles.parameters import angle_row, length_row, parameter, parameter_set

_PAPER = "Martens, Boblan 2017, found"


@dataclass(frozen=True)
class BoblanMartens(BraidedMuscle):
    """Boblan-Martens: geometry and a wall of rubber.

    Examples
    --------
    Measured at 600 kPa and 296, 282 and 267 mm: 1460, 1004 and 715 N.

    >>> muscle = BoblanMartens.published("DMSP-20-300")
    >>> [round(float(muscle.static_force(1 - l / 0.3, 6e5))) for l in (0.296, 0.282, 0.267)]
    [1445, 1022, 733]
    """

    name = "boblan-martens"
    length: float = length_row(0.3, _PAPER, "L_0")
    diameter: float = parameter(0.02, "m", 2e-3, 0.2, _PAPER, "D_0, diameter at rest", False)
    angle: float = angle_row(math.radians(28.6) - 0.073, _PAPER)
    wall: float = parameter(1.8e-3, "m", 1e-4, 0.01, _PAPER, "H_0, thickness of the wall", False)
    c0: float = parameter(93.232e6, "Pa", -1e10, 1e10, _PAPER, "modulus, constant")
    c1: float = parameter(-715.29e6, "Pa/m", -1e11, 1e11, _PAPER, "modulus, linear")
    c2: float = parameter(1.5483e9, "Pa/m^2", -1e12, 1e12, _PAPER, "modulus, square")
    c3: float = parameter(-502.95e6, "Pa/m^3", -1e13, 1e13, _PAPER, "modulus, cube")

    PUBLISHED = (
        parameter_set("DMSP-20-300", f"{_PAPER}: 20 mm, 300 mm"),
        parameter_set(
            "DMSP-10-250", f"{_PAPER}: 10 mm, 250 mm", length=0.25, diameter=0.01, angle=math.radians(28.6) - 0.1,
            c0=74.085e6, c1=-689.20e6, c2=1.837e9, c3=-848.79e6,
        ),
    )  # fmt: skip

    @property
    def limits(self) -> tuple[float, float]:
        """Somewhat beyond the measured 0.013 to 0.26: the cubic modulus means nothing further out."""
        return -0.05, 0.35

    def modulus(self, kappa: Any) -> Any:
        """Return E of the wall at a contraction. [Pa]"""
        long = self.length * (1.0 - kappa)
        return self.c0 + long * (self.c1 + long * (self.c2 + long * self.c3))

    def _static(self, kappa: Any, pressure: Any, m: Arithmetic) -> Any:
        braid, modulus = self.braid, self.modulus(kappa)
        long = self.length * (1.0 - kappa)
        across = m.sqrt(braid.fibre**2 - long * long)
        wide = across / (braid.turns * math.pi)
        slope = -long / across / (braid.turns * math.pi)
        around = modulus * (wide - self.diameter) / self.diameter * self.wall * long * math.pi * slope
        along = modulus * -kappa * self.wall * math.pi * wide
        return pressure * braid.pull(kappa, 0.0, m) + around - along


MUSCLE = BoblanMartens
