"""Bill of materials of a wheel (CycloneDX 1.6): what is linked into the extension, and what is installed beside it."""

from __future__ import annotations

import hashlib
import json
import re
import uuid
from collections.abc import Iterator, Mapping
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path
from typing import Any, NamedTuple


class Linked(NamedTuple):
    """Foreign code inside the extension: the package it comes with, its licence, and the file that holds its text."""

    name: str
    package: str
    licence: str
    text: str


LINKED = (
    Linked(
        "nanobind", "nanobind", "BSD-3-Clause", "../nanobind-{version}.dist-info/licenses/LICENSE"
    ),
    Linked("robin-map", "nanobind", "MIT", "ext/robin_map/include/tsl/robin_map.h"),
    Linked("libc++", "ziglang", "Apache-2.0 WITH LLVM-exception", "lib/libcxx/LICENSE.TXT"),
    Linked("libunwind", "ziglang", "Apache-2.0 WITH LLVM-exception", "lib/libunwind/LICENSE.TXT"),
    Linked("compiler-rt of zig", "ziglang", "MIT", "LICENSE"),
)


def linked_licences() -> Iterator[tuple[str, str]]:
    """Name of a file and the text that has to go with every copy, for each part of `LINKED`."""
    for part in LINKED:
        folder = Path(next(iter(find_spec(part.package).submodule_search_locations or ())))  # type: ignore[union-attr]
        text = (folder / part.text.format(version=version(part.package))).read_text(
            encoding="utf-8"
        )
        head = re.match(r"/\*\*(.*?)\*/", text, re.DOTALL) if part.text.endswith(".h") else None
        yield f"{part.name.replace(' ', '-')}.txt", head[1] if head else text


def bill(metadata: Mapping[str, Any], files: Mapping[str, bytes]) -> bytes:
    """Return the bill of a wheel.

    Parameters
    ----------
    metadata
        Of the wheel: name, version, and its requirements (``requires_dist``).
    files
        Compiled files in the wheel, path -> content.
    """
    name, release = metadata["name"], metadata["version"]
    package = f"pkg:pypi/{name}@{release}"
    inside = [
        {
            "type": "library", "bom-ref": part.name, "name": part.name,
            "version": version(part.package), "licenses": [{"expression": part.licence}],
            "description": f"linked into the extension, as it comes with {part.package} {version(part.package)}",
        }
        for part in LINKED
    ]  # fmt: skip
    needed = []
    for requirement in metadata["requires_dist"]:
        word = re.match(r"([\w.-]+)(\[.*?\])?([^;]*)", requirement)
        if word and "extra ==" not in requirement:
            ref = f"pkg:pypi/{word[1].lower()}"
            row = {"type": "library", "bom-ref": ref, "name": word[1], "purl": ref}
            needed.append({**row, "description": f"installed beside it: {requirement}"})
    compiled = [
        {"type": "file", "bom-ref": path, "name": path, "components": inside,
         "hashes": [{"alg": "SHA-256", "content": hashlib.sha256(content).hexdigest()}]}
        for path, content in sorted(files.items())
    ]  # fmt: skip
    serial = uuid.uuid5(
        uuid.NAMESPACE_URL, package + "".join(str(one["hashes"]) for one in compiled)
    )
    return json.dumps(
        {
            "bomFormat": "CycloneDX",
            "specVersion": "1.6",
            "serialNumber": f"urn:uuid:{serial}",
            "version": 1,
            "metadata": {
                "component": {
                    "type": "library", "bom-ref": package, "name": name, "version": release, "purl": package,
                    "licenses": [{"license": {"id": metadata["license_expression"]}}],
                }
            },
            "components": compiled + needed,
            "dependencies": [
                {"ref": package, "dependsOn": [one["bom-ref"] for one in compiled + needed]},
                *({"ref": one["bom-ref"], "dependsOn": [part.name for part in LINKED]} for one in compiled),
            ],
        },
        indent=1,
    ).encode()  # fmt: skip
