"""Watches an actuator while it runs: keeps its last cycles and asks `drift` about them, again and again."""

from __future__ import annotations

import io
import json
import math
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from dehyst.arrays import Array, Mask
from dehyst.data import POLICY, Recording, turning_points
from dehyst.errors import DehystError, ModelFileError, ParameterError
from dehyst.files import write_atomically
from dehyst.models import Model, model_to_dict
from dehyst.monitoring import drift
from dehyst_studio.strays import GAP, Strays

PER_CYCLE = 400  # samples kept of a cycle: a sine keeps its tips to 3e-5 of its range
LEAST = 8  # cycles that a report needs
MOST = 40_000  # samples kept before cycles are known
# Ranges of the model beyond its range: no actuator goes there and back within a few samples.
FAR = 10.0
COARSE = 0.5  # share of samples with a stamp of their own, below which the clock is coarse and no sample is repeated


@dataclass(frozen=True)
class Report:
    """What was found over the last cycles.

    Attributes
    ----------
    time
        Of the last sample. [s]
    status
        "unchanged", "drifted", "cannot tell" or "not comparable".
    alarm
        Whether the status has just become another one, the first "unchanged" left out.
    cycles
        Cycles that were looked at.
    error_percent
        RMS of the model's error, percent of the response's range; None where nothing is comparable.
    changes
        Part -> change, for example "gain" [%], "hysteresis" [%], "offset" [unit], with its interval.
    words
        The verdict.
    """

    time: float
    status: str
    alarm: bool
    cycles: int
    error_percent: float | None
    changes: Mapping[str, tuple[float, float, float, str]]
    words: str

    def as_dict(self) -> dict[str, Any]:
        """Return it as plain values, a line of JSON."""
        named = {
            part: {"estimate": value, "low": low, "high": high, "unit": unit}
            for part, (value, low, high, unit) in self.changes.items()
        }
        return {**vars(self), "changes": named}


class Watch:
    """Samples in, now and then a report out; memory and time a sample do not grow.

    A report comes each `every` cycles and is about the last `cycles`. Samples are thinned to about 400 a cycle. A gap
    in time is a break: the memory behind it is taken for unknown.

    Parameters
    ----------
    model
        As it was identified; what `drift` takes.
    cycles, every
        Cycles that are looked at, and from report to report.
    state
        File that keeps samples and status over restarts; None: nothing is kept.
    **settings
        false_alarm, least and ignore of `dehyst.drift`.

    Raises
    ------
    ParameterError
        If a setting lies outside what is possible.
    ModelFileError
        If the state file is damaged, or of another model.

    Examples
    --------
    >>> import dehyst
    >>> t = 0.01 * np.arange(6000)
    >>> x = np.sin(2 * np.pi * t) * (1 - 0.3 * np.sin(0.6 * t))
    >>> model = dehyst.PrandtlIshlinskii([0.0, 0.5], [1.0, 1.0])
    >>> watch = Watch(model, cycles=20, every=10)
    >>> [report.status for report in watch.feed(t, x, 1.1 * model.simulate(x))][-1]
    'drifted'
    """

    def __init__(
        self,
        model: Model,
        *,
        cycles: int = 24,
        every: int = 6,
        state: Path | None = None,
        **settings: Any,
    ) -> None:
        if not LEAST <= cycles <= 1000 or not 1 <= every <= cycles:
            raise ParameterError(
                f"cycles = {cycles}, every = {every}: a report looks at {LEAST} to 1000 cycles and comes after 1 to "
                f"`cycles`; fewer cycles decide nothing.",
                cycles=cycles,
                every=every,
            )
        self.model, self._cycles, self._every, self._settings = model, cycles, every, settings
        self._file, self._mark = state, model_to_dict(model)["sha256"]
        self._rows, self._fresh, self._status = np.zeros((0, 3)), 0, ""
        self._stride, self._skipped, self._waiting = 1, 0, 1
        self._strays = Strays()
        if state is not None and state.exists():
            self._resume(state)

    @property
    def samples(self) -> int:
        """How many samples are kept now."""
        return len(self._rows)

    @property
    def strange(self) -> int:
        """How many samples were left out because they stand apart."""
        return self._strays.count

    def feed(self, time: Array, x: Array, y: Array) -> list[Report]:
        """Take samples, each (k,), in their order; return the reports that became due.

        Samples that are not finite are left out, and a few that stand apart: out of the order of time, or far beyond
        the model's range, between samples that follow each other. Time that runs backward for longer, as after a
        restart of its clock, begins a new piece.
        """
        rows = np.column_stack([time, x, y]).astype(np.float64)
        rows = rows[np.isfinite(rows).all(axis=1)]
        reports: list[Report] = []
        for first in range(
            0, len(rows), PER_CYCLE
        ):  # a long batch is worth as many reports as short ones
            part = rows[first : first + PER_CYCLE]
            reports += self._take(
                self._strays.following(part, self._is_near(part), self._longest_step())
            )
        return reports

    def _longest_step(self) -> float:
        """Return the longest step that is no gap, by the samples of about a cycle; endless while there are few."""
        steps = np.diff(self._rows[-PER_CYCLE:, 0])
        steps = steps[steps > 0]
        if not steps.size:
            return math.inf
        return GAP * float(np.median(steps))

    def _is_near(self, rows: Array) -> Mask:
        """Whether samples lie within some ranges of the model's; all if it names none."""
        near = np.ones(len(rows), dtype=bool)
        for column, card in ((1, self.model.card.input), (2, self.model.card.output)):
            if card.low is not None and card.high is not None and card.high > card.low:
                reach = FAR * (card.high - card.low)
                near &= (rows[:, column] >= card.low - reach) & (
                    rows[:, column] <= card.high + reach
                )
        return near

    def _take(self, rows: Array) -> list[Report]:
        thinned = rows[(self._skipped + np.arange(len(rows))) % self._stride == 0]
        self._skipped = (self._skipped + len(rows)) % self._stride
        self._rows = np.concatenate([self._rows, thinned])
        self._fresh += len(thinned)
        if self._fresh < self._waiting:
            return []
        turns = self._turns()
        whole = max(0, turns.size - 2) // 2
        if whole:
            self._thin(int(turns[-2] - turns[0]) // whole)
            turns = self._turns()
        if len(self._rows) > MOST:
            self._thin(2 * PER_CYCLE)
            turns = self._turns()
        if turns.size > 2 * self._cycles + 2:
            self._rows, turns = (
                self._rows[turns[-2 * self._cycles - 2] :],
                turns[-2 * self._cycles - 2 :],
            )
        fresh = int(np.sum(turns[:-1] >= len(self._rows) - self._fresh)) // 2
        if whole < LEAST or fresh < self._every:
            self._waiting = self._fresh + PER_CYCLE // 4
            return []
        self._fresh, self._waiting = 0, PER_CYCLE // 4
        return [self._report()]

    def _turns(self) -> Any:
        card, values = self.model.card.input, self._rows[:, 1]
        if self.model.judged_backward:
            card, values = self.model.card.output, self._rows[:, 2]
        # A model without a range is judged by the range of the samples.
        span = float(np.ptp(values))
        if card.low is not None and card.high is not None:
            span = float(card.high - card.low)
        return turning_points(values, POLICY.turn_fraction * span or None)

    def _thin(self, length: int) -> None:
        """Leave out samples of cycles that are `length` samples long."""
        factor = length // PER_CYCLE
        if factor >= 2:
            self._rows, self._stride, self._skipped = self._rows[::factor], self._stride * factor, 0
            self._fresh //= factor

    def _report(self) -> Report:
        time, x, y = _spread(self._rows).T
        steps = np.diff(time)
        median = 1.0
        if np.any(steps > 0):
            median = float(np.median(steps[steps > 0]))
        breaks = tuple((np.flatnonzero((steps <= 0) | (steps > GAP * median)) + 1).tolist())
        card, log = self.model.card, None
        try:
            result = drift(
                self.model,
                Recording(
                    x,
                    y,
                    time,
                    "now",
                    card.input.name,
                    card.output.name,
                    card.input.unit,
                    card.output.unit,
                    breaks,
                ),
                **self._settings,
            )
            log, status, words = result.logs[0], result.status, result.verdict
        except DehystError as fault:
            status, words = "not comparable", str(fault)
        changed = status != self._status and bool(self._status or status != "unchanged")
        self._status = status
        if log is None:
            return Report(float(time[-1]), status, changed, 0, None, {}, words)
        changes = {c.part: (c.estimate, c.low, c.high, c.unit) for c in log.changes}
        return Report(
            float(time[-1]), status, changed, log.cycles, log.error_percent, changes, words
        )

    def save(self) -> None:
        """Write the state file, whole or not at all."""
        if self._file is None:
            return
        state = {
            "model": self._mark,
            "status": self._status,
            "fresh": self._fresh,
            "stride": self._stride,
        }
        stream = io.BytesIO()
        np.savez(stream, rows=self._rows, told=np.array(json.dumps(state)))
        write_atomically(self._file, stream.getvalue())

    def _resume(self, file: Path) -> None:
        try:
            with np.load(file, allow_pickle=False) as archive:
                rows = np.array(archive["rows"], np.float64)
                state = json.loads(str(archive["told"]))
            good = (
                rows.ndim == 2
                and rows.shape[1] == 3
                and len(rows) <= 2 * MOST
                and np.isfinite(rows).all()
            )
            mark, status = state["model"], str(state["status"])
            fresh, stride = int(state["fresh"]), int(state["stride"])
        except (OSError, ValueError, KeyError, TypeError, EOFError) as fault:
            raise ModelFileError(
                f"the state '{os.fspath(file)}' cannot be read ({fault!s:.80}). Delete it to begin anew."
            ) from None
        if mark != self._mark or not good or not 0 <= fresh <= len(rows) or stride < 1:
            raise ModelFileError(
                f"the state '{os.fspath(file)}' is of another model, or damaged. Give another file, or delete this one."
            )
        self._rows, self._status, self._fresh, self._stride = rows, status, fresh, stride
        self._strays = Strays(float(rows[-1, 0])) if len(rows) else Strays()


def _spread(rows: Array) -> Array:
    """Rows whose clock is coarser than they are, at times of their own; of a few that repeat a stamp, the first."""
    fresh = np.diff(rows[:, 0], prepend=np.nan) != 0.0
    if np.mean(fresh) > COARSE:
        return np.array(rows[fresh])
    first = np.flatnonzero(fresh)
    whole = np.array(rows[: first[-1] + 1])  # how far apart the last ones are is not known yet
    whole[:, 0] = np.interp(np.arange(len(whole)), first, rows[first, 0])
    return whole
