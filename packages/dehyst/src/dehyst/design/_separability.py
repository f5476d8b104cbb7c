"""Tests whether a motion separates hysteresis, creep and rate, from the regressors of the direct inverse.

    u = polynomial(y) + sum_i s_i E_i[y] + sum_j c_j (y - L_j[y]) + d dy/dt

is linear in its weights: what a motion cannot tell apart is seen in the singular values of its columns before anything
has been measured.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

import dehyst._native as _native
from dehyst.arrays import Array
from dehyst.errors import ParameterError

TIME_CONSTANTS = (
    4.0,
    25.0,
    150.0,
)  # of creep, a fixed grid: a factor of three beside the truth costs little [s]
OCTAVES = tuple(0.95 * 0.5**k for k in range(6, -1, -1))  # radii as shares of half the range
DEGREE = 3  # of the polynomial, which is free
SINGULAR = 1e-14  # ratio of eigenvalues of a Gram matrix below which columns are taken to be alike
LAG_BLOCK = 64  # samples whose lags are summed at once


@dataclass(frozen=True, slots=True)
class Separability:
    """How well the weights of a direct inverse follow from a motion. All columns scaled to rms one.

    Attributes
    ----------
    smallest
        Smallest singular value of the columns divided by sqrt(T), in 0..1: the rms of the output that the hardest
        combination of weights (of norm one) still makes. Noise of rms n gives weights off by n/(smallest sqrt(T)).
    condition
        Largest by smallest singular value.
    creep
        Smallest share (rms) of a creep column that no combination of all other columns imitates, in 0..1.
    rate
        The same of the viscous column.
    congruency
        The same of the stops in the upper half of the range apart from those in the lower half: whether minor loops
        may have another shape at another place.
    """

    smallest: float
    condition: float
    creep: float
    rate: float
    congruency: float


def columns(
    value: npt.ArrayLike,
    period: float,
    *,
    radii: Sequence[float] | Array,
    time_constants: Sequence[float] = TIME_CONSTANTS,
    degree: int = DEGREE,
) -> dict[str, Array]:
    """Return the regressors of the direct inverse along a motion.

    Parameters
    ----------
    value
        y, (T,), within -1..1. It begins at rest, stops at zero.
    period
        Of the samples. [s]
    radii
        Of the stops, (n,), > 0.
    time_constants
        Of creep, (m,). [s]
    degree
        Of the polynomial.

    Returns
    -------
    columns : dict
        ``polynomial`` (T, degree + 1), ``stops`` (T, n), ``creep`` (T, m), ``viscous`` (T, 1).

    Examples
    --------
    >>> found = columns([0.0, 1.0, 1.0], 1.0, radii=[0.5], time_constants=[1.0])
    >>> found["stops"].ravel().tolist(), found["creep"].ravel().round(3).tolist()
    ([0.0, 0.5, 0.5], [0.0, 0.368, 0.135])
    """
    y = np.ascontiguousarray(value, dtype=np.float64)
    r = np.ascontiguousarray(radii, dtype=np.float64)
    if y.ndim != 1 or y.size < 3 or not np.isfinite(y).all():
        raise ParameterError(
            f"a motion of shape {y.shape} has no regressors; pass three finite values or more."
        )
    plays, _ = _native.play_bank(y, r, np.full(r.size, y[0]), np.arange(y.size, dtype=np.int64))
    return {
        "polynomial": np.stack([y**k for k in range(degree + 1)], axis=1),
        "stops": y[:, None] - plays,
        "creep": y[:, None] - lags(y, period, time_constants),
        "viscous": np.gradient(y, period)[:, None],
    }


def lags(value: Array, period: float, time_constants: Sequence[float]) -> Array:
    """Return first-order lags of a signal, x <- x + (1 - exp(-T/tau)) (y - x) from x = y_0, (T, m).

    Examples
    --------
    >>> lags(np.array([0.0, 1.0, 1.0]), 1.0, [1.0]).ravel().round(3).tolist()
    [0.0, 0.632, 0.865]
    """
    decay = np.exp(-period / np.asarray(time_constants, dtype=np.float64))
    y = np.asarray(value, dtype=np.float64)
    out = np.empty((y.size, decay.size))
    x = np.full(decay.size, y[0])
    powers = decay ** np.arange(LAG_BLOCK + 1)[:, None]
    # Within a block x_k = d^k x_0 + sum_j d^(k-j) (1 - d) y_j: one triangular product for each time constant.
    i, j = np.indices((LAG_BLOCK, LAG_BLOCK))
    kernel = np.where(
        i >= j, (1 - decay)[:, None, None] * powers[np.maximum(i - j, 0)].transpose(2, 0, 1), 0.0
    )
    for begin in range(0, y.size, LAG_BLOCK):
        part = y[begin : begin + LAG_BLOCK]
        n = part.size
        out[begin : begin + n] = powers[1 : n + 1] * x + (kernel[:, :n, :n] @ part).T
        x = out[begin + n - 1]
    return out


def separability(
    value: npt.ArrayLike,
    period: float,
    *,
    time_constants: Sequence[float] = TIME_CONSTANTS,
) -> Separability:
    """Return how well stops, creep and rate can be told apart along a motion.

    Parameters
    ----------
    value
        y, (T,), within -1..1.
    period
        Of the samples. [s]
    time_constants
        As for `columns`. The radii are octaves: finely spaced ones are never told apart one by one, and need not be,
        since octaves ask for the shape of the loop.

    Examples
    --------
    One loop cannot tell creep from hysteresis; the same loop and a hold can:

    >>> loop = np.sin(2 * np.pi * np.arange(200) / 200)
    >>> held = np.concatenate([loop, np.linspace(0, 1, 50), np.ones(500), np.linspace(1, 0, 50)])
    >>> once, better = separability(loop, 0.1), separability(held, 0.1)
    >>> once.creep < 0.001 < 0.01 < better.creep
    True
    """
    bank = columns(value, period, radii=OCTAVES, time_constants=time_constants, degree=DEGREE)
    upper = bank["stops"] * np.clip(0.5 + 0.5 * bank["polynomial"][:, 1:2], 0.0, 1.0)
    placed = _unit(np.concatenate([*bank.values(), upper], axis=1))
    size = placed.shape[1] - upper.shape[1]
    gram = (
        placed.T @ placed
    )  # of 25 columns: condition numbers up to 1e7 are seen in it, more than any plan has
    values = np.linalg.eigvalsh(gram[:size, :size])
    # Rounding may make the smallest value negative.
    smallest, largest = np.sqrt(np.maximum(values[[0, -1]], 0.0)).tolist()
    shares = _own_shares(gram[:size, :size])
    first = size - 1 - bank["creep"].shape[1]
    return Separability(
        smallest=smallest,
        condition=largest / smallest if smallest > 0 else float("inf"),
        creep=float(shares[first:-1].min()),
        rate=float(shares[-1]),
        congruency=float(_own_shares(gram)[size:].min()),
    )


def _unit(table: Array) -> Array:
    """Columns of norm one; a column of zeros stays one, and makes the smallest singular value zero."""
    norm = np.linalg.norm(table, axis=0)
    return table / np.where(norm > 0, norm, 1.0)


def _own_shares(gram: Array) -> Array:
    """Share of each column of norm one that is orthogonal to all others: 1/sqrt of the diagonal of (X'X)^-1."""
    values, vectors = np.linalg.eigh(gram)
    if not values[0] > SINGULAR * values[-1]:
        return np.zeros(gram.shape[0])
    return np.asarray(1.0 / np.sqrt((vectors**2 / values).sum(axis=1)))
