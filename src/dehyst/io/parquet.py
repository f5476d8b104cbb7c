"""Parquet and Feather (Arrow), whole or in chunks, by polars: the extra ``dehyst[parquet]``."""

from __future__ import annotations

import io
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from dehyst.io.collect import Collector
from dehyst.io.foreign import guard, muted_stderr, optional, refuse_bomb
from dehyst.io.streams import HEAD_ROWS, Column, Piece, Source, numbers_of
from dehyst.io.table import Table
from dehyst.shell import visible


def read_parquet(data: bytes, name: str, sha256: str) -> Table:
    """Read a Parquet or Feather file; nulls become NaN, date-times seconds, text labels."""
    polars = optional("polars", "parquet", name)
    found = Collector(name)
    guard(name, "Parquet or Feather file", len(data), lambda: _fill(found, polars, data))
    return found.table(sha256)


def _fill(found: Collector, polars: Any, data: bytes) -> None:
    with muted_stderr():
        arrow = data.startswith(b"ARROW1")
        plan = (polars.scan_ipc if arrow else polars.scan_parquet)(io.BytesIO(data))
        # A column of one value packs into nothing: count rows and columns before unpacking them.
        rows = int(plan.select(polars.len()).collect().item())
        refuse_bomb(8 * rows * len(plan.collect_schema()), len(data), found.name)
        frame = (polars.read_ipc if arrow else polars.read_parquet)(io.BytesIO(data))
        for series in frame.get_columns():
            values = values_of(polars, series)
            if values is not None:
                found.add(series.name, values)


def values_of(polars: Any, series: Any) -> npt.NDArray[Any] | None:
    """Values of a column: nulls become NaN or "", other types than numbers, text and times None."""
    if series.dtype in (polars.String, polars.Categorical):
        return np.array(series.cast(polars.String).fill_null("").to_list(), dtype=np.str_)
    if series.dtype.is_numeric() or series.dtype == polars.Boolean:
        return np.asarray(series.cast(polars.Float64).to_numpy())
    return np.asarray(series.to_numpy()) if series.dtype.is_temporal() else None


class TableSource(Source):
    """A .parquet or .feather file."""

    costly = False

    def __init__(self, path: Path, head: bytes) -> None:
        self.path, self.size = path, path.stat().st_size
        self._polars: Any = optional("polars", "parquet", path.name)
        self._arrow = head.startswith(b"ARROW1")
        self._rows = 0
        found = Collector(path.name)
        guard(path.name, "Parquet or Feather file", self.size, lambda: self._collect(found))
        self._table = found.table("")
        self.lengths: Mapping[str, int] = dict.fromkeys(self._table.order, self._rows)

    def _plan(self) -> Any:
        return (self._polars.scan_ipc if self._arrow else self._polars.scan_parquet)(self.path)

    def _collect(self, found: Collector) -> None:
        with muted_stderr():
            self._rows = int(self._plan().select(self._polars.len()).collect().item())
            for series in self._plan().slice(0, HEAD_ROWS).collect().get_columns():
                values = values_of(self._polars, series)
                if values is not None:
                    found.add(series.name, values)

    def _columns(self, names: Sequence[str], first: int, rows: int) -> list[Column]:
        series: dict[str, Any] = {}

        def fill() -> None:
            with muted_stderr():
                plan = self._plan()
                inside = {visible(name): name for name in reversed(plan.collect_schema().names())}
                wanted = plan.select([inside.get(name, name) for name in dict.fromkeys(names)]).slice(first, rows)
                for s in wanted.collect().get_columns():
                    series[visible(s.name)] = numbers_of(np.asarray(values_of(self._polars, s)))

        guard(self.path.name, "Parquet or Feather file", self.size, fill)
        return [series[name] for name in names]

    def pieces(self, names: Sequence[str], rows: int) -> Iterator[Piece]:
        """All rows of some columns, at most `rows` at a time."""
        for k in range(0, self._rows, rows):
            columns = self._columns(names, k, rows)
            number = np.arange(k + 1, k + columns[0].size + 1, dtype=np.int64)
            yield Piece(columns, number, self.size * min(self._rows, k + rows) // self._rows)
