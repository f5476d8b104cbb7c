"""Parquet and Feather (Arrow), whole or in parts, by polars: the extra ``dehyst[parquet]``.

Nulls become NaN, date-times seconds, text labels.
"""

from __future__ import annotations

import base64
import io
import struct
from collections.abc import Mapping, Sequence
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from dehyst.io._collect import HEAD_ROWS, Collector, Column, Source, numbers_of
from dehyst.io._foreign import muted_stderr, refuse_bomb
from dehyst.shell import visible

SCHEMA_BYTES = 1 << 20  # at the begin of an Arrow file, which hold its schema


def fill(collector: Collector, data: bytes, path: Path) -> None:
    """Add every column of a file."""
    import polars

    with muted_stderr():
        plan = _plan(data[:6], io.BytesIO(data))
        # A column of one value packs into nothing: count rows and columns before unpacking them.
        rows = int(plan.select(polars.len()).collect().item())
        refuse_bomb(8 * rows * len(plan.collect_schema()), len(data), collector.name)
        _add(
            collector,
            plan,
            _units(data[:6], data if data.startswith(b"ARROW1") else io.BytesIO(data)),
        )


def _plan(head: bytes, file: Any) -> Any:
    """What can be read from a file that begins like this."""
    import polars

    return (polars.scan_ipc if head.startswith(b"ARROW1") else polars.scan_parquet)(file)


def _add(collector: Collector, plan: Any, units: Mapping[str, str]) -> None:
    for series in plan.collect().get_columns():
        values = _values(series)
        if values is not None:
            collector.add(series.name, values, units.get(series.name, ""))


def _units(head: bytes, file: Any) -> dict[str, str]:
    """Units that the fields of a file carry as metadata, by name; polars passes them over."""
    import polars

    with suppress(Exception):  # a label: where it cannot be read, the log still can
        if head.startswith(b"ARROW1"):
            return units_of_schema(file[8:])
        return units_of_schema(base64.b64decode(polars.read_parquet_metadata(file)["ARROW:schema"]))
    return {}


def units_of_schema(message: bytes) -> dict[str, str]:
    """Units of the fields of an Arrow schema, whose metadata name them.

    The message is a FlatBuffer: a table begins with the way back to the list of the places of its members.
    """

    def number(place: int, kind: str) -> int:
        return int(struct.unpack_from(kind, message, place)[0])

    def member(table: int, index: int) -> int:
        places = table - number(table, "<i")
        beyond = 4 + 2 * index >= number(places, "<H")
        step = 0 if beyond else number(places + 4 + 2 * index, "<H")
        return table + step + number(table + step, "<I") if step else 0

    def items(vector: int) -> list[int]:
        first = vector + 4
        return (
            [first + 4 * k + number(first + 4 * k, "<I") for k in range(number(vector, "<I"))]
            if vector
            else []
        )

    def text(place: int) -> str:
        return message[place + 4 : place + 4 + number(place, "<I")].decode("utf-8") if place else ""

    begin = 8 if message.startswith(b"\xff\xff\xff\xff") else 4
    schema = member(begin + number(begin, "<I"), 2)
    units: dict[str, str] = {}
    for field in items(member(schema, 1)):
        for pair in items(member(field, 6)):
            if text(member(pair, 0)).lower() in {"unit", "units"}:
                units[text(member(field, 0))] = text(member(pair, 1))
    return units


def _values(series: Any) -> npt.NDArray[Any] | None:
    """Values of a column: nulls become NaN or "", other types than numbers, text and times None."""
    import polars

    if series.dtype in (polars.String, polars.Categorical):
        return np.array(series.cast(polars.String).fill_null("").to_list(), dtype=np.str_)
    if series.dtype.is_numeric() or series.dtype == polars.Boolean:
        return np.asarray(series.cast(polars.Float64).to_numpy())
    return np.asarray(series.to_numpy()) if series.dtype.is_temporal() else None


class ParquetParts(Source):
    """A .parquet or .feather file."""

    def _scan(self) -> Any:
        with self.path.open("rb") as stream:
            return _plan(stream.read(6), self.path)

    def _field_units(self) -> dict[str, str]:
        with self.path.open("rb") as stream:
            head = stream.read(SCHEMA_BYTES)
        return _units(head[:6], head if head.startswith(b"ARROW1") else self.path)

    def collect(self, collector: Collector) -> None:
        """Gather the first rows of all columns."""
        import polars

        with muted_stderr():
            rows = int(self._scan().select(polars.len()).collect().item())
            _add(collector, self._scan().slice(0, HEAD_ROWS), self._field_units())
        self.lengths = dict.fromkeys(collector.names, rows)

    def opened(self, stack: ExitStack, names: Sequence[str]) -> None:
        """Nothing stays open: polars reads the rows of each part anew."""

    def part(self, file: None, names: Sequence[str], begin: int, end: int) -> list[Column]:
        """Rows of some columns from one to another."""
        columns: dict[str, Column] = {}
        with muted_stderr():
            plan = self._scan()
            inside = {visible(name): name for name in reversed(plan.collect_schema().names())}
            wanted = [inside.get(name, name) for name in dict.fromkeys(names)]
            for series in plan.select(wanted).slice(begin, end - begin).collect().get_columns():
                columns[visible(series.name)] = numbers_of(np.asarray(_values(series)))
        return [columns[name] for name in names]
