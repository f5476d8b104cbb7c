"""Runs a sweep on Dask and writes one table that grows; a second start does only the runs that are missing in it."""

from __future__ import annotations

import csv
import importlib
import itertools
import logging
import math
import os
import signal
import time
from collections.abc import Callable, Container, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from dehyst.errors import DehystError, MissingExtraError, OutputError, ParameterError
from dehyst.io import kit as io_kit
from dehyst_robot.experiments._point import evaluate_point
from dehyst_robot.experiments._sweep.points import (
    ERROR,
    KEY,
    Point,
    RunOutcome,
    expand_points,
    table_of,
)
from dehyst_robot.experiments._sweep.spec import SweepSpec

RUNS_AHEAD = 2  # runs handed out for each worker: it computes one, the next one waits for it
MOST_WORKERS = 1024
SECONDS_TO_CONNECT = 10.0
SECONDS_BETWEEN_TABLES = 2.0  # a kill of the process loses the runs that ended in this time
SHARE_OF_WRITING = (
    0.05  # of the time may be spent on writing the table; a large one is written less often
)
DIED = "the process that ran it died: killed, out of memory, or a crash in C"


class Evaluator(Protocol):
    """A function of a module, so that other processes can import it, that runs one point."""

    def __call__(
        self,
        changes: Mapping[str, Any],
        *,
        experiment: str,
        joint: int,
        seed: int,
        trials: Sequence[str],
        compensators: Sequence[str],
        run_settings: Mapping[str, Any],
    ) -> Mapping[str, float]:
        """Return figures by name."""


class SweepProgress(Protocol):
    """Is told how far a sweep is."""

    def __call__(self, finished: int, failed: int, total: int, resumed: int) -> None:
        """Take note of different runs finished, of which some failed and some were in the table already."""


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
        The table: name -> cells, (rows,): ``study``, ``point``, ``seed``, parameters, ``key``, ``error``, figures.
    out
        File of the table.
    runs
        Number of different runs; points of two studies may be the same one.
    resumed
        How many of them an earlier start had finished.
    failed
        How many of them failed.
    """

    spec: SweepSpec
    points: tuple[Point, ...]
    columns: Mapping[str, Sequence[Any]]
    out: Path
    runs: int
    resumed: int
    failed: int


def run_sweep(
    spec: SweepSpec,
    out: str | os.PathLike[str],
    *,
    evaluate: Evaluator = evaluate_point,
    workers: int | None = None,
    dask: str | None = None,
    progress: SweepProgress | None = None,
    retry: bool = False,
    overwrite: bool = False,
) -> SweepResult:
    """Run all points of a sweep and write one table, a row a point.

    The table grows while the sweep runs. Started again after a kill, or after values were added to the sweep, it runs
    only what is missing; the table is the same as that of an uninterrupted run, and does not depend on the workers.

    Parameters
    ----------
    spec
        The sweep, from `load_sweep`.
    out
        Table to write, ``.csv``.
    evaluate
        Runs a point. A function of a module.
    workers
        Processes; the number of processors if None, 0 for this process itself, where a debugger can follow.
    dask
        Address of a Dask cluster, ``tcp://host:port``, instead of local processes.
    progress
        Is called at the start and after every run.
    retry
        Do the runs again that failed.
    overwrite
        Drop the table that is there and begin anew.

    Raises
    ------
    OutputError
        If the table cannot be written, or the one that is there has other runs than those of this sweep.
    ParameterError
        If the number of workers is none, or there is no cluster at that address.
    MissingExtraError
        If the package ``distributed`` is not installed.
    KeyboardInterrupt
        On Ctrl-C; what was finished is in the table.
    """
    target = io_kit.require_table_name(out)
    count = _number_of_workers(workers)
    function_name = f"{evaluate.__module__}.{getattr(evaluate, '__qualname__', '')}"
    points = expand_points(spec, function_name)
    runs = {point.key: point for point in points}
    outcomes: dict[str, RunOutcome] = {}
    if not overwrite:
        outcomes = _outcomes_in(target, runs)
    if retry:
        outcomes = {key: outcome for key, outcome in outcomes.items() if not outcome.error}
    missing = {key: point for key, point in runs.items() if key not in outcomes}
    resumed = len(runs) - len(missing)
    table = _GrowingTable(target, spec, points, outcomes)
    report = progress or _no_report
    report(resumed, table.failed, len(runs), resumed)
    try:
        if missing:
            with _dask_client(min(count, len(missing)), dask) as client:
                for key, outcome in _outcomes(client, spec, missing, evaluate):
                    table.add(key, outcome)
                    report(len(outcomes), table.failed, len(runs), resumed)
    finally:
        columns = table.write()
    return SweepResult(spec, points, columns, target, len(runs), resumed, table.failed)


def _no_report(finished: int, failed: int, total: int, resumed: int) -> None:
    """Take note of nothing."""


def _number_of_workers(workers: int | None) -> int:
    if workers is None:
        return (
            len(os.sched_getaffinity(0))
            if hasattr(os, "sched_getaffinity")
            else os.cpu_count() or 1
        )
    if not 0 <= workers <= MOST_WORKERS:
        raise ParameterError(
            f"workers is {workers}, but must lie between 0 and {MOST_WORKERS}. Try --workers 2."
        )
    return workers


class _GrowingTable:
    """The file of a table that is written again every few seconds while runs end."""

    def __init__(
        self, file: Path, spec: SweepSpec, points: Sequence[Point], outcomes: dict[str, RunOutcome]
    ) -> None:
        self._file = file
        self._spec = spec
        self._points = points
        self._outcomes = outcomes
        self._next = time.monotonic() + SECONDS_BETWEEN_TABLES
        self.failed = sum(bool(outcome.error) for outcome in outcomes.values())

    def add(self, key: str, outcome: RunOutcome) -> None:
        self._outcomes[key] = outcome
        self.failed += bool(outcome.error)
        if time.monotonic() > self._next:
            self.write()

    def write(self) -> dict[str, list[Any]]:
        """Write the rows whose runs have ended; without any, leave the file alone."""
        begin = time.monotonic()
        finished_points = [point for point in self._points if point.key in self._outcomes]
        columns = table_of(self._spec, finished_points, self._outcomes)
        if finished_points:
            io_kit.write_table(self._file, columns)
        end = time.monotonic()
        self._next = end + max(SECONDS_BETWEEN_TABLES, (end - begin) / SHARE_OF_WRITING)
        return columns


def _outcomes_in(file: Path, keys: Container[str]) -> dict[str, RunOutcome]:
    """Outcomes by key of a run, of a table that an earlier start wrote; none if there is no such file."""
    if not file.exists():
        return {}
    try:
        with file.open(encoding="utf-8", newline="") as stream:
            rows = list(csv.DictReader(stream))
    except (OSError, ValueError, csv.Error):
        rows = [{}]
    if not all(KEY in row and ERROR in row for row in rows):
        raise OutputError(
            f"'{file}' exists already and is no table of a sweep; writing there would lose it. Name another file with "
            f"--out, or add --overwrite.",
            path=str(file),
        )
    foreign_rows = [row for row in rows if row[KEY] not in keys]
    if foreign_rows:
        raise OutputError(
            f"'{file}' holds {len(foreign_rows)} runs that are not of this sweep: since then values were taken out of "
            f"the sweep file, or the robot's parameters or the version of dehyst changed. Add --overwrite to drop the "
            f"table and begin anew, or name another table with --out.",
            path=str(file),
            runs=len(foreign_rows),
        )
    outcomes = {}
    for row in rows:
        outcome = _outcome_of(row)
        if outcome is not None:
            outcomes[row[KEY]] = outcome
    return outcomes


def _outcome_of(row: Mapping[Any, Any]) -> RunOutcome | None:
    """Outcome in a row of a table; None for a damaged row, whose run is then done again."""
    if row[ERROR]:
        return RunOutcome(error=row[ERROR])
    names = list(row)
    figures = {}
    try:
        for name in names[names.index(ERROR) + 1 :]:
            if row[name]:
                figures[name] = float(row[name])
    except (TypeError, ValueError):
        return None
    if None in row.values() or any(map(math.isinf, figures.values())):
        return None
    return RunOutcome(figures)


@contextmanager
def _dask_client(workers: int, address: str | None) -> Iterator[Any]:
    """A client of the cluster at an address, or of one that is started on this machine."""
    try:
        distributed = importlib.import_module("distributed")
        dask_settings = importlib.import_module("dask.config").set
    except ImportError as fault:
        raise MissingExtraError(
            f"a sweep needs the package distributed, which is not installed ({fault}). Type: "
            f"pip install dehyst-robot",
            extra="dask",
        ) from None
    if address is None:
        # The scheduler and its workers report a lost worker on the error stream; the table has it in its row.
        options = {
            "dashboard_address": "127.0.0.1:0",
            "silence_logs": logging.CRITICAL,
            "threads_per_worker": 1,
        }
        with ExitStack() as stack:
            stack.enter_context(_environment_restored())
            # A run that dies is tried once more alone, not four times among others.
            stack.enter_context(dask_settings({"distributed.scheduler.allowed-failures": 0}))
            cluster = distributed.LocalCluster(
                n_workers=max(workers, 1), processes=workers > 0, **options
            )
            stack.enter_context(cluster)
            client = stack.enter_context(distributed.Client(cluster, set_as_default=False))
            if workers > 0:
                client.run(_ignore_ctrl_c)
            yield client
        return
    try:
        client = distributed.Client(address, timeout=SECONDS_TO_CONNECT, set_as_default=False)
    except (OSError, ValueError, TypeError, TimeoutError) as fault:
        raise ParameterError(
            f"no Dask cluster answers at {address!r} within {SECONDS_TO_CONNECT:g} s ({type(fault).__name__}: {fault})."
            f" Start one with `dask scheduler` and `dask worker ADDRESS`, and give its address as tcp://host:8786; or "
            f"leave out --dask to use the processors of this machine.",
            address=address,
        ) from None
    with client:
        if not client.nthreads():
            raise ParameterError(
                f"the Dask cluster at {address} has no workers. Start some: dask worker {address}",
                address=address,
            )
        yield client


@contextmanager
def _environment_restored() -> Iterator[None]:
    """Take back what Dask sets for its workers in the environment of this process: one thread, a seed of hashes."""
    before = dict(os.environ)
    try:
        yield
    finally:
        for name in os.environ.keys() - before.keys():
            del os.environ[name]
        os.environ.update(before)


def _ignore_ctrl_c() -> None:
    """Leave Ctrl-C to the process that started this worker: it writes the table and ends its workers."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def _outcomes(
    client: Any, spec: SweepSpec, missing: Mapping[str, Point], evaluate: Evaluator
) -> Iterator[tuple[str, RunOutcome]]:
    """Key and outcome of each run as it ends; a few runs are handed out ahead, however many there are."""
    distributed = importlib.import_module("distributed")
    waiting = iter(missing.items())
    key_of: dict[str, str] = {}

    def submit(key: str) -> Any:
        changes, settings = arguments_of(spec, missing[key])
        future = client.submit(perform, evaluate, changes, settings, pure=False)
        key_of[future.key] = key
        return future

    def next_runs(count: int) -> list[Any]:
        return [submit(key) for key, _ in itertools.islice(waiting, count)]

    suspects = []
    ahead = RUNS_AHEAD * sum(client.nthreads().values())
    under_way = distributed.as_completed(next_runs(ahead), loop=client.loop)
    for future in under_way:
        key = key_of.pop(future.key)
        outcome = _outcome_from(future)
        if outcome.error == DIED:
            suspects.append(key)
        else:
            yield key, outcome
        under_way.update(next_runs(1))
    # Dask blames a dead process on every run that had been handed to it. Alone, a run answers for itself.
    for key in suspects:
        yield key, _outcome_from(submit(key))


def _outcome_from(future: Any) -> RunOutcome:
    try:
        outcome: RunOutcome = future.result()
    except Exception as fault:
        if type(fault).__name__ == "KilledWorker":
            return RunOutcome(error=DIED)
        reason = f"{type(fault).__name__}: {' '.join(str(fault).split())[:300]}"
        raise ParameterError(
            f"a run could not be sent to a worker or back ({reason}). Finished runs are kept in the table. Look "
            f"whether the cluster still answers and its workers have the same dehyst, then start the same line again.",
            reason=reason,
        ) from None
    return outcome


def arguments_of(spec: SweepSpec, point: Point) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return what an `Evaluator` takes for a point: changes of the robot, and its other arguments by name."""
    settings = {
        "experiment": spec.experiment,
        "joint": spec.joint,
        "seed": point.seed,
        "trials": spec.trials,
        "compensators": spec.compensators,
        "run_settings": point.run_settings
        | {"conditions": point.values.get("conditions", spec.keys.conditions)},
    }
    return {**spec.keys.foreign, **point.changes}, settings


def perform(
    evaluate: Callable[..., Mapping[str, float]], changes: Mapping[str, Any], settings: Any
) -> RunOutcome:
    """Run one point; a fault in it is its outcome and stops nothing else."""
    figures = {}
    try:
        for name, value in evaluate(changes, **settings).items():
            figures[str(name)] = float(value)
            if math.isinf(value):
                raise ValueError(f"{name} is infinite")
    except Exception as fault:
        name = "" if isinstance(fault, DehystError) else f"{type(fault).__name__}: "
        return RunOutcome(error=" ".join(f"{name}{fault}".split())[:500] or type(fault).__name__)
    return RunOutcome(figures)
