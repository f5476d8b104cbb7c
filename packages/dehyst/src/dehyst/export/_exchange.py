"""Replaces a folder atomically: after an interruption the old folder or the new one is complete.

The new files are written beside the folder and the two are exchanged in one step, where the system has one. Where it
has none, or the folder cannot be moved (one stands in it, it is a mount, nothing may be made beside it), the new files
are written inside it first, and then take their places one by one; a call that finds this half done finishes it.
"""

from __future__ import annotations

import ctypes
import json
import os
import shutil
import tempfile
from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path

from dehyst.errors import OutputError
from dehyst.files import cure

COMING = ".dehyst-coming"  # inside the folder: the new files while they are written; before they are whole
WHOLE = ".dehyst-whole"  # and when they are: what is half done is finished from here
GONE = "gone.json"  # in it: names of files that go with the old export
NEW = "new"
HERE, EXCHANGE = -100, 2  # AT_FDCWD, RENAME_EXCHANGE of Linux


@contextmanager
def alone(folder: Path) -> Iterator[None]:
    """Wait until nobody else writes an export into the folder that this one lies in, and keep others waiting.

    The folder above is locked, which leaves no file behind and ends with the process. Where the system or the file
    system has no locks, nobody waits.
    """
    above = _locked(folder)
    try:
        yield
    finally:
        if above is not None:
            os.close(above)


def put(folder: Path, content: Mapping[str, bytes], old: Collection[str]) -> None:
    """Write files into a folder in place of old ones, `alone`; other files there stay.

    Parameters
    ----------
    folder
        May be there or not; the one above it is there.
    content
        Relative name -> bytes of each file.
    old
        Relative names of what is to go, there or not.

    Raises
    ------
    OutputError
        If it cannot be written, or a file that stays has a name of a new one; what was there is untouched.
    """
    try:
        if not folder.exists():
            with _beside(folder) as beside:
                _fill(Path(beside) / NEW, content)
                (Path(beside) / NEW).replace(folder)
            return
        _refuse_others(folder, content, old)
        if not _exchanged(folder, content, old):
            _replaced_inside(folder, content, old)
    except OSError as fault:
        if (folder / WHOLE).is_dir():
            repair(folder)
            return
        raise OutputError(
            f"cannot write '{folder}': {fault.strerror or fault}. What was there is untouched. {cure(fault)}",
            path=str(folder),
        ) from None


def repair(folder: Path) -> None:
    """Finish what an interrupted call left in a folder or beside it, `alone`; nothing to do is the rule."""
    try:
        if (folder / WHOLE).is_dir():
            _finish(folder)
        if (folder / COMING).is_dir():
            shutil.rmtree(folder / COMING)
        for left in folder.absolute().parent.glob(_prefix(folder) + 8 * "?"):
            shutil.rmtree(left, ignore_errors=True)  # another user's stays
    except (OSError, ValueError) as fault:
        raise OutputError(
            f"'{folder}' was left half written when an earlier export was interrupted, and cannot be repaired "
            f"({getattr(fault, 'strerror', None) or fault}): the new files are in '{folder / WHOLE}'. Allow writing in "
            f"it and repeat.",
            path=str(folder),
        ) from None


def is_inside(name: str) -> bool:
    """Whether the name of a file in a manifest is relative and stays in its folder.

    Examples
    --------
    >>> is_inside("src/pi.c"), is_inside("../x"), is_inside("/etc/x"), is_inside("")
    (True, False, False, False)
    """
    if not {"", ".", ".."}.isdisjoint(name.split("/")):
        return False
    # Backslash and colon lead elsewhere on Windows; no system takes a zero byte.
    return set("\\:\0").isdisjoint(name)


def _locked(folder: Path) -> int | None:
    """Lock the folder above; its number as an open file, None where there are no locks."""
    try:
        import fcntl

        above = os.open(Path(os.path.realpath(folder)).parent, os.O_RDONLY)
    except (ImportError, OSError):
        return None
    try:
        fcntl.flock(above, fcntl.LOCK_EX)
        return above
    except OSError:
        os.close(above)
        return None
    except KeyboardInterrupt:
        os.close(above)
        raise


def _prefix(folder: Path) -> str:
    return f".dehyst-{folder.absolute().name}-"


def _beside(folder: Path) -> tempfile.TemporaryDirectory[str]:
    return tempfile.TemporaryDirectory(prefix=_prefix(folder), dir=folder.absolute().parent)


def _make_way(path: Path) -> Path:
    """Make the folders above a file that is going to be written."""
    path.parent.mkdir(parents=True, exist_ok=True)
    return path


def _fill(place: Path, content: Mapping[str, bytes]) -> None:
    """Write all files, and wait until they are on the disk."""
    for name, data in content.items():
        with _make_way(place / name).open("xb") as stream:
            stream.write(data)
            stream.flush()
            os.fsync(stream.fileno())


def _refuse_others(folder: Path, content: Collection[str], old: Collection[str]) -> None:
    """Refuse if a file of the user has a name that the new export needs."""
    in_the_way = []
    for name in sorted(content):
        if name not in old and (folder / name).exists():
            in_the_way.append(name)
    if not in_the_way:
        return
    verb, files, them = "are", "files", "them"
    if len(in_the_way) == 1:
        verb, files, them = "is", "a file", "it"
    raise OutputError(
        f"cannot write '{folder}': {', '.join(in_the_way[:3])} there {verb} not of the export, and the new one has "
        f"{files} of that name. Move {them} away, or name another folder.",
        path=str(folder),
    )


def _exchanged(folder: Path, content: Mapping[str, bytes], old: Collection[str]) -> bool:
    """Make the folder anew beside it and exchange the two; False if that cannot be done here."""
    if folder.is_symlink() or folder.resolve() == Path.cwd().resolve():
        return False
    with suppress(OSError), _beside(folder) as beside:
        new = Path(beside) / NEW

        def going(place: str, names: list[str]) -> set[str]:
            here = Path(place).relative_to(folder)
            return {name for name in names if (here / name).as_posix() in old}

        # What stays is linked, not copied: it is the same file in both, and remains when the old folder goes.
        shutil.copytree(folder, new, symlinks=True, ignore=going, copy_function=os.link)
        _remove_empty(new, old)
        _fill(new, content)
        was = folder.stat()
        if (was.st_uid, was.st_gid) != (new.stat().st_uid, new.stat().st_gid):
            os.chown(new, was.st_uid, was.st_gid)
        _exchange(new, folder)
        _rescue(new, folder, {*old, *content})
        return True
    return False


def _exchange(first: Path, second: Path) -> None:
    """Let two names change places in one step."""
    call = None
    if os.name == "posix":
        call = getattr(ctypes.CDLL(None, use_errno=True), "renameat2", None)
    if call is None:
        raise OSError("no exchange in one step on this system")
    if call(HERE, os.fsencode(first), HERE, os.fsencode(second), EXCHANGE) != 0:
        raise OSError(ctypes.get_errno(), os.strerror(ctypes.get_errno()))


def _rescue(old: Path, new: Path, exported: Collection[str]) -> None:
    """Carry over what was made or saved anew in the old folder while the new one was being written."""
    for path in sorted(old.rglob("*")):
        name = path.relative_to(old)
        if name.as_posix() in exported or (path.is_dir() and not path.is_symlink()):
            continue
        goal = new / name
        if not (goal.exists() and goal.samefile(path)) and not path.is_symlink():
            path.replace(_make_way(goal))


def _replaced_inside(folder: Path, content: Mapping[str, bytes], old: Collection[str]) -> None:
    """Write the new files whole inside the folder; then let each take its place."""
    try:
        _fill(folder / COMING / NEW, content)
        _fill(folder / COMING, {GONE: json.dumps(sorted({*old} - {*content})).encode()})
        for name in content:  # what could fail is done while nothing is changed
            _make_way(folder / name)
        (folder / COMING).replace(folder / WHOLE)
        _finish(folder)
    finally:
        if (folder / WHOLE).is_dir():  # Ctrl-C came meanwhile
            _finish(folder)
        shutil.rmtree(folder / COMING, ignore_errors=True)
        _remove_empty(folder, content)


def _finish(folder: Path) -> None:
    """Move what is left of the new files to their places, take the old ones away; may be repeated at any point."""
    whole = folder / WHOLE
    gone = json.loads((whole / GONE).read_text(encoding="utf-8"))
    new = []
    for path in sorted((whole / NEW).rglob("*")):
        if path.is_file():
            new.append(path.relative_to(whole / NEW).as_posix())
    top = folder.resolve()
    # A folder that came from elsewhere may name any file of this computer.
    for name in (*gone, *new):
        if not is_inside(name) or not (folder / name).parent.resolve().is_relative_to(top):
            raise ValueError(f"'{name:.80}' would lie outside of it")
    for name in new:
        (whole / NEW / name).replace(_make_way(folder / name))
    for name in gone:
        with suppress(FileNotFoundError, NotADirectoryError):
            (folder / name).unlink()
    _remove_empty(folder, gone)
    whole.replace(folder / COMING)  # from here on there is nothing to finish
    shutil.rmtree(folder / COMING)


def _remove_empty(folder: Path, names: Collection[str]) -> None:
    """Remove the folders of these files where nothing is left in them."""
    places = set()
    for name in names:
        for above in (folder / name).parents:
            if folder in above.parents:
                places.add(above)
    # The deepest comes first: its removal may empty the one above.
    for place in sorted(places, key=lambda p: -len(p.parts)):
        with suppress(OSError):  # not empty: it holds files of the new export, or the user's
            place.rmdir()
