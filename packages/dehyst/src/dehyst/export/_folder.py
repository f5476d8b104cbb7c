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
from dehyst.export._budget import Budget, budget
from dehyst.export._cautions import about_unit
from dehyst.export._exchange import alone, is_inside, put, repair
from dehyst.export._folders import TEMPLATES
from dehyst.export._signal import to_csv
from dehyst.export._subject import Subject
from dehyst.export._targets import target as target_of
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


def export(
    subject: Subject, target: str, folder: str | os.PathLike[str], overwrite: bool = False
) -> Written:
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
    for value, allowed, option in (
        (subject.what, kind.whats, "--what"),
        (subject.real, kind.reals, "--real"),
    ):
        if value not in allowed:
            raise ParameterError(
                f"target '{target}' has no {option} {value}; it has {', '.join(allowed)}. Choose one of these, or "
                f"another target."
            )
    if subject.retain and not kind.retains:
        raise ParameterError(
            f"--retain has no meaning for target '{target}': only a PLC has memory that outlives a power cycle by "
            f"itself. Leave it out, or export with --target st."
        )
    if subject.tunable and not kind.tunable:
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
    content = {name: _encoded(text) for name, text in files.items()}
    return {**content, MANIFEST: manifest_text(_manifest(subject, target, content)).encode("utf-8")}


def _encoded(text: str | bytes) -> bytes:
    """Return the bytes of a file; a name in its text steers no terminal and no editor."""
    if isinstance(text, bytes):
        return text
    return visible_text(text).encode("utf-8")


def manifest_text(facts: Mapping[str, Any]) -> str:
    """Return what stands in the manifest of an export with these facts."""
    # NaN is no JSON: other readers would refuse the whole file.
    return json.dumps(facts, indent=1, allow_nan=False) + "\n"


def _manifest(subject: Subject, target: str, content: Mapping[str, bytes]) -> dict[str, Any]:
    signals = {}
    for role, card in (("input", subject.input), ("output", subject.output)):
        signals[role] = {"name": card.name, "unit": card.unit, "low": card.low, "high": card.high}
    return {
        "format": FORMAT,
        "schema": SCHEMA,
        "dehyst": __version__,
        # The date alone differs between two exports of one model.
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
        raise OutputError(
            f"cannot write '{folder}': it is a file. Name a folder.", path=str(folder)
        )
    if not place.parent.is_dir():
        raise OutputError(
            f"cannot write '{folder}': the folder above it does not exist. Make it first: mkdir -p "
            f"{quoted(folder.parent)}",
            path=str(folder),
        )
    repair(folder)
    if not folder.exists() or not any(folder.iterdir()):
        return
    exported = exported_files(folder)
    if exported is None:
        raise OutputError(
            f"'{folder}' is not empty and holds no export of dehyst; writing there would lose {_some(folder)}. Name "
            f"another folder; --overwrite replaces exports only.",
            path=str(folder),
        )
    inside = ""
    if place in here.resolve().parents:
        inside = "the folder you are in"
    for path in inputs:
        if place in path.resolve().parents:
            inside = f"'{path}', which is read for the export,"
            break
    if inside:
        raise OutputError(
            f"cannot write '{folder}': {inside} lies in it, and its files are going to be replaced. Name another "
            f"folder.",
            path=str(folder),
        )
    if overwrite:
        return
    edited = []
    for name, checksum in exported.items():
        # A file that was deleted has no checksum, and nothing to lose.
        if _checksum(folder / name) not in (checksum, ""):
            edited.append(name)
    if not edited:
        return
    names = ", ".join(edited[:3])
    if len(edited) > 3:
        names += " and more"
    verb = "are"
    if len(edited) == 1:
        verb = "is"
    raise OutputError(
        f"'{folder}' is an export of dehyst, but {names} {verb} not as it was written; writing there would lose that. "
        f"Name another folder, or add --overwrite.",
        path=str(folder),
    )


def exported_files(folder: Path) -> dict[str, str] | None:
    """Return name -> sha256 of the files that belong to an export, there or not; None if it is none of ours."""
    try:
        listed = read_manifest(folder)["files"]
    except OutputError:
        return None
    top = folder.resolve()
    files = {}
    for name, checksum in listed.items():
        # A manifest that names a file elsewhere is not one that dehyst wrote.
        if not is_inside(name) or not (folder / name).parent.resolve().is_relative_to(top):
            return None
        files[name] = str(checksum)
    return files


def files_below(folder: Path) -> list[str]:
    """Return the relative paths of all files of a folder, but for those that file managers and git leave there."""
    names = []
    for path in sorted(folder.rglob("*")):
        name = path.relative_to(folder).as_posix()
        if path.name in HIDDEN or name.startswith(".git/"):
            continue
        # A link counts as a file, also one that leads to a folder.
        if path.is_symlink() or not path.is_dir():
            names.append(name)
    return names


HIDDEN = (".DS_Store", "Thumbs.db", "desktop.ini", ".gitignore", ".gitattributes")


def _checksum(path: Path) -> str:
    if not path.is_file():
        return ""
    return hashlib.sha256(path.read_bytes()).hexdigest()


def _some(folder: Path) -> str:
    names = sorted(path.name for path in folder.iterdir())
    words = ", ".join(f"'{name:.40}'" for name in names[:3])
    if len(names) > 3:
        words += f" and {len(names) - 3} more"
    return words


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
        lack = "does not exist"
        if folder.exists():
            lack = f"holds no {MANIFEST}"
        raise OutputError(
            f"'{folder}' {lack}, so it is no export of dehyst. Name a folder written by `dehyst export ... --out DIR`.",
            path=str(folder),
        )
    try:
        if path.stat().st_size > MOST_BYTES:
            raise OSError("it is too large")
        return path.read_bytes()
    except OSError as fault:
        raise _no_manifest(path, fault) from None


def _no_constant(name: str) -> None:
    """Refuse Infinity and NaN, which are not JSON and which no export writes."""
    raise ValueError(f"it holds {name}, which is not JSON")


def parse_manifest(data: bytes, folder: Path) -> dict[str, Any]:
    """Return what the bytes of the manifest of `folder` say; refuse what is none."""
    try:
        manifest = json.loads(data.decode("utf-8"), parse_constant=_no_constant)
        if not isinstance(manifest, dict) or manifest.get("format") != FORMAT:
            raise ValueError(f'it lacks "format": "{FORMAT}"')
        if manifest.get("schema") != SCHEMA:
            raise ValueError(
                f"its schema is {manifest.get('schema')!r:.20}, this dehyst, {__version__}, reads {SCHEMA}; verify it "
                f"with dehyst {manifest.get('dehyst')!s:.20}, which wrote it"
            )
        if not isinstance(manifest.get("files"), dict) or not isinstance(
            manifest.get("settings"), dict
        ):
            raise ValueError("it lists no files or no settings")
    except (ValueError, RecursionError) as fault:
        raise _no_manifest(folder / MANIFEST, fault) from None
    return manifest


def _no_manifest(path: Path, fault: Exception) -> OutputError:
    return OutputError(
        f"'{path}' is no manifest of an export ({fault}). Export again: dehyst export MODEL --target ... --out DIR",
        path=str(path),
    )
