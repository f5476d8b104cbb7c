"""Sources of long logs, progress messages, and a temporary copy of a log that is slow to read.

The temporary file has no name where the system allows that, so nothing is left behind whatever ends the process. It
holds blocks of signals, float64, `BLOCK` samples each; it is read with ordinary reads and not mapped, so that the
memory of the process stays what it is.
"""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from types import TracebackType
from typing import Any, Protocol, Self, runtime_checkable

import numpy as np

from dehyst.arrays import Array
from dehyst.errors import OutputError
from dehyst.files import FULL

Chunk = tuple[Array | None, Array, Array]


@runtime_checkable
class Source(Protocol):
    """A log that is read in chunks, again and again.

    Iteration starts at the first sample each time and gives ``(time, x, y)``, float64, (K,) each; time [s] is None for
    a log without one. `dehyst.open_chunks` makes one from a file. Further attributes are used where they are there:
    ``name``, ``input_name``, ``output_name``, ``input_unit``, ``output_unit``, ``findings``, ``provenance``; ``size``
    and ``consumed``, the bytes of a pass and those read of it so far; ``costly``, whether another pass takes much
    longer than reading numbers would.
    """

    def __iter__(self) -> Iterator[Chunk]:
        """Chunks from the first sample on."""
        ...


# Stages of a streamed identification, in order. The first one reads the log; each of the others goes through the
# samples again, through those that are fitted or through all.
STAGES = ("reading", "looking", "choosing", "summing", "refining", "comparing", "scoring")


@dataclass(frozen=True, slots=True)
class Progress:
    """How far an identification has come.

    Attributes
    ----------
    stage
        What is being done, one of "reading", "looking" (turning points), "choosing" (family and start), "summing"
        (normal equations), "refining", "comparing" (the curve without hysteresis), "scoring".
    number, of
        Which stage it is, from 1 on, and how many there are.
    done, total
        Bytes of the log in this stage, or samples where the log does not tell bytes; total is 0 where it is unknown.

    Examples
    --------
    >>> now = Progress("summing", 4, 7, 5e8, 1e9)
    >>> f"{now.stage}, step {now.number} of {now.of}: {now.done / now.total:.0%}"
    'summing, step 4 of 7: 50%'
    """

    stage: str
    number: int
    of: int
    done: float
    total: float


class Watch:
    """Calls back with the progress of the present stage."""

    def __init__(self, progress: Callable[[Progress], object] | None) -> None:
        self._progress, self._stage = progress, STAGES[0]
        self._bytes = 0.0

    def begin(self, stage: str) -> None:
        """Enter a stage."""
        self._stage = stage
        self._tell(0.0, self._bytes)

    def read(self, samples: int, consumed: float, size: float) -> None:
        """Tell of the first pass."""
        self._bytes = size
        self._tell(consumed if size else float(samples), size)

    def advance(self, samples: int, of: int) -> None:
        """Tell of a later pass."""
        total = self._bytes or float(of)
        self._tell(total * samples / of, total)

    def _tell(self, done: float, total: float) -> None:
        if self._progress is not None:
            self._progress(Progress(self._stage, STAGES.index(self._stage) + 1, len(STAGES), done, total))


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
