"""How much work something is, told without a clock: no test may fail because a machine is slow or busy."""

import contextlib
import sys
import time

PATIENCE = (
    120.0  # s of processor time for what takes a fraction of one: a hang, on whatever machine
)


def lines_run(action):
    """Lines of Python that ran in this thread: the same number on every machine.

    What is done by arrays runs as many for a thousand samples as for a million; a loop over samples does not.
    """
    count, before = 0, sys.gettrace()

    def trace(frame, event, argument):
        nonlocal count
        count += event == "line"
        return trace

    sys.settrace(trace)
    try:
        action()
    finally:
        sys.settrace(before)
    return count


@contextlib.contextmanager
def no_hang(what=""):
    """Fail if the block takes minutes of this thread's own processor time."""
    begin = time.thread_time()
    yield
    assert time.thread_time() - begin < PATIENCE, f"{what}: as good as a hang"
