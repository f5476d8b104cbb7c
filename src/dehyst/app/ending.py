"""How a command ends: one line instead of a traceback, and the status of its meaning, whatever happened."""

from __future__ import annotations

import errno
import io
import os
import sys
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import NoReturn, TextIO

from dehyst.app.status import Status
from dehyst.errors import DehystError
from dehyst.files import FULL

STOPPED = "stopped; files that were complete are kept, none is half written\n"


def end(work: Callable[[], object]) -> NoReturn:
    """Do the work of a command line and leave with the status that tells how it ended."""
    _open_closed_streams()
    _write_whole()
    try:
        status = _status_after(work)
        sys.stdout.flush()
    except KeyboardInterrupt:
        status = Status.STOPPED
        _say(STOPPED)
    except BrokenPipeError:
        status = Status.UNREAD
    except OSError as fault:
        status = Status.LOST
        _say(f"the result could not be written: {fault.strerror or fault}. {_cure(fault)}\n")
    if status in (Status.STOPPED, Status.UNREAD, Status.LOST):
        _drop_unwritten(sys.stdout)
    sys.exit(status)


def _cure(fault: OSError) -> str:
    if fault.errno == errno.EBADF:
        return "The standard output is closed: leave out `>&-`, or send it to a file."
    return "Free some space, or write it elsewhere." if fault.errno in FULL else "Write it elsewhere."


def _status_after(work: Callable[[], object]) -> int:
    try:
        work()
    except SystemExit as left:
        for fault in _behind(left):  # typer ends with a status of its own what it should not know of
            if isinstance(fault, KeyboardInterrupt | BrokenPipeError):
                raise fault from None
        return left.code if isinstance(left.code, int) else Status.DONE
    except DehystError as fault:
        _say(f"{type(fault).__name__}: {fault}\n")
        return Status.REFUSED
    except (OSError, KeyboardInterrupt):
        raise
    except Exception:
        _say(traceback.format_exc())
        return Status.DEFECT
    return Status.DONE


def _behind(fault: BaseException) -> Iterator[BaseException]:
    """What was being handled when this was raised, and so on, unless the code said that it is over."""
    behind = fault.__cause__ if fault.__suppress_context__ else fault.__context__
    if behind is not None:
        yield behind
        yield from _behind(behind)


@contextmanager
def concluding(status: Status) -> Iterator[None]:
    """Print a verdict and leave with its status; that a reader leaves before the end does not change it.

    Examples
    --------
    >>> with concluding(Status.NO):
    ...     print("not verified")
    Traceback (most recent call last):
    SystemExit: 1
    """
    try:
        yield
        sys.stdout.flush()
    except BrokenPipeError:
        _drop_unwritten(sys.stdout)
    raise SystemExit(status) from None


def _say(words: str) -> None:
    """Write to the error stream; if that is full or gone, the status has to tell."""
    try:
        sys.stderr.write(words)
        sys.stderr.flush()
    except OSError:
        _drop_unwritten(sys.stderr)


def _drop_unwritten(stream: TextIO) -> None:
    """Send what cannot be printed to nowhere, or Python would try it again at its end and end with 120."""
    with suppress(OSError):  # it is no file
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, stream.fileno())
        os.close(nowhere)


def _open_closed_streams() -> None:
    """Open what the shell closed (`>&-`): without it the first file that is opened would get all that is printed.

    Nothing can be written to the standard output then, which is told if something was to be; messages go nowhere.
    """
    for number, (name, mode) in enumerate((("stdin", "r"), ("stdout", "w"), ("stderr", "w"))):
        if getattr(sys, name) is None:
            place = os.open(os.devnull, os.O_WRONLY if name == "stderr" else os.O_RDONLY)
            if place != number:
                os.dup2(place, number)
                os.close(place)
            setattr(sys, name, open(number, mode, encoding="utf-8"))  # noqa: SIM115, PTH123


def _write_whole() -> None:
    """Let no stream take a part of what is written for all of it.

    Python's unbuffered streams (`PYTHONUNBUFFERED`, `python -u`) ask the system once and look at no count: on a disk
    that fills up, or in a pipe whose reader leaves, the rest would be lost without an error.
    """
    for name in ("stdout", "stderr"):
        stream = getattr(sys, name)
        if isinstance(getattr(stream, "buffer", None), io.RawIOBase):
            whole = open(  # noqa: SIM115
                stream.fileno(), "w", buffering=1, encoding=stream.encoding, errors=stream.errors, closefd=False
            )
            setattr(sys, name, whole)
