"""Checks that `dehyst verify` runs for every target; each target adds its own."""

from __future__ import annotations

import hashlib
import io
import json
import os
import re
import tempfile
import zipfile
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Any

import numpy as np

from dehyst.errors import DehystError, OutputError
from dehyst.export._exchange import is_inside
from dehyst.export._folder import (
    BUILDS,
    EXCERPT,
    MANIFEST,
    MOST_BYTES,
    VERIFIED,
    contents,
    files_below,
    manifest_text,
    parse_manifest,
    read_bytes,
)
from dehyst.export._kinds import GROUP as CONTROLLER_GROUP
from dehyst.export._kinds import controller_kind
from dehyst.export._pair import PAIR, pair_contents, pair_settings
from dehyst.export._signal import from_csv, same_bits
from dehyst.export._subject import DIRECT, WHATS, Subject, subject_of
from dehyst.export._targets import GROUP as TARGET_GROUP
from dehyst.export._targets import Check, target
from dehyst.export.compilers import check_folder
from dehyst.families import kit as families_kit
from dehyst.models import kit as models_kit
from dehyst.plugins import EXPORTS, added
from dehyst.version import __version__

CLAIM = "files are those that dehyst exports from this model"
CLAIM_OF_VERSION = "exported with the version of dehyst that verifies it"
# A text of a stranger goes to the terminal only where it looks like a version.
VERSION = re.compile(r"\d[a-z0-9.+-]{,40}")
# The members of an FMU in which two honest machines may differ.
BINARY = re.compile(r"binaries/[\w-]+/\w+\.(so|dll|dylib)")


@dataclass(frozen=True)
class Verification:
    """What a verification found.

    Attributes
    ----------
    checks
        One a claim.
    subject
        The unit, made again from the model in the folder; None if that was not possible.
    why_not
        Why the export is not signed off; "" if it is.
    manifest, digest
        The manifest that was compared, and the sha256 of its bytes.
    """

    checks: tuple[Check, ...]
    subject: Subject | None
    why_not: str
    manifest: Mapping[str, Any]
    digest: str

    @property
    def good(self) -> bool:
        """Whether the export is signed off."""
        return not self.why_not


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
    return list(verify_folder(Path(folder)).checks)


def verify_folder(folder: Path) -> Verification:
    """Compare an export folder with a fresh export of its model, byte by byte; then compile and run the fresh one.

    Each file is read once. No byte of the folder is compiled or run: what runs are the bytes that dehyst writes itself,
    and they are the folder's, or nothing runs.
    """
    # Its digest is what is signed off, so the manifest is read as bytes, and once.
    written = read_bytes(folder)
    manifest = parse_manifest(written, folder)
    content = read_content(folder, manifest)
    version = version_check(manifest.get("dehyst"))
    checks = [version, *file_checks(folder, manifest, content), *added_checks(folder, manifest)]

    def verified(subject: Subject | None, why_not: str) -> Verification:
        return Verification(
            tuple(checks), subject, why_not, manifest, hashlib.sha256(written).hexdigest()
        )

    # Another version writes other files: compared with those of this one, all would seem to be edited.
    if not version.ok:
        checks.append(NOT_RUN)
        return verified(None, WRONG)
    install = package_to_install(manifest)
    if install:
        checks += [Check(CLAIM, "skipped", install), NOT_RUN_HERE]
        if _all_hold(checks):
            return verified(None, install)
        return verified(None, WRONG)
    subject: Subject | None = None
    try:
        if manifest["settings"].get("what") == PAIR:
            fresh = pair_again(folder, manifest, content)
        else:
            subject = subject_again(folder, manifest, content)
            checks += expectation_checks(content, subject)
            fresh = contents(subject, str(manifest.get("target")))
    except DehystError as fault:
        checks.append(Check("the model can be read, and its unit made again", "failed", str(fault)))
        return verified(None, WRONG)
    checks += regeneration_checks(manifest, written, content, fresh)
    if not _all_hold(checks):
        checks.append(NOT_RUN)
        return verified(subject, WRONG)
    # The fresh files lie in a folder of their own, where nobody else has put anything that a compiler finds.
    with tempfile.TemporaryDirectory(prefix="dehyst-") as place:
        for name, data in fresh.items():
            path = Path(place) / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(data)
        if subject is None:
            runs = check_folder(Path(place))
        else:
            runs = target(str(manifest["target"])).load().verify(Path(place), subject)
    checks += runs
    # A file that was exchanged while the checks ran must not be signed off.
    if (read_bytes(folder), read_content(folder, manifest)) != (written, content):
        claim = "the folder stayed as it was meanwhile"
        checks.append(Check(claim, "failed", "its files changed; verify it again"))
    if not _all_hold(checks):
        return verified(subject, WRONG)
    if not _was_run(runs, compiled="Makefile" in fresh):
        return verified(subject, NOTHING_RAN)
    return verified(subject, "")


def _all_hold(checks: Iterable[Check]) -> bool:
    return all(check.ok for check in checks)


NOT_RUN = Check(
    "its code gives the model's answers",
    "skipped",
    "not compared and not run, because of the faults above",
)
NOT_RUN_HERE = Check(
    "its code gives the model's answers",
    "skipped",
    "not compared and not run, because this package is not installed",
)
WRONG = "do not use this export"
NOTHING_RAN = (
    "nothing was compiled; install gcc or clang, and make, for target rust cargo, for ada GNAT (on Debian: apt-get "
    "install gcc make cargo gnat gprbuild)"
)


def package_to_install(manifest: Mapping[str, Any]) -> str:
    """Return which package of dehyst lacks here to export the folder again, and what to type; "" if none does."""
    target_name = str(manifest.get("target"))
    kind_name = str(manifest["settings"].get("what"))
    for name, group in ((target_name, TARGET_GROUP), (kind_name, CONTROLLER_GROUP)):
        if name in EXPORTS and name not in added(group):
            package = EXPORTS[name]
            return f"{name} is part of {package}, which is not installed: pip install {package}, and verify again"
    return ""


def _was_run(runs: Iterable[Check], compiled: bool) -> bool:
    """Whether some code was run; what is not compiled, as Structured Text, runs in a checker of our own."""
    if compiled:
        return any(check.ran for check in runs)
    return any(check.status == "passed" for check in runs)


def read_content(folder: Path, manifest: Mapping[str, Any]) -> dict[str, bytes]:
    """Return name -> bytes of the files that the manifest names and that are there."""
    content = {}
    for name in manifest["files"]:
        if not is_inside(name):
            raise OutputError(
                f"the manifest of '{folder}' names a file '{name:.80}' outside the folder: dehyst wrote no such "
                f"export. Export again.",
                path=str(folder),
            )
        path = folder / name
        try:
            if path.is_file():
                # A huge file could fill the memory before anything is compared.
                if path.stat().st_size > MOST_BYTES:
                    raise OSError(f"it is larger than {MOST_BYTES // 2**20} MiB")
                content[name] = path.read_bytes()
        except OSError as fault:
            raise OutputError(
                f"'{path}' cannot be read ({fault}). Export again.", path=str(path)
            ) from None
    return content


def file_checks(
    folder: Path, manifest: Mapping[str, Any], content: Mapping[str, bytes]
) -> list[Check]:
    """Compare every file with its checksum; files that were edited, lost, or lie elsewhere are named."""
    sums = manifest["files"]
    edited, missing = [], []
    for name, checksum in sums.items():
        if name not in content:
            missing.append(name)
        elif hashlib.sha256(content[name]).hexdigest() != checksum:
            edited.append(name)
    # What a link leads to may change after it was compared.
    links = [name for name in (*sums, MANIFEST) if _is_linked(folder, name)]
    claim = "files are as they were written"
    words = _listed(("edited", edited), ("missing", missing), ("links to files elsewhere", links))
    if not sums:
        words = ["the manifest lists none"]
    if words:
        return [Check(claim, "failed", "; ".join(words) + "; export again, and change a copy")]
    return [Check(claim, "passed", f"{len(sums)} files, sha256")]


def _is_linked(folder: Path, name: str) -> bool:
    """Whether a file, or a folder on the way to it, is a symbolic link."""
    parts = name.split("/")
    return any((folder / "/".join(parts[: k + 1])).is_symlink() for k in range(len(parts)))


def added_checks(folder: Path, manifest: Mapping[str, Any]) -> list[Check]:
    """Name files that were added: where compilers and make would find them they are a fault, elsewhere notes."""
    exported = {*manifest["files"], MANIFEST, VERIFIED}
    # Some file systems take names for the same that differ in case.
    tops = {name.partition("/")[0].casefold() for name in manifest["files"]}
    builds = set()
    additions = []
    strange = []
    for name in files_below(folder):
        top, slash, _ = name.partition("/")
        if name in exported:
            continue
        if slash and top in BUILDS:
            builds.add(top)
            continue
        additions.append(name)
        if top.casefold() in tops or _is_code(name):
            strange.append(name)
    claim = "no file was added to the sources"
    if strange:
        why = f"added: {_some(strange)}; take them out, they can change what is compiled"
        return [Check(claim, "failed", why)]
    notes = []
    if additions:
        notes.append(f"notes beside it: {_some(additions)}")
    for name in sorted(builds):
        notes.append(f"{name}/ was not looked at; delete it before you build")
    return [Check(claim, "passed", "; ".join(notes))]


CODE = (
    ".c", ".h", ".cc", ".cpp", ".cxx", ".hpp", ".inc", ".s", ".mk", ".cmake", ".ino", ".m", ".st", ".scl", ".xml",
    ".rs", ".toml", ".ads", ".adb", ".gpr",
)  # fmt: skip
TOOLS = ("makefile", "gnumakefile", "cmakelists.txt", "rust-toolchain")


def _is_code(name: str) -> bool:
    """Whether a file would be taken for one of the export, by a tool or by a person."""
    low = name.lower()
    return low.startswith(".cargo/") or (
        "/" not in name and (low.endswith((*CODE, ".fmu")) or low in TOOLS)
    )


def _listed(*groups: tuple[str, Sequence[str]]) -> list[str]:
    """Return one clause for each group that has names."""
    return [f"{heading}: {_some(names)}" for heading, names in groups if names]


def _some(names: Sequence[str]) -> str:
    words = ", ".join(names[:5])
    if len(names) > 5:
        words += " and more"
    return words


def pair_again(
    folder: Path, manifest: Mapping[str, Any], content: Mapping[str, bytes]
) -> dict[str, bytes]:
    """Make the files of an export of two inputs and two outputs anew from the model in its `content`.

    Raises
    ------
    DehystError
        If the folder's files do not allow it.
    """
    try:
        model = models_kit.model_from_text(_text(content, "model.json"), str(folder / "model.json"))
        if not isinstance(model, families_kit.CoupledModel):
            raise OutputError(f"model.json holds a {model.family} model and no two inputs.")
        return pair_contents(model, pair_settings(manifest["settings"]))
    except (KeyError, TypeError, ValueError) as fault:
        raise OutputError(f"its settings are none of such an export ({fault!s:.120}).") from None


def subject_again(
    folder: Path, manifest: Mapping[str, Any], content: Mapping[str, bytes]
) -> Subject:
    """Make the subject of a folder anew from the model in its `content`.

    Raises
    ------
    DehystError
        If the folder's files do not allow it.
    """
    settings = manifest["settings"]
    try:
        kind, name, real = (str(settings[key]) for key in ("what", "name", "real"))
        text = _text(content, "model.json")
        model = models_kit.model_from_text(text, str(folder / "model.json"))
        if kind not in (*WHATS, DIRECT):
            return controller_kind(kind).from_folder(
                model, lambda file: _text(content, file), folder, settings
            )
        bounds, ramp = settings.get("range"), int(settings["ramp"])
        range = None if bounds is None else (float(bounds[0]), float(bounds[1]))
        period = None if settings.get("period") is None else float(settings["period"])
        followed = (
            None if settings.get("follow_offset") is None else float(settings["follow_offset"])
        )
        excerpt = None
        if EXCERPT in manifest["files"]:
            excerpt = from_csv(_text(content, EXCERPT), 1, EXCERPT).inputs[:, 0]
        source = str(manifest.get("excerpt_source", ""))
        return subject_of(
            model, "inverse" if kind == DIRECT else kind, name=name, period=period, real=real, range=range, ramp=ramp,
            excerpt=excerpt, excerpt_source=source, follow_offset=followed,
            retain=bool(settings.get("retain")), tunable=bool(settings.get("tunable")),
        )  # fmt: skip
    # An edited manifest may hold anything in the place of a number.
    except (KeyError, TypeError, IndexError, ValueError, OverflowError) as fault:
        if isinstance(fault, DehystError):
            raise
        raise OutputError(
            f"the manifest of '{folder}' lacks a setting ({fault!s:.200}). Export again."
        ) from None


def expectation_checks(content: Mapping[str, bytes], subject: Subject) -> list[Check]:
    """Compare the expected answers in the folder with those of the model in it, computed again."""
    checks = []
    for label, name, signal in (
        ("test signal", "expected/test_signal.csv", subject.test),
        ("excerpt in this folder", EXCERPT, subject.excerpt),
    ):
        if signal is None and (subject.block is None or subject.more):
            continue  # a log of one column says nothing about a controller, nor about a unit with several inputs
        if signal is None:
            why = "exported without a log; add --log LOG --column COLUMN to dehyst export"
            checks.append(
                Check(f"{label}: expected answers are those of the model", "skipped", why)
            )
            continue
        exported = from_csv(_text(content, name), signal.inputs.shape[1], name)
        claim = f"{label}: expected answers are those of the model"
        same = (
            same_bits(exported.inputs, signal.inputs)
            and same_bits(exported.outputs, signal.outputs)
            and np.array_equal(exported.flags, signal.flags)
            and np.array_equal(exported.switch, signal.switch)
        )
        if not same:
            why = f"'{name}' holds other numbers: export again"
            checks.append(Check(claim, "failed", why))
            continue
        detail = f"{signal.samples} samples, bit for bit"
        if signal is subject.excerpt:
            detail += f"; recorded source: {subject.excerpt_source}"
        checks.append(Check(claim, "passed", detail))
    return checks


def _text(content: Mapping[str, bytes], name: str) -> str:
    try:
        return content[name].decode("utf-8")
    except KeyError:
        raise OutputError(
            f"'{name}' is not among the files of the export. Export again.", path=name
        ) from None
    except UnicodeDecodeError as fault:
        raise OutputError(f"'{name}' is no text ({fault}). Export again.", path=name) from None


def version_check(version: object) -> Check:
    """Return whether a folder was exported with this version: another one writes files that only it can make."""
    if version == __version__:
        return Check(CLAIM_OF_VERSION, "passed", __version__)
    if not isinstance(version, str) or not VERSION.fullmatch(version):
        why = f"{MANIFEST} names no version of dehyst; this is {__version__}: export again with it"
        return Check(CLAIM_OF_VERSION, "failed", why)
    why = f"exported with dehyst {version}, this is {__version__}, which writes other files: verify the folder with "
    return Check(
        CLAIM_OF_VERSION,
        "failed",
        f"{why}dehyst {version}, or export its model again with this one",
    )


def regeneration_checks(
    manifest: Mapping[str, Any],
    written: bytes,
    content: Mapping[str, bytes],
    fresh: Mapping[str, bytes],
) -> list[Check]:
    """Compare manifest and files of a folder with a fresh export of its model."""
    return [_facts(manifest, written, json.loads(fresh[MANIFEST])), _files(content, fresh)]


def _facts(manifest: Mapping[str, Any], written: bytes, facts: dict[str, Any]) -> Check:
    """Compare the manifest with the one written today; the date only has to be a date."""
    claim = f"{MANIFEST} says what the model says"
    # A date that is not written as dehyst writes it was edited.
    facts["date"] = manifest.get("date") if _is_date(manifest.get("date")) else ""
    facts["files"] = dict(
        sorted(manifest["files"].items())
    )  # compared with the files, and these with fresh ones
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
    changed = sorted(name for name in due & content.keys() if content[name] != fresh[name])
    words = _listed(
        ("not as exported", changed),
        ("missing", sorted(due - content.keys())),
        ("of no such export", sorted(content.keys() - due)),
    )
    if not words:
        return Check(CLAIM, "passed", f"exported again: {len(due)} files are the same")
    for name in changed:
        if name.endswith(".fmu"):
            words.append(_compiled(name, content[name], fresh[name]))
    words.append("export again, and change a copy")
    return Check(CLAIM, "failed", "; ".join(filter(None, words)))


def _compiled(name: str, exported: bytes, fresh: bytes) -> str:
    """Say so if only binaries or the packing of an FMU differ: honest ones do, of another compiler or zlib."""
    try:
        ours, theirs = _members(fresh), _members(exported)
    except (zipfile.BadZipFile, ValueError, NotImplementedError, EOFError, OSError):
        return ""
    members = {*ours, *theirs}
    changed = sorted(member for member in members if ours.get(member) != theirs.get(member))
    if not all(map(BINARY.fullmatch, changed)):
        return ""
    differing = f"the packing of {name} is"
    if len(changed) == 1:
        differing = f"{changed[0]} in {name} is"
    elif changed:
        differing = f"{', '.join(changed)} in {name} are"
    return f"{differing} not what this machine makes of the same sources: verify it where it was exported"


def _members(data: bytes) -> dict[str, tuple[int, int]]:
    """Return path -> checksum and size of what an archive holds; nothing is unpacked, it may be hostile."""
    with zipfile.ZipFile(io.BytesIO(data)) as packed:
        return {entry.filename: (entry.CRC, entry.file_size) for entry in packed.infolist()}
