"""The source files of the C core, and which of them an exported unit needs."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from functools import cache
from pathlib import Path

from dehyst.errors import OutputError

CONFIG = "dehyst_config.h"
# A definition begins at the margin and has a body; what is static stays inside its file.
_DEFINED = re.compile(r"(?m)^(?!static\b)[a-z][\w \t*]*?\b(dehyst_\w+)\([^;{]*\)\s*\{")
_NAMED = re.compile(r"\bdehyst_\w+")
_HERE = Path(__file__).resolve()
_PLACES = (_HERE.parents[1] / "core_sources", _HERE.parents[3] / "core")  # installed; a checkout


@cache
def core_files() -> dict[str, str]:
    """Return file name -> text of the core's sources and headers, without `CONFIG`: each export has its own.

    Examples
    --------
    >>> "dehyst.h" in core_files()
    True
    """
    texts = {}
    for path in sorted(place().iterdir()):
        if path.suffix in (".c", ".h") and path.name != CONFIG:
            texts[path.name] = path.read_text(encoding="utf-8")
    return texts


def place() -> Path:
    """Return the folder of the core."""
    for folder in _PLACES:
        if (folder / "dehyst.h").is_file():
            return folder
    raise OutputError(
        "the sources of the core are not in this installation of dehyst, so there is nothing to export. Install it "
        "again: pip install --force-reinstall dehyst"
    )


def needed(functions: Iterable[str]) -> dict[str, str]:
    """Return the headers, and the sources that functions of the core need, directly or through others.

    Examples
    --------
    >>> sorted(needed(["dehyst_map_value"]))
    ['dehyst.h', 'map.c']
    """
    files = core_files()
    sources = c_sources(files)
    home = {}
    for name, text in sources.items():
        for function in _DEFINED.findall(text):
            home[function] = name
    needed_sources: set[str] = set()
    to_read = {home[function] for function in functions}
    while to_read:
        name = to_read.pop()
        needed_sources.add(name)
        for function in _NAMED.findall(sources[name]):
            # Types and constants of the core have no source file.
            if function in home and home[function] not in needed_sources:
                to_read.add(home[function])
    return {
        name: text for name, text in files.items() if name.endswith(".h") or name in needed_sources
    }


def c_sources(files: Mapping[str, str]) -> dict[str, str]:
    """Return those of the files that are compiled: no headers."""
    return {name: text for name, text in files.items() if name.endswith(".c")}


def defined(sources: Iterable[str]) -> list[str]:
    """Return the names of the functions that sources of the core define for others."""
    functions: set[str] = set()
    for text in sources:
        functions.update(_DEFINED.findall(text))
    return sorted(functions)


# Bits are those of separate multiplications and additions.
CONTRACT = """/* No fused multiply-add: other last digits. gcc knows no such pragma and needs -ffp-contract=off. */
#if defined(_MSC_VER) && !defined(__clang__)
#pragma fp_contract(off)
#elif defined(__clang__) || !defined(__GNUC__)
#pragma STDC FP_CONTRACT OFF
#endif
"""


def config(real: str) -> str:
    """Return the text of `CONFIG` for "double" or "float".

    In float the functions of the core get names of their own, so that units of both precisions link into one program.
    """
    refuse = (
        '#ifdef DEHYST_FLOAT\n#error "this export is in double precision: export with --real float"\n#endif\n\n'
        "#include <float.h>\n\n#if DBL_MANT_DIG < 53\n"
        '#error "double has fewer than 53 bits on this processor (AVR): export with --real float"\n#endif\n'
    )
    functions = defined(c_sources(core_files()).values())
    renamed = "".join(f"#define {name} {name}_float\n" for name in functions)
    choose = (
        "#ifndef DEHYST_FLOAT\n#define DEHYST_FLOAT\n#endif\n\n"
        f"/* Names of their own: a unit in double may be in the same program. */\n{renamed}"
    )
    choice = choose
    if real == "double":
        choice = refuse
    return (
        "/* SPDX-License-Identifier: 0BSD */\n"
        f"/* The choice of this export: {real} precision. */\n"
        f"#ifndef DEHYST_CONFIG_H\n#define DEHYST_CONFIG_H\n\n{CONTRACT}\n{choice}\n#endif\n"
    )
