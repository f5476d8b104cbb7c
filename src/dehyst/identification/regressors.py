"""Regressors of one operator bank over a data set, reduced to triangles as they are made."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from dehyst import _native
from dehyst.identification.data import DataSet
from dehyst.identification.least_squares import triangle
from dehyst.identification.memory import state_before

Array = npt.NDArray[np.float64]
Rows = npt.NDArray[np.int64]

# Rows that are reduced at once: 1024 x 120 doubles, 1 MB, stay in the processor's cache, where the triangular
# factor takes a quarter of the time of 8192 rows.
CHUNK = 1024
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
    states = _states(data, thresholds, initial_state)
    low = np.full(thresholds.size, np.inf)
    high = np.full(thresholds.size, -np.inf)
    for piece, state, rows in zip(data.pieces, states, training_rows(data, initial_state), strict=True):
        # A play reaches its extremes where the input turns: those rows suffice.
        turns = np.ones(piece.x.size, dtype=np.bool_)
        turns[1:-1] = np.diff(np.sign(np.diff(piece.x))) != 0
        turns[rows[:1]] = turns[rows[-1:]] = True
        for _, plays in _blocks(piece.x, thresholds, state, rows[turns[rows]]):
            low, high = np.minimum(low, plays.min(axis=0)), np.maximum(high, plays.max(axis=0))
    moved = high - low > MOVED
    moved[0] = True
    kept = np.ascontiguousarray(thresholds[moved])
    return Bank(kept, thresholds[~moved], tuple(np.ascontiguousarray(s[moved]) for s in states), initial_state)


def _blocks(x: Array, thresholds: Array, state: Array, rows: Rows) -> Iterator[tuple[Rows, Array]]:
    """Play outputs at the given rows of one piece, a chunk at a time."""
    position = 0
    size = max(CHUNK, 2 * thresholds.size)  # fewer rows than columns would not reduce anything
    for begin in range(0, rows.size, size):
        part = rows[begin : begin + size]
        stop = int(part[-1]) + 1
        plays, state = _native.play_bank(x[position:stop], thresholds, state, part - position)
        position = stop
        yield part, plays


def _states(data: DataSet, thresholds: Array, initial_state: str) -> tuple[Array, ...]:
    return tuple(
        state_before(
            "unknown" if piece.after_break else initial_state,
            thresholds,
            float(piece.x[0]),
            low=-1.0,
            high=1.0,
            origin=-data.center / data.half_range,
        )
        for piece in data.pieces
    )


def training_rows(data: DataSet, initial_state: str) -> tuple[Rows, ...]:
    """Indices of the training samples of each piece whose memory is known."""
    return tuple(np.flatnonzero(piece.train & piece.usable(initial_state)).astype(np.int64) for piece in data.pieces)


def plays_at(data: DataSet, bank: Bank, rows: tuple[Rows, ...]) -> tuple[Array, Array]:
    """Play outputs (m, n) and scaled output (m,) at the given rows of all pieces."""
    plays, outputs = [], []
    for piece, state, chosen in zip(data.pieces, bank.states, rows, strict=True):
        for part, block in _blocks(piece.x, bank.thresholds, state, chosen):
            plays.append(block)
            outputs.append(piece.y[part])
    return np.concatenate(plays), np.concatenate(outputs)


def reduce(data: DataSet, bank: Bank, rows: tuple[Rows, ...], knots: Array | None = None) -> Array:
    """Triangular factor of [1 | plays | ramps | y] over the given rows, in constant memory.

    Parameters
    ----------
    knots
        Knots of the output map: adds the ramp columns of `ramps`. None leaves them out.
    """
    factor: Array | None = None
    for piece, state, chosen in zip(data.pieces, bank.states, rows, strict=True):
        for part, plays in _blocks(piece.x, bank.thresholds, state, chosen):
            block = design(plays, piece.y[part], knots)
            factor = triangle(block if factor is None else np.vstack([factor, block]))
    if factor is None:
        raise AssertionError("no rows to fit")  # the caller has checked
    return factor


def design(plays: Array, y: Array, knots: Array | None) -> Array:
    """Rows [1 | plays | ramps | y], (m, 1 + n + p + 1)."""
    columns = [np.ones((y.size, 1)), plays]
    if knots is not None:
        columns.append(ramps(y, knots))
    columns.append(y[:, None])
    return np.hstack(columns)


def ramps(y: Array, knots: Array) -> Array:
    """Columns min(max(y - k_j, 0), k_{j+1} - k_j), (m, p): with slopes m_j they sum to a piecewise linear map."""
    ramp: Array = np.clip(y[:, None] - knots[:-1], 0.0, np.diff(knots))
    return ramp
