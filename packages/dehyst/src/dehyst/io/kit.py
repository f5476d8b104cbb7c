"""Tools of `dehyst.io` for other rooms."""

from dehyst.lazy import lazy_names

TYPE_CHECKING = False
if TYPE_CHECKING:
    from dehyst.io._cells import HOLDS_TEXT as HOLDS_TEXT
    from dehyst.io._cells import comma_number as comma_number
    from dehyst.io._cells import date_order as date_order
    from dehyst.io._cells import parse_numbers as parse_numbers
    from dehyst.io._clocks import TIME_WORDS as TIME_WORDS
    from dehyst.io._clocks import counting_clock as counting_clock
    from dehyst.io._clocks import in_seconds as in_seconds
    from dehyst.io._clocks import two_columns as two_columns
    from dehyst.io._clocks import unit_finding as unit_finding
    from dehyst.io._collect import Collector as Collector
    from dehyst.io._collect import Source as Source
    from dehyst.io._columns import find_column as find_column
    from dehyst.io._columns import matching as matching
    from dehyst.io._delimited import layout_of as layout_of
    from dehyst.io._delimited import read_delimited as read_delimited
    from dehyst.io._layout import find_layout as find_layout
    from dehyst.io._lines import is_comment as is_comment
    from dehyst.io._lines import split_line as split_line
    from dehyst.io._logs import at_samples as at_samples
    from dehyst.io._table import LARGEST as LARGEST
    from dehyst.io._table import finite as finite
    from dehyst.io._table import measured as measured
    from dehyst.io._text import open_text as open_text
    from dehyst.io._two_files import two_places as two_places
    from dehyst.io._write import require_table_name as require_table_name
    from dehyst.io._write import write_table as write_table

__getattr__, __dir__, __all__ = lazy_names(
    "dehyst.io.kit",
    {
        "_cells": "HOLDS_TEXT comma_number date_order parse_numbers",
        "_clocks": "TIME_WORDS counting_clock in_seconds two_columns unit_finding",
        "_collect": "Collector Source",
        "_columns": "find_column matching",
        "_delimited": "layout_of read_delimited",
        "_layout": "find_layout",
        "_lines": "is_comment split_line",
        "_logs": "at_samples",
        "_table": "LARGEST finite measured",
        "_text": "open_text",
        "_two_files": "two_places",
        "_write": "require_table_name write_table",
    },
)
