"""Regressor columns of a sum of elements: each rises or stays constant with the present sample.

A column reads the element e of one memory cell::

    column = gain ramp(e; low, high) + ramp(x; x_low, x_high),    ramp(v; a, b) = clip(v, a, b) - clip(0, a, b)

or is the product of two lags that do not know the present sample, within the range, with either sign.

So weights that are not negative give a sum that rises with x; the program needs to know nothing else. There are ramps

- of x alone,
- of plays (with their two thresholds they are the cells of a Preisach operator),
- of x less what follows it (stops, relaxation),
- of lags in time (creep; viscous plays, whose loop widens with the rate),
- of the rate, up to where it saturates (dampers),
- of Dahl's lag along the way.

With a schedule xi, from 0 to 1, every column stands there twice, times 1 - xi and times xi, so that its weight goes
from one value to another with the schedule; and a level goes with xi. Two schedules add up.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

import dehyst._native as _native
from dehyst.arrays import Array
from dehyst.families._elements import NO_MAP, Element, Pairs

Numbers = npt.NDArray[np.int64]
Marks = npt.NDArray[np.bool_]

# Radii of plays with ramps. [half ranges]
RADII = (
    0.01, 0.02, 0.035, 0.05, 0.075, 0.1, 0.14, 0.18, 0.23,
    0.28, 0.34, 0.4, 0.47, 0.55, 0.65, 0.75, 0.85, 0.95,
)  # fmt: skip
# Radii of plays and stops without ramps. A loop with few plays has each of them within 2 % of the half range of one
# of these.
THRESHOLDS = tuple(
    np.concatenate([np.geomspace(0.004, 0.09, 12), np.linspace(0.11, 0.98, 28)]).tolist()
)
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
LEVEL = "level"  # group of columns that are constant but for their schedule
CONSTANT: Pairs = ((-1.0, 1.0), (1.0, 1.0))

Part = tuple[float, float]


class Line(NamedTuple):
    """A column by its numbers: cell, gain, ramp of the cell, ramp of x; or the cell of the other factor."""

    cell: int
    gain: float
    part: Part = EVERYWHERE
    x_part: Part = NOWHERE
    second: int = NO_CELL


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
    second
        Cell of the second factor of a product, `NO_CELL` of other columns, (p,).
    share
        What each column is multiplied by, (p,): 0 for 1, 2 v + 1 for 1 - xi of schedule v, 2 v + 2 for xi.
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
    second: Numbers
    share: Numbers

    @cached_property
    def _numbers(self) -> Array:
        return np.stack([self.gain, self.low, self.high, self.x_low, self.x_high])

    def values(self, e: Array, xi: Array | None = None, out: Array | None = None) -> Array:
        """Columns (T, p) of elements (T, cells), at schedules (T, schedules); in `out`, if there is one."""
        values = np.empty((len(e), self.cell.size)) if out is None else out
        _native.ramps(e, self.cell, self._numbers, values)
        products = np.flatnonzero(self.second != NO_CELL)
        if products.size:
            values[:, products] *= np.clip(e[:, self.second[products]], *WITHIN)
        if xi is not None and xi.shape[1]:
            levels = np.flatnonzero(self.group == LEVEL)
            values[:, levels] = self.gain[levels]
            values *= shares(xi)[:, self.share]
        return values

    def of(self, groups: Sequence[str]) -> Numbers:
        """Which columns are those of groups, x, and levels of schedules."""
        return np.flatnonzero(np.isin(self.group, ("x", LEVEL, *groups)))

    def take(self, columns: Numbers) -> Columns:
        """Return a table of some of these columns, increasing, and of the cells that they read."""
        cells = np.unique(np.append([0, *self.cell[columns]], self._second_cells(columns)))
        number = np.full(len(self.cells) + 1, NO_CELL)
        number[cells] = np.arange(cells.size)
        place = np.full(self.cell.size, -1)
        place[columns] = np.arange(columns.size)
        neighbours = place[self.neighbours]
        return Columns(
            cells=tuple(self.cells[cell] for cell in cells),
            group=self.group[columns],
            cell=number[self.cell[columns]],
            gain=self.gain[columns],
            low=self.low[columns],
            high=self.high[columns],
            x_low=self.x_low[columns],
            x_high=self.x_high[columns],
            neighbours=neighbours[np.all(neighbours >= 0, axis=1)],
            second=number[self.second[columns]],
            share=self.share[columns],
        )

    def _second_cells(self, columns: Numbers) -> Numbers:
        second = self.second[columns]
        return np.asarray(second[second != NO_CELL])

    def elements(self, weight: Array) -> tuple[Element, ...]:
        """The elements of a sum with weights (p,) of the columns; those of weight 0 are left out."""
        elements: list[Element] = []
        for share in range(int(self.share.max()) + 1):
            carries = (weight != 0.0) & (self.share == share)
            elements += self._ramps(weight, carries, share)
            elements += self._products(weight, carries, share)
            level = float(np.sum((weight * self.gain)[carries & (self.group == LEVEL)]))
            if level:
                elements.append(Element("input", 0.0, 0.0, level, CONSTANT, share))
        return tuple(elements)

    def _ramps(self, weight: Array, carries: Marks, share: int) -> Iterator[Element]:
        """Yield an element for each cell whose ramps carry weight."""
        single = np.flatnonzero(carries & (self.second == NO_CELL) & (self.group != LEVEL))
        for number in np.unique(np.append(0, self.cell[single])).tolist():
            cell = self.cells[number]
            k = single[self.cell[single] == number]
            ramps = np.array([weight[k] * self.gain[k], self.low[k], self.high[k]])
            if number == 0:
                # Ramps of x stand in columns of other cells, too; in the model they belong to x itself.
                k = np.flatnonzero(carries & (self.x_high > self.x_low))
                x_ramps = np.array([weight[k], self.x_low[k], self.x_high[k]])
                ramps = np.concatenate([ramps, x_ramps], axis=1)
            if ramps.size:
                slope, pairs = _sum_of(*ramps)
                yield Element(cell.kind, cell.radius, cell.time, slope, pairs, share)

    def _products(self, weight: Array, carries: Marks, share: int) -> Iterator[Element]:
        """Yield the products with weight, in chains: each reads the lag of the next one."""
        # A graph: cells are its nodes, products its edges. Every edge is walked once.
        edges: dict[int, dict[int, float]] = {}
        for k in np.flatnonzero((self.second != NO_CELL) & carries).tolist():
            first, second = int(self.cell[k]), int(self.second[k])
            of_first, of_second = edges.setdefault(first, {}), edges.setdefault(second, {})
            value = of_first.get(second, 0.0) + float(weight[k] * self.gain[k])
            of_first[second] = value
            of_second[first] = value
        for begin in edges:
            cell = begin
            while edges[cell]:
                neighbour = min(edges[cell])
                value = edges[cell].pop(neighbour)
                edges[neighbour].pop(cell, None)
                yield Element("product", 1.0, self.cells[cell].time, value, NO_MAP, share)
                cell = neighbour
                if not edges[cell]:
                    # The chain ends here; its last product reads the lag of this element.
                    yield Element("past", 0.0, self.cells[cell].time, 0.0)
                    cell = begin


def _ramp(v: Array, low: Array, high: Array) -> Array:
    return np.asarray(np.clip(v, low, high) - np.clip(0.0, low, high))


def _sum_of(weight: Array, low: Array, high: Array) -> tuple[float, Pairs]:
    """Return weight and map of a sum of ramps; a line has no map."""
    ends = np.concatenate([low, high])
    knots = np.unique(ends[np.isfinite(ends)])
    if not knots.size:
        return float(weight.sum()), NO_MAP
    u = np.concatenate([knots[:1] - 1.0, knots, knots[-1:] + 1.0])
    v = _ramp(u[:, None], low, high) @ weight
    return 1.0, (tuple(u.tolist()), tuple(v.tolist()))


def shares(xi: Array) -> Array:
    """Return what columns are multiplied by, (T, 2 schedules + 1), for schedules from 0 to 1, (T, schedules)."""
    factors = np.ones((len(xi), 2 * xi.shape[1] + 1))
    factors[:, 1::2] = 1.0 - xi
    factors[:, 2::2] = xi
    return factors


def columns_of(groups: Sequence[str], ramps: int, pace: Pace | None, schedules: int = 0) -> Columns:
    """Return the columns of x, in so many ramps, and of groups; without `pace` nothing depends on time."""
    columns = _unscheduled(groups, ramps, pace)
    return _scheduled(columns, schedules) if schedules else columns


def _scheduled(columns: Columns, schedules: int) -> Columns:
    """Return the columns times 1 - xi and times xi of each schedule, and two levels with xi: weights have one sign."""
    size, copies = columns.cell.size, 2 * schedules
    places = np.tile(np.arange(size), copies)
    levels = np.zeros(copies, dtype=np.int64)
    places = np.concatenate([places, levels])
    group = columns.group[places].astype(np.result_type(columns.group, np.array([LEVEL])))
    group[copies * size :] = LEVEL
    gain = columns.gain[places]
    gain[copies * size :] = np.tile([1.0, -1.0], schedules)
    neighbours = []
    for copy in range(copies):
        neighbours.append(columns.neighbours + copy * size)
    return replace(
        columns,
        group=group,
        cell=columns.cell[places],
        gain=gain,
        low=columns.low[places],
        high=columns.high[places],
        x_low=np.where(group == LEVEL, 0.0, columns.x_low[places]),
        x_high=np.where(group == LEVEL, 0.0, columns.x_high[places]),
        neighbours=np.concatenate(neighbours),
        second=np.where(group == LEVEL, NO_CELL, columns.second[places]),
        share=np.concatenate(
            [np.repeat(np.arange(1, copies + 1), size), 2 * np.repeat(np.arange(schedules), 2) + 2]
        ),
    )


def _unscheduled(groups: Sequence[str], ramps: int, pace: Pace | None) -> Columns:
    cells = [Element("input")]
    lines = _ramps_of(0, _parts(np.linspace(-1.0, 1.0, ramps + 1)[1:-1].tolist()))
    names = ["x"] * len(lines)
    neighbours = _chained(0, len(lines), ramps)
    for name in groups:
        new_cells, new_lines, chain = GROUPS[name](pace)
        neighbours += _chained(len(lines), len(new_lines), chain)
        for line in new_lines:
            lines.append(_shifted(line, len(cells)))
        names += [name] * len(new_lines)
        cells += new_cells
    cell, gain, part, x_part, second = zip(*lines, strict=True)
    low, high = np.array(part).T
    x_low, x_high = np.array(x_part).T
    return Columns(
        cells=tuple(cells),
        group=np.array(names),
        cell=np.array(cell),
        gain=np.array(gain),
        low=low,
        high=high,
        x_low=x_low,
        x_high=x_high,
        neighbours=np.array(neighbours, dtype=np.int64).reshape(-1, 2),
        second=np.array(second),
        share=np.zeros(len(lines), dtype=np.int64),
    )


def _chained(first: int, count: int, chain: int) -> list[tuple[int, int]]:
    """Return pairs of neighbouring columns among `count` from the first on, in chains of equal length."""
    pairs = []
    for k in range(count - 1):
        # The last column of a chain and the first of the next one belong to different cells.
        if k % chain < chain - 1:
            pairs.append((first + k, first + k + 1))
    return pairs


def _shifted(line: Line, by: int) -> Line:
    """Number the cells of a line among those of all groups."""
    if line.second == NO_CELL:
        return line._replace(cell=line.cell + by)
    return line._replace(cell=line.cell + by, second=line.second + by)


def _parts(inner: Sequence[float]) -> list[Part]:
    """Return the parts of the real line between inner points."""
    return list(zip((-np.inf, *inner), (*inner, np.inf), strict=True))


# Cells, lines (numbered among these cells), length of a chain of neighbours.
Group = tuple[list[Element], list[Line], int]


def _ramps_of(cell: int, parts: Sequence[Part]) -> list[Line]:
    """Return one column for each part of a cell's range."""
    return [Line(cell, 1.0, part) for part in parts]


def _elements(kind: str, radii: Sequence[float], times: Sequence[float] = (0.0,)) -> list[Element]:
    """Return elements of a kind: every radius at every time constant, the radius changing first."""
    return [Element(kind, radius, time) for time in times for radius in radii]


def _plain(cells: list[Element]) -> Group:
    """Return a group where each cell is one column."""
    return cells, [Line(k, 1.0) for k in range(len(cells))], 1


def _ramped(cells: list[Element], inner: Sequence[float]) -> Group:
    """Return a group where the range of each cell is cut into ramps."""
    lines = []
    for k in range(len(cells)):
        lines += _ramps_of(k, _parts(inner))
    return cells, lines, len(inner) + 1


def _plays(pace: Pace | None) -> Group:
    return _plain(_elements("play", THRESHOLDS))


def _stops(pace: Pace | None) -> Group:
    return _plain(_elements("stop", THRESHOLDS))


def _paths(pace: Pace | None) -> Group:
    return _plain(_elements("path", WAYS))


def _lagging(pace: Pace | None) -> Group:
    return _ramped(_elements("play", RADII), FINE)


def _leading(pace: Pace | None) -> Group:
    """Return ramps of x less those of a play. The ramp of x is so wide that the difference never falls."""
    lines = []
    for k, radius in enumerate(RADII):
        for low, high in _parts(FINE):
            # Rounded, so that the ends of neighbouring ramps of x are the same number.
            x_part = (round(low - radius, 9), round(high + radius, 9))
            lines.append(Line(k, -1.0, (low, high), x_part))
    return _elements("play", RADII), lines, len(FINE) + 1


def _creep(pace: Pace | None) -> Group:
    assert pace is not None
    longest = max(pace.duration, 4.0 * pace.period)
    times = np.geomspace(2.0 * pace.period, longest, CREEP_TIMES).tolist()
    return _plain(_elements("creep", CREEP_RADII, times))


def _viscous(pace: Pace | None) -> Group:
    assert pace is not None
    longest = max(pace.duration / 20.0, 2.0 * pace.period)
    times = np.geomspace(pace.period, longest, VISCOUS_TIMES).tolist()
    return _plain(_elements("creep", RADII[2::3], times))


def _lag_times(pace: Pace | None, passed: float = 2.0) -> list[float]:
    """Return time constants of lags; the longest passes so often within the training."""
    assert pace is not None
    longest = max(pace.duration / passed, 6.0 * pace.period)
    times: list[float] = np.geomspace(3.0 * pace.period, longest, LAG_TIMES).tolist()
    return times


def _creep_by_place(pace: Pace | None) -> Group:
    return _ramped(_elements("creep", (0.0,), _lag_times(pace)), COARSE)


def _relaxing(pace: Pace | None) -> Group:
    # A longer lag would be a drift, and the solution of an inverse row would continue it beyond the fitted time.
    return _plain(_elements("relax", (0.0,), _lag_times(pace, RELAXED)))


def _relaxing_by_place(pace: Pace | None) -> Group:
    cells = _elements("past", (0.0,), _lag_times(pace))
    lines = []
    for k in range(len(cells)):
        for part in _parts(COARSE):
            lines.append(Line(k, -1.0, part, part))
    return cells, lines, len(COARSE) + 1


def _rates(pace: Pace | None) -> Group:
    assert pace is not None
    lines = []
    for k, move in enumerate(pace.moves):
        for saturation in SATURATIONS:
            limit = move * saturation
            lines.append(Line(k, 1.0 / limit, (-limit, limit)))
    times = [samples * pace.period for samples in RATE_LAGS]
    return _elements("relax", (0.0,), times), lines, 1


def _products(pace: Pace | None) -> Group:
    times = _lag_times(pace)
    lines = []
    for i in range(len(times)):
        for j in range(i, len(times)):
            # Weights are not negative, so a product stands there with either sign.
            lines += [Line(i, 1.0, WITHIN, second=j), Line(i, -1.0, WITHIN, second=j)]
    return _elements("past", (0.0,), times), lines, 1


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
