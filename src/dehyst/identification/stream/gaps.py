"""Gaps in the time of a log, found in one pass by the rules that reading a whole log follows."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from dehyst.arrays import Array
from dehyst.data.gaps import gap_limit, memory_lost
from dehyst.errors import TimeError

STEPS = 1 << 16  # steps that stand for all: their median and 95th percentile
MOST = 4096  # gaps that can be told apart
MOST_RESTARTS = 50


@dataclass(frozen=True)
class Gaps:
    """What time says about a log.

    Attributes
    ----------
    breaks
        Samples before which the memory of the actuator is unknown.
    gaps, longest, usual
        Number of gaps, length of the longest and the usual step. [s]
    restarts
        Samples at which the clock jumps back.
    repeated
        Number of samples with the stamp of the one before.
    after
        The samples after the breaks: number, x, y and time, (m, 4).
    jumps
        Number of the sample after each gap and each jump back, and the step, (m, 2).
    """

    breaks: tuple[int, ...] = ()
    gaps: int = 0
    longest: float = 0.0
    usual: float = 0.0
    restarts: tuple[int, ...] = ()
    repeated: int = 0
    after: Array = field(default_factory=lambda: np.zeros((0, 4)))
    jumps: Array = field(default_factory=lambda: np.zeros((0, 2)))


class GapFinder:
    """Collects steps of time; `result` tells which of them are gaps."""

    def __init__(self, name: str) -> None:
        self._name = name
        self._last: Array | None = None  # time and x of the sample before
        self._total = 0.0
        self._repeated = 0
        # Every so many steps stand for all of them.
        self._stride, self._seen = 1, 0
        self._sample: list[Array] = []
        self._sampled = 0
        # Long steps, (m, 6): number, x, y and time of the sample after, the step, |dx| across it.
        self._bound = 0.0
        self._long: list[Array] = []
        self._restarts: list[Array] = []

    def add(self, begin: int, time: Array, x: Array, y: Array) -> None:
        """Add the samples from number `begin` on."""
        first = np.array([[time[0]], [x[0]]]) if self._last is None else self._last
        step, moved = np.diff(time, prepend=first[0]), np.diff(x, prepend=first[1])
        self._last = np.array([time[-1:], x[-1:]])
        self._total += float(np.sum(np.maximum(step, 0.0)))
        self._repeated += int(np.count_nonzero(step == 0.0)) - (begin == 0)
        self._sample_steps(step)
        for kept, chosen in ((self._restarts, step < 0.0), (self._long, step > self._bound)):
            k = np.flatnonzero(chosen)
            if k.size:
                kept.append(np.column_stack([begin + k, x[k], y[k], time[k], step[k], np.abs(moved[k])]))
        if sum(part.shape[0] for part in self._restarts) > MOST_RESTARTS:
            raise TimeError(
                f"time stamps of {self._name} run backward more than {MOST_RESTARTS} times, first at sample "
                f"{int(self._restarts[0][0, 0]) + 1}. The order of the samples is the memory of the actuator, so it is "
                f"not guessed. Sort the log by time, or name another time column with --time.",
            )
        if sum(part.shape[0] for part in self._long) > 8 * MOST:
            self._forget()

    def _sample_steps(self, step: Array) -> None:
        chosen = step[-self._seen % self._stride :: self._stride]
        self._seen += step.size
        self._sample.append(chosen)
        self._sampled += chosen.size
        while self._sampled > 2 * STEPS:
            joined = np.concatenate(self._sample)[::2]
            self._sample, self._sampled, self._stride = [joined], joined.size, 2 * self._stride
            self._raise_bound()

    def _raise_bound(self) -> None:
        """A gap is at least 5 times the median; twice that of the steps so far leaves room for its changes."""
        steps = np.concatenate(self._sample)
        steps = steps[steps > 0.0]
        if steps.size:
            self._bound = 2.0 * float(np.median(steps))

    def _forget(self) -> None:
        """Keep the longest steps only: those that can be gaps."""
        self._raise_bound()
        rows = np.concatenate(self._long)
        rows = rows[rows[:, 4] > self._bound]
        if rows.shape[0] > 4 * MOST:
            rows = rows[np.sort(np.argpartition(rows[:, 4], -4 * MOST)[-4 * MOST :])]
        self._long = [rows]

    def result(self, span: float, swings: Callable[[], int]) -> Gaps:
        """Gaps, given the range of the input and how often it swings to and fro, which is asked only if it matters."""
        if self._seen < 3:
            return Gaps()
        steps = np.concatenate(self._sample)
        limit, usual = gap_limit(steps), steps[steps > 0.0]
        rows = np.concatenate([np.zeros((0, 6)), *self._long])
        rows = rows[rows[:, 4] > limit]
        if rows.shape[0] > MOST:
            raise TimeError(
                f"{self._name} has more than {MOST} gaps in its time, steps above {limit:.4g} s. Log without gaps, or "
                f"name another time column with --time.",
                limit=limit,
            )
        lost = memory_lost(rows[:, 4], rows[:, 5], span, np.inf, 1)
        if not lost.all():
            measured = self._total - float(np.sum(rows[:, 4] - limit))
            lost = memory_lost(rows[:, 4], rows[:, 5], span, measured, swings())
        restarts = np.concatenate([np.zeros((0, 6)), *self._restarts])
        jumps = np.concatenate([rows, restarts])[:, [0, 4]]
        after = np.concatenate([rows[lost], restarts])[:, :4]
        after = after[np.argsort(after[:, 0])]
        return Gaps(
            tuple(after[:, 0].astype(int).tolist()),
            rows.shape[0],
            float(np.max(rows[:, 4], initial=0.0)),
            float(np.median(usual)) if usual.size else 0.0,
            tuple(restarts[:, 0].astype(int).tolist()),
            self._repeated,
            after,
            jumps[np.argsort(jumps[:, 0])],
        )
