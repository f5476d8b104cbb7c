"""Muscles of fibres wound around a cylinder, by virtual work: Chou-Hannaford, Boblan-Martens, Davis-Caldwell, Klute."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from dehyst.errors import ParameterError
from dehyst_robot.muscles._base import Arithmetic, MuscleModel

NEUTRAL = math.acos(1 / math.sqrt(3))  # 54.7 degrees, where pressure neither pulls nor pushes
_STEEP = math.radians(80.0)
_FLAT = math.asin(0.1)  # 5.7 degrees


@dataclass(frozen=True)
class Braid:
    """Inextensible fibres on a cylinder without ends.

    Attributes
    ----------
    length, diameter
        At rest. [m]
    angle
        Between fibres and axis at rest. [rad]

    Examples
    --------
    >>> braid = Braid(0.4, 0.04, math.radians(28.6))
    >>> round(1e3 * braid.volume(0.0), 3), round(math.degrees(NEUTRAL), 1)
    (0.503, 54.7)
    """

    length: float
    diameter: float
    angle: float

    @property
    def fibre(self) -> float:
        """b, length of a fibre. [m]"""
        return self.length / math.cos(self.angle)

    @property
    def turns(self) -> float:
        """n, of a fibre around the axis."""
        return self.length * math.tan(self.angle) / (math.pi * self.diameter)

    @property
    def widest(self) -> float:
        """D_90, diameter with the fibres at right angles to the axis. [m]"""
        return self.diameter / math.sin(self.angle)

    def volume(self, kappa: Any) -> Any:
        """Return the volume inside the braid. [m^3]"""
        cosine = (1.0 - kappa) * math.cos(self.angle)
        return 0.25 * math.pi * self.length * (1.0 - kappa) * self.widest**2 * (1.0 - cosine**2)

    def pull(self, kappa: Any, wall: float, m: Arithmetic) -> Any:
        """Return -dV/dl of the volume inside a wall of a thickness, the force for a pressure of 1 Pa. [m^2]"""
        square = ((1.0 - kappa) * math.cos(self.angle)) ** 2
        pull = 0.25 * math.pi * self.widest**2 * (3.0 * square - 1.0)
        # The wall takes volume from the gas; most muscles are described without it.
        if wall:
            sine = m.sqrt(1.0 - square)
            pull = pull + math.pi * wall * (self.widest * (2.0 * sine - 1.0 / sine) - wall)
        return pull

    @property
    def limits(self) -> tuple[float, float]:
        """Contractions with fibres between 5.7 and 80 degrees: beyond these, walls and ends decide."""
        cosine = math.cos(self.angle)
        return 1.0 - math.cos(_FLAT) / cosine, 1.0 - math.cos(_STEEP) / cosine


class FibreMuscle(MuscleModel):
    """A muscle of fibres that stand at an angle to the axis, and contracts."""

    angle: float

    def __post_init__(self) -> None:
        super().__post_init__()
        if not _FLAT < self.angle < NEUTRAL:
            raise ParameterError(
                f"angle = {math.degrees(self.angle):g} degrees: fibres at 5.8 to 54.7 degrees at rest make a muscle "
                "that contracts. Angles are in rad.",
                angle=self.angle,
            )


class BraidedMuscle(FibreMuscle):
    """A muscle that is inextensible fibres around a cylinder, perhaps with a wall inside."""

    diameter: float
    wall: float = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        if not 2 * self.wall < self.diameter:
            raise ParameterError(
                f"wall = {self.wall:g} m fills the muscle of {self.diameter:g} m; pass the thickness."
            )

    @cached_property
    def braid(self) -> Braid:
        """Geometry: fibre length, turns, volume."""
        return Braid(self.length, self.diameter, self.angle)

    @property
    def limits(self) -> tuple[float, float]:
        """Fibres between 5.7 and 80 degrees."""
        return self.braid.limits


@dataclass(frozen=True)
class ChouHannaford(BraidedMuscle):
    r"""Inextensible braid by virtual work, and Coulomb friction (Chou, Hannaford 1994, 1996).

    .. math::

        F_{static} = -p \frac{dV}{dl} = \frac{\pi D_{90}^2 p}{4} (3 \cos^2\theta - 1)
            + \pi p \left[ D_{90}\, t \left( 2 \sin\theta - \frac{1}{\sin\theta} \right) - t^2 \right],
        \qquad \cos\theta = (1 - \kappa) \cos\theta_0

    .. math:: R = F_c \, s

    D_90 = D_0/sin(theta_0) is the diameter with fibres at right angles to the axis, t the thickness of the wall.
    Without wall the force is zero at 54.7 degrees, arccos(1/sqrt 3), whatever the pressure.

    Source: Chou, Hannaford, IEEE Transactions on Robotics and Automation 12(1), 1996 (own knowledge, high confidence).
    They measured hysteresis that is Coulomb friction, hardly dependent on rate, and gave no model: a constant band F_c
    of 2 to 5 N for braided muscles of 15 mm (low confidence: calibrate).

    Cannot show
    -----------
    Rubber that resists contraction: a geometric muscle is some 4 % of the largest force off. Friction that grows with
    pressure; loops inside loops.

    Examples
    --------
    >>> braid = ChouHannaford.published("braid-15")
    >>> neutral = 1 - math.cos(NEUTRAL) / math.cos(braid.angle)
    >>> abs(float(braid.static_force(neutral, 4e5))) < 1e-9
    True
    """

    name = "chou-hannaford"
    length: float
    diameter: float
    angle: float
    wall: float
    band: float
    presliding: float

    @property
    def largest_contraction(self) -> float:
        """At 54.7 degrees, where a muscle without wall stops to pull."""
        return 1.0 - math.cos(NEUTRAL) / math.cos(self.angle)

    def _static(self, kappa: Any, pressure: Any, m: Arithmetic) -> Any:
        return pressure * self.braid.pull(kappa, self.wall, m)

    def _resistance(self, kappa: Any, pressure: Any, speed: Any, slip: Any, m: Arithmetic) -> Any:
        return self.band * slip


@dataclass(frozen=True)
class BoblanMartens(BraidedMuscle):
    r"""Braid with a wall of rubber, from dimensions and one modulus (Boblan 2009; Martens, Boblan 2017).

    .. math::

        F = -p \frac{dV}{dL} + \sigma_D H_0 L \pi \frac{dD}{dL} - \sigma_L H_0 \pi D, \qquad
        \sigma_L = E \frac{L - L_0}{L_0}, \quad \sigma_D = E \frac{D - D_0}{D_0}

        V = \frac{L (L_f^2 - L^2)}{4 \pi n^2}, \quad D = \frac{\sqrt{L_f^2 - L^2}}{n \pi}, \quad
        L_f = \frac{L_0}{\cos\theta_0}, \quad n = \frac{L_0 \tan\theta_0}{\pi D_0}, \quad E(L) = \sum_{i=0}^3 c_i L^i

    L = l_0 (1 - kappa) in metres: the modulus E(L) belongs to muscles of one length. The sign of the last term is the
    one that was found and that reproduces the measured map: 16 N rms where a DMSP-20 of 300 mm pulls, 1.1 % of its
    largest force.

    Source: Martens, Boblan, Actuators 6(4), 2017, as found in ModelComparison2.m: structure and coefficients found; the
    angle is 28.6 degrees and an offset of -0.073 and -0.1 rad. Lightly damped and without hysteresis: Boblan neglected
    the latter for lack of data.

    Cannot show
    -----------
    Hysteresis, speed, creep: it is a static map. Muscles of another length or diameter without another E(L).

    Examples
    --------
    Measured at 600 kPa and 296, 282 and 267 mm: 1460, 1004 and 715 N.

    >>> muscle = BoblanMartens.published("DMSP-20-300")
    >>> [round(float(muscle.static_force(1 - l / 0.3, 6e5))) for l in (0.296, 0.282, 0.267)]
    [1445, 1022, 733]
    """

    name = "boblan-martens"
    length: float
    diameter: float
    angle: float
    wall: float
    c0: float
    c1: float
    c2: float
    c3: float

    @property
    def limits(self) -> tuple[float, float]:
        """Somewhat beyond the measured 0.013 to 0.26: the cubic modulus means nothing further out."""
        return -0.05, 0.35

    def modulus(self, kappa: Any) -> Any:
        """Return E of the wall at a contraction. [Pa]"""
        long = self.length * (1.0 - kappa)
        return self.c0 + long * (self.c1 + long * (self.c2 + long * self.c3))

    def _static(self, kappa: Any, pressure: Any, m: Arithmetic) -> Any:
        # In the symbols above: L, sqrt(L_f^2 - L^2), D and dD/dL.
        braid = self.braid
        modulus = self.modulus(kappa)
        long = self.length * (1.0 - kappa)
        across = m.sqrt(braid.fibre**2 - long * long)
        wide = across / (braid.turns * math.pi)
        slope = -long / across / (braid.turns * math.pi)
        around = (
            modulus * (wide - self.diameter) / self.diameter * self.wall * long * math.pi * slope
        )
        along = modulus * -kappa * self.wall * math.pi * wide
        return pressure * braid.pull(kappa, 0.0, m) + around - along


@dataclass(frozen=True)
class DavisCaldwell(BraidedMuscle):
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

    Raises
    ------
    ParameterError
        If a value has no physical meaning, or the strands do not fit next to each other at rest.

    Cannot show
    -----------
    Rubber; loops inside loops, which need more than one slip strain; dependence on speed.

    Examples
    --------
    >>> braid = DavisCaldwell.published("nylon")
    >>> round(math.degrees(braid.locking_angle), 1)
    7.0
    """

    name = "davis-caldwell"
    length: float
    diameter: float
    angle: float
    strands: float
    strand: float
    friction: float
    contact: float
    exponent: float
    reference_pressure: float
    presliding: float

    def __post_init__(self) -> None:
        super().__post_init__()
        if (
            self._packing >= 1
            or not self.locking_angle < self.angle < math.pi / 2 - self.locking_angle
        ):
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
        cosine = math.cos(self.angle)
        least = self.locking_angle
        return 1.0 - math.cos(least) / cosine, 1.0 - math.sin(least) / cosine

    def contact_area(self, kappa: Any, m: Arithmetic) -> Any:
        """Return A, of all contacts together. [m^2]"""
        cosine = (1.0 - kappa) * math.cos(self.angle)
        # A rhombus of two bands of equal width: sin(2 theta) = 2 sin(theta) cos(theta).
        crossing = (self.contact * self.strand) ** 2 / (
            2.0 * cosine * m.sqrt(1.0 - cosine * cosine)
        )
        return 2.0 * self.braid.turns * self.strands**2 * crossing

    def _static(self, kappa: Any, pressure: Any, m: Arithmetic) -> Any:
        return pressure * self.braid.pull(kappa, 0.0, m)

    def _resistance(self, kappa: Any, pressure: Any, speed: Any, slip: Any, m: Arithmetic) -> Any:
        # A vacuum does not press the strands together.
        load = m.maximum(pressure, 0.0)
        if self.exponent:
            load = load * (load / self.reference_pressure) ** self.exponent
        return self.friction * load * self.contact_area(kappa, m) * slip


@dataclass(frozen=True)
class Klute(BraidedMuscle):
    r"""Braid with a Mooney-Rivlin bladder and Hill's force-velocity law (Klute, Czerniecki, Hannaford 2002).

    .. math::

        F_{static} = -p \frac{dV}{dl} + V_b \frac{dW}{dl}, \qquad W = C_{10} (I_1 - 3) + C_{01} (I_2 - 3)

        R = c\, v |v| + (1 + \alpha) F_{static}^+ \frac{v}{b + |v|}

    The bladder is incompressible, relaxed at l_0, and follows the braid: stretches 1 - kappa along the axis and
    sin(theta)/sin(theta_0) around it; V_b is its volume. A bare actuator hardly depends on speed; Klute and others
    added a hydraulic damper in parallel, whose orifice gives c v^2, so that actuator and damper together follow a
    biological muscle,

    .. math:: (F + a)(v + b) = (F_0 + a)\, b, \qquad a = \alpha F_0, \quad v_{max} = b F_0/a,

    which is the second term, as a law of its own: F = F_0 - (1 + alpha) F_0 v/(b + v). b = 0 leaves it out.

    Structure: own knowledge, high confidence; C_10 = 118.4 kPa and C_01 = 105.7 kPa of latex medium; c low: calibrate.
    Measured for shortening only; here the damper resists both ways, and so does Hill's term.

    Cannot show
    -----------
    Hysteresis at low speed: both terms vanish there. A bladder that is slack before it touches the braid.

    Examples
    --------
    >>> actuator = Klute.published("triceps")
    >>> float(actuator.static_force(0.1, 5e5)) > float(actuator.static_force(0.2, 5e5))
    True
    """

    name = "klute"
    length: float
    diameter: float
    angle: float
    wall: float
    c10: float
    c01: float
    damper: float
    hill_ratio: float
    hill_speed: float

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
        # Principal stretches: along the axis, around it, and through the wall, whose product is 1.
        along = 1.0 - kappa
        start = math.sin(self.angle)
        around = m.sqrt(1.0 - (along * math.cos(self.angle)) ** 2) / start
        # Slopes of the stretches around and through over that along.
        slope = -((math.cos(self.angle) / start) ** 2) * along / around
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
        # A muscle that does not pull has no force that speed could take away.
        if self.hill_speed:
            isometric = m.maximum(self._static(kappa, pressure, m), 0.0)
            resistance = resistance + (1.0 + self.hill_ratio) * isometric * speed / (
                self.hill_speed + abs(speed)
            )
        return resistance
