"""Export folders: written whole or not at all, and verified file by file."""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from dehyst import __version__
from dehyst.errors import OutputError, ParameterError
from dehyst.export.budget import Budget, budget
from dehyst.export.checks import Check
from dehyst.export.rendering import TEMPLATES
from dehyst.export.signal import to_csv
from dehyst.export.subject import Subject
from dehyst.export.targets import target as target_of

FORMAT = "dehyst-export"
SCHEMA = 1
MANIFEST = "manifest.json"
VERIFIED = "VERIFIED.txt"
BUILD = "build"  # what `make` leaves behind
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
    """

    folder: Path
    files: tuple[str, ...]
    size: int
    budget: Budget


def export(subject: Subject, target: str, folder: str | os.PathLike[str], overwrite: bool = False) -> Written:
    """Write a subject for a target into a folder that appears whole or not at all.

    Parameters
    ----------
    subject
        From `subject_of` or `joint_subject`.
    target
        Name of a target, a key of `TARGETS`.
    folder
        To write; an export that is there already is replaced, anything else is refused.
    overwrite
        Replace whatever is there.

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
    kind = target_of(target)
    for value, allowed, option in ((subject.what, kind.whats, "--what"), (subject.real, kind.reals, "--real")):
        if value not in allowed:
            raise ParameterError(
                f"target '{target}' has no {option} {value}; it has {', '.join(allowed)}. Choose one of these, or "
                f"another target."
            )
    place = Path(folder)
    refuse_folder(place, overwrite)
    content = contents(subject, target)
    _write(place, content)
    return Written(place, tuple(sorted(content)), sum(map(len, content.values())), budget(subject))


def contents(subject: Subject, target: str) -> dict[str, bytes]:
    """Return relative path -> bytes of all files of an export, the manifest included."""
    files: dict[str, str | bytes] = {
        "LICENSE": (TEMPLATES / "LICENSE").read_text(encoding="utf-8"),
        "model.json": subject.model_text,
        "expected/test_signal.csv": to_csv(subject.test),
    }
    if subject.excerpt is not None:
        files["expected/excerpt.csv"] = to_csv(subject.excerpt)
    for name, text in subject.extra.items():
        files[name] = text
    files |= target_of(target).load().files(subject)
    content = {name: text.encode("utf-8") if isinstance(text, str) else text for name, text in files.items()}
    manifest = json.dumps(_manifest(subject, target, content), indent=1, allow_nan=False) + "\n"
    return {**content, MANIFEST: manifest.encode("utf-8")}


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


def refuse_folder(folder: Path, overwrite: bool) -> None:
    """Refuse a folder that holds anything but an export, and a place that is no folder.

    Raises
    ------
    OutputError
        If something would be lost, or the folder above does not exist.
    """
    if folder.exists() and not folder.is_dir():
        raise OutputError(f"cannot write '{folder}': it is a file. Name a folder.", path=str(folder))
    if not folder.absolute().parent.is_dir():
        raise OutputError(
            f"cannot write '{folder}': the folder above it does not exist. Make it first: mkdir -p {folder.parent}",
            path=str(folder),
        )
    if not folder.exists() or overwrite or not any(folder.iterdir()):
        return
    strange = foreign_files(folder)
    if strange is None:
        raise OutputError(
            f"'{folder}' is not empty and holds no export of dehyst; writing there would lose {_some(folder)}. Name "
            f"another folder, or add --overwrite.",
            path=str(folder),
        )
    if strange:
        raise OutputError(
            f"'{folder}' is an export of dehyst, but {', '.join(strange[:3])}{' and more' if len(strange) > 3 else ''} "
            f"{'is' if len(strange) == 1 else 'are'} not as it was written; writing there would lose that. Name "
            f"another folder, or add --overwrite.",
            path=str(folder),
        )


def foreign_files(folder: Path) -> list[str] | None:
    """Return which files of an export were added or edited since; None if it is none of ours."""
    try:
        known = read_manifest(folder)["files"]
    except OutputError:
        return None
    strange = []
    for path in sorted(folder.rglob("*")):
        name = path.relative_to(folder).as_posix()
        if path.is_dir() or name in (MANIFEST, VERIFIED) or name.startswith(f"{BUILD}/"):
            continue
        if hashlib.sha256(path.read_bytes()).hexdigest() != known.get(name):
            strange.append(name)
    return strange


def _some(folder: Path) -> str:
    names = sorted(path.name for path in folder.iterdir())
    return ", ".join(f"'{name:.40}'" for name in names[:3]) + (f" and {len(names) - 3} more" if len(names) > 3 else "")


def _write(folder: Path, content: Mapping[str, bytes]) -> None:
    """Write a sibling, then let it take the folder's place."""
    aside = None
    try:
        temporary = Path(tempfile.mkdtemp(prefix=f".{folder.name}.", dir=folder.absolute().parent))
        try:
            for name, data in content.items():
                path = temporary / name
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_bytes(data)
            mask = os.umask(0)
            os.umask(mask)
            temporary.chmod(0o777 & ~mask)
            if folder.exists():
                aside = Path(tempfile.mkdtemp(prefix=f".{folder.name}.", dir=folder.absolute().parent))
                folder.replace(aside / "old")
            temporary.replace(folder)
        except OSError:
            shutil.rmtree(temporary, ignore_errors=True)
            if aside is not None and (aside / "old").exists() and not folder.exists():
                (aside / "old").replace(folder)
            raise
    except OSError as fault:
        raise OutputError(
            f"cannot write '{folder}': {fault.strerror or fault}. What was there is untouched. Free some space or name "
            f"another folder.",
            path=str(folder),
        ) from None
    finally:
        if aside is not None:
            shutil.rmtree(aside, ignore_errors=True)


def read_manifest(folder: str | os.PathLike[str]) -> dict[str, Any]:
    """Return the manifest of an export folder.

    Raises
    ------
    OutputError
        If the folder is none, or its manifest is of another version.
    """
    place = Path(folder)
    path = place / MANIFEST
    if not path.is_file():
        what = "does not exist" if not place.exists() else f"holds no {MANIFEST}"
        raise OutputError(
            f"'{place}' {what}, so it is no export of dehyst. Name a folder written by `dehyst export ... --out DIR`.",
            path=str(place),
        )
    try:
        if path.stat().st_size > MOST_BYTES:
            raise ValueError("it is too large")
        manifest = json.loads(path.read_text(encoding="utf-8"))
        if not isinstance(manifest, dict) or manifest.get("format") != FORMAT:
            raise ValueError(f'it lacks "format": "{FORMAT}"')
        if manifest.get("schema") != SCHEMA:
            raise ValueError(f"its schema is {manifest.get('schema')!r:.20}, this dehyst reads {SCHEMA}")
        if not isinstance(manifest.get("files"), dict) or not isinstance(manifest.get("settings"), dict):
            raise ValueError("it lists no files or no settings")
    except (OSError, ValueError, RecursionError) as fault:
        raise OutputError(
            f"'{path}' is no manifest of an export ({fault}). Export again: dehyst export MODEL --target ... --out DIR",
            path=str(path),
        ) from None
    return manifest


def verify(folder: str | os.PathLike[str]) -> list[Check]:
    """Check an export folder: its files, its expected answers against the model, and the target's own checks.

    Returns
    -------
    checks : list of Check
        All that was claimed and whether it holds.

    Raises
    ------
    OutputError
        If the folder is no export.
    """
    from dehyst.export.verification import verify_folder

    return verify_folder(Path(folder))
