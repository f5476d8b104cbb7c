"""One log after its first pass: its samples by number, its outline, its gaps, and the rows that are kept of it."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from dehyst.arrays import Array, Rows
from dehyst.data.loops import TURN_FRACTION
from dehyst.data.recording import MINIMUM_SAMPLES, Recording
from dehyst.errors import RecordingError
from dehyst.findings import Finding
from dehyst.identification.stream.column import INPUT, Reader
from dehyst.identification.stream.gaps import GapFinder, Gaps
from dehyst.identification.stream.outline import PLACE, TIME, Outline, X, Y
from dehyst.identification.stream.samples import Tape
from dehyst.identification.stream.source import Source
from dehyst.identification.stream.spool import BLOCK
from dehyst.identification.stream.zigzag import Zigzag


@dataclass(frozen=True)
class Log:
    """A log of any length.

    Attributes
    ----------
    reader
        Its samples.
    gaps
        Where its memory is unknown.
    places
        Numbers of the samples that stand for it, (m,), increasing.
    recording
        These samples; its breaks are those of the log.
    """

    reader: Reader
    gaps: Gaps
    places: Rows
    recording: Recording

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
