"""The export that a folder's model and settings give today, compared file by file and fact by fact with the folder."""

from __future__ import annotations

import io
import json
import re
import zipfile
from collections.abc import Mapping
from datetime import datetime
from typing import Any

from dehyst import __version__
from dehyst.errors import DehystError
from dehyst.export.checks import Check
from dehyst.export.folder import MANIFEST, contents
from dehyst.export.subject import Subject

FREE = ("date", "dehyst", "files")  # facts of a manifest that differ between equal exports, or are compared elsewhere
OF_THE_MODEL = ("model_sha256", "provenance", "operators", "input", "output", "period")  # whatever dehyst wrote it
BINARY = re.compile(r"binaries/[\w-]+/\w+\.(so|dll|dylib)")
# Lines of an FMU's README.md that hang on the compilers of the machine that exported it.
_COMPILED = re.compile(
    rf"- `{BINARY.pattern}`|No binary for \w+: no [\w ./-]+ for it on this machine\.[\w .,:`-]*"
    r"|`cp \w+\.fmu [\w .,:`-]*"
)


def regeneration_checks(subject: Subject, manifest: Mapping[str, Any], content: Mapping[str, bytes]) -> list[Check]:
    """Compare manifest and files of a folder with what is exported from the subject anew.

    Binaries inside an FMU are another compiler's business: they are run against the model instead.
    """
    claim = "files are those that dehyst exports from this model"
    try:
        fresh = contents(subject, str(manifest["target"]))
    except DehystError as fault:
        return [Check(claim, "failed", f"it cannot be exported again: {fault}")]
    facts = json.loads(fresh.pop(MANIFEST))
    written_by = manifest.get("dehyst")
    same_version = written_by == __version__
    checks = [_facts(manifest, facts, same_version)]
    if not same_version:
        why = f"exported with dehyst {written_by!s:.20}, this is {__version__}: export again to compare every file"
        return [*checks, Check(claim, "skipped", why)]
    both = fresh.keys() & content.keys()
    words = [
        f"{what}: {', '.join(names[:5])}{' and more' if len(names) > 5 else ''}"
        for what, names in (
            (
                "not as exported",
                sorted(name for name in both if not _same(name, content[name], fresh[name])),
            ),
            ("missing", sorted(fresh.keys() - content.keys())),
            ("of no such export", sorted(content.keys() - fresh.keys())),
        )
        if names
    ]
    if words:
        return [*checks, Check(claim, "failed", "; ".join(words) + "; export again, and change a copy")]
    return [
        *checks,
        Check(claim, "passed", f"exported again: {len(fresh)} files are the same{_binaries(content, fresh)}"),
    ]


def _facts(manifest: Mapping[str, Any], facts: Mapping[str, Any], same_version: bool) -> Check:
    """Compare what the manifest says with what the model says; dates only have to be dates."""
    claim = f"{MANIFEST} says what the model says"
    names = (manifest.keys() | facts.keys()) - set(FREE) if same_version else OF_THE_MODEL
    wrong = [name for name in sorted(names) if _plain(manifest.get(name)) != _plain(facts.get(name))]
    try:
        datetime.fromisoformat(str(manifest.get("date")))
    except ValueError:
        wrong.append("date")
    if not re.fullmatch(r"[\w.+-]{1,40}", str(manifest.get("dehyst"))):
        wrong.append("dehyst")
    if wrong:
        return Check(claim, "failed", f"other than the model's: {', '.join(wrong)}; export again")
    return Check(claim, "passed", ", ".join(OF_THE_MODEL[:3]) + ("" if same_version else "; no more, see below"))


def _plain(value: object) -> str:
    return json.dumps(value, sort_keys=True)


def _same(name: str, kept: bytes, fresh: bytes) -> bool:
    """Whether two files are equal, but for binaries in an archive and the lines that list these."""
    if kept == fresh:
        return True
    if fresh.startswith(b"PK\x03\x04"):
        try:
            members = [_members(data) for data in (kept, fresh)]
        except (zipfile.BadZipFile, ValueError, NotImplementedError, RuntimeError, EOFError):
            return False
        return members[0] == members[1]
    return name == "README.md" and _uncompiled(kept) == _uncompiled(fresh)


def _members(data: bytes) -> dict[str, bytes]:
    """Return path -> content of an archive without its binaries; a name that stands there twice is an error."""
    with zipfile.ZipFile(io.BytesIO(data)) as packed:
        if len(set(packed.namelist())) != len(packed.namelist()):
            raise ValueError("a member stands there twice")
        return {name: packed.read(name) for name in packed.namelist() if not BINARY.fullmatch(name)}


def _uncompiled(text: bytes) -> list[str]:
    lines = text.decode("utf-8", errors="replace").splitlines()
    plain = [line.replace(" and binaries:", "").rstrip(".") for line in lines if not _COMPILED.fullmatch(line)]
    return [line for line in plain if line]


def _binaries(content: Mapping[str, bytes], fresh: Mapping[str, bytes]) -> str:
    """Say which binaries of an FMU are not those that this machine compiles."""
    others = []
    for name in fresh:
        if fresh[name].startswith(b"PK\x03\x04") and content[name] != fresh[name]:
            with zipfile.ZipFile(io.BytesIO(content[name])) as kept, zipfile.ZipFile(io.BytesIO(fresh[name])) as made:
                both = set(made.namelist())
                paths = [path for path in kept.namelist() if BINARY.fullmatch(path)]
                others += [path for path in paths if path not in both or kept.read(path) != made.read(path)]
    return f"; not from this machine's compilers: {', '.join(others)}" if others else ""
