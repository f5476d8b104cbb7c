"""Writes the .fmu file and the files beside it in the exported folder."""

from __future__ import annotations

import hashlib
import io
import uuid
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from html import escape

from dehyst.export import Subject, UnitNumbers, core_files
from dehyst.export import kit as export_kit
from dehyst.shell import visible
from dehyst.version import __version__
from dehyst_targets.fmu._description import (
    Description,
    Variable,
    Version,
    build_description,
    model_description,
    placed,
)
from dehyst_targets.fmu._interface import BEYOND, fmu_interface, start_input, tuned
from dehyst_targets.fmu._sources import (
    Binaries,
    FmuUnit,
    compile_binaries,
    fmu_sources,
    hexadecimal,
)
from dehyst_targets.fmu._terminals import PICTURE, picture, terminals

# Communication step of the examples where the unit has no period: times add up without rounding. [s]
STEP = 2.0**-10
# A zip archive cannot hold an earlier date. All files have this one, so that equal exports are equal bytes.
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
            # The upper half holds the rights of Unix: some systems load only libraries that may be executed.
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
    variables = placed(fmu_interface(subject), arrays=version == 3)
    unit = FmuUnit(
        subject.name, subject.title, *_part(subject, variables), core=_core(subject), variables=variables,
        period=subject.period, single=single_of(subject, version),
    )  # fmt: skip
    # The token stands in the sources and is their checksum, so they are written twice: first without it.
    digest = hashlib.sha256()
    for path, content in fmu_sources(unit, version, "", 0).items():
        digest.update(path.encode() + b"\0" + content + b"\0")
    token = f"{{{uuid.UUID(bytes=digest.digest()[:16])}}}"
    # Other bytes of the checksum mark the images of a state: a restore refuses those of another export.
    texts = fmu_sources(unit, version, token, int.from_bytes(digest.digest()[-4:], "big"))
    binaries = compile_binaries(subject.name, texts, version)
    files = {f"sources/{path}": content for path, content in texts.items()} | binaries.files
    if version == 3:
        files["sources/buildDescription.xml"] = build_description(subject.name)
        files["terminalsAndIcons/terminalsAndIcons.xml"] = terminals(variables)
        files["terminalsAndIcons/icon.svg"] = PICTURE.encode()
    # Each version of FMI looks for the icon in a place of its own.
    icon = {2: "model.png", 3: "terminalsAndIcons/icon.png"}[version]
    files[icon] = picture()
    files["modelDescription.xml"] = model_description(
        _description(subject, token, variables, version), version
    )
    files["documentation/index.html"] = _page(subject, variables).encode()
    files["documentation/licenses/license.txt"] = (export_kit.TEMPLATES / "LICENSE").read_bytes()
    return Package(subject, version, variables, token, texts, binaries, archive(files))


def single_of(subject: Subject, version: Version) -> bool:
    """Whether real variables but time are of type Float32: FMI 2.0 has doubles only."""
    return version == 3 and subject.real == "float"


def step_of(subject: Subject) -> float:
    """Communication step of examples and checks. [s]"""
    return subject.period or STEP


def _core(subject: Subject) -> dict[str, str]:
    """Return the C sources of the unit; one with parameters gets its tunable numbers in each step."""
    with_tuning = tuned(subject)
    functions = list(subject.numbers.functions)
    if with_tuning:
        functions += export_kit.TUNING
    return core_files.needed(functions) | export_kit.unit_files(subject, with_tuning)


def _part(subject: Subject, variables: tuple[Variable, ...]) -> tuple[str, dict[str, object]]:
    """Template of what is inside, and its values."""
    words = f"{subject.name.upper()}_IMAGE_WORDS"
    starts_of, states = [], False
    for variable in variables:
        if variable.role == "parameter":
            starts_of.append(hexadecimal(variable.start[0]))
        elif variable.role == "local":
            states = True
    if subject.block:
        start_inputs = (start_input(subject.block), *subject.middle[1:])
        starts = {
            "start_output": hexadecimal(subject.start_output),
            "starts": list(map(hexadecimal, start_inputs)),
        }
        # A unit that shows no states may have none.
        memory = ""
        if states:
            memory = subject.block.memory[0][1]
        common = {
            "words": words,
            "beyond": BEYOND[subject.real],
            "b": subject.block,
            "states": memory,
        }
        return "fmu/unit_block.h.j2", {
            **common,
            **starts,
            "parameters": starts_of,
            "rule": _rule(subject.block),
        }
    controller = subject.controller
    assert controller is not None  # a subject without block has one
    inputs = [hexadecimal(quantity.values[0]) for quantity in controller.inputs]
    bits = {
        "switches": list(controller.switch_bits.values()),
        "flags": list(controller.flag_bits.values()),
    }
    memory = ""
    if states:
        memory = "z"
    common = {"words": words, "states": memory, "parameters": ()}
    return "fmu/unit_joint.h.j2", {**common, "inputs": len(inputs), "starts": inputs, **bits}


def _rule(block: UnitNumbers) -> str:
    """What parameters can be, for messages: the condition of c/tunable.j2."""
    return (
        "parameters are finite numbers, output_scale and fade above 0, fade at most 1, and "
        f"{block.output_low:.9g} <= output_low <= output_high <= {block.output_high:.9g}"
    )


def _description(
    subject: Subject, token: str, variables: tuple[Variable, ...], version: Version
) -> Description:
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
    rows = ""
    for v in variables:
        # A model has hundreds of constants: they would hide the rest.
        if v.role != "constant":
            cells = (escape(v.name), v.role, escape(visible(v.unit)), escape(v.description))
            rows += f"<tr><td>{'</td><td>'.join(cells)}</td></tr>\n"
    sample = "Every communication step is one sample, however long it is."
    if subject.period:
        sample = f"A communication step is a whole number of periods of {subject.period!r} s."
    return (
        f'<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8"><title>{escape(subject.name)}</title></head>\n'
        f"<body><h1>{escape(subject.name)}</h1>\n<p>{escape(subject.title)}.</p>\n<p>{sample} Leaving initialization "
        f"mode sets the state to that of the start.</p>\n<table>\n{rows}</table>\n</body></html>\n"
    )
