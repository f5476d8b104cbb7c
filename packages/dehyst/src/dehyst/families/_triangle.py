"""Cells of the Preisach triangle alpha >= beta: cell (i, j), j <= i, has number i (i + 1)/2 + j."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array


def triangle_size(n: int) -> int:
    """Number of cells of a triangle with n on a side."""
    return n * (n + 1) // 2


def side_of(cells: int) -> int:
    """Number of cells on a side."""
    return (math.isqrt(8 * cells + 1) - 1) // 2


def triangle_of(values: Array) -> Array:
    """Matrix (n, n) with the values of the cells and zeros above the diagonal."""
    n = side_of(values.size)
    square = np.zeros((n, n))
    square[np.tril_indices(n)] = values
    return square


def prefixes(masses: Array) -> Array:
    """Everett function at the lower ends from the masses: E of (i, j) weighs the cells i' <= i with j' >= j.

    Examples
    --------
    >>> prefixes(np.array([0.1, 0.7, 0.1])).round(6).tolist()
    [0.1, 0.9, 0.1]
    """
    square = triangle_of(masses)
    sums = np.cumsum(np.cumsum(square, axis=0)[:, ::-1], axis=1)[:, ::-1]
    return np.asarray(sums[np.tril_indices(square.shape[0])])


def masses_of(everett: Array) -> Array:
    """Masses of the cells from the Everett function: the inverse of `prefixes`."""
    square = triangle_of(everett)
    n = square.shape[0]
    # A mass is the mixed difference of E over its cell; beyond the triangle E is 0.
    padded = np.zeros((n + 1, n + 1))
    padded[1:, :n] = square
    cells = padded[1:, :n] - padded[:-1, :n] - padded[1:, 1:] + padded[:-1, 1:]
    return np.asarray(cells[np.tril_indices(n)])


def on_diagonal(cells: int) -> npt.NDArray[np.bool_]:
    """Which of the cells lie on the diagonal, i = j."""
    i, j = np.tril_indices(side_of(cells))
    return np.asarray(i == j)


Pairs = tuple[npt.NDArray[np.intp], npt.NDArray[np.intp]]


def neighbours(cells: int) -> tuple[Pairs, Pairs]:
    """Pairs of cells: next to each other along the diagonal; sharing a side, without those on it."""
    n = side_of(cells)
    # Numbers of the cells; -1 where the square has no cell.
    number = np.full((n, n), -1, dtype=np.intp)
    number[np.tril_indices(n)] = np.arange(cells)
    off = np.where(np.eye(n, dtype=np.bool_), -1, number)
    return _both(number[:-1, :-1], number[1:, 1:]), _joined(
        _both(off[:, :-1], off[:, 1:]), _both(off[:-1], off[1:])
    )


def _both(a: npt.NDArray[np.intp], b: npt.NDArray[np.intp]) -> Pairs:
    """Return the pairs of which both cells exist."""
    exist = (a >= 0) & (b >= 0)
    return a[exist], b[exist]


def _joined(first: Pairs, second: Pairs) -> Pairs:
    return np.concatenate([first[0], second[0]]), np.concatenate([first[1], second[1]])
