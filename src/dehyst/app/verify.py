"""dehyst verify: compile an export, run it, compare it with the model, sign it off."""

from __future__ import annotations

import json
import platform
import sys
from collections.abc import Iterable
from datetime import UTC, datetime
from pathlib import Path

from rich.table import Table
from rich.text import Text

from dehyst.app.ending import concluding
from dehyst.app.status import Status
from dehyst.app.terminal import ask_progress, terminal
from dehyst.errors import OutputError
from dehyst.export import Check, compilers
from dehyst.export.exchange import alone, repair
from dehyst.export.folder import MANIFEST, VERIFIED, exported_files
from dehyst.export.verification import Verification, verify_folder
from dehyst.files import write_atomically
from dehyst.findings import doubtful
from dehyst.version import __version__

SIGNED = "Verified by `dehyst verify`."
STYLES = {"passed": "green", "failed": "bold red", "skipped": "yellow"}


def run_verify(folder: Path, as_json: bool) -> None:
    """Check, print, write `VERIFIED` if all passed and its code ran; exit status 1 otherwise."""
    with alone(folder):
        repair(folder)
    withdraw(folder)
    with ask_progress("compiling and running", as_json):
        found = verify_folder(folder)
    if found.good:
        write_atomically(folder / VERIFIED, signed(found))
    with concluding(Status.DONE if found.good else Status.NO):
        _tell(folder, found, as_json)


def _tell(folder: Path, found: Verification, as_json: bool) -> None:
    if as_json:
        checks = [check.as_dict() for check in found.checks]
        content = {"folder": str(folder), "verified": found.good, "why_not": found.why_not, "checks": checks}
        sys.stdout.write(json.dumps({**content, "doubt": _doubt(found)}, indent=1) + "\n")
    else:
        _print(folder, found)


def withdraw(folder: Path) -> None:
    """Take away what an earlier run signed, before anything else: it is not about what is there now.

    Raises
    ------
    OutputError
        If it cannot be taken away. In a folder that is no export, a file that `verify` did not write stays.
    """
    path = folder / VERIFIED
    try:
        if path.is_file() and (exported_files(folder) is not None or _beginning(path) == SIGNED.encode("ascii")):
            path.unlink()
    except OSError as fault:
        raise OutputError(
            f"'{path}' of an earlier run cannot be taken away ({fault.strerror}), and may be wrong by now. Allow "
            f"writing in '{folder}', or verify a copy.",
            path=str(path),
        ) from None


def _beginning(path: Path) -> bytes:
    with path.open("rb") as stream:
        return stream.read(len(SIGNED))


def _doubt(found: Verification) -> str:
    """Return the verdict on the model if it was less than good: right code of a bad model is no good compensator."""
    verdict = doubtful(found.subject.provenance.get("verdict")) if found.subject else ""
    return f"the code is the model's; the model's verdict was: {verdict}" if verdict else ""


def signed(found: Verification) -> str:
    """Return the summary that is written into a folder that holds what it claims."""
    checks, unit, doubt = found.checks, found.subject, _doubt(found)
    assert unit is not None  # it is good
    passed = sum(check.status == "passed" for check in checks)
    lines = [
        SIGNED,
        "",
        f"date            {datetime.now(UTC).isoformat(timespec='seconds')}",
        f"dehyst          {__version__}; exported on {found.manifest['date']}",
        f"machine         {platform.system()} {platform.machine()}",
        *(f"compiler        {name}: {version}" for name, version in compilers.found().items()),
        f"unit            {unit.title}",
        f"model           sha256 {unit.checksum}",
        f"{MANIFEST}   sha256 {found.digest}",
        f"checks          {passed} passed, {len(checks) - passed} skipped, 0 failed",
        "",
        *(f"{check.status:8} {check.claim}{': ' + check.detail if check.detail else ''}" for check in checks),
        *(["", doubt] if doubt else []),
    ]
    return "\n".join(lines) + "\n"


def _print(folder: Path, found: Verification) -> None:
    out, checks = terminal(), found.checks
    for detail, claims in _faults(checks).items():  # full width, and a cause once however many compilers found it
        out.print(Text.assemble(("failed ", STYLES["failed"]), f"{', '.join(claims)}\n  {detail}"), soft_wrap=True)
    table = Table(box=None, pad_edge=False)
    for name in ("", "claim", "detail"):
        table.add_column(name)
    for check in checks:
        if check.ok:
            table.add_row(Text(check.status, style=STYLES[check.status]), Text(check.claim), Text(check.detail))
    out.print(table)
    counts = {status: sum(check.status == status for check in checks) for status in STYLES}
    words = f"{counts['passed']} passed, {counts['failed']} failed, {counts['skipped']} skipped"
    end = f"signed off in {folder / VERIFIED}" if found.good else f"not verified: {found.why_not}"
    out.print(Text(f"\n{words}; {end}", style="bold" if found.good else "bold red"), soft_wrap=True)
    if doubt := _doubt(found):
        out.print(Text(doubt, style="bold yellow"), soft_wrap=True)


def _faults(checks: Iterable[Check]) -> dict[str, list[str]]:
    """Return what went wrong -> the claims that it broke."""
    faults: dict[str, list[str]] = {}
    for check in checks:
        if not check.ok:
            faults.setdefault(check.detail, []).append(check.claim)
    return faults
