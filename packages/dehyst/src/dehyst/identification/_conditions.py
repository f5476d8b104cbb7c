"""Compares the recordings of one fit: whether level, gain and width of their loops are those of one actuator."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

import dehyst._native as _native
from dehyst.arrays import Array
from dehyst.data import POLICY as DATA_POLICY
from dehyst.data import Recording, range_of, turning_points
from dehyst.identification._data import inputs_of, outputs_of
from dehyst.identification._policy import POLICY

CELLS = 12  # along the input, within what all recordings go over
SHARED = 0.5  # of the range of all: what they have in common at least, or nothing is compared
FEWEST = 3  # samples of either branch in a cell, and cells that all have
# Of the output's range: a model with a narrower loop does not say how wide one should be.
NARROW = 0.01
SPEEDS = 1.5  # times as fast: a wider loop may be the rate's
# Of an operator that stands for a model without a loop, share of the range.
RADII = np.array([0.05, 0.12, 0.25, 0.4])


class Condition(NamedTuple):
    """How one recording answers, against what one actuator would answer to its motion: factors about 1."""

    name: str
    gain: float
    width: float
    width_percent: float


def conditions(
    recordings: Sequence[Recording], predictions: Sequence[Array] | None, output_range: float
) -> tuple[Condition, ...]:
    """Return the condition of each recording; none where they have too little in common to be compared.

    Gain and width are those of the loop between the branches that rise and fall, over the input that all recordings
    share, divided by those of the predictions, or of an operator where these have no loop: loops of other sizes have
    other widths.

    Examples
    --------
    >>> x = np.sin(np.arange(900) / 20.0)
    >>> stop = x - np.array(_native.play_bank(x, np.array([0.3]), np.zeros(1), np.arange(900))[0][:, 0])
    >>> logs = [Recording(input=x, output=x + size * stop, name=f"{size:g} A") for size in (1.0, 3.0)]
    >>> [(condition.name, round(condition.width, 1)) for condition in conditions(logs, None, 2.0)]
    [('1 A', 0.5), ('3 A', 1.5)]
    """
    if len(recordings) < 2:
        return ()
    inputs = inputs_of(recordings)
    lows, highs = zip(*map(range_of, inputs), strict=True)
    low, high = max(lows), min(highs)
    whole = max(highs) - min(lows)
    if high - low < SHARED * whole:
        return ()
    edges = np.linspace(low + 0.05 * (high - low), high - 0.05 * (high - low), CELLS + 1)
    measured = _loops(recordings, outputs_of(recordings), edges)
    if measured is None:
        return ()
    expected = None
    if predictions is not None:
        expected = _predicted(recordings, predictions, edges)
    if expected is None or float(np.mean(expected.widths)) < NARROW * output_range:
        # Loops of other sizes have other widths, and nothing says what the motion makes of these.
        if high - low < whole / POLICY.wider:
            return ()
        expected = _predicted(recordings, [_operator(x, whole) for x in inputs], edges)
    if expected is None:
        return ()
    gains = measured.gains / expected.gains
    usual = float(np.mean(expected.widths) / np.mean(measured.widths))
    widths = measured.widths / expected.widths * usual
    compared = []
    for k, record in enumerate(recordings):
        percent = 100.0 * float(measured.widths[k]) / output_range
        compared.append(Condition(record.name, float(gains[k]), float(widths[k]), percent))
    return tuple(compared)


def wider(compared: Sequence[Condition]) -> bool:
    """Whether the widths of loops differ beyond what their motions make of them."""
    if not compared:
        return False
    sizes = [condition.width_percent for condition in compared]
    widths = [condition.width for condition in compared]
    apart = max(sizes) - min(sizes) > 100.0 * POLICY.width_apart
    return apart and max(widths) > POLICY.wider * max(min(widths), 1e-9)


def steeper(compared: Sequence[Condition]) -> bool:
    """Whether the gains differ."""
    if not compared:
        return False
    gains = [condition.gain for condition in compared]
    apart = max(gains) - min(gains) > POLICY.gain_apart
    return apart and max(gains) > POLICY.steeper * max(min(gains), 1e-9)


def at_one_speed(recordings: Sequence[Recording]) -> bool:
    """Whether the inputs move about equally fast, as far as time stamps tell."""
    speeds = []
    for record in recordings:
        if record.time is not None:
            step = float(np.mean(np.abs(np.diff(record.input))))
            speeds.append(step / float(np.median(np.diff(record.time))))
    return not speeds or max(speeds) <= SPEEDS * min(speeds)


class _Loops(NamedTuple):
    """Gain about the mean curve, and width, of each recording, (n,)."""

    gains: Array
    widths: Array


def _predicted(
    recordings: Sequence[Recording], outputs: Sequence[Array], edges: Array
) -> _Loops | None:
    predicted = _loops(recordings, outputs, edges)
    if predicted is None:
        return None
    # A loop without width, or a curve that falls, is no measure for another one.
    if float(np.min(predicted.widths)) > 0.0 and np.min(predicted.gains) > 0.0:
        return predicted
    return None


def _branches(record: Recording, y: Array, edges: Array) -> Array:
    """Mean output in each cell on branches that fall and that rise, (2, cells); not a number where samples are few."""
    sums, counts = np.zeros((2, CELLS)), np.zeros((2, CELLS))
    for piece in record.pieces:
        x = record.input[piece]
        points = turning_points(x, DATA_POLICY.turn_fraction * float(edges[-1] - edges[0]))
        if points.size < 4:
            continue
        rows = np.arange(points[1], points[-1])
        branch = np.minimum(np.searchsorted(points, rows, side="right"), points.size - 1)
        rising = (x[points[branch]] > x[points[branch - 1]]).astype(np.int64)
        cell = np.digitize(x[rows], edges) - 1
        inside = (cell >= 0) & (cell < CELLS)
        place = rising[inside] * CELLS + cell[inside]
        sums += np.bincount(place, y[piece][rows][inside], 2 * CELLS).reshape(2, CELLS)
        counts += np.bincount(place, None, 2 * CELLS).reshape(2, CELLS)
    enough = counts >= FEWEST
    return np.where(enough, sums / np.maximum(counts, 1.0), np.nan)


def _loops(
    recordings: Sequence[Recording], outputs: Sequence[Array], edges: Array
) -> _Loops | None:
    """Compare over the cells that all have; the mean loop says which way round it goes in each."""
    branches = []
    for record, output in zip(recordings, outputs, strict=True):
        branches.append(_branches(record, output, edges))
    both = np.array(branches)
    shared = np.isfinite(both).all(axis=0).all(axis=0)
    if np.count_nonzero(shared) < FEWEST:
        return None
    falling, rising = both[:, 0][:, shared], both[:, 1][:, shared]
    distance, middle = 0.5 * (falling - rising), 0.5 * (falling + rising)
    way = np.sign(distance.mean(axis=0))
    curve = middle.mean(axis=0) - float(middle.mean())
    square = float(curve @ curve)
    if not square > 0.0:
        return None
    return _Loops(middle @ curve / square, np.maximum(distance @ way / way.size, 0.0))


def _operator(x: Array, whole: float) -> Array:
    """Plays of several sizes beside the input."""
    radii = RADII * whole
    moved = _native.play_bank(
        np.ascontiguousarray(x), radii, x[0] + np.zeros(radii.size), np.arange(x.size)
    )[0]
    answer: Array = x + np.asarray(moved, dtype=np.float64).mean(axis=1)
    return answer
