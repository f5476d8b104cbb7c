"""A temporary file of samples, for logs that are slow to read more than once.

The file has no name where the system allows that, so nothing is left behind whatever ends the process. It holds blocks
of signals, float64, `BLOCK` samples each; it is read with ordinary reads and not mapped, so that the memory of the
process stays what it is.
"""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Sequence
from types import TracebackType
from typing import Any, Self

import numpy as np

from dehyst.arrays import Array
from dehyst.errors import OutputError
from dehyst.files import FULL

# Samples of a block: signals of 256 kB stay in the processor's cache together.
BLOCK = 1 << 15
MARGIN = 1 << 28  # bytes that are left free for others


class Spool:
    """Blocks of signals in a temporary file.

    Parameters
    ----------
    folder
        Where the file is made; by default the system's folder for temporary files.
    signals
        How many there are.

    Raises
    ------
    OutputError
        If the folder cannot be written to.

    Examples
    --------
    >>> with Spool() as spool:
    ...     spool.write((np.arange(3.0), np.ones(3)))
    ...     spool.read(0, 3, 1)[0].tolist()
    [0.0, 1.0, 2.0]
    """

    def __init__(self, folder: str | os.PathLike[str] | None = None, signals: int = 2) -> None:
        self.folder = os.fspath(folder) if folder is not None else tempfile.gettempdir()
        self.signals = signals
        try:
            self._file: Any = tempfile.TemporaryFile(prefix="dehyst-", dir=self.folder, buffering=0)  # noqa: SIM115
        except OSError as fault:
            raise OutputError(
                f"cannot write the temporary copy of the log to '{self.folder}': {fault.strerror}. Name a folder "
                f"that exists and that you may write to (--spool-dir, or the variable TMPDIR).",
                folder=self.folder,
            ) from None

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, fault: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Give the file back."""
        self._file.close()

    def require(self, samples: float, name: str) -> None:
        """Refuse so many more samples if they would fill the disk."""
        needed, free = 8.0 * self.signals * samples, shutil.disk_usage(self.folder).free
        if needed + MARGIN > free:
            raise OutputError(
                f"{name} needs a temporary copy, because it is read several times: {_size(needed)} more, and "
                f"'{self.folder}' has {_size(free)} free. Free some space, name another folder (--spool-dir, or the "
                f"variable TMPDIR), or convert the log to NPZ or Parquet, which are read again directly.",
                folder=self.folder,
                needed=needed,
                free=free,
            )

    def write(self, signals: Sequence[Array]) -> None:
        """Append a block; only the last one may be shorter than `BLOCK`."""
        for signal in signals:
            view = np.ascontiguousarray(signal).view(np.uint8)
            while view.size:
                try:
                    view = view[self._file.write(view.data) :]
                except OSError as fault:
                    raise self._full(fault) from None

    def _full(self, fault: OSError) -> OutputError:
        cure = "Free some space, or name" if fault.errno in FULL else "Name"
        return OutputError(
            f"writing the temporary copy of the log to '{self.folder}' failed: {fault.strerror}. {cure} another "
            f"folder (--spool-dir, or the variable TMPDIR).",
            folder=self.folder,
        )

    def read(self, block: int, samples: int, signals: int) -> Array:
        """Return the first few signals of a block of so many samples, (signals, samples)."""
        values = np.empty((signals, samples))
        view = values.reshape(-1).view(np.uint8)
        self._file.seek(8 * block * BLOCK * self.signals)
        while view.size:
            count = self._file.readinto(view.data)
            if not count:
                raise OutputError(
                    f"the temporary copy of the log in '{self.folder}' became shorter while it was read. Do not clean "
                    f"that folder during a run, or name another one (--spool-dir).",
                    folder=self.folder,
                )
            view = view[count:]
        return values


def _size(count: float) -> str:
    return f"{count / 1e9:.3g} GB" if count >= 1e8 else f"{count / 1e6:.3g} MB"
