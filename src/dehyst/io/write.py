"""Signals and tables of results to files that dehyst, and anything else, can read back."""

from __future__ import annotations

import csv
import io
import json
import math
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from dehyst.errors import OutputError
from dehyst.files import write_atomically
from dehyst.io.cells import FORMULA, number
from dehyst.io.foreign import muted_stderr, optional
from dehyst.io.formats import PathLike
from dehyst.shell import visible


def format_csv(columns: Mapping[str, npt.ArrayLike], path: PathLike = "the table") -> str:
    """Return columns of equal length as CSV text, with all digits.

    `path` is where it is going, for the message of an error.

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


ENDINGS = (".csv", ".parquet")

Cell = float | int | bool | str | None


def require_table_name(path: PathLike) -> Path:
    """Return the path of a table to be written, or refuse it before anything is computed for it."""
    target = Path(path)
    if target.suffix.lower() not in ENDINGS:
        raise OutputError(
            f"cannot write '{target}': its ending says neither CSV nor Parquet. Name a file that ends in "
            f"{' or '.join(ENDINGS)}.",
            path=str(target),
        )
    try:
        if target.is_dir():
            raise OutputError(f"cannot write '{target}': it is a folder. Name a file inside it.", path=str(target))
        found = target.parent.is_dir()
    except (OSError, ValueError) as fault:
        reason = getattr(fault, "strerror", None) or fault
        raise OutputError(f"cannot write '{target}': {reason}. Name another file.", path=str(target)) from None
    if not found:
        raise OutputError(
            f"cannot write '{target}': there is no folder '{target.parent}'. Make it, or name a folder that exists.",
            path=str(target),
        )
    if target.suffix.lower() == ".parquet":
        _polars(target)
    return target


def write_table(path: PathLike, columns: Mapping[str, Sequence[Any]]) -> Path:
    """Write columns of equal length to a CSV or Parquet file, with all digits, atomically.

    A cell is a number, a text, a truth value or None (empty in CSV, null in Parquet); anything else, a list say, is
    written as JSON text. A NaN is a missing number and becomes None. A column of numbers and texts is one of texts.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "x.csv"
    >>> write_table(file, {"name": ["a", "b"], "rms": [0.1, None]}).read_text().split()
    ['name,rms', 'a,0.1', 'b,']
    """
    target = require_table_name(path)
    sizes = {name: len(cells) for name, cells in columns.items()}
    if not sizes or len(set(sizes.values())) != 1:
        raise OutputError(f"cannot write '{target}': columns must have one length, got {sizes or 'none'}.", sizes=sizes)
    plain = {name: _uniform([_plain_cell(value) for value in cells]) for name, cells in columns.items()}
    content = (
        _parquet(plain, target)
        if target.suffix.lower() == ".parquet"
        else csv_text(plain, zip(*plain.values(), strict=True))
    )
    return write_atomically(target, content)


def _plain_cell(value: Any) -> Cell:
    """A number, text or None for a value of any kind."""
    if isinstance(value, float) and math.isnan(value):
        return None
    if value is None or isinstance(value, bool | int | float | str):
        return value
    return json.dumps(value, default=str)


def _uniform(cells: list[Cell]) -> list[Cell]:
    """Cells of one kind: whole numbers become floats beside floats, and everything becomes text beside text."""
    kinds = {type(cell) for cell in cells if cell is not None}
    if len(kinds) <= 1:
        return cells
    if kinds == {int, float}:
        return [None if cell is None else float(cell) for cell in cells]
    return [None if cell is None else cell if isinstance(cell, str) else json.dumps(cell) for cell in cells]


def _parquet(columns: Mapping[str, Sequence[Cell]], target: Path) -> bytes:
    polars = _polars(target)
    types = {bool: polars.Boolean, int: polars.Int64, float: polars.Float64, str: polars.String}
    series = []
    with muted_stderr():
        for name, cells in columns.items():
            kind = next((type(cell) for cell in cells if cell is not None), float)
            fits = kind is not int or all(cell is None or abs(int(cell)) < 1 << 63 for cell in cells)
            series.append(polars.Series(name, cells, dtype=types[kind if fits else float], strict=False))
        stream = io.BytesIO()
        polars.DataFrame(series).write_parquet(stream)
    return stream.getvalue()


def _polars(target: Path) -> Any:
    return optional("polars", "parquet", target.name, "writing", "name a file that ends in .csv")
