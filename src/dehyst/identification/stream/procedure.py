"""identify_stream(): fits logs of any length in constant memory.

Each log is cleaned first: clock jumps that are taken back, values far beyond all others, what follows the actuator's
end. The rows that stand for a log hold its extremes, so that a false one is among them; whether it is part of a wide
loop is looked up in the samples beside it.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Array
from dehyst.data.loops import taken_back
from dehyst.data.outliers import CODES, find_outliers
from dehyst.errors import ParameterError
from dehyst.findings import Finding
from dehyst.identification.cautions import plays_only
from dehyst.identification.fit import Fit
from dehyst.identification.mending import about_change, about_stop, changed_at, stopped_at
from dehyst.identification.procedure import Call, call_of, solve
from dehyst.identification.settings import PAPER_OPERATORS, check_recordings, check_settings, eps_of_call
from dehyst.identification.split import checked
from dehyst.identification.stream.data import branches, prepare, split_logs
from dehyst.identification.stream.log import Log, read
from dehyst.identification.stream.measure import measure_streamed
from dehyst.identification.stream.samples import INPUT, OUTPUT, Tape
from dehyst.identification.stream.source import Chunk, Progress, Source, Watch
from dehyst.identification.threads import single_blas

Limits = tuple[float, float]

BESIDE = 256  # samples on either side by which a value is judged
USUAL = 2.0  # times the 99 % quantile of the steps beside it: what a signal may do where its clock jumps
SHOWN = 4
NO_LIMITS = (-np.inf, np.inf)


@dataclass
class Sound:
    """A log without some of its samples, or by another clock; everything else is that of its source."""

    source: Source  # The log
    limits: tuple[Limits, Limits] = (NO_LIMITS, NO_LIMITS)  # Input and output beyond which samples are left out
    end: int | None = None  # Number of the first sample that is no more of it; None for all
    # Samples from which on the clock is early, and by how much, (m, 2). [-, s]
    jumps: Array = field(default_factory=lambda: np.zeros((0, 2)))
    said: tuple[Finding, ...] = ()  # Why, where it is known before the log is read
    dropped: int = field(default=0, init=False)  # Samples beyond the limits in the present pass

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
            f"{self.dropped} samples of {getattr(self.source, 'name', 'log')} hold a value far from those beside it "
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


PLAYS_ONLY = plays_only(
    "the log was read in chunks", "Leave --stream out, or take a part of the log that fits into memory (--from, --to)"
)


def identify_stream(
    sources: Source | Sequence[Source],
    family: str = "auto",
    *,
    n: int | str = PAPER_OPERATORS,
    eps: float | str | None = None,
    thresholds: npt.ArrayLike | None = None,
    initial_state: str = "auto",
    train_fraction: float | None = None,
    progress: Callable[[Progress], object] | None = None,
    copy: bool | None = None,
    spool_dir: str | os.PathLike[str] | None = None,
) -> Fit:
    """Identify a hysteresis model from logs that need not fit into memory.

    The same program, choice of family and scores as `identify`, over all samples, in several passes. Memory does not
    depend on the length of the logs.

    Parameters
    ----------
    sources
        One log in chunks, as `dehyst.open_chunks` gives it, or a list of them.
    family, n, eps, thresholds, initial_state, train_fraction
        As for `identify`.
    progress
        Called with a `Progress` again and again: stage, and how much of it is done.
    copy
        Whether a temporary copy of 16 bytes a sample (24 with time) is made while a log is read for the first time,
        because reading it again would be slow. By default if the source says that it is ``costly``: text, MCAP.
    spool_dir
        Folder of that copy; by default the system's for temporary files.

    Returns
    -------
    fit : Fit
        As of `identify`. Its recordings hold the rows that stand for the whole log: those where input or output are
        extreme within buckets, about 160 000 at most; predictions and masks are given at these. Scores, certificate
        and findings are of all samples; ``recording.samples`` tells how many there were.

    Raises
    ------
    ParameterError, ExcitationError, IdentificationError
        As `identify`.
    LogError
        If a log changes while it is read, or a chunk is none.
    OutputError
        If there is no room for the temporary copy.

    Examples
    --------
    >>> import numpy as np
    >>> class Sine:
    ...     def __iter__(self):
    ...         for k in range(10):
    ...             x = np.sin(0.01 * np.arange(1000 * k, 1000 * (k + 1)))
    ...             yield None, x, 2 * x
    >>> fit = identify_stream(Sine(), family="pi")
    >>> fit.recordings[0].samples, round(float(fit.model.weights[0]), 9)
    (10000, 2.0)
    """
    listed = _sources(sources)
    begun, chosen = eps_of_call(family, eps)
    given = check_settings(family, n, begun, thresholds, initial_state)
    checked(train_fraction)  # before hours of reading
    watch = Watch(progress)
    folder = None if spool_dir is None else os.fspath(spool_dir)
    tapes: list[Tape] = []

    def first_pass(source: Source) -> Log:
        copied = _costly(source) if copy is None else copy
        tapes.append(Tape(source, str(getattr(source, "name", "log")), watch, copied, folder))
        return read(source, tapes[-1])

    try:
        with single_blas():
            watch.begin("reading")
            logs = [_noted(_mended(source, first_pass)) for source in listed]
            check_recordings([log.recording for log in logs])
            split = split_logs(logs, train_fraction)
            fit = _identify(call_of(family, n, (begun, chosen), given, initial_state, split), logs, watch)
            return fit if family != "auto" else replace(fit, warnings=(*fit.warnings, PLAYS_ONLY))
    finally:
        for tape in tapes:
            tape.close()


def _mended(source: Source, first_pass: Callable[[Source], Log]) -> Log:
    """The log, read again without what is no response of the actuator, if there is any."""
    log = first_pass(source)
    for better in (by_one_clock, without_outliers, without_rest):
        found = better(source, log)
        if found is not source:
            log.reader.tape.close()
            source, log = found, first_pass(found)
    return log


def _identify(call: Call, logs: list[Log], watch: Watch) -> Fit:
    data = prepare(logs, call.split)
    watch.begin("looking")
    found = branches(data)
    return solve(call, logs[0].recording, data, found, measure_streamed(logs, watch.begin), entering=watch.begin)


def _sources(sources: Source | Sequence[Source]) -> list[Source]:
    listed: list[Any] = list(sources) if isinstance(sources, (list, tuple)) else [sources]
    if not listed or not all(_is_source(source) for source in listed):
        raise ParameterError(
            "identify_stream() takes a log in chunks that can be read several times, or a list of such logs: "
            "dehyst.open_chunks(path, input=..., output=...), or an object whose __iter__ begins anew and yields "
            "(time or None, x, y). A generator can be read only once."
        )
    return listed


def _is_source(source: object) -> bool:
    """A path is a sequence of characters and an iterator is spent after one pass: neither is a log in chunks."""
    return isinstance(source, Source) and not isinstance(source, (str, bytes)) and not hasattr(source, "__next__")


def _costly(source: Source) -> bool:
    return bool(getattr(source, "costly", False))


def _noted(log: Log) -> Log:
    """The log with a finding that tells how it was read."""
    note = Finding(
        "streamed",
        f"{log.recording.name} was read in chunks, {log.samples} samples: false values within the range of the others "
        f"stay in, angles are not unwrapped, rows are not sorted, single jumps of the clock are breaks. Figures show "
        f"{log.places.size} samples, the extreme ones among them; scores are of all. Families are plays and the "
        f"curve: sums of elements, with creep and rate, need the log in memory. Nothing to do if the log is "
        f"clean; otherwise clean it, or identify a part that fits into memory.",
    )
    return replace(log, recording=log.recording.with_findings(note))
