"""Regressor columns of a sum of elements: each rises or stays constant with the present sample.

A column reads one element e of one memory cell::

    column = gain ramp(e; low, high) + ramp(x; x_low, x_high),    ramp(v; a, b) = clip(v, a, b) - clip(0, a, b)

or, of two lags that do not know the present sample, their product within the range, with either sign,

so that weights from 0 on give a sum that rises with x: that is all the program needs to know. Ramps of x alone, of
plays (their two thresholds make them the cells of a Preisach operator), of x less what follows it (stops, relaxation),
of lags in time (creep; viscous plays, whose loop widens with the rate), of the rate up to where it saturates
(dampers), of Dahl's lag along the way.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array
from dehyst.families.elements import NO_MAP, Element, Pairs

Numbers = npt.NDArray[np.int64]

RADII = (0.01, 0.02, 0.035, 0.05, 0.075, 0.1, 0.14, 0.18, 0.23, 0.28, 0.34, 0.4, 0.47, 0.55, 0.65, 0.75, 0.85, 0.95)
# of plays and stops without ramps: of a loop with few of them each lies within 2 % of the half range of one of these
THRESHOLDS = tuple(np.concatenate([np.geomspace(0.004, 0.09, 12), np.linspace(0.11, 0.98, 28)]).tolist())
FINE = (-0.8, -0.5, -0.2, 0.2, 0.5, 0.8)  # between ramps of plays: seven
COARSE = (-0.4, 0.4)  # between ramps of lags: three
CREEP_RADII = (0.0, 0.1, 0.3)
CREEP_TIMES, VISCOUS_TIMES, LAG_TIMES = 14, 6, 6
WAYS = tuple(np.geomspace(0.02, 1.5, 16).tolist())
RELAXED = 16.0
RATE_LAGS = (1.0, 3.0, 10.0)  # samples
SATURATIONS = (0.1, 0.2, 0.4, 0.7, 1.0, 1.5, 3.0)  # of the rate that 95 % of the samples keep below
EVERYWHERE = (-np.inf, np.inf)
WITHIN = (-1.0, 1.0)  # the range that was fitted
NOWHERE = (0.0, 0.0)
NO_CELL = -1

Part = tuple[float, float]


class Line(NamedTuple):
    """A column by its numbers: cell, gain, ramp of the cell, ramp of x; or the cell of the other factor."""

    cell: int
    gain: float
    part: Part = EVERYWHERE
    x_part: Part = NOWHERE
    other: int = NO_CELL


@dataclass(frozen=True)
class Pace:
    """What columns of time are made for.

    Attributes
    ----------
    period
        Usual time between samples. [s]
    duration
        Of the longest stretch. [s]
    moves
        How far x goes from each lag of `RATE_LAGS`, of 95 % of the samples.
    """

    period: float
    duration: float
    moves: tuple[float, ...]


@dataclass(frozen=True, eq=False)
class Columns:
    """A table of columns over memory cells; the first cell is x itself.

    Attributes
    ----------
    cells
        Elements of weight 1 without a map.
    group
        Name of the group of each column, (p,).
    cell, gain, low, high, x_low, x_high
        Of each column, (p,).
    neighbours
        Pairs of columns whose weights should differ little, (q, 2).
    other
        Cell of the second factor of a product, `NO_CELL` of other columns, (p,).
    """

    cells: tuple[Element, ...]
    group: npt.NDArray[np.str_]
    cell: Numbers
    gain: Array
    low: Array
    high: Array
    x_low: Array
    x_high: Array
    neighbours: Numbers
    other: Numbers

    def values(self, e: Array) -> Array:
        """Columns (T, p) of elements (T, cells)."""
        found = self.gain * _ramp(e[:, self.cell], self.low, self.high)
        pairs = np.flatnonzero(self.other != NO_CELL)
        found[:, pairs] *= np.clip(e[:, self.other[pairs]], *WITHIN)
        both = np.flatnonzero(self.x_high > self.x_low)
        found[:, both] += _ramp(e[:, :1], self.x_low[both], self.x_high[both])
        return np.asarray(found)

    def of(self, groups: Sequence[str]) -> Numbers:
        """Which columns are those of groups, and x."""
        return np.flatnonzero(np.isin(self.group, ("x", *groups)))

    def elements(self, weight: Array) -> tuple[Element, ...]:
        """The elements of a sum with weights (p,) of the columns; those of weight 0 are left out."""
        made = []
        for number, cell in enumerate(self.cells):
            own = np.flatnonzero((self.cell == number) & (self.other == NO_CELL) & (weight != 0.0))
            ramps = [(weight[k] * self.gain[k], self.low[k], self.high[k]) for k in own]
            if number == 0:
                both = np.flatnonzero((self.x_high > self.x_low) & (weight != 0.0))
                ramps += [(weight[k], self.x_low[k], self.x_high[k]) for k in both]
            if ramps:
                slope, pairs = _sum_of(ramps)
                made.append(Element(cell.kind, cell.radius, cell.time, slope, pairs))
        return (*made, *self._products(weight))

    def _products(self, weight: Array) -> Iterator[Element]:
        """Products with weight, in chains: each reads the lag of the next one."""
        left: dict[int, dict[int, float]] = {}
        for k in np.flatnonzero((self.other != NO_CELL) & (weight != 0.0)).tolist():
            one, other = int(self.cell[k]), int(self.other[k])
            own = left.setdefault(one, {})
            left.setdefault(other, {})[one] = own[other] = own.get(other, 0.0) + float(weight[k] * self.gain[k])
        for begin in left:
            at = begin
            while left[at]:
                other = min(left[at])
                value = left[at].pop(other)
                left[other].pop(at, None)
                yield Element("product", 1.0, self.cells[at].time, value)
                at = other
                if not left[at]:
                    yield Element("past", 0.0, self.cells[at].time, 0.0)
                    at = begin


def _ramp(v: Array, low: Array, high: Array) -> Array:
    return np.asarray(np.clip(v, low, high) - np.clip(0.0, low, high))


def _sum_of(ramps: Sequence[tuple[float, float, float]]) -> tuple[float, Pairs]:
    """Weight and map of a sum of ramps; a line has no map."""
    weight, low, high = (np.array(values) for values in zip(*ramps, strict=True))
    ends = np.concatenate([low, high])
    knots = np.unique(ends[np.isfinite(ends)])
    if not knots.size:
        return float(weight.sum()), NO_MAP
    u = np.concatenate([knots[:1] - 1.0, knots, knots[-1:] + 1.0])
    v = _ramp(u[:, None], low, high) @ weight
    return 1.0, (tuple(u.tolist()), tuple(v.tolist()))


def columns_of(groups: Sequence[str], ramps: int, pace: Pace | None) -> Columns:
    """Return the columns of x, in so many ramps, and of groups; `pace` None: without time."""
    cells, lines = [Element("input")], list[Line]()
    names, joined = list[str](), list[tuple[int, int]]()
    inner = np.linspace(-1.0, 1.0, ramps + 1)[1:-1].tolist()
    made: list[tuple[str, list[Element], list[Line], int]] = [
        ("x", [], [Line(0, 1.0, part) for part in _parts(inner)], ramps)
    ]
    for name in groups:
        new, own, chain = GROUPS[name](pace)
        made.append((name, new, [_shifted(line, len(cells) + sum(len(m[1]) for m in made)) for line in own], chain))
    for name, new, own, chain in made:
        first = len(lines)
        joined += [(k, k + 1) for k in range(first, first + len(own) - 1) if (k - first) % chain < chain - 1]
        cells += new
        lines += own
        names += [name] * len(own)
    cell, gain, own_part, x_part, other = zip(*lines, strict=True)
    low, high = np.array(own_part).T
    x_low, x_high = np.array(x_part).T
    pairs = np.array(joined, dtype=np.int64).reshape(-1, 2)
    return Columns(
        tuple(cells), np.array(names), np.array(cell), np.array(gain), low, high, x_low, x_high, pairs, np.array(other)
    )


def _shifted(line: Line, by: int) -> Line:
    return line._replace(cell=line.cell + by, other=line.other if line.other == NO_CELL else line.other + by)


def _parts(inner: Sequence[float]) -> list[Part]:
    """Parts of the real line between inner points."""
    return list(zip((-np.inf, *inner), (*inner, np.inf), strict=True))


Group = tuple[list[Element], list[Line], int]  # cells, lines (numbered among these cells), length of a chain


def _plain(cells: list[Element]) -> Group:
    return cells, [Line(k, 1.0) for k in range(len(cells))], 1


def _plays(pace: Pace | None) -> Group:
    return _plain([Element("play", r) for r in THRESHOLDS])


def _stops(pace: Pace | None) -> Group:
    return _plain([Element("stop", r) for r in THRESHOLDS])


def _paths(pace: Pace | None) -> Group:
    return _plain([Element("path", r) for r in WAYS])


def _lagging(pace: Pace | None) -> Group:
    cells = [Element("play", r) for r in RADII]
    return cells, [Line(k, 1.0, part) for k in range(len(RADII)) for part in _parts(FINE)], len(FINE) + 1


def _leading(pace: Pace | None) -> Group:
    """What a ramp of x has more than that of a play, wide enough that the difference never falls."""
    cells = [Element("play", r) for r in RADII]
    lines = [
        Line(k, -1.0, (a, b), (round(a - r, 9), round(b + r, 9))) for k, r in enumerate(RADII) for a, b in _parts(FINE)
    ]
    return cells, lines, len(FINE) + 1


def _creep(pace: Pace | None) -> Group:
    assert pace is not None
    times = np.geomspace(2.0 * pace.period, max(pace.duration, 4.0 * pace.period), CREEP_TIMES).tolist()
    return _plain([Element("creep", r, time) for time in times for r in CREEP_RADII])


def _viscous(pace: Pace | None) -> Group:
    assert pace is not None
    times = np.geomspace(pace.period, max(pace.duration / 20.0, 2.0 * pace.period), VISCOUS_TIMES).tolist()
    return _plain([Element("creep", r, time) for time in times for r in RADII[2::3]])


def _lag_times(pace: Pace | None, passed: float = 2.0) -> list[float]:
    """Time constants of lags, the longest passed so often within the training."""
    assert pace is not None
    longest = max(pace.duration / passed, 6.0 * pace.period)
    return [float(t) for t in np.geomspace(3.0 * pace.period, longest, LAG_TIMES)]


def _creep_by_place(pace: Pace | None) -> Group:
    times = _lag_times(pace)
    lines = [Line(k, 1.0, part) for k in range(len(times)) for part in _parts(COARSE)]
    return [Element("creep", 0.0, time) for time in times], lines, len(COARSE) + 1


def _relaxing(pace: Pace | None) -> Group:
    # A longer lag is a drift, which the solution of an inverse row goes on with beyond what was fitted.
    return _plain([Element("relax", 0.0, time) for time in _lag_times(pace, RELAXED)])


def _relaxing_by_place(pace: Pace | None) -> Group:
    times = _lag_times(pace)
    lines = [Line(k, -1.0, part, part) for k in range(len(times)) for part in _parts(COARSE)]
    return [Element("past", 0.0, time) for time in times], lines, len(COARSE) + 1


def _rates(pace: Pace | None) -> Group:
    assert pace is not None
    lines = [Line(k, 1.0 / s, (-s, s)) for k, move in enumerate(pace.moves) for s in (move * q for q in SATURATIONS)]
    return [Element("relax", 0.0, samples * pace.period) for samples in RATE_LAGS], lines, 1


def _products(pace: Pace | None) -> Group:
    times = _lag_times(pace)
    pairs = [(i, j) for i in range(len(times)) for j in range(i, len(times))]
    lines = [Line(i, sign, WITHIN, other=j) for i, j in pairs for sign in (1.0, -1.0)]
    return [Element("past", 0.0, time) for time in times], lines, 1


GROUPS: dict[str, Callable[[Pace | None], Group]] = {
    "play": _plays,
    "stop": _stops,
    "path": _paths,
    "lag": _lagging,
    "lead": _leading,
    "creep": _creep,
    "viscous": _viscous,
    "creep-by-place": _creep_by_place,
    "relax": _relaxing,
    "relax-by-place": _relaxing_by_place,
    "rate": _rates,
    "product": _products,
}
