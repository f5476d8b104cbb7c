"""Linear regressions of a measurement on its past and on valve positions, for many valves and blocks at once.

    y(t) = a_1 y(t-1) + ... + a_p y(t-p) + b_0 x(t-n) + ... + b_q x(t-n-q) + c

A long past stands for any dead time, lags and coloured noise, an integrating process included; without a past the noise
is that of the sensor alone.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import product

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array

Index = npt.NDArray[np.intp]
PAST = (0, 2, 4, 8, 12, 20)  # terms of the measurement's past that are tried
TAPS = (3, 6, 10, 16)  # terms of the position that are tried
RIDGE = 1e-11  # share of a column's square that keeps equal columns solvable
SMALLEST = 1e-300  # that is divided by
ROUNDING = 1e-12  # mean square that tells nothing more, of a measurement of deviation 1


@dataclass(frozen=True)
class BlockSums:
    """Products of all columns with each other, block by block: (k, B, m, m), the measurement last."""

    products: Array
    rows: int
    past: int
    taps: int

    @cached_property
    def total(self) -> Array:
        """Products over all blocks, (k, m, m)."""
        return np.asarray(self.products.sum(axis=1))

    @property
    def structures(self) -> list[tuple[int, int]]:
        """Pairs of terms of the past and of the position that are tried."""
        return [
            (past, taps)
            for past, taps in product(PAST, TAPS)
            if past <= self.past and taps <= self.taps
        ]

    def select(self, which: Index) -> BlockSums:
        """Return the sums of some of the valves."""
        return BlockSums(self.products[which], self.rows, self.past, self.taps)

    def columns(self, structure: tuple[int, int]) -> Index:
        """Places of its columns: past, position, constant and others, measurement."""
        past, taps = structure
        ends = range(self.past + self.taps, self.products.shape[-1])
        return np.array([*range(past), *range(self.past, self.past + taps), *ends])

    def errors(self, structure: tuple[int, int]) -> Array:
        """Sums of squares that are left, (k,)."""
        places = self.columns(structure)
        return _left(self.total[:, places[:, None], places])

    def redrawn_errors(self, structure: tuple[int, int], weights: Array) -> Array:
        """Sums of squares that are left where blocks count as often as the weights say: (R, B) to (R, k)."""
        places = self.columns(structure)
        part = self.products[:, :, places[:, None], places]
        return np.stack([_left(np.einsum("b,kbij->kij", weight, part)) for weight in weights])

    def block_errors(self, structure: tuple[int, int], k: int) -> Array:
        """Sums of squares of valve k in each block, (B,), with the coefficients of all blocks."""
        places = self.columns(structure)
        a = np.append(-self.coefficients(structure, k), 1.0)
        part = self.products[k][:, places[:, None], places]
        return np.asarray(np.einsum("i,bij,j->b", a, part, a))

    def coefficients(self, structure: tuple[int, int], k: int) -> Array:
        """Coefficients of valve k: past, position, constant and others."""
        places = self.columns(structure)
        return _coefficients(self.total[k][places[:, None], places])

    def criterion(self, more: int = 0) -> tuple[Array, list[tuple[int, int]]]:
        """Return Schwarz's criterion of each valve, the smaller the better, and its best structure.

        `more` are numbers that were fitted beside the columns.
        """
        floor = ROUNDING * self.rows
        scores = []
        for structure in self.structures:
            left = np.maximum(self.errors(structure), floor) / self.rows
            numbers = self.columns(structure).size - 1 + more
            scores.append(self.rows * np.log(left) + numbers * np.log(self.rows))
        table = np.array(scores)
        return table.min(axis=0), [self.structures[row] for row in table.argmin(axis=0)]


def _coefficients(total: Array) -> Array:
    square = total[..., :-1, :-1]
    scale = np.sqrt(np.maximum(np.einsum("...ii->...i", square), SMALLEST))
    scaled = square / scale[..., :, None] / scale[..., None, :]
    right = (total[..., :-1, -1] / scale)[..., None]
    solved = np.linalg.solve(scaled + RIDGE * np.eye(scale.shape[-1]), right)
    return np.asarray(solved[..., 0] / scale)


def _left(total: Array) -> Array:
    a = _coefficients(total)
    along = np.einsum("...i,...i->...", a, total[..., :-1, -1])
    inner = np.einsum("...i,...ij,...j->...", a, total[..., :-1, :-1], a, optimize=True)
    return np.asarray(np.maximum(total[..., -1, -1] - 2.0 * along + inner, 0.0))


def regression_sums(
    measured: Array, positions: Array, blocks: int, nearest: int, others: Array | None = None
) -> BlockSums:
    """Add up the products of all regressors in blocks of equal length.

    Parameters
    ----------
    measured
        y, (T,), about zero.
    positions
        x of each valve, (T, k), about zero.
    blocks
        Number of blocks B.
    nearest
        0 where the position of the same sample counts, 1 where it cannot have acted yet.
    others
        Further regressors beside the constant, (T, q).
    """
    size = measured.size
    # A short log has few rows for each number.
    past = max(count for count in PAST if count <= max(PAST[1], size // 20))
    taps = max(count for count in TAPS if count <= max(TAPS[0], size // 20))
    begin = max(past, taps + nearest)
    index = np.arange(begin, size)[(size - begin) % blocks :]
    tail = [np.ones(index.size)]
    if others is not None:
        tail += list(others[index].T)
    tail.append(measured[index])
    common = np.empty((index.size, past + len(tail)))
    common[:, :past] = measured[index[:, None] - np.arange(1, past + 1)]
    common[:, past:] = np.array(tail).T
    width, count = common.shape[1] + taps, positions.shape[1]
    here = np.r_[:past, past + taps : width]
    products = np.empty((count, blocks, width, width))
    parts = common.reshape(blocks, -1, common.shape[1])
    products[:, :, here[:, None], here] = parts.transpose(0, 2, 1) @ parts
    back = index[:, None] - np.arange(nearest, nearest + taps)
    middle = np.arange(past, past + taps)
    for k in range(count):
        moved = positions[:, k][back].reshape(blocks, -1, taps).transpose(0, 2, 1)
        across = moved @ parts
        products[k][:, middle[:, None], here] = across
        products[k][:, here[:, None], middle] = across.transpose(0, 2, 1)
        products[k][:, middle[:, None], middle] = moved @ moved.transpose(0, 2, 1)
    return BlockSums(products, index.size, past, taps)
