"""Writes the .fmu file and the files beside it in the exported folder."""

from __future__ import annotations

import hashlib
import io
import uuid
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from html import escape

from dehyst.control.joint import FLAGS, SWITCHES
from dehyst.export import core_files
from dehyst.export.c import unit_files
from dehyst.export.fmu.description import Description, Variable, Version, build_description, model_description, placed
from dehyst.export.fmu.interface import BEYOND, interface, joint_starts, start_input
from dehyst.export.fmu.sources import Binaries, Unit, compile_binaries, hexadecimal, sources
from dehyst.export.rendering import TEMPLATES
from dehyst.export.subject import Subject
from dehyst.version import __version__

STEP = 2.0**-10  # communication step of the examples where the unit has no period: times add up without rounding [s]


_DATE = (1980, 1, 1, 0, 0, 0)


def archive(files: Mapping[str, bytes]) -> bytes:
    """Return the zip archive of files, path -> content; no date and no owner is in it.

    Examples
    --------
    >>> archive({"a": b"x"}) == archive({"a": b"x"})
    True
    """
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w") as packed:
        for path in sorted(files, key=lambda p: (p != "modelDescription.xml", p)):
            info = zipfile.ZipInfo(path, _DATE)
            info.compress_type = zipfile.ZIP_DEFLATED
            info.external_attr = (0o755 if path.startswith("binaries/") else 0o644) << 16
            packed.writestr(info, files[path])
    return out.getvalue()


@dataclass(frozen=True)
class Package:
    """An FMU and its parts.

    Attributes
    ----------
    subject
        What is inside.
    version
        Of FMI.
    variables
        By value reference.
    token
        GUID or instantiation token: changes with anything that is in the sources.
    sources
        Path below sources/ -> content.
    binaries
        What was compiled, and what was not.
    fmu
        Bytes of the .fmu file.
    """

    subject: Subject
    version: Version
    variables: tuple[Variable, ...]
    token: str
    sources: dict[str, bytes]
    binaries: Binaries
    fmu: bytes


def package(subject: Subject, version: Version) -> Package:
    """Write the sources, compile them where a compiler is found, and put the FMU together."""
    variables = placed(interface(subject), arrays=version == 3)
    unit = Unit(
        subject.name, subject.title, *_part(subject), core=_core(subject), variables=variables, period=subject.period
    )
    digest = hashlib.sha256()
    for path, content in sources(unit, version, "", 0).items():
        digest.update(path.encode() + b"\0" + content + b"\0")
    token = f"{{{uuid.UUID(bytes=digest.digest()[:16])}}}"
    texts = sources(unit, version, token, int.from_bytes(digest.digest()[-4:], "big"))
    binaries = compile_binaries(subject.name, texts, version)
    files = {f"sources/{path}": content for path, content in texts.items()} | binaries.files
    if version == 3:
        files["sources/buildDescription.xml"] = build_description(subject.name)
    files["modelDescription.xml"] = model_description(_description(subject, token, variables), version)
    files["documentation/index.html"] = _page(subject, variables).encode()
    files["documentation/licenses/license.txt"] = (TEMPLATES / "LICENSE").read_bytes()
    return Package(subject, version, variables, token, texts, binaries, archive(files))


def step_of(subject: Subject) -> float:
    """Communication step of examples and checks. [s]"""
    return subject.period or STEP


def _core(subject: Subject) -> dict[str, str]:
    core = core_files.needed(subject.numbers.functions)
    return core | unit_files(subject)


def _part(subject: Subject) -> tuple[str, dict[str, object]]:
    """Template of what is inside, and its values."""
    words = f"{subject.name.upper()}_IMAGE_WORDS"
    if subject.block:
        starts = {
            "start_output": hexadecimal(subject.start_output),
            "starts": [hexadecimal(value) for value in (start_input(subject.block), *subject.middle[1:])],
        }
        return "fmu/unit_block.h.j2", {"words": words, "beyond": BEYOND[subject.real], "b": subject.block, **starts}
    assert subject.parameters is not None  # a joint controller has them
    inputs = [hexadecimal(value) for value in joint_starts(subject.parameters).values()]
    bits = {"switches": list(SWITCHES.values()), "flags": list(FLAGS.values())}
    return "fmu/unit_joint.h.j2", {"words": words, "inputs": len(inputs), "starts": inputs, **bits}


def _description(subject: Subject, token: str, variables: tuple[Variable, ...]) -> Description:
    step = step_of(subject)
    return Description(
        name=subject.name,
        token=token,
        text=subject.title,
        tool=f"dehyst {__version__}",
        variables=variables,
        period=subject.period,
        step=step,
        end=step * subject.test.samples,
    )


def _page(subject: Subject, variables: tuple[Variable, ...]) -> str:
    """Documentation inside the FMU: what it is and what its variables mean."""
    rows = "".join(
        f"<tr><td>{escape(v.name)}</td><td>{v.role}</td><td>{escape(v.unit)}</td><td>{escape(v.description)}</td></tr>\n"
        for v in variables
        if v.role != "constant"
    )
    sample = (
        f"A communication step is a whole number of periods of {subject.period!r} s."
        if subject.period
        else "Every communication step is one sample, however long it is."
    )
    return (
        f'<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8"><title>{escape(subject.name)}</title></head>\n'
        f"<body><h1>{escape(subject.name)}</h1>\n<p>{escape(subject.title)}.</p>\n<p>{sample} Leaving initialization "
        f"mode sets the state to that of the start.</p>\n<table>\n{rows}</table>\n</body></html>\n"
    )
