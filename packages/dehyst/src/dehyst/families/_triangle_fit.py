"""Least-squares fit of Preisach weights: convex, with the grid chosen on held-out blocks.

A model of this kind is linear in its masses, y = offset + states @ masses. Off the diagonal all masses have one sign:
positive, or negative where the loops run clockwise. On the diagonal they are at least what the smallest slope asks for.
Differences between neighbours are held small: along the diagonal, where equal masses are a Prandtl-Ishlinskii operator,
and less across it. How strongly, on which grid and from which start state, decides the error on blocks left out.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Protocol, Self, TypeVar

import numpy as np
import numpy.typing as npt

import dehyst._native as _native
from dehyst.arrays import Array, rank
from dehyst.errors import IdentificationError
from dehyst.families._policy import POLICY
from dehyst.families._training import Training
from dehyst.families._triangle import neighbours, on_diagonal

BLOCKS = 16
# Weight of a difference of masses against the residual of a sample, scaled.
SMOOTHING = (0.03, 0.1, 0.3, 1.0, 3.0)
ACROSS = (0.0, 0.3)  # the same across the diagonal, as a share of it
FIRST = (0.1, 0.3)  # smoothing and share with which start states are compared
RIDGE = 1e-3  # of every mass: cells that no sample visits would be anything
SLOPE = 0.001  # smallest slope right after a turn, scaled, as in the paper's fit
STARTS = ("zero", "rest", "rising", "falling", "origin")


def beyond(cells: int) -> int:
    """Cells that a grid has on either side of the fitted range: a tenth, filled by the smoothing alone.

    A log goes on a little further than its first part; a grid that ended there would be saturated, without memory.
    """
    return round(0.1 * cells)


class Cells(Protocol):
    """A model on the triangle, its masses still to be found."""

    @property
    def width(self) -> float:
        """Input over which a mass on the diagonal rises. [scaled input]"""

    def states(self, x: Array) -> Array:
        """States of the cells, (T, m), from the model's start."""

    def with_start(self, start: str) -> Self:
        """The same model from another start."""

    def with_masses(self, masses: Array, offset: float) -> Self:
        """The same model with masses (m,) and offset."""


C = TypeVar("C", bound=Cells)


@dataclass(frozen=True, eq=False)
class Blocks:
    """Sums of products of the columns [1 | states | y] over consecutive blocks of the samples, (blocks, 2 + m, 2 + m).

    Attributes
    ----------
    sign
        Of each mass, (m,): the states are multiplied by it.
    lower
        Least masses, (1 + m,), the offset's first and not used.
    """

    parts: Array
    sign: Array
    lower: Array

    @property
    def whole(self) -> Array:
        """Sums over all samples."""
        return np.asarray(self.parts.sum(axis=0))


@dataclass(frozen=True, eq=False)
class JudgedGrid:
    """A grid with its smoothing, and the error on the blocks left out, scaled."""

    error: float
    cells: Any
    blocks: Blocks
    smoothing: float
    share: float


def fit_triangle(
    training: Training, shapes: Sequence[C], last: Callable[[C], Sequence[C]] = lambda _: ()
) -> C:
    """Fit the masses of the best of several grids.

    Parameters
    ----------
    shapes
        Models without masses; the first also serves to choose start state and sign.
    last
        From the best shape to finer ones, which are tried with its smoothing only.

    Raises
    ------
    IdentificationError
        If the least squares cannot be solved.
    """
    thin = training.thinned()
    # Start state and sign are chosen on the first grid, the grid and its smoothing with these.
    coarse = []
    for sign in _signs(training):
        for start in STARTS:
            coarse.append(_judged(shapes[0].with_start(start), thin, sign, *FIRST))
    first = _clearly_best(coarse)
    start, sign = first.cells.start, float(np.min(first.blocks.sign))
    grids = []
    for shape in shapes:
        cells = shape.with_start(start)
        blocks = cell_blocks(thin, cells, sign)
        for share in ACROSS:
            for smoothing in SMOOTHING:
                error = left_out_error(blocks, smoothing, share)
                grids.append(JudgedGrid(error, cells, blocks, smoothing, share))
    best = min(grids, key=_error)
    finalists = [best]
    for cells in last(best.cells):
        finalists.append(_judged(cells, thin, sign, best.smoothing, best.share))
    best = min(finalists, key=_error)
    penalty = smooth(best.blocks.sign.size, best.smoothing, best.share)
    u, _ = solve(best.blocks.whole, penalty, best.blocks.lower)
    model: C = best.cells
    return model.with_masses(u[1:] * best.blocks.sign, float(u[0]))


def _signs(training: Training) -> tuple[float, ...]:
    """Return the signs of masses off the diagonal that the loops of the log allow."""
    signs = {"counter-clockwise": (1.0,), "clockwise": (-1.0,)}
    return signs.get(training.orientation, (1.0, -1.0))


def _judged(
    cells: C, training: Training, sign: float, smoothing: float, share: float
) -> JudgedGrid:
    blocks = cell_blocks(training, cells, sign)
    return JudgedGrid(left_out_error(blocks, smoothing, share), cells, blocks, smoothing, share)


def _error(grid: JudgedGrid) -> float:
    return rank(grid.error)


def _clearly_best(candidates: Sequence[JudgedGrid]) -> JudgedGrid:
    """Return the first candidate, unless another is clearly better."""
    best = min(candidates, key=_error)
    return best if best.error < POLICY.preisach_start * candidates[0].error else candidates[0]


def cell_blocks(training: Training, cells: Cells, sign: float) -> Blocks:
    """Sums over the blocks of the training part; masses off the diagonal get the sign."""
    rows = training.joined(lambda stretch: cells.states(stretch.x))
    flat = on_diagonal(rows.shape[1])
    signs = np.where(flat, 1.0, sign)
    rows *= signs
    columns = np.column_stack([np.ones(rows.shape[0]), rows, training.y])
    parts = np.array([block.T @ block for block in np.array_split(columns, BLOCKS)])
    lower = np.concatenate([[0.0], np.where(flat, 0.5 * SLOPE * cells.width, 0.0)])
    return Blocks(parts, signs, lower)


def smooth(cells: int, smoothing: float, share: float) -> Array:
    """Matrix (1 + m, 1 + m) of the penalty that stands beside one sample."""
    penalty = np.zeros((1 + cells, 1 + cells))
    for (a, b), weight in zip(neighbours(cells), (smoothing, share * smoothing), strict=True):
        np.add.at(penalty, (np.r_[a, b] + 1, np.r_[a, b] + 1), weight**2)
        np.add.at(penalty, (np.r_[a, b] + 1, np.r_[b, a] + 1), -(weight**2))
    penalty[1:, 1:] += RIDGE**2 * np.eye(cells)
    return penalty


def solve(
    sums: Array, penalty: Array, lower: Array, warm: npt.NDArray[np.bool_] | None = None
) -> tuple[Array, Any]:
    """Offset and masses, (1 + m,), and which are off their bounds."""
    gram, rhs = np.ascontiguousarray(sums[:-1, :-1]), np.ascontiguousarray(sums[:-1, -1])
    u, passive, kkt, _, _, status = _native.solve_bounded(
        gram, rhs, lower, 1, lower.size - 1, _native.SLOPES, penalty * sums[0, 0], None, warm,
        float(np.sqrt(sums[-1, -1])),
    )  # fmt: skip
    if status == 2 or not np.all(np.isfinite(u)):
        raise IdentificationError(
            f"the least squares of {lower.size - 1} cells has no solution in double precision (optimality {kkt:.2g}): "
            f"the input visits too few of them. Record loops of several amplitudes."
        )
    return u, passive


def left_out_error(blocks: Blocks, smoothing: float, share: float) -> float:
    """RMS error on each block of the fit to the others, scaled; infinite if one of them cannot be solved."""
    whole, penalty = blocks.whole, smooth(blocks.sign.size, smoothing, share)
    total = 0.0
    try:
        warm = solve(whole, penalty, blocks.lower)[1]
        for part in blocks.parts:
            v = np.append(solve(whole - part, penalty, blocks.lower, warm)[0], -1.0)
            total += max(float(v @ part @ v), 0.0)
    except IdentificationError:
        # Another grid may have a solution.
        return float("inf")
    return float(np.sqrt(total / whole[0, 0]))
