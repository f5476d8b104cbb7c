"""MAT files up to version 7, by scipy: vectors, matrices, structs, strings, Simulink's structure with time."""

from __future__ import annotations

import io
import struct
import zlib
from typing import Any

import numpy as np

from dehyst.findings import Finding
from dehyst.io.collect import Collector, strings_of
from dehyst.io.foreign import BINARY_FREE, foreign_reader, refuse_bomb
from dehyst.io.table import Table
from dehyst.io.text import EXPANSION_LIMIT

COMPRESSED = 15  # type of a packed element
MAX_DEPTH = 6
MAX_ITEMS = 200


def read_mat(data: bytes, name: str, sha256: str) -> Table:
    """Read a MAT file of version 4, 6 or 7.

    A struct field becomes ``struct.field``; a signal of Simulink's structure with time takes its label.

    Raises
    ------
    LogError
        If it is damaged, unpacks to more than the limit, or holds no numbers.
    """
    found = Collector(name)
    with foreign_reader(name, "MAT file"):
        _refuse_packed_bomb(data, name)
        from scipy.io import loadmat  # 60 ms that the other formats need not pay

        for key, value in loadmat(io.BytesIO(data)).items():
            if not key.startswith("__"):
                _walk(found, key, value, 0)
    return found.table(sha256)


def _refuse_packed_bomb(data: bytes, name: str) -> None:
    """Unpack every packed element up to the limit, keeping nothing."""
    if not data.startswith(b"MATLAB 5.0"):
        return
    order = "<" if data[126:128] == b"IM" else ">"
    limit = max(BINARY_FREE, EXPANSION_LIMIT * len(data))
    place, total = 128, 0
    while place + 8 <= len(data):
        kind, size = struct.unpack(order + "II", data[place : place + 8])
        if kind == COMPRESSED:
            total += len(zlib.decompressobj().decompress(data[place + 8 : place + 8 + size], limit + 1))
            refuse_bomb(total, len(data), name)
        place += 8 + size


def _walk(found: Collector, path: str, value: Any, depth: int) -> None:
    if depth > MAX_DEPTH:
        return
    kind = type(value).__name__
    if kind in {"MatlabOpaque", "MatlabFunction"}:
        note_object(found, path)
    elif isinstance(value, np.ndarray) and value.dtype.names:
        items = value.reshape(-1)[:MAX_ITEMS]
        for k, item in enumerate(items):
            _walk_struct(found, path if items.size == 1 else f"{path}({k + 1})", item, depth)
    elif isinstance(value, np.ndarray) and value.dtype == object:
        _walk_cell(found, path, value, depth)
    elif isinstance(value, np.ndarray):
        found.add(path, value)


def _walk_struct(found: Collector, path: str, item: Any, depth: int) -> None:
    names = item.dtype.names
    label = _text(item["label"]) if "label" in names and "values" in names else ""
    for field in names:
        if field == "values" and label:
            # signals(k).values named by its label, beside the time of the struct above
            _walk(found, f"{path.rpartition('.')[0] or path}.{label}", item[field], depth + 1)
        elif not (field in {"label", "blockName"} and "values" in names):
            _walk(found, f"{path}.{field}", item[field], depth + 1)


def _walk_cell(found: Collector, path: str, value: Any, depth: int) -> None:
    cells = value.reshape(-1)
    texts = strings_of([_text(cell) or cell for cell in cells])
    if texts is not None:
        found.add(path, texts)
        return
    for k, cell in enumerate(cells[:MAX_ITEMS]):
        _walk(found, f"{path}{{{k + 1}}}", cell, depth + 1)


def _text(value: Any) -> str:
    array = np.asarray(value)
    return str(array.reshape(-1)[0]).strip() if array.dtype.kind == "U" and array.size == 1 else ""


def note_object(found: Collector, path: str) -> None:
    """Say which variable is a MATLAB object that only MATLAB can read, and how to save it."""
    path = path if path and path != "None" else "of the file"
    found.findings.append(
        Finding(
            "matlab-object",
            f"a variable {path} in {found.name} is a MATLAB object (timeseries, table, ...), which only MATLAB "
            f"can read. Save its numbers: s = struct('time', ts.Time, 'data', ts.Data); save('log.mat', 's')",
        )
    )
