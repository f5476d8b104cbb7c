"""Logs as one data set whose samples are read from the file on demand."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from dehyst.arrays import Array
from dehyst.data.ranges import robust_range
from dehyst.identification.data import DataSet, Piece, clear_trend, middle, require_gain, trend_of_increments
from dehyst.identification.facts import Branches, shares, spread, strokes
from dehyst.identification.memory import VISITED, Known, known_of
from dehyst.identification.split import HALF, LEAST_RECORDINGS, Outline, Split, checked, end_of, whole, whole_recordings
from dehyst.identification.stream.log import Log, spans
from dehyst.identification.stream.outline import PLACE, VALUE, Zigzag
from dehyst.identification.stream.samples import INPUT, OUTPUT, Column

# Swings that count, of the scaled input: a twentieth of its range.
SWING = 0.1


def split_logs(logs: Sequence[Log], train_fraction: float | None) -> Split:
    """What is fitted of each log, as `dehyst.identification.split.split_recordings` says it of recordings."""
    share, sizes = checked(train_fraction), [log.samples for log in logs]
    if share is None and len(logs) >= LEAST_RECORDINGS:
        held = whole_recordings([_outline(log) for log in logs])
        if held:
            return whole(sizes, held)
    share = HALF if share is None else share
    return Split(tuple(end_of(size, share) for size in sizes), share)


def _outline(log: Log) -> Outline:
    low, high = log.reader.extremes(0, log.samples, OUTPUT)
    return Outline(log.samples, *log.reader.extremes(0, log.samples, INPUT), high - low)


def prepare(logs: Sequence[Log], split: Split) -> DataSet:
    """Split, scale and cut logs into pieces, as `dehyst.identification.data.prepare` does with recordings."""
    center, half = middle(logs[0].recording, _range(logs, split.ends, INPUT), "input", split.fitted_part)
    level, amplitude = middle(logs[0].recording, _range(logs, split.ends, OUTPUT), "output", split.fitted_part)
    require_gain(logs[0].recording, half, amplitude)
    trend = clear_trend(_moments(logs, split.ends)) or _trend(logs, split.ends, half)
    pieces = []
    for index, (log, end) in enumerate(zip(logs, split.ends, strict=True)):
        for order, span in enumerate(log.pieces):
            size = span.stop - span.start
            x = Column(log.reader, INPUT, span.start, size, center, half)
            y = Column(log.reader, OUTPUT, span.start, size, level, trend * amplitude)
            inside = min(max(end - span.start, 0), size)
            known, within = _known(log, span, center, half)
            pieces.append(Piece(x, y, index, span.start, inside, known, order > 0, within=within))
    # The rows that are kept have the extremes of the log among them, and those of every bucket.
    whole = robust_range([log.recording.output for log in logs])
    return DataSet(tuple(pieces), center, half, level, amplitude, trend, whole)


def _range(logs: Sequence[Log], ends: Sequence[int], signal: int) -> tuple[float, float]:
    found = [log.reader.extremes(0, end, signal) for log, end in zip(logs, ends, strict=True) if end]
    return min(low for low, _ in found), max(high for _, high in found)


def _moments(logs: Sequence[Log], splits: Sequence[int]) -> Array:
    """Sums (count, x, y, xx, yy, xy) over the fitted samples, of differences from the first sample of all."""
    total, origin = np.zeros(6), logs[0].reader.outline.origin
    for log, split in zip(logs, splits, strict=True):
        sums, (x0, y0), end = log.reader.outline.moments(split)
        dx, dy = x0 - origin[0], y0 - origin[1]
        count, x, y, xx, yy, xy = sums.tolist()
        total += np.array(
            [
                count,
                x + count * dx,
                y + count * dy,
                xx + 2 * dx * x + count * dx * dx,
                yy + 2 * dy * y + count * dy * dy,
                xy + dx * y + dy * x + count * dx * dy,
            ]
        )
        for part in spans(end, split):
            a = log.reader.read(part.start, part.stop, INPUT) - origin[0]
            b = log.reader.read(part.start, part.stop, OUTPUT) - origin[1]
            total += np.array([a.size, a.sum(), b.sum(), a @ a, b @ b, a @ b])
    return total


def _trend(logs: Sequence[Log], splits: Sequence[int], half: float) -> int:
    """Trend by increments, over the fitted samples of all logs one after the other."""
    begins = np.concatenate([[0], np.cumsum(splits)])

    def part_of(part: slice, signal: int) -> Array:
        found = []
        for log, begin, split in zip(logs, begins.tolist(), splits, strict=False):
            low, high = max(part.start - begin, 0), min(part.stop - begin, split)
            found.append(log.reader.read(low, max(low, high), signal))
        return np.concatenate(found)

    return trend_of_increments(lambda part: (part_of(part, INPUT), part_of(part, OUTPUT)), int(begins[-1]), half)


def _known(log: Log, span: slice, center: float, half: float) -> Known:
    """What is known of the memory within a piece, as `dehyst.identification.memory` finds it."""

    def visited(low: float, high: float) -> int:
        slack = VISITED * (high - low)
        first = log.reader.first_beyond(center + half * (low + slack), True, span.start, span.stop)
        last = log.reader.first_beyond(center + half * (high - slack), False, span.start, span.stop)
        return max(first, last) - int(span.start)

    low, high = ((value - center) / half for value in log.reader.extremes(span.start, span.stop, INPUT))
    return known_of(span.stop - span.start, low, high, visited)


def branches(data: DataSet) -> tuple[Branches, ...]:
    """Fitted samples of each piece on rising and falling branches, as `dehyst.identification.facts.branches`."""
    return tuple(_branches(piece, most) for piece, most in zip(data.pieces, shares(data), strict=True))


def _first_branch(piece: Piece) -> int:
    """First turning point of the fitted part, 0 if there is only one."""
    zigzag, first = Zigzag(SWING), 0
    for part in spans(0, piece.split):
        points = zigzag.add(part.start, piece.x[part])
        if points.size and not first:
            first = int(points[0, PLACE])
        if zigzag.inner > 1:
            return first
    return 0


def _branches(piece: Piece, most: int) -> Branches:
    rows = spread(_first_branch(piece) if most else 0, piece.split, most)
    x, y, falling = np.empty(rows.size), np.empty(rows.size), np.zeros(rows.size, dtype=np.bool_)
    zigzag, told, turns = Zigzag(SWING), 0, [np.zeros((0, 2))]
    before = np.zeros((1, 2))
    for part in spans(0, piece.split):
        signal = piece.x[part]
        if part.start == 0:
            before[0, VALUE] = signal[0]
        low, high = np.searchsorted(rows, [part.start, part.stop])
        x[low:high], y[low:high] = signal[rows[low:high] - part.start], piece.y[part][rows[low:high] - part.start]
        found = zigzag.add(part.start, signal)
        turns.append(found)
        if part.stop == piece.split:
            found = np.concatenate([found, [[part.stop - 1.0, signal[-1]]]])
        points = np.concatenate([before, found])
        end = int(np.searchsorted(rows, points[-1, PLACE]))
        branch = np.searchsorted(points[:, PLACE], rows[told:end], side="right")
        falling[told:end] = points[branch, VALUE] <= points[branch - 1, VALUE]
        told, before = end, points[-1:]
    points = np.concatenate(turns)
    return Branches(x, y, None, falling, zigzag.inner, strokes(points[:, PLACE], points[:, VALUE]))
