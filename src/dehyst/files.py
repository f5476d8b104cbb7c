"""Files are written atomically: a reader sees the old file or the new one, never half of one."""

from __future__ import annotations

import os
import tempfile
from contextlib import suppress
from pathlib import Path

from dehyst.errors import OutputError


def write_atomically(path: str | os.PathLike[str], content: str | bytes) -> Path:
    """Write `content` to `path` by way of a temporary file in the same folder.

    Raises
    ------
    OutputError
        If the folder does not exist, is not writable, or the disk is full. An existing file stays as it was.

    Examples
    --------
    >>> import tempfile, pathlib
    >>> folder = pathlib.Path(tempfile.mkdtemp())
    >>> write_atomically(folder / "a.txt", "hello").read_text()
    'hello'
    """
    target = Path(path)
    data = content.encode("utf-8") if isinstance(content, str) else content
    try:
        if target.is_dir():
            raise OutputError(f"cannot write '{target}': it is a folder. Name a file inside it.", path=str(target))
        handle, temporary = tempfile.mkstemp(prefix=f".{target.name}.", dir=target.parent)
    except (OSError, ValueError) as fault:  # ValueError: a name with a null character
        reason = getattr(fault, "strerror", None) or fault
        raise OutputError(
            f"cannot write '{target}': {reason}. Nothing was changed. "
            f"Name a folder that exists and that you may write to.",
            path=str(target),
        ) from None
    try:
        with os.fdopen(handle, "wb") as stream:
            stream.write(data)
            stream.flush()
            os.fsync(stream.fileno())
        # mkstemp makes the file private; a result should be as readable as any other file of the user.
        mask = os.umask(0)
        os.umask(mask)
        Path(temporary).chmod(0o666 & ~mask)
        Path(temporary).replace(target)
    except OSError as fault:
        with suppress(OSError):
            Path(temporary).unlink()
        raise OutputError(
            f"cannot write '{target}': {fault.strerror}. An earlier file of that name is untouched. "
            f"Free some space or name another folder.",
            path=str(target),
        ) from None
    return target
