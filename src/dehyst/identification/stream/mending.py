"""Logs in chunks made ready: clocks set to and fro, values far beyond all others, what follows the actuator's end.

The rows that stand for a log hold its extremes, so that a false one is among them; whether it is no wide loop is looked
up in the samples beside it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from dehyst.arrays import Array
from dehyst.data.gaps import taken_back
from dehyst.data.outliers import CODES, find_outliers
from dehyst.findings import Finding
from dehyst.identification.changed import about_change, changed_at
from dehyst.identification.stopped import about_stop, stopped_at
from dehyst.identification.stream.column import INPUT, OUTPUT
from dehyst.identification.stream.log import Log
from dehyst.identification.stream.source import Chunk, Source

Limits = tuple[float, float]

BESIDE = 256  # samples on either side by which a value is judged
USUAL = 2.0  # times the 99 % quantile of the steps beside it: what a signal may do where its clock jumps
SHOWN = 4
NO_LIMITS = (-np.inf, np.inf)


@dataclass
class Sound:
    """A log without some of its samples, or by another clock; everything else is that of its source.

    Attributes
    ----------
    source
        The log.
    limits
        Input and output beyond which samples are left out.
    end
        Number of the first sample that is no more of it; None for all.
    jumps
        Samples from which on the clock is early, and by how much, (m, 2). [-, s]
    said
        Why, where it is known before the log is read.
    dropped
        Samples beyond the limits in the present pass.
    """

    source: Source
    limits: tuple[Limits, Limits] = (NO_LIMITS, NO_LIMITS)
    end: int | None = None
    jumps: Array = field(default_factory=lambda: np.zeros((0, 2)))
    said: tuple[Finding, ...] = ()
    dropped: int = field(default=0, init=False)

    def __getattr__(self, name: str) -> Any:
        """Names, units and the number of bytes."""
        return getattr(self.source, name)

    @property
    def findings(self) -> tuple[Finding, ...]:
        """Those of the source, and what was left out."""
        own = self.said or (self._outliers(),)
        return (*getattr(self.source, "findings", ()), *own)

    def __iter__(self) -> Iterator[Chunk]:
        """Begin anew."""
        self.dropped, left, begin = 0, self.end, 0
        late = np.concatenate([[0.0], np.cumsum(self.jumps[:, 1])])
        for time, x, y in self.source:
            kept = np.ones(len(x), dtype=np.bool_)
            for values, (low, high) in zip((x, y), self.limits, strict=True):
                kept &= (np.asarray(values) >= low) & (np.asarray(values) <= high)
            self.dropped += int(np.count_nonzero(~kept))
            if left is not None:
                kept[left:] = False
                left = max(left - len(x), 0)
            if time is not None:
                jumped = np.searchsorted(self.jumps[:, 0], np.arange(begin, begin + len(x)), side="right")
                time = (np.asarray(time) - late[jumped])[kept]
            begin += len(x)
            yield time, np.asarray(x)[kept], np.asarray(y)[kept]

    def _outliers(self) -> Finding:
        names = (getattr(self.source, "input_name", "input"), getattr(self.source, "output_name", "output"))
        beyond = [
            f"'{name}' {side} {limit:.6g}"
            for name, limits in zip(names, self.limits, strict=True)
            for side, limit in zip(("below", "above"), limits, strict=True)
            if np.isfinite(limit)
        ]
        return Finding(
            "outlier",
            f"{self.dropped} samples of {getattr(self.source, 'name', 'log')} hold a value far from all others "
            f"({'; '.join(beyond)}); they were left out. A single one would spoil the fit, because the model remembers "
            f"extremes. Check the sensor and its wiring; if the values are real, log faster so that they are more than "
            f"a spike.",
        )


def by_one_clock(source: Source, log: Log) -> Source:
    """The log without jumps of its clock that are taken back while the signals go on; itself if there are none.

    Reading a whole log takes out single jumps too, which need more than the samples beside them to be told.
    """
    places, size = log.gaps.jumps[:, 0].astype(np.int64), log.gaps.jumps[:, 1] - log.gaps.usual
    found: list[tuple[int, float]] = []
    for k, m in taken_back(places, size, log.samples):
        if _goes_on(log, int(places[k])) and _goes_on(log, int(places[m])):
            found += [(int(places[k]), float(size[k])), (int(places[m]), -float(size[k]))]
    if not found:
        return source
    shown = ", ".join(f"{place} ({size:+.4g} s)" for place, size in found[:SHOWN]) + (", ..." if found[SHOWN:] else "")
    about = Finding(
        "clock-jump",
        f"the clock of {log.recording.name} jumps at samples {shown} while '{log.recording.input_name}' and "
        f"'{log.recording.output_name}' go on smoothly: the clock was set, the log was not interrupted. The jumps were "
        f"taken out, and memory goes on. Nothing to do; a clock that only counts up (monotonic) does not jump.",
    )
    return Sound(source, jumps=np.array(found), said=(about,))


def _goes_on(log: Log, place: int) -> bool:
    """Whether no signal jumps with the clock."""
    begin, end = max(place - BESIDE, 0), min(place + BESIDE, log.samples)
    steps = [np.abs(np.diff(log.reader.read(begin, end, signal))) for signal in (INPUT, OUTPUT)]
    return all(bool(step[place - 1 - begin] <= USUAL * np.quantile(step, 0.99)) for step in steps)


def without_outliers(source: Source, log: Log) -> Source:
    """The log without values far beyond all others; itself if there are none."""
    limits = (_limits(log, INPUT, log.recording.input), _limits(log, OUTPUT, log.recording.output))
    return source if limits == (NO_LIMITS, NO_LIMITS) else Sound(source, limits)


def without_rest(source: Source, log: Log) -> Source:
    """The log up to where its output stopped following its input for good, or changed; itself if it never did."""
    kept, places, samples = log.recording, log.places, log.samples
    stop = stopped_at(kept.input, kept.output)
    if stop is not None:
        begin, broke = (int(places[k]) for k in stop)
        return Sound(source, end=begin, said=(about_stop(kept, stop, broke, begin, samples),))
    change = changed_at(kept.input, kept.output)
    if change is not None:
        begin, broke = int(places[change.begin]), int(places[change.place])
        return Sound(source, end=begin, said=(about_change(kept, change, broke, begin, samples),))
    return source


def _limits(log: Log, signal: int, values: Array) -> Limits:
    """Between the values that stand for a log and those of them that are false."""
    flagged = np.concatenate([find_outliers(values[piece]) for piece in log.recording.pieces])
    for k in np.flatnonzero(flagged).tolist():
        flagged[k] = np.isin(values[k], CODES) or _alone(log, signal, int(log.places[k]))
    good, bad = values[~flagged], values[flagged]
    low, high = float(good.min()), float(good.max())
    below, above = bad[bad < low], bad[bad > high]
    return (
        0.5 * (low + float(below.max())) if below.size else -np.inf,
        0.5 * (high + float(above.min())) if above.size else np.inf,
    )


def _alone(log: Log, signal: int, place: int) -> bool:
    """Whether a sample stands off from those beside it: a wide loop within one of the buckets does not."""
    begin = max(place - BESIDE, 0)
    samples = log.reader.read(begin, min(place + BESIDE + 1, log.samples), signal)
    return bool(find_outliers(samples)[place - begin])
