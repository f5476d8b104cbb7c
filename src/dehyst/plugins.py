"""What other installed packages add to dehyst, by entry points; a package that is missing is named with what to type.

Groups: ``dehyst.commands`` (of the command line), ``dehyst.targets`` (of `dehyst export`), ``dehyst.controllers`` (what
is exported beside models) and ``dehyst.families`` (of `dehyst compare`). A stranger's package is found in the same way.
"""

from __future__ import annotations

from functools import cache
from importlib.metadata import EntryPoint, entry_points
from types import MappingProxyType

# What dehyst's own packages add, so that what is not installed can be named.
PACKAGES = MappingProxyType(
    {
        "dehyst-robot": ("reproduce", "muscle", "rig", "sweep", "joint-controller"),
        "dehyst-targets": ("fmu2", "fmu3", "st", "simulink", "rust", "ada", "arduino"),
        "dehyst-studio": ("studio", "page", "watch"),
    }
)


PACKAGE_COMMANDS = ("reproduce", "muscle", "rig", "sweep", "studio", "page", "watch")


@cache
def added(group: str) -> dict[str, EntryPoint]:
    """Return what installed packages add to a group, by name.

    Examples
    --------
    >>> "no-such-command" in added("dehyst.commands")
    False
    """
    return {point.name: point for point in entry_points(group=group)}


def package_of(name: str) -> str:
    """Return the package of dehyst that has a command, target or kind of this name; "" if none has.

    Examples
    --------
    >>> package_of("rust")
    'dehyst-targets'
    """
    for package, names in PACKAGES.items():
        if name in names:
            return package
    return ""
