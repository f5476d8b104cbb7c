"""Logs in, tables out: bar and degrees stop here."""

from dehyst.io.chunks import ChunkedLog, open_chunks
from dehyst.io.inspect import ColumnSummary, LogSummary, Sampling, inspect_log
from dehyst.io.logs import Signal, read_log, read_signal
from dehyst.io.mcap_log import write_mcap
from dehyst.io.write import format_csv, write_csv

__all__ = [
    "ChunkedLog",
    "ColumnSummary",
    "LogSummary",
    "Sampling",
    "Signal",
    "format_csv",
    "inspect_log",
    "open_chunks",
    "read_log",
    "read_signal",
    "write_csv",
    "write_mcap",
]
