"""Parquet and Feather (Arrow), by polars: the extra ``dehyst[parquet]``."""

from __future__ import annotations

import io
from typing import Any

import numpy as np
import numpy.typing as npt

from dehyst.io.collect import Collector
from dehyst.io.foreign import guard, muted_stderr, optional, refuse_bomb
from dehyst.io.table import Table


def read_parquet(data: bytes, name: str, sha256: str) -> Table:
    """Read a Parquet or Feather file; nulls become NaN, date-times seconds, text labels.

    Raises
    ------
    LogError
        If it is damaged or holds no numbers.
    MissingExtraError
        If polars is not installed.
    """
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
