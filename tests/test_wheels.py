"""What is handed out: metadata of four packages, sdists with the same bytes each time, the bill of materials."""

import importlib
import json
import re
import subprocess
import sys
import tarfile
import tomllib

import pytest

from dehyst.version import __version__
from places import PACKAGES, ROOT

NAMES = ("dehyst", "dehyst-targets", "dehyst-robot", "dehyst-studio")
COMPILED = ("dehyst", "dehyst-robot")
PROJECTS = {
    name: tomllib.loads((PACKAGES / name / "pyproject.toml").read_text(encoding="utf-8"))
    for name in NAMES
}


@pytest.fixture
def make(monkeypatch):
    """The module wheels/make.py, whose imports lie beside it."""
    pytest.importorskip("packaging")
    monkeypatch.syspath_prepend(str(ROOT / "wheels"))
    module = importlib.import_module("make")
    for name in ("make", "sbom"):
        monkeypatch.delitem(sys.modules, name)
    return module


def test_version_and_licence_are_the_same_wherever_they_stand():
    text = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    cited = dict(re.findall(r"^(\w+): (.*)$", text, re.MULTILINE))
    assert cited["version"] == __version__
    assert cited["license"] == "Apache-2.0"
    for project in PROJECTS.values():
        assert project["project"]["version"] == __version__
        assert project["project"]["license"] == "Apache-2.0"


def test_every_package_asks_for_the_kernel_of_its_own_version():
    for name in set(NAMES) - {"dehyst"}:
        assert f"dehyst=={__version__}" in PROJECTS[name]["project"]["dependencies"]


def test_every_package_has_the_same_licence_text_and_the_same_least_python():
    texts = {(PACKAGES / name / "LICENSE").read_bytes() for name in NAMES}
    assert texts == {(ROOT / "LICENSE").read_bytes()}
    assert {project["project"]["requires-python"] for project in PROJECTS.values()} == {">=3.11"}


def test_every_python_that_a_classifier_names_is_one_that_is_asked_for():
    project = PROJECTS["dehyst"]["project"]
    named = re.findall(r"Python :: 3\.(\d+)", "\n".join(project["classifiers"]))
    least = int(re.fullmatch(r">=3\.(\d+)", project["requires-python"])[1])
    assert min(map(int, named)) == least
    assert not [entry for entry in project["classifiers"] if "License" in entry]


def test_wheels_of_every_system_are_built_for_the_same_pythons():
    for name in COMPILED:
        tool = PROJECTS[name]["tool"]
        assert tool["scikit-build"]["wheel"]["py-api"] == "cp312"
        assert tool["cibuildwheel"]["build"] == ["cp311-*", "cp312-*"]
        windows = tool["cibuildwheel"]["windows"]["environment"]
        assert windows["CMAKE_GENERATOR_TOOLSET"] == "ClangCL"


def test_the_release_publishes_and_builds_all_four_packages(make):
    folder = ROOT / ".github" / "workflows"
    release = (folder / "release.yml").read_text(encoding="utf-8")
    wheels = (folder / "wheels.yml").read_text(encoding="utf-8")
    listed = re.search(r"project: \[(.*)\]", release)[1].split(", ")
    assert sorted(listed) == sorted(NAMES)
    assert sorted((*make.COMPILED, *make.PURE)) == sorted(NAMES)
    for name in make.COMPILED:
        assert f"package: [{', '.join(make.COMPILED)}]" in wheels, name


def test_the_sources_of_the_robot_hold_the_c_of_the_kernel_that_they_include(make, tmp_path):
    staged = make.stage("dehyst-robot", tmp_path)
    held = {path.name for path in staged.rglob("*.h")}
    missing = set()
    for path in staged.rglob("*.[ch]*"):
        for name in re.findall(
            r'^#include "(\S+)"', path.read_text(encoding="utf-8"), re.MULTILINE
        ):
            if not (staged / "native" / name).is_file() and name not in held:
                missing.add(f"{path.name}: {name}")
    assert held and not missing
    listing = (staged / "CMakeLists.txt").read_text(encoding="utf-8")
    for name in re.findall(r"\$\{kernel\}/([\w/]+\.\w+)", listing):
        assert (staged / "kernel" / name).is_file(), name


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_the_sdist_is_the_same_twice_and_holds_every_source(name, make, tmp_path, monkeypatch):
    backend = PROJECTS[name]["build-system"]["build-backend"]
    pytest.importorskip(backend, reason=f"needs {backend.partition('.')[0]}")
    program = f"import sys, {backend} as backend; print(backend.build_sdist(sys.argv[1]))"
    monkeypatch.setenv("SOURCE_DATE_EPOCH", make.EPOCH)
    staged = make.stage(name, tmp_path)
    made = []
    for folder in (tmp_path / "first", tmp_path / "second"):
        folder.mkdir()
        subprocess.run([sys.executable, "-c", program, folder], cwd=staged, check=True)
        made.append(next(folder.glob("*.tar.gz")))
    assert made[0].read_bytes() == made[1].read_bytes()
    with tarfile.open(made[0]) as archive:
        names = {member.name.partition("/")[2] for member in archive if member.isfile()}
    sources = set()
    for path in staged.rglob("*"):
        if path.is_file():
            sources.add(path.relative_to(staged).as_posix())
    assert names >= {"LICENSE", "README.md", "pyproject.toml", "PKG-INFO"} | sources
    compiled = re.compile(r"core_sources|__pycache__|\.(so|pyc|pyd)$")
    assert not [entry for entry in names if compiled.search(entry)]


def test_the_bill_of_a_wheel_is_valid_cyclonedx_and_names_what_is_linked_and_what_is_needed(
    monkeypatch,
):
    validation = pytest.importorskip("cyclonedx.validation.json")
    schema = pytest.importorskip("cyclonedx.schema").SchemaVersion
    monkeypatch.syspath_prepend(str(ROOT / "wheels"))
    sbom = importlib.import_module("sbom")
    monkeypatch.delitem(sys.modules, "sbom")
    monkeypatch.setattr(sbom, "version", lambda name: "1.2.3")
    needs = ["numpy>=1.26", 'rosbags>=0.11; extra == "ros"']
    about = {
        "name": "dehyst",
        "version": "0.1.0",
        "license_expression": "Apache-2.0",
        "requires_dist": needs,
    }
    text = sbom.bill(about, {"dehyst/_native.abi3.so": b"\x7fELF"})
    assert validation.JsonStrictValidator(schema.V1_6).validate_str(text.decode()) is None
    compiled, *needed = json.loads(text)["components"]
    assert {one["name"] for one in compiled["components"]} >= {"nanobind", "libc++"}
    assert [one["name"] for one in needed] == ["numpy"]
    assert text == sbom.bill(about, {"dehyst/_native.abi3.so": b"\x7fELF"})
    assert text != sbom.bill(about, {"dehyst/_native.abi3.so": b"another"})
