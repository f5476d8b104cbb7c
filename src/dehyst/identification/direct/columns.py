"""Columns of the program of a direct inverse: what each term would contribute with weight 1, scaled."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache
from math import comb

import numpy as np
import numpy.typing as npt
from numpy.polynomial import Polynomial

import dehyst._native as _native
from dehyst.arrays import Array
from dehyst.identification.direct.data import DirectData, DirectPiece

Indices = npt.NDArray[np.int64]

# Memory before the first sample. "unknown": every stop keeps its lowest and highest admissible state.
STARTS = ("unknown", "rest", "rising", "falling")
DEGREES = (1, 3, 5, 7)
# Rows that are made at a time.
ROWS = 4096
# Groups of terms of a shape, in the order of columns.
GROUPS = ("stops", "path", "creep", "viscous")
# Radii and path lengths, of the half range of the output. None is larger than the range that was visited: beyond it a
# stop is a straight line and trades its weight with the polynomial.
RADII = np.geomspace(0.004, 0.95, 30)
LENGTHS = np.geomspace(0.03, 1.5, 9)


@dataclass(frozen=True)
class Bank:
    """Radii (n,), path lengths (k,), both scaled, and time constants (m,) [s] that are offered."""

    radii: Array
    lengths: Array
    time_constants: Array


@dataclass(frozen=True)
class Shape:
    """Which terms a direct inverse has.

    Attributes
    ----------
    degree
        Of the polynomial of the output, 1, 3, 5 or 7.
    groups
        Which of `GROUPS` it has; always "stops".
    by_output
        Whether the weights change with the output itself, for loops that are not symmetric.
    start
        Memory before the first sample.
    """

    degree: int = 3
    groups: tuple[str, ...] = ("stops",)
    by_output: bool = False
    start: str = "unknown"

    def with_group(self, group: str) -> Shape:
        """The same with one more group of terms."""
        return replace(self, groups=tuple(name for name in GROUPS if name in {*self.groups, group}))

    @property
    def words(self) -> str:
        """In words, for tables."""
        more = " + ".join(name for name in self.groups if name != "stops")
        return f"degree {self.degree}, stops{' + ' if more else ''}{more}" + (", by output" if self.by_output else "")


class Layout:
    """Where the columns of every shape stand in a row: [powers of y of every part | terms of every set | u].

    The polynomial has one part, or two for every given schedule, at its lower and its upper end. Terms are stored for
    both sets of a schedule of the output, of which the one set without it is the sum, then for those of given ones.
    """

    def __init__(self, bank: Bank, given: int) -> None:
        self.bank, self.given = bank, given
        self.sizes = {
            "stops": bank.radii.size,
            "path": bank.lengths.size,
            "creep": bank.time_constants.size,
            "viscous": 1,
        }
        self.parts = max(1, 2 * given)
        self.powers = DEGREES[-1] + 1
        self.polynomials = self.powers * self.parts
        self.terms = sum(self.sizes.values())
        self.width = self.polynomials + (2 + 2 * given) * self.terms + 1

    @property
    def constants(self) -> list[int]:
        """Parts whose constant is an unknown: 1 - xi of a second schedule adds none."""
        return [0, 1, *range(3, self.parts, 2)] if self.given else [0]

    def terms_of(self, shape: Shape) -> Indices:
        """Places of the terms of a shape within a set."""
        places, begin = [np.zeros(0, dtype=np.int64)], 0
        for name in GROUPS:
            if name in shape.groups:
                places.append(np.arange(begin, begin + self.sizes[name]))
            begin += self.sizes[name]
        return np.concatenate(places)

    def sets_of(self, shape: Shape) -> list[list[int]]:
        """Sets of a shape: each as the stored ones that it is the sum of. The output's come first."""
        given = [[2 + k] for k in range(2 * self.given)]
        if shape.by_output:
            return [[0], [1], *given]
        return given or [[0, 1]]

    def select(self, shape: Shape, rows: Array) -> Array:
        """System [constants | slopes of the polynomials, terms | u] of a shape.

        `rows` are full rows, or their triangle.
        """
        terms, rising = self.terms_of(shape), rising_powers(shape.degree)
        powers = [rows[:, self.powers * part : self.powers * (part + 1)] for part in range(self.parts)]
        constants = [powers[part][:, 0] for part in self.constants]
        slopes = [part[:, : shape.degree + 1] @ rising for part in powers]
        bounded = [
            np.sum([rows[:, self.polynomials + part * self.terms + terms] for part in parts], axis=0)
            for parts in self.sets_of(shape)
        ]
        return np.column_stack([*constants, *slopes, *bounded, rows[:, -1]])


@cache
def rising_powers(degree: int) -> Array:
    """Coefficients (degree + 1, degree) of polynomials that rise from -1 to 1: integrals of Bernstein's of degree - 1.

    A sum of them with non-negative weights rises everywhere between, and weights not below eps make it rise by eps at
    least: their derivatives add up to 1.
    """
    columns = np.zeros((degree + 1, degree))
    up, down = Polynomial([0.5, 0.5]), Polynomial([0.5, -0.5])
    for j in range(degree):
        rising = (comb(degree - 1, j) * up**j * down ** (degree - 1 - j)).integ(lbnd=-1.0)
        columns[: rising.coef.size, j] = rising.coef
    return columns


def past_of(start: str) -> Array:
    """Turning points before the first sample that its memory is of: both extremes, or none."""
    return np.array({"rising": [1.0, -1.0], "falling": [-1.0, 1.0]}.get(start, []))


def terms_along(layout: Layout, piece: DirectPiece, start: str, every: int = 1) -> Iterator[tuple[slice, Array]]:
    """What every term of one set would contribute along a piece, (m, terms), and where, in parts for the cache.

    Stops are those of the middle of what is admissible. `every`: the share of rows that are needed, for longer parts.
    """
    y, known, own = np.ascontiguousarray(piece.y), start != "unknown", layout.bank
    clock = np.arange(y.size, dtype=np.float64) if piece.time is None else np.ascontiguousarray(piece.time)
    bank, past, memory = (own.radii, own.lengths, own.time_constants, known), past_of(start), None
    if past.size:  # creep is at rest at the first sample, whatever turned before
        memory = _native.direct_bank(past, np.zeros(past.size), *bank)[1]
        memory[1], memory[memory.size - own.time_constants.size :] = clock[0], y[0]
    for begin in range(0, y.size, ROWS * every):
        part = slice(begin, min(begin + ROWS * every, y.size))
        walked, memory = _native.direct_bank(y[part], clock[part], *bank, memory)
        yield part, np.column_stack([walked, piece.rate[part]])


def rows_at(layout: Layout, piece: DirectPiece, terms: Array, at: slice | Indices) -> Array:
    """All columns at some samples of a piece, (m, width); `terms` are those there."""
    y, given = piece.y[at], tuple(xi[at] for xi in piece.given)
    out = np.empty((y.size, layout.width))
    powers = powers_of(y, layout.powers)
    for part, share in enumerate(set_shares(given) or [np.ones(y.size)]):
        out[:, layout.powers * part : layout.powers * (part + 1)] = share[:, None] * powers
    for place, share in enumerate(set_shares((by_output(y), *given))):
        begin = layout.polynomials + place * layout.terms
        np.multiply(terms, share[:, None], out=out[:, begin : begin + layout.terms])
    out[:, -1] = piece.u[at]
    return out


def by_output(y: Array) -> Array:
    """Share of the upper end of the schedule of the output, (T,)."""
    share: Array = np.clip(0.5 * (y + 1.0), 0.0, 1.0)
    return share


def set_shares(schedules: tuple[Array, ...]) -> list[Array]:
    """Factor of both sets of every schedule, (T,) each: 1 - xi and xi."""
    return [part for xi in schedules for part in (1.0 - xi, xi)]


def powers_of(y: Array, count: int) -> Array:
    """y^0, y^1, ... (T, count), held beyond the fitted range."""
    return np.vander(np.clip(y, -1.0, 1.0), count, increasing=True)


def fitted_rows(layout: Layout, data: DirectData, start: str, every: int = 1) -> Iterator[Array]:
    """All columns of the fitted samples, or of every so manieth of them, in parts that fit into the cache."""
    for piece in data.pieces:
        fitted = np.flatnonzero(piece.mask(True))[::every]
        for part, terms in terms_along(layout, piece, start, every):
            if part.start >= piece.split:
                break
            at = fitted[slice(*np.searchsorted(fitted, [part.start, part.stop]))]
            yield rows_at(layout, piece, terms[at - part.start], at)
