"""Geometry that several models start from: fibres wound around a cylinder, and a cylinder with conical ends."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from dehyst.errors import ParameterError
from dehyst.robot.muscles.base import Arithmetic, MuscleModel

NEUTRAL = math.acos(1 / math.sqrt(3))  # 54.7 degrees, where pressure neither pulls nor pushes
_STEEP = math.radians(80.0)
_FLAT = math.asin(0.1)


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
        if wall:
            sine = m.sqrt(1.0 - square)
            pull = pull + math.pi * wall * (self.widest * (2.0 * sine - 1.0 / sine) - wall)
        return pull

    @property
    def limits(self) -> tuple[float, float]:
        """Contractions with fibres between 5.7 and 80 degrees: beyond, walls and ends are what counts."""
        rest = math.cos(self.angle)
        return 1.0 - math.cos(_FLAT) / rest, 1.0 - math.cos(_STEEP) / rest


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
            raise ParameterError(f"wall = {self.wall:g} m fills the muscle of {self.diameter:g} m; pass the thickness.")

    @cached_property
    def braid(self) -> Braid:
        """Geometry: fibre length, turns, volume."""
        return Braid(self.length, self.diameter, self.angle)

    @property
    def limits(self) -> tuple[float, float]:
        """Fibres between 5.7 and 80 degrees."""
        return self.braid.limits


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
        k = self.shape + (self.shape_pressure * m.exp(-pressure / 1e5) if self.shape_pressure else 0.0)
        a, b = 3.0 / math.tan(self.angle) ** 2, 1.0 / math.sin(self.angle) ** 2
        return math.pi * self.radius**2 * (a * (1.0 - k * kappa) ** 2 - b)
