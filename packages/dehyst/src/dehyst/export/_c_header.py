"""Target ``c-header``: the whole export in one header; one source file defines NAME_IMPLEMENTATION before it.

Types are those of the core and shared by all such headers of a program; functions of the core get the unit's name in
front, and so do the names that are local to a source file: two headers, from whatever versions, do not collide.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from pathlib import Path

from dehyst.export import core_files
from dehyst.export._extra import extra_files
from dehyst.export._rendering import render
from dehyst.export._subject import Subject
from dehyst.export._targets import Check, Writer
from dehyst.export.c import companions, template_values, unit_files, with_warning
from dehyst.export.compilers import check_folder
from dehyst.export.precision import BYTES
from dehyst.version import RELEASE

_INCLUDE = re.compile(r"(?m)^#include .*\n")
_SYSTEM = re.compile(r"(?m)^#include (<\w+\.h>)$")
_PROTOTYPE = re.compile(
    r"(?m)^(?!typedef|static|enum|struct|extern)[a-z][\w \t*]*?\b(dehyst_\w+)\([^;{}]*?\);\n"
)
_COMMENTED = re.compile(r"(?m)^(/\*(?:(?!\*/)[\s\S])*\*/\n)(?=PROTOTYPE)|PROTOTYPE\n")
_LOCAL = re.compile(
    r"(?m)^static [\w \t*]*?\b(\w+)(?:\(|\[| =)|^typedef (?:union|struct|enum) (\w+)|^[ \t]*#[ \t]*define (\w+)"
)
_GUARD = re.compile(r"(?s)\A(.*?)#ifndef DEHYST_H\n#define DEHYST_H\n(.*)#endif\n\Z")
_LINKAGE = re.compile(r'(?ms)^#ifdef __cplusplus\n(?:extern "C" \{|\})\n#endif\n\n?')


def _files(subject: Subject) -> dict[str, str | bytes]:
    """Return the header with example, check, Makefile, CMakeLists.txt and README."""
    build = {
        "name": subject.name,
        "include": ".",
        "rules": [],
        "headers": f"{subject.name}.h",
        "objects": "",
    }
    values = template_values(subject)
    made = {f"{subject.name}.h": header(subject), **companions(subject, implementation=True)}
    return {
        **made,
        **extra_files(
            subject, made, {**core_files.core_files(), **unit_files(subject)}, {**values, **build}
        ),
        "Makefile": render("c/Makefile.j2", **build),
        "CMakeLists.txt": render("c/CMakeLists.txt.j2", release=RELEASE, **build),
        "README.md": with_warning(render("c/README.md.j2", single=True, **values), subject),
    }


def header(subject: Subject) -> str:
    """Return the whole unit as one header."""
    core = core_files.needed(subject.functions)
    text = core["dehyst.h"]
    sources = core_files.c_sources(core)
    functions = core_files.defined(sources.values())
    # A program may include two such headers: each holds the core under names of its own.
    prefix = {function: f"{subject.name}_{function}" for function in functions}
    unit = unit_files(subject)
    bodies = []
    system = set()
    for name, body in sorted(sources.items()):
        bodies.append(renamed(body, Path(name).stem, subject.name, prefix))
        system.update(_SYSTEM.findall(body))
    # The types at the top of the header need this one, so it is included there.
    system.discard("<stdint.h>")
    bodies.append(
        renamed(unit[f"{subject.name}.c"], "unit", subject.name, prefix, keep=f"{subject.name}_")
    )
    return render(
        "c/header.h.j2",
        **template_values(subject),
        size=BYTES[subject.real],
        types=types(text),
        interface=header_interface(unit[f"{subject.name}.h"]),
        prototypes=rename("".join(prototypes(text, functions)), prefix),
        bodies=[_INCLUDE.sub("", body).strip() + "\n" for body in bodies],
        system=sorted(system),
        contract=core_files.CONTRACT,
    )


def types(text: str) -> str:
    """Return a header of the core without its functions: types, constants and macros, without guard and linkage."""
    match = _GUARD.match(text)
    body = text
    if match:
        body = match[2]
    # The header stands alone: no file of the core lies beside it to be included.
    body = _LINKAGE.sub("", _INCLUDE.sub("", body))
    body = _COMMENTED.sub("", _PROTOTYPE.sub("PROTOTYPE\n", body))
    return re.sub(r"\n{3,}", "\n\n", body).strip() + "\n"


def prototypes(text: str, functions: Iterable[str]) -> list[str]:
    """Return the declarations of functions as they stand in a header of the core."""
    names = set(functions)
    return [match[0] for match in _PROTOTYPE.finditer(text) if match[1] in names]


def header_interface(text: str) -> str:
    """Return the declarations of the unit's own header, without guard, include and linkage."""
    return _LINKAGE.sub("", text[text.index("enum {") : text.rindex("#endif")]).strip() + "\n"


def renamed(text: str, stem: str, name: str, functions: Mapping[str, str], keep: str = "\0") -> str:
    """Return a source file in which every name of its own has the unit's name in front."""
    new_names = dict(functions)
    for groups in _LOCAL.findall(text):
        # One group matched: the name of a function or table, of a type, or of a macro.
        local = "".join(groups)
        if local.startswith(keep):
            continue
        new_name = f"{name}_{stem}_{local}"
        if local.isupper():
            new_name = new_name.upper()
        new_names[local] = new_name
    return rename(text, new_names)


def rename(text: str, names: Mapping[str, str]) -> str:
    """Return a text with whole words exchanged, but for members of structures.

    Examples
    --------
    >>> rename("move(z); s.move = 1; p->move; moved", {"move": "a_move"})
    'a_move(z); s.move = 1; p->move; moved'
    """
    if not names:
        return text
    longest_first = sorted(names, key=len, reverse=True)
    alternatives = "|".join(map(re.escape, longest_first))
    words = re.compile(rf"(?<![\w.])(?<!->)(?:{alternatives})\b")
    return words.sub(lambda match: names[match[0]], text)


def _verify(folder: Path, subject: Subject) -> list[Check]:
    """Compile the folder with every compiler found, and run its check."""
    return check_folder(folder)


WRITER = Writer(_files, _verify)
