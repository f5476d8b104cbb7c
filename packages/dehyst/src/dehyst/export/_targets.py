"""Table of export targets: name and the module that writes and verifies it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Literal, TypeAlias, cast

from dehyst.errors import ParameterError
from dehyst.plugins import EXPORTS, added, load_added

if TYPE_CHECKING:
    from dehyst.export._subject import Subject

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


Files: TypeAlias = "Callable[[Subject], dict[str, str | bytes]]"
Verify: TypeAlias = "Callable[[Path, Subject], list[Check]]"


@dataclass(frozen=True)
class Writer:
    """How a target is written and verified: the module of a target ends with one of these, called ``WRITER``.

    Attributes
    ----------
    files
        Subject -> relative path and content of every file that belongs to the target alone.
    verify
        Folder and subject -> checks: compiles, runs and compares what was exported. The subject is made anew from the
        model in the folder.
    check_own_name
        Refuses a name of the user's own that the target cannot take, where there are such names.
    """

    files: Files
    verify: Verify
    check_own_name: Callable[[Subject], None] | None = None


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
        That ends with its `Writer`, ``WRITER``.
    whats, reals
        What it can hold; others are refused by name.
    retains
        Whether its memory outlives a power cycle by itself.
    tunable
        Whether its numbers can be changed through a calibration file.
    """

    name: str
    summary: str
    module: str
    whats: tuple[str, ...] = (*BLOCKS, "joint-controller")
    reals: tuple[str, ...] = ("double", "float")
    retains: bool = False
    tunable: bool = False

    def load(self) -> Writer:
        """Return the writer of its module, which is imported only now.

        Raises
        ------
        ParameterError
            If the module cannot be imported, or holds no ``WRITER``.
        """
        try:
            return cast(Writer, import_module(self.module).WRITER)
        except ModuleNotFoundError:
            # The command line names the package that is missing.
            raise
        except (ImportError, AttributeError, SyntaxError) as fault:
            raise ParameterError(
                f"target '{self.name}' cannot be loaded: its module '{self.module}' says {type(fault).__name__}: "
                f"{fault}. Install the package that holds it again, or tell its author.",
                name=self.name,
            ) from fault


_C = Target(
    "c",
    "C sources with example, check, Makefile and CMakeLists.txt",
    "dehyst.export.c",
    tunable=True,
)
_C_HEADER = Target(
    "c-header",
    "one C header that holds all of it",
    "dehyst.export._c_header",
    tunable=True,
)
# Targets of this package; other packages add theirs by an entry point.
TARGETS: Mapping[str, Target] = MappingProxyType({_C.name: _C, _C_HEADER.name: _C_HEADER})


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
    if name in added(GROUP):
        return cast(Target, load_added(GROUP, name))
    listed = "; ".join(f"{entry.name} ({entry.summary})" for entry in targets().values())
    # The targets of other packages of dehyst are known even where they are not installed.
    package = EXPORTS.get(name, "")
    cure = ""
    if package:
        cure = f" {name} is part of {package}, which is not installed: pip install {package}."
    raise ParameterError(
        f"--target {name!r:.40} is unknown. There are: {listed}.{cure}", target=name
    )


def targets() -> dict[str, Target]:
    """Return all targets by name: the kernel's, and those of packages with an entry point in ``dehyst.targets``.

    Such an entry point leads to a `Target`, whose module may be any that is installed.

    Examples
    --------
    >>> "c" in targets()
    True
    """
    available = dict(TARGETS)
    for name in added(GROUP):
        # A package that is broken must not hide the targets of the others.
        with suppress(ParameterError):
            available[name] = load_added(GROUP, name)
    return available
