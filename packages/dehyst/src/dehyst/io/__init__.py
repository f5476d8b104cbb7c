"""Reads logs and writes tables: files become tables (`formats`), tables become recordings (`logs`)."""

from dehyst.lazy import lazy_names

TYPE_CHECKING = False
if TYPE_CHECKING:
    from dehyst.io._cells import cell_with_unit as cell_with_unit
    from dehyst.io._cells import parse_date_times as parse_date_times
    from dehyst.io._clocks import choose_clock as choose_clock
    from dehyst.io._clocks import require_unit as require_unit
    from dehyst.io._clocks import seconds as seconds
    from dehyst.io._clocks import with_time_unit as with_time_unit
    from dehyst.io._example import example_csv as example_csv
    from dehyst.io._example import example_recording as example_recording
    from dehyst.io._example import write_example as write_example
    from dehyst.io._foreign import optional as optional
    from dehyst.io._formats import read_table as read_table
    from dehyst.io._inspect import ColumnSummary as ColumnSummary
    from dehyst.io._inspect import LogSummary as LogSummary
    from dehyst.io._inspect import Sampling as Sampling
    from dehyst.io._inspect import inspect_log as inspect_log
    from dehyst.io._layout import TableLayout as TableLayout
    from dehyst.io._logs import LogColumns as LogColumns
    from dehyst.io._logs import LogSignal as LogSignal
    from dehyst.io._logs import read_columns as read_columns
    from dehyst.io._logs import read_log as read_log
    from dehyst.io._logs import read_signal as read_signal
    from dehyst.io._table import LogTable as LogTable
    from dehyst.io._two_files import read_two_files as read_two_files
    from dehyst.io._write import format_csv as format_csv
    from dehyst.io._write import write_csv as write_csv
    from dehyst.io._write import write_mcap as write_mcap

__getattr__, __dir__, __all__ = lazy_names(
    "dehyst.io",
    {
        "_cells": "cell_with_unit parse_date_times",
        "_clocks": "choose_clock require_unit seconds with_time_unit",
        "_example": "example_csv example_recording write_example",
        "_foreign": "optional",
        "_formats": "read_table",
        "_inspect": "ColumnSummary LogSummary Sampling inspect_log",
        "_layout": "TableLayout",
        "_logs": "LogColumns LogSignal read_columns read_log read_signal",
        "_table": "LogTable",
        "_two_files": "read_two_files",
        "_write": "format_csv write_csv write_mcap",
    },
)
