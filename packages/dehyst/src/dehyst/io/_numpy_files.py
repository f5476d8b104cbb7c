"""NumPy's own files, .npz archives and .npy arrays, whole or in parts. Nothing in them is ever unpickled.

Every vector becomes a column, every matrix ``key_1``, ``key_2``, ...; a single array ``column_1``, ``column_2``, ...,
or the fields of its records.
"""

from __future__ import annotations

import io
import zipfile
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
import numpy.typing as npt

from dehyst.errors import LogError
from dehyst.io._collect import (
    HEAD_ROWS,
    MAX_WIDTH,
    Collector,
    Column,
    Source,
    numbers_of,
)
from dehyst.io._foreign import refuse_bomb
from dehyst.shell import visible


def fill(collector: Collector, data: bytes, path: Path) -> None:
    """Add the array, or every array of an archive."""
    if not zipfile.is_zipfile(io.BytesIO(data)):
        array = np.load(io.BytesIO(data), allow_pickle=False)
        name = _single(array.ndim)
        if array.dtype.names:
            name = ""  # its fields have names
        collector.add(name, array)
        return
    members = _members(collector.name, io.BytesIO(data))
    refuse_bomb(sum(member.file_size for member in members), len(data), collector.name)
    pickled: list[str] = []
    with np.load(io.BytesIO(data), allow_pickle=False) as arrays:
        for key in arrays.files:
            try:
                collector.add(key, arrays[key])
            except ValueError as fault:
                if "pickle" not in str(fault):
                    raise
                pickled.append(key)
    if pickled and not collector.columns:
        raise LogError(
            f"the arrays {', '.join(pickled)} of '{collector.name}' hold Python objects, which could "
            "run code when loaded; "
            f"they are not read. Save numbers: numpy.savez(file, time=t.astype(float), ...)",
            file=collector.name,
        )


def _single(dimensions: int) -> str:
    if dimensions > 1:
        return "column"
    return "column_1"


def _members(name: str, file: Any) -> list[zipfile.ZipInfo]:
    """What is in an archive that holds arrays."""
    with zipfile.ZipFile(file) as archive:
        members = archive.infolist()
    if not any(member.filename.endswith(".npy") for member in members):
        raise LogError(
            f"'{name}' is a zip archive without NumPy arrays. A spreadsheet must be saved as CSV; an archive of logs "
            f"must be unpacked.",
            file=name,
        )
    return members


@dataclass(frozen=True, slots=True)
class _Strand:
    """Where the samples of one signal lie in a file."""

    member: str  # array of the archive, "" in an .npy file
    start: int  # byte of the first sample
    step: int  # bytes from one sample to the next
    count: int  # of samples
    dtype: np.dtype[Any]  # of one sample

    def read(self, stream: BinaryIO, samples: int, last: bool) -> npt.NDArray[Any]:
        """Return the next samples of a stream that stands at the first of them."""
        size = samples * self.step
        if last:
            # Behind the last sample the file may end.
            size += self.dtype.itemsize - self.step
        data = stream.read(size)
        if len(data) != size:
            raise EOFError(f"{self.member or 'the array'} ends early")
        return np.ndarray((samples,), self.dtype, data, 0, (self.step,))


class NumpyParts(Source):
    """An .npz archive or .npy array of vectors, matrices and records."""

    def collect(self, collector: Collector) -> None:
        """Gather the first rows of every array, and the strands of the columns that they become."""
        self._strands: dict[str, _Strand] = {}
        self._archive = zipfile.is_zipfile(self.path)
        arrays = [""]
        if self._archive:
            names = [member.filename for member in _members(self.path.name, self.path)]
            arrays = [name for name in names if name.endswith(".npy")]
        for member in arrays:
            with ExitStack() as stack:
                stream = self._open(stack, member)
                shape, fortran, dtype = _header(stream)
                start = stream.tell()
            key = member.removesuffix(".npy")
            fields: Mapping[str, Any] = {"": (dtype, 0)}
            if dtype.fields:
                fields = dtype.fields
            for name, (part, offset, *_) in fields.items():
                path = f"{key}.{name}".removeprefix(".").removesuffix(".")
                strands = _strands(member, start + offset, shape, fortran, dtype.itemsize, part)
                if strands and part.kind in "fiubMmUS":
                    self._add(collector, path, strands, len(shape))
        self.lengths = {name: strand.count for name, strand in self._strands.items()}

    def _open(self, stack: ExitStack, member: str) -> BinaryIO:
        if not self._archive:
            return stack.enter_context(self.path.open("rb"))
        archive = stack.enter_context(zipfile.ZipFile(self.path))
        return stack.enter_context(archive.open(member))  # type: ignore[return-value]

    def _add(
        self, collector: Collector, path: str, strands: list[_Strand], dimensions: int
    ) -> None:
        heads = [self._first(strand) for strand in strands]
        if strands[0].count == 1 and len(strands) == 1:
            collector.add(path, heads[0][0])
            return
        bare = visible(path) or _single(dimensions)
        head = heads[0]
        if len(strands) > 1:
            head = np.column_stack(heads)
        names = collector.add(bare, head)
        if bare in collector.labels and strands[0].dtype.kind in "US":
            names = [bare]
        self._strands.update(zip(names, strands, strict=False))

    def _first(self, strand: _Strand) -> npt.NDArray[Any]:
        with ExitStack() as stack:
            stream = self._open(stack, strand.member)
            stream.seek(strand.start)
            return strand.read(stream, min(strand.count, HEAD_ROWS), True)

    def opened(self, stack: ExitStack, names: Sequence[str]) -> list[BinaryIO | None]:
        """Streams that stand at the first sample of each column, None for one that is counted."""
        streams: list[BinaryIO | None] = []
        for name in names:
            stream = None
            if name in self._strands:
                strand = self._strands[name]
                stream = self._open(stack, strand.member)
                stream.seek(strand.start)
            streams.append(stream)
        return streams

    def part(
        self, file: list[BinaryIO | None], names: Sequence[str], begin: int, end: int
    ) -> list[Column]:
        """Samples of some columns from one to another."""
        columns: list[Column] = []
        for name, stream in zip(names, file, strict=True):
            if stream is None:
                columns.append(self.counted(name, begin, end))
                continue
            strand = self._strands[name]
            columns.append(numbers_of(strand.read(stream, end - begin, end == strand.count)))
        return columns


def _header(stream: BinaryIO) -> tuple[tuple[int, ...], bool, np.dtype[Any]]:
    read = np.lib.format.read_array_header_2_0
    if np.lib.format.read_magic(stream) == (1, 0):
        read = np.lib.format.read_array_header_1_0
    shape, fortran, dtype = read(stream)
    return shape, bool(fortran), dtype


def _strands(
    member: str, start: int, shape: tuple[int, ...], fortran: bool, item: int, dtype: np.dtype[Any]
) -> list[_Strand]:
    """Signals of an array: a vector is one, a matrix one for each place along its shorter side."""
    if dtype.shape or dtype.hasobject or 0 in shape:
        return []
    # Length of each axis and bytes from place to place on it; an axis of one place is none.
    axes: list[tuple[int, int]] = []
    size = item
    fastest_first = shape
    if not fortran:
        fastest_first = shape[::-1]
    for length in fastest_first:
        if length > 1:
            axes.append((length, size))
        size *= length
    if len(axes) > 2:
        return []
    if not fortran:
        axes.reverse()
    if not axes:
        axes.append((1, item))
    if len(axes) == 1:
        axes.append((1, 0))
    (count, step), (width, apart) = axes
    if count < width:
        count, step, width, apart = width, apart, count, step
    if width > MAX_WIDTH:
        return []
    return [_Strand(member, start + j * apart, step, count, dtype) for j in range(width)]
