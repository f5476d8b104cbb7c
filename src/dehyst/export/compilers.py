"""Host compilers: which there are, and `make check` of an exported folder with each."""

from __future__ import annotations

import os
import shutil
import subprocess
import tempfile
from collections.abc import Sequence
from pathlib import Path

from dehyst.export.checks import Check

COMPILERS = ("cc", "gcc", "clang")
LEVELS = ("-O0", "-O2")
PATIENCE = 300  # seconds for one build and run


def found(names: Sequence[str] = COMPILERS) -> dict[str, str]:
    """Return name -> first line of its version, of each compiler on the path; an alias of another one only once."""
    compilers: dict[str, str] = {}
    seen: set[str] = set()
    for name in reversed(names):  # gcc rather than cc, if both are the same
        path = shutil.which(name)
        if path is None or str(Path(path).resolve()) in seen:
            continue
        seen.add(str(Path(path).resolve()))
        compilers[name] = version_of(path)
    return dict(reversed(compilers.items()))


def version_of(compiler: str) -> str:
    """Return the first line that a compiler says of itself."""
    try:
        said = subprocess.run([compiler, "--version"], capture_output=True, text=True, timeout=30, check=False).stdout
    except (OSError, subprocess.TimeoutExpired):
        return "?"
    return said.partition("\n")[0].strip() or "?"


def check_folder(folder: Path) -> list[Check]:
    """Run `make check` with every compiler at every level; objects go into a temporary folder."""
    compilers = found()
    make = shutil.which("make")
    if not compilers or make is None:
        missing = "compiler (cc, gcc or clang)" if not compilers else "make"
        why = f"there is no {missing} on this machine; on Debian: apt-get install gcc make"
        return [Check("the sources compile and give the model's answers", "skipped", why)]
    return [_one(folder, make, name, version, level) for name, version in compilers.items() for level in LEVELS]


def _one(folder: Path, make: str, compiler: str, version: str, level: str) -> Check:
    claim = f"make check with {compiler} {level}"
    with tempfile.TemporaryDirectory(prefix="dehyst-") as build:
        command = [make, "-s", "-C", str(folder), "check", f"CC={compiler}", f"CFLAGS={level}", f"BUILD={build}"]
        plain = {key: value for key, value in os.environ.items() if key not in ("MAKEFLAGS", "MFLAGS", "MAKELEVEL")}
        try:
            run = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE, check=False, env=plain)
        except subprocess.TimeoutExpired:
            return Check(claim, "failed", f"not finished after {PATIENCE} s")
    lines = [line for line in run.stdout.splitlines() if line.strip()]
    if run.returncode == 0:
        return Check(claim, "passed", f"{sum(line.endswith(' ok') for line in lines)} claims; {version}")
    wrong = [line for line in lines if "FAILED" in line or "expected" in line] + run.stderr.splitlines()
    return Check(claim, "failed", "; ".join(line.strip() for line in wrong[:4]) or f"exit status {run.returncode}")
