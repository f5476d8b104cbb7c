"""Sources of an FMU: the core as it is, the unit's header, and the wrapper of FMI, brought together in one all.c."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass

from dehyst.export.fmu.description import Version
from dehyst.export.fmu.variables import Variable, constants, count
from dehyst.export.rendering import TEMPLATES, render
from dehyst.version import __version__

_FUNCTION = re.compile(r"(?m)^[a-z][\w \t*]*?\b(dehyst_\w+)\(")
_LOCAL = re.compile(r"(?m)^static [\w \t*]*?\b(\w+)(?:\(|\[| =)|^typedef (?:union|struct|enum) (\w+)|^\} (\w+);")
_MACRO = re.compile(r"(?m)^[ \t]*#[ \t]*define (\w+)")


@dataclass(frozen=True)
class Unit:
    """What is inside an FMU.

    Attributes
    ----------
    name
        C identifier.
    title
        One line about it.
    part
        Template of its type and functions, below templates/fmu.
    values
        For this template.
    core
        File name -> text of all C sources and headers that it needs, those of the core as they are.
    variables
        By value reference.
    period
        Of the samples, None if every communication step is one. [s]
    """

    name: str
    title: str
    part: str
    values: Mapping[str, object]
    core: Mapping[str, str]
    variables: tuple[Variable, ...]
    period: float | None


def sources(unit: Unit, version: Version, token: str, content: int) -> dict[str, bytes]:
    """Return the files below sources/: all.c is to be compiled, it includes all others."""
    head = render(
        "fmu/unit_head.h.j2",
        title=unit.title,
        version=__version__,
        name=unit.name,
        token=token,
        content=content,
        period=hexadecimal(unit.period or 0.0),
        counts={kind: max(count(unit.variables, kind), 1) for kind in ("real", "whole", "truth")},
        variables=unit.variables,
        constants=[hexadecimal(value) for value in constants(unit.variables)] or ["0"],
    )
    texts = {f"core/{name}": text for name, text in unit.core.items()}
    texts["unit.h"] = head + render(unit.part, name=unit.name, **unit.values)
    for name in ("fmu.h", f"fmi{version}.h", f"fmi{version}.c"):
        texts[name] = (TEMPLATES / "fmu" / name).read_text(encoding="utf-8")
    texts["all.c"] = render(
        "fmu/all.c.j2", fmi=version, name=unit.name, functions=functions(unit.core), core=included(unit.core)
    )
    return {path: text.encode() for path, text in sorted(texts.items())}


def functions(core: Mapping[str, str]) -> list[str]:
    """Names of the core's functions, renamed in each FMU so that several can be linked into one program."""
    headers = (text for name, text in core.items() if name.endswith(".h"))
    return sorted({name for text in headers for name in _FUNCTION.findall(text)})


def included(core: Mapping[str, str]) -> list[dict[str, object]]:
    """Source files in order, each with the names of its own that another file has too: they are kept apart."""
    files = {name: text for name, text in sorted(core.items()) if name.endswith(".c")}
    local = {name: {a or b or c for a, b, c in _LOCAL.findall(text)} for name, text in files.items()}
    macros = {name: set(_MACRO.findall(text)) for name, text in files.items()}
    often = Counter(name for names in local.values() for name in names)
    return [
        {
            "name": name,
            "stem": re.sub(r"\W", "_", name.removesuffix(".c")),
            "local": sorted(n for n in local[name] if often[n] > 1),
            "macros": sorted(macros[name]),
        }
        for name in files
    ]


def hexadecimal(value: float) -> str:
    """C constant that is this double, to the bit."""
    return float(value).hex()
