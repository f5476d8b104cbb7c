"""MAT files of version 7.3 and plain HDF5, by h5py: a group or a field of a struct becomes ``group.field``."""

from __future__ import annotations

import io
import math
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from dehyst.findings import Finding
from dehyst.io._collect import (
    HEAD_ROWS,
    MAX_WIDTH,
    Collector,
    Column,
    NotInPartsError,
    Source,
    numbers_of,
    strings_of,
)
from dehyst.io._conventions import Attributes, interpret
from dehyst.io._foreign import refuse_bomb
from dehyst.io._matlab import MAX_DEPTH, MAX_ITEMS, note_object

# Attributes that point to other datasets.
OF_LIBRARIES = frozenset({"DIMENSION_LIST", "REFERENCE_LIST", "CLASS", "NAME"})
SIGNATURE = b"\x89HDF\r\n\x1a\n"
HEAP = b"GCOL\x01"
BLOCK = 1 << 24  # bytes of a file that are searched at once


def fill(collector: Collector, data: bytes, path: Path) -> None:
    """Add every dataset of vectors, matrices or texts."""
    import h5py

    _refuse_circles(io.BytesIO(data))
    with h5py.File(io.BytesIO(data), "r") as file:
        _Walk(collector, file, len(data)).all()


def _refuse_circles(stream: BinaryIO) -> None:
    """Refuse a heap with an entry that leads to itself: the HDF5 library walks on for ever, and hears no signal.

    A global heap keeps texts of any length. It is "GCOL", version 1, its size at 8, then entries of number (2 bytes),
    uses, size; number 0 is what is free, and its size counts from the entry's own beginning.
    """

    def read(place: int, size: int) -> bytes:
        stream.seek(place)
        return stream.read(size)

    end_of_file = stream.seek(0, io.SEEK_END)
    begin = next(_places(stream, SIGNATURE))
    version = read(begin + 8, 1)[0]
    width = read(begin + (14 if version < 2 else 10), 1)[0]  # of a length in this file [bytes]
    head = 8 + -(-width // 8) * 8
    for heap in _places(stream, HEAP, begin):
        place = heap + head
        end = min(end_of_file, heap + int.from_bytes(read(heap + 8, width), "little"))
        while place + head <= end:
            entry = read(place, 8 + width)
            size = int.from_bytes(entry[8:], "little")
            step = head + size if entry[:2] != b"\0\0" else size
            if step == 0 or step >= 1 << (8 * width - 1):
                raise ValueError(f"heap at byte {heap}: the entry at byte {place} has no end")
            place += -(-step // 8) * 8


def _places(stream: BinaryIO, mark: bytes, begin: int = 0) -> Iterator[int]:
    """Bytes at which a mark stands in a file, block by block."""
    overlap = len(mark) - 1
    while True:
        stream.seek(begin)
        block = stream.read(BLOCK + overlap)
        place = block.find(mark)
        while place >= 0:
            yield begin + place
            place = block.find(mark, place + 1)
        if len(block) < BLOCK + overlap:
            return
        begin += BLOCK


class _Walk:
    """A walk over the members of a file, each group once; what they unpack to is limited."""

    def __init__(self, collector: Collector, file: Any, packed: int) -> None:
        self.collector, self.file, self.packed, self.used = collector, file, packed, 0
        self.groups: set[Any] = set()  # groups may hold each other
        self.attributes = Attributes(collector)
        self.is_netcdf = "_NCProperties" in file.attrs

    def all(self) -> None:
        """Walk over the whole file."""
        for key in self.file:
            if not key.startswith("#"):
                self.follow(key, self.file, key, 0)
        self.attributes.finish()

    def spend(self, size: int) -> None:
        self.used += size
        refuse_bomb(self.used, self.packed, self.collector.name)

    def follow(self, path: str, group: Any, key: str, depth: int) -> None:
        """Walk on to a member of a group, if it stands in this file."""
        link = group.get(key, getlink=True)
        node = None if hasattr(link, "filename") else group.get(key)
        if node is None or getattr(node, "is_virtual", False) or getattr(node, "external", None):
            # A log that names other files could show what its reader may see and its sender may not.
            self.collector.findings.append(
                Finding(
                    "data-elsewhere",
                    f"'{path}' of {self.collector.name} does not stand in this file: it is a link to "
                    "another file or to "
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
            note_object(self.collector, path, _matlab_class(node))
        elif node.shape is not None and "MATLAB_empty" not in node.attrs:
            self.add(path, node, depth)

    def add(self, path: str, node: Any, depth: int) -> None:
        """Add a dataset; references of a cell array or a struct array are walked on."""
        if node.dtype.kind == "O" and node.dtype.metadata and node.dtype.metadata.get("ref"):
            self.spend(64 * int(node.size))
            references = filter(None, np.ravel(node[()])[: 100 * MAX_ITEMS])
            targets = list(map(self.file.__getitem__, references))
            if set(map(_matlab_class, targets)) == {"char"}:
                joined = ["".join(self.texts(target)) for target in targets]
                self.collector.add(path, np.array(joined, dtype=np.str_))
                return
            if len(targets) == 1:
                self.visit(path, targets[0], depth + 1)
                return
            for k, target in enumerate(targets[:MAX_ITEMS], 1):
                self.visit(f"{path}({k})", target, depth + 1)
        elif _matlab_class(node) == "char":
            texts = list(filter(None, self.texts(node)))
            if len(texts) > 1:
                self.collector.add(path, np.array(texts, dtype=np.str_))
        elif node.dtype.kind == "O":
            self.spend(64 * node.size)
            values: list[Any] = []
            for value in np.ravel(node[()]).tolist():
                if isinstance(value, bytes):
                    value = value.decode("utf-8", "replace")
                values.append(value)
            labels = strings_of(values)
            if labels is not None:
                self.collector.add(path, labels)
        else:
            self.add_numbers(path, node)

    def add_numbers(self, path: str, node: Any) -> None:
        """Add a dataset of numbers."""
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
        if "label" not in group or "values" not in group:
            return ""
        if _matlab_class(group["label"]) != "char":
            return ""
        return "".join(self.texts(group["label"]))


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


class _Head(_Walk):
    """A walk that reads the first rows of long datasets, and notes where their columns come from."""

    def __init__(self, collector: Collector, file: Any, packed: int) -> None:
        super().__init__(collector, file, packed)
        # column -> its dataset, place among its columns, rows
        self.origins: dict[str, tuple[str, int, int]] = {}

    def add_numbers(self, path: str, node: Any) -> None:
        """Add the first rows of a dataset of numbers."""
        rows = _rows(node)
        if rows <= HEAD_ROWS:
            super().add_numbers(path, node)
            return
        refuse_bomb(
            int(node.size) * node.dtype.itemsize, self.packed, self.collector.name, math.inf
        )
        before = set(self.collector.names)
        self.attributes.add(path, _cut(node, 0, HEAD_ROWS), _attributes(node), self.is_netcdf)
        columns = [name for name in self.collector.names if name not in before]
        if node.dtype.names is None or len(node.dtype.names) == len(columns):
            for place, name in enumerate(columns):
                self.origins[name] = (node.name, place, rows)


def _rows(node: Any) -> int:
    """Rows of a dataset: a vector, or a matrix with time along its longer side; 0 for anything else."""
    lengths = sorted(length for length in node.shape if length > 1)
    if not lengths or len(lengths) > 2 or (len(lengths) == 2 and lengths[0] > MAX_WIDTH):
        return 0
    return int(lengths[-1])


def _cut(node: Any, begin: int, end: int) -> Any:
    """Rows of a dataset from one to another, (rows, columns)."""
    axis = int(np.argmax(node.shape))
    part = np.asarray(node[(slice(None),) * axis + (slice(begin, end),)])
    return np.moveaxis(part, axis, 0).reshape(end - begin, -1)


class Hdf5Parts(Source):
    """A .h5, .hdf5 or .mat file of version 7.3."""

    def collect(self, collector: Collector) -> None:
        """Gather the first rows of every dataset."""
        import h5py

        with self.path.open("rb") as stream:
            _refuse_circles(stream)
        with h5py.File(self.path, "r") as file:
            head = _Head(collector, file, self.size)
            head.all()
        if len(set(head.attributes.starts.values())) > 1:
            raise NotInPartsError(
                f"the clocks of '{self.path.name}' count from several dates.", file=self.path.name
            )
        self._is_netcdf, self._origins = head.is_netcdf, head.origins
        lengths: dict[str, int] = {}
        for name, column in (*collector.columns.items(), *collector.labels.items()):
            lengths[name] = column.size
        for name, (_, _, rows) in self._origins.items():
            lengths[name] = rows
        self.lengths = lengths

    def opened(self, stack: ExitStack, names: Sequence[str]) -> Any:
        """Open the file."""
        import h5py

        return stack.enter_context(h5py.File(self.path, "r"))

    def part(self, file: Any, names: Sequence[str], begin: int, end: int) -> list[Column]:
        """Rows of some columns from one to another."""
        return [self._column(file, name, begin, end) for name in names]

    def _column(self, file: Any, name: str, begin: int, end: int) -> Column:
        short = {**self.table.columns, **self.table.labels}.get(name)
        if short is not None and short.size == self.lengths.get(name):
            return numbers_of(short[begin:end])
        if name not in self._origins:
            return self.counted(name, begin, end)
        dataset, place, _ = self._origins[name]
        node = file[dataset]
        values = interpret(_cut(node, begin, end), _attributes(node), self._is_netcdf).values
        if values.dtype.names:
            return numbers_of(values[values.dtype.names[place]][:, 0])
        return numbers_of(values[:, place])
