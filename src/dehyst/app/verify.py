"""dehyst verify: compiles an export, runs it, compares it with the model, and records the result."""

from __future__ import annotations

import platform
from collections.abc import Iterable
from datetime import UTC, datetime
from pathlib import Path

from rich.text import Text

from dehyst.app.ending import Status, concluding
from dehyst.app.requests import VerifyRequest
from dehyst.app.targets import beginning
from dehyst.app.terminal import ask_progress, print_json, table, terminal
from dehyst.errors import OutputError
from dehyst.export import Check, compilers
from dehyst.export.exchange import alone, repair
from dehyst.export.folder import MANIFEST, VERIFIED, exported_files
from dehyst.export.verification import Verification, verify_folder
from dehyst.files import write_atomically
from dehyst.findings import doubtful
from dehyst.shell import visible
from dehyst.version import __version__

SIGNED = "Verified by `dehyst verify`."
STYLES = {"passed": "green", "failed": "bold red", "skipped": "yellow"}


def run_verify(request: VerifyRequest) -> None:
    """Check, print, write `VERIFIED` if all passed and its code ran; exit status 1 otherwise."""
    folder = request.folder
    with alone(folder):
        repair(folder)
    _withdraw(folder)
    with ask_progress("compiling and running", request.json):
        found = verify_folder(folder)
    if found.good:
        write_atomically(folder / VERIFIED, _signed(found))
    with concluding(Status.DONE if found.good else Status.NO):
        if request.json:
            checks = [check.as_dict() for check in found.checks]
            said = {"folder": str(folder), "verified": found.good, "why_not": found.why_not, "checks": checks}
            print_json({**said, "doubt": _doubt(found)})
        else:
            _print(folder, found)


def _withdraw(folder: Path) -> None:
    """Take away what an earlier run signed, before anything else: it is not about what is there now.

    Raises
    ------
    OutputError
        If it cannot be taken away. In a folder that is no export, a file that `verify` did not write stays.
    """
    path = folder / VERIFIED
    try:
        if path.is_file() and (exported_files(folder) is not None or beginning(path, len(SIGNED)) == SIGNED):
            path.unlink()
    except OSError as fault:
        raise OutputError(
            f"'{path}' of an earlier run cannot be taken away ({fault.strerror}), and may be wrong by now. Allow "
            f"writing in '{folder}', or verify a copy.",
            path=str(path),
        ) from None


def _doubt(found: Verification) -> str:
    """Return the verdict on the model if it was less than good: right code of a bad model is no good compensator."""
    verdict = doubtful(found.subject.provenance.get("verdict")) if found.subject else ""
    return f"the code is the model's; the model's verdict was: {verdict}" if verdict else ""


def _signed(found: Verification) -> str:
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
    return "".join(f"{visible(line)}\n" for line in lines)


def _print(folder: Path, found: Verification) -> None:
    out, checks = terminal(), found.checks
    for detail, claims in _faults(checks).items():  # full width, and a cause once however many compilers found it
        out.print(Text.assemble(("failed ", STYLES["failed"]), f"{', '.join(claims)}\n  {detail}"), soft_wrap=True)
    rows = [(Text(check.status, style=STYLES[check.status]), check.claim, check.detail) for check in checks if check.ok]
    out.print(table(("", "claim", "detail"), rows))
    counts = {status: sum(check.status == status for check in checks) for status in STYLES}
    words = f"{counts['passed']} passed, {counts['failed']} failed, {counts['skipped']} skipped"
    end = f"signed off in {folder / VERIFIED}" if found.good else f"not verified: {found.why_not}"
    out.print(f"\n{words}; {end}", style="bold" if found.good else "bold red", soft_wrap=True)
    if doubt := _doubt(found):
        out.print(doubt, style="bold yellow", soft_wrap=True)


def _faults(checks: Iterable[Check]) -> dict[str, list[str]]:
    """Return what went wrong -> the claims that it broke."""
    faults: dict[str, list[str]] = {}
    for check in checks:
        if not check.ok:
            faults.setdefault(check.detail, []).append(check.claim)
    return faults
