"""Writes signals, runs and result tables as CSV or MCAP.

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
from itertools import repeat
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from dehyst.errors import OutputError
from dehyst.files import FULL, write_atomically
from dehyst.io._cells import FORMULA, cell_number
from dehyst.io._foreign import optional
from dehyst.io._formats import PathLike
from dehyst.shell import visible

# Field with the channel's clock in all its bits; the message's stamp has nanoseconds.
TIME = "time_s"
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
    cells: dict[str, list[Any]] = {}
    shapes: dict[str, tuple[int, ...]] = {}
    for name, values in columns.items():
        array = np.asarray(values)
        shapes[name] = array.shape
        cells[name] = array.tolist()
    if len(set(shapes.values())) != 1 or len(next(iter(shapes.values()))) != 1:
        raise OutputError(
            f"cannot write '{path}': its columns must be vectors of one length, got {shapes or 'none'}.",
            sizes=shapes,
        )
    return csv_text(cells, zip(*cells.values(), strict=True))


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
    for row in rows:
        writer.writerow(map(_cell, row))
    return stream.getvalue()


def _cell(value: object) -> object:
    if not isinstance(value, str):
        return value
    shown = visible(value)
    if FORMULA.match(shown) and cell_number(shown) is None:
        return f"'{shown}"
    return shown


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
    if target.suffix.lower() != ".csv":
        raise OutputError(
            f"cannot write '{target}': a table is a CSV file. Name a file that ends in .csv.",
            path=str(target),
        )
    try:
        if target.is_dir():
            raise OutputError(
                f"cannot write '{target}': it is a folder. Name a file inside it.", path=str(target)
            )
        folder_exists = target.parent.is_dir()
    except (OSError, ValueError) as fault:
        reason = getattr(fault, "strerror", None) or fault
        raise OutputError(
            f"cannot write '{target}': {reason}. Name another file.", path=str(target)
        ) from None
    if not folder_exists:
        raise OutputError(
            f"cannot write '{target}': there is no folder '{target.parent}'. Make it, or name a folder that exists.",
            path=str(target),
        )
    return target


def write_table(path: PathLike, columns: Mapping[str, Sequence[Any]]) -> Path:
    """Write columns of equal length to a CSV file, with all digits, atomically.

    A cell is a number, a text, a truth value or None, which is empty like a NaN; a list, say, is written as JSON text.

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
        raise OutputError(
            f"cannot write '{target}': columns must have one length, got {sizes or 'none'}.",
            sizes=sizes,
        )
    rows = zip(*columns.values(), strict=True)
    return write_atomically(target, csv_text(columns, (map(_plain_cell, row) for row in rows)))


def _plain_cell(value: Any) -> Cell:
    """A number, text or None for a value of any kind."""
    if isinstance(value, float) and math.isnan(value):
        return None
    if value is None or isinstance(value, bool | int | float | str):
        return value
    return json.dumps(value, default=str)


@dataclass(frozen=True, eq=False)
class _Channel:
    """One topic: its fields, the stamps (T,) [ns], and the messages as bytes, (T, 4 + 8 F)."""

    topic: str
    fields: tuple[str, ...]
    stamps: npt.NDArray[np.int64]
    messages: npt.NDArray[np.uint8]


def write_mcap(
    path: PathLike, channels: Mapping[str, tuple[npt.ArrayLike, Mapping[str, npt.ArrayLike]]]
) -> Path:
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
        raise OutputError(
            f"cannot write '{target}': there is no channel. Give one at least.", path=str(target)
        )
    first = _first_time(channels)
    packed: list[_Channel] = []
    for name, (time, columns) in channels.items():
        packed.append(_pack(target, name, np.asarray(time), columns, first))
    return write_atomically(target, _bytes_of(target, packed, rosbag2, typesys))


def _first_time(channels: Mapping[str, tuple[npt.ArrayLike, Mapping[str, npt.ArrayLike]]]) -> float:
    """Time that becomes the stamp zero: MCAP's clock has no sign."""
    first = 0.0
    for time, _ in channels.values():
        if np.size(time) and np.all(np.isfinite(time)):
            first = min(first, float(np.min(time)))
    return first


def _pack(
    path: Path,
    name: str,
    time: npt.NDArray[Any],
    columns: Mapping[str, npt.ArrayLike],
    first: float,
) -> _Channel:
    """Messages of a channel in CDR: a header, then the float64 fields, all aligned by themselves."""
    values = {TIME: time}
    for key, column in columns.items():
        values[key] = np.asarray(column)
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
    column, fault = None, "is no name of a message's field"
    if twice:
        column, fault = TIME, "is the channel's own time"
    for key in values:
        if not _FIELD.fullmatch(key) or keyword.iskeyword(key):
            column = key
            break
    if column is not None:
        raise OutputError(
            f"cannot write '{path}': column {column!r} of channel '{name}' {fault}. Use letters, digits and single "
            f"underscores, for example 'angle_rad'.",
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
        cure = "Name another such folder in TMPDIR."
        if fault.errno in FULL:
            cure = "Free some space, or name another such folder in TMPDIR."
        raise OutputError(
            f"cannot write '{path}': {fault.strerror or fault} in the folder for temporary files. {cure}",
            path=str(path),
        ) from None


def _fill(bag: Path, channels: Sequence[_Channel], rosbag2: Any, typesys: Any) -> None:
    writer = rosbag2.Writer(bag, version=9, storage_plugin=rosbag2.StoragePlugin.MCAP)
    writer.set_compression(rosbag2.CompressionMode.STORAGE, rosbag2.CompressionFormat.ZSTD)
    store = typesys.get_typestore(typesys.Stores.EMPTY)
    with writer:
        stamps: list[int] = []
        messages: list[tuple[Any, npt.NDArray[np.uint8]]] = []
        for channel in channels:
            link = _link(writer, store, typesys, channel)
            stamps.extend(channel.stamps.tolist())
            messages.extend(zip(repeat(link), channel.messages, strict=False))
        # In the order of time over all channels: a player need not sort, and a chunk of the file is a stretch of time.
        for k in np.argsort(stamps, kind="stable").tolist():
            link, message = messages[k]
            writer.write(link, stamps[k], message.data)


def _link(writer: Any, store: Any, typesys: Any, channel: _Channel) -> Any:
    """Connection of a topic; channels with the same columns share a message type.

    Types have numbers, not the channels' names: readers pass over types by name ("Log", "Image").
    """
    for connection in writer.connections:
        if tuple(name for name, _ in store.fielddefs[connection.msgtype][1]) == channel.fields:
            return writer.add_connection(channel.topic, connection.msgtype, typestore=store)
    msgtype = f"dehyst/msg/Signals{len(store.fielddefs) + 1}"
    definition = "\n".join(f"float64 {name}" for name in channel.fields) + "\n"
    store.register(typesys.get_types_from_msg(definition, msgtype))
    return writer.add_connection(channel.topic, msgtype, typestore=store)
