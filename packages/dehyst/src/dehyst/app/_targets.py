"""Checks where a command may write: existing files are never overwritten without a message."""

from __future__ import annotations

import hashlib
import json
import os
import tempfile
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

from dehyst.errors import OutputError
from dehyst.files import write_atomically
from dehyst.shell import quoted

# How the files begin that dehyst itself writes again and again, and what is no such file.
MODEL = '"format": "dehyst-model"'
OTHER_MODELS = ('"format": "dehyst-family"', '"format": "dehyst-coupled"')  # models too
PAGE = '<meta name="generator" content="dehyst '
SWEEP = "dehyst sweep: "
EXCITATION = "dehyst design: "
BAND = "dehyst band: "
FAMILIES = "dehyst compare: "
LOOPS = "dehyst loops: "
COUPLED = "dehyst coupled: "
SENSOR = "dehyst sensor: "
MUSCLE = '"format": "dehyst-muscle"'
MUSCLES = "dehyst muscle: "
RIGS = "dehyst rig: "
REPRODUCTION = '"format": "dehyst-reproduction"'
OTHERS = {
    MODEL: "no dehyst model",
    PAGE: "no report of dehyst",
    SWEEP: "no picture of a sweep",
    EXCITATION: "no picture of dehyst design",
    BAND: "no picture of an unknown memory",
    FAMILIES: "no picture of dehyst compare",
    LOOPS: "no picture of dehyst loops",
    COUPLED: "no picture of dehyst coupled",
    SENSOR: "no picture of dehyst sensor",
    MUSCLE: "no muscle of dehyst",
    MUSCLES: "no picture of dehyst muscle",
    RIGS: "no picture of dehyst rig",
    REPRODUCTION: "no result of dehyst reproduce",
}
PICTURES = (EXCITATION, FAMILIES, LOOPS, COUPLED, SENSOR, MUSCLES, RIGS)
MARKED = 2000  # characters at the beginning of a file, in which the mark stands


def write_new(path: Path, overwrite: bool, text: str) -> None:
    """Write a text file, unless that would lose another one."""
    refuse_existing(path, overwrite, content=text)
    write_atomically(path, text)


def refuse_existing(
    path: Path, overwrite: bool, own: str | None = None, content: str | None = None
) -> None:
    """Refuse a file that exists, unless it may be overwritten, is one of dehyst's `own`, or would stay as it is.

    `own` is the mark in the beginning of a file that a former run wrote, such as `MODEL` or `PAGE`; a file that
    holds just the `content` that is going to be written loses nothing.
    """
    if overwrite or path.is_dir() or not path.exists():  # a folder is refused by whoever writes
        return
    # Pipes, devices and empty files hold nothing that could be lost.
    if path.is_fifo() or path.is_char_device():
        return
    if path.is_file() and path.stat().st_size == 0:
        return
    # A mark at the begin of a file is enough: a large page need not be read for it.
    existing = beginning(path, MARKED)
    if own is not None and (
        own in existing or (own == MODEL and any(mark in existing for mark in OTHER_MODELS))
    ):
        return
    # A file that would stay as it is loses nothing, so that a command can be repeated.
    if content is not None and beginning(path, len(content.encode()) + 1) == content:
        return
    kind = ""
    if own is not None:
        kind = f" and is {OTHERS[own]}"
    raise OutputError(
        f"'{path}' exists already{kind}; writing there would lose it. Name another file, or add --overwrite.",
        path=str(path),
    )


def place_of(path: Path) -> object:
    """What is equal for all names of one file, hard links too; of a file that is not there yet, its full name."""
    try:
        status = path.stat()
    except OSError:
        # A file that does not exist yet has no number of its own.
        return path.resolve()
    return status.st_dev, status.st_ino


def refuse_clashes(
    sources: Iterable[Path | None], overwrite: bool, **targets: tuple[Path | None, str | None]
) -> None:
    """Refuse, before any work, outputs that cannot be written or would cost a file that is there.

    Each target is an option with its file and that file's mark, as for `refuse_existing`.
    """
    read = {place_of(path) for path in sources if path is not None}
    named: dict[object, str] = {}
    typed: dict[str, tuple[Path, str | None]] = {}
    for option, (target, mark) in targets.items():
        if target is not None:
            typed[option] = target, mark
    for option, (path, _) in typed.items():
        if place_of(path) in read:
            raise OutputError(
                f"'{path}' is the log itself, or a model that is read; writing there would lose it. Name another file."
            )
        # The place is tried now: after a long run the refusal would cost the result.
        refuse_unwritable(path)
        if place_of(path) in named:
            raise OutputError(
                f"--{named[place_of(path)]} and --{option} both name '{path}'. Name a file for each."
            )
        named[place_of(path)] = option
    for path, mark in typed.values():
        if mark in PICTURES:
            from dehyst.report import require_picture_name

            require_picture_name(path)
        refuse_existing(path, overwrite, mark)


def refuse_other_model(
    path: Path, overwrite: bool, logs: Iterable[Path], settings: Mapping[str, Any]
) -> None:
    """Refuse, before any work, to replace a model that the new one is not going to be.

    Of `settings`, those that the file does not name say nothing; what only the result can tell, `save_model` asks.

    Raises
    ------
    OutputError
        If the model in the file is of other logs or has other settings. What only the result can tell, `save_model`
        asks.
    """
    if overwrite or not path.is_file() or path.stat().st_size == 0:
        return
    existing = _said(path)
    if existing is None:
        return
    provenance = existing["provenance"]
    # A setting may stand in the model, its provenance or the settings, whichever the family writes.
    had = {**existing, **provenance, **provenance.get("settings", {})}
    earlier_logs = provenance.get("logs", [provenance])
    old = {log.get("sha256") for log in earlier_logs}
    # Of input and output in two files the second has its own.
    old |= {log["output_sha256"] for log in earlier_logs if "output_sha256" in log}
    for name, value in settings.items():
        if had.get(name, value) != value:
            raise _other_model(path, f"of {name} {had[name]}, where this one is of {value}")
    for log in logs:
        # A model that was made in Python has no checksum of a log, and nothing is known of what it is.
        if log.is_file() and None not in old:
            with log.open("rb") as stream:
                if hashlib.file_digest(stream, "sha256").hexdigest() not in old:
                    raise _other_model(path, f"that is not of '{log.name}' as it is now")


def _other_model(path: Path, reason: str = "") -> OutputError:
    return OutputError(
        f"'{path}' exists already and holds another model{reason and ', one '}{reason}; saving this one there would "
        f"lose it. Name another file, or add --overwrite.",
        path=str(path),
    )


def save_model_file(path: Path, overwrite: bool, save: Callable[[Path], object]) -> None:
    """Save a model; one that is there already is replaced if the user said so, or if only its date differs."""
    if overwrite or not path.is_file() or path.stat().st_size == 0:
        save(path)
        return
    # The new model is written beside it, and only what both say decides.
    with tempfile.TemporaryDirectory(prefix="dehyst-") as place:
        new = Path(place) / path.name
        save(new)
        same = _undated(new) == _undated(path)
    if same:
        save(path)
        return
    raise _other_model(path)


def _undated(path: Path) -> object:
    """What a model file says, but for when it was made and the checksum over that."""
    content = _said(path)
    if content is None:
        return None
    provenance = {key: value for key, value in content["provenance"].items() if key != "date"}
    return {**content, "provenance": provenance, "sha256": ""}


def _said(path: Path) -> dict[str, Any] | None:
    """What a model file says; None if it is damaged, and so like no other."""
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        provenance = content["provenance"]
        tables = [content, provenance, provenance.get("settings", {}), *provenance.get("logs", [])]
        return content if all(isinstance(table, dict) for table in tables) else None
    except (OSError, ValueError, RecursionError, KeyError, TypeError, AttributeError):
        return None


def refuse_unwritable(path: Path, folder: bool = False) -> None:
    """Refuse a place where nothing can be written, before a long run and not after it.

    Of a folder those above it are made too; the folder of a file must exist.
    """
    if not folder and path.is_dir():
        raise OutputError(
            f"cannot write '{path}': it is a folder. Name a file inside it.", path=str(path)
        )
    if path.exists() and not folder:
        if not os.access(path, os.W_OK):
            raise OutputError(
                f"cannot write '{path}': it is protected against writing. Name another file, or: chmod u+w",
                path=str(path),
            )
        if not path.is_file():  # a device or a pipe, which is written to as it is
            return
    place = path if folder else Path(os.path.realpath(path)).parent
    # Folders that are missing are made later, so that the first one that exists decides.
    while folder and not place.exists() and place != place.parent:
        place = place.parent
    if not place.exists():
        raise OutputError(
            f"cannot write '{path}': there is no folder '{place}'. Make it first: mkdir -p {quoted(place)}",
            path=str(path),
        )
    if not place.is_dir():
        raise OutputError(
            f"cannot write to '{path}': '{place}' is a file. Name another folder.", path=str(path)
        )
    if not os.access(place, os.W_OK):
        raise OutputError(
            f"cannot write to '{path}': '{place}' may not be written to.", path=str(path)
        )


def beginning(path: Path, size: int) -> str:
    """Return the first bytes of a file as text; "" of a pipe, and of what cannot be read."""
    try:
        if not path.is_file():  # a pipe would block the reader
            return ""
        with path.open("rb") as stream:
            return stream.read(size).decode("utf-8", errors="replace")
    except OSError:
        return ""
