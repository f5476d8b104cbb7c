"""NumPy's own files: .npz archives and .npy arrays. Nothing in them is ever unpickled."""

from __future__ import annotations

import io
import zipfile

import numpy as np

from dehyst.errors import LogError
from dehyst.io.collect import Collector
from dehyst.io.foreign import guard, refuse_bomb
from dehyst.io.table import Table


def read_npz(data: bytes, name: str, sha256: str) -> Table:
    """Read an archive: every vector a column, every matrix ``key_1``, ``key_2``, ...

    Raises
    ------
    LogError
        If it is damaged, no archive of arrays, or unpacks to more than the limit.
    """
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
    """Read a single array: fields of a structured array, or ``column_1``, ``column_2``, ... of a matrix.

    Raises
    ------
    LogError
        If it is damaged or holds Python objects.
    """
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
