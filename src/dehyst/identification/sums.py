"""Normal equations of plays: sums over all samples, after which the data are needed no more.

The columns are [1 | cells | targets] with cell i = z_i - z_{i+1} and the last cell z_n, because in cells the unknowns
are the slopes S_i = w_1 + ... + w_i of

    y = c + sum_i w_i z_i = c + sum_{i<n} S_i (z_i - z_{i+1}) + S_n z_n

and the condition number of the cells grows with n only, that of the plays with n^2. Sums add over recordings and
chunks, and those of a coarser set of operators are sums of the same cells.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from dehyst._native import Gram
from dehyst.arrays import Array
from dehyst.errors import ParameterError
from dehyst.identification.data import DataSet, Piece, chunks
from dehyst.identification.regressors import Bank

# Of the level of a piece that may have any.
TRACE = 1e-12


@dataclass(frozen=True, eq=False)
class NormalEquations:
    """Sums over samples of products of the columns [1 | cells | targets].

    Attributes
    ----------
    thresholds
        r, (n,), increasing from 0. [input]
    matrix
        Sums of weight times column times column, (1 + n + m, 1 + n + m), symmetric. The last target is y.
    counted
        Sum of the weights where levels were taken out of some samples; None: the first element of the matrix.
    """

    thresholds: Array
    matrix: Array
    counted: float | None = None

    @property
    def operators(self) -> int:
        """Number n of plays."""
        return self.thresholds.size

    @property
    def samples(self) -> float:
        """Sum of the weights: the number of samples where all count alike."""
        return float(self.matrix[0, 0]) if self.counted is None else self.counted

    def __add__(self, other: NormalEquations) -> NormalEquations:
        """Sums over the samples of both."""
        if not np.array_equal(self.thresholds, other.thresholds) or self.matrix.shape != other.matrix.shape:
            raise ParameterError(
                f"sums over {self.operators} and {other.operators} operators (matrices {self.matrix.shape} and "
                f"{other.matrix.shape}) belong to different columns and cannot be added. Accumulate both with the "
                f"same thresholds and the same extra columns.",
                operators=(self.operators, other.operators),
            )
        counted = None if self.counted is other.counted is None else self.samples + other.samples
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
        starts = np.concatenate([[0], 1 + np.flatnonzero(kept), np.arange(1 + n, self.matrix.shape[0])])
        merged = np.add.reduceat(np.add.reduceat(self.matrix, starts, axis=0), starts, axis=1)
        return NormalEquations(self.thresholds[kept], merged, self.counted)


def sums_of(
    data: DataSet, bank: Bank, knots: Array | None = None, span: Callable[[Piece], slice] | None = None
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
    return matrix if count == 0.0 else matrix - (1.0 - TRACE) / count * np.outer(matrix[0], matrix[0])


def ramp_columns(y: Array, knots: Array) -> Array:
    """Rows min(max(y - k_j, 0), k_{j+1} - k_j), (p, m): with slopes m_j they sum to a piecewise linear map."""
    ramp: Array = np.subtract(y, knots[:-1, None])
    return np.clip(ramp, 0.0, np.diff(knots)[:, None], out=ramp)
