r"""Braid with a Mooney-Rivlin bladder and Hill's force-velocity law (Klute, Czerniecki, Hannaford 2002).

.. math::

    F_{static} = -p \frac{dV}{dl} + V_b \frac{dW}{dl}, \qquad W = C_{10} (I_1 - 3) + C_{01} (I_2 - 3)

    R = c\, v |v| + (1 + \alpha) F_{static}^+ \frac{v}{b + |v|}

The bladder is incompressible, relaxed at l_0, and follows the braid: stretches 1 - kappa along the axis and
sin(theta)/sin(theta_0) around it; V_b is its volume. A bare actuator hardly depends on speed; Klute and others added a
hydraulic damper in parallel, whose orifice gives c v^2, so that actuator and damper together follow a biological
muscle,

.. math:: (F + a)(v + b) = (F_0 + a)\, b, \qquad a = \alpha F_0, \quad v_{max} = b F_0/a,

which is the second term, as a law of its own: F = F_0 - (1 + alpha) F_0 v/(b + v). b = 0 leaves it out.

Structure: own knowledge, high confidence; C_10 = 118.4 kPa and C_01 = 105.7 kPa of latex medium; c low: calibrate.
Measured for shortening only; here the damper resists both ways, and so does Hill's term.

Cannot show
-----------
Hysteresis at low speed: both terms vanish there. A bladder that is slack before it touches the braid.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from dehyst.robot.muscles.base import Arithmetic
from dehyst.robot.muscles.braid import BraidedMuscle
from dehyst.robot.muscles.parameters import AT_HAND, angle_row, length_row, parameter, parameter_set

_PAPER = "Klute, Czerniecki, Hannaford 2002"
_LATEX = "Klute, Hannaford 2000; own knowledge, medium"
_WALL = "Klute, Hannaford 2000: 1/16 inch of latex; own knowledge, low"
_ORIFICE = f"{_PAPER}, structure; size low: calibrate"
_TRICEPS = f"{_PAPER}: actuator with a damper in parallel; dimensions and c are assumptions (low)"


@dataclass(frozen=True)
class Klute(BraidedMuscle):
    """Klute: braid, hyperelastic bladder, hydraulic damper, Hill's law.

    Examples
    --------
    >>> actuator = Klute.published("triceps")
    >>> float(actuator.static_force(0.1, 5e5)) > float(actuator.static_force(0.2, 5e5))
    True
    """

    name = "klute"
    length: float = length_row(0.2)
    diameter: float = parameter(0.02, "m", 2e-3, 0.2, AT_HAND, "D_0, diameter at rest")
    angle: float = angle_row(math.radians(20.0))
    wall: float = parameter(1.6e-3, "m", 0.0, 0.01, _WALL, "bladder")
    c10: float = parameter(118.4e3, "Pa", 0.0, 1e7, _LATEX, "C_10 of the bladder")
    c01: float = parameter(105.7e3, "Pa", 0.0, 1e7, _LATEX, "C_01 of the bladder")
    damper: float = parameter(2000.0, "N s^2/m^2", 0.0, 1e6, _ORIFICE, "c of the orifice")
    hill_ratio: float = parameter(0.25, "1", 0.05, 1.0, f"{_PAPER} and Hill 1938: 0.25, high", "alpha = a/F_0")
    hill_speed: float = parameter(0.0, "m/s", 0.0, 10.0, "assumption: v_max a/F_0 of the muscle", "b, 0 for none")

    PUBLISHED = (
        parameter_set("triceps", _TRICEPS),
        parameter_set("bare", f"{_PAPER}: actuator alone, independent of speed", damper=0.0),
        parameter_set("muscle", "Hill 1938: a/F_0 = 0.25; v_max = 1 m/s is an assumption", damper=0.0, hill_speed=0.25),
    )

    @property
    def affine_in_pressure(self) -> bool:  # type: ignore[override]
        """Whether Hill's term, which ends with the pull, is left out."""
        return self.hill_speed == 0.0

    @property
    def largest_speed(self) -> float:
        """v_max = b/alpha of Hill's law, at which it does not pull any more. [m/s]"""
        return self.hill_speed / self.hill_ratio

    def rubber(self, kappa: Any, m: Arithmetic) -> Any:
        """Return V_b dW/dl, the pull of the bladder. [N]"""
        along, start = 1.0 - kappa, math.sin(self.angle)
        around = m.sqrt(1.0 - (along * math.cos(self.angle)) ** 2) / start
        slope = -((math.cos(self.angle) / start) ** 2) * along / around  # of the stretch around over that along
        through = 1.0 / (along * around)
        change = -through * (1.0 / along + slope / around)
        first = 2.0 * (along + around * slope + through * change)
        second = -2.0 * (along**-3 + around**-3 * slope + through**-3 * change)
        return self.section * (self.c10 * first + self.c01 * second)

    @property
    def section(self) -> float:
        """V_b/l_0, cross-section of the bladder's wall. [m^2]"""
        return math.pi * self.wall * (self.diameter - self.wall)

    def _static(self, kappa: Any, pressure: Any, m: Arithmetic) -> Any:
        return pressure * self.braid.pull(kappa, self.wall, m) + self.rubber(kappa, m)

    def _resistance(self, kappa: Any, pressure: Any, speed: Any, slip: Any, m: Arithmetic) -> Any:
        resistance = self.damper * speed * abs(speed)
        if self.hill_speed:
            isometric = m.maximum(self._static(kappa, pressure, m), 0.0)
            resistance = resistance + (1.0 + self.hill_ratio) * isometric * speed / (self.hill_speed + abs(speed))
        return resistance


MUSCLE = Klute
