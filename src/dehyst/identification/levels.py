"""Levels of pieces whose wide plays remember nobody knows what: found from the data, as far as a memory can explain."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from dehyst.arrays import Array
from dehyst.identification.data import DataSet, Piece, chunks
from dehyst.identification.regressors import Bank
from dehyst.models import HysteresisModel


def settled(data: DataSet, bank: Bank, model: HysteresisModel) -> Bank:
    """Bank whose states before pieces of unknown level are such that the mean error of the piece vanishes, if any is.

    A play wider than the piece stands still anywhere between M - r and m + r, M and m the extremes of the input there.
    All wide plays are moved by the same share of what they can, so that what no memory of theirs explains stays in the
    errors. The mean is that of the fitted samples of a piece, and of the held-out ones where none was fitted.
    """
    pairs = zip(data.pieces, bank.states, strict=True)
    return replace(bank, states=tuple(_settled(data, bank, model, piece, state) for piece, state in pairs))


def started(data: DataSet, bank: Bank, model: HysteresisModel, state: Array) -> HysteresisModel:
    """Model with a state of the bank, (n,), scaled."""
    kept = np.searchsorted(bank.thresholds * data.half_range, model.radii)
    return model.with_state(state[kept] * data.half_range)


def _settled(data: DataSet, bank: Bank, model: HysteresisModel, piece: Piece, state: Array) -> Array:
    within, span = piece.unknown_level(bank.initial_state), piece.fitted(bank.initial_state)
    if span.stop <= span.start:
        span = piece.held_out(bank.initial_state)
    if within is None or span.stop <= span.start:
        return state
    spare = np.maximum(bank.thresholds - 0.5 * (within[1] - within[0]), 0.0)
    low, high = (_miss(data, piece, span, started(data, bank, model, state + side * spare)) for side in (-1.0, 1.0))
    if low == high:
        return state
    moved: Array = state + float(np.clip((low + high) / (low - high), -1.0, 1.0)) * spare
    return moved


def _miss(data: DataSet, piece: Piece, span: slice, model: HysteresisModel) -> float:
    """Sum of the measured output less that of the model over a span. [output]"""
    stepper, total = model.stepper("dense"), 0.0
    for part in chunks(slice(0, span.start)):
        stepper.simulate(data.center + data.half_range * piece.x[part])
    for part in chunks(span):
        output = stepper.simulate(data.center + data.half_range * piece.x[part])[0]
        miss = data.level + data.trend * data.amplitude * piece.y[part] - output
        total += float(np.sum(miss) if piece.weight is None else miss @ piece.weight[part])
    return total
