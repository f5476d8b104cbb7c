"""Parquet and Feather (Arrow), by polars: the extra ``dehyst[parquet]``."""

from __future__ import annotations

import io

import numpy as np

from dehyst.io.collect import Collector
from dehyst.io.foreign import foreign_reader, optional
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
    with foreign_reader(name, "Parquet or Feather file"):
        read = polars.read_ipc if data.startswith(b"ARROW1") else polars.read_parquet
        frame = read(io.BytesIO(data))
        for series in frame.get_columns():
            if series.dtype in (polars.String, polars.Categorical):
                found.add(series.name, np.array(series.cast(polars.String).fill_null("").to_list(), dtype=np.str_))
            elif series.dtype.is_numeric() or series.dtype == polars.Boolean:
                found.add(series.name, series.cast(polars.Float64).to_numpy())
            elif series.dtype.is_temporal():
                found.add(series.name, series.to_numpy())
    return found.table(sha256)
