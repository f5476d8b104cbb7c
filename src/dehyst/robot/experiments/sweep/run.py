"""Runs a sweep: all points that are not yet in the journal, then the table."""

from __future__ import annotations

import importlib
import os
from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Executor, Future, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol, cast

from dehyst.errors import OutputError, ParameterError
from dehyst.io.write import require_table_name, write_table
from dehyst.robot.experiments.sweep.journal import Journal, Outcome, fingerprint, journal_path
from dehyst.robot.experiments.sweep.points import Point, expand, table_of
from dehyst.robot.experiments.sweep.spec import SweepSpec
from dehyst.robot.experiments.sweep.workers import (
    Evaluator,
    InThisProcess,
    Task,
    dask_cluster,
    local_pool,
    perform,
    require_sendable,
    task_of,
)
from dehyst.version import __version__

AHEAD = 2  # runs handed out for each worker: one that it computes, one that waits for it
MOST_WORKERS = 1024
DIED = "the process that ran it died: killed, out of memory, or a crash in C"


class Progress(Protocol):
    """Is told how far a sweep is."""

    def __call__(self, done: int, failed: int, total: int, resumed: int) -> None:
        """Take note of different runs done, of which some failed and some were in the journal already."""


@dataclass(frozen=True, eq=False)
class SweepResult:
    """A sweep that has been run.

    Attributes
    ----------
    spec
        What was asked.
    points
        Rows of the table.
    columns
        The table: name -> cells, (rows,): ``study``, ``point``, ``seed``, parameters, ``error``, figures.
    out
        File of the table.
    journal
        File of the journal; it is kept when runs failed, so that they can be tried again.
    runs
        Number of different runs; points of two studies may be the same one.
    resumed
        How many of them an earlier start had done.
    failed
        How many of them failed.
    """

    spec: SweepSpec
    points: tuple[Point, ...]
    columns: Mapping[str, Sequence[Any]]
    out: Path
    journal: Path
    runs: int
    resumed: int
    failed: int


def run_sweep(
    spec: SweepSpec,
    out: str | os.PathLike[str],
    *,
    evaluate: Evaluator | None = None,
    workers: int | None = None,
    dask: str | None = None,
    progress: Progress | None = None,
    restart: bool = False,
    retry: bool = False,
    overwrite: bool = False,
) -> SweepResult:
    """Run all points of a sweep and write one table, a row a point.

    Every finished run is written to a journal beside the table. Started again after a kill, it goes on there; the table
    is the same as that of an uninterrupted run, and does not depend on the number of workers.

    Parameters
    ----------
    spec
        The sweep, from `load_sweep`.
    out
        Table to write, ``.csv`` or ``.parquet``.
    evaluate
        Runs a point; `dehyst.robot.experiments.point.evaluate_point` if None. A function of a module.
    workers
        Processes; the number of processors if None, 0 for this process itself.
    dask
        Address of a Dask cluster, ``tcp://host:port``, instead of local processes.
    progress
        Is called at the start and after every run.
    restart
        Drop what the journal holds.
    retry
        Do the runs again that failed.
    overwrite
        Replace a table that is there already and has no journal.

    Raises
    ------
    OutputError
        If the table or its journal cannot be written, or the journal is one of another sweep.
    ParameterError
        If the number of workers is none, or there is no cluster at that address.
    MissingExtraError
        If Parquet or Dask is asked for and not installed.
    KeyboardInterrupt
        On Ctrl-C; what was finished is in the journal.
    """
    target = require_table_name(out)
    count = _workers(workers)
    points = expand(spec)
    run = evaluate if evaluate is not None else _default_evaluator()
    if dask is None and count > 0:
        require_sendable(run)
    if target.exists() and not journal_path(target).exists() and not overwrite:
        raise OutputError(
            f"'{target}' exists already and has no journal to go on from; writing there would lose it. Name another "
            f"file with --out, or add --overwrite.",
            path=str(target),
        )
    mark = fingerprint(spec, __version__, f"{run.__module__}.{getattr(run, '__qualname__', '')}")
    tasks = {point.key: task_of(spec, point, run) for point in points}
    with Journal(journal_path(target), mark, restart, retry) as journal:
        todo = {key: task for key, task in tasks.items() if key not in journal.done}
        resumed = len(tasks) - len(todo)
        _perform_all(todo, journal, _Teller(progress, len(tasks), resumed, journal), count, dask)
        columns = table_of(spec, points, journal.done)
        write_table(target, columns)
        failed = sum(bool(journal.done[key].error) for key in tasks)
        if not failed:
            journal.remove()
    return SweepResult(spec, points, columns, target, journal.path, len(tasks), resumed, failed)


def _workers(workers: int | None) -> int:
    if workers is None:
        return min(len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1, 61)
    if not 0 <= workers <= MOST_WORKERS:
        raise ParameterError(f"workers is {workers}, but must lie between 0 and {MOST_WORKERS}. Try --workers 2.")
    return workers


def _default_evaluator() -> Evaluator:
    return cast(Evaluator, importlib.import_module("dehyst.robot.experiments.point").evaluate_point)


class _Teller:
    """Counts for the progress display."""

    def __init__(self, progress: Progress | None, total: int, resumed: int, journal: Journal) -> None:
        self._progress, self._total, self._resumed, self._done = progress, total, resumed, resumed
        self._failed = sum(bool(outcome.error) for outcome in journal.done.values())
        self._say()

    def tell(self, outcome: Outcome) -> None:
        self._done += 1
        self._failed += bool(outcome.error)
        self._say()

    def _say(self) -> None:
        if self._progress is not None:
            self._progress(self._done, self._failed, self._total, self._resumed)


def _perform_all(todo: Mapping[str, Task], journal: Journal, teller: _Teller, workers: int, dask: str | None) -> None:
    """Perform tasks until all are in the journal; a pool that a run brought down is replaced."""
    queue, suspects = deque(todo), deque[str]()
    while queue or suspects:
        with _executor(min(workers, len(queue) + len(suspects)), dask) as (executor, room):
            # After a breakdown each run that was under way goes alone: the one that does it again is to blame.
            lost = _drain(suspects, todo, journal, teller, executor, 1) if suspects else []
            if not lost:
                lost = _drain(queue, todo, journal, teller, executor, room)
                suspects.extend(lost)
            elif lost:
                outcome = Outcome(error=DIED)
                journal.add(lost[0], outcome)
                teller.tell(outcome)


@contextmanager
def _executor(workers: int, dask: str | None) -> Iterator[tuple[Executor, int]]:
    """Who computes, and how many runs to hand out at a time."""
    if dask is not None:
        with dask_cluster(dask) as cluster:
            yield cluster[0], AHEAD * cluster[1]
    elif workers == 0:
        yield InThisProcess(), 1
    else:
        with local_pool(workers) as pool:
            yield pool, AHEAD * workers


def _lost_on_the_way(fault: Exception, journal: Journal) -> Outcome:
    """Outcome of a run that killed Dask's workers; anything else that `perform` cannot raise is no run's own fault."""
    if type(fault).__name__ == "KilledWorker":
        return Outcome(error=DIED)
    reason = f"{type(fault).__name__}: {' '.join(str(fault).split())[:300]}"
    raise ParameterError(
        f"a run could not be sent to a worker or back ({reason}). {len(journal.done)} finished runs are kept in "
        f"'{journal.path}'. Look whether the cluster still answers and its workers have the same dehyst, then start "
        f"the same line again.",
        reason=reason,
    ) from None


def _drain(
    queue: deque[str], tasks: Mapping[str, Task], journal: Journal, teller: _Teller, executor: Executor, room: int
) -> list[str]:
    """Perform what is queued, at most `room` at a time; return what was under way when the pool broke down."""
    under_way: dict[Future[Outcome], str] = {}
    lost: list[str] = []
    while (queue and not lost) or under_way:
        while queue and not lost and len(under_way) < room:
            key = queue.popleft()
            try:
                under_way[executor.submit(perform, tasks[key])] = key
            except BrokenProcessPool:
                lost.append(key)
        for future in wait(under_way, return_when=FIRST_COMPLETED).done:
            key = under_way.pop(future)
            try:
                outcome = future.result()
            except BrokenProcessPool:
                lost.append(key)
                continue
            except Exception as fault:
                outcome = _lost_on_the_way(fault, journal)
            journal.add(key, outcome)
            teller.tell(outcome)
    return lost
