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

from dehyst.app.requests import DoctorRequest
from dehyst.app.terminal import print_json, table, terminal
from dehyst.version import __version__

EXTRAS = {  # of dehyst -> what it is for
    "frames": "data frames of pandas, polars and Arrow",
    "excel": "spreadsheets as logs",
    "tdms": "logs of LabVIEW",
    "mdf": "logs in MDF",
    "parquet": "Parquet and Feather",
    "ros": "ROS bags and MCAP",
    "control": "models as systems of python-control",
    "scikit": "models as regressors of scikit-learn",
    "benchmarks": "logs of nonlinear_benchmarks",
    "plant": "the simulated robot: reproduce, sweep, design --joint",
    "watch": "watch: MQTT and OPC UA",
    "gym": "the robot as a Gymnasium environment",
    "dask": "sweeps on several machines",
    "studio": "studio: the page in a browser, Python behind it",
    "fmi": "FMUs for other platforms, and running FMUs in verify",
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


def run_doctor(request: DoctorRequest) -> None:
    """Print, or with --json write, a row for every package and program."""
    rows = [*_extras(), *_tools()]
    if request.json:
        print_json(
            {
                "dehyst": __version__,
                "python": platform.python_version(),
                "platform": platform.platform(),
                "parts": [dict(zip(("name", "found", "purpose", "install"), row, strict=True)) for row in rows],
            }
        )
        return
    out = terminal()
    core = "with its compiled core" if find_spec("dehyst._native") else "WITHOUT its compiled core: install it again"
    out.print(f"dehyst {__version__} {core}, Python {platform.python_version()} at {sys.executable}")
    out.print(f"{platform.platform()}\n")
    shown = [
        (name, Text(found or "missing", style="green" if found else "yellow"), purpose)
        for name, found, purpose, _ in rows
    ]
    out.print(table((Column("part", no_wrap=True), "found", "what it is for"), shown))
    missing = [install for _, found, _, install in rows if not found]
    if missing:
        out.print("\nTo have what is missing, type:")
        for install in missing:
            out.print(f"  {install}", soft_wrap=True)


def _extras() -> list[tuple[str, str, str, str]]:
    """A row an extra: its packages with their versions, "" where one is missing."""
    needed: dict[str, list[str]] = {}
    for line in requires("dehyst") or ():
        if (extra := re.search(r"extra\s*==\s*['\"](\w+)['\"]", line)) and (
            name := re.match(r"(?!dehyst)[\w.-]+", line)
        ):
            needed.setdefault(extra[1], []).append(name[0])
    return [
        (f"dehyst[{extra}]", _versions(needed.get(extra, ())), purpose, f"pip install 'dehyst[{extra}]'")
        for extra, purpose in EXTRAS.items()
    ]


def _versions(names: list[str] | tuple[str, ...]) -> str:
    try:
        return ", ".join(f"{name} {version(name)}" for name in names)
    except PackageNotFoundError:
        return ""


def _tools() -> list[tuple[str, str, str, str]]:
    return [
        (name, "yes" if shutil.which(name) else "", purpose, f"apt-get install {package}")
        for name, (purpose, package) in TOOLS.items()
    ]
