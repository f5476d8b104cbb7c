"""MAT files up to version 7: vectors, matrices, structs, strings, Simulink's structure with time."""

from __future__ import annotations

from typing import Any

import numpy as np

from dehyst.findings import Finding
from dehyst.io.collect import Collector, strings_of
from dehyst.io.foreign import guard
from dehyst.io.mat5 import OPAQUE, Text, parse_mat, parse_old
from dehyst.io.table import Table

MAX_DEPTH = 6
MAX_ITEMS = 200


def read_mat(data: bytes, name: str, sha256: str) -> Table:
    """Read a MAT file of version 4, 6 or 7.

    A struct field becomes ``struct.field``; a signal of Simulink's structure with time takes its label.
    """
    found = Collector(name)
    guard(name, "MAT file", len(data), lambda: _fill(found, data))
    return found.table(sha256)


def _fill(found: Collector, data: bytes) -> None:
    variables = parse_mat(data, found.name) if data.startswith(b"MATLAB") else parse_old(data)
    for key, value in variables.items():
        _walk(found, key, value, 0)


def _walk(found: Collector, path: str, value: Any, depth: int) -> None:
    if depth > MAX_DEPTH:
        return
    if value is OPAQUE:
        note_object(found, path)
    elif isinstance(value, Text):
        if len(value) > 1:
            found.add(path, np.array(value, dtype=np.str_))
    elif isinstance(value, np.ndarray):
        found.add(path, value)
    elif isinstance(value, list) and value and isinstance(value[0], dict):
        for k, item in enumerate(value[:MAX_ITEMS]):
            _walk_struct(found, path if len(value) == 1 else f"{path}({k + 1})", item, depth)
    elif isinstance(value, list):
        _walk_cell(found, path, value, depth)


def _walk_struct(found: Collector, path: str, item: dict[str, Any], depth: int) -> None:
    label = _single_text(item.get("label")) if "values" in item else ""
    for field, value in item.items():
        if field == "values" and label:
            # signals(k).values named by its label, beside the time of the struct above
            _walk(found, f"{path.rpartition('.')[0] or path}.{label}", value, depth + 1)
        elif not (field in {"label", "blockName"} and "values" in item):
            _walk(found, f"{path}.{field}", value, depth + 1)


def _walk_cell(found: Collector, path: str, cells: list[Any], depth: int) -> None:
    texts = strings_of([_single_text(cell) or cell for cell in cells])
    if texts is not None:
        found.add(path, texts)
        return
    for k, cell in enumerate(cells[:MAX_ITEMS]):
        _walk(found, f"{path}{{{k + 1}}}", cell, depth + 1)


def _single_text(value: Any) -> str:
    return value[0] if isinstance(value, Text) and len(value) == 1 else ""


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
