"""Table of export targets: name and the module that writes and verifies it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from types import MappingProxyType
from typing import Literal, Protocol, cast

from dehyst.errors import ParameterError
from dehyst.export.subject import Subject
from dehyst.plugins import added, package_of

BLOCKS = ("inverse", "forward", "direct-inverse")
GROUP = "dehyst.targets"


Status = Literal["passed", "failed", "skipped"]


@dataclass(frozen=True)
class Check:
    """One claim about an export, and whether it holds.

    Attributes
    ----------
    claim
        What is claimed, one line.
    status
        "passed", "failed", or "skipped" with the reason in `detail`.
    detail
        Numbers, or why it failed or was skipped.
    ran
        Whether code of the export was compiled and run for it.

    Examples
    --------
    >>> Check("outputs have the bits of the model", "passed", "1400 samples").ok
    True
    """

    claim: str
    status: Status
    detail: str = ""
    ran: bool = False

    @property
    def ok(self) -> bool:
        """Whether nothing speaks against the claim: a skipped one is not a failed one."""
        return self.status != "failed"

    def as_dict(self) -> dict[str, str]:
        """Return ``{"claim": ..., "status": ..., "detail": ...}``."""
        return {"claim": self.claim, "status": self.status, "detail": self.detail}


class TargetModule(Protocol):
    """What the module of a target offers."""

    def files(self, subject: Subject) -> dict[str, str | bytes]:
        """Return relative path -> content of everything that belongs to the target alone."""
        ...

    def verify(self, folder: Path, subject: Subject) -> list[Check]:
        """Compile, run and compare an exported folder; `subject` is made anew from the model in it."""
        ...


@dataclass(frozen=True)
class Target:
    """One target.

    Attributes
    ----------
    name
        As typed after ``--target``.
    summary
        One line for help and errors.
    module
        That has `files` and `verify`.
    whats, reals
        What it can hold; others are refused by name.
    """

    name: str
    summary: str
    module: str
    whats: tuple[str, ...] = (*BLOCKS, "joint-controller")
    reals: tuple[str, ...] = ("double", "float")

    @property
    def present(self) -> bool:
        """Whether this dehyst has it."""
        return find_spec(self.module) is not None

    def load(self) -> TargetModule:
        """Return its module."""
        return cast(TargetModule, import_module(self.module))


TARGETS: Mapping[str, Target] = MappingProxyType(
    {
        target.name: target
        for target in (
            Target("c", "C sources with example, check, Makefile and CMakeLists.txt", "dehyst.export.c"),
            Target("c-header", "one C header that holds all of it", "dehyst.export.c_header"),
            Target("fmu2", "FMU for co-simulation, FMI 2.0", "dehyst.export.fmu2"),
            Target("fmu3", "FMU for co-simulation, FMI 3.0", "dehyst.export.fmu3"),
            Target("st", "Structured Text function block and PLCopen XML", "dehyst.export.st", BLOCKS),
            Target("simulink", "Simulink: C Function block recipe and S-function", "dehyst.export.simulink"),
            Target("rust", "Rust crate without std around the C sources", "dehyst.export.rust"),
            Target("ada", "Ada package with contracts around the C sources", "dehyst.export.ada"),
            Target("arduino", "Arduino library", "dehyst.export.arduino", BLOCKS, ("float",)),
        )
        if target.present
    }
)


def target(name: str) -> Target:
    """Return the target of that name.

    Raises
    ------
    ParameterError
        If there is none.

    Examples
    --------
    >>> target("c").module
    'dehyst.export.c'
    """
    if name in TARGETS:
        return TARGETS[name]
    known = targets()
    if name in known:
        return known[name]
    listed = "; ".join(f"{entry.name} ({entry.summary})" for entry in known.values())
    package = package_of(name)
    cure = f" {name} is part of {package}, which is not installed: pip install {package}." if package else ""
    raise ParameterError(f"--target {name!r:.40} is unknown. There are: {listed}.{cure}", target=name)


def targets() -> dict[str, Target]:
    """Return all targets by name: dehyst's own, and those of packages with an entry point in ``dehyst.targets``.

    Such an entry point leads to a `Target`, whose module may be any that is installed.

    Examples
    --------
    >>> "c" in targets()
    True
    """
    return {**TARGETS, **{name: cast(Target, point.load()) for name, point in added(GROUP).items()}}
