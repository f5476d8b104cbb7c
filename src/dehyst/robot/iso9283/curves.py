"""Curves in space over their arc length: straight lines, circles, corner blends, and chains of them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Protocol

import numpy as np
import numpy.typing as npt
from numpy.polynomial import Chebyshev

from dehyst.arrays import Array


class Curve(Protocol):
    """A curve r(s) over its arc length s, with a continuous tangent.

    Curvature kappa = \\|r''\\|; its peak and the peak of its derivative bound acceleration and jerk along the curve.
    """

    @property
    def length(self) -> float:
        """Arc length. [m]"""

    @property
    def curvature(self) -> float:
        """Largest curvature. [1/m]"""

    @property
    def curvature_rate(self) -> float:
        """Largest change of the curvature along the curve. [1/m^2]"""

    def at(self, s: Array) -> tuple[Array, Array, Array]:
        """Return r(s), r'(s) and r''(s), (N, 3) each, for s (N,)."""


@dataclass(frozen=True, eq=False)
class Straight:
    """Straight line from `start` to `end`, (3,) each. [m]

    Examples
    --------
    >>> Straight(np.zeros(3), np.array([3.0, 4.0, 0.0])).length
    5.0
    """

    start: Array
    end: Array
    curvature: float = 0.0
    curvature_rate: float = 0.0

    @property
    def length(self) -> float:
        """Arc length. [m]"""
        return math.dist(self.start, self.end)

    def at(self, s: Array) -> tuple[Array, Array, Array]:
        """Return r(s), r'(s) and r''(s), (N, 3) each, for s (N,)."""
        direction = (self.end - self.start) / self.length
        tangent = np.broadcast_to(direction, (s.size, 3)).copy()
        return self.start + s[:, None] * direction, tangent, np.zeros((s.size, 3))


@dataclass(frozen=True, eq=False)
class Circle:
    """Full circle r(s) = center + radius (u cos(s/radius) + v sin(s/radius)); u, v orthogonal unit vectors (3,).

    Examples
    --------
    >>> x, y, _ = np.eye(3)
    >>> position, tangent, bend = Circle(np.zeros(3), x, y, 2.0).at(np.array([np.pi]))
    >>> position.round(12).tolist(), tangent.round(12).tolist(), bend.round(12).tolist()
    ([[0.0, 2.0, 0.0]], [[-1.0, 0.0, 0.0]], [[-0.0, -0.5, -0.0]])
    """

    center: Array
    u: Array
    v: Array
    radius: float
    curvature_rate: float = 0.0

    @property
    def length(self) -> float:
        """Arc length. [m]"""
        return 2.0 * math.pi * self.radius

    @property
    def curvature(self) -> float:
        """Largest curvature. [1/m]"""
        return 1.0 / self.radius

    def at(self, s: Array) -> tuple[Array, Array, Array]:
        """Return r(s), r'(s) and r''(s), (N, 3) each, for s (N,)."""
        angle = s[:, None] / self.radius
        outward = self.u * np.cos(angle) + self.v * np.sin(angle)
        return (
            self.center + self.radius * outward,
            self.v * np.cos(angle) - self.u * np.sin(angle),
            -outward / self.radius,
        )


@cache
def _blend_shape() -> tuple[Chebyshev, Chebyshev]:
    """Return x(u), y(u) of the blend of unit length, u in 0..1: integrals of cos and sin of its heading."""

    def heading(u: Array) -> Array:
        return np.asarray(0.25 * np.pi * (1.0 - np.cos(np.pi * u)))

    # An entire function: 24 terms leave 1e-16 of the length, checked against quadrature in the tests.
    x = Chebyshev.interpolate(lambda u: np.cos(heading(u)), 24, domain=[0.0, 1.0])
    y = Chebyshev.interpolate(lambda u: np.sin(heading(u)), 24, domain=[0.0, 1.0])
    return x.integ(lbnd=0.0), y.integ(lbnd=0.0)


@dataclass(frozen=True, eq=False)
class Blend:
    """Quarter turn between two legs whose curvature begins and ends at zero.

    The heading along a blend of length l is theta(s) = pi/4 (1 - cos(pi s/l)): the curvature pi^2/(4 l) sin(pi s/l) is
    continuous, its derivative bounded, so a point that runs along it at constant speed has continuous acceleration and
    bounded jerk - what a chamber filled through a valve can follow. An arc would jump in acceleration at both ends.

    Parameters
    ----------
    corner
        The sharp corner, (3,). [m]
    into, out
        Unit vectors along the leg into the corner and the leg out of it, orthogonal, (3,) each.
    rounding
        Distance from the corner at which the blend leaves the first leg and joins the second; for an arc that
        distance would be its radius. The smallest radius of curvature is 0.674 of it. [m]

    Examples
    --------
    >>> x, y, _ = np.eye(3)
    >>> blend = Blend(np.zeros(3), x, y, 0.03)
    >>> start, end = blend.at(np.array([0.0, blend.length]))[0]
    >>> bool(np.allclose(start, [-0.03, 0, 0]) and np.allclose(end, [0, 0.03, 0]))
    True
    """

    corner: Array
    into: Array
    out: Array
    rounding: float

    @property
    def length(self) -> float:
        """Arc length. [m]"""
        return self.rounding / float(_blend_shape()[0](1.0))

    @property
    def curvature(self) -> float:
        """Largest curvature, half way. [1/m]"""
        return math.pi**2 / (4.0 * self.length)

    @property
    def curvature_rate(self) -> float:
        """Largest change of the curvature along the curve, at both ends. [1/m^2]"""
        return self.curvature * math.pi / self.length

    def at(self, s: Array) -> tuple[Array, Array, Array]:
        """Return r(s), r'(s) and r''(s), (N, 3) each, for s (N,)."""
        shape_x, shape_y = _blend_shape()
        u = s[:, None] / self.length
        theta = 0.25 * np.pi * (1.0 - np.cos(np.pi * u))
        kappa = self.curvature * np.sin(np.pi * u)
        along, across = self.length * shape_x(u) - self.rounding, self.length * shape_y(u)
        tangent = self.into * np.cos(theta) + self.out * np.sin(theta)
        normal = self.out * np.cos(theta) - self.into * np.sin(theta)
        return self.corner + self.into * along + self.out * across, tangent, kappa * normal


class Chain:
    """Curves one after the other, over the arc length of all.

    Parameters
    ----------
    curves
        Each begins where the one before it ends.

    Examples
    --------
    >>> o, x, y = np.zeros(3), np.array([1.0, 0, 0]), np.array([1.0, 2.0, 0])
    >>> chain = Chain([Straight(o, x), Straight(x, y)])
    >>> chain.length, chain.at(np.array([0.5, 2.0]))[0].tolist()
    (3.0, [[0.5, 0.0, 0.0], [1.0, 1.0, 0.0]])
    """

    def __init__(self, curves: Sequence[Curve]) -> None:
        self.curves = tuple(curves)
        self.ends: Array = np.cumsum([curve.length for curve in self.curves])
        self.starts: Array = np.concatenate(([0.0], self.ends[:-1]))
        self.length = float(self.ends[-1])
        self.curvature = max(curve.curvature for curve in self.curves)
        self.curvature_rate = max(curve.curvature_rate for curve in self.curves)

    def index(self, s: Array) -> npt.NDArray[np.int64]:
        """Return which curve the arc lengths s (N,) lie on, (N,); at a joint the later one."""
        return np.searchsorted(self.ends[:-1], s, side="right").astype(np.int64)

    def at(self, s: Array) -> tuple[Array, Array, Array]:
        """Return r(s), r'(s) and r''(s), (N, 3) each, for s (N,); beyond an end the end."""
        s = np.clip(s, 0.0, self.length)
        index = self.index(s)
        position, tangent, bend = np.empty((s.size, 3)), np.empty((s.size, 3)), np.empty((s.size, 3))
        for number, curve in enumerate(self.curves):
            here = index == number
            if here.any():
                position[here], tangent[here], bend[here] = curve.at(s[here] - self.starts[number])
        return position, tangent, bend
