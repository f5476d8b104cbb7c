"""The other route: the families' programs on the triangular factor of [1 | plays | ramps | y].

It costs T n^2 operations instead of T, and scipy's import; it is taken where normal equations would lose digits.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from dehyst.arrays import Array
from dehyst.identification.data import DataSet, Piece
from dehyst.identification.least_squares import solve_bounded, triangle
from dehyst.identification.programs import Regularisation, lower_bounds, smoothing_rows
from dehyst.identification.regressors import Bank, blocks, ramps
from dehyst.identification.sums import TRACE

# Rows that are reduced at once: 1024 x 120 doubles, 1 MB, stay in the processor's cache, where the triangular
# factor takes a quarter of the time of 8192 rows.
CHUNK = 1024


def solve_family(
    family: str,
    system: Array,
    operators: int,
    eps: float,
    knots: Array | None = None,
    regularisation: Regularisation | None = None,
    fold_ridge: float = 0.0,
    samples: float | None = None,
) -> tuple[Array, float]:
    """Parameters u = [c | plays | slopes of the map] and KKT residual of one family's program.

    Parameters
    ----------
    system
        Triangular factor of [1 | plays | ramps | y]; the ramps only for "modified-pi".
    samples
        Number of rows behind it; None where its first column tells.
    """
    # QR keeps column lengths.
    length = float(np.linalg.norm(system[:, :1])) if samples is None else float(np.sqrt(samples))
    if fold_ridge:
        ridge = np.zeros((operators, system.shape[1]))
        ridge[np.arange(operators), 1 + np.arange(operators)] = np.sqrt(fold_ridge)
        system = np.vstack([system, ridge])
    one, plays, y = system[:, :1], system[:, 1 : 1 + operators], system[:, -1:]
    if family == "modified-pi":
        if knots is None or regularisation is None:
            raise AssertionError("the modified model needs knots and a regularisation")  # the caller gives them
        rows, rhs = smoothing_rows(regularisation, operators, np.diff(knots))
        ramp = system[:, 1 + operators : operators + knots.size]
        data = np.hstack([one, plays, -ramp, np.zeros((system.shape[0], 1))])
        system = np.vstack([data, length * np.column_stack([rows, rhs])])
    elif family == "pi-cumulative":
        differences = plays.copy()
        differences[:, :-1] -= plays[:, 1:]
        system = np.hstack([one, differences, y])
    elif family == "stop":
        stops = plays[:, :1] - plays
        stops[:, 0] = plays[:, 0]
        system = np.hstack([one, stops, y])
    else:
        system = np.hstack([one, plays, y])
    solution = solve_bounded(system, 1, lower_bounds(family, operators, eps, system.shape[1] - 2 - operators))
    return np.concatenate([solution.free, solution.bounded]), solution.kkt_residual


def reduce(
    data: DataSet, bank: Bank, knots: Array | None = None, span: Callable[[Piece], slice] | None = None
) -> Array:
    """Triangular factor of [1 | plays | ramps | y] over the fitted samples, in constant memory.

    Parameters
    ----------
    knots
        Knots of the output map: adds the ramp columns of `ramps`. None leaves them out.
    span
        Samples of a piece that count; by default those that are fitted.
    """
    factor: Array | None = None
    size = max(CHUNK, 2 * bank.thresholds.size)  # fewer rows than columns would not reduce anything
    for piece, state in zip(data.pieces, bank.states, strict=True):
        chosen = piece.fitted(bank.initial_state) if span is None else span(piece)
        own = piece.unknown_level(bank.initial_state) is not None
        before, factor = factor, None if own else factor
        for part, plays in blocks(piece.x, bank.thresholds, state, chosen, size):
            block = design(plays, piece.y[part], knots)
            if piece.weight is not None:
                block *= np.sqrt(piece.weight[part])[:, None]
            factor = triangle(block if factor is None else np.vstack([factor, block]))
        if own and factor is not None:
            factor[0] *= np.sqrt(TRACE)  # the row of the means
        if own and before is not None:
            factor = before if factor is None else triangle(np.vstack([before, factor]))
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
