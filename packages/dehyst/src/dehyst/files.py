"""Writes files atomically: a crash leaves the old file or the new one, never half of one. Reads small files."""

from __future__ import annotations

import errno
import json
import os
import stat
import tempfile
import tomllib
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

from dehyst.errors import DehystError, OutputError
from dehyst.shell import quoted

Refusal = Callable[
    [str], DehystError
]  # what is wrong with a file, "is no TOML (...)" -> the error with its cure

GZIP = b"\x1f\x8b"  # first bytes
FULL = (
    errno.ENOSPC,
    errno.EDQUOT,
    errno.EFBIG,
)  # the disk, the user's share of it, the largest file allowed


def write_atomically(path: str | os.PathLike[str], content: str | bytes) -> Path:
    """Write `content` to `path` by way of a temporary file in the same folder.

    A file that is replaced gives its mode and its owner to the new one. A symbolic link stays and its target is
    written; into a pipe or a character device (``/dev/stdout``) the content is written as it is.

    Raises
    ------
    OutputError
        If the folder does not exist, the file or the folder may not be written to, it is a disk or a socket, or the
        disk is full. An existing file stays as it was.

    Examples
    --------
    >>> import tempfile, pathlib
    >>> folder = pathlib.Path(tempfile.mkdtemp())
    >>> write_atomically(folder / "a.txt", "hello").read_text()
    'hello'
    """
    requested = Path(path)
    if isinstance(content, str):
        content = content.encode("utf-8")
    data: bytes = content
    try:
        status = _there(requested)
        if status is not None and not stat.S_ISREG(status.st_mode):
            _write_through(requested, status, data)
            return requested
        target = Path(os.path.realpath(requested))  # a link stays, and what it points to is written
        handle, temporary = tempfile.mkstemp(prefix=f".{target.name}.", dir=target.parent)
    except (OSError, ValueError) as fault:  # ValueError: a name with a null character
        raise _refused(requested, fault) from None
    try:
        with os.fdopen(handle, "wb") as stream:
            _take_over(temporary, status)
            stream.write(data)
            stream.flush()
            os.fsync(stream.fileno())
        Path(temporary).replace(target)
    except OSError as fault:
        raise _refused(requested, fault) from None
    finally:  # gone if it took the place of the file; a stop with Ctrl-C leaves nothing behind either
        with suppress(OSError):
            Path(temporary).unlink()
    return requested


def _there(path: Path) -> os.stat_result | None:
    """Return what is at a path, at the end of its links; refuse a file that is protected against writing."""
    try:
        status = path.stat()
    except FileNotFoundError:
        return None
    if stat.S_ISREG(status.st_mode) and not os.access(path, os.W_OK):
        raise OSError(errno.EACCES, "it is protected against writing")
    return status


def _write_through(path: Path, status: os.stat_result, data: bytes) -> None:
    """Write into a pipe or a character device, which stays what it is; nothing else is taken for a file."""
    if stat.S_ISDIR(status.st_mode):
        raise IsADirectoryError(errno.EISDIR, "it is a folder. Name a file inside it")
    if not stat.S_ISFIFO(status.st_mode) and not stat.S_ISCHR(status.st_mode):
        raise OSError(errno.EINVAL, "it is a disk or a socket, no file")
    with path.open("wb", buffering=0) as stream:
        left = memoryview(data)
        while left:
            left = left[stream.write(left) :]


def _take_over(temporary: str, status: os.stat_result | None) -> None:
    """Give a new file the mode and the owner of the one it replaces, or the mode that any new file of the user gets.

    An owner that only the administrator may give stays behind; then nobody of the old group gets in by the mode.
    """
    if status is None:
        mask = os.umask(0)
        os.umask(mask)
        Path(temporary).chmod(0o666 & ~mask)
        return
    mode = stat.S_IMODE(status.st_mode)
    now = Path(temporary).stat()
    if (now.st_uid, now.st_gid) != (status.st_uid, status.st_gid):
        try:
            os.chown(temporary, status.st_uid, status.st_gid)
        except OSError:
            mode &= 0o707
    Path(temporary).chmod(mode)


def _refused(path: Path, fault: Exception) -> OutputError:
    reason = getattr(fault, "strerror", None) or fault
    return OutputError(
        f"cannot write '{path}': {reason}. What was there is untouched. {cure(fault)}",
        path=str(path),
    )


def cure(fault: Exception) -> str:
    """What to do about a file that cannot be written.

    Examples
    --------
    >>> cure(OSError(errno.ENOSPC, "No space left on device"))
    'Free some space or name another folder.'
    """
    if getattr(fault, "errno", None) in FULL:
        return "Free some space or name another folder."
    return "Name a folder that exists and that you may write to."


def text_of(path: str | os.PathLike[str], refused: Refusal, most: int = 1 << 20) -> str:
    """Return the text of a small file; refuse what is no regular file, has more than `most` bytes or is no text.

    Examples
    --------
    >>> text_of("nowhere.toml", lambda what: OutputError(f"the file {what}"))
    Traceback (most recent call last):
    dehyst.errors.OutputError: the file does not exist
    """
    try:
        source = Path(path)
        # A pipe or a device is not opened: it would block the reader.
        if not source.exists():
            trouble = "does not exist"
        elif source.is_dir():
            trouble = "is a folder"
        elif not source.is_file():
            trouble = "is no regular file"
        else:
            with source.open("rb") as stream:
                data = stream.read(most + 1)
            if data.startswith(GZIP):
                trouble = f"is packed with gzip (to unpack it: gzip -dk {quoted(source.name)})"
            elif len(data) <= most:
                return data.decode("utf-8")
            else:
                trouble = f"is larger than {most} bytes"
    except OSError as fault:
        trouble = f"cannot be read ({fault.strerror})"
    except ValueError as fault:
        trouble = f"cannot be read as UTF-8 text ({fault})"
    raise refused(trouble)


def document_of(text: str, refused: Refusal, language: str = "JSON") -> Any:
    """Return what a text of JSON or TOML holds; refuse any other, and one that names a key twice.

    Examples
    --------
    >>> document_of("a = [1, 2]", lambda what: OutputError(what), "TOML")
    {'a': [1, 2]}
    """
    try:
        if language == "TOML":
            return tomllib.loads(text)
        return json.loads(text, parse_constant=_no_constant, object_pairs_hook=_no_repetition)
    except (ValueError, RecursionError) as fault:
        raise refused(f"is not {language} ({' '.join(str(fault).split())[:160]})") from None


def _no_constant(name: str) -> float:
    raise ValueError(f"{name} is not a JSON number")


def _no_repetition(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    content: dict[str, Any] = {}
    for name, value in pairs:
        if name in content:
            raise ValueError(f"the key '{name:.60}' stands twice in one object")
        content[name] = value
    return content
