"""Target ``simulink``: a Level-2 C MEX S-function, and instructions for a C Function block."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from dehyst.export import c, core_files
from dehyst.export.budget import budget
from dehyst.export.compilers import check_folder
from dehyst.export.rendering import TEMPLATES, render
from dehyst.export.signal import to_hex
from dehyst.export.subject import Subject
from dehyst.export.targets import Check


def files(subject: Subject) -> dict[str, str | bytes]:
    """Return sources, S-function, scripts for MATLAB, and a check that needs none."""
    name = subject.name
    core = core_files.needed(subject.numbers.functions)
    sources: dict[str, str | bytes] = {f"src/{file}": text for file, text in core.items()}
    sources |= {f"src/{file}": text for file, text in c.unit_files(subject).items()}
    values = c.template_values(subject) | template_values(subject)
    sources[f"src/{name}_simulink.h"] = render("simulink/adaptor.h.j2", **values)
    sources[f"src/{name}_simulink.c"] = render("simulink/adaptor.c.j2", **values)
    values["sources"] = sorted(file for file in sources if file.endswith(".c"))
    values["headers"] = sorted(file for file in sources if file.endswith(".h"))
    companions = c.companions(subject)
    return {
        **sources,
        f"sfun_{name}.c": render("simulink/sfun.c.j2", **values),
        f"build_{name}.m": render("simulink/build.m.j2", **values),
        f"check_{name}.m": render("simulink/check.m.j2", **values),
        f"settings_{name}.m": render("simulink/settings.m.j2", **values),
        "check/check.c": companions["check/check.c"],
        "check/expected.h": companions["check/expected.h"],
        "check/test_signal.hex": to_hex(subject.test),
        "check/stand_in/simstruc.h": (TEMPLATES / "simulink" / "simstruc.h").read_text(encoding="utf-8"),
        "check/stand_in/simulink.c": render("simulink/simulink.c.j2", **values),
        "Makefile": render("simulink/Makefile.j2", **values),
        "README.md": c.with_warning(render("simulink/README.md.j2", **values), subject),
    }


def template_values(subject: Subject) -> dict[str, Any]:
    """Return what templates of this target are filled with, beside the values of C templates."""
    inputs, outputs = subject.test.inputs.shape[1], subject.test.outputs.shape[1]
    block = subject.block
    return {
        "joint": block is None,
        "memory": memory_words(subject),
        "type": "SS_DOUBLE" if subject.real == "double" else "SS_SINGLE",
        "matlab_type": "double" if subject.real == "double" else "single",
        "implementation": False,
        "inputs": inputs,
        "columns": inputs + outputs + 2,
    }


def memory_words(subject: Subject) -> int:
    """Return the words that hold a unit's state on any processor, with one to say that it runs."""
    return 1 + (budget(subject).state_bytes + 64) // 4  # wider pointers, gaps between members


def verify(folder: Path, subject: Subject) -> list[Check]:
    """Compile and run C code and S-function with every compiler found; MATLAB's part is the user's."""
    claim = f"check_{subject.name} in MATLAB"
    return [*check_folder(folder), Check(claim, "skipped", "dehyst has no MATLAB: run it there, once for each release")]
