"""Predictions of a model over recordings, and how far they are from the data."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from dehyst.identification.data import DataSet
from dehyst.identification.fit import Score
from dehyst.identification.regressors import Bank
from dehyst.models import HysteresisModel, ModifiedPrandtlIshlinskii, PrandtlIshlinskii, StopOperatorModel
from dehyst.recording import Recording

Array = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]


def masks(
    records: tuple[Recording, ...], data: DataSet, initial_state: str
) -> tuple[tuple[Mask, ...], tuple[Mask, ...]]:
    """Train and test masks of each recording, without the samples whose memory is unknown."""
    train = [np.zeros(len(record), dtype=np.bool_) for record in records]
    test = [np.zeros(len(record), dtype=np.bool_) for record in records]
    for piece in data.pieces:
        span = slice(piece.start, piece.start + piece.x.size)
        usable = piece.usable(initial_state)
        train[piece.recording][span] = piece.train & usable
        test[piece.recording][span] = piece.test & usable
    return tuple(train), tuple(test)


def predictions(
    records: tuple[Recording, ...], data: DataSet, bank: Bank, model: HysteresisModel
) -> tuple[tuple[Array, ...], tuple[Array, ...]]:
    """Output of the model for each recording, and the input its inverse asks for to reach the measured output.

    Every piece starts from its own memory.
    """
    outputs = [np.empty(len(record)) for record in records]
    demands = [np.empty(len(record)) for record in records]
    thresholds = _thresholds(model)
    kept = np.searchsorted(bank.thresholds * data.half_range, thresholds)
    for piece, state in zip(data.pieces, bank.states, strict=True):
        span = slice(piece.start, piece.start + piece.x.size)
        started = model.with_state(state[kept] * data.half_range)
        outputs[piece.recording][span] = started.simulate(records[piece.recording].input[span])
        demands[piece.recording][span] = started.inverse().simulate(records[piece.recording].output[span])
    return tuple(outputs), tuple(demands)


def _thresholds(model: HysteresisModel) -> Array:
    if isinstance(model, ModifiedPrandtlIshlinskii):
        return model.hysteresis.thresholds
    if isinstance(model, (PrandtlIshlinskii, StopOperatorModel)):
        return model.thresholds
    raise AssertionError(f"no thresholds in {type(model).__name__}")


def score(
    records: tuple[Recording, ...], outputs: tuple[Array, ...], chosen: tuple[Mask, ...], output_range: float
) -> Score | None:
    """Score of the chosen samples of all recordings together; None if there are none."""
    measured = np.concatenate([record.output[mask] for record, mask in zip(records, chosen, strict=True)])
    if measured.size == 0:
        return None
    error = np.concatenate([y[mask] for y, mask in zip(outputs, chosen, strict=True)]) - measured
    rmse = float(np.sqrt(np.mean(error**2)))
    deviation = float(np.std(measured))
    return Score(
        rmse=rmse,
        rmse_percent=100.0 * rmse / output_range,
        nrmse=rmse / deviation if deviation > 0 else float("inf") if rmse > 0 else 0.0,
        max=float(np.max(np.abs(error))),
    )


def round_trip(model: HysteresisModel, x: Array) -> float:
    """Larger of max|inverse(model(x)) - x| and max|model(inverse(y)) - y|, y = model(x), relative to the ranges."""
    y = model.simulate(x)
    inverse = model.inverse()
    back = inverse.simulate(y)
    again = model.simulate(back)
    input_error = float(np.max(np.abs(back - x))) / max(float(np.ptp(x)), 1e-300)
    output_error = float(np.max(np.abs(again - y))) / max(float(np.ptp(y)), 1e-300)
    return max(input_error, output_error)


def inverse_miss(records: tuple[Recording, ...], demands: tuple[Array, ...], chosen: tuple[Mask, ...]) -> float:
    """RMS of the input asked for less the input applied, over the chosen samples, share of the input's range."""
    miss = np.concatenate([(x - rec.input)[mask] for rec, x, mask in zip(records, demands, chosen, strict=True)])
    inputs = np.concatenate([record.input for record in records])
    return float(np.sqrt(np.mean(miss**2))) / float(np.ptp(inputs))
