"""What other installed packages add to dehyst, by entry points; a package that is missing is named with what to type.

Groups: ``dehyst.commands`` (of the command line), ``dehyst.targets`` (of `dehyst export`), ``dehyst.controllers`` (what
is exported beside models), ``dehyst.designs`` (of `dehyst design`) and ``dehyst.families`` (of `dehyst identify` and
`dehyst compare`). A package of anybody else is found in the same way.
"""

from __future__ import annotations

from functools import cache
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from dehyst.errors import ParameterError

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

# What dehyst's other packages add, so that what is not installed can be named: commands, in the order of `--help`.
COMMANDS = MappingProxyType(
    {
        "reproduce": "dehyst-robot",
        "muscle": "dehyst-robot",
        "rig": "dehyst-robot",
        "sweep": "dehyst-robot",
        "backlash": "dehyst-targets",
        "valve": "dehyst-targets",
        "studio": "dehyst-studio",
        "page": "dehyst-studio",
        "watch": "dehyst-studio",
    }
)
# Targets of `dehyst export`, and what it exports besides models.
EXPORTS = MappingProxyType(
    {
        "fmu2": "dehyst-targets",
        "fmu3": "dehyst-targets",
        "st": "dehyst-targets",
        "simulink": "dehyst-targets",
        "rust": "dehyst-targets",
        "ada": "dehyst-targets",
        "arduino": "dehyst-targets",
        "joint-controller": "dehyst-robot",
    }
)


@cache
def added(group: str) -> dict[str, EntryPoint]:
    """Return what installed packages add to a group, by name.

    Examples
    --------
    >>> "no-such-command" in added("dehyst.commands")
    False
    """
    from importlib.metadata import entry_points  # takes longer than everything else here

    return {point.name: point for point in entry_points(group=group)}


def load_added(group: str, name: str) -> Any:
    """Return the object that an installed package adds to a group under this name.

    Raises
    ------
    KeyError
        If no package adds it.
    ParameterError
        If its package is broken; the message names the package.
    """
    point = added(group)[name]
    try:
        return point.load()
    except Exception as fault:
        package = point.dist.name if point.dist else point.value
        raise ParameterError(
            f"'{name}' cannot be loaded: its package {package} says '{point.value}' "
            f"({type(fault).__name__}: {fault}). Install {package} again, or tell its author.",
            name=name,
        ) from fault
