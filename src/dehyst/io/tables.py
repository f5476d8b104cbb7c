"""Tables of results, CSV or Parquet by the ending of the file: one row a run, numbers and texts."""

from __future__ import annotations

import io
import json
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from dehyst.errors import OutputError
from dehyst.files import write_atomically
from dehyst.io.foreign import muted_stderr, optional
from dehyst.io.formats import PathLike
from dehyst.io.write import csv_text

ENDINGS = (".csv", ".parquet")

Cell = float | int | bool | str | None


def require_table_name(path: PathLike) -> Path:
    """Return the path of a table to be written, or refuse it before anything is computed for it.

    Raises
    ------
    OutputError
        If its ending is neither ``.csv`` nor ``.parquet``, it is a folder, or its folder does not exist.
    MissingExtraError
        If it is a Parquet file and polars is not installed.
    """
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

    Parameters
    ----------
    path
        File to write, ``.csv`` or ``.parquet``; an existing one is replaced.
    columns
        Name -> cells, (N,).

    Returns
    -------
    path : pathlib.Path

    Raises
    ------
    OutputError
        If lengths differ, there is no column, or the file cannot be written.
    MissingExtraError
        If it is a Parquet file and polars is not installed.

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
    plain = {name: _uniform([_cell(value) for value in cells]) for name, cells in columns.items()}
    content = (
        _parquet(plain, target)
        if target.suffix.lower() == ".parquet"
        else csv_text(plain, zip(*plain.values(), strict=True))
    )
    return write_atomically(target, content)


def _cell(value: Any) -> Cell:
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
