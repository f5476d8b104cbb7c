"""Test cube and test paths of ISO 9283:1998, clause 6.8: line, circles, rectangle, joined to a closed cycle."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array, Rows
from dehyst.errors import ParameterError
from dehyst_robot.iso9283._curves import Blend, Chain, Circle, Curve, Straight

TRANSFER = -1  # figure index of the ways between figures


class _Path:
    """Base of what runs along a chain of curves."""

    chain: Chain

    @property
    def length(self) -> float:
        """Arc length of the whole. [m]"""
        return self.chain.length

    def position(self, s: npt.ArrayLike) -> Array:
        """Return the points (N, 3) at arc lengths s (N,) from the start. [m]"""
        return self.chain.at(_lengths(s))[0]

    def tangent(self, s: npt.ArrayLike) -> Array:
        """Return the unit tangents (N, 3) at arc lengths s (N,)."""
        return self.chain.at(_lengths(s))[1]


def _lengths(s: npt.ArrayLike) -> Array:
    return np.atleast_1d(np.asarray(s, dtype=np.float64))


@dataclass(frozen=True, eq=False)
class Figure(_Path):
    """One figure of a test path.

    Attributes
    ----------
    name
        Such as "large circle".
    strokes
        Curves run from rest to rest, one after the other: a circle has one, a line that is run there and back two.
    corners
        Sharp corners of the figure before rounding, (K, 3) in the order in which they are passed; (0, 3) if it has
        none. [m]
    rounding
        Distance from a sharp corner at which its rounding begins. [m]
    """

    name: str
    strokes: tuple[Curve, ...]
    corners: Array = field(default_factory=lambda: np.empty((0, 3)))
    rounding: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "chain", Chain(self.strokes))

    @property
    def closed(self) -> bool:
        """Whether the figure ends at its start, as a line run there and back does."""
        start, end = self.position([0.0, self.length])
        return bool(np.linalg.norm(end - start) <= 1e-9 * self.length)


@dataclass(frozen=True, eq=False)
class Leg:
    """A part of a test path that is run from rest to rest.

    Attributes
    ----------
    figure
        Index of its figure, -1 for a transfer.
    curve
        The way of the leg.
    offset
        Arc length of the figure at which the leg begins. [m]
    """

    figure: int
    curve: Curve
    offset: float = 0.0


@dataclass(frozen=True, eq=False)
class TestPath(_Path):
    """Figures joined by straight transfers to one closed cycle, so that cycles can be repeated.

    Attributes
    ----------
    figures
        In the order in which they are run.
    home
        Where a cycle begins and ends, (3,). [m]
    legs
        Parts of a cycle that are run from rest to rest: strokes of the figures and transfers between them.

    Examples
    --------
    >>> o, x = np.zeros(3), np.array([1.0, 0.0, 0.0])
    >>> line = Figure("line", (Straight(o, x), Straight(x, o)))
    >>> path = TestPath((line,), home=np.array([0.0, 1.0, 0.0]))
    >>> path.length, path.rests.tolist(), path.figure([0.5, 1.5, 3.5]).tolist()
    (4.0, [0.0, 1.0, 2.0, 3.0, 4.0], [-1, 0, -1])
    """

    __test__ = False  # its name is the standard's, not pytest's
    figures: tuple[Figure, ...]
    home: Array
    legs: tuple[Leg, ...] = field(init=False)

    def __post_init__(self) -> None:
        if not self.figures:
            raise ParameterError(
                "a test path without figures measures nothing; pass at least one figure."
            )
        legs = _legs(self.figures, np.asarray(self.home, dtype=np.float64))
        object.__setattr__(self, "legs", legs)
        object.__setattr__(self, "chain", Chain([leg.curve for leg in legs]))

    @property
    def rests(self) -> Array:
        """Arc lengths at which the path rests, start and end of the cycle included, (legs + 1,). [m]"""
        return np.concatenate(([0.0], self.chain.ends))

    def figure(self, s: npt.ArrayLike) -> Rows:
        """Return the index of the figure at arc lengths s (N,), -1 on a transfer; at a rest point the next leg's."""
        return self.figure_of_leg[self.chain.index(_lengths(s))]

    @cached_property
    def figure_of_leg(self) -> Rows:
        """(legs,) index of the figure that each leg belongs to, -1 for a transfer."""
        return np.array([leg.figure for leg in self.legs], dtype=np.int64)


def _legs(figures: Sequence[Figure], home: Array) -> tuple[Leg, ...]:
    """Return the legs of a cycle: home, the figures in order with transfers between them, home."""
    legs: list[Leg] = []

    def transfer(start: Array, end: Array) -> None:
        # Figures that join need no way between them.
        if np.linalg.norm(end - start) >= 1e-9:
            legs.append(Leg(TRANSFER, Straight(start, end)))

    here = home
    for index, figure in enumerate(figures):
        start, end = figure.position([0.0, figure.length])
        transfer(here, start)
        offset = 0.0
        for stroke in figure.strokes:
            legs.append(Leg(index, stroke, offset))
            offset += stroke.length
        here = end
    transfer(here, home)
    return tuple(legs)


# C1..C4 the lower face, counter-clockwise from above, C1-C2 the edge nearest the base; C5..C8 above them. x forward,
# y left, z up. The numbering on the cube is [own knowledge, medium]; the four planes are the standard's.
_CORNERS = np.array(
    [
        [-1, 1, -1], [-1, -1, -1], [1, -1, -1], [1, 1, -1],
        [-1, 1, 1], [-1, -1, 1], [1, -1, 1], [1, 1, 1],
    ],
    dtype=np.float64,
)  # fmt: skip
PLANES = {
    "C1-C2-C7-C8": (1, 2, 7, 8),
    "C2-C3-C8-C5": (2, 3, 8, 5),
    "C3-C4-C5-C6": (3, 4, 5, 6),
    "C4-C1-C6-C7": (4, 1, 6, 7),
}
SHARE = 0.8  # of the plane's diagonal and of the edge: the corners of line and rectangle lie at 10 % of the diagonal


@dataclass(frozen=True, eq=False)
class TestCube:
    """Test cube with its edges parallel to the frame of the base, and one of its diagonal planes.

    Parameters
    ----------
    edge
        L. [m]
    center
        P1, (3,) in the frame of the base: x forward, y left, z up. [m]
    plane
        "C1-C2-C7-C8" (the preferred one: it rises with the distance from the base), "C2-C3-C8-C5", "C3-C4-C5-C6" or
        "C4-C1-C6-C7". The four are one another turned about the vertical.

    Raises
    ------
    ParameterError
        If the edge is not positive, the centre not a point, or the plane not one of the four.

    Examples
    --------
    >>> cube = TestCube(0.4, [0.6, 0.0, 0.9])
    >>> cube.corner(1).round(9).tolist(), cube.corner(7).round(9).tolist()
    ([0.4, 0.2, 0.7], [0.8, -0.2, 1.1])
    """

    __test__ = False
    edge: float
    center: npt.ArrayLike
    plane: str = "C1-C2-C7-C8"

    def __post_init__(self) -> None:
        if not (math.isfinite(self.edge) and self.edge > 0):
            raise ParameterError(
                f"the test cube's edge is {self.edge} m; pass a positive length, such as 0.4."
            )
        center = np.asarray(self.center, dtype=np.float64)
        if center.shape != (3,) or not np.isfinite(center).all():
            raise ParameterError(
                f"the test cube's centre {self.center!r} is no point; pass x, y, z in m."
            )
        if self.plane not in PLANES:
            raise ParameterError(
                f"no test plane {self.plane!r}; the cube has {', '.join(PLANES)}.", plane=self.plane
            )

    @property
    def origin(self) -> Array:
        """P1, the centre as an array (3,). [m]"""
        return np.asarray(self.center, dtype=np.float64)

    def corner(self, number: int) -> Array:
        """Return the cube's corner C1..C8, (3,). [m]"""
        half: float = 0.5 * self.edge
        return np.asarray(self.origin + half * _CORNERS[number - 1])

    @property
    def axes(self) -> tuple[Array, Array, Array]:
        """Unit vectors (3,): along the plane's short side (a horizontal edge), along its long side, and its normal."""
        numbers = PLANES[self.plane]
        first = self.corner(numbers[0])
        second = self.corner(numbers[1])
        fourth = self.corner(numbers[3])
        u = (second - first) / self.edge
        v = (fourth - first) / (math.sqrt(2.0) * self.edge)
        return u, v, np.cross(u, v)

    def pose_points(self) -> Array:
        """Return P1..P5 of the standard, (5, 3): the centre, and the points at 10 % of the plane's diagonals. [m]"""
        corners = np.array([self.corner(number) for number in PLANES[self.plane]])
        return np.vstack([self.origin, self.origin + SHARE * (corners - self.origin)])


def line(cube: TestCube) -> Figure:
    """Return the line P2-P4 on a diagonal of the test plane, run there and back.

    Its length one way is 0.8 sqrt(3) L, 0.8 of the distance of opposite corners.

    Examples
    --------
    >>> round(line(TestCube(1.0, [0, 0, 0])).length, 9) == round(2 * 0.8 * 3**0.5, 9)
    True
    """
    _, p2, _, p4, _ = cube.pose_points()
    return Figure("line", (Straight(p2, p4), Straight(p4, p2)))


def circle(cube: TestCube, diameter_share: float, name: str) -> Figure:
    """Return a circle around P1 with a diameter of `diameter_share` L (the standard's: 0.8 and 0.1), run once."""
    u, v, _ = cube.axes
    return Figure(name, (Circle(cube.origin, u, v, 0.5 * diameter_share * cube.edge),))


def rectangle(cube: TestCube, rounding: float) -> Figure:
    """Return the rounded rectangle whose corners lie 10 % of the plane's diagonals inside the plane's corners.

    Its sides are 0.8 L and 0.8 sqrt(2) L. It starts and ends in the middle of a long side, so that all four corners are
    passed at the command speed. Each corner is rounded by a `Blend`, whose curvature is continuous. At a sharp corner
    the arm would have to stop; on an arc its acceleration would jump. Every result names the rounding.

    Parameters
    ----------
    cube
        Gives the plane.
    rounding
        Distance from the sharp corner at which the rounding begins. [m]

    Raises
    ------
    ParameterError
        If the roundings of a short side's two corners overlap, or there is none.

    Examples
    --------
    >>> figure = rectangle(TestCube(0.4, [0.6, 0.0, 0.9]), 0.03)
    >>> figure.closed, figure.corners.shape
    (True, (4, 3))
    """
    short = SHARE * cube.edge
    if not 0 < rounding < 0.5 * short:
        raise ParameterError(
            f"a rounding of {rounding} m does not fit the rectangle, whose short sides are {short:g} m: two roundings "
            f"of one side must not meet, and a sharp corner cannot be passed without a stop. Pass 0 < rounding < "
            f"{0.5 * short:g}.",
            rounding=rounding,
        )
    corners = cube.pose_points()[1:]  # E1 to E4 in the order in which they are passed
    here = start = 0.5 * (corners[3] + corners[0])  # on the long side E4-E1
    curves: list[Curve] = []
    for corner, following in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        into, out = _unit(corner - here), _unit(following - corner)
        curves += [Straight(here, corner - rounding * into), Blend(corner, into, out, rounding)]
        here = corner + rounding * out
    curves.append(Straight(here, start))
    return Figure("rectangle", (Chain(curves),), corners, rounding)


def _unit(vector: Array) -> Array:
    return vector / float(np.linalg.norm(vector))


def test_path(cube: TestCube, rounding: float) -> TestPath:
    """Return the test path: line there and back, large circle, small circle, rectangle, from P1 and back to P1.

    Each figure begins and ends at rest; straight transfers join them.

    Examples
    --------
    >>> path = test_path(TestCube(0.4, [0.6, 0.0, 0.9]), rounding=0.03)
    >>> [figure.name for figure in path.figures]
    ['line', 'large circle', 'small circle', 'rectangle']
    """
    figures = (
        line(cube),
        circle(cube, 0.8, "large circle"),
        circle(cube, 0.1, "small circle"),
        rectangle(cube, rounding),
    )
    return TestPath(figures, home=cube.origin)


test_path.__test__ = False  # type: ignore[attr-defined]  # its name is the standard's, not pytest's
