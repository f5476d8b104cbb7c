"""The engine as the library uses it, in the shape that the benchmark times."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from dehyst import _native

Array = npt.NDArray[np.float64]

AUTO, EVENTS, DENSE = -1, 0, 2**31 - 1
WEIGHTS = 1  # unknowns are weights of plays
LEVELS = ("portable", "avx2", "avx512")


def evaluator(r: Array, w: Array, method: int = AUTO) -> Any:
    """An evaluator at rest."""
    made = _native.Evaluator(r, w, 0.0, 0.0, np.zeros(r.size))
    if method != AUTO:
        made.method(method)
    return made


def cell_sums(x: Array, y: Array, r: Array) -> Array:
    """Sums of products of [1 | cells | y], (n + 2, n + 2), from rest."""
    gram = _native.Gram(r, np.zeros(r.size), 1)
    gram.add(x, y[None, :])
    return np.asarray(gram.take())


def solve(g: Array, b: Array, passive: npt.NDArray[np.uint8] | None = None) -> tuple[Array, npt.NDArray[np.uint8]]:
    """Weights w >= 0 from normal equations of cells, and which of them are off their bound."""
    n = b.size
    start = np.zeros(n, dtype=np.uint8) if passive is None else passive
    u, passive, *_ = _native.solve_bounded(g, b, np.zeros(n), 0, n, WEIGHTS, None, None, start)
    return np.asarray(u), passive


def weights(x: Array, y: Array, r: Array) -> Array:
    """Data to weights: one pass, one program."""
    g, b = inner(cell_sums(x, y, r))
    return solve(g, b)[0]


def inner(sums: Array) -> tuple[Array, Array]:
    """G and b of the cells alone, without the constant column."""
    return np.ascontiguousarray(sums[1:-1, 1:-1]), np.ascontiguousarray(sums[1:-1, -1])


def in_weights(g: Array, b: Array) -> tuple[Array, Array]:
    """Normal equations of the weights from those of the cells: z_i is the sum of cells i, i + 1, ..."""
    turned = g[::-1, ::-1].cumsum(axis=0).cumsum(axis=1)
    return np.ascontiguousarray(turned[::-1, ::-1]), np.ascontiguousarray(b[::-1].cumsum()[::-1])
