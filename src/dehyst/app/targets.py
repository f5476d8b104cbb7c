"""Files to write: what a user has is never overwritten silently."""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Callable
from pathlib import Path

from dehyst.errors import OutputError

# How the files begin that dehyst itself writes again and again; enough of a file is read to see it.
MODEL = '"format": "dehyst-model"'
FAMILY_MODEL = '"format": "dehyst-family"'
PAGE = '<meta name="generator" content="dehyst '
SWEEP = "dehyst sweep: "
EXCITATION = "dehyst design: "
BAND = "dehyst band: "
FAMILIES = "dehyst compare: "
MUSCLE = '"format": "dehyst-muscle"'
MUSCLES = "dehyst muscle: "
REPRODUCTION = '"format": "dehyst-reproduction"'
_BEGINNING = 2000


def refuse_existing(path: Path, overwrite: bool, own: str | None = None, content: str | None = None) -> None:
    """Refuse a file that exists, unless it may be overwritten, is one of dehyst's `own`, or would stay as it is.

    Parameters
    ----------
    path
        File to be written.
    overwrite
        Whether the user said ``--overwrite``.
    own
        Mark in the beginning of a file that a former run wrote, `MODEL`, `PAGE`, `SWEEP` or `EXCITATION`; None if
        nothing tells.
    content
        What is going to be written; a file that holds just that loses nothing.

    Raises
    ------
    OutputError
        If the file would be lost.
    """
    if overwrite or path.is_dir() or not path.exists():  # a folder is refused by whoever writes
        return
    if path.is_fifo() or path.is_char_device() or (path.is_file() and path.stat().st_size == 0):  # nothing to lose
        return
    beginning = _beginning(path, _BEGINNING)
    if own is not None and (own in beginning or (own == MODEL and FAMILY_MODEL in beginning)):
        return
    if content is not None and _beginning(path, len(content.encode()) + 1) == content:
        return
    kinds = {
        MODEL: "no dehyst model",
        PAGE: "no report of dehyst",
        SWEEP: "no picture of a sweep",
        EXCITATION: "no picture of dehyst design",
        BAND: "no picture of an unknown memory",
        FAMILIES: "no picture of dehyst compare",
        MUSCLE: "no muscle of dehyst",
        MUSCLES: "no picture of dehyst muscle",
        REPRODUCTION: "no result of dehyst reproduce",
    }
    kind = "" if own is None else f" and is {kinds[own]}"
    raise OutputError(
        f"'{path}' exists already{kind}; writing there would lose it. Name another file, or add --overwrite.",
        path=str(path),
    )


def save_model(path: Path, overwrite: bool, save: Callable[[Path], object]) -> None:
    """Save a model; one that is there already is replaced if the user said so, or if only its date differs.

    Parameters
    ----------
    path
        File to be written; `refuse_existing` has refused what is no model.
    overwrite
        Whether the user said ``--overwrite``.
    save
        Writes the model to the path that it is given.

    Raises
    ------
    OutputError
        If another model would be lost, or the file cannot be written.
    """
    if overwrite or not path.is_file() or path.stat().st_size == 0:
        save(path)
        return
    with tempfile.TemporaryDirectory(prefix="dehyst-") as place:
        new = Path(place) / path.name
        save(new)
        same = _undated(new) == _undated(path)
    if same:
        save(path)
        return
    raise OutputError(
        f"'{path}' exists already and holds another model; saving this one there would lose it. Name another file, or "
        f"add --overwrite.",
        path=str(path),
    )


def _undated(path: Path) -> object:
    """What a model file says, but for when it was made and the checksum over that."""
    try:
        said = json.loads(path.read_text(encoding="utf-8"))
        provenance = {key: value for key, value in said["provenance"].items() if key != "date"}
        return {**said, "provenance": provenance, "sha256": ""}
    except (OSError, ValueError, RecursionError, KeyError, TypeError, AttributeError):
        return None  # damaged: like no other


def refuse_unwritable(path: Path, folder: bool = False) -> None:
    """Refuse a place where nothing can be written, before a long run and not after it.

    Parameters
    ----------
    path
        File to be written, or folder to be made.
    folder
        Whether it is a folder: then those above it are made too. The folder of a file must exist.

    Raises
    ------
    OutputError
        If there is a file where a folder is needed or the other way round, or the folder may not be written to.
    """
    if not folder and path.is_dir():
        raise OutputError(f"cannot write '{path}': it is a folder. Name a file inside it.", path=str(path))
    if path.exists() and not folder:
        if not os.access(path, os.W_OK):
            raise OutputError(
                f"cannot write '{path}': it is protected against writing. Name another file, or: chmod u+w",
                path=str(path),
            )
        if not path.is_file():  # a device or a pipe, which is written to as it is
            return
    place = path if folder else Path(os.path.realpath(path)).parent
    while folder and not place.exists() and place != place.parent:
        place = place.parent
    if not place.exists():
        raise OutputError(f"cannot write '{path}': there is no folder '{place}'. Make it first.", path=str(path))
    if not place.is_dir():
        raise OutputError(f"cannot write to '{path}': '{place}' is a file. Name another folder.", path=str(path))
    if not os.access(place, os.W_OK):
        raise OutputError(f"cannot write to '{path}': '{place}' may not be written to.", path=str(path))


def _beginning(path: Path, size: int) -> str:
    try:
        if not path.is_file():  # a pipe would block the reader
            return ""
        with path.open("rb") as stream:
            return stream.read(size).decode("utf-8", errors="replace")
    except OSError:
        return ""
