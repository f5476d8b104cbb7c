"""The source files of the C core, and which of them an exported unit needs."""

from __future__ import annotations

import re
from collections.abc import Iterable
from functools import cache
from pathlib import Path

from dehyst.errors import OutputError

CONFIG = "dehyst_config.h"
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
    paths = [path for path in sorted(place().iterdir()) if path.suffix in (".c", ".h") and path.name != CONFIG]
    return {path.name: path.read_text(encoding="utf-8") for path in paths}


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
    sources = {name: text for name, text in files.items() if name.endswith(".c")}
    home = {function: name for name, text in sources.items() for function in _DEFINED.findall(text)}
    found: set[str] = set()
    open_ = {home[function] for function in functions}
    while open_:
        name = open_.pop()
        found.add(name)
        open_ |= {home[other] for other in _NAMED.findall(sources[name]) if other in home} - found
    return {name: text for name, text in files.items() if name.endswith(".h") or name in found}


def defined(sources: Iterable[str]) -> list[str]:
    """Return the names of the functions that sources of the core define for others."""
    return sorted({function for text in sources for function in _DEFINED.findall(text)})


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
    functions = defined(text for name, text in core_files().items() if name.endswith(".c"))
    own = "".join(f"#define {name} {name}_float\n" for name in functions)
    choose = (
        "#ifndef DEHYST_FLOAT\n#define DEHYST_FLOAT\n#endif\n\n"
        f"/* Names of their own: a unit in double may be in the same program. */\n{own}"
    )
    choice = refuse if real == "double" else choose
    return (
        "/* SPDX-License-Identifier: 0BSD */\n"
        f"/* The choice of this export: {real} precision. */\n"
        f"#ifndef DEHYST_CONFIG_H\n#define DEHYST_CONFIG_H\n\n{CONTRACT}\n{choice}\n#endif\n"
    )
