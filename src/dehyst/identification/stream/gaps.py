"""Gaps in the time of a log, found in one pass by the rules that reading a whole log follows."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from dehyst.errors import TimeError
from dehyst.gaps import gap_limit, memory_lost

Array = npt.NDArray[np.float64]

STEPS = 1 << 16  # steps that stand for all: their median and 95th percentile
MOST = 4096  # gaps, and restarts of the clock, that can be told apart


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
    """

    breaks: tuple[int, ...] = ()
    gaps: int = 0
    longest: float = 0.0
    usual: float = 0.0
    restarts: tuple[int, ...] = ()
    repeated: int = 0


@dataclass
class GapFinder:
    """Collects steps of time; `result` tells which of them are gaps."""

    name: str
    _stride: int = 1
    _seen: int = 0
    _sample: list[Array] = field(default_factory=list)
    _kept: int = 0
    _total: float = 0.0
    _last: tuple[float, float] | None = None
    _long: list[Array] = field(default_factory=list)  # rows (index, step, |dx|) of long steps
    _bound: float = 0.0
    _restarts: list[int] = field(default_factory=list)
    _repeated: int = 0

    def add(self, begin: int, time: Array, x: Array) -> None:
        """Add the samples from index `begin` on."""
        if self._last is not None:
            time, x, begin = np.concatenate([[self._last[0]], time]), np.concatenate([[self._last[1]], x]), begin - 1
        self._last = (float(time[-1]), float(x[-1]))
        step = np.diff(time)
        backward = np.flatnonzero(step < 0.0)
        if backward.size:
            self._restarts += (backward + begin + 1).tolist()
            if len(self._restarts) > MOST // 64:
                raise TimeError(
                    f"time stamps of {self.name} run backward {len(self._restarts)} times or more, first before sample "
                    f"{self._restarts[0] + 1}. The order of the samples is the memory of the actuator, so it is not "
                    f"guessed. Sort the log by time, or name another time column with --time.",
                    samples=self._restarts,
                )
        self._repeated += int(np.count_nonzero(step == 0.0))
        self._total += float(np.sum(np.maximum(step, 0.0)))
        self._sample_steps(step)
        far = np.flatnonzero(step > self._bound)
        if far.size:
            self._long.append(np.column_stack([far + begin + 1.0, step[far], np.abs(x[far + 1] - x[far])]))
            if sum(part.shape[0] for part in self._long) > 8 * MOST:
                self._forget()

    def _sample_steps(self, step: Array) -> None:
        chosen = step[-self._seen % self._stride :: self._stride]
        self._seen += step.size
        self._sample.append(chosen)
        self._kept += chosen.size
        while self._kept > 2 * STEPS:
            joined = np.concatenate(self._sample)[::2]
            self._sample, self._kept, self._stride = [joined], joined.size, 2 * self._stride
        if self._seen <= 2 * STEPS or not self._bound:
            self._raise_bound()

    def _raise_bound(self) -> None:
        steps = np.concatenate(self._sample)
        steps = steps[steps > 0.0]
        if steps.size >= 1000:
            self._bound = 2.0 * float(np.median(steps))

    def _forget(self) -> None:
        """Keep the longest steps only, those that can be gaps."""
        self._raise_bound()
        rows = np.concatenate(self._long)
        rows = rows[rows[:, 1] > self._bound]
        if rows.shape[0] > 4 * MOST:
            rows = rows[np.sort(np.argpartition(rows[:, 1], -4 * MOST)[-4 * MOST :])]
        self._long = [rows]

    def result(self, span: float, swings: int) -> Gaps:
        """Gaps, given the range of the input and how often it swung to and fro."""
        if self._seen < 2:
            return Gaps()
        sample = np.concatenate(self._sample)
        limit = gap_limit(sample)
        rows = np.concatenate(self._long) if self._long else np.zeros((0, 3))
        rows = rows[rows[:, 1] > limit]
        if rows.shape[0] > MOST:
            raise TimeError(
                f"{self.name} has more than {MOST} gaps in its time, steps above {limit:.4g} s. Log without gaps, or "
                f"name another time column with --time.",
                limit=limit,
            )
        lost = memory_lost(rows[:, 1], rows[:, 2], span, self._total - float(np.sum(rows[:, 1] - limit)), swings)
        breaks = {int(k) for k in rows[lost, 0]} | set(self._restarts)
        usual = sample[sample > 0.0]
        return Gaps(
            tuple(sorted(breaks)),
            rows.shape[0],
            float(np.max(rows[:, 1], initial=0.0)),
            float(np.median(usual)) if usual.size else 0.0,
            tuple(self._restarts),
            self._repeated,
        )
