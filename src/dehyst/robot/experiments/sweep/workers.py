"""Runs a sweep in parallel: local processes, a Dask cluster, or the current process."""

from __future__ import annotations

import importlib
import math
import multiprocessing
import os
import pickle
import signal
import threading
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from multiprocessing.connection import wait as wait_for
from typing import Any, Protocol

from dehyst.errors import DehystError, MissingExtraError, ParameterError
from dehyst.robot.experiments.sweep.journal import Outcome
from dehyst.robot.experiments.sweep.points import Point
from dehyst.robot.experiments.sweep.spec import SweepSpec

DASK_SECONDS = 10.0  # to reach the cluster
# Each run is one process; libraries that start threads of their own for it would only disturb the others.
THREADS = (
    "OMP_NUM_THREADS",
    "OPENBLAS_NUM_THREADS",
    "MKL_NUM_THREADS",
    "NUMEXPR_NUM_THREADS",
    "VECLIB_MAXIMUM_THREADS",
)


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


@dataclass(frozen=True)
class Task:
    """One run, ready to be sent to another process."""

    evaluate: Evaluator
    changes: Mapping[str, Any]
    settings: Mapping[str, Any]


def task_of(spec: SweepSpec, point: Point, evaluate: Evaluator) -> Task:
    """Return the run of a point."""
    settings = {
        "experiment": spec.experiment,
        "joint": spec.joint,
        "seed": point.seed,
        "trials": spec.trials,
        "compensators": spec.compensators,
        "run_settings": point.run_settings | {"conditions": point.values.get("conditions", spec.keys.conditions)},
    }
    return Task(evaluate, {**spec.keys.foreign, **point.changes}, settings)


def require_sendable(evaluate: Evaluator) -> None:
    """Refuse a function that other processes cannot import."""
    try:
        pickle.dumps(evaluate)
    except Exception as fault:
        raise ParameterError(
            f"the function that runs a point cannot be sent to other processes ({type(fault).__name__}: {fault}). "
            f"Either define it in a module that the workers can import, or run in this process: workers=0."
        ) from None


def perform(task: Task) -> Outcome:
    """Run one point; whatever goes wrong in it is its outcome and stops nothing else."""
    try:
        figures = task.evaluate(task.changes, **task.settings)
        return Outcome({str(name): _number(name, value) for name, value in figures.items()})
    except Exception as fault:
        name = "" if isinstance(fault, DehystError) else f"{type(fault).__name__}: "
        return Outcome(error=" ".join(f"{name}{fault}".split())[:500] or type(fault).__name__)


def _number(name: str, value: Any) -> float:
    number = float(value)
    if math.isinf(number):
        raise ValueError(f"{name} is infinite")
    return number


@contextmanager
def local_pool(workers: int) -> Iterator[Executor]:
    """Processes of this machine, started fresh, each with one thread, deaf to Ctrl-C, ending with this process."""
    pool = None
    with _one_thread():
        try:
            context = multiprocessing.get_context("spawn")
            pool = ProcessPoolExecutor(workers, mp_context=context, initializer=_start)
            _begin(pool, workers)
            yield pool
        except BaseException:
            if pool is not None:
                _stop(pool)
            raise
        pool.shutdown(cancel_futures=True)


def _begin(pool: ProcessPoolExecutor, workers: int) -> None:
    """Start all processes and wait for one, so that one that cannot start is not taken for a run that kills it."""
    with _deaf():
        started = [pool.submit(os.getpid) for _ in range(workers)]  # a process is made for each
    try:
        started[0].result()
    except BrokenProcessPool:
        raise ParameterError(
            "a worker process could not start. A script that calls run_sweep must do so below the line "
            "`if __name__ == '__main__':`, because workers read the script too; or run in this process: workers=0."
        ) from None


@contextmanager
def _deaf() -> Iterator[None]:
    """Ignore Ctrl-C for a moment: a process that is started now ignores it from its first instruction on."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def _stop(pool: ProcessPoolExecutor) -> None:
    """End a pool now: what its processes are computing is not wanted any more, and they do not hear Ctrl-C."""
    processes = list((getattr(pool, "_processes", None) or {}).values())
    pool.shutdown(wait=False, cancel_futures=True)
    for process in processes:
        with suppress(OSError):
            process.terminate()
    for process in processes:
        process.join(5.0)


def _start() -> None:
    """First thing in a worker."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()
    if parent is not None:
        threading.Thread(target=_follow, args=(parent.sentinel,), daemon=True).start()


def _follow(sentinel: int) -> None:
    """End with the parent: one that was killed cannot say goodbye, and its workers would wait for work for ever."""
    wait_for([sentinel])
    os._exit(1)


@contextmanager
def _one_thread() -> Iterator[None]:
    """Environment of the processes to be started: numerical libraries read it when they are loaded."""
    before = {name: os.environ.get(name) for name in THREADS}
    os.environ.update(dict.fromkeys(THREADS, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value


@contextmanager
def dask_cluster(address: str) -> Iterator[tuple[Executor, int]]:
    """Executor on a Dask cluster, and how many runs it takes at a time.

    dehyst must be installed on its workers, in the same version.
    """
    try:
        distributed = importlib.import_module("distributed")
    except ImportError as fault:
        raise MissingExtraError(
            f"a sweep on a Dask cluster needs the package distributed, which is not installed ({fault}). Type: "
            f"pip install 'dehyst[dask]' - or leave out --dask to use the processors of this machine.",
            extra="dask",
        ) from None
    try:
        client = distributed.Client(address, timeout=DASK_SECONDS, set_as_default=False)
    except (OSError, ValueError, TypeError, TimeoutError) as fault:
        raise ParameterError(
            f"no Dask cluster answers at {address!r} within {DASK_SECONDS:g} s ({type(fault).__name__}: {fault}). "
            f"Start one with `dask scheduler` and `dask worker ADDRESS`, and give its address as tcp://host:8786; or "
            f"leave out --dask to use the processors of this machine.",
            address=address,
        ) from None
    with client:
        threads = sum(client.nthreads().values())
        if not threads:
            raise ParameterError(
                f"the Dask cluster at {address} has no workers. Start some: dask worker {address}", address=address
            )
        yield OnDask(client), threads


class OnDask(Executor):
    """Runs on a Dask cluster.

    Dask's own executor does not pass on every fault: a run whose result was lost with its worker would never end.

    Parameters
    ----------
    client
        ``distributed.Client``.
    """

    def __init__(self, client: Any) -> None:
        self._client = client

    def submit(self, fn: Any, /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Send a run to the cluster."""
        future: Future[Any] = Future()
        self._client.submit(fn, *args, pure=False, **kwargs).add_done_callback(lambda remote: _pass_on(remote, future))
        return future


def _pass_on(remote: Any, future: Future[Any]) -> None:
    try:
        future.set_result(remote.result())
    except Exception as fault:
        future.set_exception(fault)
    except BaseException as fault:  # asyncio's CancelledError is no Exception: the cluster went away
        future.set_exception(RuntimeError(type(fault).__name__))


class InThisProcess(Executor):
    """Runs where it is called: for a debugger, and for tests of other executors."""

    def submit(self, fn: Any, /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Run at once."""
        future: Future[Any] = Future()
        future.set_result(fn(*args, **kwargs))
        return future
