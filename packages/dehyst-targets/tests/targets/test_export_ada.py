"""The Ada target: packages of every kind of unit, checked by their own programs and linked into one."""

import re
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import pytest

from dehyst.errors import ParameterError
from dehyst.export import export, subject_of, verify
from dehyst_targets import ada
from element_samples import scheduled_model
from export_samples import play_model
from places import ROOT
from wrapped_samples import UNITS, other_precision

PAGE = ROOT / "docs" / "how-to" / "use-in-ada.md"
BUILD = ("gprbuild", "-q", "-p", "-P")
WITH_GNAT = pytest.mark.skipif(
    shutil.which("gprbuild") is None or shutil.which("gnatmake") is None,
    reason="needs apt-get install gnat gprbuild",
)
FMA = "fma" in Path("/proc/cpuinfo").read_text() if Path("/proc/cpuinfo").is_file() else False


def exported(name, folder, real="double"):
    return export(UNITS[name](real), "ada", folder / name).folder


def run(folder, *command):
    return subprocess.run(command, cwd=folder, capture_output=True, text=True)


def done(folder, *command):
    """What a command says that has to go well."""
    ran = run(folder, *command)
    assert ran.returncode == 0, ran.stdout + ran.stderr
    return ran.stdout


def use(page, package):
    """What a page shows as its use, as a block of a program."""
    shown = re.search(r"```ada\n(.*?)\n\.\.\.\n(.*?)```", page.read_text(), re.DOTALL)
    inputs = re.findall(r"\w+", " ".join(re.findall(r"Step \(Self, (.*?), On =>", shown[2])))
    own = "".join(f"{word} : {package}.Real := 0.0;\n" for word in inputs)
    if "Seen" in shown[2]:
        own = f"Seen : {package}.Sensors;\nWanted : {package}.Reference;\n"
    return f"declare\n{own}{shown[1]}\nbegin\n{shown[2]}end;\n"


@pytest.mark.exhaustive
@WITH_GNAT
@pytest.mark.parametrize(
    ("real", "names"), [("double", tuple(UNITS)), ("float", ("sums", "inverted", "taught"))]
)
def test_units_of_every_kind_have_the_models_answers_and_link_into_one_program(
    real, names, tmp_path
):
    for name in names:
        exported(name, tmp_path, real)
    export(other_precision(real), "ada", tmp_path / "other")
    every = (*names, "other")
    projects = "".join(f'with "{name}/{name}.gpr";\n' for name in every)
    (tmp_path / "whole.gpr").write_text(
        f'{projects}project Whole is\nfor Main use ("whole.adb");\nend Whole;\n'
    )
    uses = "".join(use(tmp_path / name / "README.md", name.capitalize()) for name in every)
    packages = "".join(f"with {name};\n" for name in every)
    (tmp_path / "whole.adb").write_text(f"{packages}procedure Whole is\nbegin\n{uses}end Whole;\n")
    done(tmp_path, *BUILD, "whole.gpr")
    done(tmp_path, "./whole")
    for name in names:
        done(tmp_path / name, *BUILD, f"{name}_check.gpr")
        said = done(tmp_path / name, f"build/{name}_check").splitlines()
        assert said[-1] == "all checks passed" and all(
            line.endswith(": EQUAL") for line in said[:-1]
        ), said


@pytest.mark.slow
@WITH_GNAT
def test_wrong_numbers_are_told_from_other_last_digits_also_without_gprbuild(tmp_path):
    folder = exported("plays", tmp_path)
    assert all(
        check.ok and check.status == "passed"
        for check in verify(folder)
        if "gprbuild" in check.claim
    )
    shown = re.search(r"```sh\n(.*?)```", (folder / "README.md").read_text(), re.DOTALL)[1]
    shown += "build/plays_check"
    assert done(folder, "sh", "-ec", shown).splitlines()[-1] == "all checks passed"
    if FMA:
        contracted = shown.replace("-ffp-contract=off", "-ffp-contract=fast -mfma")
        said = done(folder, "sh", "-ec", contracted)
        assert ": CLOSE" in said and "WRONG" not in said and "usable, not bit-equal" in said
    source = folder / "csrc" / "plays_unit.c"
    source.write_text(source.read_text().replace("0x1.", "0x1.8", 1))
    assert not all(check.ok for check in verify(folder))
    ran = run(folder, "sh", "-ec", shown)
    assert ran.returncode == 1 and ": WRONG" in ran.stdout and "do not use this build" in ran.stdout


@pytest.mark.slow
@WITH_GNAT
def test_the_page_shows_what_compiles_and_a_step_before_a_reset_breaks_its_contract(tmp_path):
    export(subject_of(play_model(), name="elbow"), "ada", tmp_path / "elbow")
    program = f"with Elbow;\nprocedure Page is\nbegin\n{use(PAGE, 'Elbow')}end Page;\n"
    (tmp_path / "page.gpr").write_text(
        'with "elbow/elbow.gpr";\nproject Page is\nfor Main use ("page.adb");\nend Page;\n'
    )
    for text, fails in ((program, False), (program.replace("Elbow.Reset (Self);", ""), True)):
        (tmp_path / "page.adb").write_text(text)
        done(
            tmp_path,
            *BUILD,
            "page.gpr",
            "-XELBOW_BUILD=" + str(tmp_path / f"build{fails}"),
            "-f",
            "-cargs:ada",
            "-gnata",
        )
        ran = run(tmp_path, "./page")
        assert (ran.returncode != 0) == fails and ("precondition" in ran.stderr) == fails, (
            ran.stderr
        )


@pytest.mark.parametrize("name", ["range", "system", "project", "limited"])
def test_a_word_of_ada_is_no_name_and_the_cure_is_said(name, tmp_path):
    with pytest.raises(ParameterError, match=f"--name {name}_unit"):
        export(subject_of(play_model(), name=name), "ada", tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_an_input_that_is_a_word_of_ada_is_written_otherwise():
    subject = subject_of(scheduled_model(), "forward", name="unit_1")
    given = ("type", "answer", "load")[: len(subject.numbers.given)]
    specification = ada.WRITER.files(
        replace(subject, numbers=replace(subject.numbers, given=given))
    )["src/unit_1.ads"]
    assert "Type_Input : Real" in specification and "Answer_Input : Real" in specification


def test_no_line_of_hostile_text_is_too_long_or_other_than_ascii(tmp_path):
    folder = exported("plays", tmp_path)
    for path in (*folder.glob("src/*.ad?"), *folder.glob("check/*.ad?"), *folder.glob("*.gpr")):
        text = path.read_text(encoding="ascii")
        assert max(map(len, text.splitlines())) <= 255, path  # GNAT takes no more


def test_without_gnat_it_is_skipped_by_name(tmp_path, monkeypatch):
    monkeypatch.setattr(shutil, "which", lambda *_, **__: None)
    (check,) = ada.WRITER.verify(tmp_path, UNITS["plays"]("double"))
    assert check.status == "skipped" and "apt-get install gnat gprbuild" in check.detail
