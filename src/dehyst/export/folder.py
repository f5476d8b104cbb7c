"""Export folders: written whole or not at all, and verified file by file."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from dehyst.errors import OutputError, ParameterError
from dehyst.export.budget import Budget, budget
from dehyst.export.cautions import about_unit
from dehyst.export.exchange import alone, is_inside, put, repair
from dehyst.export.rendering import TEMPLATES
from dehyst.export.signal import to_csv
from dehyst.export.subject import Subject
from dehyst.export.targets import target as target_of
from dehyst.findings import Finding
from dehyst.shell import quoted, visible_text
from dehyst.version import __version__

FORMAT = "dehyst-export"
SCHEMA = 1
MANIFEST = "manifest.json"
VERIFIED = "VERIFIED.txt"
EXCERPT = "expected/excerpt.csv"
BUILDS = ("build", "target")  # what `make` and cargo leave behind
MOST_BYTES = 64 * 1024 * 1024


@dataclass(frozen=True)
class Written:
    """What was exported.

    Attributes
    ----------
    folder
        Where.
    files
        Relative paths, sorted.
    size
        Bytes of all of them.
    budget
        What the unit costs on a target.
    findings
        What is worth a warning before the unit drives a machine.
    """

    folder: Path
    files: tuple[str, ...]
    size: int
    budget: Budget
    findings: tuple[Finding, ...] = ()


def export(subject: Subject, target: str, folder: str | os.PathLike[str], overwrite: bool = False) -> Written:
    """Write a subject for a target into a folder that appears whole or not at all.

    Parameters
    ----------
    subject
        From `subject_of` or `joint_subject`.
    target
        Name of a target, a key of `TARGETS`.
    folder
        To write; an export that is there already is replaced, files beside it stay, anything else is refused.
    overwrite
        Replace an export also if its files were edited.

    Raises
    ------
    ParameterError
        If there is no such target, or it cannot hold the subject.
    OutputError
        If the folder would be lost or cannot be written.

    Examples
    --------
    >>> import tempfile, pathlib
    >>> from dehyst.export import export, subject_of
    >>> from dehyst.models import ModelCard, PrandtlIshlinskii, SignalCard
    >>> card = ModelCard(SignalCard("p", "bar", -1.0, 1.0), SignalCard("angle", "deg", -2.0, 2.0))
    >>> model = PrandtlIshlinskii([0.0, 0.5], [1.0, 1.0], card=card)
    >>> folder = pathlib.Path(tempfile.mkdtemp()) / "out"
    >>> "src/joint_1.c" in export(subject_of(model, name="joint_1"), "c", folder).files
    True
    """
    place = Path(folder)
    refuse_unfit(subject, target)
    refuse_folder(place, overwrite)
    content = contents(subject, target)
    with alone(place):
        _refuse_folder(place, overwrite)  # again: others may have written it meanwhile
        put(place, content, {*(exported_files(place) or {}), MANIFEST, VERIFIED})
    size = sum(map(len, content.values()))
    return Written(place, tuple(sorted(content)), size, budget(subject), about_unit(subject))


def refuse_unfit(subject: Subject, target: str) -> None:
    """Refuse a target that there is not, or that cannot hold the subject."""
    kind = target_of(target)
    for value, allowed, option in ((subject.what, kind.whats, "--what"), (subject.real, kind.reals, "--real")):
        if value not in allowed:
            raise ParameterError(
                f"target '{target}' has no {option} {value}; it has {', '.join(allowed)}. Choose one of these, or "
                f"another target."
            )
    if subject.retain and target != "st":
        raise ParameterError(
            f"--retain has no meaning for target '{target}': only a PLC has memory that outlives a power cycle by "
            f"itself. Leave it out, or export with --target st."
        )
    if subject.tunable and target not in ("c", "c-header"):
        raise ParameterError(
            f"target '{target}' has no --tunable: what is changed through a calibration file are variables of C. Leave "
            f"--tunable out{' (an FMU has these numbers as parameters)' * target.startswith('fmu')}, or choose "
            f"--target c or c-header."
        )


def contents(subject: Subject, target: str) -> dict[str, bytes]:
    """Return relative path -> bytes of all files of an export, the manifest included."""
    refuse_unfit(subject, target)
    files: dict[str, str | bytes] = {
        "LICENSE": (TEMPLATES / "LICENSE").read_text(encoding="utf-8"),
        "model.json": subject.model_text,
        "expected/test_signal.csv": to_csv(subject.test),
    }
    if subject.excerpt is not None:
        files[EXCERPT] = to_csv(subject.excerpt)
    for name, text in subject.extra.items():
        files[name] = text
    files |= target_of(target).load().files(subject)
    content = {name: _written(text) for name, text in files.items()}
    return {**content, MANIFEST: manifest_text(_manifest(subject, target, content)).encode("utf-8")}


def _written(text: str | bytes) -> bytes:
    """Bytes of a file; a name in its text steers no terminal and no editor."""
    return visible_text(text).encode("utf-8") if isinstance(text, str) else text


def manifest_text(facts: Mapping[str, Any]) -> str:
    """Return what stands in the manifest of an export with these facts."""
    return json.dumps(facts, indent=1, allow_nan=False) + "\n"


def _manifest(subject: Subject, target: str, content: Mapping[str, bytes]) -> dict[str, Any]:
    signals = {
        role: {"name": card.name, "unit": card.unit, "low": card.low, "high": card.high}
        for role, card in (("input", subject.input), ("output", subject.output))
    }
    return {
        "format": FORMAT,
        "schema": SCHEMA,
        "dehyst": __version__,
        "date": datetime.now(UTC).isoformat(timespec="seconds"),
        "target": target,
        "settings": dict(subject.settings),
        "title": subject.title,
        **signals,
        "operators": subject.operators,
        "period": subject.period,
        "model_sha256": subject.checksum,
        "provenance": dict(subject.provenance),
        "excerpt_source": subject.excerpt_source,
        "budget": budget(subject).as_dict(),
        "files": {name: hashlib.sha256(data).hexdigest() for name, data in sorted(content.items())},
    }


def refuse_folder(folder: Path, overwrite: bool, inputs: Iterable[Path] = ()) -> None:
    """Refuse a folder that holds anything but an export, and a place that is no folder.

    A folder that holds one of the `inputs` is refused too.
    """
    with alone(folder):
        _refuse_folder(folder, overwrite, inputs)


def _refuse_folder(folder: Path, overwrite: bool, inputs: Iterable[Path] = ()) -> None:
    try:
        place = folder.absolute().resolve()
        here = Path.cwd()
    except OSError as fault:
        raise OutputError(
            f"cannot write '{folder}': the folder you are in does not exist any more ({fault.strerror}). Go to one "
            f"that does: cd ~",
            path=str(folder),
        ) from None
    if folder.exists() and not folder.is_dir():
        raise OutputError(f"cannot write '{folder}': it is a file. Name a folder.", path=str(folder))
    if not place.parent.is_dir():
        raise OutputError(
            f"cannot write '{folder}': the folder above it does not exist. Make it first: mkdir -p "
            f"{quoted(folder.parent)}",
            path=str(folder),
        )
    repair(folder)
    if not folder.exists() or not any(folder.iterdir()):
        return
    known = exported_files(folder)
    if known is None:
        raise OutputError(
            f"'{folder}' is not empty and holds no export of dehyst; writing there would lose {_some(folder)}. Name "
            f"another folder; --overwrite replaces exports only.",
            path=str(folder),
        )
    held = [path for path in (*inputs, here / "x") if place in path.resolve().parents]
    held = [path for path in held if path != here / "x" or here.resolve() != place]
    if held:
        what = "the folder you are in" if held[0] == here / "x" else f"'{held[0]}', which is read for the export,"
        raise OutputError(
            f"cannot write '{folder}': {what} lies in it, and its files are going to be replaced. Name another folder.",
            path=str(folder),
        )
    edited = [name for name, checksum in known.items() if _checksum(folder / name) not in (checksum, "")]
    if edited and not overwrite:
        raise OutputError(
            f"'{folder}' is an export of dehyst, but {', '.join(edited[:3])}{' and more' if len(edited) > 3 else ''} "
            f"{'is' if len(edited) == 1 else 'are'} not as it was written; writing there would lose that. Name "
            f"another folder, or add --overwrite.",
            path=str(folder),
        )


def exported_files(folder: Path) -> dict[str, str] | None:
    """Return name -> sha256 of the files that belong to an export, there or not; None if it is none of ours."""
    try:
        known = read_manifest(folder)["files"]
    except OutputError:
        return None
    top = folder.resolve()
    inside = all(is_inside(name) and top in (folder / name).parent.resolve().joinpath("x").parents for name in known)
    return {name: str(checksum) for name, checksum in known.items()} if inside else None


def files_below(folder: Path) -> list[str]:
    """Return the relative paths of all files of a folder, but for those that file managers and git leave there."""
    found = []
    for path in sorted(folder.rglob("*")):
        name = path.relative_to(folder).as_posix()
        if (path.is_symlink() or not path.is_dir()) and path.name not in HIDDEN and not name.startswith(".git/"):
            found.append(name)
    return found


HIDDEN = (".DS_Store", "Thumbs.db", "desktop.ini", ".gitignore", ".gitattributes")


def _checksum(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest() if path.is_file() else ""


def _some(folder: Path) -> str:
    names = sorted(path.name for path in folder.iterdir())
    return ", ".join(f"'{name:.40}'" for name in names[:3]) + (f" and {len(names) - 3} more" if len(names) > 3 else "")


def read_manifest(folder: str | os.PathLike[str]) -> dict[str, Any]:
    """Return the manifest of an export folder.

    Raises
    ------
    OutputError
        If the folder is none, or its manifest is of another version.
    """
    return parse_manifest(read_bytes(Path(folder)), Path(folder))


def read_bytes(folder: Path) -> bytes:
    """Return the bytes of the manifest of an export folder; refuse a folder that has none."""
    path = folder / MANIFEST
    if not path.is_file():
        what = "does not exist" if not folder.exists() else f"holds no {MANIFEST}"
        raise OutputError(
            f"'{folder}' {what}, so it is no export of dehyst. Name a folder written by `dehyst export ... --out DIR`.",
            path=str(folder),
        )
    try:
        if path.stat().st_size > MOST_BYTES:
            raise OSError("it is too large")
        return path.read_bytes()
    except OSError as fault:
        raise _no_manifest(path, fault) from None


def parse_manifest(data: bytes, folder: Path) -> dict[str, Any]:
    """Return what the bytes of the manifest of `folder` say; refuse what is none."""
    try:
        manifest = json.loads(data.decode("utf-8"))
        if not isinstance(manifest, dict) or manifest.get("format") != FORMAT:
            raise ValueError(f'it lacks "format": "{FORMAT}"')
        if manifest.get("schema") != SCHEMA:
            found = f"its schema is {manifest.get('schema')!r:.20}, this dehyst, {__version__}, reads {SCHEMA}"
            raise ValueError(f"{found}; verify it with dehyst {manifest.get('dehyst')!s:.20}, which wrote it")
        if not isinstance(manifest.get("files"), dict) or not isinstance(manifest.get("settings"), dict):
            raise ValueError("it lists no files or no settings")
    except (ValueError, RecursionError) as fault:
        raise _no_manifest(folder / MANIFEST, fault) from None
    return manifest


def _no_manifest(path: Path, fault: Exception) -> OutputError:
    return OutputError(
        f"'{path}' is no manifest of an export ({fault}). Export again: dehyst export MODEL --target ... --out DIR",
        path=str(path),
    )
