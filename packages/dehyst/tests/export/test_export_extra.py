"""Files of a C export for build systems and assessors: each is taken by the tool it is for, or by its schema."""

import hashlib
import json
import re
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest

from dehyst import __version__
from dehyst.export import core_files, export, subject_of, verify
from dehyst.export._extra import deviations
from dehyst.export._requirements import REQUIREMENTS
from dehyst.models import ModelCard, SignalCard
from dehyst_robot.control import JointControllerParameters
from dehyst_robot.export import joint_subject
from direct_export_samples import direct_model
from export_samples import mapped_model, play_model
from places import KERNEL, ROOT
from test_export_c import C_TARGETS, needs, run

ZEPHYR = """
cmake_minimum_required(VERSION 3.10...3.31)
project(app LANGUAGES C)
add_executable(app {check})
macro(zephyr_include_directories folder)
  target_include_directories(app PRIVATE ${{CMAKE_CURRENT_SOURCE_DIR}}/${{folder}})
endmacro()
macro(zephyr_library_named name)
  set(unit ${{name}})
  add_library(${{name}} STATIC)
  target_link_libraries(app PRIVATE ${{name}})
endmacro()
macro(zephyr_library_compile_options)
  target_compile_options(${{unit}} PRIVATE ${{ARGV}})
endmacro()
macro(zephyr_library_sources)
  foreach(file ${{ARGV}})
    target_sources(${{unit}} PRIVATE ${{CMAKE_CURRENT_SOURCE_DIR}}/${{file}})
  endforeach()
endmacro()
set(CONFIG_DEHYST_ELBOW y)
add_subdirectory({module} unit)
"""


@pytest.fixture(scope="module", params=C_TARGETS)
def folder(request, tmp_path_factory):
    return export(
        subject_of(mapped_model(), name="elbow", ramp=40),
        request.param,
        tmp_path_factory.mktemp("x") / "out",
    ).folder


@pytest.fixture(scope="module")
def sources(folder):
    return sorted(path.relative_to(folder).as_posix() for path in folder.glob("src/*.c"))


@pytest.fixture(scope="module")
def installed(folder, tmp_path_factory):
    needs("cmake", "cc")
    place = tmp_path_factory.mktemp("installed")
    run("cmake", "-S", str(folder), "-B", "build", cwd=place)
    run("cmake", "--build", "build", cwd=place)
    run("cmake", "--install", "build", "--prefix", "prefix", cwd=place)
    return place / "prefix"


@pytest.mark.slow
def test_a_project_finds_the_installed_package_by_cmake_and_its_check_passes(
    folder, installed, tmp_path
):
    release = re.match(r"\d+\.\d+\.\d+", __version__).group()
    (tmp_path / "CMakeLists.txt").write_text(
        "cmake_minimum_required(VERSION 3.10...3.31)\nproject(user LANGUAGES C)\n"
        f"find_package(elbow {release} EXACT CONFIG REQUIRED)\nadd_executable(user {folder}/check/check.c)\n"
        "target_link_libraries(user PRIVATE elbow::elbow)\n"
    )
    run("cmake", "-S", ".", "-B", "build", f"-DCMAKE_PREFIX_PATH={installed}", cwd=tmp_path)
    run("cmake", "--build", "build", cwd=tmp_path)
    assert run("build/user", cwd=tmp_path).splitlines()[-1] == "all checks passed"


@pytest.mark.slow
def test_a_project_finds_the_installed_package_by_pkg_config_also_where_it_was_moved(
    folder, installed, tmp_path
):
    needs("pkg-config")
    moved = tmp_path / "moved"
    moved.symlink_to(installed)
    said = run(
        "env",
        f"PKG_CONFIG_PATH={moved}/lib/pkgconfig",
        "pkg-config",
        "--cflags",
        "--libs",
        "elbow",
        cwd=tmp_path,
    )
    run("cc", f"{folder}/check/check.c", "-o", "user", *said.split(), cwd=tmp_path)
    assert run("./user", cwd=tmp_path).splitlines()[-1] == "all checks passed"


@pytest.mark.slow
def test_zephyr_builds_what_its_kconfig_switches_on(folder, sources, tmp_path):
    """Zephyr's functions are those of CMake with another name: here they are written so."""
    needs("cmake", "cc")
    module = dict(
        re.findall(r"(?m)^ *(\w+): (\S+)$", (folder / "zephyr" / "module.yml").read_text())
    )
    assert module == {"name": "elbow", "cmake": "zephyr", "kconfig": "zephyr/Kconfig"}
    kconfiglib = pytest.importorskip("kconfiglib")
    symbol = kconfiglib.Kconfig(str(folder / module["kconfig"]), warn_to_stderr=False).syms[
        "DEHYST_ELBOW"
    ]
    symbol.set_value("y")
    assert symbol.str_value == "y" and symbol.nodes[0].help
    stand_in = ZEPHYR.format(check=folder / "check" / "check.c", module=folder / module["cmake"])
    (tmp_path / "CMakeLists.txt").write_text(stand_in)
    run("cmake", "-S", ".", "-B", "build", cwd=tmp_path)
    run("cmake", "--build", "build", cwd=tmp_path)
    assert run("build/app", cwd=tmp_path).splitlines()[-1] == "all checks passed"


def test_the_library_of_platformio_is_as_documented_and_names_what_there_is(folder, sources):
    told = json.loads((folder / "library.json").read_text())
    assert re.fullmatch(r"[a-z][a-z0-9_]{0,49}", told["name"]) and re.fullmatch(
        r"\d+\.\d+\.\d+", told["version"]
    )
    assert 0 < len(told["description"]) <= 255 and told["license"] == "0BSD"
    build = told["build"]
    assert (folder / build["includeDir"] / told["headers"]).is_file()
    assert [path.name for path in sorted((folder / build["srcDir"]).glob("*.c"))] == [
        Path(name).name for name in sources
    ]
    assert build["flags"] == "-ffp-contract=off" if sources else build["srcFilter"] == "-<*>"
    (example,) = told["examples"]
    assert all((folder / example["base"] / name).is_file() for name in example["files"])


def test_the_cmsis_pack_is_as_its_schema_says_and_names_what_there_is(folder, sources):
    (path,) = folder.glob("*.pdsc")
    pack = ET.parse(path).getroot()
    assert path.name == f"{pack.findtext('vendor')}.{pack.findtext('name')}.pdsc"
    assert {"vendor", "name", "description", "url", "license", "releases", "components"} == {
        part.tag for part in pack
    }
    assert re.fullmatch(r"\d+\.\d+\.\d+", pack.attrib["schemaVersion"])
    (component,) = pack.iter("component")
    assert all(3 <= len(component.attrib[part]) <= 32 for part in ("Cclass", "Cgroup"))
    assert pack.find("releases/release").attrib["version"] == component.attrib["Cversion"]
    assert all(len(text.text) <= 256 for text in pack.iter("description"))
    files = [(file.attrib["category"], file.attrib["name"]) for file in component.iter("file")]
    assert {kind for kind, _ in files} <= {"doc", "include", "header", "sourceC"}
    assert all((folder / name).exists() for _, name in files)
    assert [name for kind, name in files if kind == "sourceC"] == sources


def test_the_bill_of_materials_is_valid_cyclonedx_and_has_the_checksum_of_every_source(folder):
    validation = pytest.importorskip("cyclonedx.validation.json")
    schema = pytest.importorskip("cyclonedx.schema").SchemaVersion
    text = (folder / "sbom.cdx.json").read_text()
    assert validation.JsonStrictValidator(schema.V1_6).validate_str(text) is None
    told = json.loads(text)
    hashes = {
        part["name"]: part["hashes"][0]["content"]
        for part in told["components"]
        if part["type"] == "file"
    }
    code = {
        path.relative_to(folder).as_posix() for path in (*folder.glob("*.h"), *folder.glob("src/*"))
    }
    assert set(hashes) == code
    assert all(
        hashlib.sha256((folder / name).read_bytes()).hexdigest() == sha
        for name, sha in hashes.items()
    )
    assert set(told["dependencies"][0]["dependsOn"]) == {
        part["bom-ref"] for part in told["components"]
    }


def subjects():
    yield subject_of(mapped_model(), name="u", ramp=40, tunable=True)
    yield subject_of(direct_model(), name="u", period=1e-3)
    yield joint_subject(play_model(), JointControllerParameters(), name="u")


def test_every_requirement_is_shown_by_tests_and_proofs_that_there_are(tmp_path):
    proofs = {
        one["name"] for one in json.loads((ROOT / "proofs" / "results.json").read_text())["proofs"]
    }
    for one in REQUIREMENTS:
        assert one.tests and all(
            any(ROOT.glob(f"packages/*/tests/*/{name}")) for name in one.tests
        ), one.key
        assert set(one.proofs) <= proofs, one.key
    checks = []
    for k, one in enumerate(subjects()):
        folder = export(one, "c", tmp_path / str(k)).folder
        checks.append((folder / "check" / "check.c").read_text())
        assert ("| sensor faults |" in (folder / "requirements.md").read_text()) == (
            one.joint is not None
        )
    every = "".join(checks)
    assert all(
        f'report("{claim}' in every or claim == "your log"
        for one in REQUIREMENTS
        for claim in one.claims
    )
    shown = {claim for one in REQUIREMENTS for claim in one.claims_in(every)}
    assert shown == set(
        re.findall(r'report\("([^"]+)"', every)
    )  # no claim that no requirement asks for


def test_deviations_of_the_whole_core_are_those_that_are_listed():
    listed = json.loads((KERNEL / "core" / "misra.json").read_text())
    assert deviations(core_files.core_files()) == [
        (rule, sum(entry["files"].values()), entry["reason"]) for rule, entry in listed.items()
    ]
    few = {rule: places for rule, places, _ in deviations({"map.c": ""})}
    assert few == {
        rule: entry["files"]["map.c"] for rule, entry in listed.items() if "map.c" in entry["files"]
    }


@pytest.mark.parametrize("name", ["sbom.cdx.json", "elbow.pc", "zephyr/Kconfig"])
def test_verification_names_such_a_file_once_it_was_edited(name, tmp_path):
    folder = export(subject_of(play_model(), name="elbow"), "c", tmp_path / "out").folder
    (folder / name).write_text((folder / name).read_text() + "\n")
    faults = [check.detail for check in verify(folder) if check.status == "failed"]
    assert faults and all(name in detail for detail in faults)


def test_text_of_a_log_cannot_leave_a_string_of_such_a_file(tmp_path):
    evil = 'a"}</name> & \\ */ "\n- x: é'
    card = ModelCard(SignalCard(evil, evil, -1.0, 1.0), SignalCard(evil, evil, -2.0, 2.0))
    folder = export(subject_of(play_model(card), name="elbow"), "c", tmp_path / "out").folder
    assert 'a"}' in json.loads((folder / "library.json").read_text())["description"]
    assert (
        'a"}'
        in json.loads((folder / "sbom.cdx.json").read_text())["metadata"]["component"][
            "description"
        ]
    )
    assert 'a"}' in ET.parse(next(folder.glob("*.pdsc"))).getroot().findtext("description")
    assert len((folder / "elbow.pc").read_text().splitlines()) == 8
