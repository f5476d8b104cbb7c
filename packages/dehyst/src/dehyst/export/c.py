"""Target ``c``: sources of the core, one parameter file, an example, and a check that needs only a compiler."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from dehyst.export import core_files
from dehyst.export._budget import budget
from dehyst.export._extra import extra_files
from dehyst.export._rendering import comment, render
from dehyst.export._subject import SAME_WORDS, Subject
from dehyst.export._targets import Check, Writer
from dehyst.export.compilers import check_folder
from dehyst.findings import Grade, grade_in
from dehyst.shell import visible
from dehyst.version import RELEASE, __version__

JOINT_WORDS = {
    "double": "bits of the controller",
    "float": "valves to 2e-2, the rest to 1e-4 and limits to a period",
}
WORDS = {"double": "bits of the model", "float": "the model to 1e-5"}


def _files(subject: Subject) -> dict[str, str | bytes]:
    """Return the files of an export folder, without those that every target has."""
    values = template_values(subject)
    sources = source_files(subject)
    rules = []
    objects = []
    for name in names_ending(sources, ".c"):
        stem = Path(name).stem
        rules.append({"stem": stem, "source": name})
        objects.append(f"$(BUILD)/{stem}.o")
    build = {
        "name": subject.name,
        "include": "src",
        "rules": rules,
        "headers": " ".join(names_ending(sources, ".h")),
        "objects": " ".join(objects),
    }
    code = {**sources, **companions(subject)}
    unit = {**core_files.needed(subject.functions), **unit_files(subject)}
    return {
        **code,
        **extra_files(subject, code, unit, {**values, **build}),
        "Makefile": render("c/Makefile.j2", **build),
        "CMakeLists.txt": render("c/CMakeLists.txt.j2", release=RELEASE, **build),
        "README.md": with_warning(render("c/README.md.j2", single=False, **values), subject),
    }


def source_files(subject: Subject, folder: str = "src") -> dict[str, str | bytes]:
    """Return the sources of the core that the unit needs, and those of the unit, below a folder."""
    sources = core_files.needed(subject.functions) | unit_files(subject)
    return {f"{folder}/{name}": text for name, text in sources.items()}


def names_ending(names: Iterable[str], ending: str) -> list[str]:
    """Return the names with this ending, sorted.

    Examples
    --------
    >>> names_ending(["b.c", "a.h", "a.c"], ".c")
    ['a.c', 'b.c']
    """
    return sorted(name for name in names if name.endswith(ending))


def unit_files(subject: Subject, with_tuning: bool = False) -> dict[str, str]:
    """Return dehyst_config.h and ``<name>.h/.c``: what a target with C sources needs beside the sources of the core.

    If `with_tuning`, a step takes its tunable numbers as an argument. Otherwise it reads them from pages, or has none.
    """
    kind = "joint"
    if subject.block:
        kind = "unit"
    values = template_values(subject, with_tuning)
    return {
        core_files.CONFIG: core_files.config(subject.real),
        f"{subject.name}.h": render(f"c/{kind}.h.j2", **values),
        f"{subject.name}.c": render(f"c/{kind}.c.j2", **values),
    }


def companions(subject: Subject, implementation: bool = False) -> dict[str, str | bytes]:
    """Return example and check; `implementation` if they are to bring the unit's functions in from its header."""
    kind = "joint_"
    if subject.block:
        kind = ""
    values = {**template_values(subject), "implementation": implementation}
    return {
        "example/main.c": render(f"c/{kind}main.c.j2", **values),
        "check/check.c": render(f"c/{kind}check.c.j2", **values),
        "check/expected.h": render(f"c/{kind}expected.h.j2", **values),
    }


def template_values(subject: Subject, with_tuning: bool = False) -> dict[str, Any]:
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
        # An output that stands still has no range by which an error could be judged.
        "ranges": [float(span) or 1.0 for span in np.ptp(subject.test.outputs, axis=0)],
        "excerpt": subject.excerpt,
        "excerpt_source": subject.excerpt_source,
        "words": WORDS[subject.real],
        "same": SAME_WORDS[subject.real],
        "budget": budget(subject),
        "subject": subject,
    }
    joint = subject.joint
    if joint is not None:
        operators = 0
        if joint.compensator:
            operators = joint.compensator.parts
        return {
            **common,
            "m": joint.compensator,
            "n": operators,
            "d": joint.direct,
            "adaptation": joint.adaptation,
            "j": joint.values,
            "fingerprint": joint.fingerprint,
            "indent": " " * len(f"void {subject.name}_step("),
            "words": JOINT_WORDS[subject.real],
        }
    block = subject.block
    assert block is not None  # a subject has one of both
    # How a step comes to its tunable numbers: as an argument, from pages in memory, or not at all.
    tuning = ""
    tuned = ""
    if with_tuning:
        tuning = "given"
        tuned = f", const {subject.name}_tunable *tuned"
    elif subject.tunable:
        tuning = "pages"
    return {
        **common,
        "b": block,
        "n": block.parts,
        "d": None,
        "samples": round(1 / block.fade),
        "tuning": tuning,
        "tuned": tuned,
        "back": block.back,
    }


def provenance_lines(subject: Subject) -> list[str]:
    """Return what is known of the model's origin, one line an entry."""
    lines = []
    for key, value in sorted(subject.provenance.items()):
        if value not in (None, "", [], {}):
            lines.append(f"{key}: {value}")
    # The comment on top of a source file must leave the code in sight.
    return lines[:20]


def with_warning(readme: str, subject: Subject) -> str:
    """Return a README that says under its title what identification thought of the model, unless it was good.

    A forward model drives nothing, and says nothing.
    """
    grade = grade_in(subject.provenance)
    if grade is None or grade is Grade.GOOD or subject.what == "forward":
        return readme
    cure = "Watch the actuator."
    if grade is Grade.BAD:
        cure = "Do not let it drive a machine."
    verdict = comment(subject.provenance.get("verdict"))
    line = f"**When this model was identified, the verdict was: {verdict} {cure}**"
    # The first empty line is the one below the title.
    return readme.replace("\n\n", f"\n\n{line}\n\n", 1)


def _range(low: float | None, high: float | None, unit: str) -> str:
    if low is None or high is None:
        return "nothing"
    return visible(f"{low:.6g} .. {high:.6g} {unit}").rstrip()


def _verify(folder: Path, subject: Subject) -> list[Check]:
    """Compile the folder with every compiler found, and run its check."""
    return check_folder(folder)


WRITER = Writer(_files, _verify)
