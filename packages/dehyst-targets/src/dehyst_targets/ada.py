"""Target ``ada``: a package with contracts around the C sources, project files of GNAT, and a check program."""

from __future__ import annotations

import shutil
import tempfile
from pathlib import Path
from typing import Any

from dehyst.export import Check, Subject, c
from dehyst.export import kit as export_kit
from dehyst_targets import wrapped

_WORDS = """
abort abs abstract accept access aliased all and array at begin body case constant declare delay delta digits do else
elsif end entry exception exit extends external external_as_list for function generic goto if in interface is library
limited loop mod new not null of or others out overriding package parallel pragma private procedure project protected
raise range record rem renames requeue return reverse select separate some subtype synchronized tagged task terminate
then type until use when while with xor
ada gnat interfaces standard system calendar direct_io io_exceptions machine_code sequential_io text_io
unchecked_conversion unchecked_deallocation
"""
# Words of the language, of its project files, and packages that come with it.
WORDS = frozenset(_WORDS.split())
# Names that the body of `Step` uses itself.
_IN_STEP = frozenset(
    ["answer", "boolean", "float", "long_float", "on", "real", "self", "started", "unit"]
)
_CLAIM = "gprbuild and the check program"
_FAULTS = ("WRONG", "error", "raised")


def _files(subject: Subject) -> dict[str, str | bytes]:
    """Return the package: C sources, specification, body, project files and check."""
    name = subject.name
    wrapped.refuse_word(
        name, WORDS, "the name of a package: it is a word of Ada or a package that comes with it"
    )
    values = _ada_values(subject)
    shown = dict(values)
    for key in ("title", "input_label", "output_label"):
        shown[key] = _comment(values[key])

    def text_of(file: str) -> str:
        # GNAT reads Latin-1 unless told otherwise, so its sources hold ASCII only.
        text = export_kit.render(f"ada/{file}.j2", **shown)
        return text.encode("ascii", "replace").decode()

    sources = wrapped.wrapped_sources(subject, values)
    # GNAT names the object of the Ada body after the unit, so the C file needs another name.
    sources[f"csrc/{name}_unit.c"] = sources.pop(f"csrc/{name}.c")
    return {
        **sources,
        f"{name}.gpr": text_of("unit.gpr"),
        f"{name}_check.gpr": text_of("check.gpr"),
        f"src/{name}.ads": text_of("unit.ads"),
        f"src/{name}.adb": text_of("unit.adb"),
        f"check/{name}_check.adb": text_of("check.adb"),
        f"check/{name}_expected.ads": text_of("expected.ads"),
        "README.md": c.with_warning(export_kit.render("ada/README.md.j2", **values), subject),
    }


def _ada_values(subject: Subject) -> dict[str, Any]:
    name = subject.name
    values = wrapped.wrapped_values(subject, ada_argument)
    values |= {"language": "Ada", "binding": f"src/{name}.ads", "package": _cased(name)}
    values["more"] = [(ada_argument(word), _comment(about)) for word, about in subject.more]
    return values


def _comment(text: object) -> str:
    # GNAT refuses lines of more than 255 characters.
    return export_kit.comment(text)[:200]


def ada_argument(word: str) -> str:
    """Return the name of a further input in Ada.

    Examples
    --------
    >>> ada_argument("mean_pressure"), ada_argument("delta")
    ('Mean_Pressure', 'Delta_Input')
    """
    if word in WORDS or word in _IN_STEP:
        word = f"{word}_input"
    return _cased(word)


def _cased(name: str) -> str:
    # Case does not count in Ada, but this is how its programmers write names.
    return "_".join(part.capitalize() for part in name.split("_"))


def _verify(folder: Path, subject: Subject) -> list[Check]:
    """Build and run the check with gprbuild; objects go elsewhere."""
    gprbuild = shutil.which("gprbuild")
    if gprbuild is None:
        return [_skipped("gprbuild")]
    if shutil.which("gnatmake") is None:
        return [_skipped("GNAT")]
    name = subject.name
    with tempfile.TemporaryDirectory(prefix="dehyst-") as place:
        build = [gprbuild, "-q", "-p", "-P", f"{name}_check.gpr", f"-X{name.upper()}_BUILD={place}"]
        lines: list[str] = []
        for command in (build, [f"{place}/{name}_check"]):
            run = export_kit.run_program(command, folder)
            if run is None:
                return [Check(_CLAIM, "failed", f"not finished after {export_kit.PATIENCE} s")]
            lines = [line.strip() for line in (run.stdout + run.stderr).splitlines()]
            if run.returncode:
                why = wrapped.first_fault(lines, _FAULTS, run.returncode)
                return [Check(_CLAIM, "failed", why)]
    return [_judged(folder, name, lines)]


def _skipped(tool: str) -> Check:
    why = f"no {tool} on this machine; on Debian: apt-get install gnat gprbuild"
    return Check(_CLAIM, "skipped", why)


def _judged(folder: Path, name: str, lines: list[str]) -> Check:
    """Compare the claims that the program printed with those in its source."""
    passed = sum(line.endswith(": EQUAL") for line in lines)
    program = (folder / "check" / f"{name}_check.adb").read_text(encoding="utf-8")
    due = program.count("   Report (")
    if passed != due or lines[-1:] != ["all checks passed"]:
        why = f"{passed} claims are EQUAL, due are {due}; {' '.join(lines[-1:])}"
        return Check(_CLAIM, "failed", why)
    detail = f"{passed} claims; {export_kit.version_of('gnatmake')}"
    return Check(_CLAIM, "passed", detail, ran=True)


WRITER = export_kit.Writer(_files, _verify)
