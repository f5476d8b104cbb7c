"""Files of a C export beside its sources, for build systems, assessors and calibration: one table, name -> template."""

from __future__ import annotations

import hashlib
import json
import uuid
from collections.abc import Mapping
from typing import Any

from dehyst.export import core_files
from dehyst.export._calibration import calibration_values
from dehyst.export._rendering import render
from dehyst.export._requirements import required
from dehyst.export._subject import Subject

FILES = {  # name in the folder -> template below templates/extra/
    "{name}.pc": "package.pc.j2",
    "library.json": "library.json.j2",
    "dehyst.{name}.pdsc": "pack.pdsc.j2",
    "zephyr/module.yml": "module.yml.j2",
    "zephyr/CMakeLists.txt": "zephyr.cmake.j2",
    "zephyr/Kconfig": "Kconfig.j2",
    "requirements.md": "requirements.md.j2",
    "misra.md": "misra.md.j2",
    "sbom.cdx.json": "sbom.json.j2",
    "calibration/{name}.a2l": "calibration.a2l.j2",
    "calibration/addresses.py": "addresses.py.j2",
}


def extra_files(
    subject: Subject,
    made: Mapping[str, str | bytes],
    unit: Mapping[str, str],
    values: Mapping[str, Any],
) -> dict[str, str | bytes]:
    """Return the files of the table, for an export whose own files are `made`.

    `unit` are the sources of the unit and dehyst.h as they are in target c, `values` those of its templates.
    """
    sources = []
    for name, text in sorted(made.items()):
        if not name.startswith(("check/", "example/")):
            checksum = hashlib.sha256(str(text).encode("utf-8")).hexdigest()
            sources.append((name, checksum))
    # The serial number follows from the content, so that equal exports are equal files.
    digest = hashlib.sha256(repr((subject.checksum, sources)).encode("utf-8")).digest()
    filled = {
        **values,
        **calibration_values(subject, unit),
        "check": str(made["check/check.c"]),
        "requirements": required(subject),
        "deviations": deviations(core_files.needed(subject.functions)),
        "sources": sources,
        "serial": str(uuid.UUID(bytes=digest[:16], version=5)),
    }
    files: dict[str, str | bytes] = {}
    for name, file in FILES.items():
        files[name.format(name=subject.name)] = render(f"extra/{file}", **filled)
    return files


def deviations(files: Mapping[str, str]) -> list[tuple[str, int, str]]:
    """Return rule, places and reason of each deviation from MISRA C in these files of the core."""
    listed = json.loads((core_files.place() / "misra.json").read_text(encoding="utf-8"))
    rows = []
    for rule, entry in listed.items():
        places = sum(entry["files"].get(name, 0) for name in files)
        if places:
            rows.append((rule, places, entry["reason"]))
    return rows
