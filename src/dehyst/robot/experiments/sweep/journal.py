"""Journal of a sweep: one JSON line per finished run, so that a stopped sweep can be resumed.

The first line says for which sweep it is: a fingerprint of the file's contents, of the robot's parameters and of the
program's version. A last line that a power cut tore is dropped and its run is done again.
"""

from __future__ import annotations

import hashlib
import json
import math
import os
import time
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import asdict, dataclass, field, fields
from pathlib import Path
from types import TracebackType
from typing import Any, BinaryIO

from dehyst.errors import OutputError
from dehyst.robot.experiments.sweep.spec import SweepSpec

FORMAT = "dehyst-sweep-journal"
BEGINNING = f'{{"format": "{FORMAT}"'.encode()
SYNC_SECONDS = 1.0  # a power cut loses what was finished in this time; a kill of the process loses nothing


@dataclass(frozen=True)
class Outcome:
    """What one run gave.

    Attributes
    ----------
    figures
        Name -> number; empty if it failed.
    error
        Why it failed, or "".
    """

    figures: Mapping[str, float] = field(default_factory=dict)
    error: str = ""


def journal_path(out: Path) -> Path:
    """Return where the journal of a table lies: beside it.

    Examples
    --------
    >>> journal_path(Path("sweep.csv")).name
    'sweep.csv.journal'
    """
    return out.with_name(out.name + ".journal")


def fingerprint(spec: SweepSpec, version: str, evaluator: str) -> str:
    """Return what a journal is valid for, as a short text."""
    said = {each.name: getattr(spec, each.name) for each in fields(spec) if each.name not in ("keys", "studies")}
    said["studies"] = [asdict(study) for study in spec.studies]
    told = json.dumps([said, version, evaluator, spec.keys.robot.fingerprint], sort_keys=True)
    return hashlib.sha256(told.encode()).hexdigest()[:24]


class Journal:
    """An open journal: what is done already (``done``: key of a run -> its outcome), and a place for what gets done.

    Parameters
    ----------
    path
        File; made if there is none.
    mark
        `fingerprint` of the sweep.
    restart
        Forget what is in it.
    retry
        Forget the runs that failed.

    Raises
    ------
    OutputError
        If it belongs to another sweep, another process writes to it, or it cannot be written.
    """

    def __init__(self, path: Path, mark: str, restart: bool = False, retry: bool = False) -> None:
        self.path = path
        self.done: dict[str, Outcome] = {}
        self._synced = time.monotonic()
        self._stream = self._open()
        try:
            _lock(self._stream, path)
            self._load(mark, restart)
            if retry:
                self.done = {key: outcome for key, outcome in self.done.items() if not outcome.error}
        except BaseException:
            self._stream.close()
            raise

    def _open(self) -> BinaryIO:
        try:
            return os.fdopen(os.open(self.path, os.O_RDWR | os.O_CREAT | getattr(os, "O_BINARY", 0), 0o666), "r+b")
        except (OSError, ValueError) as fault:
            raise OutputError(
                f"cannot write '{self.path}', the journal beside the table: "
                f"{getattr(fault, 'strerror', None) or fault}. Nothing was run. "
                f"Name a table in a folder that exists and that you may write to.",
                path=str(self.path),
            ) from None

    def _load(self, mark: str, restart: bool) -> None:
        self._stream.seek(0)
        data = self._stream.read()
        end = data.rfind(b"\n") + 1  # what follows the last line's end was torn
        lines = data[:end].split(b"\n")[:-1]
        head = _parse(lines[0]) if lines else {}
        torn = not lines and BEGINNING.startswith(data[: len(BEGINNING)])
        if head.get("format") != FORMAT and not torn:
            raise OutputError(_no_journal(self.path), path=str(self.path))
        if torn or restart:
            self._stream.seek(0)
            self._stream.truncate()
            self._write({"format": FORMAT, "fingerprint": mark})
            self.sync()
            return
        if head.get("fingerprint") != mark:
            raise OutputError(
                f"'{self.path}' holds {len(lines) - 1} finished runs of another sweep: since then the sweep file, the "
                f"robot's parameters or the version of dehyst changed, and a table of both would be wrong. Add "
                f"--restart to drop them and begin anew, or name another table with --out.",
                path=str(self.path),
                runs=len(lines) - 1,
            )
        for line in lines[1:]:
            entry = _parse(line)
            if _is_outcome(entry):
                self.done[entry["key"]] = Outcome(entry["figures"], entry["error"])
        self._stream.truncate(end)
        self._stream.seek(end)

    def add(self, key: str, outcome: Outcome) -> None:
        """Write one finished run; it is on its way to the disk when this returns, and there within a second."""
        self.done[key] = outcome
        self._write({"key": key, "figures": dict(outcome.figures), "error": outcome.error})
        if time.monotonic() - self._synced > SYNC_SECONDS:
            self.sync()

    def _write(self, entry: Mapping[str, Any]) -> None:
        try:
            self._stream.write(json.dumps(entry).encode() + b"\n")
            self._stream.flush()
        except OSError as fault:
            raise OutputError(
                f"cannot write '{self.path}': {fault.strerror}. {len(self.done)} finished runs are kept in it. Free "
                f"some space and start the same line again.",
                path=str(self.path),
            ) from None

    def sync(self) -> None:
        """Wait until everything is on the disk."""
        with suppress(OSError):  # a pipe or a network folder that cannot
            os.fsync(self._stream.fileno())
        self._synced = time.monotonic()

    def remove(self) -> None:
        """Delete the file: the table has everything."""
        with suppress(OSError):
            self.path.unlink()

    def __enter__(self) -> Journal:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, fault: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.sync()
        self._stream.close()


def _parse(line: bytes) -> dict[str, Any]:
    """One entry; an empty one for a damaged line, whose run is then done again."""
    try:
        entry = json.loads(line)
    except (ValueError, RecursionError):
        return {}
    return entry if isinstance(entry, dict) else {}


def _is_outcome(entry: Mapping[str, Any]) -> bool:
    """Whether an entry holds what `Journal.add` writes; the run of any other is done again."""
    figures = entry.get("figures")
    return (
        isinstance(entry.get("key"), str)
        and isinstance(entry.get("error"), str)
        and isinstance(figures, dict)
        and all(isinstance(value, float) and not math.isinf(value) for value in figures.values())
    )


def _no_journal(path: Path) -> str:
    return (
        f"'{path}' is no journal of a sweep, but the journal of this table would have that name. Move it away, or name "
        f"another table with --out."
    )


def _lock(stream: BinaryIO, path: Path) -> None:
    """Refuse a journal that another process writes to; the lock goes with the process, however it ends."""
    try:
        import fcntl
    except ImportError:  # not on this system: two sweeps into one table are then the user's to avoid
        return
    try:
        fcntl.flock(stream, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise OutputError(
            f"another process runs the sweep of '{path}' now. Wait for its end or stop it, or name another table with "
            f"--out.",
            path=str(path),
        ) from None
    except OSError:  # a network folder without locks
        return
