"""Play operators over a data set: states before each piece, and normal equations of their columns.

The columns are [1 | cells | targets] with cell i = z_i - z_{i+1} and the last cell z_n, because in cells the unknowns
are the slopes S_i = w_1 + ... + w_i of

    y = c + sum_i w_i z_i = c + sum_{i<n} S_i (z_i - z_{i+1}) + S_n z_n

and the condition number of the cells grows with n only, that of the plays with n^2. Sums add over recordings and
chunks, and those of a coarser set of operators are sums of the same cells.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

import dehyst._native as _native
from dehyst._native import Gram
from dehyst.arrays import Array
from dehyst.data import range_of
from dehyst.errors import ParameterError
from dehyst.identification._data import DataSet, Piece, chunks
from dehyst.identification._memory import state_before
from dehyst.models import HysteresisModel

# A play that moved less than this share of the half range over the training samples tells nothing.
MOVED = 1e-6


@dataclass(frozen=True)
class PlayBank:
    """Play operators over all pieces of a data set."""

    thresholds: Array  # r, (n,), scaled; only those that moved in the training samples
    undetermined: Array  # Thresholds that did not, scaled
    states: tuple[Array, ...]  # State before each piece, (pieces, n)
    initial_state: str  # The assumption behind them


def make_bank(data: DataSet, thresholds: Array, initial_state: str) -> PlayBank:
    """Choose the operators that the training samples set in motion, and their states before each piece."""
    states = tuple(_state(data, piece, thresholds, initial_state) for piece in data.pieces)
    low = np.full(thresholds.size, np.inf)
    high = np.full(thresholds.size, -np.inf)
    moved = np.zeros(thresholds.size, dtype=np.bool_)
    for piece, state in zip(data.pieces, states, strict=True):
        fitted = piece.fitted(initial_state)
        if fitted.stop > fitted.start:
            least, most = _extremes(piece.x, fitted, thresholds, state)
            # In another place than in other pieces a play tells nothing of itself.
            if piece.unknown_level(initial_state):
                moved |= most - least > MOVED
            else:
                low, high = np.minimum(low, least), np.maximum(high, most)
    moved |= high - low > MOVED
    moved[0] = True
    moving = np.ascontiguousarray(thresholds[moved])
    return PlayBank(
        moving,
        thresholds[~moved],
        tuple(np.ascontiguousarray(s[moved]) for s in states),
        initial_state,
    )


def _extremes(x: Array, fitted: slice, thresholds: Array, state: Array) -> tuple[Array, Array]:
    """Smallest and largest output of each play over the fitted samples.

    A play rises only with x - r and falls only with x + r, so its largest value is that at the first sample or
    max x - r, its smallest that at the first sample or min x + r: no need to look at every turn.
    """
    for part in chunks(slice(0, fitted.start + 1)):
        _, state = _native.play_bank(x[part], thresholds, state, np.zeros(0, dtype=np.int64))
    low, high = range_of(x[fitted])
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
    count = 0
    for piece in data.pieces:
        span = piece.fitted(initial_state)
        if piece.weight is None:
            count += span.stop - span.start
        else:
            count += int(np.count_nonzero(piece.weight[span]))
    return count


def blocks(
    x: Array, thresholds: Array, state: Array, rows: slice, size: int
) -> Iterator[tuple[slice, Array]]:
    """Play outputs over a span of one piece, (size, n) at a time."""
    for part in chunks(slice(0, rows.start)):
        _, state = _native.play_bank(x[part], thresholds, state, np.zeros(0, dtype=np.int64))
    for part in chunks(rows, size):
        plays, state = _native.play_bank(
            x[part], thresholds, state, np.arange(part.stop - part.start, dtype=np.int64)
        )
        yield part, plays


def settled_bank(data: DataSet, bank: PlayBank, model: HysteresisModel) -> PlayBank:
    """Bank with states before pieces of unknown level such that the mean error of the piece vanishes, if any is.

    A play wider than the piece stands still anywhere between M - r and m + r, M and m the extremes of the input there.
    All wide plays are moved by the same share of what they can, so that what no memory of theirs explains stays in the
    errors. The mean is that of the fitted samples of a piece, and of the held-out ones where none was fitted.
    """
    states = []
    for piece, state in zip(data.pieces, bank.states, strict=True):
        states.append(_settled(data, bank, model, piece, state))
    return replace(bank, states=tuple(states))


def started(data: DataSet, bank: PlayBank, model: HysteresisModel, state: Array) -> HysteresisModel:
    """Model with a state of the bank, (n,), scaled."""
    places = np.searchsorted(bank.thresholds * data.half_range, model.radii)
    return model.with_state(state[places] * data.half_range)


def _settled(
    data: DataSet, bank: PlayBank, model: HysteresisModel, piece: Piece, state: Array
) -> Array:
    within, span = piece.unknown_level(bank.initial_state), piece.fitted(bank.initial_state)
    if span.stop <= span.start:
        span = piece.held_out(bank.initial_state)
    if within is None or span.stop <= span.start:
        return state
    spare = np.maximum(bank.thresholds - 0.5 * (within[1] - within[0]), 0.0)
    low = _miss(data, piece, span, started(data, bank, model, state - spare))
    high = _miss(data, piece, span, started(data, bank, model, state + spare))
    if low == high:
        return state
    moved: Array = state + float(np.clip((low + high) / (low - high), -1.0, 1.0)) * spare
    return moved


def _miss(data: DataSet, piece: Piece, span: slice, model: HysteresisModel) -> float:
    """Sum of the measured output less that of the model over a span. [output]"""
    stepper, total = model.stepper("dense"), 0.0
    for part in chunks(slice(0, span.start)):
        stepper.simulate(data.center + data.half_range * piece.x[part])
    for part in chunks(span):
        output = stepper.simulate(data.center + data.half_range * piece.x[part])[0]
        miss = data.level + data.trend * data.amplitude * piece.y[part] - output
        total += float(np.sum(miss) if piece.weight is None else miss @ piece.weight[part])
    return total


# Of the level of a piece that may have any.
TRACE = 1e-12


@dataclass(frozen=True, eq=False)
class NormalEquations:
    """Sums over samples of products of the columns [1 | cells | targets]."""

    thresholds: Array  # r, (n,), increasing from 0. [input]
    matrix: Array  # Sums of weight times column times column, (1 + n + m, 1 + n + m), symmetric. The last target is y.
    # Sum of the weights where levels were taken out of some samples; None: the first element of the matrix
    counted: float | None = None

    @property
    def operators(self) -> int:
        """Number n of plays."""
        return self.thresholds.size

    @property
    def samples(self) -> float:
        """Sum of the weights: the number of samples where all count alike."""
        if self.counted is None:
            return float(self.matrix[0, 0])
        return self.counted

    def __add__(self, other: NormalEquations) -> NormalEquations:
        """Sums over the samples of both."""
        if (
            not np.array_equal(self.thresholds, other.thresholds)
            or self.matrix.shape != other.matrix.shape
        ):
            raise ParameterError(
                f"sums over {self.operators} and {other.operators} operators (matrices {self.matrix.shape} and "
                f"{other.matrix.shape}) belong to different columns and cannot be added. Accumulate both with the "
                f"same thresholds and the same extra columns.",
                operators=(self.operators, other.operators),
            )
        counted = None
        if self.counted is not None or other.counted is not None:
            counted = self.samples + other.samples
        return NormalEquations(self.thresholds, self.matrix + other.matrix, counted)

    def coarser(self, kept: npt.NDArray[np.bool_]) -> NormalEquations:
        """Sums of the operators with kept[i] only, (n,), kept[0] among them: neighbouring cells are added up."""
        if kept.shape != self.thresholds.shape or not kept[0]:
            raise ParameterError(
                f"kept must have one entry for each of the {self.operators} operators and keep the first: without a "
                f"play of radius 0 the model has no inverse.",
                operators=self.operators,
            )
        n = self.operators
        starts = np.concatenate(
            [[0], 1 + np.flatnonzero(kept), np.arange(1 + n, self.matrix.shape[0])]
        )
        merged = np.add.reduceat(np.add.reduceat(self.matrix, starts, axis=0), starts, axis=1)
        return NormalEquations(self.thresholds[kept], merged, self.counted)


def normal_equations(
    data: DataSet,
    bank: PlayBank,
    knots: Array | None = None,
    span: Callable[[Piece], slice] | None = None,
) -> NormalEquations:
    """Sums of [1 | cells | ramps | y] over the fitted samples of a data set, or over another span of each piece.

    Parameters
    ----------
    knots
        Knots of an output map: adds the ramp columns. None leaves them out.
    span
        Samples of a piece that count; by default those that are fitted.
    """
    targets = 1 + (0 if knots is None else knots.size - 1)
    total: Array | None = None
    count, freed = 0.0, False
    for piece, state in zip(data.pieces, bank.states, strict=True):
        chosen = piece.fitted(bank.initial_state) if span is None else span(piece)
        if chosen.stop <= chosen.start:
            continue
        gram = Gram(bank.thresholds, state, targets)
        for part in chunks(slice(0, chosen.start)):
            gram.skip(piece.x[part])
        for part in chunks(chosen):
            y = piece.y[part][None, :]
            columns = y if knots is None else np.concatenate([ramp_columns(y[0], knots), y])
            gram.add(piece.x[part], columns, None if piece.weight is None else piece.weight[part])
        sums = gram.take()
        count += float(sums[0, 0])
        if piece.unknown_level(bank.initial_state):
            freed, sums = True, without_level(sums)
        total = sums if total is None else np.add(total, sums, out=total)
    if total is None:
        raise AssertionError("no rows to fit")  # the caller has checked
    return NormalEquations(bank.thresholds, total, count if freed else None)


def without_level(matrix: Array) -> Array:
    """Sums over the samples of a piece, of the columns less their means: its output has a constant of its own.

    A trace of the level is left, so that the offset is something where every piece has its own.
    """
    count = float(matrix[0, 0])
    return (
        matrix if count == 0.0 else matrix - (1.0 - TRACE) / count * np.outer(matrix[0], matrix[0])
    )


def ramp_columns(y: Array, knots: Array) -> Array:
    """Rows min(max(y - k_j, 0), k_{j+1} - k_j), (p, m): with slopes m_j they sum to a piecewise linear map."""
    ramp: Array = np.subtract(y, knots[:-1, None])
    return np.clip(ramp, 0.0, np.diff(knots)[:, None], out=ramp)
