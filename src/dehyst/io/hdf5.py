"""MAT files of version 7.3 and plain HDF5, by h5py: a group or a field of a struct becomes ``group.field``."""

from __future__ import annotations

import io
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from dehyst.findings import Finding
from dehyst.io.collect import Collector, strings_of
from dehyst.io.conventions import Attributes
from dehyst.io.foreign import refuse_bomb
from dehyst.io.matlab import MAX_DEPTH, MAX_ITEMS, note_object

OF_LIBRARIES = frozenset({"DIMENSION_LIST", "REFERENCE_LIST", "CLASS", "NAME"})  # they point to other datasets
SIGNATURE = b"\x89HDF\r\n\x1a\n"


def fill(found: Collector, data: bytes, path: Path) -> None:
    """Add every dataset of vectors, matrices or texts."""
    import h5py

    _refuse_circles(data)
    with h5py.File(io.BytesIO(data), "r") as file:
        walk = _Walk(found, file, len(data))
        for key in file:
            if not key.startswith("#"):
                walk.follow(key, file, key, 0)
        walk.attributes.finish()


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


class _Walk:
    """A walk over the members of a file, each group once; what they unpack to is limited."""

    def __init__(self, found: Collector, file: Any, packed: int) -> None:
        self.found, self.file, self.packed, self.used = found, file, packed, 0
        self.groups: set[Any] = set()  # groups may hold each other
        self.attributes = Attributes(found)
        self.is_netcdf = "_NCProperties" in file.attrs

    def spend(self, size: int) -> None:
        self.used += size
        refuse_bomb(self.used, self.packed, self.found.name)

    def follow(self, path: str, group: Any, key: str, depth: int) -> None:
        """Walk on to a member of a group, if it stands in this file."""
        link = group.get(key, getlink=True)
        node = None if hasattr(link, "filename") else group.get(key)
        if node is None or getattr(node, "is_virtual", False) or getattr(node, "external", None):
            # A log that names other files could show what its reader may see and its sender may not.
            self.found.findings.append(
                Finding(
                    "data-elsewhere",
                    f"'{path}' of {self.found.name} does not stand in this file: it is a link to another file or to "
                    f"nothing. It was left out. Copy its numbers into the file (h5repack, or h5py), if it is wanted.",
                )
            )
        elif not hasattr(node, "keys"):
            self.visit(path, node, depth)
        elif node.id not in self.groups:
            self.groups.add(node.id)
            self.visit(path, node, depth)

    def visit(self, path: str, node: Any, depth: int) -> None:
        if depth > MAX_DEPTH:
            return
        if hasattr(node, "keys"):
            label = self.label(node)
            for key in list(node)[:MAX_ITEMS]:
                if key == "values" and label:
                    self.follow(f"{path.rpartition('.')[0] or path}.{label}", node, key, depth + 1)
                elif not (key in {"label", "blockName"} and "values" in node):
                    self.follow(f"{path}.{key}", node, key, depth + 1)
        elif node.attrs.get("MATLAB_object_decode", 0):
            note_object(self.found, path, _matlab_class(node))
        elif node.shape is not None and "MATLAB_empty" not in node.attrs:
            self.add(path, node, depth)

    def add(self, path: str, node: Any, depth: int) -> None:
        """Add a dataset; references of a cell array or a struct array are walked on."""
        if node.dtype.kind == "O" and node.dtype.metadata and node.dtype.metadata.get("ref"):
            self.spend(64 * int(node.size))
            targets = [self.file[reference] for reference in np.ravel(node[()])[: 100 * MAX_ITEMS] if reference]
            if targets and all(_matlab_class(target) == "char" for target in targets):
                self.found.add(path, np.array(["".join(self.texts(target)) for target in targets], dtype=np.str_))
                return
            for k, target in enumerate(targets[:MAX_ITEMS], 1):
                self.visit(path if len(targets) == 1 else f"{path}({k})", target, depth + 1)
        elif _matlab_class(node) == "char":
            texts = [text for text in self.texts(node) if text]
            if len(texts) > 1:
                self.found.add(path, np.array(texts, dtype=np.str_))
        elif node.dtype.kind == "O":
            self.spend(64 * node.size)
            values = [v.decode("utf-8", "replace") if isinstance(v, bytes) else v for v in np.ravel(node[()]).tolist()]
            labels = strings_of(values)
            if labels is not None:
                self.found.add(path, labels)
        else:
            self.spend(int(node.size) * node.dtype.itemsize)
            self.attributes.add(path, np.asarray(node[()]), _attributes(node), self.is_netcdf)

    def texts(self, node: Any) -> list[str]:
        """Rows of a MATLAB char array, which is stored column by column as code units."""
        if node.shape is None or node.dtype.kind not in "ui" or len(node.shape) != 2:
            return []
        self.spend(4 * int(node.size))
        return ["".join(map(chr, row)).strip("\0 ") for row in node[()].T.tolist()]

    def label(self, group: Any) -> str:
        """Name of a signal in Simulink's structure with time."""
        named = "label" in group and "values" in group and _matlab_class(group["label"]) == "char"
        return "".join(self.texts(group["label"])) if named else ""


def _attributes(node: Any) -> dict[str, Any]:
    """Attributes of a dataset, without those that cannot be read and those of netCDF and MATLAB themselves."""
    attributes: dict[str, Any] = {}
    for name in list(node.attrs)[:MAX_ITEMS]:
        if name in OF_LIBRARIES or name.startswith("MATLAB"):
            continue
        with suppress(OSError, TypeError, ValueError, KeyError):
            attributes[name] = node.attrs[name]
    return attributes


def _matlab_class(node: Any) -> str:
    kind = node.attrs.get("MATLAB_class", b"")
    return kind.decode("ascii", "replace") if isinstance(kind, bytes) else str(kind)
