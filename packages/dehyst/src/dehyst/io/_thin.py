"""Thins a log while it is read: of any number of rows, at most `MOST_ROWS` stay.

The rows that stay are rows of the log as they are: one of so many, and beside them those that decide the memory of an
actuator. A play remembers where its input turned, so the turning points of the input stay, and the rows on both sides
of a gap in time, the first row and the last one.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array, Mask, Rows
from dehyst.data import gap_limit, turning_points
from dehyst.io._policy import POLICY

# The choice among all families takes 600 MB of memory for so many rows, that of plays 140 MB (decision 23).
MOST_ROWS = 500_000
# Of many rows one in 3, 9, 27, ... stays: periods of a logger are round numbers, whose factors are 2 and 5, and a power
# of three meets every phase of them.
FACTOR = 3
# A single false value must not decide what is small: the range is taken between these quantiles.
RANGE = (0.01, 0.99)


class Thinner:
    """Rows that stand for a log.

    Parameters
    ----------
    most
        Most rows that stay.
    signal, clock
        Which of the columns is the input, whose turning points stay, and which the time; None for no such column.

    Attributes
    ----------
    samples
        Rows added so far.
    every
        One of so many rows stays.
    swing
        Smallest swing whose turning points stayed; 0 as long as all rows did.
    is_full
        Whether the input turned so often that no more rows are taken.

    Examples
    --------
    >>> thinner = Thinner(most=100, signal=0)
    >>> x = np.abs(np.arange(3000) % 2000 - 1000.0)
    >>> thinner.add([x], np.arange(3000))
    >>> columns, rows = thinner.result()
    >>> thinner.every, rows.size, [int(k) for k in (0, 1000, 2000, 2999) if k in rows]
    (81, 41, [0, 1000, 2000, 2999])
    """

    samples: int
    every: int
    swing: float
    is_full: bool

    def __init__(
        self, most: int = MOST_ROWS, signal: int | None = None, clock: int | None = None
    ) -> None:
        self.samples, self.every, self.swing, self.is_full = 0, 1, 0.0, False
        self._most, self._signal, self._clock = most, signal, clock
        self._parts: list[
            list[npt.NDArray[Any]]
        ] = []  # of each column, then the row numbers and the gaps
        self._size = 0
        self._gap_limit = np.nan
        self._last_time = np.nan

    def add(self, columns: Sequence[npt.NDArray[Any]], rows: Rows) -> None:
        """Add rows: columns of one length, finite where they are input or time, and the number of each row."""
        if rows.size == 0 or self.is_full:
            return
        self.samples += rows.size
        gaps = self._gaps(columns, rows.size)
        keep = (rows % self.every == 0) | (gaps > 0.0)
        keep[[0, -1]] = True  # the next part may begin with a gap
        if self._signal is not None and self.every > 1:
            keep[turn_candidates(columns[self._signal], self.swing)] = True
        for k, column in enumerate((*columns, rows, gaps)):
            if k == len(self._parts):
                self._parts.append([])
            self._parts[k].append(column[keep])
        self._size += int(np.count_nonzero(keep))
        if self._size > self._most:
            self._thin()

    def result(self) -> tuple[list[npt.NDArray[Any]], Rows]:
        """Return the columns of the rows that stand for all, and the numbers of these rows."""
        *columns, rows, _ = [np.concatenate(parts) for parts in self._parts]
        return columns, rows

    def _gaps(self, columns: Sequence[npt.NDArray[Any]], size: int) -> Array:
        """Length of the gap beside each row, 0 where there is none. [s]"""
        gaps = np.zeros(size)
        if self._clock is None:
            return gaps
        time = columns[self._clock]
        if np.isnan(self._gap_limit):
            self._gap_limit = gap_limit(np.diff(time)) if size > 2 else np.inf
        steps = np.abs(np.diff(time, prepend=self._last_time))
        self._last_time = time[-1]
        after = np.flatnonzero(steps > self._gap_limit)
        gaps[after] = steps[after]
        inside = after[after > 0]
        gaps[inside - 1] = np.maximum(gaps[inside - 1], steps[inside])
        if after.size > inside.size:  # the row before it is the last of the part before
            self._parts[-1][-1][-1] = steps[0]
        return gaps

    def _thin(self) -> None:
        rows, gaps = (np.concatenate(parts) for parts in self._parts[-2:])
        while np.count_nonzero(gaps > self._gap_limit) > POLICY.most_gaps * self._most:
            self._gap_limit *= 2.0
        decisive = (
            gaps > self._gap_limit
            if self._clock is not None
            else np.zeros(rows.size, dtype=np.bool_)
        )
        decisive[[0, -1]] = True
        if self._signal is not None:
            decisive[self._turns(np.concatenate(self._parts[self._signal]))] = True
        if self.is_full:
            return
        keep = self._stay(rows, decisive)
        for parts in self._parts:
            parts[:] = [np.concatenate(parts)[keep]]
        self._size = int(np.count_nonzero(keep))

    def _stay(self, rows: Rows, decisive: Mask) -> Mask:
        """Which rows stay, so few that there is room for others."""
        room = max(0.5 * self._most, 1.25 * np.count_nonzero(decisive))
        keep = np.ones(rows.size, dtype=np.bool_)
        while np.count_nonzero(keep) > room:
            self.every *= FACTOR
            keep = decisive | (rows % self.every == 0)
        return keep

    def _turns(self, signal: Array) -> Rows:
        """Turning points that stay."""
        low, high = np.quantile(signal, RANGE)
        span = float(high - low)
        if not span > 0.0:
            return np.zeros(0, dtype=np.int64)
        self.swing = max(self.swing, POLICY.smallest_swing * span)
        turns = turning_points(signal, self.swing)
        while (
            turns.size > POLICY.thinned_turns * self._most
            and self.swing < POLICY.largest_swing * span
        ):
            self.swing *= 2.0
            turns = turns[turning_points(signal[turns], self.swing)]
        self.is_full = turns.size > POLICY.most_turns * self._most
        return turns


def turn_candidates(signal: Array, swing: float) -> Rows:
    """Samples of a part of a signal that may be turning points of the whole, as far as the part can tell."""
    if not swing > 0.0:
        return np.zeros(0, dtype=np.int64)
    points = turning_points(signal, swing)
    if points.size < 2:
        return points
    # Before the first turning point and after the last one the other parts decide.
    begin, end = signal[: points[1] + 1], signal[points[-2] :]
    extremes = np.array([begin.argmin(), begin.argmax()])
    last_extremes = points[-2] + np.array([end.argmin(), end.argmax()])
    return np.unique(np.concatenate([points, extremes, last_extremes]))
