"""NumPy's own files, .npz archives and .npy arrays, whole or in chunks. Nothing in them is ever unpickled."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
import numpy.typing as npt

from dehyst.errors import LogError
from dehyst.io.collect import MAX_WIDTH, Collector
from dehyst.io.foreign import guard, refuse_bomb
from dehyst.io.streams import HEAD_ROWS, Column, Piece, Source, numbers_of
from dehyst.io.table import Table
from dehyst.shell import visible


def read_npz(data: bytes, name: str, sha256: str) -> Table:
    """Read an archive: every vector a column, every matrix ``key_1``, ``key_2``, ..."""
    found = Collector(name)
    pickled: list[str] = []
    guard(name, "NPZ archive", len(data), lambda: _fill(found, data, pickled))
    if pickled and not found.columns:
        raise LogError(
            f"the arrays {', '.join(pickled)} of '{name}' hold Python objects, which could run code when loaded; they "
            f"are not read. Save numbers: numpy.savez(file, time=t.astype(float), ...)",
            file=name,
        )
    return found.table(sha256)


def read_npy(data: bytes, name: str, sha256: str) -> Table:
    """Read a single array: fields of a structured array, or ``column_1``, ``column_2``, ... of a matrix."""
    found = Collector(name)
    guard(name, "NPY array", len(data), lambda: _fill_single(found, data))
    return found.table(sha256)


def _fill(found: Collector, data: bytes, pickled: list[str]) -> None:
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        members = archive.infolist()
        refuse_bomb(sum(member.file_size for member in members), len(data), found.name)
        if not any(member.filename.endswith(".npy") for member in members):
            raise LogError(
                f"'{found.name}' is a zip archive without NumPy arrays. A spreadsheet must be saved as CSV; an archive "
                f"of logs must be unpacked.",
                file=found.name,
            )
    with np.load(io.BytesIO(data), allow_pickle=False) as arrays:
        for key in arrays.files:
            try:
                found.add(key, arrays[key])
            except ValueError as fault:
                if "pickle" not in str(fault):
                    raise
                pickled.append(key)


def _fill_single(found: Collector, data: bytes) -> None:
    array = np.load(io.BytesIO(data), allow_pickle=False)
    found.add("" if array.dtype.names else "column" if array.ndim > 1 else "column_1", array)


@dataclass(frozen=True, slots=True)
class Strand:
    """Where the samples of one signal lie in a file.

    Attributes
    ----------
    member
        Array of the archive, "" in an .npy file.
    start, step, count
        Byte of the first sample, bytes from one to the next, number of samples.
    dtype
        Of one sample.
    """

    member: str
    start: int
    step: int
    count: int
    dtype: np.dtype[Any]

    def read(self, stream: BinaryIO, samples: int, last: bool) -> npt.NDArray[Any]:
        """Return the next samples of a stream that stands at the first of them."""
        wanted = samples * self.step - (self.step - self.dtype.itemsize if last else 0)
        data = stream.read(wanted)
        if len(data) != wanted:
            raise EOFError(f"{self.member or 'the array'} ends early")
        return np.ndarray((samples,), self.dtype, data, 0, (self.step,))


class ArraySource(Source):
    """An .npz archive or .npy array of vectors, matrices and records."""

    def __init__(self, path: Path) -> None:
        self.path, self.size = path, path.stat().st_size
        self.lengths: Mapping[str, int] = {}
        self._strands: dict[str, Strand] = {}
        self._archive = zipfile.is_zipfile(path)
        self.costly = self._archive and _is_packed(path)
        found = Collector(path.name)
        kind = "NPZ archive" if self._archive else "NPY array"
        guard(path.name, kind, self.size, lambda: self._collect(found))
        self._table = found.table("")
        self.lengths = {name: strand.count for name, strand in self._strands.items()}

    def _open(self, stack: ExitStack, member: str) -> BinaryIO:
        if not self._archive:
            return stack.enter_context(self.path.open("rb"))
        archive = stack.enter_context(zipfile.ZipFile(self.path))
        return stack.enter_context(archive.open(member))  # type: ignore[return-value]

    def _members(self) -> list[str]:
        if not self._archive:
            return [""]
        with zipfile.ZipFile(self.path) as archive:
            return [name for name in archive.namelist() if name.endswith(".npy")]

    def _collect(self, found: Collector) -> None:
        """First rows of every array, and the strands of the columns that they become."""
        members = self._members()
        if not members:
            raise LogError(f"'{self.path.name}' is a zip archive without NumPy arrays.", file=self.path.name)
        for member in members:
            with ExitStack() as stack:
                stream = self._open(stack, member)
                shape, fortran, dtype = _header(stream)
                start = stream.tell()
            key = member.removesuffix(".npy")
            fields = dtype.fields or {key: (dtype, 0)}
            for name, (part, offset, *_) in fields.items():
                path = f"{key}.{name}" if key and dtype.fields else name
                self._add(
                    found, path, _strands(member, start, shape, fortran, dtype.itemsize, part, offset), len(shape)
                )

    def _add(self, found: Collector, path: str, strands: list[Strand], dimensions: int) -> None:
        if not strands or strands[0].dtype.kind not in "fiubMmUS":
            return
        heads = [self._first(strand) for strand in strands]
        if strands[0].count == 1 and len(strands) == 1:
            found.add(path, heads[0][0])
            return
        bare = visible(path) or ("column" if dimensions > 1 else "column_1")
        names = found.add(bare, np.column_stack(heads) if len(strands) > 1 else heads[0])
        if strands[0].dtype.kind in "US":
            names = [bare] if bare in found.labels else []
        self._strands.update(zip(names, strands, strict=False))

    def _first(self, strand: Strand) -> npt.NDArray[Any]:
        count = min(strand.count, HEAD_ROWS)
        with ExitStack() as stack:
            stream = self._open(stack, strand.member)
            stream.seek(strand.start)
            return strand.read(stream, count, True)

    def pieces(self, names: Sequence[str], rows: int) -> Iterator[Piece]:
        """All rows of some columns, at most `rows` at a time."""
        strands = [self._strands.get(name) for name in names]
        count = next(strand.count for strand in strands if strand)
        with ExitStack() as stack:
            streams: list[BinaryIO | None] = []
            guard(self.path.name, "NumPy file", self.size, lambda: streams.extend(self._begin(stack, strands)))
            for k in range(0, count, rows):
                samples = min(rows, count - k)
                columns: list[Column] = []

                def fill(k: int = k, samples: int = samples, into: list[Column] = columns) -> None:
                    for name, strand, stream in zip(names, strands, streams, strict=True):
                        if strand and stream:
                            into.append(numbers_of(strand.read(stream, samples, k + samples == count)))
                        else:  # time that was counted from a sampling time
                            into.append(numbers_of(np.arange(k, k + samples) * self._table.columns[name][1]))

                guard(self.path.name, "NumPy file", self.size, fill)
                number = np.arange(k + 1, k + samples + 1, dtype=np.int64)
                yield Piece(columns, number, self.size * (k + samples) // count)

    def _begin(self, stack: ExitStack, strands: Sequence[Strand | None]) -> Iterator[BinaryIO | None]:
        for strand in strands:
            stream = self._open(stack, strand.member) if strand else None
            if strand and stream:
                stream.seek(strand.start)
            yield stream


def _is_packed(path: Path) -> bool:
    with zipfile.ZipFile(path) as archive:
        return any(member.compress_type != zipfile.ZIP_STORED for member in archive.infolist())


def _header(stream: BinaryIO) -> tuple[tuple[int, ...], bool, np.dtype[Any]]:
    version = np.lib.format.read_magic(stream)
    read = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
    shape, fortran, dtype = read(stream)
    return shape, bool(fortran), dtype


def _strands(
    member: str, start: int, shape: tuple[int, ...], fortran: bool, item: int, dtype: np.dtype[Any], offset: int
) -> list[Strand]:
    """Signals of an array: a vector is one, a matrix one for each place along its shorter side."""
    if dtype.shape or dtype.hasobject or 0 in shape:
        return []
    steps, size = [], item
    for length in shape if fortran else reversed(shape):
        steps.append(size)
        size *= length
    steps = steps if fortran else steps[::-1]
    axes = [(length, step) for length, step in zip(shape, steps, strict=True) if length > 1]
    if len(axes) > 2:
        return []
    time = axes[0] if axes else (1, item)
    other = axes[1] if len(axes) == 2 else (1, 0)
    if time[0] < other[0]:
        time, other = other, time
    if other[0] > MAX_WIDTH:
        return []
    return [Strand(member, start + offset + j * other[1], time[1], time[0], dtype) for j in range(other[0])]
