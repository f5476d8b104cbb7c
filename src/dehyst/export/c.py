"""Target ``c``: sources of the core, one parameter file, an example, and a check that needs only a compiler."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from dehyst.export import core_files
from dehyst.export.budget import budget
from dehyst.export.compilers import check_folder
from dehyst.export.extra import extra_files
from dehyst.export.rendering import comment, render
from dehyst.export.subject import Subject
from dehyst.export.targets import Check
from dehyst.findings import Grade, grade_of
from dehyst.shell import visible
from dehyst.version import RELEASE, __version__

JOINT_WORDS = {"double": "bits of the controller", "float": "valves to 2e-2, the rest to 1e-4 and limits to a period"}
WORDS = {"double": "bits of the model", "float": "the model to 1e-5"}


def files(subject: Subject) -> dict[str, str | bytes]:
    """Return the files of an export folder, without those that every target has."""
    values = template_values(subject)
    core = core_files.needed(subject.functions)
    sources: dict[str, str | bytes] = {f"src/{name}": text for name, text in core.items()}
    unit = unit_files(subject)
    sources |= {f"src/{name}": text for name, text in unit.items()}
    rules = [{"stem": Path(name).stem, "source": name} for name in sorted(sources) if name.endswith(".c")]
    headers = " ".join(sorted(name for name in sources if name.endswith(".h")))
    build = {
        "name": subject.name,
        "include": "src",
        "rules": rules,
        "headers": headers,
        "objects": " ".join(f"$(BUILD)/{rule['stem']}.o" for rule in rules),
    }
    made = {**sources, **companions(subject)}
    return {
        **made,
        **extra_files(subject, made, {**core, **unit}, {**values, **build}),
        "Makefile": render("c/Makefile.j2", **build),
        "CMakeLists.txt": render("c/CMakeLists.txt.j2", release=RELEASE, **build),
        "README.md": with_warning(render("c/README.md.j2", single=False, **values), subject),
    }


def unit_files(subject: Subject, given: bool = False) -> dict[str, str]:
    """Return dehyst_config.h and ``<name>.h/.c``: what other targets that hold C sources need beside the core.

    `given`: a step is given its tunable numbers, instead of reading them from pages or having none.
    """
    kind = "unit" if subject.block else "joint"
    values = template_values(subject, given)
    return {
        core_files.CONFIG: core_files.config(subject.real),
        f"{subject.name}.h": render(f"c/{kind}.h.j2", **values),
        f"{subject.name}.c": render(f"c/{kind}.c.j2", **values),
    }


def companions(subject: Subject, implementation: bool = False) -> dict[str, str | bytes]:
    """Return example and check; `implementation` if they are to bring the unit's functions in from its header."""
    kind = "" if subject.block else "joint_"
    values = {**template_values(subject), "implementation": implementation}
    return {
        "example/main.c": render(f"c/{kind}main.c.j2", **values),
        "check/check.c": render(f"c/{kind}check.c.j2", **values),
        "check/expected.h": render(f"c/{kind}expected.h.j2", **values),
    }


def template_values(subject: Subject, given: bool = False) -> dict[str, Any]:
    """Return what the templates of C files are filled with."""
    common = {
        "version": __version__,
        "release": RELEASE,
        "name": subject.name,
        "NAME": subject.name.upper(),
        "title": subject.title,
        "real": subject.real,
        "checksum": subject.checksum,
        "provenance": provenance_lines(subject),
        "input_label": subject.input.label,
        "output_label": subject.output.label,
        "input_range": _range(subject.input.low, subject.input.high, subject.input.unit),
        "output_range": _range(subject.output.low, subject.output.high, subject.output.unit),
        "test": subject.test,
        "ranges": [float(span) or 1.0 for span in np.ptp(subject.test.outputs, axis=0)],
        "excerpt": subject.excerpt,
        "excerpt_source": subject.excerpt_source,
        "words": WORDS[subject.real],
        "same": "bits" if subject.real == "double" else "answers",
        "budget": budget(subject),
        "subject": subject,
    }
    joint, block = subject.joint, subject.block
    if joint is not None:
        return {
            **common,
            "m": joint.compensator,
            "n": joint.compensator.parts if joint.compensator else 0,
            "d": joint.direct,
            "adaptation": joint.adaptation,
            "j": joint.values,
            "fingerprint": joint.fingerprint,
            "indent": " " * len(f"void {subject.name}_step("),
            "words": JOINT_WORDS[subject.real],
        }
    assert block is not None  # one of both
    values = {**common, "b": block, "n": block.parts, "d": None, "samples": round(1 / block.fade)}
    tuned = f", const {subject.name}_tunable *tuned" if given else ""
    tuning = "given" if given else "pages" if subject.tunable else ""
    return {**values, "tuning": tuning, "tuned": tuned, "back": block.back}


def provenance_lines(subject: Subject) -> list[str]:
    """Return what is known of the model's origin, one line an entry."""
    told = sorted(subject.provenance.items())
    return [f"{key}: {value}" for key, value in told if value not in (None, "", [], {})][:20]


def with_warning(readme: str, subject: Subject) -> str:
    """Return a README that says under its title what identification thought of the model, unless it was good.

    A forward model drives nothing, and says nothing.
    """
    said = subject.provenance.get("verdict")
    grade = grade_of(said)
    if grade is None or grade is Grade.GOOD or subject.what == "forward":
        return readme
    cure = "Do not let it drive a machine." if grade is Grade.BAD else "Watch the actuator."
    line = f"**When this model was identified, the verdict was: {comment(said)} {cure}**"
    return readme.replace("\n\n", f"\n\n{line}\n\n", 1)


def _range(low: float | None, high: float | None, unit: str) -> str:
    return "nothing" if low is None or high is None else visible(f"{low:.6g} .. {high:.6g} {unit}").rstrip()


def verify(folder: Path, subject: Subject) -> list[Check]:
    """Compile the folder with every compiler found, and run its check."""
    return check_folder(folder)
