"""Recordings as one data set: scaled, split, with the initial state of every piece."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from dehyst.arrays import Array
from dehyst.data import Recording, range_over, robust_range
from dehyst.errors import ExcitationError, ParameterError
from dehyst.identification._memory import known_within
from dehyst.identification._split import Split

# Correlation below which the overall trend of a wide loop is no evidence for a rising or falling curve.
CLEAR_TREND = 0.3
# Samples that are worked on at once: two or three arrays of them stay in the processor's cache.
CHUNK = 1 << 15
# Facts that are statistics are taken from all samples of a log, but of a longer one from about so many.
LONG, ENOUGH = 200_000, 50_000
# A signal moves if its range has thousands of steps of double precision: +-4 on 1e12 has 65 000 of them.
RESOLVED = 1e-12
# Ranges, and gains between them, for which model and inverse have numbers below 1e100, the limit of the core.
LEAST_SPAN, MOST_SPAN = 1e-95, 1e95


@dataclass(frozen=True)
class Piece:
    """Samples with continuous memory, in scaled units."""

    # x, y: Scaled input in [-1, 1] over the training part and scaled, rising output, (T,)
    x: Array
    y: Array
    recording: int  # Index of the recording, and `start`, the index of the first sample in it
    start: int
    split: int  # Samples before this index are fitted, the others are held out by the split alone
    known: int  # Index from which on the memory does not depend on what was before the first sample
    after_break: bool  # Whether nothing is known about the input before this piece
    weight: Array | None = None  # How much each sample counts, (T,), or None where all count alike
    # Extremes of the input where the level is unknown even then (`dehyst.identification._memory.Known`), or None
    within: tuple[float, float] | None = None
    # Scaled input and output of strokes before the first sample that were estimated, (S, 2), or None
    lead: Array | None = None

    def begins_unknown(self, initial_state: str) -> bool:
        """Whether the memory before the first sample is unknown under the assumed initial state."""
        return self.after_break or initial_state == "unknown"

    def usable_from(self, initial_state: str) -> int:
        """First sample whose memory is known under the assumed initial state, its level apart."""
        if self.begins_unknown(initial_state):
            return self.known
        return 0

    def unknown_level(self, initial_state: str) -> tuple[float, float] | None:
        """Extremes of the input where plays wider than these add an unknown constant to the output, else None."""
        if self.begins_unknown(initial_state):
            return self.within
        return None

    def fitted(self, initial_state: str) -> slice:
        """Samples that are fitted."""
        begin = self.usable_from(initial_state)
        return slice(begin, max(begin, self.split))

    def held_out(self, initial_state: str) -> slice:
        """Samples that are held out."""
        begin = max(self.usable_from(initial_state), self.split)
        return slice(min(begin, self.x.size), self.x.size)


@dataclass(frozen=True)
class DataSet:
    """All pieces and the scaling x = center + half_range * x_scaled, y = level + trend * amplitude * y_scaled."""

    pieces: tuple[Piece, ...]  # The data
    # center, half_range: Mid-range and half range of the training input. [input]
    center: float
    half_range: float
    # level, amplitude: Mid-range and half range of the training output. [output]
    level: float
    amplitude: float
    trend: int  # +1 for curves that rise, -1 for curves that fall
    # Range of the output over all samples (`dehyst.data._ranges`), the unit of rmse_percent. [output]
    output_range: float

    @cached_property
    def short_signals(self) -> dict[tuple[str, int], Any]:
        """Short signals that stand for the fitted samples (`_short_signal.py`), by start state and size."""
        return {}

    @property
    def weighted(self) -> bool:
        """Whether some samples count more than others."""
        return any(piece.weight is not None for piece in self.pieces)


def inputs_of(records: Sequence[Recording]) -> list[Array]:
    """Return the input of each recording."""
    return [record.input for record in records]


def outputs_of(records: Sequence[Recording]) -> list[Array]:
    """Return the output of each recording."""
    return [record.output for record in records]


def input_range(records: Sequence[Recording]) -> tuple[float, float]:
    """Return the least and the largest input of recordings."""
    ranges = [record.input_range for record in records]
    return min(low for low, _ in ranges), max(high for _, high in ranges)


def output_range(records: Sequence[Recording]) -> tuple[float, float]:
    """Return the least and the largest output of recordings."""
    ranges = [record.output_range for record in records]
    return min(low for low, _ in ranges), max(high for _, high in ranges)


def all_timed(records: Sequence[Recording]) -> bool:
    """Whether all recordings have time stamps."""
    return all(record.time is not None for record in records)


def chunks(span: slice, size: int = CHUNK) -> Iterator[slice]:
    """Cut a span into consecutive parts, by default such that fit into the processor's cache."""
    for begin in range(span.start, span.stop, size):
        yield slice(begin, min(begin + size, span.stop))


def prepare(
    recordings: Sequence[Recording], split: Split, weights: Sequence[Array] | None = None
) -> DataSet:
    """Split, scale and cut recordings into pieces.

    Raises
    ------
    ParameterError
        If nothing that is fitted carries weight.
    ExcitationError
        If input or output is constant over the training part.
    """
    weights = counting(recordings, weights)
    inputs = []
    counted_inputs = []
    outputs = []
    counted_all = []
    for index, (recording, end) in enumerate(zip(recordings, split.ends, strict=True)):
        # Plays remember every input; what has no weight says nothing about the output.
        inputs.append(recording.input[:end])
        counted_inputs.append(_counted(recording.input[:end], weights, index))
        outputs.append(_counted(recording.output[:end], weights, index))
        counted_all.append(_counted(recording.output, weights, index))
    _refuse_weightless(outputs)
    center, half = middle(recordings[0], range_over(inputs), "input", split.fitted_part)
    level, amplitude = middle(recordings[0], range_over(outputs), "output", split.fitted_part)
    require_gain(recordings[0], half, amplitude)
    trend = _trend(counted_inputs, outputs, (center, half), (level, amplitude))
    pieces: list[Piece] = []
    for index, (recording, end) in enumerate(zip(recordings, split.ends, strict=True)):
        for order, span in enumerate(recording.pieces):
            x = _scaled(recording.input[span], center, half)
            y = _scaled(recording.output[span], level, trend * amplitude)
            inside = min(max(end - span.start, 0), x.size)
            weight = None
            if weights is not None:
                weight = np.ascontiguousarray(weights[index][span])
            memory = known_within(x)
            pieces.append(
                Piece(x, y, index, span.start, inside, memory[0], order > 0, weight, memory[1])
            )
    whole = robust_range(counted_all)
    return DataSet(tuple(pieces), center, half, level, amplitude, trend, whole)


def arrays_of(values: object, records: Sequence[Recording]) -> tuple[Array, ...]:
    """Return one array for each recording; one array, or one plain list of numbers, is that of the only recording."""
    listed = values
    if isinstance(values, np.ndarray) and values.ndim == 1:
        listed = [values]
    arrays = tuple(np.ascontiguousarray(part, dtype=np.float64) for part in listed)  # type: ignore[attr-defined]
    plain = len(records) == 1 and len(arrays) == len(records[0]) and not any(map(np.ndim, arrays))
    if plain:
        arrays = (np.array(arrays, dtype=np.float64),)
    return arrays


def shape_misfit(arrays: Sequence[Array], records: Sequence[Recording]) -> str:
    """Return in words how arrays differ in shape from the samples of the recordings; "" if they fit."""
    shapes = list(map(np.shape, arrays))
    sizes = list(map(len, records))
    if shapes == list(zip(sizes, strict=True)):
        return ""
    return f"the shapes {shapes} for recordings of {sizes} samples"


def counting(
    recordings: Sequence[Recording], weights: Sequence[Array] | None
) -> Sequence[Array] | None:
    """How much each sample counts: as given, 0 where it was left out; None where all count alike."""
    if not any(recording.left_out for recording in recordings):
        return weights
    counts = []
    for index, recording in enumerate(recordings):
        count = np.ones(len(recording))
        if weights is not None:
            count = weights[index].copy()
        count[list(recording.left_out)] = 0.0
        counts.append(count)
    return counts


def _counted(values: Array, weights: Sequence[Array] | None, index: int) -> Array:
    """Those values that carry weight."""
    if weights is None:
        return values
    return values[weights[index][: values.size] > 0.0]


def _refuse_weightless(outputs: Sequence[Array]) -> None:
    if not any(y.size for y in outputs):
        raise ParameterError(
            "all weights of the part that is fitted are 0: no sample is left to identify from. Give some of them a "
            "weight, or fit a larger part (--train-fraction)."
        )


def _scaled(values: Array, origin: float, unit: float) -> Array:
    scaled: Array = np.subtract(values, origin)
    scaled /= unit
    return scaled


def middle(
    first: Recording, extremes: tuple[float, float], role: str, part: str
) -> tuple[float, float]:
    """Mid-range and half range of a signal from its extremes; refuse one that does not move, or not by numbers.

    `part` is where it was looked at, in words.
    """
    low, high = extremes
    span, largest = high - low, max(abs(low), abs(high))
    if span >= RESOLVED * largest and LEAST_SPAN <= span <= MOST_SPAN:
        return low + 0.5 * span, 0.5 * span
    name = first.output_label
    if role == "input":
        name = first.input_label
    if span == 0.0:
        raise ExcitationError(
            f"{role} '{name}' stays at {low:g}{part}. A loop needs a signal that moves, so nothing can be "
            f"identified. Check the column, choose a window in which it moves (--from, --to), or fit a larger part "
            f"(--train-fraction 1).",
            value=low,
        )
    moves = f"{role} '{name}' moves by {span:.3g}{part}"
    if span < RESOLVED * largest:
        raise ExcitationError(
            f"{moves}, on an offset of {largest:.3g}, where numbers of double precision are {np.spacing(largest):.2g} "
            f"apart: too few steps to tell a loop from rounding. If it is a signal, log it without the offset; "
            f"otherwise choose a column or a window in which it moves more (--from, --to).",
            value=low,
            span=span,
        )
    raise ExcitationError(
        f"{moves}, and a model of it cannot be written in double precision: its numbers must lie between "
        f"{LEAST_SPAN:g} and {MOST_SPAN:g}. Log it in another unit, for example {_times(min(span, largest))}.",
        span=span,
    )


def require_gain(first: Recording, half_range: float, amplitude: float) -> None:
    """Refuse two signals of which no model, or no inverse, has numbers that can be written."""
    if LEAST_SPAN <= amplitude / half_range <= MOST_SPAN:
        return
    raise ExcitationError(
        f"output '{first.output_label}' moves by {2 * amplitude:.3g} while input '{first.input_label}' moves by "
        f"{2 * half_range:.3g}: a model from one to the other cannot be written in double precision, its weights would "
        f"be near {amplitude / half_range:.0e}. Log the output in another unit, for example {_times(amplitude)}, or "
        f"the input {_times(half_range)}.",
        spans=(2 * half_range, 2 * amplitude),
    )


def _times(size: float) -> str:
    """Power of ten that makes a signal one of ordinary size."""
    return f"times 1e{-math.floor(math.log10(size)):+d}"


def _trend(
    inputs: Sequence[Array],
    outputs: Sequence[Array],
    x_scale: tuple[float, float],
    y_scale: tuple[float, float],
) -> int:
    """+1 or -1: whether the output follows the input or opposes it.

    For wide loops the overall trend says nothing; then the increments decide, since a loop of either
    orientation moves its output with its input on average (sum dx dy > 0) when the curve rises.
    """
    moments = np.zeros(6)
    for whole_x, whole_y in zip(inputs, outputs, strict=True):
        for part in chunks(slice(0, whole_x.size)):
            x, y = _scaled(whole_x[part], *x_scale), _scaled(whole_y[part], *y_scale)
            moments += np.array([x.size, np.sum(x), np.sum(y), x @ x, y @ y, x @ y])
    clear = clear_trend(moments)
    if clear:
        return clear
    whole_x, whole_y = np.concatenate(inputs), np.concatenate(outputs)
    return trend_of_increments(whole_x, whole_y, x_scale[1])


def clear_trend(moments: Array) -> int:
    """+1 or -1 where the overall trend is clear, else 0; from sums (count, x, y, xx, yy, xy)."""
    count, x_sum, y_sum, xx, yy, xy = moments.tolist()
    spread = (xx - x_sum**2 / count) * (yy - y_sum**2 / count)
    if not spread > 0.0:
        return 0
    correlation = (xy - x_sum * y_sum / count) / np.sqrt(spread)
    if abs(correlation) < CLEAR_TREND:
        return 0
    if correlation > 0:
        return 1
    return -1


def trend_of_increments(x: Array, y: Array, half_range: float) -> int:
    """+1 or -1 by the sum of dx dy; of long logs in twenty stretches.

    Increments over 2 % of the range rather than single samples, whose noise would decide otherwise.
    """
    grain, total = 0.02 * 2.0 * half_range, 0.0
    edges, longest = [0, x.size], x.size
    if x.size > LONG:
        edges, longest = np.linspace(0, x.size, 21).astype(int).tolist(), ENOUGH // 20
    for begin, end in itertools.pairwise(edges):
        stretch = slice(begin, min(end, begin + longest))
        level = x[stretch]
        if grain > 0:
            level = np.round(level / grain)
        keep = begin + np.flatnonzero(np.diff(level, prepend=np.nan) != 0)
        total += float(np.sum(np.diff(x[keep]) * np.diff(y[keep])))
    if total >= 0:
        return 1
    return -1
