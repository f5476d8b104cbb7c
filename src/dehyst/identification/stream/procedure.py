"""identify_stream(): from logs of any length to a fitted, certified model, in memory that does not grow with them."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy.typing as npt

from dehyst.errors import ParameterError
from dehyst.findings import Finding
from dehyst.identification.cautions import plays_only
from dehyst.identification.fit import Fit
from dehyst.identification.procedure import Call, call_of, solve
from dehyst.identification.settings import PAPER_OPERATORS, check_recordings, check_settings, eps_of_call
from dehyst.identification.split import checked
from dehyst.identification.stream.data import branches, prepare, split_logs
from dehyst.identification.stream.log import Log, read
from dehyst.identification.stream.measure import measure_streamed
from dehyst.identification.stream.mending import by_one_clock, without_outliers, without_rest
from dehyst.identification.stream.samples import Tape
from dehyst.identification.stream.source import Source
from dehyst.identification.stream.watch import Progress, Watch
from dehyst.identification.threads import single_blas

PLAYS_ONLY = plays_only("the log was read in chunks", "Take a part of it that fits into memory (--from, --to)")


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
