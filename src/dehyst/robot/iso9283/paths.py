"""Command paths: figures, each run from rest to rest, and the test path that joins them to a closed cycle."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array
from dehyst.errors import ParameterError
from dehyst.robot.iso9283.curves import Chain, Curve, Straight

TRANSFER = -1  # figure index of the ways between figures


@dataclass(frozen=True, eq=False)
class Figure:
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

    @property
    def chain(self) -> Chain:
        """All strokes over one arc length."""
        return Chain(self.strokes)

    @property
    def length(self) -> float:
        """Arc length of all strokes. [m]"""
        return self.chain.length

    @property
    def closed(self) -> bool:
        """Whether it ends where it begins; a line run there and back does."""
        start, end = self.position([0.0, self.length])
        return bool(np.linalg.norm(end - start) <= 1e-9 * self.length)

    def position(self, s: npt.ArrayLike) -> Array:
        """Return the points (N, 3) at arc lengths s (N,) from the figure's start. [m]"""
        return self.chain.at(np.atleast_1d(np.asarray(s, dtype=np.float64)))[0]

    def tangent(self, s: npt.ArrayLike) -> Array:
        """Return the unit tangents (N, 3) at arc lengths s (N,)."""
        return self.chain.at(np.atleast_1d(np.asarray(s, dtype=np.float64)))[1]


@dataclass(frozen=True, eq=False)
class Leg:
    """A part of a test path that is run from rest to rest.

    Attributes
    ----------
    figure
        Index of the figure it belongs to, -1 for a transfer.
    curve
        Where it runs.
    offset
        Arc length of the figure at which the leg begins. [m]
    """

    figure: int
    curve: Curve
    offset: float = 0.0


@dataclass(frozen=True, eq=False)
class TestPath:
    """Figures joined by straight transfers to one closed cycle, so that cycles can be repeated.

    Attributes
    ----------
    figures
        In the order in which they are run.
    home
        Where a cycle begins and ends, (3,). [m]

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
    chain: Chain = field(init=False)

    def __post_init__(self) -> None:
        if not self.figures:
            raise ParameterError("a test path without figures measures nothing; pass at least one figure.")
        object.__setattr__(self, "legs", _legs(self.figures, np.asarray(self.home, dtype=np.float64)))
        object.__setattr__(self, "chain", Chain([leg.curve for leg in self.legs]))

    @property
    def length(self) -> float:
        """Arc length of one cycle. [m]"""
        return self.chain.length

    @property
    def rests(self) -> Array:
        """Arc lengths at which the path rests, start and end of the cycle included, (legs + 1,). [m]"""
        return np.concatenate(([0.0], self.chain.ends))

    def position(self, s: npt.ArrayLike) -> Array:
        """Return the points (N, 3) at arc lengths s (N,) from the start of the cycle. [m]"""
        return self.chain.at(np.atleast_1d(np.asarray(s, dtype=np.float64)))[0]

    def tangent(self, s: npt.ArrayLike) -> Array:
        """Return the unit tangents (N, 3) at arc lengths s (N,)."""
        return self.chain.at(np.atleast_1d(np.asarray(s, dtype=np.float64)))[1]

    def figure(self, s: npt.ArrayLike) -> npt.NDArray[np.int64]:
        """Return the index of the figure at arc lengths s (N,), -1 on a transfer; at a rest point the next leg's."""
        of_leg = np.array([leg.figure for leg in self.legs], dtype=np.int64)
        return of_leg[self.chain.index(np.atleast_1d(np.asarray(s, dtype=np.float64)))]


def _legs(figures: tuple[Figure, ...], home: Array) -> tuple[Leg, ...]:
    """Return the legs of a cycle: home, the figures in order with transfers between them, home."""
    legs: list[Leg] = []
    here = home
    for index, figure in enumerate(figures):
        start, end = figure.position([0.0, figure.length])
        legs += _transfer(here, start)
        offset = 0.0
        for stroke in figure.strokes:
            legs.append(Leg(index, stroke, offset))
            offset += stroke.length
        here = end
    return (*legs, *_transfer(here, home))


def _transfer(start: Array, end: Array) -> list[Leg]:
    if np.linalg.norm(end - start) < 1e-9:
        return []
    return [Leg(TRANSFER, Straight(start, end))]
