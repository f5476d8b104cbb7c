"""Sums of elements exported to every target: what runs there is the model, forward and inverse."""

import json
import shutil
import subprocess
from unittest.mock import patch

import numpy as np
import pytest

import dehyst_robot
from dehyst.cli import main
from dehyst.errors import ParameterError
from dehyst.export import export, subject_of, verify
from dehyst.families import example
from dehyst.families._elements import Element, ElementModel
from dehyst_robot.export import joint_subject
from element_samples import element_model, random_elements, scheduled_model
from export_samples import make_check, needs_make, play_model

MODELS = {
    "every kind": lambda: element_model(),
    "every kind, identified inversely": lambda: element_model("inverse"),
    "scheduled": lambda: scheduled_model(),
    "scheduled by three signals": lambda: scheduled_model(sources=(0, 1, 2)),
    "scheduled, identified inversely": lambda: scheduled_model("inverse", (0,)),
}


STRICT = "-Wall -Wextra -Wconversion -Wpedantic -Werror"


def told(capsys, *words):
    """Exit status, and what is said."""
    with patch("sys.argv", ["dehyst", *map(str, words)]):
        try:
            main()
            status = 0
        except SystemExit as end:
            status = end.code
    out = capsys.readouterr()
    return status, " ".join((out.out + out.err).split())


def checked(subject, target, folder, compiler="cc"):
    """Export, compile, compare: the words of the check, which must end well."""
    place = export(subject, target, folder).folder
    done = subprocess.run(
        ["make", "-s", "-C", place, "check", f"CC={compiler}", "CFLAGS=-O1", f"WARNINGS={STRICT}"],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.mark.slow
@needs_make
@pytest.mark.parametrize("compiler", ["gcc", "clang"])
@pytest.mark.parametrize("what", ["inverse", "forward"])
@pytest.mark.parametrize("model", MODELS)
def test_exported_c_has_the_bits_of_the_model_from_either_compiler(model, what, compiler, tmp_path):
    if shutil.which(compiler) is None:
        pytest.skip(f"no {compiler}")
    told = checked(
        subject_of(MODELS[model](), what, name="unit_1", ramp=40), "c", tmp_path / "out", compiler
    )
    assert (
        "bits of the model" in told
        and "a damaged image is refused" in told
        and "output in range" in told
    )


@pytest.mark.slow
@needs_make
@pytest.mark.parametrize("seed", range(4))
def test_random_sums_have_the_bits_of_the_model_in_c_and_keep_to_the_tolerance_in_float(
    seed, tmp_path
):
    model = random_elements(np.random.default_rng(seed))
    for what in ("inverse", "forward"):
        for real in ("double", "float"):
            subject = subject_of(model, what, name="unit_1", real=real, ramp=40)
            checked(subject, "c" if seed % 2 else "c-header", tmp_path / f"{what}_{real}")
            assert subject.tolerances[0] < 1e-3 * (subject.output.high - subject.output.low)


@pytest.mark.slow
@needs_make
@pytest.mark.parametrize(
    ("target", "real"), [("c-header", "float"), ("fmu2", "double"), ("fmu3", "double"), ("fmu3", "float"),
                         ("simulink", "double"), ("simulink", "float"), ("arduino", "float"),
                         ("st", "double"), ("st", "float")]
)  # fmt: skip
@pytest.mark.usefixtures("one_compiler")
def test_every_target_is_verified_with_schedules_and_a_period(target, real, tmp_path):
    sources = (0, 1, 2) if real == "double" else (-1, 0, 1)
    model, what = scheduled_model(sources=sources), "inverse"
    if target == "fmu3":
        model, what = element_model(), "forward"
    export(subject_of(model, what, name="unit_1", real=real, ramp=40), target, tmp_path / "out")
    assert [check for check in verify(tmp_path / "out") if not check.ok] == []


@pytest.mark.slow
@needs_make
def test_a_changed_digit_of_an_element_fails_the_check(tmp_path):
    folder = export(subject_of(element_model(), name="unit_1"), "c", tmp_path / "out").folder
    path = folder / "src" / "unit_1.c"
    text = path.read_text()
    line = next(row for row in text.splitlines() if "DEHYST_STOP" in row)
    path.write_text(text.replace(line, line.replace("DEHYST_STOP", "DEHYST_PLAY")))
    done = make_check(folder, tmp_path / "build")
    assert done.returncode != 0 and "FAILED" in done.stdout
    assert not all(check.ok for check in verify(folder))


def test_the_command_exports_a_sum_of_elements_for_the_period_of_its_log_or_another(
    tmp_path, capsys
):
    path = element_model().save(tmp_path / "rig.json")
    assert told(capsys, "export", path, "--target", "c", "--out", tmp_path / "a")[0] == 0
    assert json.loads((tmp_path / "a" / "manifest.json").read_text())["period"] == 0.02
    words = ("--target", "c", "--what", "forward", "--period", "0.01", "--out", tmp_path / "b")
    status, text = told(capsys, "export", path, *words)
    assert status == 0 and "a step takes x, on, every 0.01 s" in text
    assert json.loads((tmp_path / "b" / "manifest.json").read_text())["settings"]["period"] == 0.01


@pytest.mark.slow
def test_a_log_is_part_of_the_proof_where_one_column_is_all_that_goes_in(tmp_path):
    x = np.linspace(-1.0, 3.0, 50)
    subject = subject_of(
        element_model(), "forward", name="unit_1", excerpt=x, excerpt_source="rig.csv"
    )
    export(subject, "c", tmp_path / "out")
    assert subject.excerpt.samples == 50 and all(check.ok for check in verify(tmp_path / "out"))


def test_what_has_no_form_in_the_core_says_so_and_names_what_has(tmp_path, capsys):
    model = example("bouc-wen")
    assert model.no_export and not play_model().no_export and not element_model().no_export
    with pytest.raises(ParameterError, match=r"bouc-wen model runs in Python alone.* elements"):
        subject_of(model, name="unit_1")
    path = model.save(tmp_path / "loop.json")
    status, text = told(capsys, "export", path, "--target", "c", "--out", tmp_path / "out")
    assert status == 2 and "dehyst identify LOG" in text and "without --family" in text


def test_what_a_sum_cannot_be_exported_as_is_refused(tmp_path):
    creeps = ElementModel((Element("input"), Element("creep", time=1.0)), card=play_model().card)
    with pytest.raises(ParameterError, match="--period"):
        subject_of(creeps, name="unit_1")
    still = subject_of(
        ElementModel((Element("input"), Element("play", 0.1)), card=play_model().card),
        name="unit_1",
    )
    assert still.period is None and "period" not in still.settings
    with pytest.raises(ParameterError, match="period"):
        subject_of(play_model(), name="unit_1", period=-0.1)
    with pytest.raises(ParameterError, match=r"too long|switching"):
        subject_of(element_model(), name="unit_1", real="float", ramp=10_000_000)
    parameters = dehyst_robot.control.JointControllerParameters
    with pytest.raises(ParameterError, match="joint controller holds"):
        joint_subject(element_model(), parameters, name="unit_1")


@pytest.mark.slow
@pytest.mark.parametrize("what", ["inverse", "forward"])
@pytest.mark.parametrize("model", MODELS)
def test_structured_text_has_the_bits_of_the_model(model, what, tmp_path):
    export(subject_of(MODELS[model](), what, name="unit_1", ramp=40), "st", tmp_path / "out")
    checks = verify(tmp_path / "out")
    assert [check for check in checks if not check.ok] == []
    assert any("bit for bit the model" in check.detail for check in checks)
