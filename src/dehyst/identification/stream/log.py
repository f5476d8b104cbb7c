"""First pass over a long log: gaps in time, the rows to keep, access to samples by number."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from dehyst.arrays import Array, Rows
from dehyst.data.loops import TURN_FRACTION, gap_limit, memory_lost
from dehyst.data.recording import MINIMUM_SAMPLES, Recording
from dehyst.errors import RecordingError, TimeError
from dehyst.findings import Finding
from dehyst.identification.stream.outline import PLACE, TIME, Outline, X, Y, Zigzag
from dehyst.identification.stream.samples import INPUT, Reader, Tape
from dehyst.identification.stream.source import BLOCK, Source

STEPS = 1 << 16  # steps that stand for all: their median and 95th percentile
MOST = 4096  # gaps that can be told apart
MOST_RESTARTS = 50


@dataclass(frozen=True)
class Gaps:
    """What time says about a log."""

    breaks: tuple[int, ...] = ()  # Samples before which the memory of the actuator is unknown
    # gaps, longest, usual: Number of gaps, length of the longest and the usual step. [s]
    gaps: int = 0
    longest: float = 0.0
    usual: float = 0.0
    restarts: tuple[int, ...] = ()  # Samples at which the clock jumps back
    repeated: int = 0  # Number of samples with the stamp of the one before
    # The samples after the breaks: number, x, y and time, (m, 4)
    after: Array = field(default_factory=lambda: np.zeros((0, 4)))
    # Number of the sample after each gap and each jump back, and the step, (m, 2)
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


@dataclass(frozen=True)
class Log:
    """A log of any length."""

    reader: Reader  # Its samples
    gaps: Gaps  # Where its memory is unknown
    places: Rows  # Numbers of the samples that stand for it, (m,), increasing
    recording: Recording  # These samples; its breaks are those of the log

    @property
    def samples(self) -> int:
        """Number of samples."""
        return self.reader.tape.samples

    @property
    def pieces(self) -> tuple[slice, ...]:
        """Ranges of samples between breaks."""
        edges = [0, *self.gaps.breaks, self.samples]
        return tuple(slice(a, b) for a, b in itertools.pairwise(edges))


def read(source: Source, tape: Tape) -> Log:
    """Make the first pass."""
    outline, finder = Outline(), GapFinder(tape.name)
    for block in tape.record():
        outline.add(block.time, block.x, block.y)
        if block.time is not None:
            finder.add(block.begin, block.time, block.x, block.y)
    if outline.samples < MINIMUM_SAMPLES:
        raise RecordingError(
            f"{tape.name} has {outline.samples} samples; a loop needs at least {MINIMUM_SAMPLES}. Check that its "
            f"columns hold numbers: dehyst inspect LOG",
            samples=outline.samples,
        )
    reader = Reader(tape, outline)
    low, high = reader.extremes(0, tape.samples, INPUT)
    gaps = finder.result(high - low, lambda: _swings(reader, TURN_FRACTION * (high - low)))
    rows = _with_breaks(outline.rows(), gaps)
    places = rows[:, PLACE].astype(np.int64)
    return Log(reader, gaps, places, _recording(source, tape, gaps, rows, places))


def spans(begin: int, end: int) -> Iterator[slice]:
    """Cut samples into parts of a block."""
    for start in range(begin, end, BLOCK):
        yield slice(start, min(start + BLOCK, end))


def _swings(reader: Reader, swing: float) -> int:
    """How often the input swings to and fro; a pass of its own, which only logs with harmless gaps need."""
    zigzag = Zigzag(swing)
    for part in spans(0, reader.tape.samples):
        zigzag.add(part.start, reader.read(part.start, part.stop, INPUT))
    return zigzag.inner + 1


def _with_breaks(rows: Array, gaps: Gaps) -> Array:
    """Rows of the outline and the first of each piece; stamps that are shared are spread, as in a whole log."""
    rows = np.concatenate([rows, gaps.after])
    _, first = np.unique(rows[:, PLACE], return_index=True)
    rows = rows[first]
    time = rows[:, TIME]
    if not gaps.repeated or rows.shape[0] < 2:
        return rows
    new = np.concatenate([[True], (np.diff(time) != 0.0) | np.isin(rows[1:, PLACE], gaps.breaks)])
    starts = np.flatnonzero(new)
    counts = np.diff(np.append(starts, rows.shape[0]))
    usual = gaps.usual or 1.0
    width = np.append(np.diff(time[starts]), usual)
    width = np.where((width <= 0) | (width > usual), usual, width)
    place = np.arange(rows.shape[0]) - np.repeat(starts, counts)
    rows[:, TIME] = np.repeat(time[starts], counts) + place * np.repeat(width / counts, counts)
    return rows


def _recording(source: Source, tape: Tape, gaps: Gaps, rows: Array, places: Rows) -> Recording:
    about: dict[str, Any] = {name: str(getattr(source, name, "") or default) for name, default in _NAMES.items()}
    provenance: dict[str, Any] = dict(getattr(source, "provenance", {}) or {})
    # What the source saw of gaps, chunk by chunk, is known better now.
    findings = [found for found in getattr(source, "findings", ()) if found.code not in ("gap", "clock-restart")]
    findings += gap_findings(tape.name, gaps, tape.samples)
    return Recording(
        input=rows[:, X],
        output=rows[:, Y],
        time=rows[:, TIME] if tape.has_time else None,
        name=tape.name,
        breaks=tuple(np.searchsorted(places, gaps.breaks).tolist()),
        findings=tuple(findings),
        provenance=provenance | {"samples": tape.samples, "kept": int(places.size)},
        **about,
    )


_NAMES = {"input_name": "input", "output_name": "output", "input_unit": "", "output_unit": ""}


def gap_findings(name: str, gaps: Gaps, samples: int) -> Iterator[Finding]:
    """Yield what the time of a log says."""
    if gaps.restarts:
        yield Finding(
            "clock-restart",
            f"the clock of {name} jumps back at {len(gaps.restarts)} samples, first at number {gaps.restarts[0] + 1}: "
            f"several recordings follow each other, or the clock was set. Each is treated as a piece of its own, with "
            f"unknown memory at its start. Better split the log; a clock that was set is taken out where the log, or a "
            f"part of it, is read at once (dehyst.read_log).",
        )
    if gaps.repeated:
        yield Finding(
            "coarse-time",
            f"{gaps.repeated} of {samples} rows of {name} share the time stamp of the row before them: the clock is "
            f"coarser than the sampling. Rates are only as good as that; log time with more digits.",
        )
    if gaps.gaps:
        broken = len(gaps.breaks) - len(gaps.restarts)
        cure = (
            f"At {broken} of them the input may have turned unseen, so the memory of the actuator is taken as unknown "
            f"after it. Use one side only if that is enough."
            if broken
            else "The input hardly moved across them, so the recording goes on. Nothing to do."
        )
        yield Finding(
            "gap",
            f"{name} has {gaps.gaps} gap{'s' if gaps.gaps > 1 else ''} in its time; the longest has "
            f"{gaps.longest:.4g} s, against {gaps.usual:.3g} s usually. {cure}",
        )
