"""Curves in space by arc length: straight lines, circles, corner blends, and sequences of them."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from functools import cache

import numpy as np
from numpy.polynomial import Chebyshev

from dehyst.arrays import Array, Rows


class Curve(ABC):
    """A curve r(s) over its arc length s, with a continuous tangent.

    The peaks of its curvature kappa = \\|r''\\| and of the derivative of kappa bound acceleration and jerk along it.

    Attributes
    ----------
    length
        Arc length. [m]
    curvature
        Largest curvature. [1/m]
    curvature_rate
        Largest change of the curvature along the curve. [1/m^2]
    """

    length: float
    curvature: float = 0.0
    curvature_rate: float = 0.0

    @abstractmethod
    def at(self, s: Array) -> tuple[Array, Array, Array]:
        """Return r(s), r'(s) and r''(s), (N, 3) each, for s (N,)."""


class Straight(Curve):
    """Straight line from `start` to `end`, (3,) each. [m]

    Examples
    --------
    >>> Straight(np.zeros(3), np.array([3.0, 4.0, 0.0])).length
    5.0
    """

    def __init__(self, start: Array, end: Array) -> None:
        self.start = start
        self.end = end
        self.length = math.dist(start, end)

    def at(self, s: Array) -> tuple[Array, Array, Array]:
        """Return r(s), r'(s) and r''(s), (N, 3) each, for s (N,)."""
        direction = (self.end - self.start) / self.length
        tangent = np.broadcast_to(direction, (s.size, 3)).copy()
        return self.start + s[:, None] * direction, tangent, np.zeros((s.size, 3))


class Circle(Curve):
    """Full circle r(s) = center + radius (u cos(s/radius) + v sin(s/radius)); u, v orthogonal unit vectors (3,).

    Examples
    --------
    >>> x, y, _ = np.eye(3)
    >>> position, tangent, bend = Circle(np.zeros(3), x, y, 2.0).at(np.array([np.pi]))
    >>> position.round(12).tolist(), tangent.round(12).tolist(), bend.round(12).tolist()
    ([[0.0, 2.0, 0.0]], [[-1.0, 0.0, 0.0]], [[-0.0, -0.5, -0.0]])
    """

    def __init__(self, center: Array, u: Array, v: Array, radius: float) -> None:
        self.center = center
        self.u, self.v = u, v
        self.radius = radius
        self.length = 2.0 * math.pi * radius
        self.curvature = 1.0 / radius

    def at(self, s: Array) -> tuple[Array, Array, Array]:
        """Return r(s), r'(s) and r''(s), (N, 3) each, for s (N,)."""
        angle = s[:, None] / self.radius
        outward = self.u * np.cos(angle) + self.v * np.sin(angle)
        tangent = self.v * np.cos(angle) - self.u * np.sin(angle)
        return self.center + self.radius * outward, tangent, -outward / self.radius


@cache
def _blend_shape() -> tuple[Chebyshev, Chebyshev]:
    """Return x(u), y(u) of the blend of unit length, u in 0..1: integrals of cos and sin of its heading."""

    def heading(u: Array) -> Array:
        return np.asarray(0.25 * np.pi * (1.0 - np.cos(np.pi * u)))

    # An entire function: 24 terms leave 1e-16 of the length, checked against quadrature in the tests.
    x = Chebyshev.interpolate(lambda u: np.cos(heading(u)), 24, domain=[0.0, 1.0])
    y = Chebyshev.interpolate(lambda u: np.sin(heading(u)), 24, domain=[0.0, 1.0])
    return x.integ(lbnd=0.0), y.integ(lbnd=0.0)


class Blend(Curve):
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

    def __init__(self, corner: Array, into: Array, out: Array, rounding: float) -> None:
        self.corner = corner
        self.into, self.out = into, out
        self.rounding = rounding
        # The blend of unit length reaches as far along the first leg as the rounding is long.
        self.length = rounding / float(_blend_shape()[0](1.0))
        self.curvature = math.pi**2 / (4.0 * self.length)  # half way
        self.curvature_rate = self.curvature * math.pi / self.length  # at both ends

    def at(self, s: Array) -> tuple[Array, Array, Array]:
        """Return r(s), r'(s) and r''(s), (N, 3) each, for s (N,)."""
        shape_x, shape_y = _blend_shape()
        u = s[:, None] / self.length
        theta = 0.25 * np.pi * (1.0 - np.cos(np.pi * u))
        kappa = self.curvature * np.sin(np.pi * u)
        along = self.length * shape_x(u) - self.rounding
        across = self.length * shape_y(u)
        tangent = self.into * np.cos(theta) + self.out * np.sin(theta)
        normal = self.out * np.cos(theta) - self.into * np.sin(theta)
        return self.corner + self.into * along + self.out * across, tangent, kappa * normal


class Chain(Curve):
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

    def index(self, s: Array) -> Rows:
        """Return which curve the arc lengths s (N,) lie on, (N,); at a joint the later one."""
        return np.searchsorted(self.ends[:-1], s, side="right").astype(np.int64)

    def at(self, s: Array) -> tuple[Array, Array, Array]:
        """Return r(s), r'(s) and r''(s), (N, 3) each, for s (N,); beyond an end the end."""
        # Rounding of a time law may end a little behind the path.
        s = np.clip(s, 0.0, self.length)
        index = self.index(s)
        position, tangent, bend = np.empty((3, s.size, 3))
        for number, curve in enumerate(self.curves):
            here = index == number
            if here.any():
                position[here], tangent[here], bend[here] = curve.at(s[here] - self.starts[number])
        return position, tangent, bend
