"""Geometry of fibres that wind around a cylinder, shared by the models that start from it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from dehyst.errors import ParameterError
from dehyst.robot.muscles.arithmetic import Arithmetic
from dehyst.robot.muscles.base import MuscleModel

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


class BraidedMuscle(MuscleModel):
    """A muscle that is inextensible fibres around a cylinder."""

    diameter: float
    angle: float

    @cached_property
    def braid(self) -> Braid:
        """Geometry: fibre length, turns, volume."""
        return Braid(self.length, self.diameter, self.angle)

    @property
    def limits(self) -> tuple[float, float]:
        """Fibres between 5.7 and 80 degrees."""
        return self.braid.limits

    def _refuse_thick(self, wall: float) -> None:
        if not 2 * wall < self.diameter:
            raise ParameterError(f"wall = {wall:g} m fills the muscle of {self.diameter:g} m; pass the thickness.")


def contracting_angle(angle: float) -> None:
    """Raise unless fibres at this angle make a muscle that contracts."""
    if not _FLAT < angle < NEUTRAL:
        raise ParameterError(
            f"angle = {math.degrees(angle):g} degrees: fibres at 5.8 to 54.7 degrees at rest make a muscle that "
            "contracts. Angles are in rad.",
            angle=angle,
        )


def conical_pull(kappa: Any, shape: Any, radius: float, angle: float) -> Any:
    """Return pi r_0^2 [a (1 - k kappa)^2 - b], the force for 1 Pa of a cylinder with conical ends. [m^2]"""
    a, b = 3.0 / math.tan(angle) ** 2, 1.0 / math.sin(angle) ** 2
    return math.pi * radius**2 * (a * (1.0 - shape * kappa) ** 2 - b)


def conical_limit(shape: float, angle: float) -> float:
    """Return the contraction (1 - sqrt(b/a))/k at which it stops to pull."""
    return (1.0 - 1.0 / (math.sqrt(3.0) * math.cos(angle))) / shape
