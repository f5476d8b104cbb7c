"""Recordings as one data set: scaled, split, with the memory of every piece accounted for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from dehyst.errors import ExcitationError, ParameterError
from dehyst.identification.memory import known_from
from dehyst.recording import Recording

Array = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

# Correlation below which the overall trend of a wide loop is no evidence for a rising or falling curve.
CLEAR_TREND = 0.3


@dataclass(frozen=True)
class Piece:
    """Samples with continuous memory, in scaled units.

    Attributes
    ----------
    x, y
        Scaled input in [-1, 1] over the training part and scaled, rising output, (T,).
    recording
        Index of the recording, and `start`, the index of the first sample in it.
    train, test
        Which samples are fitted and which are held out by the split alone, (T,).
    known
        Index from which on the memory does not depend on what was before the first sample.
    after_break
        Whether nothing is known about the input before this piece.
    """

    x: Array
    y: Array
    recording: int
    start: int
    train: Mask
    test: Mask
    known: int
    after_break: bool

    def usable(self, initial_state: str) -> Mask:
        """Samples whose memory is known under the assumed initial state, (T,)."""
        mask = np.ones(self.x.size, dtype=np.bool_)
        if self.after_break or initial_state == "unknown":
            mask[: self.known] = False
        return mask


@dataclass(frozen=True)
class DataSet:
    """All pieces and the scaling x = center + half_range * x_scaled, y = level + trend * amplitude * y_scaled.

    Attributes
    ----------
    pieces
        The data.
    center, half_range
        Mid-range and half range of the training input. [input]
    level, amplitude
        Mid-range and half range of the training output. [output]
    trend
        +1 for curves that rise, -1 for curves that fall.
    output_range
        Range of the output over all samples, the unit of rmse_percent. [output]
    """

    pieces: tuple[Piece, ...]
    center: float
    half_range: float
    level: float
    amplitude: float
    trend: int
    output_range: float


def _trend(x: Array, y: Array) -> int:
    """+1 or -1: whether the output follows the input or opposes it.

    For wide loops the overall trend says nothing; then the increments decide, since a loop of either
    orientation moves its output with its input on average (sum dx dy > 0) when the curve rises.
    """
    correlation = float(np.corrcoef(x, y)[0, 1])
    if abs(correlation) >= CLEAR_TREND:
        return 1 if correlation > 0 else -1
    # Increments over 2 % of the range rather than single samples, whose noise would decide otherwise.
    grain = 0.02 * float(np.ptp(x))
    level = np.round(x / grain) if grain > 0 else x
    keep = np.flatnonzero(np.diff(level, prepend=np.nan) != 0)
    return 1 if float(np.sum(np.diff(x[keep]) * np.diff(y[keep]))) >= 0 else -1


def _split(recording: Recording, fraction: float) -> int:
    count = int(fraction * len(recording))
    return len(recording) if fraction >= 1.0 else max(1, min(len(recording) - 1, count))


def prepare(recordings: Sequence[Recording], train_fraction: float) -> DataSet:
    """Split, scale and cut recordings into pieces.

    Raises
    ------
    ParameterError
        If the fraction lies outside (0, 1].
    ExcitationError
        If input or output is constant over the training part.
    """
    if not 0.0 < train_fraction <= 1.0:
        raise ParameterError(
            f"train_fraction = {train_fraction:g} must lie in (0, 1]: the share of each recording that is fitted. "
            f"0.5 fits the first half and tests on the second; 1 fits all and tests nothing.",
            train_fraction=train_fraction,
        )
    splits = [_split(recording, train_fraction) for recording in recordings]
    x_train = np.concatenate([rec.input[:k] for rec, k in zip(recordings, splits, strict=True)])
    y_train = np.concatenate([rec.output[:k] for rec, k in zip(recordings, splits, strict=True)])
    _refuse_constant(recordings, x_train, "input", train_fraction)
    _refuse_constant(recordings, y_train, "output", train_fraction)
    center, half = _middle(x_train)
    level, amplitude = _middle(y_train)
    trend = _trend(x_train, y_train)
    low, high = -1.0, 1.0
    pieces: list[Piece] = []
    for index, (recording, split) in enumerate(zip(recordings, splits, strict=True)):
        for order, span in enumerate(recording.pieces):
            x = np.ascontiguousarray((recording.input[span] - center) / half)
            y = np.ascontiguousarray(trend * (recording.output[span] - level) / amplitude)
            train = np.arange(span.start, span.stop) < split
            pieces.append(Piece(x, y, index, span.start, train, ~train, known_from(x, low, high), order > 0))
    everything = np.concatenate([recording.output for recording in recordings])
    return DataSet(tuple(pieces), center, half, level, amplitude, trend, float(np.ptp(everything)))


def _middle(values: Array) -> tuple[float, float]:
    low, high = float(np.min(values)), float(np.max(values))
    return low + 0.5 * (high - low), 0.5 * (high - low)


def _refuse_constant(recordings: Sequence[Recording], values: Array, role: str, fraction: float) -> None:
    span = float(np.ptp(values))
    if span > 1e-9 * float(np.max(np.abs(values))) and span > 1e-150:
        return
    first = recordings[0]
    name = first.input_label if role == "input" else first.output_label
    part = "" if fraction >= 1.0 else f" in the first {100 * fraction:g} % of the recording, which is fitted"
    raise ExcitationError(
        f"{role} '{name}' stays at {float(values[0]):g}{part}. A loop needs a signal that moves, so nothing can be "
        f"identified. Check the column, choose a window in which it moves (--from, --to), or fit a larger part "
        f"(--train-fraction 1).",
        value=float(values[0]),
    )
