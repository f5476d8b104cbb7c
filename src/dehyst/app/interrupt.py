"""Ctrl-C: an exception where the program works, and the end at once where an exception would be swallowed."""

from __future__ import annotations

import os
import signal
import sys
import threading
from collections.abc import Callable
from contextlib import suppress
from types import FrameType

from dehyst.app.ending import STOPPED
from dehyst.app.status import Status

AGAIN = 0.005  # s from an interrupt that was swallowed to its repetition


def heed(before: Callable[..., object] = signal.default_int_handler) -> None:
    """Take care of Ctrl-C from now on, `before` having done so; not if who started this process told it not to."""
    if signal.getsignal(signal.SIGINT) is before:
        signal.signal(signal.SIGINT, _stop)
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
            cursor = "\r\x1b[K\x1b[?25h" if sys.stderr.isatty() else ""  # which a progress line may have hidden
            with suppress(OSError):
                os.write(2, (cursor + STOPPED).encode())
            os._exit(Status.STOPPED)
        frame = frame.f_back
    raise KeyboardInterrupt


def _raise_again(swallowed: sys.UnraisableHookArgs) -> None:
    """Ctrl-C in a destructor or a callback of C code is not lost, and not printed: it comes again after it."""
    if issubclass(swallowed.exc_type, KeyboardInterrupt):  # at once it would be swallowed by this very hook
        threading.Timer(AGAIN, signal.pthread_kill, [threading.main_thread().ident, signal.SIGINT]).start()
    else:
        sys.__unraisablehook__(swallowed)
