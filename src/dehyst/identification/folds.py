"""Blocks of a short signal, summed once for one bank of operators, fitted and scored by every choice."""

from __future__ import annotations

from typing import Protocol

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array
from dehyst.identification.families import MAP_PIECES, Estimate, Regularisation, fit_family, mapped
from dehyst.identification.regressors import Bank
from dehyst.identification.short_signal import ShortSignal
from dehyst.identification.sums import NormalEquations, ramp_columns

Marks = npt.NDArray[np.bool_]

BLOCKS = 5
# What is left of a log without one block may not move every play; a trace of ridge keeps those at rest, whose
# weights would otherwise be anything. Relative to the rms of the scaled output.
FOLD_RIDGE = 1e-4


def output_knots() -> Array:
    """Knots of the output map over the training range, scaled."""
    return np.linspace(-1.0, 1.0, MAP_PIECES + 1)


def blocks_of(rows: int, blocks: int = BLOCKS) -> list[slice]:
    """Consecutive blocks of some rows."""
    parts = np.array_split(np.arange(rows), blocks)
    return [slice(int(part[0]), int(part[-1]) + 1) for part in parts]


class Setting(Protocol):
    """What a choice says about the program."""

    @property
    def family(self) -> str:
        """Model family."""

    @property
    def regularisation(self) -> Regularisation | None:
        """Of the output map."""


class Folds:
    """Consecutive blocks of the rows under one bank of operators."""

    def __init__(self, short: ShortSignal, bank: Bank, blocks: int = BLOCKS, ramps: bool = True) -> None:
        self._short, self._bank = short, bank
        self._y, self._weight = short.y, short.weight
        self._blocks = blocks_of(short.rows, blocks)
        self.knots = output_knots()
        self._samples = float(self._y.size if self._weight is None else np.sum(self._weight))
        self._targets = self._y[None, :]
        if ramps:
            self._targets = np.vstack([ramp_columns(self._y, self.knots), self._y])
        self._sums = short.sums(bank.thresholds, bank.states, self._targets, self._blocks)
        self._warm: dict[tuple[str, int], Marks | None] = {}

    def errors(self, choice: Setting, eps: float) -> Array:
        """RMSE on every block of the fit to the others, scaled, (blocks,)."""
        return np.array([error for _, _, error in self.estimates(choice, eps)])

    def estimates(self, choice: Setting, eps: float) -> list[tuple[Estimate, slice, float]]:
        """Fit to all blocks but one, the rows of that block and the RMSE on them, scaled, for each block."""
        estimates = [self._without(choice, eps, left_out) for left_out in range(len(self._blocks))]
        return [(found, block, self._rms(found, block)) for found, block in zip(estimates, self._blocks, strict=True)]

    def _without(self, choice: Setting, eps: float, left_out: int) -> Estimate:
        others = [block for k, block in enumerate(self._sums) if k != left_out]
        sums = self._summed(np.sum(others, axis=0), left_out)
        estimate = fit_family(
            choice.family, sums, eps, self.knots, choice.regularisation,
            fold_ridge=FOLD_RIDGE**2 * self._samples,
            warm=self._warm.get((choice.family, left_out)),
            triangle=lambda: self._triangle(left_out),
        )  # fmt: skip
        self._warm[choice.family, left_out] = estimate.passive
        return estimate

    def whole(self, choice: Setting, eps: float) -> tuple[Estimate, float]:
        """Fit to all rows, and its RMSE on these, scaled."""
        whole = self._sums[0] if len(self._sums) == 1 else np.sum(self._sums, axis=0)
        estimate = fit_family(
            choice.family, self._summed(whole, None), eps, self.knots, choice.regularisation,
            warm=self._warm.get((choice.family, -1)), triangle=lambda: self._triangle(None),
        )  # fmt: skip
        self._warm[choice.family, -1] = estimate.passive
        return estimate, self._rms(estimate, slice(0, self._y.size), alone=False)

    def _summed(self, matrix: Array, left_out: int | None) -> NormalEquations:
        """Sums with the count of the samples, where levels were taken out of them."""
        if not any(piece.own_level for piece in self._short.pieces):
            return NormalEquations(self._bank.thresholds, matrix)
        counts = np.ones(self._y.size) if self._weight is None else self._weight.copy()
        if left_out is not None:
            counts[self._blocks[left_out]] = 0.0
        return NormalEquations(self._bank.thresholds, matrix, float(np.sum(counts)))

    def _rms(self, estimate: Estimate, block: slice, alone: bool = True) -> float:
        bank = self._bank
        inner = self._short.outputs(bank.thresholds, bank.states, estimate.weights, estimate.offset)[block]
        residual = self._short.levelled(mapped(estimate, inner, self.knots) - self._y[block], block, alone)
        return float(np.sqrt(np.average(residual**2, weights=None if self._weight is None else self._weight[block])))

    def _triangle(self, left_out: int | None) -> Array:
        from dehyst.identification.least_squares import triangle  # only where normal equations will not do

        plays = self._short.plays(self._bank.thresholds, self._bank.states)
        rows = np.column_stack([np.ones(self._y.size), plays, self._targets.T])
        for block in self._blocks:
            rows[block] = self._short.levelled(rows[block], block, alone=False)
        if self._weight is not None:
            rows *= np.sqrt(self._weight)[:, None]
        return triangle(rows if left_out is None else np.delete(rows, self._blocks[left_out], axis=0))
