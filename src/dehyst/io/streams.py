"""Sources of chunks: what every format offers to a log that is read in chunks."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from dehyst.arrays import Rows
from dehyst.findings import Finding
from dehyst.io.table import Table

HEAD_ROWS = 1 << 16  # rows by which columns, clock and units are found

Column = npt.NDArray[np.float64] | npt.NDArray[np.str_]


@dataclass(frozen=True, slots=True)
class Piece:
    """Some rows of the columns that were asked for.

    Attributes
    ----------
    columns
        Numbers, or labels, (K,) each.
    rows
        Number of each row in the file, (K,).
    consumed
        Bytes of the file that have been read so far.
    """

    columns: Sequence[Column]
    rows: Rows
    consumed: int


class Source(Protocol):
    """A log on disk that is never in memory as a whole: its path and size in bytes.

    `lengths` is column -> number of its samples, where the file tells; columns of different lengths are on different
    clocks. `costly` tells whether a pass takes much longer than reading the numbers from a binary file would.
    """

    path: Path
    size: int
    costly: bool
    lengths: Mapping[str, int]
    _table: Table

    def head(self) -> Table:
        """First rows, as the reader of whole files gives them."""
        return self._table

    def pieces(self, names: Sequence[str], rows: int) -> Iterator[Piece]:
        """All rows of some columns, at most `rows` at a time."""
        ...

    def findings(self) -> list[Finding]:
        """What the last pass met with, besides cells without numbers."""
        return []


def numbers_of(values: npt.NDArray[Any]) -> Column:
    """Numbers of an array as `Collector` makes them: float64, date-times in seconds, text as labels."""
    if values.dtype.kind == "M":
        seconds = values.astype("datetime64[ns]").astype(np.int64) / 1e9
        return np.where(np.isnat(values), np.nan, seconds)
    if values.dtype.kind == "m":
        return values.astype("timedelta64[ns]").astype(np.float64) / 1e9
    if values.dtype.kind in "US":
        return labels_of(values)
    with np.errstate(all="ignore"):
        return np.ascontiguousarray(values, dtype=np.float64)


def labels_of(values: npt.NDArray[Any]) -> npt.NDArray[np.str_]:
    """Labels of an array of texts, without blanks around them."""
    text = values.astype(np.str_) if values.dtype.kind == "U" else np.char.decode(values, "latin-1")
    return np.asarray(np.char.strip(text))
