"""What `dehyst verify` does for every target; each target adds its own checks."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from dehyst.control.storage import load_controller
from dehyst.errors import DehystError, OutputError
from dehyst.export.checks import Check
from dehyst.export.folder import BUILD, MANIFEST, VERIFIED, read_manifest
from dehyst.export.joint import joint_subject
from dehyst.export.signal import Signal, from_csv, same_bits
from dehyst.export.subject import Subject, subject_of
from dehyst.export.targets import target
from dehyst.models import load_model


def verify_folder(folder: Path) -> list[Check]:
    """Return all checks of an export folder, those of its target last."""
    manifest = read_manifest(folder)
    checks = file_checks(folder, manifest)
    try:
        subject = subject_again(folder, manifest)
        checks += expectation_checks(folder, subject)
    except DehystError as fault:
        return [*checks, Check("the model can be read, and its unit made again", "failed", str(fault))]
    return [*checks, *target(str(manifest["target"])).load().verify(folder, subject, manifest)]


def file_checks(folder: Path, manifest: Mapping[str, Any]) -> list[Check]:
    """Compare every file with its checksum; files that were edited, lost or added are named."""
    edited, missing = [], []
    for name, expected in manifest["files"].items():
        path = folder / name
        if not path.is_file():
            missing.append(name)
        elif hashlib.sha256(path.read_bytes()).hexdigest() != expected:
            edited.append(name)
    added = [
        name
        for path in sorted(folder.rglob("*"))
        if path.is_file()
        and (name := path.relative_to(folder).as_posix()) not in manifest["files"]
        and name not in (MANIFEST, VERIFIED)
        and not name.startswith(f"{BUILD}/")
    ]
    claim = "files are as they were written"
    words = [
        f"{what}: {', '.join(names[:5])}{' and more' if len(names) > 5 else ''}"
        for what, names in (("edited", edited), ("missing", missing))
        if names
    ]
    if words:
        return [Check(claim, "failed", "; ".join(words) + "; export again, and change a copy")]
    more = f"; beside them {', '.join(added[:3])}{' and more' if len(added) > 3 else ''}" if added else ""
    return [Check(claim, "passed", f"{len(manifest['files'])} files, sha256{more}")]


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
        model = load_model(folder / "model.json")
        return joint_subject(model, parameters, name=str(settings["name"]), real=str(settings["real"]))
    excerpt = _read_signal(folder, "expected/excerpt.csv", 1) if manifest.get("excerpt_source") else None
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


def expectation_checks(folder: Path, subject: Subject) -> list[Check]:
    """Compare the expected answers in the folder with those of the model in it, computed again."""
    checks = []
    for label, name, signal in (
        ("test signal", "expected/test_signal.csv", subject.test),
        ("excerpt of your log", "expected/excerpt.csv", subject.excerpt),
    ):
        if signal is None and subject.joint is not None:
            continue  # a log of one column says nothing about a controller
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
        detail = f"{signal.samples} samples, bit for bit" if same else f"'{name}' holds other numbers: export again"
        checks.append(Check(claim, "passed" if same else "failed", detail))
    return checks


def _read_signal(folder: Path, name: str, inputs: int) -> Signal:
    try:
        return from_csv((folder / name).read_text(encoding="utf-8"), inputs, name)
    except (OSError, UnicodeDecodeError) as fault:
        raise OutputError(f"'{folder / name}' cannot be read ({fault}). Export again.") from None
