"""Guards calls of other packages' readers: one kind of error, limited time and memory."""

from __future__ import annotations

import gc
import importlib
import io
import logging
import os
import signal
import sys
import threading
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stdout
from typing import Any, TypeVar

from dehyst.errors import DehystError, LogError, MissingExtraError
from dehyst.io._text import EXPANSION_LIMIT, SIZE_LIMIT

Result = TypeVar("Result")

# Arrays unpack without parsing, so more is allowed for free than for text.
BINARY_FREE = 64 << 20


# A damaged file can send a reader round in circles. A sound one is read far faster than this.
GRACE_SECONDS = 1.0
SLOWEST_RATE = 1 << 18


class _TooLongError(Exception):
    """The reader did not finish in time."""


def guard(name: str, kind: str, size: int, read: Callable[[], Result]) -> Result:
    """Return what a foreign reader returns, which is run so that whatever goes wrong in it becomes one named error.

    A damaged file can make such a reader raise anything (polars' panics are not even an Exception), warn, write to
    the terminal, or never end. The meaning is always the same: the file is not what its first bytes promise.
    `size` is that of the file in bytes: the limit is 1 s and 4 s more for each MB, where the system has interval timers
    and this is the main thread.
    """
    with _quiet():
        try:
            # It rings again and again, until it is left.
            with _deadline(GRACE_SECONDS + size / SLOWEST_RATE):
                return read()
        except (DehystError, KeyboardInterrupt, SystemExit):
            raise
        except BaseException as fault:
            failure = f"{type(fault).__name__}: {' '.join(str(fault).split())[:160]}".strip(": _")
        # Half-built objects of the reader complain when they go: let them go while it is quiet.
        gc.collect(1)
    # Raised here, not above: a fault kept as context would keep those objects alive.
    raise LogError(
        f"log '{name}' is damaged: it cannot be read as {kind} ({failure}). Copy or export it again, or save the "
        f"columns as CSV.",
        file=name,
        kind=kind,
    )


@contextmanager
def _quiet() -> Iterator[None]:
    """No warnings, prints, log lines or 'exception ignored' of other packages."""
    hook, level = sys.unraisablehook, logging.root.manager.disable
    sys.unraisablehook = lambda _: None
    logging.disable(logging.CRITICAL)
    try:
        with warnings.catch_warnings(), redirect_stdout(io.StringIO()):
            warnings.simplefilter("ignore")
            yield
    finally:
        sys.unraisablehook = hook
        logging.disable(level)


@contextmanager
def _deadline(seconds: float) -> Iterator[None]:
    """Raise in the block when it takes too long, again and again: some readers swallow what is raised in them.

    Time of the processor counts, so that a busy machine makes no good file a damaged one. [s]
    """
    if (
        not hasattr(signal, "setitimer")
        or threading.current_thread() is not threading.main_thread()
    ):
        yield
        return
    active = True

    def ring(*_: object) -> None:
        if active:
            raise _TooLongError(f"no end after {seconds:.1f} s of work")

    before = signal.signal(signal.SIGPROF, ring)
    signal.setitimer(signal.ITIMER_PROF, seconds, 0.05)
    try:
        yield
    finally:
        try:
            active = False
        finally:  # the bell may ring on the line above
            signal.setitimer(signal.ITIMER_PROF, 0.0)
            signal.signal(signal.SIGPROF, before)


@contextmanager
def muted_stderr() -> Iterator[None]:
    """Send the process's error stream nowhere: compiled readers write their panics straight to it."""
    sys.stderr.flush()
    keep = os.dup(2)
    nowhere = os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(nowhere, 2)
        yield
    finally:
        os.dup2(keep, 2)
        os.close(nowhere)
        os.close(keep)


def optional(
    module: str,
    extra: str,
    name: str,
    doing: str = "reading",
    instead: str = "save the columns as CSV",
) -> Any:
    """Import an optional package, or say which line installs it, and what can be done `instead`."""
    try:
        return importlib.import_module(module)
    except ImportError as fault:
        raise MissingExtraError(
            f"{doing} '{name}' needs the package {module.partition('.')[0]}, which is not installed ({fault}). Type: "
            f"pip install 'dehyst[{extra}]' - or {instead}.",
            extra=extra,
            module=module,
        ) from None


def refuse_bomb(expanded: int, packed: int, name: str, most: float = SIZE_LIMIT) -> None:
    """Refuse contents that unpack to more than 100 times the file (and 64 MB), or more than `most` bytes."""
    limit = min(most, max(BINARY_FREE, EXPANSION_LIMIT * packed))
    if expanded > limit:
        raise LogError(
            f"log '{name}' has {packed} bytes but claims to hold {expanded}; more than {limit / 2**20:.0f} MB are not "
            f"read from it: it is damaged, or was made to fill the memory. Save the columns you need as CSV.",
            file=name,
            limit=limit,
        )
