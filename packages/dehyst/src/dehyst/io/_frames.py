"""Data frames in memory (pandas, polars, Arrow and whatever narwhals knows): the extra ``dehyst[frames]``."""

from __future__ import annotations

import hashlib
from typing import Any

import numpy as np

from dehyst.errors import LogError
from dehyst.io._collect import Collector
from dehyst.io._foreign import optional
from dehyst.io._table import FRAME, LogTable, unique_names


def is_frame(log: object) -> bool:
    """Whether an object is a table in memory: it has columns with names, or offers Arrow's stream of them."""
    return any(
        hasattr(type(log), name)
        for name in ("columns", "__dataframe__", "__arrow_c_stream__", "__narwhals_dataframe__")
    )


def table_of_frame(frame: Any) -> LogTable:
    """Columns of a frame; nulls become NaN, date-times seconds, and an index of pandas that is no row number a column.

    Raises
    ------
    LogError
        If narwhals does not know the object, or it holds no numbers.
    MissingExtraError
        If narwhals is not installed.
    """
    nw = optional(
        "narwhals",
        "frames",
        FRAME,
        instead="pass arrays: dehyst.Recording(input=u, output=y, time=t)",
    )
    index = getattr(frame, "index", None)
    if index is not None and hasattr(frame, "columns") and type(index).__name__ != "RangeIndex":
        # An index without a name is most often the time.
        nameless = index.nlevels == 1 and index.names[0] is None
        frame = frame.reset_index(names="time" if nameless else None)
    try:
        native = nw.from_native(frame)
        if isinstance(native, nw.LazyFrame):
            native = native.collect()
        columns = list(map(native.__getitem__, native.columns))
    except TypeError as fault:
        raise LogError(
            f"a {type(frame).__name__} cannot be read as a table ({str(fault)[:120]}). Pass a frame of pandas, polars "
            f"or Arrow, the path of a log, or arrays: dehyst.Recording(input=u, output=y, time=t)."
        ) from None
    collector, digest = Collector(FRAME), hashlib.sha256()
    names = unique_names(list(map(str, native.columns)))
    for name, series in zip(names, columns, strict=True):
        values = _values(nw, series)
        if values is not None:
            collector.add(name, values)
            digest.update(name.encode() + values.tobytes())
    table = collector.table()
    return LogTable(**{**vars(table), "sha256": digest.hexdigest()})


def _values(nw: Any, series: Any) -> Any:
    """Values of a column: nulls become NaN or "", other types than numbers, text and times None."""
    if series.dtype in (nw.String, nw.Categorical, nw.Enum):
        return np.array(
            ["" if value is None else str(value) for value in series.to_list()], dtype=np.str_
        )
    if series.dtype.is_numeric() or series.dtype == nw.Boolean:
        return np.asarray(series.cast(nw.Float64).to_numpy(), dtype=np.float64)
    if series.dtype.is_temporal():
        if getattr(series.dtype, "time_zone", None):
            series = series.dt.convert_time_zone("UTC").dt.replace_time_zone(None)
        return np.asarray(series.to_numpy())
    return None
