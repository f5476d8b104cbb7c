"""Test cube, test plane and test paths of ISO 9283:1998, clause 6.8."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array
from dehyst.errors import ParameterError
from dehyst.robot.iso9283.curves import Blend, Chain, Circle, Curve, Straight
from dehyst.robot.iso9283.paths import Figure, TestPath

# C1..C4 the lower face, counter-clockwise from above, C1-C2 the edge nearest the base; C5..C8 above them. x forward,
# y left, z up. The numbering on the cube is [own knowledge, medium]; the four planes are the standard's.
_CORNERS = np.array(
    [[-1, 1, -1], [-1, -1, -1], [1, -1, -1], [1, 1, -1], [-1, 1, 1], [-1, -1, 1], [1, -1, 1], [1, 1, 1]],
    dtype=np.float64,
)
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
            raise ParameterError(f"the test cube's edge is {self.edge} m; pass a positive length, such as 0.4.")
        center = np.asarray(self.center, dtype=np.float64)
        if center.shape != (3,) or not np.isfinite(center).all():
            raise ParameterError(f"the test cube's centre {self.center!r} is no point; pass x, y, z in m.")
        if self.plane not in PLANES:
            raise ParameterError(f"no test plane {self.plane!r}; the cube has {', '.join(PLANES)}.", plane=self.plane)

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
        first, second, _, fourth = (self.corner(number) for number in PLANES[self.plane])
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
    """Return the rectangle with its corners at 10 % of the plane's diagonals from the plane's corners, rounded.

    Its sides are 0.8 L and 0.8 sqrt(2) L. It starts and ends in the middle of a long side, so that all four corners are
    passed at the command speed. The rounding is a `Blend`, whose curvature is continuous: with sharp corners the arm
    would have to stop in each, with arcs its acceleration would jump. The rounding goes with every result.

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
    corners = cube.pose_points()[[2, 3, 4, 1]]  # E2, E3, E4, E1: the long side E1-E4 holds the start
    start = 0.5 * (corners[2] + corners[3])
    curves: list[Curve] = []
    corners = np.roll(corners, 1, axis=0)  # passed in the order E1, E2, E3, E4
    here = start
    for number, corner in enumerate(corners):
        into = _unit(corner - here)
        out = _unit(corners[(number + 1) % 4] - corner)
        curves += [Straight(here, corner - rounding * into), Blend(corner, into, out, rounding)]
        here = corner + rounding * out
    curves.append(Straight(here, start))
    return Figure("rectangle", (Chain(curves),), corners, rounding)


def _unit(vector: Array) -> Array:
    return vector / float(np.linalg.norm(vector))


def test_path(cube: TestCube, rounding: float) -> TestPath:
    """Return the test path: line there and back, large circle, small circle, rectangle, from P1 and back to P1.

    Each figure begins and ends at rest; straight transfers join them.

    References
    ----------
    ISO 9283:1998, 6.8: paths to be followed.

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
