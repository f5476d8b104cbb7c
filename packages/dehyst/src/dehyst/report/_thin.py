"""Reduces the points of long signals for drawing; extremes and turning points stay."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array
from dehyst.data import turning_points

Index = npt.NDArray[np.int64]
Cells = npt.NDArray[np.float64]

# A path with more points than this is thinned; a path that would still need more becomes an area.
LIMIT = 5000
# Cells across a panel in each direction: about half a point of a printed panel, below what the eye separates.
ACROSS, UP = 640, 440
# Cell sizes for thinning a path, from half a point to one and a half: a straight line joins what is kept.
CELLS = (1.0, 2.0, 3.0)
# Longest outline of an area, in cells; a rougher one is drawn on a coarser grid.
RIM = 12_000
# Points of a series at most: the extremes of every stretch.
SERIES = 2000
# A point is left out when it is closer than this to the straight line between its neighbours. [cells of the panel]
FLAT, PASSES = 0.3, 6
# Cells that may be filled while drawing an area; beyond it the samples are drawn without the lines between them.
WORK = 30_000_000


@dataclass(frozen=True, slots=True)
class Window:
    """Range of a panel in data units."""

    x_low: float
    x_high: float
    y_low: float
    y_high: float

    @classmethod
    def around(cls, *pairs: tuple[Array, Array], margin: float = 0.04) -> Window:
        """Window that holds all pairs of (x, y), with a margin; never of zero size."""
        x_low, x_high = _bounds([x for x, _ in pairs], margin)
        y_low, y_high = _bounds([y for _, y in pairs], margin)
        return cls(x_low, x_high, y_low, y_high)

    def cells(self, x: Array, y: Array) -> tuple[Array, Array]:
        """Coordinates in cells, (T,) each, NaN where a value is NaN."""
        return (
            (x - self.x_low) * (ACROSS / (self.x_high - self.x_low)),
            (y - self.y_low) * (UP / (self.y_high - self.y_low)),
        )


def _bounds(arrays: list[Array], margin: float) -> tuple[float, float]:
    # An empty line, or one of gaps alone, has no bounds and must not spoil those of the others.
    bounds = []
    for array in arrays:
        if not np.isnan(array).all():
            bounds += [float(np.nanmin(array)), float(np.nanmax(array))]
    low, high = min(bounds, default=0.0), max(bounds, default=1.0)
    span = high - low
    if span <= 1e-12 * max(abs(low), abs(high)) or span == 0.0:
        span = max(abs(high), 1.0) * 0.1
    return low - margin * span, high + margin * span


def interrupted(
    values: Array, breaks: tuple[int, ...], mask: npt.NDArray[np.bool_] | None = None
) -> Array:
    """Return values with a NaN put in before each break and NaN where the mask is False.

    Lines are interrupted at NaN; the length is (T + number of breaks,).

    Examples
    --------
    >>> interrupted(np.array([1.0, 2.0, 3.0]), (2,), np.array([False, True, True])).tolist()
    [nan, 2.0, nan, 3.0]
    """
    if mask is not None:
        values = np.where(mask, values, np.nan)
    if breaks:
        values = np.insert(values, list(breaks), np.nan)
    return values


def thin_path(x: Array, y: Array, window: Window) -> tuple[Array, Array] | None:
    """Return a path of at most about `LIMIT` points that looks the same, or None if there is none.

    A sample is dropped if it lies in the same cell as its predecessor; so no dropped sample is farther than the
    diagonal of a cell from a kept one. The smallest of `CELLS` that suffices is taken.
    First, last and turning points stay.
    """
    if x.size <= LIMIT:
        return x, y
    u, v = window.cells(x, y)
    gap = np.isnan(u) | np.isnan(v)
    for cell in CELLS:
        new = _entered(np.rint(u / cell), np.rint(v / cell), gap)
        if int(np.count_nonzero(new)) <= LIMIT:
            break
    else:
        return None
    # The eye looks at turns and extremes: they must not move by even a part of a cell.
    good = np.flatnonzero(~gap)
    if good.size:
        for signal in (x[good], y[good]):
            new[good[turning_points(signal)]] = True
            new[good[[int(np.argmin(signal)), int(np.argmax(signal))]]] = True
    return x[new], y[new]


def _entered(column: Array, row: Array, gap: npt.NDArray[np.bool_]) -> npt.NDArray[np.bool_]:
    """Which samples lie in another cell than the one before; one of each run of interruptions."""
    new = np.ones(column.size, dtype=np.bool_)
    new[1:] = (column[1:] != column[:-1]) | (row[1:] != row[:-1])
    new[1:] &= ~(gap[1:] & gap[:-1])
    return new


def occupancy(x: Array, y: Array, window: Window) -> tuple[Array, Array, Cells]:
    """Return which cells of the panel a path visits: what a very long log looks like.

    Returns
    -------
    columns, rows : (m,), (k,)
        Cell centres in data units.
    visited : (k, m)
        1 where the path passes, smoothed over neighbours; its level 0.5 outlines the visited area.
    """
    u, v = window.cells(x, y)
    u, v = _filled_in(u, v)
    good = ~(np.isnan(u) | np.isnan(v))
    column = np.clip(np.rint(u[good]), 1, ACROSS - 1).astype(np.int64)
    row = np.clip(np.rint(v[good]), 1, UP - 1).astype(np.int64)
    visited = np.zeros((UP + 1, ACROSS + 1))
    visited[row, column] = 1.0
    spread = visited.copy()
    # A cell counts when a neighbour is visited: this closes pinholes between the lines.
    for axis in (0, 1):
        spread = np.maximum(
            spread, 0.6 * np.maximum(np.roll(visited, 1, axis), np.roll(visited, -1, axis))
        )
    columns = np.linspace(window.x_low, window.x_high, ACROSS + 1)
    rows = np.linspace(window.y_low, window.y_high, UP + 1)
    # The size of the picture's file grows with the outline.
    while _rim(spread) > RIM and min(spread.shape) > 64:
        columns, rows, spread = _coarser(columns, rows, spread)
    return columns, rows, spread


def _rim(visited: Cells) -> int:
    """Length of the outline, in cells."""
    inside = visited >= 0.5
    return int(
        np.count_nonzero(inside[1:] != inside[:-1])
        + np.count_nonzero(inside[:, 1:] != inside[:, :-1])
    )


def _coarser(columns: Array, rows: Array, visited: Cells) -> tuple[Array, Array, Cells]:
    """Join 2 x 2 cells: visited if one of them is."""
    # An odd last row or column has no partner, and is left out.
    height, across = visited.shape[0] // 2 * 2, visited.shape[1] // 2 * 2
    blocks = visited[:height, :across].reshape(height // 2, 2, across // 2, 2)
    joined: Cells = blocks.max(axis=(1, 3))
    return (
        0.5 * (columns[:across:2] + columns[1:across:2]),
        0.5 * (rows[:height:2] + rows[1:height:2]),
        joined,
    )


def _filled_in(u: Array, v: Array) -> tuple[Array, Array]:
    """Add points between samples that are more than a cell apart, unless that would be too many."""
    step = np.maximum(np.abs(np.diff(u)), np.abs(np.diff(v)))
    parts = np.where(np.isfinite(step), np.clip(np.ceil(step), 1, ACROSS + UP), 1).astype(np.int64)
    if int(parts.sum()) > WORK:
        return u, v
    start = np.repeat(np.arange(parts.size), parts)
    first = np.cumsum(parts) - parts
    share = (np.arange(start.size) - first[start]) / parts[start]
    return (
        np.append(u[start] + share * (u[start + 1] - u[start]), u[-1:]),
        np.append(v[start] + share * (v[start + 1] - v[start]), v[-1:]),
    )


def joined(x: Array, y: Array, window: Window) -> tuple[Array, Array]:
    """Return a path without the points that lie on the straight line between their neighbours.

    In every pass each second point is tried, so no point moves the line by more than `PASSES` times `FLAT`. The first,
    the last and the extreme points stay.

    Examples
    --------
    >>> x = np.linspace(0.0, 1.0, 1000)
    >>> kept = joined(x, np.abs(x - 0.5), Window(0.0, 1.0, 0.0, 1.0))
    >>> kept[0].size < 40, bool(kept[1].min() == np.abs(x - 0.5).min())
    (True, True)
    """
    u, v = window.cells(x, y)
    indices = np.arange(x.size)
    fixed = np.zeros(x.size, dtype=np.bool_)
    if x.size:
        for signal in (x, y):
            fixed[[np.nanargmin(signal), np.nanargmax(signal)]] = True
    for _ in range(PASSES):
        if indices.size < 3:
            break
        middle = np.arange(1, indices.size - 1, 2)
        a, m, b = indices[middle - 1], indices[middle], indices[middle + 1]
        du, dv = u[b] - u[a], v[b] - v[a]
        length = np.hypot(du, dv)
        off = np.abs(du * (v[m] - v[a]) - dv * (u[m] - u[a])) / np.maximum(length, 1e-9)
        # A point beyond its neighbours is a turn, however close to their line.
        along = ((u[m] - u[a]) * du + (v[m] - v[a]) * dv) / np.maximum(length, 1e-9) ** 2
        flat = (off < FLAT) & (along >= 0.0) & (along <= 1.0) & ~fixed[m]
        indices = np.delete(indices, middle[flat])
    return x[indices], y[indices]


def thin_series(y: Array, limit: int = SERIES) -> Index:
    """Return indices that keep the smallest and largest value of every stretch of a series.

    Parameters
    ----------
    y
        Values over a rising abscissa, (T,); NaN interrupts, one interruption a stretch is kept.
    limit
        Number of indices aimed at.

    Examples
    --------
    >>> y = np.zeros(10_000); y[1234] = 5.0
    >>> kept = thin_series(y, 100)
    >>> len(kept) <= 150, 1234 in kept
    (True, True)
    """
    if y.size <= limit:
        return np.arange(y.size)
    width = -(-y.size // max(1, limit // 2))
    stretches = -(-y.size // width)
    padded = np.full(stretches * width, np.nan)
    padded[: y.size] = y
    table = padded.reshape(stretches, width)
    gap = np.isnan(table)
    start = np.arange(stretches) * width
    low = start + np.where(gap, np.inf, table).argmin(axis=1)
    high = start + np.where(gap, -np.inf, table).argmax(axis=1)
    interruption = (start + gap.argmax(axis=1))[gap.any(axis=1)]
    indices = np.unique(np.concatenate([[0], low, high, interruption, [y.size - 1]]))
    return indices[indices < y.size]
