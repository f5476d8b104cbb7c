"""Exit statuses: one for each meaning, listed in docs/reference/commands."""

from __future__ import annotations

from enum import IntEnum


class Status(IntEnum):
    """How a command ended; each has its `meaning`, which the reference of the commands prints.

    Examples
    --------
    >>> int(Status.NO), Status.NO.meaning
    (1, 'the check says no: `verify` does not sign off, `drift` found a change, `evaluate` no model to run')
    """

    meaning: str

    def __new__(cls, number: int, meaning: str) -> Status:
        """Give a number its meaning."""
        status = int.__new__(cls, number)
        status._value_ = number
        status.meaning = meaning
        return status

    DONE = 0, "the command did its work; a check says yes: `verify` signed off, `drift` found no change"
    NO = 1, "the check says no: `verify` does not sign off, `drift` found a change, `evaluate` no model to run"
    REFUSED = 2, "refused, nothing was overwritten: the message on the error stream says why and what to type"
    NOT_COMPARABLE = 3, "`drift` has nothing to compare"
    CANNOT_TELL = 4, "`drift` cannot tell: the logs do not decide whether something changed"
    LOST = 5, "the result could not be printed: the disk of the standard output is full, or it is closed"
    DEFECT = 70, "a defect of dehyst itself: please report the traceback"
    STOPPED = 130, "stopped with Ctrl-C; every file is as it was before or complete"
    UNREAD = (
        141,
        "the reader of a pipe left before everything was printed, as `head` does; with `verify`, `drift`, `sweep`"
        " and a no of `evaluate` the status of the verdict stays",
    )
