"""Compares the recordings of one fit: whether level, gain and width of their loops are those of one actuator."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

import dehyst._native as _native
from dehyst.arrays import Array
from dehyst.data.loops import TURN_FRACTION, turning_points
from dehyst.data.recording import Recording

CELLS = 12  # along the input, within what all recordings go over
SHARED = 0.5  # of the range of all: what they have in common at least, or nothing is compared
FEWEST = 3  # samples of either branch in a cell, and cells that all have
NARROW = 0.01  # of the output's range: a model with a narrower loop does not say how wide one should be
# A width is another one if it is so many times another's, beyond what the motion makes of it, and by this share of the
# output's range; a gain likewise. What sizes and speeds make of equal loops stays below (tests/peculiar_logs.py).
WIDER = 1.35
WIDTH_APART = 0.015
STEEPER = 1.08
GAIN_APART = 0.03
SPEEDS = 1.5  # times as fast: a wider loop may be the rate's
RADII = np.array([0.05, 0.12, 0.25, 0.4])  # of an operator that stands for a model without a loop, share of the range


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
    >>> [(each.name, round(each.width, 1)) for each in conditions(logs, None, 2.0)]
    [('1 A', 0.5), ('3 A', 1.5)]
    """
    if len(recordings) < 2:
        return ()
    inputs = [record.input for record in recordings]
    low, high = max(float(x.min()) for x in inputs), min(float(x.max()) for x in inputs)
    whole = max(float(x.max()) for x in inputs) - min(float(x.min()) for x in inputs)
    if high - low < SHARED * whole:
        return ()
    edges = np.linspace(low + 0.05 * (high - low), high - 0.05 * (high - low), CELLS + 1)
    measured = _loops([_branches(record, record.output, edges) for record in recordings])
    if measured is None:
        return ()
    said = None if predictions is None else _predicted(recordings, predictions, edges)
    if said is None or float(np.mean(said.widths)) < NARROW * output_range:
        if high - low < whole / WIDER:  # loops of other sizes, and nothing says what they make of the width
            return ()
        said = _predicted(recordings, [_operator(x, whole) for x in inputs], edges)
    if said is None:
        return ()
    gains = measured.gains / said.gains
    widths = measured.widths / said.widths * float(np.mean(said.widths) / np.mean(measured.widths))
    return tuple(
        Condition(record.name, float(gain), float(width), 100.0 * float(size) / output_range)
        for record, gain, width, size in zip(recordings, gains, widths, measured.widths, strict=True)
    )


def wider(found: Sequence[Condition]) -> bool:
    """Whether the widths of loops differ beyond what their motions make of them."""
    sizes = [each.width_percent for each in found]
    widths = [each.width for each in found]
    apart = bool(found) and max(sizes) - min(sizes) > 100.0 * WIDTH_APART
    return apart and max(widths) > WIDER * max(min(widths), 1e-9)


def steeper(found: Sequence[Condition]) -> bool:
    """Whether the gains differ."""
    gains = [each.gain for each in found]
    return bool(found) and max(gains) > STEEPER * max(min(gains), 1e-9) and max(gains) - min(gains) > GAIN_APART


def at_one_speed(recordings: Sequence[Recording]) -> bool:
    """Whether the inputs move about equally fast, as far as time stamps tell."""
    speeds = [
        float(np.mean(np.abs(np.diff(record.input)))) / float(np.median(np.diff(record.time)))
        for record in recordings
        if record.time is not None
    ]
    return not speeds or max(speeds) <= SPEEDS * min(speeds)


class _Loops(NamedTuple):
    """Gain about the mean curve, and width, of each recording, (n,)."""

    gains: Array
    widths: Array


def _predicted(recordings: Sequence[Recording], outputs: Sequence[Array], edges: Array) -> _Loops | None:
    pairs = zip(recordings, outputs, strict=True)
    found = _loops([_branches(record, output, edges) for record, output in pairs])
    return found if found is not None and float(np.min(found.widths)) > 0.0 and np.min(found.gains) > 0.0 else None


def _branches(record: Recording, y: Array, edges: Array) -> Array:
    """Mean output in each cell on branches that fall and that rise, (2, cells); not a number where samples are few."""
    sums, counts = np.zeros((2, CELLS)), np.zeros((2, CELLS))
    for piece in record.pieces:
        x = record.input[piece]
        points = turning_points(x, TURN_FRACTION * float(edges[-1] - edges[0]))
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


def _loops(branches: Sequence[Array]) -> _Loops | None:
    """Compare over the cells that all have; the mean loop says which way round it goes in each."""
    both = np.array(branches)
    there = np.isfinite(both).all(axis=0).all(axis=0)
    if np.count_nonzero(there) < FEWEST:
        return None
    falling, rising = both[:, 0][:, there], both[:, 1][:, there]
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
    moved = _native.play_bank(np.ascontiguousarray(x), radii, x[0] + np.zeros(radii.size), np.arange(x.size))[0]
    answer: Array = x + np.asarray(moved, dtype=np.float64).mean(axis=1)
    return answer
