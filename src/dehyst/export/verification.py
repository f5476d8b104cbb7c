"""What `dehyst verify` does for every target; each target adds its own checks."""

from __future__ import annotations

import hashlib
import tempfile
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from dehyst.control.storage import load_adaptation, load_controller
from dehyst.errors import DehystError, OutputError
from dehyst.export.checks import Check
from dehyst.export.direct_block import WHAT, direct_block_subject
from dehyst.export.folder import BUILD, MANIFEST, MOST_BYTES, VERIFIED, files_below, is_inside, read_manifest
from dehyst.export.joint import joint_subject
from dehyst.export.regeneration import regeneration_checks
from dehyst.export.signal import Signal, from_csv, same_bits
from dehyst.export.subject import Subject, subject_of
from dehyst.export.targets import target
from dehyst.models import DirectInverse, load_any, load_model


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
    """

    checks: tuple[Check, ...]
    subject: Subject | None
    why_not: str

    @property
    def good(self) -> bool:
        """Whether the export is signed off."""
        return not self.why_not


def verify_folder(folder: Path) -> Verification:
    """Check an export folder; its code is compiled and run only if it is what dehyst exports from its model.

    What is run is a copy that holds the files of the manifest and nothing else.
    """
    manifest = read_manifest(folder)
    content = read_content(folder, manifest)
    checks = [*file_checks(manifest, content), *added_checks(folder, manifest)]
    try:
        subject = subject_again(folder, manifest)
        checks += expectation_checks(folder, subject)
        kind = target(str(manifest.get("target"))).load()
    except DehystError as fault:
        checks.append(Check("the model can be read, and its unit made again", "failed", str(fault)))
        return Verification(tuple(checks), None, WRONG)
    checks += regeneration_checks(subject, manifest, content)
    if not all(check.ok for check in checks):
        checks.append(Check("its code gives the model's answers", "skipped", "not run, because of the faults above"))
        return Verification(tuple(checks), subject, WRONG)
    with tempfile.TemporaryDirectory(prefix="dehyst-") as place:
        for name, data in content.items():
            path = Path(place) / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(data)
        runs = kind.verify(Path(place), subject, manifest)
    checks += runs
    compiled = any(check.ran for check in runs) or ("Makefile" not in content and any(_passed(runs)))
    why_not = "" if compiled else NOTHING_RAN
    return Verification(tuple(checks), subject, why_not if all(check.ok for check in checks) else WRONG)


WRONG = "do not use this export"
NOTHING_RAN = "nothing was compiled; install gcc or clang, and make (on Debian: apt-get install gcc make)"


def _passed(checks: Iterable[Check]) -> Iterable[bool]:
    return (check.status == "passed" for check in checks)


def read_content(folder: Path, manifest: Mapping[str, Any]) -> dict[str, bytes]:
    """Return name -> bytes of the files that the manifest names and that are there.

    Raises
    ------
    OutputError
        If a name leads out of the folder, or a file cannot be read.
    """
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
                if path.stat().st_size > MOST_BYTES:
                    raise OSError(f"it is larger than {MOST_BYTES // 2**20} MiB")
                content[name] = path.read_bytes()
        except OSError as fault:
            raise OutputError(f"'{path}' cannot be read ({fault}). Export again.", path=str(path)) from None
    return content


def file_checks(manifest: Mapping[str, Any], content: Mapping[str, bytes]) -> list[Check]:
    """Compare every file with its checksum; files that were edited or lost are named."""
    sums = manifest["files"]
    edited = [name for name, data in content.items() if hashlib.sha256(data).hexdigest() != sums[name]]
    missing = [name for name in sums if name not in content]
    claim = "files are as they were written"
    words = [f"{what}: {_some(names)}" for what, names in (("edited", edited), ("missing", missing)) if names]
    if not sums:
        words = ["the manifest lists none"]
    if words:
        return [Check(claim, "failed", "; ".join(words) + "; export again, and change a copy")]
    return [Check(claim, "passed", f"{len(sums)} files, sha256")]


def added_checks(folder: Path, manifest: Mapping[str, Any]) -> list[Check]:
    """Name files that were added: where compilers and make would find them they are a fault, elsewhere notes."""
    known = {*manifest["files"], MANIFEST, VERIFIED}
    own = {name.partition("/")[0] for name in manifest["files"] if "/" in name}
    added = [name for name in files_below(folder) if name not in known and not name.startswith(f"{BUILD}/")]
    strange = [name for name in added if name.partition("/")[0] in own or _is_code(name)]
    claim = "no file was added to the sources"
    if strange:
        return [Check(claim, "failed", f"added: {_some(strange)}; take them out, they can change what is compiled")]
    return [Check(claim, "passed", f"notes beside it: {_some(added)}" if added else "")]


CODE = (".c", ".h", ".cc", ".cpp", ".cxx", ".hpp", ".inc", ".s", ".mk", ".cmake", ".ino", ".m", ".st", ".scl", ".xml")


def _is_code(name: str) -> bool:
    """Whether a file at the top would be taken for one of the export, by a tool or by a person."""
    low = name.lower()
    return "/" not in name and (low.endswith((*CODE, ".fmu")) or low in ("makefile", "gnumakefile", "cmakelists.txt"))


def _some(names: Sequence[str]) -> str:
    return ", ".join(names[:5]) + (" and more" if len(names) > 5 else "")


def subject_again(folder: Path, manifest: Mapping[str, Any]) -> Subject:
    """Make the subject of a folder anew from the model that lies in it.

    Raises
    ------
    DehystError
        If the folder's files do not allow it.
    """
    settings = manifest["settings"]
    if settings.get("what") == "joint-controller":
        parameters = load_controller(folder / "controller.json")
        adaptation = load_adaptation(folder / "controller.json")
        model = load_any(folder / "model.json")
        return joint_subject(model, parameters, adaptation, name=str(settings["name"]), real=str(settings["real"]))
    if settings.get("what") == WHAT:
        return _direct_again(folder, settings)
    excerpt = _read_signal(folder, "expected/excerpt.csv", 1) if "expected/excerpt.csv" in manifest["files"] else None
    bounds = settings.get("range")
    try:
        return subject_of(
            load_model(folder / "model.json"),
            str(settings["what"]),
            name=str(settings["name"]),
            real=str(settings["real"]),
            range=None if bounds is None else (float(bounds[0]), float(bounds[1])),
            ramp=int(settings["ramp"]),
            excerpt=None if excerpt is None else excerpt.inputs[:, 0],
            excerpt_source=str(manifest.get("excerpt_source", "")),
        )
    except (KeyError, TypeError, IndexError, ValueError) as fault:
        if isinstance(fault, DehystError):
            raise
        raise OutputError(f"the manifest of '{folder}' lacks a setting ({fault}). Export again.") from None


def _direct_again(folder: Path, settings: Mapping[str, Any]) -> Subject:
    model = load_any(folder / "model.json")
    if not isinstance(model, DirectInverse):
        raise OutputError(f"'{folder / 'model.json'}' is no direct inverse. Export again.", path=str(folder))
    bounds = settings.get("range")
    try:
        return direct_block_subject(
            model,
            name=str(settings["name"]),
            real=str(settings["real"]),
            period=float(settings["period"]),
            range=None if bounds is None else (float(bounds[0]), float(bounds[1])),
            ramp=int(settings["ramp"]),
        )
    except (KeyError, TypeError, IndexError, ValueError) as fault:
        if isinstance(fault, DehystError):
            raise
        raise OutputError(f"the manifest of '{folder}' lacks a setting ({fault}). Export again.") from None


def expectation_checks(folder: Path, subject: Subject) -> list[Check]:
    """Compare the expected answers in the folder with those of the model in it, computed again."""
    checks = []
    for label, name, signal in (
        ("test signal", "expected/test_signal.csv", subject.test),
        ("excerpt in this folder", "expected/excerpt.csv", subject.excerpt),
    ):
        if signal is None and subject.block is None:
            continue  # a log of one column says nothing about a controller, nor about a unit with several inputs
        if signal is None:
            why = "exported without a log; add --log LOG --column COLUMN to dehyst export"
            checks.append(Check(f"{label}: expected answers are those of the model", "skipped", why))
            continue
        kept = _read_signal(folder, name, signal.inputs.shape[1])
        claim = f"{label}: expected answers are those of the model"
        same = (
            same_bits(kept.inputs, signal.inputs)
            and same_bits(kept.outputs, signal.outputs)
            and np.array_equal(kept.flags, signal.flags)
            and np.array_equal(kept.switch, signal.switch)
        )
        recorded = f"; recorded source: {subject.excerpt_source}" if signal is subject.excerpt else ""
        good, bad = f"{signal.samples} samples, bit for bit{recorded}", f"'{name}' holds other numbers: export again"
        checks.append(Check(claim, "passed" if same else "failed", good if same else bad))
    return checks


def _read_signal(folder: Path, name: str, inputs: int) -> Signal:
    try:
        return from_csv((folder / name).read_text(encoding="utf-8"), inputs, name)
    except (OSError, UnicodeDecodeError) as fault:
        raise OutputError(f"'{folder / name}' cannot be read ({fault}). Export again.") from None
