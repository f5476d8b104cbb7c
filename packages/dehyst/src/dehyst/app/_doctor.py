"""dehyst doctor: what is installed beside dehyst, what each of it is for, and what to type for what is missing."""

from __future__ import annotations

import platform
import re
import shutil
import sys
from importlib.metadata import PackageNotFoundError, requires, version
from importlib.util import find_spec

from rich.table import Column
from rich.text import Text

from dehyst.app._terminal import print_json, table, terminal
from dehyst.app.requests import DoctorRequest
from dehyst.plugins import added
from dehyst.version import __version__

EXTRAS = {  # of dehyst -> what it is for
    "frames": "data frames of pandas, polars and Arrow",
    "excel": "spreadsheets as logs",
    "tdms": "logs of LabVIEW",
    "hdf5": "HDF5, MAT files of version 7.3",
    "netcdf": "netCDF 3",
    "mdf": "logs in MDF",
    "parquet": "Parquet and Feather",
    "ros": "ROS bags and MCAP",
    "control": "models as systems of python-control",
    "scikit": "models as regressors of scikit-learn",
    "benchmarks": "logs of nonlinear_benchmarks",
}
PACKAGES = {  # beside the kernel -> what it is for
    "dehyst-targets": "export: FMU, Structured Text, Simulink, Rust, Ada, Arduino",
    "dehyst-targets[fmi]": "FMUs for other platforms, and running FMUs in verify",
    "dehyst-robot": "the simulated robot: reproduce, rig, sweep, muscle, design --joint",
    "dehyst-robot[gym]": "the robot as a Gymnasium environment",
    "dehyst-studio": "the page and the studio in a browser; watch",
    "dehyst-studio[watch]": "watch: MQTT and OPC UA",
}
TOOLS = {  # program -> what it is for, package of Debian
    "cc": ("export: checks of C, and FMUs", "gcc"),
    "make": ("export: checks of C", "make"),
    "clang": ("verify: a second compiler", "clang"),
    "arm-none-eabi-gcc": ("verify: Cortex-M", "gcc-arm-none-eabi libnewlib-arm-none-eabi"),
    "qemu-system-arm": ("verify: Cortex-M, run", "qemu-system-arm"),
    "avr-gcc": ("verify: Arduino", "gcc-avr avr-libc"),
    "cargo": ("verify: Rust", "cargo"),
    "gnatmake": ("verify: Ada", "gnat gprbuild"),
}


GROUPS = {  # of entry points -> what they add
    "dehyst.commands": "commands",
    "dehyst.targets": "export",
    "dehyst.controllers": "export --what",
    "dehyst.designs": "design",
    "dehyst.families": "identify and compare",
}


def run_doctor(request: DoctorRequest) -> None:
    """Print, or with --json write, a row for every package and program."""
    rows = [*_extras(), *_others(), *_tools()]
    if request.json:
        keys = ("name", "found", "purpose", "install")
        print_json(
            {
                "dehyst": __version__,
                "python": platform.python_version(),
                "platform": platform.platform(),
                "parts": [dict(zip(keys, row, strict=True)) for row in rows],
            }
        )
        return
    out = terminal()
    # Nothing can be simulated without the core, so that a broken installation is said first.
    core = "WITHOUT its compiled core: install it again"
    if find_spec("dehyst._native"):
        core = "with its compiled core"
    out.print(
        f"dehyst {__version__} {core}, Python {platform.python_version()} at {sys.executable}"
    )
    out.print(f"{platform.platform()}\n")
    shown, missing = [], []
    # What is missing is listed once more below, as lines to copy.
    for name, installed, purpose, install in rows:
        if installed:
            shown.append((name, Text(installed, style="green"), purpose))
        else:
            shown.append((name, Text("missing", style="yellow"), purpose))
            missing.append(install)
    out.print(table((Column("part", no_wrap=True), "found", "what it is for"), shown))
    if missing:
        out.print("\nTo have what is missing, type:")
        for install in missing:
            out.print(f"  {install}", soft_wrap=True)


def _extras() -> list[tuple[str, str, str, str]]:
    """A row an extra and a row a package beside the kernel, with the versions that are there."""
    rows = []
    purposes = {f"dehyst[{extra}]": purpose for extra, purpose in EXTRAS.items()} | PACKAGES
    for part, purpose in purposes.items():
        package, _, extra = part.rstrip("]").partition("[")
        names, typed = [package], part
        if extra:
            names, typed = _needs(package, extra), repr(part)  # shells read brackets
        rows.append((part, _versions(names), purpose, f"pip install {typed}"))
    return rows


def _others() -> list[tuple[str, str, str, str]]:
    """A row a package of anybody else that adds to dehyst by entry points: what it adds, under which names."""
    own = {"dehyst", *(part.partition("[")[0] for part in PACKAGES)}
    additions: dict[str, list[str]] = {}
    for group, purpose in GROUPS.items():
        names_of: dict[str, list[str]] = {}
        for name, point in added(group).items():
            if point.dist is not None and point.dist.name not in own:
                names_of.setdefault(point.dist.name, []).append(name)
        for package, names in names_of.items():
            additions.setdefault(package, []).append(f"{purpose}: {', '.join(sorted(names))}")
    rows = []
    for package, purposes in sorted(additions.items()):
        rows.append((package, _versions([package]), "; ".join(purposes), f"pip install {package}"))
    return rows


def _needs(package: str, extra: str) -> list[str]:
    """Distributions that an extra of a package asks for; the package itself where it is not there."""
    try:
        lines = requires(package) or []
    except PackageNotFoundError:
        return [package]
    names = []
    for line in lines:
        # Extras of dehyst that name other extras of it have rows of their own.
        name = re.match(r"(?!dehyst)[\w.-]+", line)
        if name and re.search(rf"extra\s*==\s*['\"]{extra}['\"]", line):
            names.append(name[0])
    return names


def _versions(names: list[str]) -> str:
    """Names of distributions with their versions; "" if one of them is missing."""
    versions = []
    for name in names:
        try:
            versions.append(f"{name} {version(name)}")
        except PackageNotFoundError:
            return ""
    return ", ".join(versions)


def _tools() -> list[tuple[str, str, str, str]]:
    """A row a program that compiles or runs what is exported."""
    rows = []
    for name, (purpose, package) in TOOLS.items():
        # Asking a program for its version would run it, which takes long and may fail.
        present = ""
        if shutil.which(name):
            present = "yes"
        rows.append((name, present, purpose, f"apt-get install {package}"))
    return rows
