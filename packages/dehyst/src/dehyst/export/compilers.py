"""Finds the C compilers of this computer, and runs `make check` of an exported folder with each."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType

from dehyst.export._targets import Check

COMPILERS = ("cc", "gcc", "clang")
# -O0 computes what stands there, -O2 what an optimizer makes of it: both must give the same bits.
LEVELS = ("-O0", "-O2")
PATIENCE = 300  # seconds for one build and run


def found(names: Sequence[str] = COMPILERS) -> dict[str, str]:
    """Return name -> first line of its version, of each compiler on the path; an alias of another one only once."""
    compilers: dict[str, str] = {}
    programs: set[Path] = set()
    # From the end on: gcc rather than cc, if both are the same.
    for name in reversed(names):
        path = shutil.which(name)
        if path is None or Path(path).resolve() in programs:
            continue
        programs.add(Path(path).resolve())
        compilers[name] = version_of(path)
    return dict(reversed(compilers.items()))


def version_of(compiler: str) -> str:
    """Return the first line that a compiler says of itself."""
    try:
        printed = subprocess.run(
            [compiler, "--version"], capture_output=True, text=True, timeout=30, check=False
        ).stdout
    except (OSError, subprocess.TimeoutExpired):
        return "?"
    return printed.partition("\n")[0].strip() or "?"


def check_folder(folder: Path) -> list[Check]:
    """Run `make check` with every compiler at every level; objects go into a temporary folder."""
    compilers = found()
    make = shutil.which("make")
    if not compilers or make is None:
        missing = "compiler (cc, gcc or clang)" if not compilers else "make"
        why = f"there is no {missing} on this machine; on Debian: apt-get install gcc make"
        return [Check("the sources compile and give the model's answers", "skipped", why)]
    checks = []
    for name, version in compilers.items():
        for level in LEVELS:
            checks.append(_check_with(folder, make, name, version, level))
    return checks


def _check_with(folder: Path, make: str, compiler: str, version: str, level: str) -> Check:
    claim = f"make check with {compiler} {level}"
    with tempfile.TemporaryDirectory(prefix="dehyst-") as build:
        settings = ["check", f"CC={compiler}", f"CFLAGS={level}", f"BUILD={build}"]
        # Without -f make would take a GNUmakefile first, which somebody may have put beside it.
        command = [make, "-s", "-C", str(folder), "-f", "Makefile", *settings]
        run = run_program(command, folder)
    if run is None:
        return Check(claim, "failed", f"not finished after {PATIENCE} s")
    lines = [line.strip() for line in run.stdout.splitlines() if line.strip()]
    fault = first_failure(lines, run.stderr.splitlines())
    for line in lines:
        if "not bit-equal" in line:
            fault = fault or line
    if run.returncode or fault:
        return Check(claim, "failed", fault or f"exit status {run.returncode}")
    # A program that ends early and says nothing must not pass, so claims are counted.
    due = claims_due(folder)
    passed = ends = 0
    for line in lines:
        passed += line.endswith(" ok")
        ends += "all checks passed" in line
    if (passed, ends) != due or due[0] == 0:
        why = f"its programs said ok {passed} times and 'all checks passed' {ends} times, due are {due[0]} and {due[1]}"
        return Check(claim, "failed", why)
    return Check(claim, "passed", f"{passed} claims; {version}", ran=True)


# All that make and compilers are told of the environment: where tools, their libraries and temporary files are.
KEPT = (
    "PATH", "HOME", "TMPDIR", "TMP", "TEMP", "LD_LIBRARY_PATH", "DYLD_LIBRARY_PATH", "DEVELOPER_DIR", "SDKROOT",
    "SYSTEMROOT", "COMSPEC", "PATHEXT",
)  # fmt: skip


def plain_environment() -> dict[str, str]:
    """Return an environment in which make and compilers do what they are told, and say so in English."""
    return {key: os.environ[key] for key in KEPT if key in os.environ} | {"LC_ALL": "C"}


def run_program(
    command: Sequence[str], folder: Path, more: Mapping[str, str] = MappingProxyType({})
) -> subprocess.CompletedProcess[str] | None:
    """Return what a command does in a folder, in the plain environment and `more`; None if it does not end."""
    try:
        return subprocess.run(
            command, cwd=folder, capture_output=True, text=True, errors="replace", timeout=PATIENCE, check=False,
            env={**plain_environment(), **more},
        )  # fmt: skip
    except subprocess.TimeoutExpired:
        return None


def first_failure(lines: Sequence[str], errors: Sequence[str]) -> str:
    """Return the first thing that went wrong in one run, "" if nothing: what follows from it is left out."""
    for k, line in enumerate(lines):
        if "FAILED" in line:
            # The line before may show what was expected.
            if k and "expected" in lines[k - 1]:
                return f"{line} ({lines[k - 1]})"
            return line
    for line in errors:
        if "error" in line.lower() or "undefined" in line:
            return line.strip()
    return ""


def claims_due(folder: Path) -> tuple[int, int]:
    """Return how often the check programs of a folder say ok, and how many end with "all checks passed"."""
    claims = ends = 0
    defined = "".join(_text(path) for path in folder.glob("check/*.h"))
    for path in (*folder.glob("check/**/*.c"), *folder.glob("examples/*/*.ino")):
        program = _GUARDED.sub(
            lambda part: part[2] if f"#define {part[1]}" in defined else "", _text(path)
        )
        claims += len(_CLAIM.findall(program))
        ends += "all checks passed" in program
    return claims, ends


# Claims about a log stand between these, and are due only where the export has one.
_GUARDED = re.compile(r"^#ifdef (EXPECTED_\w+)\n(.*?)^#endif", re.MULTILINE | re.DOTALL)
_CLAIM = re.compile(r"""\b(?:report|run)\("|\bprintf\("[^"%]* %s\\n", \w+ \? "FAILED" : "ok"\);""")


def _text(path: Path) -> str:
    return path.read_text(encoding="utf-8", errors="replace")
