"""Parquet and Feather in chunks, by polars, which unpacks only the row groups and columns that are asked for."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from dehyst.findings import Finding
from dehyst.io.collect import Collector
from dehyst.io.foreign import guard, muted_stderr, optional
from dehyst.io.parquet import values_of
from dehyst.io.streams import HEAD_ROWS, Column, Piece, numbers_of
from dehyst.io.table import Table
from dehyst.visible import visible


class TableSource:
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

    def head(self) -> Table:
        """First rows, as the reader of whole files gives them."""
        return self._table

    def findings(self) -> list[Finding]:
        """Nothing: every row has its cells."""
        return []

    def pieces(self, names: Sequence[str], rows: int) -> Iterator[Piece]:
        """All rows of some columns, at most `rows` at a time."""
        for k in range(0, self._rows, rows):
            columns = self._columns(names, k, rows)
            number = np.arange(k + 1, k + columns[0].size + 1, dtype=np.int64)
            yield Piece(columns, number, self.size * min(self._rows, k + rows) // self._rows)
