"""Columns that nobody named: those that `dehyst inspect` proposes, if names and units leave no choice."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from dehyst.app.identify_stream import is_large
from dehyst.app.inspect import print_columns
from dehyst.app.terminal import terminal
from dehyst.errors import ColumnError
from dehyst.io import LogSummary, inspect_log
from dehyst.shell import typed


def named_columns(
    command: str, logs: Sequence[Path], input: str, output: str, run: str | None, time_unit: str | None,
    quiet: bool,
) -> tuple[str, str]:  # fmt: skip
    """Return the columns of input and output: as named, else as proposed for the first log, which is said.

    Parameters
    ----------
    command
        That is going to read them, for the line to type.
    logs
        Files to read.
    input, output
        As typed, "" if they were not.
    run, time_unit
        What of them is read.
    quiet
        Whether the standard output is for the result alone: then it is said on the error stream.

    Raises
    ------
    ColumnError
        If names and units leave a choice; the columns have been printed on the error stream then.
    """
    if input and output:
        return input, output
    log = logs[0]
    summary = None if is_large(logs) else inspect_log(log, run, time_unit=time_unit)
    if summary is None or not summary.clear or summary.input is None or summary.output is None:
        raise _choice(command, log, summary)
    pair = input or summary.input, output or summary.output
    if pair[0] == pair[1]:
        raise _choice(command, log, summary)
    words = typed(["--input", pair[0], "--output", pair[1]])
    terminal(stderr=quiet).print(f"columns: {words}, by their names and units\n", soft_wrap=True)
    return pair


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
