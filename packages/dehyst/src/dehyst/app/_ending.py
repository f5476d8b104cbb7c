"""How a command ends: its exit status, one line instead of a traceback, and Ctrl-C."""

from __future__ import annotations

import errno
import io
import os
import signal
import sys
import threading
import traceback
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from enum import IntEnum
from types import FrameType
from typing import NoReturn, TextIO

from dehyst.errors import DehystError
from dehyst.files import FULL
from dehyst.shell import visible_lines

# Packages that only the robot asks for.
ROBOT_NEEDS = ("daqp", "distributed", "mink", "mujoco", "scipy", "tomlkit")
STOPPED = "stopped; files that were complete are kept, none is half written\n"
AGAIN = 0.005  # s from an interrupt that was swallowed to its repetition


class Status(IntEnum):
    """How a command ended; each has its `meaning`, which the reference of the commands prints.

    Examples
    --------
    >>> int(Status.NO), Status.NO.meaning.partition(":")[0]
    (1, 'the check says no')
    """

    meaning: str

    def __new__(cls, number: int, meaning: str) -> Status:
        """Give a number its meaning."""
        status = int.__new__(cls, number)
        status._value_ = number
        status.meaning = meaning
        return status

    DONE = (
        0,
        "the command did its work; a check says yes: `verify` signed off, `drift` or `watch` found no change",
    )
    NO = (
        1,
        "the check says no: `verify` does not sign off, `drift` or `watch` found a change, `evaluate` no model to run, "
        "`backlash` no table to write",
    )
    REFUSED = (
        2,
        "refused, nothing was overwritten: the message on the error stream says why and what to type",
    )
    NOT_COMPARABLE = (
        3,
        "`drift` has nothing to compare; `watch` ended without a report, or with such a one",
    )
    CANNOT_TELL = (
        4,
        "`drift`, or the last report of `watch`, cannot tell whether something changed, or `valve` whether one sticks",
    )
    LOST = (
        5,
        "the result could not be printed: the disk of the standard output is full, or it is closed",
    )
    DEFECT = 70, "a defect of dehyst itself: please report the traceback"
    STOPPED = 130, "stopped with Ctrl-C; every file is as it was before or complete"
    UNREAD = (
        141,
        "the reader of a pipe left before everything was printed, as `head` does; with `verify`, `drift`, `sweep`"
        " and a no of `evaluate`, `backlash` or `valve` the status of the verdict stays",
    )


def end(work: Callable[[], object]) -> NoReturn:
    """Do the work of a command line and leave with the status that tells how it ended."""
    _open_closed_streams()
    _write_whole()
    _tell_warnings()
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


def _tell_warnings() -> None:
    """A warning is a sentence on the error stream, without file, line and class of who gave it."""
    shown = warnings.showwarning

    def told(
        message: Warning | str,
        category: type[Warning],
        filename: str,
        lineno: int,
        file: TextIO | None = None,
        line: str | None = None,
    ) -> None:
        if issubclass(category, UserWarning):
            _say(visible_lines(f"warning: {message}") + "\n")
        else:
            shown(message, category, filename, lineno, file, line)

    warnings.showwarning = told


def _cure(fault: OSError) -> str:
    if fault.errno == errno.EBADF:
        return "The standard output is closed: leave out `>&-`, or send it to a file."
    if fault.errno in FULL:
        return "Free some space, or write it elsewhere."
    return "Write it elsewhere."


def _status_after(work: Callable[[], object]) -> int:
    try:
        work()
    except SystemExit as left:
        # Typer turns Ctrl-C and a broken pipe into a status of its own: ours is the one that is documented.
        for fault in _behind(left):
            if isinstance(fault, KeyboardInterrupt | BrokenPipeError):
                raise fault from None
        if isinstance(left.code, int):
            return left.code
        return Status.DONE
    except DehystError as fault:
        _say(f"{type(fault).__name__}: {fault}\n")
        return Status.REFUSED
    except (OSError, KeyboardInterrupt):
        # They may come from the flush after the work as well, so that `end` handles both.
        raise
    except ModuleNotFoundError as fault:
        package = (fault.name or "dehyst").partition(".")[0]
        # A module of our own that is missing is a defect, and no package that the user could install.
        if package == "dehyst":
            _say(traceback.format_exc())
            return Status.DEFECT
        if _is_installed(package):
            _say(
                f"{fault}: the package {package} is installed, but lacks this module. Install it again: "
                f"pip install --force-reinstall {package.replace('_', '-')}, or tell its authors.\n"
            )
            return Status.REFUSED
        # The laboratory imports its packages at once; everything else that is optional names its extra itself.
        wing = "dehyst-robot" if package in ROBOT_NEEDS else package
        _say(
            f"this command needs the package {package}, which is not installed. Type: pip install {wing}\n"
        )
        return Status.REFUSED
    except Exception:
        _say(traceback.format_exc())
        return Status.DEFECT
    return Status.DONE


def _is_installed(package: str) -> bool:
    """Whether a package is there at all, so that only a module of it is missing."""
    from importlib.util import find_spec  # only a command that failed needs it

    try:
        return find_spec(package) is not None
    # The import is refused on purpose, by this process or by an importer.
    except (ValueError, ModuleNotFoundError):
        return False


def _behind(fault: BaseException) -> Iterator[BaseException]:
    """What was being handled when this was raised, and so on, unless the code said that it is over."""
    behind = fault.__context__
    if fault.__suppress_context__:
        behind = fault.__cause__
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
        # A script that asks for the verdict reads the status: `| head` must not change it.
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
    # A stream without a file number, as tests have it, needs nothing of this.
    with suppress(OSError):
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, stream.fileno())
        os.close(nowhere)


def _open_closed_streams() -> None:
    """Open what the shell closed (`>&-`): without it the first file that is opened would get all that is printed.

    Nothing can be written to the standard output then, which is told if something was to be; messages go nowhere.
    """
    for number, (name, mode) in enumerate((("stdin", "r"), ("stdout", "w"), ("stderr", "w"))):
        if getattr(sys, name) is None:
            # An output that cannot be written makes the lost result known; messages may be lost.
            access = os.O_RDONLY
            if name == "stderr":
                access = os.O_WRONLY
            place = os.open(os.devnull, access)
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
        # A raw stream below the text means that nothing is buffered.
        if isinstance(getattr(stream, "buffer", None), io.RawIOBase):
            whole = open(  # noqa: SIM115
                stream.fileno(),
                "w",
                buffering=1,
                encoding=stream.encoding,
                errors=stream.errors,
                closefd=False,
            )
            setattr(sys, name, whole)


def heed(before: Callable[..., object] = signal.default_int_handler) -> None:
    """Take care of Ctrl-C from now on, `before` having done so; not if who started this process told it not to."""
    if signal.getsignal(signal.SIGINT) is before:
        signal.signal(signal.SIGINT, _stop)
        # Windows has no way to send the interrupt once more.
        if hasattr(signal, "pthread_kill"):
            sys.unraisablehook = _raise_again


def let_go() -> None:
    """Leave Ctrl-C to the system: nothing is left to do but to end, and Python would print what it interrupts there."""
    if signal.getsignal(signal.SIGINT) is _stop:
        signal.signal(signal.SIGINT, signal.SIG_DFL)


def _stop(number: int, frame: FrameType | None) -> None:
    """Raise KeyboardInterrupt; while a module is being loaded, which may make any other fault of it, end at once.

    That is safe at any moment, because every file is written so that a kill leaves it whole.
    """
    while frame is not None:
        if frame.f_code.co_filename.startswith("<frozen importlib"):
            # A progress line may have hidden the cursor, and nothing else will show it again.
            cursor = ""
            if sys.stderr.isatty():
                cursor = "\r\x1b[K\x1b[?25h"
            with suppress(OSError):
                os.write(2, (cursor + STOPPED).encode())
            os._exit(Status.STOPPED)
        frame = frame.f_back
    raise KeyboardInterrupt


def _raise_again(swallowed: sys.UnraisableHookArgs) -> None:
    """Ctrl-C in a destructor or a callback of C code is not lost, and not printed: it comes again after it."""
    if issubclass(swallowed.exc_type, KeyboardInterrupt):
        # Raised at once it would be swallowed by this very hook: a timer raises it after the hook ended.
        interrupt = [threading.main_thread().ident, signal.SIGINT]
        threading.Timer(AGAIN, signal.pthread_kill, interrupt).start()
    else:
        sys.__unraisablehook__(swallowed)
