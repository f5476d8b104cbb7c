"""Target ``simulink``: a Level-2 C MEX S-function, and instructions for a C Function block."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from dehyst.export import Check, Subject, c
from dehyst.export import kit as export_kit

# Type of the S-function's signals, and what MATLAB calls it.
_TYPES = {"double": ("SS_DOUBLE", "double"), "float": ("SS_SINGLE", "single")}


def _files(subject: Subject) -> dict[str, str | bytes]:
    """Return sources, S-function, scripts for MATLAB, and a check that needs none."""
    name = subject.name
    sources = c.source_files(subject)
    values = c.template_values(subject) | _simulink_values(subject)

    def text_of(template: str) -> str:
        return export_kit.render(f"simulink/{template}.j2", **values)

    sources[f"src/{name}_simulink.h"] = text_of("adaptor.h")
    sources[f"src/{name}_simulink.c"] = text_of("adaptor.c")
    # The scripts below list every source, the adaptor too.
    values["sources"] = c.names_ending(sources, ".c")
    values["headers"] = c.names_ending(sources, ".h")
    companions = c.companions(subject)
    return {
        **sources,
        f"sfun_{name}.c": text_of("sfun.c"),
        f"build_{name}.m": text_of("build.m"),
        f"check_{name}.m": text_of("check.m"),
        f"settings_{name}.m": text_of("settings.m"),
        "check/check.c": companions["check/check.c"],
        "check/expected.h": companions["check/expected.h"],
        "check/test_signal.hex": export_kit.to_hex(subject.test),
        "check/stand_in/simstruc.h": export_kit.plain_template("simulink/simstruc.h"),
        "check/stand_in/simulink.c": text_of("simulink.c"),
        "Makefile": text_of("Makefile"),
        "README.md": c.with_warning(text_of("README.md"), subject),
    }


def _simulink_values(subject: Subject) -> dict[str, Any]:
    """Return what templates of this target are filled with, beside the values of C templates."""
    inputs, outputs = subject.test.inputs.shape[1], subject.test.outputs.shape[1]
    simulink_type, matlab_type = _TYPES[subject.real]
    return {
        "joint": subject.block is None,
        "memory": memory_words(subject),
        "type": simulink_type,
        "matlab_type": matlab_type,
        "implementation": False,
        "inputs": inputs,
        # Of the file of the test signal: switch and flags stand beside inputs and outputs.
        "columns": inputs + outputs + 2,
    }


def memory_words(subject: Subject) -> int:
    """Return the words that hold a unit's state on any processor, with one to say that it runs."""
    # 64 bytes more hold wider pointers and gaps between members.
    return 1 + (export_kit.budget(subject).state_bytes + 64) // 4


def _verify(folder: Path, subject: Subject) -> list[Check]:
    """Compile and run C code and S-function with every compiler found; MATLAB's part is the user's."""
    claim = f"check_{subject.name} in MATLAB"
    return [
        *export_kit.check_folder(folder),
        Check(claim, "skipped", "dehyst has no MATLAB: run it there, once for each release"),
    ]


WRITER = export_kit.Writer(_files, _verify)
