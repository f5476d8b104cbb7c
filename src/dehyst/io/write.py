"""Signals to a CSV file that dehyst, and anything else, can read back."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Mapping
from pathlib import Path

import numpy as np
import numpy.typing as npt

from dehyst.errors import OutputError
from dehyst.files import write_atomically
from dehyst.io.cells import FORMULA, number
from dehyst.io.formats import PathLike
from dehyst.visible import visible


def format_csv(columns: Mapping[str, npt.ArrayLike], path: PathLike = "the table") -> str:
    """Return columns of equal length as CSV text, with all digits.

    Parameters
    ----------
    columns
        Column name with its unit -> values, (T,).
    path
        Where it is going, for the message of an error.

    Raises
    ------
    OutputError
        If lengths differ or there is no column.

    Examples
    --------
    >>> format_csv({"p_bar": [1.0, 2.5]})
    'p_bar\\n1.0\\n2.5\\n'
    """
    arrays = {name: np.asarray(values) for name, values in columns.items()}
    sizes = {name: array.shape for name, array in arrays.items()}
    if not arrays or len(set(sizes.values())) != 1 or any(len(shape) != 1 for shape in sizes.values()):
        raise OutputError(
            f"cannot write '{path}': its columns must be vectors of one length, got {sizes or 'none'}.", sizes=sizes
        )
    return csv_text(arrays, zip(*(array.tolist() for array in arrays.values()), strict=True))


def csv_text(names: Iterable[str], rows: Iterable[Iterable[object]]) -> str:
    r"""Return a header and rows of numbers and texts as CSV; no text in it is a formula to a spreadsheet.

    A text that a spreadsheet would run (``=cmd``, ``@SUM``) has an apostrophe put before it, which reading a log takes
    away again; what no terminal may see is spelled out.

    Examples
    --------
    >>> csv_text(["=1+1", "p\n[bar]"], [[-1.5, "-1.5"], [2.0, "@x"]])
    "'=1+1,p [bar]\n-1.5,-1.5\n2.0,'@x\n"
    """
    stream = io.StringIO(newline="")
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(map(_cell, names))
    # repr of a Python float is the shortest text that reads back as the same bits.
    writer.writerows([_cell(cell) if isinstance(cell, str) else cell for cell in row] for row in rows)
    return stream.getvalue()


def _cell(text: str) -> str:
    shown = visible(text)
    return f"'{shown}" if FORMULA.match(shown) and number(shown) is None else shown


def write_csv(path: PathLike, columns: Mapping[str, npt.ArrayLike]) -> Path:
    """Write columns of equal length, with all digits, atomically.

    Parameters
    ----------
    path
        File to write; an existing one is replaced.
    columns
        Column name with its unit (``"pressure_bar"``) -> values, (T,).

    Returns
    -------
    path : pathlib.Path

    Raises
    ------
    OutputError
        If lengths differ, there is no column, or the file cannot be written.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "x.csv"
    >>> write_csv(file, {"time_s": [0.0, 0.1], "pressure_bar": [1.0, 2.5]}).read_text().split()
    ['time_s,pressure_bar', '0.0,1.0', '0.1,2.5']
    """
    return write_atomically(path, format_csv(columns, path))
