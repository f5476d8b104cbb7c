"""What one would use otherwise: numpy, numba, the core's dense step, chunked BLAS, solvers of quadratic programs.

A package that is not there gives None instead of a function; the table says "not installed".
"""

from __future__ import annotations

import ctypes
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from importlib.util import find_spec
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.optimize import nnls

from dehyst import _native

Array = npt.NDArray[np.float64]
CHUNK = 2048  # rows of play outputs that stay in the processor's cache
STEPPED = 63  # samples of a call up to which Stepper.simulate takes the core's steps
_NO_MAP = np.zeros(0)


def numpy_loop(x: Array, r: Array, w: Array) -> Array:
    """Time in Python, thresholds in numpy: the usual script."""
    z, y = np.zeros(r.size), np.empty(x.size)
    for k, u in enumerate(x.tolist()):
        z = np.maximum(u - r, np.minimum(u + r, z))
        y[k] = w @ z
    return y


def numpy_plays(x: Array, r: Array) -> Array:
    """Play outputs H (T, n) by the same script: what an identification script stores."""
    z, h = np.zeros(r.size), np.empty((x.size, r.size))
    for k, u in enumerate(x.tolist()):
        z = np.maximum(u - r, np.minimum(u + r, z))
        h[k] = z
    return h


@cache
def numba_loop() -> Callable[[Array, Array, Array], Array] | None:
    """The double loop, compiled; None without numba."""
    if find_spec("numba") is None:
        return None
    import numba

    @numba.njit
    def loop(x: Array, r: Array, w: Array) -> Array:
        z, y = np.zeros(r.size), np.empty(x.size)
        for k in range(x.size):
            total = 0.0
            for i in range(r.size):
                z[i] = max(x[k] - r[i], min(x[k] + r[i], z[i]))
                total += w[i] * z[i]
            y[k] = total
        return y

    loop(np.zeros(2), np.zeros(1), np.ones(1))  # compile before anything is timed
    return loop  # type: ignore[no-any-return]


def core_dense(x: Array, r: Array, w: Array) -> Array:
    """The step that is exported to the robot, sample by sample in C: in pieces so short that the engine keeps out."""
    stepper = _native.Stepper(r, w, 0.0, 0.0, _NO_MAP, _NO_MAP, _NO_MAP, _NO_MAP, np.zeros(r.size))
    y = np.empty(x.size)
    for k in range(0, x.size, STEPPED):
        y[k : k + STEPPED] = stepper.simulate(x[k : k + STEPPED])[0]
    return y


def chunked_blas(x: Array, y: Array, r: Array) -> Array:
    """Normal equations [H | y]'[H | y], (n + 1, n + 1): play outputs in C, products of 2048 rows by BLAS (syrk)."""
    z, total = np.zeros(r.size), np.zeros((r.size + 1, r.size + 1))
    rows = np.empty((CHUNK, r.size + 1))
    every = np.arange(CHUNK, dtype=np.int64)
    for k in range(0, x.size, CHUNK):
        part = x[k : k + CHUNK]
        h, z = _native.play_bank(part, r, z, every[: part.size])
        block = rows[: part.size]
        block[:, :-1], block[:, -1] = h, y[k : k + CHUNK]
        total += block.T @ block
    return total


def triangle(g: Array, b: Array) -> tuple[Array, Array]:
    """R and R^-T b of |R w - R^-T b|^2, the form in which scipy's nnls takes a quadratic program."""
    factor = np.linalg.cholesky(g)
    return np.ascontiguousarray(factor.T), np.linalg.solve(factor, b)


def solve_nnls(factor: Array, right: Array) -> Array:
    """scipy's Lawson-Hanson on the triangular factor, which is given and not timed."""
    return np.asarray(nnls(factor, right, maxiter=30 * right.size)[0])


def solve_quadprog(g: Array, b: Array) -> Array:
    """Goldfarb and Idnani's dual method."""
    import quadprog

    return np.asarray(quadprog.solve_qp(g, b, np.eye(b.size), np.zeros(b.size))[0])


def solve_daqp(g: Array, b: Array) -> Array:
    """Arnström's dual active set method."""
    import daqp

    n = b.size
    upper, sense = np.full(n, 1e30), np.zeros(n, dtype=ctypes.c_int)
    return np.asarray(daqp.solve(g, -b, np.zeros((0, n)), upper, np.zeros(n), sense)[0])


def solve_qpoases(g: Array, b: Array) -> Array:
    """Ferreau's online active set method, through casadi."""
    return np.asarray(_qpoases(b.size)(h=g, g=-b, lbx=0.0)["x"]).ravel()


@cache
def _qpoases(n: int) -> Any:
    import casadi

    dense = casadi.Sparsity.dense(n, n)
    options = {"printLevel": "none", "terminationTolerance": 1e-14, "nWSR": 10_000}
    with silence():  # its banner would stand in the JSON
        solver = casadi.conic(
            "dehyst", "qpoases", {"h": dense, "a": casadi.Sparsity(0, n)}, options
        )
        solver(h=np.eye(n), g=-np.ones(n), lbx=0.0)
    return solver


@contextmanager
def silence() -> Iterator[None]:
    """Nothing reaches standard output, not even from C."""
    sys.stdout.flush()
    kept, nowhere = os.dup(1), os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    try:
        yield
    finally:
        ctypes.CDLL(None).fflush(None)
        os.dup2(kept, 1)
        os.close(kept)
        os.close(nowhere)


PROGRAM_SOLVERS: dict[str, tuple[str, Callable[[Array, Array], Array]]] = {
    "DAQP": ("daqp", solve_daqp),
    "quadprog": ("quadprog", solve_quadprog),
    "qpOASES": ("casadi", solve_qpoases),
}


def solvers() -> dict[str, Callable[[Array, Array], Array] | None]:
    """Name -> w = solve(G, b), the minimum of w'Gw/2 - b'w over w >= 0; None if it is not installed."""
    return {
        name: solve if find_spec(package) else None
        for name, (package, solve) in PROGRAM_SOLVERS.items()
    }
