"""A joint controller with a direct inverse, exported: the bits of the extension, with learning, contact and faults."""

import json
import shutil
import subprocess
from functools import cache

import numpy as np
import pytest

from dehyst.cli import main
from dehyst.errors import ParameterError
from dehyst.export import export, verify
from dehyst_robot.control import (
    FLAGS,
    SWITCHES,
    Adaptation,
    JointController,
    JointControllerParameters,
    save_controller,
)
from dehyst_robot.export import joint_subject
from dehyst_robot.export._joint_run import joint_run
from direct_export_samples import QUICK, direct_model
from export_samples import make_check, needs_make

TOLD = JointControllerParameters()
CASES = {
    "scheduled": {},
    "plain, after a homing": {"schedules": 0, "past": "rest"},
    "by three variables": {"schedules": 3},
    "stops only": {"paths": 0, "creeps": 0, "schedules": 0},
    "a polynomial only": {"stops": 0, "paths": 0, "creeps": 0},
}


@cache
def subject(case="scheduled", real="double", adaptation=QUICK):
    return joint_subject(direct_model(**CASES[case]), TOLD, adaptation, name="elbow", real=real)


@pytest.mark.parametrize("adaptation", [Adaptation(), QUICK])
def test_the_recorded_run_learns_is_pushed_and_switches_position_control_off(adaptation):
    run = joint_run(TOLD, direct_model(), "double", adaptation)
    learned = run.flags & FLAGS["learned"] != 0
    assert 100 < learned.sum() < 1500
    off = run.switch & SWITCHES["position"] == 0
    assert off[:100].all()
    assert off[350:420].all()
    assert not off[420:].any()
    contact, doubt = run.outputs[:, 11], run.outputs[:, 12]
    assert np.abs(contact[950:1090]).mean() > 3 * np.abs(contact[700:890]).mean()
    assert doubt[0] > doubt[800] > 0  # the past becomes known
    controller = JointController(TOLD, direct_model(), adaptation)
    controller.reset(*run.inputs[0, :3])
    controller.run(*run.inputs[:1000, :3].T, run.inputs[:1000, 3:], run.switch[:1000])
    assert np.abs(controller.scales - 1).max() > 1e-3


@pytest.mark.slow
@needs_make
@pytest.mark.parametrize("case", CASES)
def test_exported_c_checks_itself(case, tmp_path):
    written = export(subject(case), "c", tmp_path / "out")
    done = make_check(written.folder, tmp_path / "build")
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.slow
@needs_make
@pytest.mark.parametrize("target", ["c-header", "fmu2", "fmu3", "simulink"])
@pytest.mark.parametrize("real", ["double", "float"])
@pytest.mark.usefixtures("one_compiler")
def test_every_target_verifies(target, real, tmp_path):
    export(subject(real=real), target, tmp_path / "out")
    bad = [check for check in verify(tmp_path / "out") if not check.ok]
    assert not bad


@pytest.mark.slow
@needs_make
def test_a_changed_digit_is_found(tmp_path):
    folder = export(subject(), "c", tmp_path / "out").folder
    text = (folder / "src" / "elbow.c").read_text()
    begin = text.index("elbow_weight[] = {")
    place = text.index("0x1.", begin) + 6
    (folder / "src" / "elbow.c").write_text(
        text[:place] + ("0" if text[place] != "0" else "1") + text[place + 1 :]
    )
    assert make_check(folder, tmp_path / "build").returncode != 0
    assert any(check.status == "failed" for check in verify(folder))


@pytest.mark.slow
@pytest.mark.parametrize("compiler", ["gcc", "clang"])
@pytest.mark.parametrize("language", ["c99", "c11", "c++17"])
@pytest.mark.parametrize("case", ["scheduled", "a polynomial only"])
def test_it_compiles_without_a_warning(compiler, language, case, tmp_path, run_strict):
    run_strict(compiler, language, export(subject(case), "c", tmp_path / "out").folder / "src")


@pytest.fixture
def run_strict():
    def strict(compiler, language, sources):
        if shutil.which(compiler) is None:
            pytest.skip(f"no {compiler}")
        kind = "c++" if "+" in language else "c"
        warnings = ["-Wall", "-Wextra", "-Wconversion", "-Wpedantic", "-Werror"]
        command = [
            compiler,
            "-x",
            kind,
            f"-std={language}",
            *warnings,
            "-ffp-contract=off",
            "-O1",
            "-fsyntax-only",
        ]
        done = subprocess.run(
            [*command, *map(str, sorted(sources.glob("*.c")))],
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 0, done.stderr

    return strict


@pytest.mark.slow
@needs_make
def test_no_check_of_it_meets_undefined_behaviour(tmp_path):
    folder = export(subject(), "c", tmp_path / "out").folder
    flags = "-O1 -g -fsanitize=address,undefined -fno-sanitize-recover=all"
    done = subprocess.run(
        ["make", "-s", "-C", str(folder), "check", f"BUILD={tmp_path / 'b'}", f"CFLAGS={flags}", f"LDFLAGS={flags}"],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr


def test_the_command_exports_a_direct_inverse_in_a_controller(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    direct_model().save("elbow.json")
    save_controller(TOLD, "controller.json", Adaptation(rate=0.7))

    def run(*words):
        monkeypatch.setattr("sys.argv", ["dehyst", *words])
        with pytest.raises(SystemExit) as end:
            main()
        return int(end.value.code or 0), capsys.readouterr()

    told = (
        "export",
        "elbow.json",
        "--target",
        "c",
        "--what",
        "joint-controller",
        "--controller",
        "controller.json",
    )
    status, said = run(*told, "--out", "out", "--json")
    assert status == 0
    assert json.loads(said.out)["operators"] == 11
    assert (
        json.loads((tmp_path / "out" / "controller.json").read_text())["adaptation"]["rate"] == 0.7
    )
    assert f"{(0.7).hex()}".rstrip("0") in (tmp_path / "out" / "src" / "elbow.c").read_text()
    status, said = run("export", "elbow.json", "--target", "c", "--what", "forward", "--out", "x")
    assert status == 2
    assert "direct inverse" in said.err


def test_where_no_instructions_were_measured_the_budget_says_so(tmp_path):
    told = export(subject(), "c", tmp_path / "out").budget
    assert ("not measured" in " ".join(told.lines())) == (not told.instructions)
    assert any("instructions" in line for line in told.lines())


def test_what_floats_cannot_tell_apart_is_refused():
    model = direct_model(stops=0, schedules=0)
    close = type(model)(radii=[0.1, 0.1 * (1 + 1e-9)], stop_weights=[1.0, 1.0], card=model.card)
    with pytest.raises(ParameterError, match="radii become the same number"):
        joint_subject(close, TOLD, name="elbow", real="float")
