"""Which reader reads which file."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

from dehyst.errors import LogError
from dehyst.io.delimited import read_delimited
from dehyst.io.streams import Source
from dehyst.io.table import Table
from dehyst.io.text import SIZE_LIMIT

PathLike = str | os.PathLike[str]

THREAD_BYTES = 1 << 20  # larger files are hashed beside the reading

# First bytes by which a format is known, whatever the file is called.
BAGS = (b"#ROSBAG V2.0", b"SQLite format 3\0", b"\x89MCAP0\r\n")
ZIP = (b"PK\x03\x04", b"PK\x05\x06")
NPY = b"\x93NUMPY"
HDF5 = b"\x89HDF\r\n\x1a\n"
MDF = (b"MDF     ", b"UnFinMF ")
TABLES = (b"PAR1", b"ARROW1")
BINARY = {
    ".npz": "a NumPy archive",
    ".npy": "a NumPy array",
    ".h5": "HDF5",
    ".hdf5": "HDF5",
    ".bag": "a ROS bag",
    ".db3": "a ROS bag",
    ".mcap": "an MCAP file",
    ".mf4": "MDF",
    ".mdf": "MDF",
    ".parquet": "Parquet",
    ".feather": "Feather",
}


def read_table(path: PathLike) -> Table:
    """Read a log of any known format, chosen by the file's ending and first bytes.

    Raises
    ------
    LogError
        If the file does not exist, cannot be opened, is empty, too large, damaged, or of an unknown format.
    MissingExtraError
        If the format needs a package that is not installed.
    """
    source = path_of(path)
    with readable(source):
        if source.is_dir():
            return _read_folder(source)
        size = require_file(source)
        if size > SIZE_LIMIT:
            raise LogError(
                f"'{source.name}' has {size / 2**20:.0f} MB, more than the {SIZE_LIMIT >> 20} MB that are read "
                f"at once. Split it into runs, or read it in chunks: dehyst identify --stream, or dehyst.open_chunks.",
                size=size,
            )
        data = source.read_bytes()
    if len(data) < THREAD_BYTES:
        return _dispatch(data, source, hashlib.sha256(data).hexdigest())
    with ThreadPoolExecutor(1) as other:  # hashing takes as long as parsing, and both let go of the interpreter
        digest = other.submit(hashlib.sha256, data)
        return replace(_dispatch(data, source, ""), sha256=digest.result().hexdigest())


def path_of(path: PathLike) -> Path:
    """Path of a log, whatever was given for it."""
    if not isinstance(path, str | os.PathLike):
        raise LogError(
            f"the log is given as {path!r:.60}, which is no path. Give the file's name, for example 'log.csv'; of "
            f"arrays or a table in memory, make a recording: dehyst.Recording(input=u, output=y, time=t).",
            path=path,
        )
    return Path(path)


def require_file(source: Path) -> int:
    """Bytes of a file that can be read more than once."""
    size = source.stat().st_size
    if not source.is_file():
        raise LogError(f"'{source}' is not a file that can be read twice; save it to disk first.", path=str(source))
    if size == 0:
        raise LogError(f"'{source.name}' is empty. Check that the logger was started.", path=str(source))
    return size


@contextmanager
def readable(source: Path) -> Iterator[None]:
    """Turn what the system says about a path into a LogError."""
    try:
        yield
    except OSError as fault:
        raise LogError(
            f"cannot read '{source}': {fault.strerror or fault}. Check the path and the permissions.", path=str(source)
        ) from None
    except ValueError as fault:  # a NUL byte in the path
        raise LogError(f"cannot read {str(source)!r}: {fault}. Check the path.", path=str(source)) from None


def _read_folder(source: Path) -> Table:
    """A rosbag2 folder is one log; any other folder is not."""
    if not (source / "metadata.yaml").is_file():
        raise LogError(
            f"'{source}' is a folder, not a log. Name a file inside it (a rosbag2 folder would hold metadata.yaml).",
            path=str(source),
        )
    digest = hashlib.sha256()
    for part in sorted(source.iterdir()):
        if part.suffix in {".db3", ".mcap", ".yaml"} and part.is_file():
            digest.update(part.read_bytes())
    from dehyst.io.ros import read_bag

    return read_bag(source, digest.hexdigest())


def _dispatch(data: bytes, source: Path, sha256: str) -> Table:
    """Choose the reader by the first bytes, then by the ending; readers are imported when they are needed."""
    name, ending = source.name, source.suffix.lower()
    if data.startswith(BAGS):
        from dehyst.io.ros import read_bag

        return read_bag(source, sha256)
    if data.startswith(ZIP):
        from dehyst.io.numpy_files import read_npz

        return read_npz(data, name, sha256)
    if data.startswith(NPY):
        from dehyst.io.numpy_files import read_npy

        return read_npy(data, name, sha256)
    if data.startswith(HDF5) or data[512:520] == HDF5:
        from dehyst.io.hdf5 import read_hdf5

        return read_hdf5(data, name, sha256)
    if data.startswith(MDF):
        from dehyst.io.mdf import read_mdf

        return read_mdf(data, name, sha256)
    if data.startswith(TABLES):
        from dehyst.io.parquet import read_parquet

        return read_parquet(data, name, sha256)
    if data.startswith(b"MATLAB 5.0") or (ending == ".mat" and b"\0" in data[:20]):
        from dehyst.io.matlab import read_mat

        return read_mat(data, name, sha256)
    if ending in BINARY:
        raise LogError(
            f"'{name}' ends in {ending}, but its first bytes ({data[:8].hex(' ')}) are not those of {BINARY[ending]}: "
            f"it is damaged, or has the wrong ending. Copy or export it again.",
            path=str(source),
        )
    return read_delimited(data, name, sha256)


def open_source(path: Path, head: bytes) -> Source:
    """Source for a file that begins with `head`, of a known format; readers are imported when they are needed."""
    if head.startswith(BAGS):
        from dehyst.io.ros import BagSource

        return BagSource(path)
    if head.startswith((*ZIP, NPY)):
        from dehyst.io.numpy_files import ArraySource

        return ArraySource(path)
    if head.startswith(TABLES):
        from dehyst.io.parquet import TableSource

        return TableSource(path, head)
    from dehyst.io.stream_text import TextSource

    return TextSource(path)
