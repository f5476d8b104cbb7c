"""Writes the .fmu file and the files beside it in the exported folder."""

from __future__ import annotations

import hashlib
import io
import uuid
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from html import escape

from dehyst.export import core_files
from dehyst.export.c import unit_files
from dehyst.export.fmu.description import Description, Variable, Version, build_description, model_description, placed
from dehyst.export.fmu.interface import BEYOND, interface, start_input, tuned
from dehyst.export.fmu.sources import Binaries, Unit, compile_binaries, hexadecimal, sources
from dehyst.export.fmu.terminals import PICTURE, picture, terminals
from dehyst.export.numbers import UnitNumbers
from dehyst.export.rendering import TEMPLATES
from dehyst.export.subject import TUNING, Subject
from dehyst.shell import visible
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
        subject.name, subject.title, *_part(subject, variables), core=_core(subject), variables=variables,
        period=subject.period, single=single_of(subject, version),
    )  # fmt: skip
    digest = hashlib.sha256()
    for path, content in sources(unit, version, "", 0).items():
        digest.update(path.encode() + b"\0" + content + b"\0")
    token = f"{{{uuid.UUID(bytes=digest.digest()[:16])}}}"
    texts = sources(unit, version, token, int.from_bytes(digest.digest()[-4:], "big"))
    binaries = compile_binaries(subject.name, texts, version)
    files = {f"sources/{path}": content for path, content in texts.items()} | binaries.files
    if version == 3:
        files["sources/buildDescription.xml"] = build_description(subject.name)
        files["terminalsAndIcons/terminalsAndIcons.xml"] = terminals(variables)
        files["terminalsAndIcons/icon.svg"] = PICTURE.encode()
    files["terminalsAndIcons/icon.png" if version == 3 else "model.png"] = picture()
    files["modelDescription.xml"] = model_description(_description(subject, token, variables, version), version)
    files["documentation/index.html"] = _page(subject, variables).encode()
    files["documentation/licenses/license.txt"] = (TEMPLATES / "LICENSE").read_bytes()
    return Package(subject, version, variables, token, texts, binaries, archive(files))


def single_of(subject: Subject, version: Version) -> bool:
    """Whether real variables but time are of type Float32: FMI 2.0 has doubles only."""
    return version == 3 and subject.real == "float"


def step_of(subject: Subject) -> float:
    """Communication step of examples and checks. [s]"""
    return subject.period or STEP


def _core(subject: Subject) -> dict[str, str]:
    tuning = TUNING if tuned(subject) else ()
    return core_files.needed((*subject.numbers.functions, *tuning)) | unit_files(subject, given=tuned(subject))


def _part(subject: Subject, variables: tuple[Variable, ...]) -> tuple[str, dict[str, object]]:
    """Template of what is inside, and its values."""
    words = f"{subject.name.upper()}_IMAGE_WORDS"
    starts_of = [hexadecimal(v.start[0]) for v in variables if v.role == "parameter"]
    states = any(v.role == "local" for v in variables)
    if subject.block:
        starts = {
            "start_output": hexadecimal(subject.start_output),
            "starts": [hexadecimal(value) for value in (start_input(subject.block), *subject.middle[1:])],
        }
        memory = subject.block.memory[0][1] if states else ""
        common = {"words": words, "beyond": BEYOND[subject.real], "b": subject.block, "states": memory}
        return "fmu/unit_block.h.j2", {**common, **starts, "parameters": starts_of, "rule": _rule(subject.block)}
    controller = subject.controller
    assert controller is not None  # a subject without block has one
    inputs = [hexadecimal(quantity.values[0]) for quantity in controller.inputs]
    bits = {"switches": list(controller.switch_bits.values()), "flags": list(controller.flag_bits.values())}
    common = {"words": words, "states": "z" if states else "", "parameters": ()}
    return "fmu/unit_joint.h.j2", {**common, "inputs": len(inputs), "starts": inputs, **bits}


def _rule(block: UnitNumbers) -> str:
    """What parameters can be, for messages: the condition of c/tunable.j2."""
    return (
        "parameters are finite numbers, output_scale and fade above 0, fade at most 1, and "
        f"{block.output_low:.9g} <= output_low <= output_high <= {block.output_high:.9g}"
    )


def _description(subject: Subject, token: str, variables: tuple[Variable, ...], version: Version) -> Description:
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
        single=single_of(subject, version),
    )


def _page(subject: Subject, variables: tuple[Variable, ...]) -> str:
    """Documentation inside the FMU: what it is and what its variables mean."""
    rows = "".join(
        f"<tr><td>{escape(v.name)}</td><td>{v.role}</td><td>{escape(visible(v.unit))}</td><td>{escape(v.description)}</td></tr>\n"
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
