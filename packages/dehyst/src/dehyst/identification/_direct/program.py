"""Convex program of a direct inverse: rising polynomials, nonnegative weights, small ridge."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cache
from math import comb

import numpy as np
import numpy.typing as npt
from numpy.polynomial import Polynomial

import dehyst._native as _native
from dehyst.arrays import Array
from dehyst.identification._direct.data import DirectData, DirectPiece
from dehyst.least_squares import solve_bounded, triangle

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
    """Which terms a direct inverse has."""

    degree: int = 3  # Of the polynomial of the output, 1, 3, 5 or 7
    groups: tuple[str, ...] = ("stops",)  # Which of `GROUPS` it has; always "stops"
    # Whether the weights change with the output itself, for loops that are not symmetric
    by_output: bool = False
    start: str = "unknown"  # Memory before the first sample

    def with_group(self, group: str) -> Shape:
        """The same with one more group of terms."""
        return replace(self, groups=tuple(name for name in GROUPS if name in {*self.groups, group}))

    @property
    def words(self) -> str:
        """In words, for tables."""
        ending = ""
        if self.by_output:
            ending = ", by output"
        names = ["stops", *(name for name in self.groups if name != "stops")]
        return f"degree {self.degree}, {' + '.join(names)}{ending}"


class Layout:
    """Where the columns of every shape stand in a row: [powers of y of every part | terms of every set | u].

    The polynomial has one part, or two for every given schedule, at its lower and its upper end. Terms are stored for
    both sets of a schedule of the output, of which the one set without it is the sum, then for those of given ones.
    """

    def __init__(self, bank: Bank, schedules: int) -> None:
        self.bank, self.schedules = bank, schedules
        self.sizes = {
            "stops": bank.radii.size,
            "path": bank.lengths.size,
            "creep": bank.time_constants.size,
            "viscous": 1,
        }
        self.parts = max(1, 2 * schedules)
        self.powers = DEGREES[-1] + 1
        self.polynomials = self.powers * self.parts
        self.terms = sum(self.sizes.values())
        self.width = self.polynomials + (2 + 2 * schedules) * self.terms + 1

    @property
    def constants(self) -> list[int]:
        """Parts whose constant is an unknown: 1 - xi of a second schedule adds none."""
        if not self.schedules:
            return [0]
        return [0, 1, *range(3, self.parts, 2)]

    def terms_of(self, shape: Shape) -> Indices:
        """Places of the terms of a shape within a set."""
        places, begin = [np.zeros(0, dtype=np.int64)], 0
        for name in GROUPS:
            if name in shape.groups:
                places.append(np.arange(begin, begin + self.sizes[name]))
            begin += self.sizes[name]
        return np.concatenate(places)

    def sets_of(self, shape: Shape) -> list[list[int]]:
        """Return the sets of a shape, those of the output first: each as a list of the stored sets that it sums."""
        outer = [[2 + k] for k in range(2 * self.schedules)]
        if shape.by_output:
            return [[0], [1], *outer]
        return outer or [[0, 1]]

    def select(self, shape: Shape, rows: Array) -> Array:
        """System [constants | slopes of the polynomials, terms | u] of a shape.

        `rows` are full rows, or their triangle.
        """
        terms, rising = self.terms_of(shape), rising_powers(shape.degree)
        columns = []
        for part in self.constants:
            columns.append(rows[:, self.powers * part])
        for part in range(self.parts):
            begin = self.powers * part
            columns.append(rows[:, begin : begin + shape.degree + 1] @ rising)
        for parts in self.sets_of(shape):
            sets = [rows[:, self.polynomials + part * self.terms + terms] for part in parts]
            columns.append(np.sum(sets, axis=0))
        return np.column_stack([*columns, rows[:, -1]])


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


def terms_along(
    layout: Layout, piece: DirectPiece, start: str, every: int = 1
) -> Iterator[tuple[slice, Array]]:
    """What every term of one set would contribute along a piece, (m, terms), and where, in parts for the cache.

    Stops are those of the middle of what is admissible. `every`: the share of rows that are needed, for longer parts.
    """
    y, constants = np.ascontiguousarray(piece.y), layout.bank.time_constants
    clock = np.arange(y.size, dtype=np.float64)
    if piece.time is not None:
        clock = np.ascontiguousarray(piece.time)
    bank = (layout.bank.radii, layout.bank.lengths, constants, start != "unknown")
    past = past_of(start)
    memory = None
    if past.size:
        memory = _native.direct_bank(past, np.zeros(past.size), *bank)[1]
        # Creep is at rest at the first sample, whatever turned before.
        memory[1] = clock[0]
        memory[memory.size - constants.size :] = y[0]
    for begin in range(0, y.size, ROWS * every):
        part = slice(begin, min(begin + ROWS * every, y.size))
        walked, memory = _native.direct_bank(y[part], clock[part], *bank, memory)
        yield part, np.column_stack([walked, piece.rate[part]])


def rows_at(layout: Layout, piece: DirectPiece, terms: Array, at: slice | Indices) -> Array:
    """All columns at some samples of a piece, (m, width); `terms` are those there."""
    y, schedules = piece.y[at], tuple(xi[at] for xi in piece.shares)
    out = np.empty((y.size, layout.width))
    powers = powers_of(y, layout.powers)
    for part, share in enumerate(set_shares(schedules) or [np.ones(y.size)]):
        out[:, layout.powers * part : layout.powers * (part + 1)] = share[:, None] * powers
    for place, share in enumerate(set_shares((by_output(y), *schedules))):
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
    shares = []
    for xi in schedules:
        shares += [1.0 - xi, xi]
    return shares


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


# Square of the weight of each non-negative unknown, whose column is scaled to rms 1, relative to a sample. It keeps
# terms that are nearly alike from trading weight; it costs nothing that could be measured.
RIDGE = 1e-6
# Smallest slope of the polynomial, of input range over output range: the input rises with the output, whatever the
# past.
SMALLEST_SLOPE = 0.05


@dataclass(frozen=True)
class DirectEstimate:
    """Solution of one shape, scaled."""

    shape: Shape
    unknowns: Array  # As in the program: constants, slopes, weights
    polynomials: Array  # (parts, degree + 1), powers of y
    weights: Array  # (sets, terms) of the shape
    kkt_residual: float  # Largest violation of the optimality conditions


def solve_shape(
    layout: Layout, shape: Shape, system: Array, samples: int, ridge: float = RIDGE
) -> DirectEstimate:
    """Solve the program of a shape for its rows, or triangles of them stacked, that stand for `samples` samples."""
    free = len(layout.constants)
    slopes = layout.parts * shape.degree
    terms = system.shape[1] - 1 - free - slopes
    rms = np.sqrt(np.sum(system[:, free + slopes : -1] ** 2, axis=0) / max(samples, 1))
    penalty = np.zeros((terms, system.shape[1]))
    penalty[:, free + slopes : -1] = np.diag(np.sqrt(ridge * samples) * rms)
    # Parts of several given schedules are summed: each gives its share of the slope.
    lower = np.zeros(slopes + terms)
    lower[:slopes] = SMALLEST_SLOPE / max(1, layout.schedules)
    solution = solve_bounded(np.vstack([system, penalty]), free, lower)
    polynomials = (
        solution.bounded[:slopes].reshape(layout.parts, shape.degree)
        @ rising_powers(shape.degree).T
    )
    polynomials[layout.constants, 0] += solution.free
    unknowns = np.concatenate([solution.free, solution.bounded])
    weights = solution.bounded[slopes:].reshape(
        len(layout.sets_of(shape)), layout.terms_of(shape).size
    )
    return DirectEstimate(shape, unknowns, polynomials, weights, solution.kkt_residual)


def rms_on(layout: Layout, estimate: DirectEstimate, reduced: Array, samples: int) -> float:
    """RMS of the residual of an estimate on rows, or on the triangle of rows, that stand for `samples` samples."""
    left = layout.select(estimate.shape, reduced) @ np.append(estimate.unknowns, -1.0)
    return float(np.sqrt(left @ left / max(samples, 1)))


@dataclass(frozen=True)
class RowBlock:
    """Consecutive fitted rows, or their triangle, and the number of samples they stand for."""

    rows: Array
    samples: int


def reduced_blocks(parts: Iterable[Array], samples: int, blocks: int) -> list[RowBlock]:
    """Cut `samples` rows, which come in parts, into consecutive blocks, each reduced to its triangle."""
    edges = np.linspace(0, samples, blocks + 1).round().astype(int).tolist()
    finished: list[RowBlock] = []
    gathered, place = np.zeros((0, 0)), 0
    for part in parts:
        rows = part
        while rows.shape[0]:
            begin, end = edges[len(finished)], edges[len(finished) + 1]
            count = min(rows.shape[0], end - place)
            head = rows[:count]
            if gathered.size:
                head = np.vstack([gathered, head])
            gathered = _reduced(head)
            rows = rows[count:]
            place += count
            if place == end:
                finished.append(RowBlock(gathered, end - begin))
                gathered = np.zeros((0, 0))
    return finished


def _reduced(rows: Array) -> Array:
    if rows.shape[0] > rows.shape[1]:
        return triangle(rows)
    return rows


def _joined(blocks: list[RowBlock]) -> RowBlock:
    """One block of several."""
    rows = np.concatenate([block.rows for block in blocks])
    return RowBlock(rows, sum(block.samples for block in blocks))


def merged(blocks: list[RowBlock], together: int) -> list[RowBlock]:
    """Fewer and larger blocks: always so many of them together."""
    return [_joined(blocks[k : k + together]) for k in range(0, len(blocks), together)]


def without(blocks: list[RowBlock], left_out: int) -> tuple[Array, int]:
    """Rows of all blocks but one, and their number of samples."""
    remainder = _joined(blocks[:left_out] + blocks[left_out + 1 :])
    return remainder.rows, remainder.samples


def held_out(layout: Layout, shape: Shape, blocks: list[RowBlock]) -> Array:
    """RMS on every block of the fit to the others, scaled, (blocks,)."""
    errors = []
    for k, block in enumerate(blocks):
        rows, samples = without(blocks, k)
        estimate = solve_shape(layout, shape, layout.select(shape, rows), samples)
        errors.append(rms_on(layout, estimate, block.rows, block.samples))
    return np.array(errors)


def predict(
    layout: Layout, estimate: DirectEstimate, piece: DirectPiece, terms: Array, at: slice
) -> Array:
    """Scaled input that an estimate asks for at some samples of a piece, (m,), from the terms there."""
    y, schedules = piece.y[at], tuple(xi[at] for xi in piece.shares)
    powers = powers_of(y, estimate.shape.degree + 1)
    chosen = terms[:, layout.terms_of(estimate.shape)]
    stored = set_shares((by_output(y), *schedules))
    curves = (powers @ estimate.polynomials.T).T
    weighted = (chosen @ estimate.weights.T).T
    products = []
    for share, values in zip(set_shares(schedules) or [np.ones(y.size)], curves, strict=True):
        products.append(share * values)
    for parts, values in zip(layout.sets_of(estimate.shape), weighted, strict=True):
        products.append(np.sum([stored[k] for k in parts], axis=0) * values)
    asked: Array = np.sum(products, axis=0)
    return asked
