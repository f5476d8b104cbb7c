"""Writes signals, runs and result tables as CSV, Parquet or MCAP.

A run as an MCAP file (the extra ``dehyst[ros]``) has one topic a channel and one message a sample. The message type is
made for the channel: a float64 field a column, under the column's name, and its definition stands in the file, so that
Foxglove or PlotJuggler offer ``/joint_1.angle_rad`` by name.
"""

from __future__ import annotations

import csv
import io
import json
import keyword
import math
import re
import tempfile
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from dehyst.errors import OutputError
from dehyst.files import FULL, write_atomically
from dehyst.io.cells import FORMULA, number
from dehyst.io.foreign import muted_stderr, optional
from dehyst.io.formats import PathLike
from dehyst.shell import visible

ENDINGS = (".csv", ".parquet")
TIME = "time_s"  # field with the channel's clock in all its bits; the message's stamp has nanoseconds
CDR_HEADER = b"\x00\x01\x00\x00"  # plain CDR, little endian
_FIELD = re.compile(r"[A-Za-z][A-Za-z0-9]*(_[A-Za-z0-9]+)*")
_TOPIC = re.compile(r"/?[A-Za-z][A-Za-z0-9_]*(/[A-Za-z][A-Za-z0-9_]*)*")

Cell = float | int | bool | str | None


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


@dataclass(frozen=True, eq=False)
class _Channel:
    """One topic: its fields, the stamps (T,) [ns], and the messages as bytes, (T, 4 + 8 F)."""

    topic: str
    fields: tuple[str, ...]
    stamps: npt.NDArray[np.int64]
    messages: npt.NDArray[np.uint8]


def write_mcap(path: PathLike, channels: Mapping[str, tuple[npt.ArrayLike, Mapping[str, npt.ArrayLike]]]) -> Path:
    """Write channels of samples to one MCAP file, atomically.

    A message is stamped with its time in whole nanoseconds; its field ``time_s`` and all columns keep every bit. Times
    below zero move the stamps of all channels, so that the first one is zero.

    Parameters
    ----------
    path
        File to write, ``.mcap``; an existing one is replaced.
    channels
        Topic -> time, (T,) [s], and its columns by name, (T,) each. T may differ from channel to channel. Names are
        letters, digits and single underscores: ``"joint_1"``, ``"angle_rad"``.

    Raises
    ------
    OutputError
        If lengths differ, a name cannot be a ROS name, time is not finite, or the file cannot be written.
    MissingExtraError
        If rosbags is not installed.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "run.mcap"
    >>> write_mcap(file, {"joint_1": ([0.0, 0.5], {"angle_rad": [0.1, 0.2]})}).name
    'run.mcap'
    """
    target = Path(path)
    rosbag2 = optional("rosbags.rosbag2", "ros", target.name, "writing", "write CSV")
    typesys = optional("rosbags.typesys", "ros", target.name, "writing", "write CSV")
    if not channels:
        raise OutputError(f"cannot write '{target}': there is no channel. Give one at least.", path=str(target))
    first = _first_time(channels)
    packed = [_pack(target, name, np.asarray(t), columns, first) for name, (t, columns) in channels.items()]
    return write_atomically(target, _bytes_of(target, packed, rosbag2, typesys))


def _first_time(channels: Mapping[str, tuple[npt.ArrayLike, Mapping[str, npt.ArrayLike]]]) -> float:
    """Time that becomes the stamp zero: MCAP's clock has no sign."""
    starts = [float(np.min(t)) for t, _ in channels.values() if np.size(t) and np.all(np.isfinite(t))]
    return min(0.0, *starts) if starts else 0.0


def _pack(
    path: Path, name: str, time: npt.NDArray[Any], columns: Mapping[str, npt.ArrayLike], first: float
) -> _Channel:
    """Messages of a channel in CDR: a header, then the float64 fields, all aligned by themselves."""
    values = {TIME: time, **{key: np.asarray(column) for key, column in columns.items()}}
    _check(path, name, values, TIME in columns)
    t = time.astype(np.float64)
    body = np.column_stack([value.astype("<f8") for value in values.values()]).astype("<f8")
    messages = np.empty((t.size, len(CDR_HEADER) + 8 * len(values)), dtype=np.uint8)
    messages[:, : len(CDR_HEADER)] = np.frombuffer(CDR_HEADER, dtype=np.uint8)
    messages[:, len(CDR_HEADER) :] = np.ascontiguousarray(body).view(np.uint8).reshape(t.size, -1)
    stamps = np.round((t - first) * 1e9).astype(np.int64)
    return _Channel("/" + name.lstrip("/"), tuple(values), stamps, messages)


def _check(path: Path, name: str, values: Mapping[str, npt.NDArray[Any]], twice: bool) -> None:
    if not _TOPIC.fullmatch(name):
        raise OutputError(
            f"cannot write '{path}': channel {name!r} is no name of a topic. Use letters, digits and underscores, "
            f"for example 'joint_1'.",
            channel=name,
        )
    bad = [key for key in values if not _FIELD.fullmatch(key) or keyword.iskeyword(key)]
    if bad or twice:
        column = bad[0] if bad else TIME
        raise OutputError(
            f"cannot write '{path}': column {column!r} of channel '{name}' "
            + ("is the channel's own time" if twice else "is no name of a message's field")
            + ". Use letters, digits and single underscores, for example 'angle_rad'.",
            channel=name,
            column=column,
        )
    shapes = {key: value.shape for key, value in values.items()}
    time = values[TIME]
    if time.ndim != 1 or len(set(shapes.values())) != 1:
        raise OutputError(
            f"cannot write '{path}': time and columns of channel '{name}' must be vectors of one length, got {shapes}.",
            channel=name,
            shapes=shapes,
        )
    if not np.all(np.isfinite(time)) or (time.size and float(np.ptp(time)) > 9e9):
        raise OutputError(
            f"cannot write '{path}': the time of channel '{name}' is not finite or spans more than 285 years. "
            f"Give seconds.",
            channel=name,
        )


def _bytes_of(path: Path, channels: Sequence[_Channel], rosbag2: Any, typesys: Any) -> bytes:
    """Write a bag in a folder of its own and return its one MCAP file."""
    try:
        with tempfile.TemporaryDirectory(prefix="dehyst-mcap-") as folder:
            bag = Path(folder) / "run"
            _fill(bag, channels, rosbag2, typesys)
            return (bag / "run.mcap").read_bytes()
    except OSError as fault:
        raise OutputError(
            f"cannot write '{path}': {fault.strerror or fault} in the folder for temporary files. "
            f"{'Free some space, or name' if fault.errno in FULL else 'Name'} another such folder in TMPDIR.",
            path=str(path),
        ) from None


def _fill(bag: Path, channels: Sequence[_Channel], rosbag2: Any, typesys: Any) -> None:
    writer = rosbag2.Writer(bag, version=9, storage_plugin=rosbag2.StoragePlugin.MCAP)
    writer.set_compression(rosbag2.CompressionMode.STORAGE, rosbag2.CompressionFormat.ZSTD)
    store = typesys.get_typestore(typesys.Stores.EMPTY)
    with writer:
        links = [_link(writer, store, typesys, channel) for channel in channels]
        # In the order of time over all channels: a player need not sort, and a chunk of the file is a stretch of time.
        owner = np.repeat(np.arange(len(channels)), [channel.stamps.size for channel in channels])
        index = np.concatenate([np.arange(channel.stamps.size) for channel in channels])
        stamps = np.concatenate([channel.stamps for channel in channels])
        order = np.argsort(stamps, kind="stable")
        rows = [channel.messages for channel in channels]
        for k, i, ns in zip(owner[order].tolist(), index[order].tolist(), stamps[order].tolist(), strict=True):
            writer.write(links[k], ns, rows[k][i].data)


def _link(writer: Any, store: Any, typesys: Any, channel: _Channel) -> Any:
    """Connection of a topic; channels with the same columns share a message type.

    Types have numbers, not the channels' names: readers pass over types by name ("Log", "Image").
    """
    for known, connection in ((c.msgtype, c) for c in writer.connections):
        if tuple(name for name, _ in store.fielddefs[known][1]) == channel.fields:
            return writer.add_connection(channel.topic, connection.msgtype, typestore=store)
    msgtype = f"dehyst/msg/Signals{len(store.fielddefs) + 1}"
    definition = "\n".join(f"float64 {name}" for name in channel.fields) + "\n"
    store.register(typesys.get_types_from_msg(definition, msgtype))
    return writer.add_connection(channel.topic, msgtype, typestore=store)
