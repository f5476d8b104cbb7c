"""What is handed out: metadata, an sdist that is the same each time, and the bill of materials of a wheel."""

import importlib
import json
import re
import sys
import tarfile
import tomllib
from pathlib import Path

import pytest

from dehyst.version import __version__

ROOT = Path(__file__).parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))


def test_version_and_licence_are_the_same_wherever_they_stand():
    cited = dict(re.findall(r"^(\w+): (.*)$", (ROOT / "CITATION.cff").read_text(encoding="utf-8"), re.MULTILINE))
    assert {PROJECT["project"]["version"], cited["version"]} == {__version__}
    assert {PROJECT["project"]["license"], cited["license"]} == {"Apache-2.0"}


def test_every_python_that_a_classifier_names_is_one_that_is_asked_for():
    named = re.findall(r"Python :: 3\.(\d+)", "\n".join(PROJECT["project"]["classifiers"]))
    least = int(re.fullmatch(r">=3\.(\d+)", PROJECT["project"]["requires-python"])[1])
    assert min(map(int, named)) == least and not [one for one in PROJECT["project"]["classifiers"] if "License" in one]


def test_wheels_of_every_system_are_built_for_the_same_pythons():
    assert PROJECT["tool"]["scikit-build"]["wheel"]["py-api"] == "cp312"
    assert PROJECT["tool"]["cibuildwheel"]["build"] == ["cp311-*", "cp312-*"]
    assert PROJECT["tool"]["cibuildwheel"]["windows"]["environment"]["CMAKE_GENERATOR_TOOLSET"] == "ClangCL"


@pytest.mark.slow
def test_the_sdist_is_the_same_twice_and_builds_on_its_own(tmp_path, monkeypatch):
    backend = pytest.importorskip("scikit_build_core.build", reason="needs scikit-build-core")
    monkeypatch.chdir(ROOT)
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1767225600")
    made = [tmp_path / name / backend.build_sdist(str(tmp_path / name)) for name in ("first", "second")]
    assert made[0].read_bytes() == made[1].read_bytes()
    with tarfile.open(made[0]) as archive:
        names = {member.name.partition("/")[2] for member in archive if member.isfile()}
    needed = {"CMakeLists.txt", "LICENSE", "README.md", "Makefile", "constraints.txt", "wheels/make.py", "PKG-INFO"}
    folders = ("core", "engine", "plant", "reviewed", "src", "wheels", "tests")
    sources = {path.relative_to(ROOT).as_posix() for one in folders for path in (ROOT / one).rglob("*.[chp]*")}
    compiled = re.compile(r"core_sources|__pycache__|\.(so|pyc|pyd)$")
    assert names >= needed | {name for name in sources if not compiled.search(name)}
    assert not [name for name in names if compiled.search(name)]


def test_the_bill_of_a_wheel_is_valid_cyclonedx_and_names_what_is_linked_and_what_is_needed(monkeypatch):
    validation = pytest.importorskip("cyclonedx.validation.json")
    schema = pytest.importorskip("cyclonedx.schema").SchemaVersion
    monkeypatch.syspath_prepend(str(ROOT / "wheels"))
    sbom = importlib.import_module("sbom")
    monkeypatch.delitem(sys.modules, "sbom")
    monkeypatch.setattr(sbom, "version", lambda name: "1.2.3")
    needs = ["numpy>=1.26", 'rosbags>=0.11; extra == "ros"']
    about = {"name": "dehyst", "version": "0.1.0", "license_expression": "Apache-2.0", "requires_dist": needs}
    text = sbom.bill(about, {"dehyst/_native.abi3.so": b"\x7fELF"})
    assert validation.JsonStrictValidator(schema.V1_6).validate_str(text.decode()) is None
    compiled, *needed = json.loads(text)["components"]
    assert {one["name"] for one in compiled["components"]} >= {"nanobind", "libc++"}
    assert [one["name"] for one in needed] == ["numpy"]
    assert text == sbom.bill(about, {"dehyst/_native.abi3.so": b"\x7fELF"})
    assert text != sbom.bill(about, {"dehyst/_native.abi3.so": b"another"})
