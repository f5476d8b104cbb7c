"""Reads logs and writes tables: files become tables (`formats`), tables become recordings (`logs`)."""

from dehyst.io.chunks import ChunkedLog, open_chunks
from dehyst.io.example import example_csv, example_recording, write_example
from dehyst.io.inspect import ColumnSummary, LogSummary, Sampling, inspect_log
from dehyst.io.logs import Signal, read_log, read_signal
from dehyst.io.write import format_csv, write_csv, write_mcap

__all__ = [
    "ChunkedLog",
    "ColumnSummary",
    "LogSummary",
    "Sampling",
    "Signal",
    "example_csv",
    "example_recording",
    "format_csv",
    "inspect_log",
    "open_chunks",
    "read_log",
    "read_signal",
    "write_csv",
    "write_example",
    "write_mcap",
]
