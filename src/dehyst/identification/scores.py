"""Predictions of a model over recordings, and how far they are from the data."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from dehyst.arrays import Array, Mask
from dehyst.data.ranges import robust_range
from dehyst.data.recording import Recording
from dehyst.identification.data import DataSet, Piece, chunks, range_over
from dehyst.identification.fit import InputError, Score
from dehyst.identification.levels import started
from dehyst.identification.regressors import Bank
from dehyst.models import HysteresisModel


class Readable(Protocol):
    """Samples that can be asked for part by part."""

    def __getitem__(self, part: slice, /) -> Array:
        """Samples of a part."""


@dataclass(frozen=True)
class Part:
    """Which samples of the recordings are meant, and how much each counts.

    Attributes
    ----------
    spans
        Spans of samples, for each recording.
    weights
        Weight of each sample of each recording, (T,), or None where all count alike.
    """

    spans: tuple[tuple[slice, ...], ...]
    weights: tuple[Array | None, ...]

    def __bool__(self) -> bool:
        """Whether there are any samples."""
        return any(True for _ in self.blocks())

    def blocks(self, *numbers: int) -> Iterator[tuple[int, slice, Array | None]]:
        """Recording, samples and their weights, a cacheful at a time; of some recordings only."""
        for index, (spans, weight) in enumerate(zip(self.spans, self.weights, strict=True)):
            if numbers and index not in numbers:
                continue
            for span in spans:
                for part in chunks(span):
                    chosen = None if weight is None else weight[part]
                    if chosen is None or np.any(chosen > 0.0):
                        yield index, part, chosen

    def mask(self, index: int, size: int) -> Mask:
        """Whether each sample of a recording of that size belongs to the part; those of no weight do not."""
        mask, weight = np.zeros(size, dtype=np.bool_), self.weights[index]
        for span in self.spans[index]:
            mask[span] = True if weight is None else weight[span] > 0.0
        return mask

    def moments(
        self, signals: Sequence[Readable], less: Sequence[Readable] | None = None, *numbers: int, extremes: bool = False
    ) -> Moments:
        """Count, mean, mean square and, if `extremes`, largest size of a signal, or of a difference of two."""
        count = first = second = largest = 0.0
        for index, part, weight in self.blocks(*numbers):
            values = signals[index][part] if less is None else signals[index][part] - less[index][part]
            scaled = values if weight is None else values * weight
            count += values.size if weight is None else float(np.sum(weight))
            first += float(np.sum(scaled))
            second += float(scaled @ values)
            if extremes:
                sized = values if weight is None else values[weight > 0.0]
                largest = max(largest, float(sized.max()), -float(sized.min()))
        return Moments(count, first / count if count else 0.0, second / count if count else 0.0, largest)


@dataclass(frozen=True, slots=True)
class Moments:
    """Sums over samples of a signal.

    Attributes
    ----------
    count, mean, square, largest
        Sum of the weights, weighted mean, weighted mean square, largest absolute value.
    """

    count: float
    mean: float
    square: float
    largest: float

    @property
    def rms(self) -> float:
        """Root of the mean square."""
        return float(np.sqrt(self.square))


def parts(records: tuple[Recording, ...], data: DataSet, initial_state: str) -> tuple[Part, Part]:
    """Fitted and held-out samples of each recording, without those whose memory is unknown."""
    fitted: list[list[slice]] = [[] for _ in records]
    held_out: list[list[slice]] = [[] for _ in records]
    weights: list[Array | None] = [None if not data.weighted else np.ones(len(record)) for record in records]
    for piece in data.pieces:
        for spans, span in ((fitted, piece.fitted(initial_state)), (held_out, piece.held_out(initial_state))):
            if span.stop > span.start:
                spans[piece.recording].append(slice(piece.start + span.start, piece.start + span.stop))
        given = weights[piece.recording]
        if given is not None and piece.weight is not None:
            given[piece.start : piece.start + piece.x.size] = piece.weight
    first, second = (Part(tuple(map(tuple, spans)), tuple(weights)) for spans in (fitted, held_out))
    return first, second


def part_of(masks: Sequence[Mask]) -> Part:
    """Return the samples that masks (T,) of all recordings choose."""
    spans = []
    for mask in masks:
        ends = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]]).astype(np.int8))).reshape(-1, 2)
        spans.append(tuple(slice(int(low), int(high)) for low, high in ends))
    return Part(tuple(spans), (None,) * len(spans))


def predictions(
    records: tuple[Recording, ...], data: DataSet, bank: Bank, model: HysteresisModel
) -> tuple[tuple[Array, ...], tuple[Array, ...]]:
    """Output of the model for each recording, and the input its inverse asks for to reach the measured output.

    Every piece starts from its own memory.
    """
    demands: list[list[Array]] = [[] for _ in records]
    for piece, begun in _started(data, bank, model):
        span = slice(piece.start, piece.start + piece.x.size)
        demands[piece.recording].append(begun.inverse().simulate(records[piece.recording].output[span]))
    return simulated(records, data, bank, model), tuple(map(_joined, demands))


def simulated(records: tuple[Recording, ...], data: DataSet, bank: Bank, model: HysteresisModel) -> tuple[Array, ...]:
    """Output of the model for each recording; every piece starts from its own memory."""
    outputs: list[list[Array]] = [[] for _ in records]
    for piece, begun in _started(data, bank, model):
        span = slice(piece.start, piece.start + piece.x.size)
        outputs[piece.recording].append(begun.simulate(records[piece.recording].input[span]))
    return tuple(map(_joined, outputs))


def _started(data: DataSet, bank: Bank, model: HysteresisModel) -> Iterator[tuple[Piece, HysteresisModel]]:
    """Each piece with the model in its state before it."""
    for piece, state in zip(data.pieces, bank.states, strict=True):
        yield piece, started(data, bank, model, state)


def _joined(pieces: list[Array]) -> Array:
    return pieces[0] if len(pieces) == 1 else np.concatenate(pieces)


def score(records: tuple[Recording, ...], outputs: Sequence[Readable], part: Part, output_range: float) -> Score | None:
    """Score of the chosen samples of all recordings together; None if there are none."""
    measured = [record.output for record in records]
    about = part.moments(measured)
    if about.count == 0.0:
        return None
    error = part.moments(outputs, measured, extremes=True)
    middle = [np.broadcast_to(about.mean, record.output.shape) for record in records]
    return score_of(error, part.moments(measured, middle).rms, output_range)


def score_of(error: Moments, deviation: float, output_range: float) -> Score:
    """Score from the moments of the error and the standard deviation of the output."""
    return Score(
        rmse=error.rms,
        rmse_percent=100.0 * error.rms / output_range,
        nrmse=error.rms / deviation if deviation > 0 else float("inf") if error.rms > 0 else 0.0,
        max=error.largest,
    )


def round_trip(model: HysteresisModel, x: Array) -> float:
    """Larger of max|inverse(model(x)) - x| and max|model(inverse(y)) - y|, y = model(x), relative to the ranges."""
    forward, inverse, again = (m.stepper("dense") for m in (model, model.inverse(), model))
    misses, ranges = np.zeros(2), np.array([[np.inf, -np.inf], [np.inf, -np.inf]])
    for part in chunks(slice(0, x.size)):
        y = forward.simulate(x[part])[0]
        back = inverse.simulate(y)[0]
        for k, (found, wanted) in enumerate(((back, x[part]), (again.simulate(back)[0], y))):
            misses[k] = max(misses[k], float(np.max(np.abs(found - wanted))))
            ranges[k] = min(ranges[k, 0], float(wanted.min())), max(ranges[k, 1], float(wanted.max()))
    return float(np.max(misses / np.maximum(ranges[:, 1] - ranges[:, 0], 1e-300)))


def input_error(records: tuple[Recording, ...], demands: Sequence[Array], part: Part) -> InputError | None:
    """Error of the input asked for, kept within the range that was applied; None if no samples are chosen."""
    inputs = [record.input for record in records]
    low, high = range_over(inputs)
    held = [np.clip(demand, low, high) for demand in demands]
    return input_error_of(part.moments(held, inputs), robust_range(inputs))


def input_error_of(moments: Moments, span: float) -> InputError | None:
    """Error from the moments of the input asked for less the input applied."""
    if not moments.count:
        return None
    return InputError(100.0 * moments.rms / span, 100.0 * moments.mean / span)
