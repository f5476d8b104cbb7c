"""The export that a folder's model and settings give today, compared byte by byte with the folder."""

from __future__ import annotations

import io
import json
import re
import zipfile
from collections.abc import Mapping
from datetime import datetime
from typing import Any

from dehyst.export.checks import Check
from dehyst.export.folder import MANIFEST, manifest_text
from dehyst.version import __version__

CLAIM = "files are those that dehyst exports from this model"
CLAIM_OF_VERSION = "exported with the version of dehyst that verifies it"
VERSION = re.compile(r"\d[a-z0-9.+-]{,40}")
BINARY = re.compile(r"binaries/[\w-]+/\w+\.(so|dll|dylib)")


def version_check(version: object) -> Check:
    """Return whether a folder was exported with this version: another one writes files that only it can make."""
    if version == __version__:
        return Check(CLAIM_OF_VERSION, "passed", __version__)
    if not isinstance(version, str) or not VERSION.fullmatch(version):
        why = f"{MANIFEST} names no version of dehyst; this is {__version__}: export again with it"
        return Check(CLAIM_OF_VERSION, "failed", why)
    why = f"exported with dehyst {version}, this is {__version__}, which writes other files: verify the folder with "
    return Check(CLAIM_OF_VERSION, "failed", f"{why}dehyst {version}, or export its model again with this one")


def regeneration_checks(
    manifest: Mapping[str, Any], written: bytes, content: Mapping[str, bytes], fresh: Mapping[str, bytes]
) -> list[Check]:
    """Compare manifest and files of a folder with a fresh export of its model."""
    return [_facts(manifest, written, json.loads(fresh[MANIFEST])), _files(content, fresh)]


def _facts(manifest: Mapping[str, Any], written: bytes, facts: dict[str, Any]) -> Check:
    """Compare the manifest with the one written today; the date only has to be a date."""
    claim = f"{MANIFEST} says what the model says"
    facts["date"] = manifest.get("date") if _is_date(manifest.get("date")) else ""
    facts["files"] = dict(sorted(manifest["files"].items()))  # compared with the files, and these with fresh ones
    names = sorted({*manifest, *facts})
    wrong = [name for name in names if _plain(manifest.get(name)) != _plain(facts.get(name))]
    if wrong:
        return Check(claim, "failed", f"other than the model's: {', '.join(wrong)}; export again")
    if written != manifest_text(facts).encode("utf-8"):
        return Check(claim, "failed", "its text is not as exported; export again")
    return Check(claim, "passed", "model_sha256, provenance, operators, settings")


def _is_date(text: object) -> bool:
    try:
        date = datetime.fromisoformat(str(text))
    except ValueError:
        return False
    return date.utcoffset() is not None and date.isoformat(timespec="seconds") == text


def _plain(value: object) -> str:
    return json.dumps(value, sort_keys=True)


def _files(content: Mapping[str, bytes], fresh: Mapping[str, bytes]) -> Check:
    due = fresh.keys() - {MANIFEST}
    other = sorted(name for name in due & content.keys() if content[name] != fresh[name])
    found = (
        ("not as exported", other),
        ("missing", sorted(due - content.keys())),
        ("of no such export", sorted(content.keys() - due)),
    )
    words = [f"{what}: {', '.join(names[:5])}{' and more' if len(names) > 5 else ''}" for what, names in found if names]
    if not words:
        return Check(CLAIM, "passed", f"exported again: {len(due)} files are the same")
    words += [_compiled(name, content[name], fresh[name]) for name in other if name.endswith(".fmu")]
    return Check(CLAIM, "failed", "; ".join([*filter(None, words), "export again, and change a copy"]))


def _compiled(name: str, kept: bytes, fresh: bytes) -> str:
    """Say so if only binaries or the packing of an FMU differ: honest ones do, of another compiler or zlib."""
    try:
        ours, theirs = _members(fresh), _members(kept)
    except (zipfile.BadZipFile, ValueError, NotImplementedError, EOFError, OSError):
        return ""
    other = sorted(member for member in {*ours, *theirs} if ours.get(member) != theirs.get(member))
    if not all(BINARY.fullmatch(member) for member in other):
        return ""
    what = (
        f"{', '.join(other)} in {name} {'is' if len(other) == 1 else 'are'}" if other else f"the packing of {name} is"
    )
    return f"{what} not what this machine makes of the same sources: verify it where it was exported"


def _members(data: bytes) -> dict[str, tuple[int, int]]:
    """Return path -> checksum and size of what an archive holds; nothing is unpacked, it may be hostile."""
    with zipfile.ZipFile(io.BytesIO(data)) as packed:
        return {entry.filename: (entry.CRC, entry.file_size) for entry in packed.infolist()}
