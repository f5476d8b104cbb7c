"""Shared libraries of an FMU, from its sources, by the compilers that are there."""

from __future__ import annotations

import platform
import shutil
import subprocess
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from dehyst.errors import OutputError
from dehyst.export.compilers import plain_environment
from dehyst.export.fmu.description import Version

OPTIONS = ("-std=c99", "-O2", "-ffp-contract=off", "-fvisibility=hidden", "-shared")
TIMEOUT_S = 120


@dataclass(frozen=True)
class Target:
    """A platform that binaries can be made for.

    Attributes
    ----------
    name
        For messages.
    folders
        Below binaries/: FMI 2.0's name of the platform, FMI 3.0's name.
    suffix
        Of the library.
    compilers
        Commands to try, the first that is found is used.
    options
        Of this platform alone.
    """

    name: str
    folders: tuple[str, str]
    suffix: str
    compilers: tuple[str, ...]
    options: tuple[str, ...] = ()


LINUX = Target("linux64", ("linux64", "x86_64-linux"), ".so", ("cc", "gcc", "clang"), ("-fPIC",))
WINDOWS = Target(
    "win64",
    ("win64", "x86_64-windows"),
    ".dll",
    ("x86_64-w64-mingw32-gcc",),
    ("-static-libgcc", "-Wl,--no-insert-timestamp"),
)
TARGETS = (LINUX, WINDOWS)


@dataclass(frozen=True)
class Binaries:
    """What was compiled: path below the FMU -> bytes; and what was not, with the reason."""

    files: dict[str, bytes]
    missing: tuple[str, ...]


def compile_binaries(name: str, sources: Mapping[str, bytes], version: Version) -> Binaries:
    """Compile the FMU for every platform that a compiler is found for.

    Raises
    ------
    OutputError
        If a compiler is there and fails: what it says is in the message.
    """
    found: dict[str, bytes] = {}
    missing = []
    for target in TARGETS:
        compiler = _compiler(target)
        if compiler is None:
            missing.append(f"{target.name}: no {' or '.join(target.compilers)} for it on this machine")
            continue
        path = f"binaries/{target.folders[version - 2]}/{name}{target.suffix}"
        found[path] = _compiled(compiler, target, sources, name + target.suffix)
    return Binaries(found, tuple(missing))


def _compiler(target: Target) -> str | None:
    if target is LINUX and (platform.system(), platform.machine()) != ("Linux", "x86_64"):
        return None
    return next(filter(None, map(shutil.which, target.compilers)), None)


def _compiled(compiler: str, target: Target, sources: Mapping[str, bytes], library: str) -> bytes:
    with tempfile.TemporaryDirectory() as folder:
        for path, content in sources.items():
            file = Path(folder) / path
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_bytes(content)
        done = subprocess.run(
            [compiler, *OPTIONS, *target.options, "all.c", "-o", library],
            cwd=folder,
            capture_output=True,
            text=True,
            timeout=TIMEOUT_S,
            check=False,
            env=plain_environment() | {"SOURCE_DATE_EPOCH": "0"},
        )
        if done.returncode:
            raise OutputError(
                f"{compiler} cannot compile the FMU for {target.name}: {done.stderr.strip()[:400]}. Check that this "
                f"compiler compiles at all, or take it off the PATH: the FMU then has no binary for {target.name}.",
                target=target.name,
            )
        return (Path(folder) / library).read_bytes()
