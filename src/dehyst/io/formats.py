"""Which reader reads which file."""

from __future__ import annotations

import hashlib
import os
from pathlib import Path

from dehyst.errors import LogError
from dehyst.io.delimited import read_delimited
from dehyst.io.table import Table
from dehyst.io.text import SIZE_LIMIT

TEXT = (".csv", ".txt", ".tsv", ".dat", ".asc", ".log")


def read_table(path: str | os.PathLike[str]) -> Table:
    """Read a log of any known format, chosen by the file's ending and first bytes.

    Raises
    ------
    LogError
        If the file does not exist, cannot be opened, is empty, too large, damaged, or of an unknown format.
    MissingExtraError
        If the format needs a package that is not installed.
    """
    source = Path(path)
    try:
        if source.is_dir():
            return _read_folder(source)
        size = source.stat().st_size
        if not source.is_file():
            raise LogError(f"'{source}' is not a file that can be read twice; save it to disk first.", path=str(source))
        if size > SIZE_LIMIT:
            raise LogError(
                f"'{source.name}' has {size / 2**20:.0f} MB, more than the {SIZE_LIMIT >> 20} MB that are read "
                f"at once. Split it into runs.",
                size=size,
            )
        data = source.read_bytes()
    except OSError as fault:
        raise LogError(
            f"cannot read '{source}': {fault.strerror or fault}. Check the path and the permissions.", path=str(source)
        ) from None
    except ValueError as fault:  # a NUL byte in the path
        raise LogError(f"cannot read {str(source)!r}: {fault}. Check the path.", path=str(source)) from None
    if not data:
        raise LogError(f"'{source.name}' is empty. Check that the logger was started.", path=str(source))
    return _dispatch(data, source, hashlib.sha256(data).hexdigest())


def _read_folder(source: Path) -> Table:
    raise LogError(f"'{source}' is a folder. Name a log file inside it.", path=str(source))


def _dispatch(data: bytes, source: Path, sha256: str) -> Table:
    return read_delimited(data, source.name, sha256)
