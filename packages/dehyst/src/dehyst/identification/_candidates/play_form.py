"""Plays as their program saw them, for intervals: rows of plays, and of the slopes of an output map."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

import dehyst._native as _native
from dehyst.arrays import Array
from dehyst.families.kit import NEXT_TO_NOTHING, LinearForm
from dehyst.identification._data import DataSet, Piece
from dehyst.identification._families import (
    Estimate,
    build_model,
    estimate_of,
    lower_bounds,
    mapped,
    smoothing_rows,
)
from dehyst.identification._regressors import PlayBank, ramp_columns
from dehyst.identification._selection import Choice
from dehyst.models import HysteresisModel, PrandtlIshlinskii, ShearedPrandtlIshlinskii

# Rows of all pieces; of a longer log each stands for several samples.
MOST_ROWS = 20_000
SMALLEST = 1e-12  # root of a weight that divides


@dataclass(frozen=True, eq=False)
class PlayForm:
    """A fit of plays: what `Fit.interval` needs of it.

    Attributes
    ----------
    data, bank, choice, knots, estimate
        Of the fit, with states of the bank that are settled.
    eps
        Smallest slope, scaled.
    """

    data: DataSet
    bank: PlayBank
    choice: Choice
    knots: Array | None
    estimate: Estimate
    eps: float

    def __call__(self, model: Any) -> LinearForm:
        """Return the linear form, whose models have the card and the shear of a model."""
        estimate, n = self.estimate, self.bank.thresholds.size
        start, samples = self.bank.initial_state, 0
        for piece in self.data.pieces:
            samples += max(0, piece.fitted(start).stop - piece.fitted(start).start)
        every = max(1, -(-samples // MOST_ROWS))
        parts = []
        for piece, state in zip(self.data.pieces, self.bank.states, strict=True):
            parts.append(self._piece(piece, state, every))
        rows, miss, x, y, weight = map(np.concatenate, zip(*parts, strict=True))
        root = np.sqrt(weight)
        data = self.data
        pieces = 0 if self.knots is None else self.knots.size - 1
        size = 1 + n + pieces
        penalty = np.zeros((size, size))
        if self.knots is not None and self.choice.regularisation is not None:
            smoothing, _ = smoothing_rows(self.choice.regularisation, n, np.diff(self.knots))
            penalty = smoothing.T @ smoothing
        lower = lower_bounds(self.choice.family, n, self.eps, pieces)

        def with_unknowns(u: Array) -> Any:
            drawn = estimate_of(estimate.family, n, u, 0.0, "", 1.0, None)
            weights = np.where(drawn.weights == 0.0, NEXT_TO_NOTHING, drawn.weights)
            return self._model(drawn, weights, model)

        unknowns = estimate.parameters
        lower = np.concatenate([[0.0], lower])
        settled = with_unknowns(unknowns)
        return LinearForm(
            rows=rows * root[:, None],
            miss=miss * root,
            unknowns=unknowns,
            lower=lower,
            penalty=penalty,
            inputs=data.center + data.half_range * x,
            outputs=data.level + data.trend * data.amplitude * y,
            unit=data.amplitude / np.maximum(root, SMALLEST),
            estimate=settled,
            model=with_unknowns,
        )

    def _model(self, estimate: Estimate, weights: Array, model: Any) -> HysteresisModel:
        built = build_model(
            replace(estimate, weights=weights), self.data, self.bank, self.knots, model.card
        )
        if model.shear is not None:
            assert isinstance(built, PrandtlIshlinskii)
            return ShearedPrandtlIshlinskii(built, model.shear)
        return built

    def _piece(self, piece: Piece, state: Array, every: int) -> tuple[Array, ...]:
        """Rows (k, 1 + n + p) of a piece, what was measured less the model, input, output, weight, (k,); scaled.

        They are those of each `every`-th sample.
        """
        start = self.bank.initial_state
        fitted = piece.fitted(start)
        at = np.arange(fitted.start, fitted.stop, every, dtype=np.int64)
        plays, _ = _native.play_bank(
            np.ascontiguousarray(piece.x[: fitted.stop]), self.bank.thresholds, state, at
        )
        columns = plays
        family = self.choice.family
        if family == "pi-cumulative":
            columns = plays.copy()
            columns[:, :-1] -= plays[:, 1:]
        elif family == "stop":
            columns = plays[:, :1] - plays
            columns[:, 0] = plays[:, 0]
        rows = np.hstack([np.ones((at.size, 1)), columns])
        u, size = self.estimate.parameters, rows.shape[1]
        outputs = mapped(self.estimate, rows @ u[:size], self.knots)
        if self.knots is not None and self.estimate.slopes is not None:
            place = np.clip(
                np.searchsorted(self.knots, outputs) - 1, 0, self.estimate.slopes.size - 1
            )
            rows = np.hstack([rows, -ramp_columns(outputs, self.knots).T])
            rows /= self.estimate.slopes[place][:, None]
        miss = piece.y[at] - outputs
        if piece.unknown_level(start) and at.size:
            # The piece has a constant of its own.
            rows = rows - rows.mean(axis=0, keepdims=True)
            miss = miss - miss.mean()
        weight = np.ones(at.size)
        if piece.weight is not None:
            weight = piece.weight[at]
        return rows, miss, np.asarray(piece.x[at]), outputs, weight
