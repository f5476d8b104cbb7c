"""dehyst verify: compiles an export, runs it, compares it with the model, and records the result."""

from __future__ import annotations

import platform
from collections import Counter
from collections.abc import Iterable
from datetime import UTC, datetime
from pathlib import Path

from rich.text import Text

from dehyst.app._ending import Status, concluding
from dehyst.app._targets import beginning
from dehyst.app._terminal import ask_progress, print_json, table, terminal
from dehyst.app.requests import VerifyRequest
from dehyst.errors import OutputError
from dehyst.export import Check, compilers
from dehyst.export import kit as export_kit
from dehyst.files import write_atomically
from dehyst.findings import doubt_in
from dehyst.shell import visible
from dehyst.version import __version__

SIGNED = "Verified by `dehyst verify`."
STYLES = {"passed": "green", "failed": "bold red", "skipped": "yellow"}


def run_verify(request: VerifyRequest) -> None:
    """Check, print, write `VERIFIED` if all passed and its code ran; exit status 1 otherwise."""
    folder = request.folder
    with export_kit.alone(folder):
        # An export that was interrupted while it moved its files is finished first.
        export_kit.repair(folder)
    # The old signature goes before the checks: a run that is interrupted must not leave it.
    _withdraw(folder)
    with ask_progress("compiling and running", request.json):
        verification = export_kit.verify_folder(folder)
    if verification.good:
        write_atomically(folder / export_kit.VERIFIED, _signed(verification))
    with concluding(Status.DONE if verification.good else Status.NO):
        if request.json:
            checks = [check.as_dict() for check in verification.checks]
            words = {
                "folder": str(folder),
                "verified": verification.good,
                "why_not": verification.why_not,
                "checks": checks,
            }
            print_json({**words, "doubt": _doubt(verification)})
        else:
            _print(folder, verification)


def _withdraw(folder: Path) -> None:
    """Take away what an earlier run signed, before anything else: it is not about what is there now.

    Raises
    ------
    OutputError
        If it cannot be taken away. In a folder that is no export, a file that `verify` did not write stays.
    """
    path = folder / export_kit.VERIFIED
    try:
        if path.is_file() and (
            export_kit.exported_files(folder) is not None or beginning(path, len(SIGNED)) == SIGNED
        ):
            path.unlink()
    except OSError as fault:
        raise OutputError(
            f"'{path}' of an earlier run cannot be taken away ({fault.strerror}), and may be wrong by now. Allow "
            f"writing in '{folder}', or verify a copy.",
            path=str(path),
        ) from None


def _doubt(verification: export_kit.Verification) -> str:
    """Return the verdict on the model if it was less than good: right code of a bad model is no good compensator."""
    if not verification.subject:
        return ""
    verdict = doubt_in(verification.subject.provenance)
    if not verdict:
        return ""
    return f"the code is the model's; the model's verdict was: {verdict}"


def _signed(verification: export_kit.Verification) -> str:
    """Return the summary that is written into a folder that holds what it claims."""
    checks, manifest = verification.checks, verification.manifest
    passed = _counts(checks)["passed"]
    lines = [
        SIGNED,
        "",
        f"date            {datetime.now(UTC).isoformat(timespec='seconds')}",
        f"dehyst          {__version__}; exported on {manifest['date']}",
        f"machine         {platform.system()} {platform.machine()}",
    ]
    for name, version in compilers.found().items():
        lines.append(f"compiler        {name}: {version}")
    lines += [
        f"unit            {manifest['title']}",
        f"model           sha256 {manifest['model_sha256']}",
        f"{export_kit.MANIFEST}   sha256 {verification.digest}",
        f"checks          {passed} passed, {len(checks) - passed} skipped, 0 failed",
        "",
    ]
    for check in checks:
        line = f"{check.status:8} {check.claim}"
        if check.detail:
            line += f": {check.detail}"
        lines.append(line)
    doubt = _doubt(verification)
    if doubt:
        lines += ["", doubt]
    # Names in it may come from strangers' files: nothing of them moves the cursor.
    return "\n".join([*map(visible, lines), ""])


def _counts(checks: Iterable[Check]) -> Counter[str]:
    """How many checks passed, failed and were skipped."""
    return Counter(check.status for check in checks)


def _print(folder: Path, verification: export_kit.Verification) -> None:
    """Print faults, then a table of the other checks, then the end of it all."""
    out, checks = terminal(), verification.checks
    # In full width, and a cause once however many compilers met it.
    for detail, claims in _faults(checks).items():
        fault = f"{', '.join(claims)}\n  {detail}"
        out.print(Text.assemble(("failed ", STYLES["failed"]), fault), soft_wrap=True)
    rows = []
    for check in checks:
        if check.ok:
            status = Text(check.status, style=STYLES[check.status])
            rows.append((status, check.claim, check.detail))
    out.print(table(("", "claim", "detail"), rows))
    counts = _counts(checks)
    words = f"{counts['passed']} passed, {counts['failed']} failed, {counts['skipped']} skipped"
    end, style = f"not verified: {verification.why_not}", "bold red"
    if verification.good:
        end, style = f"signed off in {folder / export_kit.VERIFIED}", "bold"
    out.print(f"\n{words}; {end}", style=style, soft_wrap=True)
    doubt = _doubt(verification)
    if doubt:
        out.print(doubt, style="bold yellow", soft_wrap=True)


def _faults(checks: Iterable[Check]) -> dict[str, list[str]]:
    """Return what went wrong -> the claims that it broke."""
    faults: dict[str, list[str]] = {}
    for check in checks:
        if not check.ok:
            faults.setdefault(check.detail, []).append(check.claim)
    return faults
