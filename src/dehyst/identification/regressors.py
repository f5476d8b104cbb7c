"""Plays of one operator bank over a data set."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

import dehyst._native as _native
from dehyst.arrays import Array
from dehyst.identification.data import DataSet, Piece, Signal, chunks, extremes
from dehyst.identification.memory import state_before

# A play that moved less than this share of the half range over the training samples tells nothing.
MOVED = 1e-6


@dataclass(frozen=True)
class Bank:
    """Play operators over all pieces of a data set.

    Attributes
    ----------
    thresholds
        r, (n,), scaled; only those that moved in the training samples.
    undetermined
        Thresholds that did not, scaled.
    states
        State before each piece, (pieces, n).
    initial_state
        The assumption behind them.
    """

    thresholds: Array
    undetermined: Array
    states: tuple[Array, ...]
    initial_state: str


def make_bank(data: DataSet, thresholds: Array, initial_state: str) -> Bank:
    """Choose the operators that the training samples set in motion, and their states before each piece."""
    states = tuple(_state(data, piece, thresholds, initial_state) for piece in data.pieces)
    low = np.full(thresholds.size, np.inf)
    high = np.full(thresholds.size, -np.inf)
    moved = np.zeros(thresholds.size, dtype=np.bool_)
    for piece, state in zip(data.pieces, states, strict=True):
        fitted = piece.fitted(initial_state)
        if fitted.stop > fitted.start:
            least, most = _extremes(piece.x, fitted, thresholds, state)
            if piece.unknown_level(initial_state):  # another place than in other pieces tells nothing
                moved |= most - least > MOVED
            else:
                low, high = np.minimum(low, least), np.maximum(high, most)
    moved |= high - low > MOVED
    moved[0] = True
    kept = np.ascontiguousarray(thresholds[moved])
    return Bank(kept, thresholds[~moved], tuple(np.ascontiguousarray(s[moved]) for s in states), initial_state)


def _extremes(x: Signal, fitted: slice, thresholds: Array, state: Array) -> tuple[Array, Array]:
    """Smallest and largest output of each play over the fitted samples.

    A play rises only with x - r and falls only with x + r, so its largest value is that at the first sample or
    max x - r, its smallest that at the first sample or min x + r: no need to look at every turn.
    """
    for part in chunks(slice(0, fitted.start + 1)):
        _, state = _native.play_bank(x[part], thresholds, state, np.zeros(0, dtype=np.int64))
    low, high = extremes(x, fitted)
    return np.minimum(state, low + thresholds), np.maximum(state, high - thresholds)


def _state(data: DataSet, piece: Piece, thresholds: Array, initial_state: str) -> Array:
    within = piece.unknown_level(initial_state)
    if within is not None:
        return np.full(thresholds.size, 0.5 * (within[0] + within[1]))
    return state_before(
        "unknown" if piece.after_break else initial_state,
        thresholds,
        float(piece.x[0]),
        low=-1.0,
        high=1.0,
        origin=-data.center / data.half_range,
    )


def fitted_samples(data: DataSet, initial_state: str) -> int:
    """Number of samples that are fitted."""
    spans = [piece.fitted(initial_state) for piece in data.pieces]
    return sum(
        span.stop - span.start if piece.weight is None else int(np.count_nonzero(piece.weight[span]))
        for piece, span in zip(data.pieces, spans, strict=True)
    )


def blocks(x: Signal, thresholds: Array, state: Array, rows: slice, size: int) -> Iterator[tuple[slice, Array]]:
    """Play outputs over a span of one piece, (size, n) at a time."""
    for part in chunks(slice(0, rows.start)):
        _, state = _native.play_bank(x[part], thresholds, state, np.zeros(0, dtype=np.int64))
    for part in chunks(rows, size):
        plays, state = _native.play_bank(x[part], thresholds, state, np.arange(part.stop - part.start, dtype=np.int64))
        yield part, plays


def ramps(y: Array, knots: Array) -> Array:
    """Columns min(max(y - k_j, 0), k_{j+1} - k_j), (m, p): with slopes m_j they sum to a piecewise linear map."""
    ramp: Array = np.clip(y[:, None] - knots[:-1], 0.0, np.diff(knots))
    return ramp
