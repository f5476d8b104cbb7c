"""The engine as the library uses it, in the shape that the benchmark times."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from dehyst import _native

Array = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

AUTO, EVENTS, DENSE = -1, 0, _native.ENGINE_DENSE
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


@dataclass(frozen=True)
class Program:
    """G and b of the cells alone, without the constant column, and |y|."""

    g: Array
    b: Array
    length: float


def program(sums: Array) -> Program:
    """Cut it out of the sums of products."""
    g, b = np.ascontiguousarray(sums[1:-1, 1:-1]), np.ascontiguousarray(sums[1:-1, -1])
    return Program(g, b, float(np.sqrt(sums[-1, -1])))


def solve(p: Program, passive: Mask | None = None) -> tuple[Array, Mask]:
    """Weights w >= 0, and which of them are off their bound."""
    n = p.b.size
    u, passive, *_ = _native.solve_bounded(
        p.g, p.b, np.zeros(n), 0, n, _native.WEIGHTS, None, None, passive, p.length
    )
    return u, passive


def weights(x: Array, y: Array, r: Array) -> Array:
    """Data to weights: one pass, one program."""
    return solve(program(cell_sums(x, y, r)))[0]


def in_weights(p: Program) -> tuple[Array, Array]:
    """Normal equations of the weights from those of the cells: z_i is the sum of cells i, i + 1, ..."""
    turned = p.g[::-1, ::-1].cumsum(axis=0).cumsum(axis=1)
    return np.ascontiguousarray(turned[::-1, ::-1]), np.ascontiguousarray(p.b[::-1].cumsum()[::-1])
