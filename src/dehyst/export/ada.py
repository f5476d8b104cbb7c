"""Target ``ada``: a package with contracts around the C sources, project files of GNAT, and a check program."""

from __future__ import annotations

import shutil
import tempfile
from pathlib import Path

from dehyst.export import c, wrapped
from dehyst.export.compilers import PATIENCE, run, version_of
from dehyst.export.rendering import comment, render
from dehyst.export.subject import Subject
from dehyst.export.targets import Check

_WORDS = """
abort abs abstract accept access aliased all and array at begin body case constant declare delay delta digits do else
elsif end entry exception exit extends external external_as_list for function generic goto if in interface is library
limited loop mod new not null of or others out overriding package parallel pragma private procedure project protected
raise range record rem renames requeue return reverse select separate some subtype synchronized tagged task terminate
then type until use when while with xor
ada gnat interfaces standard system calendar direct_io io_exceptions machine_code sequential_io text_io
unchecked_conversion unchecked_deallocation
"""
WORDS = frozenset(_WORDS.split())  # of the language, of its project files, or packages that come with it
_OWN = {"answer", "boolean", "float", "long_float", "on", "real", "self", "started", "unit"}  # within `Step`


def files(subject: Subject) -> dict[str, str | bytes]:
    """Return the package: C sources, specification, body, project files and check."""
    name = subject.name
    wrapped.refuse_word(name, WORDS, "the name of a package: it is a word of Ada or a package that comes with it")
    values = wrapped.template_values(subject, argument)
    values |= {"language": "Ada", "binding": f"src/{name}.ads", "package": _cased(name)}
    values["more"] = [(argument(word), comment(about)[:200]) for word, about in subject.more]
    lines = {key: comment(values[key])[:200] for key in ("title", "input_label", "output_label")}

    def made(file: str) -> str:
        return render(f"ada/{file}.j2", **(values | lines)).encode("ascii", "replace").decode()

    sources = wrapped.sources(subject, values)
    sources[f"csrc/{name}_unit.c"] = sources.pop(f"csrc/{name}.c")  # the object of the Ada body has the unit's name
    return {
        **sources,
        f"{name}.gpr": made("unit.gpr"),
        f"{name}_check.gpr": made("check.gpr"),
        f"src/{name}.ads": made("unit.ads"),
        f"src/{name}.adb": made("unit.adb"),
        f"check/{name}_check.adb": made("check.adb"),
        f"check/{name}_expected.ads": made("expected.ads"),
        "README.md": c.with_warning(render("ada/README.md.j2", **values), subject),
    }


def argument(word: str) -> str:
    """Return the name of a further input in Ada.

    Examples
    --------
    >>> argument("mean_pressure"), argument("delta")
    ('Mean_Pressure', 'Delta_Input')
    """
    return _cased(f"{word}_input" if word in WORDS or word in _OWN else word)


def _cased(name: str) -> str:
    return "_".join(part.capitalize() for part in name.split("_"))


def verify(folder: Path, subject: Subject) -> list[Check]:
    """Build and run the check with gprbuild; objects go elsewhere."""
    claim = "gprbuild and the check program"
    gprbuild, name = shutil.which("gprbuild"), subject.name
    if gprbuild is None or shutil.which("gnatmake") is None:
        missing = "gprbuild" if gprbuild is None else "GNAT"
        return [Check(claim, "skipped", f"no {missing} on this machine; on Debian: apt-get install gnat gprbuild")]
    with tempfile.TemporaryDirectory(prefix="dehyst-") as place:
        build = [gprbuild, "-q", "-p", "-P", f"{name}_check.gpr", f"-X{name.upper()}_BUILD={place}"]
        said: list[str] = []
        for command in (build, [f"{place}/{name}_check"]):
            done = run(command, folder)
            if done is None:
                return [Check(claim, "failed", f"not finished after {PATIENCE} s")]
            said = [line.strip() for line in (done.stdout + done.stderr).splitlines()]
            if done.returncode:
                faults = [line for word in ("WRONG", "error", "raised") for line in said if word in line]
                return [Check(claim, "failed", next(iter(faults), f"exit status {done.returncode}"))]
    passed = sum(line.endswith(": EQUAL") for line in said)
    due = (folder / "check" / f"{name}_check.adb").read_text(encoding="utf-8").count("   Report (")
    if passed != due or said[-1:] != ["all checks passed"]:
        return [Check(claim, "failed", f"{passed} claims are EQUAL, due are {due}; {' '.join(said[-1:])}")]
    return [Check(claim, "passed", f"{passed} claims; {version_of('gnatmake')}", ran=True)]
