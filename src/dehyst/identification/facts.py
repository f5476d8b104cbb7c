"""What the data shows by itself: orientation, width, rate dependence, drift."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from dehyst.identification.data import DataSet
from dehyst.loops import summarise_loops, turning_points

Array = npt.NDArray[np.float64]

BINS = 24
# A loop narrower than this share of the output's range has no orientation.
NARROW = 0.01
RATE_BLOCKS = 20


@dataclass(frozen=True, slots=True)
class Orientation:
    """Which way round the loop runs and how wide it is.

    Attributes
    ----------
    name
        "counter-clockwise", "clockwise", "mixed" or "none", for the rising form of the curve.
    width
        Mean vertical distance of the falling and the rising branch, share of the output's range.
    """

    name: str
    width: float


def orientation(data: DataSet) -> Orientation:
    """Compare the output on rising and falling branches at the same input, over the training part.

    The output of a lagging actuator is lower while its input rises: the loop runs counter-clockwise.
    """
    edges = np.linspace(-0.9, 0.9, BINS + 1)
    sums = np.zeros((2, BINS))
    counts = np.zeros((2, BINS))
    for piece in data.pieces:
        x, y = piece.x[piece.train], piece.y[piece.train]
        if x.size < 3:
            continue
        points = turning_points(x, 0.1)
        # The first branch may be a virgin curve, which lies inside the loop.
        first = int(points[1]) if points.size > 3 else 0
        direction = np.zeros(x.size, dtype=np.int64)
        for begin, end in itertools.pairwise(points):
            direction[begin:end] = 0 if x[end] > x[begin] else 1
        cell = np.digitize(x, edges) - 1
        keep = (cell >= 0) & (cell < BINS) & (np.arange(x.size) >= first)
        np.add.at(sums, (direction[keep], cell[keep]), y[keep])
        np.add.at(counts, (direction[keep], cell[keep]), 1.0)
    both = (counts > 0).all(axis=0)
    if not both.any():
        return Orientation("none", 0.0)
    distance = 0.5 * (sums[1, both] / counts[1, both] - sums[0, both] / counts[0, both])
    width = float(np.mean(np.abs(distance)))
    lag, lead = float(np.sum(distance[distance > 0])), float(-np.sum(distance[distance < 0]))
    if width < NARROW:
        return Orientation("none", width)
    if min(lag, lead) > 0.25 * max(lag, lead):
        return Orientation("mixed", width)
    return Orientation("counter-clockwise" if lag > lead else "clockwise", width)


def count_loops(data: DataSet) -> tuple[int, int]:
    """Input cycles and turning points over the training part."""
    found = [summarise_loops(piece.x[piece.train], 0.1) for piece in data.pieces if piece.train.any()]
    return sum(loops.loops for loops in found), sum(loops.turns for loops in found)


def velocity(time: Array, x: Array) -> Array:
    """Rate of a signal, smoothed over 1/40 of its mean cycle so that sensor noise does not pose as motion."""
    turns = max(2, turning_points(x).size - 1)
    window = max(1, round(x.size / turns / 20))
    kernel = np.ones(window) / window
    padded = np.concatenate([np.full(window, x[0]), x, np.full(window, x[-1])])
    smooth = np.convolve(padded, kernel, mode="same")[window:-window] if window > 1 else x
    rate: Array = np.gradient(smooth, time)
    return rate


def rate_share(time: Array, x: Array, y: Array, predicted: Array, usable: npt.NDArray[np.bool_]) -> float:
    """Share of a prediction's RMS error that the rate of the input takes away on samples that were not fitted.

    1 - rms(y - f) / rms(y - predicted), less a slow drift, where f is linear in the prediction, in hat functions of
    the rate, in the input, in its acceleration and in the drift. The record is cut into 20 blocks; even and odd
    blocks judge each other and the smaller share counts, so that what is found must hold throughout. 0 when the rate
    explains nothing.
    """
    rates = velocity(time, x)
    knots = np.unique(np.quantile(rates[usable], np.linspace(0.01, 0.99, 9)))
    if knots.size < 3:
        return 0.0
    hats = np.column_stack([np.interp(rates, knots, row) for row in np.eye(knots.size)])
    others = np.column_stack([predicted, x, np.gradient(rates, time)])
    others = (others - others.mean(axis=0)) / np.maximum(np.ptp(others, axis=0), 1e-300)
    clock = (time - time[0]) / (time[-1] - time[0])
    slow = np.column_stack([np.ones(x.size), clock, clock**2])  # a shifted zero or a drift is no rate
    columns = np.column_stack([hats, others, slow[:, 1:]])
    error = y - predicted
    even = np.arange(x.size) * RATE_BLOCKS // x.size % 2 == 0
    shares = []
    for fitted, scored in ((usable & even, usable & ~even), (usable & ~even, usable & even)):
        if min(fitted.sum(), scored.sum()) < 3 * columns.shape[1]:
            return 0.0
        coefficients = np.linalg.lstsq(columns[fitted], y[fitted], rcond=None)[0]
        trend = np.linalg.lstsq(slow[fitted], error[fitted], rcond=None)[0]
        before = float(np.mean((error[scored] - slow[scored] @ trend) ** 2))
        after = float(np.mean((y[scored] - columns[scored] @ coefficients) ** 2))
        shares.append(1.0 - np.sqrt(after / before) if before > 0 else 0.0)
    return max(0.0, float(min(shares)))


def drift(x: Array, residual: Array) -> tuple[float, float]:
    """Change of the residual from the first to the last cycle, and its standard error, in the residual's unit.

    A line through the mean residual of each full cycle; (0, 0) with fewer than four cycles.
    """
    points = turning_points(x)[1:-1]
    cycles = [residual[a:b].mean() for a, b in zip(points[:-2:2], points[2::2], strict=False) if b > a]
    if len(cycles) < 4:
        return 0.0, 0.0
    k = np.arange(len(cycles), dtype=np.float64)
    k -= k.mean()
    slope = float(k @ np.array(cycles) / (k @ k))
    rest = np.array(cycles) - np.mean(cycles) - slope * k
    error = float(np.sqrt(rest @ rest / (len(cycles) - 2) / (k @ k)))
    return slope * (len(cycles) - 1), error * (len(cycles) - 1)
