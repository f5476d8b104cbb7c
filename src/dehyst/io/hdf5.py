"""MAT files of version 7.3 and plain HDF5, by h5py."""

from __future__ import annotations

import io
from typing import Any

import numpy as np

from dehyst.findings import Finding
from dehyst.io.collect import Collector, strings_of
from dehyst.io.foreign import guard, refuse_bomb
from dehyst.io.matlab import MAX_DEPTH, MAX_ITEMS, note_object
from dehyst.io.table import Table

SIGNATURE = b"\x89HDF\r\n\x1a\n"


def read_hdf5(data: bytes, name: str, sha256: str) -> Table:
    """Read a MAT file of version 7.3, or any HDF5 file of vectors and matrices.

    A group or struct field becomes ``group.field``.
    """
    import h5py  # 100 ms that the other formats need not pay

    found = Collector(name)
    guard(name, "HDF5 file", len(data), lambda: _fill(found, h5py, data))
    return found.table(sha256)


def _refuse_circles(data: bytes) -> None:
    """Refuse a heap with an entry that leads to itself: the HDF5 library walks on for ever, and hears no signal.

    A global heap keeps texts of any length. It is "GCOL", version 1, its size at 8, then entries of number (2 bytes),
    uses, size; number 0 is what is free, and its size counts from the entry's own beginning.
    """
    begin = data.find(SIGNATURE)
    width = data[begin + (14 if data[begin + 8] < 2 else 10)]  # of a length in this file [bytes]
    head = 8 + -(-width // 8) * 8
    heap = data.find(b"GCOL\x01", begin)
    while heap >= 0:
        place, end = heap + head, min(len(data), heap + int.from_bytes(data[heap + 8 : heap + 8 + width], "little"))
        while place + head <= end:
            size = int.from_bytes(data[place + 8 : place + 8 + width], "little")
            step = head + size if data[place : place + 2] != b"\0\0" else size
            if step == 0 or step >= 1 << (8 * width - 1):
                raise ValueError(f"heap at byte {heap}: the entry at byte {place} has no end")
            place += -(-step // 8) * 8
        heap = data.find(b"GCOL\x01", heap + 1)


def _fill(found: Collector, h5py: Any, data: bytes) -> None:
    _refuse_circles(data)
    budget = _Budget(len(data), found.name)
    with h5py.File(io.BytesIO(data), "r") as file:
        for key in file:
            if not key.startswith("#"):
                _follow(found, file, key, file, key, budget, 0)


def _follow(found: Collector, file: Any, path: str, group: Any, key: str, budget: _Budget, depth: int) -> None:
    """Walk on to a member of a group, if it stands in this file."""
    link = group.get(key, getlink=True)
    node = None if hasattr(link, "filename") else group.get(key)
    if node is None or getattr(node, "is_virtual", False) or getattr(node, "external", None):
        # A log that names other files could show what its reader may see and its sender may not.
        found.findings.append(
            Finding(
                "data-elsewhere",
                f"'{path}' of {found.name} does not stand in this file: it is a link to another file or to nothing. "
                f"It was left out. Copy its numbers into the file (h5repack, or h5py), if it is wanted.",
            )
        )
    elif budget.first(node):
        _walk(found, file, path, node, budget, depth)


class _Budget:
    """Bytes that the datasets may still unpack to."""

    def __init__(self, packed: int, name: str) -> None:
        self.packed, self.name, self.used = packed, name, 0
        self._groups: set[Any] = set()

    def first(self, node: Any) -> bool:
        """Whether a dataset, or a group that was not met before: groups may hold each other."""
        known = hasattr(node, "keys") and node.id in self._groups
        if hasattr(node, "keys"):
            self._groups.add(node.id)
        return not known

    def spend(self, size: int) -> None:
        self.used += size
        refuse_bomb(self.used, self.packed, self.name)


def _walk(found: Collector, file: Any, path: str, node: Any, budget: _Budget, depth: int) -> None:
    if depth > MAX_DEPTH:
        return
    if hasattr(node, "keys"):
        label = _label(node, budget)
        for key in list(node)[:MAX_ITEMS]:
            if key == "values" and label:
                _follow(found, file, f"{path.rpartition('.')[0] or path}.{label}", node, key, budget, depth + 1)
            elif not (key in {"label", "blockName"} and "values" in node):
                _follow(found, file, f"{path}.{key}", node, key, budget, depth + 1)
        return
    kind = _matlab_class(node)
    if node.attrs.get("MATLAB_object_decode", 0):
        note_object(found, path)
    elif node.shape is None or "MATLAB_empty" in node.attrs:
        return
    elif node.dtype.kind == "O" and node.dtype.metadata and node.dtype.metadata.get("ref"):
        _walk_references(found, file, path, node, budget, depth)
    elif kind == "char":
        texts = [text for text in _texts(node, budget) if text]
        if len(texts) > 1:
            found.add(path, np.array(texts, dtype=np.str_))
    elif node.dtype.kind == "O":
        budget.spend(64 * node.size)
        values = [v.decode("utf-8", "replace") if isinstance(v, bytes) else v for v in np.ravel(node[()]).tolist()]
        labels = strings_of(values)
        if labels is not None:
            found.add(path, labels)
    else:
        budget.spend(int(node.size) * node.dtype.itemsize)
        found.add(path, node[()])


def _walk_references(found: Collector, file: Any, path: str, node: Any, budget: _Budget, depth: int) -> None:
    """Cell arrays and struct arrays hold references; a cell array of strings becomes labels."""
    budget.spend(64 * int(node.size))
    targets = [file[reference] for reference in np.ravel(node[()])[: 100 * MAX_ITEMS] if reference]
    if targets and all(_matlab_class(target) == "char" for target in targets):
        found.add(path, np.array(["".join(_texts(target, budget)) for target in targets], dtype=np.str_))
        return
    for k, target in enumerate(targets[:MAX_ITEMS]):
        single = len(targets) == 1
        _walk(found, file, path if single else f"{path}({k + 1})", target, budget, depth + 1)


def _matlab_class(node: Any) -> str:
    kind = node.attrs.get("MATLAB_class", b"")
    return kind.decode("ascii", "replace") if isinstance(kind, bytes) else str(kind)


def _texts(node: Any, budget: _Budget) -> list[str]:
    """Rows of a MATLAB char array, which is stored column by column as code units."""
    if node.shape is None or node.dtype.kind not in "ui" or len(node.shape) != 2:
        return []
    budget.spend(4 * int(node.size))
    return ["".join(map(chr, row)).strip("\0 ") for row in node[()].T.tolist()]


def _label(group: Any, budget: _Budget) -> str:
    if "label" in group and "values" in group and _matlab_class(group["label"]) == "char":
        return "".join(_texts(group["label"], budget))
    return ""
