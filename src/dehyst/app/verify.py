"""dehyst verify: compile an export, run it, compare it with the model, sign it off."""

from __future__ import annotations

import hashlib
import json
import platform
import sys
from contextlib import suppress
from datetime import UTC, datetime
from pathlib import Path

from rich.table import Table
from rich.text import Text

from dehyst import __version__
from dehyst.app.terminal import ask_progress, terminal
from dehyst.export import Check, read_manifest, verify
from dehyst.export.compilers import found
from dehyst.export.folder import MANIFEST, VERIFIED
from dehyst.files import write_atomically

STYLES = {"passed": "green", "failed": "bold red", "skipped": "yellow"}


def run_verify(folder: Path, as_json: bool) -> None:
    """Check, print, write `VERIFIED` if all passed; exit status 1 otherwise."""
    manifest = read_manifest(folder)
    with suppress(FileNotFoundError):  # what an earlier run signed is not what is there now
        (folder / VERIFIED).unlink()
    with ask_progress("compiling and running", as_json):
        checks = verify(folder)
    good = all(check.ok for check in checks) and any(check.status == "passed" for check in checks)
    if good:
        write_atomically(folder / VERIFIED, signed(folder, manifest, checks))
    if as_json:
        content = {"folder": str(folder), "verified": good, "checks": [check.as_dict() for check in checks]}
        sys.stdout.write(json.dumps(content, indent=1) + "\n")
    else:
        _print(folder, checks, good)
    if not good:
        sys.exit(1)


def signed(folder: Path, manifest: dict[str, object], checks: list[Check]) -> str:
    """Return the summary that is written into a folder that holds what it claims."""
    digest = hashlib.sha256((folder / MANIFEST).read_bytes()).hexdigest()
    passed = sum(check.status == "passed" for check in checks)
    lines = [
        "Verified by `dehyst verify`.",
        "",
        f"date            {datetime.now(UTC).isoformat(timespec='seconds')}",
        f"dehyst          {__version__}; exported with {manifest['dehyst']} on {manifest['date']}",
        f"machine         {platform.system()} {platform.machine()}",
        *(f"compiler        {name}: {version}" for name, version in found().items()),
        f"unit            {manifest['title']}",
        f"model           sha256 {manifest['model_sha256']}",
        f"{MANIFEST}   sha256 {digest}",
        f"checks          {passed} passed, {len(checks) - passed} skipped, 0 failed",
        "",
        *(f"{check.status:8} {check.claim}{': ' + check.detail if check.detail else ''}" for check in checks),
    ]
    return "\n".join(lines) + "\n"


def _print(folder: Path, checks: list[Check], good: bool) -> None:
    out = terminal()
    table = Table(box=None, pad_edge=False)
    for name in ("", "claim", "detail"):
        table.add_column(name)
    for check in checks:
        table.add_row(Text(check.status, style=STYLES[check.status]), Text(check.claim), Text(check.detail))
    out.print(table)
    counts = {status: sum(check.status == status for check in checks) for status in STYLES}
    words = f"{counts['passed']} passed, {counts['failed']} failed, {counts['skipped']} skipped"
    end = f"signed off in {folder / VERIFIED}" if good else "not verified: do not use this export"
    out.print(Text(f"\n{words}; {end}", style="bold" if good else "bold red"), soft_wrap=True)
