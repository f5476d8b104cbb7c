"""Columns that nobody named: those that `dehyst inspect` proposes, if names and units leave no choice."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TypeVar

from dehyst.app.identify_stream import is_large
from dehyst.app.inspect import print_columns
from dehyst.app.requests import LogsRequest
from dehyst.app.terminal import terminal
from dehyst.data.recording import Recording
from dehyst.errors import ColumnError
from dehyst.io import LogSummary, inspect_log, read_log
from dehyst.shell import typed

R = TypeVar("R", bound=LogsRequest)


def named_columns(command: str, request: R, quiet: bool) -> R:
    """Return the request with the columns of input and output: as named, else as proposed for the first log.

    With `quiet` the standard output is for the result alone: what was proposed is said on the error stream.

    Raises
    ------
    ColumnError
        If names and units leave a choice; the columns have been printed on the error stream then.
    """
    if request.input and request.output:
        return request
    log, run = request.logs[0], next(iter(request.runs), None)
    summary = None if is_large(request.logs) else inspect_log(log, run, time_unit=request.time_unit)
    if summary is None or not summary.clear or summary.input is None or summary.output is None:
        raise _choice(command, log, summary)
    pair = request.input or summary.input, request.output or summary.output
    if pair[0] == pair[1]:
        raise _choice(command, log, summary)
    words = typed(["--input", pair[0], "--output", pair[1]])
    terminal(stderr=quiet).print(f"columns: {words}, by their names and units\n", soft_wrap=True)
    return replace(request, input=pair[0], output=pair[1])


def read_logs(request: LogsRequest) -> list[Recording]:
    """Return the recordings of a request whose columns are named."""
    return [
        read_log(
            log, request.input or "", request.output or "", time=request.time, run=run, start=request.start,
            stop=request.stop, time_unit=request.time_unit,
        )
        for log in request.logs
        for run in (request.runs or (None,))
    ]  # fmt: skip


def _choice(command: str, log: Path, summary: LogSummary | None) -> ColumnError:
    """Print what there is to choose from, and return what to type."""
    asked = f"dehyst {command} {typed([log])} --input COLUMN --output COLUMN"
    if summary is None:
        return ColumnError(
            f"'{log}' is too large to be looked through for its input and output. Name them: {asked}", columns=()
        )
    print_columns(terminal(stderr=True), summary.columns)
    likely = f"; the best guess: {summary.input} drives {summary.output}" if summary.input and summary.output else ""
    return ColumnError(
        f"names and units of the columns of {log.name} do not tell which one drives and which one follows{likely}. "
        f"Name them: {asked}",
        columns=tuple(column.name for column in summary.columns),
    )
