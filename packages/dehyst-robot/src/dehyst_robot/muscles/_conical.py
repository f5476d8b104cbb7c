"""Muscles of a cylinder with conical ends: Tondu-Lopez, Tondu-Zagal, Kerscher."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from dehyst_robot.muscles._base import Arithmetic
from dehyst_robot.muscles._braided import FibreMuscle


class ConicalMuscle(FibreMuscle):
    """A cylinder with conical ends: pi r_0^2 [a (1 - k kappa)^2 - b] for 1 Pa, k = k_0 + k_p exp(-p/1 bar)."""

    radius: float
    shape: float  # k_0
    shape_pressure: float = 0.0  # k_p

    @property
    def affine_in_pressure(self) -> bool:  # type: ignore[override]
        """Whether k is constant."""
        return self.shape_pressure == 0.0

    @property
    def limits(self) -> tuple[float, float]:
        """Fibres along the axis; and 1/k, beyond which the square rises again."""
        return 1.0 - 1.0 / math.cos(self.angle), min(0.9, 1.0 / (self.shape + self.shape_pressure))

    @property
    def largest_contraction(self) -> float:
        """(1 - sqrt(b/a))/k, at which it stops to pull, for a high pressure."""
        return (1.0 - 1.0 / (math.sqrt(3.0) * math.cos(self.angle))) / self.shape

    def pull(self, kappa: Any, pressure: Any, m: Arithmetic) -> Any:
        """Return the force for 1 Pa at a contraction; the pressure is the one that bends the ends. [m^2]"""
        k = self.shape
        if self.shape_pressure:
            k = k + self.shape_pressure * m.exp(-pressure / 1e5)
        a = 3.0 / math.tan(self.angle) ** 2
        b = 1.0 / math.sin(self.angle) ** 2
        return math.pi * self.radius**2 * (a * (1.0 - k * kappa) ** 2 - b)


@dataclass(frozen=True)
class TonduLopez(ConicalMuscle):
    r"""Cylinder with conical ends and friction at the contact of its strands (Tondu, Lopez 2000).

    .. math::

        F_{static} = \pi r_0^2 p \, [a (1 - k \kappa)^2 - b], \qquad a = 3/\tan^2\alpha_0, \quad b = 1/\sin^2\alpha_0

        R = f(v) S_c(\kappa) \, p \, s, \qquad f(v) = f_k + (f_s - f_k) e^{-|v|/v_s}

        S_c = \frac{2 \pi r_0 l_0}{\sin\alpha_0} (1 - \kappa) \sqrt{1 - \cos^2\alpha_0 (1 - \kappa)^2}

    k > 1 accounts for the ends, which do not stay cylindrical, and may depend on the pressure,
    :math:`k = k_e + k_p e^{-p/10^5 Pa}`. The muscle pulls up to the contraction :math:`(1 - \sqrt{b/a})/k`. The
    friction has the sign of the motion: s goes from -1 to 1 within twice the presliding strain after a reversal.

    Source of the structure: Tondu, Lopez, IEEE Control Systems Magazine 20(2), 2000. The coefficients of friction and
    the normalisation of the contact area differ between reprints (low confidence): calibrate f_s and f_k.

    Cannot show
    -----------
    Loops inside loops (the friction remembers nothing but the direction), creep, a rubber that pulls back without
    pressure.

    Examples
    --------
    >>> muscle = TonduLopez.published("rubber-rayon")
    >>> round(muscle.largest_contraction, 3)
    0.297
    >>> abs(float(muscle.static_force(muscle.largest_contraction, 3e5))) < 1e-9
    True
    """

    name = "tondu-lopez"
    length: float
    radius: float
    angle: float
    shape: float
    shape_pressure: float
    friction_static: float
    friction_kinetic: float
    friction_speed: float
    presliding: float

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
        area = 2.0 * math.pi * self.radius * self.length / math.sin(self.angle)
        # Rounding may make the root's argument negative where the fibres lie along the axis.
        inside = 1.0 - (math.cos(self.angle) * (1.0 - kappa)) ** 2
        return area * (1.0 - kappa) * m.sqrt(m.maximum(inside, 0.0))


@dataclass(frozen=True)
class TonduZagal(ConicalMuscle):
    r"""Friction that depends on the speed as in Hill's law (Tondu, Zagal 2006).

    .. math:: F = F_{static} - \left[ B + \frac{a}{b + |v|} \right] v

    with the static force of `tondu-lopez`. An iron braid was found viscous (B), a rayon braid to follow a/(b + |v|): a
    damping a/b at first that saturates at the force a, a smooth Coulomb friction. For shortening that is Hill's law,
    (F + a_H)(v + b) = (F_0 + a_H) b, with a = F_0 + a_H.

    Source: Tondu, Zagal, BioRob 2006 (the law found in Kastner and others 2012, the identity computed); sizes low
    confidence, a about 20 to 30 % of the force and b 0.1 to 0.3 m/s: calibrate.

    Cannot show
    -----------
    Hysteresis: the friction vanishes with the speed and remembers nothing. Dependence of the friction on pressure.

    Examples
    --------
    >>> rayon = TonduZagal.published("rayon")
    >>> rayon.drag / rayon.drag_speed
    1500.0
    """

    name = "tondu-zagal"
    length: float
    radius: float
    angle: float
    shape: float
    drag: float
    drag_speed: float
    viscosity: float

    def _static(self, kappa: Any, pressure: Any, m: Arithmetic) -> Any:
        return pressure * self.pull(kappa, pressure, m)

    def _resistance(self, kappa: Any, pressure: Any, speed: Any, slip: Any, m: Arithmetic) -> Any:
        return (self.viscosity + self.drag / (self.drag_speed + abs(speed))) * speed


_RATE = 40.0  # of the factor over the contraction, from the publication


@dataclass(frozen=True)
class Kerscher(ConicalMuscle):
    r"""Quick-release model with factors that depend on pressure and contraction (Kerscher and others 2005, 2006).

    .. math::

        F_{static} = \mu(\kappa)\, \pi r_0^2 p \, [a (1 - \varepsilon(p) \kappa)^2 - b], \qquad
        \varepsilon = \varepsilon_0 + \varepsilon_1 e^{-p/1\,bar}, \quad \mu = \mu_0 + \mu_1 e^{-40 \kappa}

    .. math:: R = (d_0 + d_1 p)\, v

    with a and b of `tondu-lopez`. After a quick release the force drops by the damper's share at once,
    in proportion to the speed and affine in the pressure; measured up to 0.9 m/s.

    Source: Kerscher, Albiez, Zoellner, Dillmann, CLAWAR 2005 and BioRob 2006 (structure: own knowledge, medium). The
    coefficients of the factors were fitted here to the map that Martens and Boblan measured on a DMSP-20 (79 N rms, 5 %
    of its largest force: there is no term for rubber); d_0 and d_1 low confidence: calibrate.

    Cannot show
    -----------
    Hysteresis at low speed; forces of the rubber without pressure.

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
    length: float
    radius: float
    angle: float
    shape: float
    shape_pressure: float
    factor: float
    factor_long: float
    damping: float
    damping_pressure: float

    def _static(self, kappa: Any, pressure: Any, m: Arithmetic) -> Any:
        factor = self.factor + self.factor_long * m.exp(-_RATE * kappa)
        return factor * pressure * self.pull(kappa, pressure, m)

    def _resistance(self, kappa: Any, pressure: Any, speed: Any, slip: Any, m: Arithmetic) -> Any:
        return (self.damping + self.damping_pressure * m.maximum(pressure, 0.0)) * speed
