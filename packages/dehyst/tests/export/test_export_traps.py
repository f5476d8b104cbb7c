"""Exports that would go wrong in somebody's project: other units, names that are taken, two precisions, odd text."""

import re
import shutil
import subprocess
from dataclasses import replace

import numpy as np
import pytest

import dehyst
from dehyst.errors import ParameterError, UnitError
from dehyst.export import export, subject_of
from dehyst.export._names import check_name, identifier, why_prefixed
from dehyst.export._rendering import comment
from dehyst.models import ModelCard
from dehyst_robot.control import JointControllerParameters
from dehyst_robot.export import joint_subject
from dehyst_robot.export._joint import in_radians, unit_findings
from export_samples import CARD, MODELS, play_model

X = np.random.default_rng(0).uniform(-1.0, 2.0, 300)


def with_units(model, pressure, angle):
    return model.with_card(
        ModelCard(
            replace(CARD.input, unit=pressure), replace(CARD.output, unit=angle), CARD.provenance
        )
    )


@pytest.mark.parametrize(
    ("unit", "factor"), [("deg", np.pi / 180), ("mrad", 1e-3), ("rad", 1.0), ("", 1.0)]
)
@pytest.mark.parametrize("model", MODELS)
def test_a_compensator_of_a_controller_works_in_radians(model, unit, factor):
    given = with_units(MODELS[model](), "bar", unit)
    told = in_radians(given, JointControllerParameters())
    assert np.allclose(told.simulate(X), factor * given.simulate(X), rtol=1e-13, atol=1e-14)
    one = joint_subject(given, JointControllerParameters(), name="axis")
    assert one.input.unit == ("rad" if unit else "")
    assert one.input.high == pytest.approx(factor * CARD.output.high, rel=1e-15)


def test_pressures_in_another_unit_than_the_controllers_are_refused_with_the_line_that_cures():
    model = with_units(play_model(), "kPa", "rad")
    with pytest.raises(UnitError, match=r'factor of 100\. Set "compensator_unit": 1000\.0'):
        joint_subject(model, JointControllerParameters(), name="axis")
    assert (
        joint_subject(model, JointControllerParameters(compensator_unit=1000.0), name="axis").joint
        is not None
    )


@pytest.mark.parametrize(
    ("pressure", "angle", "words"), [("V", "rad", "input"), ("bar", "mm", "output")]
)
def test_a_model_that_is_none_of_a_joint_is_refused(pressure, angle, words):
    with pytest.raises(UnitError, match=f"the model's {words} is"):
        joint_subject(
            with_units(play_model(), pressure, angle), JointControllerParameters(), name="axis"
        )


def test_a_unit_that_nobody_knows_is_a_finding():
    assert [one.code for one in unit_findings(with_units(play_model(), "", "furlong"))] == [
        "unit-unknown"
    ] * 2
    assert unit_findings(play_model()) == []


@pytest.mark.parametrize(
    "name",
    [
        "dehyst",
        "stdint",
        "stddef",
        "stdio",
        "stdlib",
        "string",
        "math",
        "float",
        "fmu",
        "fmi2",
        "fmu_1",
        "check",
    ],
)
def test_names_that_would_replace_another_file_are_refused_and_defaults_get_a_prefix(name):
    with pytest.raises(ParameterError, match="is taken"):
        check_name(name)
    assert identifier(name) == f"unit_{name}"
    assert why_prefixed(name)
    assert check_name(identifier(name))


@pytest.mark.slow
def test_units_of_two_precisions_live_in_one_program(tmp_path):
    if shutil.which("cc") is None:
        pytest.skip("no cc; on Debian: apt-get install gcc")
    objects = []
    for name, real in (("left", "double"), ("right", "float")):
        folder = export(subject_of(play_model(), name=name, real=real), "c", tmp_path / name).folder
        use = f'#include "{name}.h"\ndouble use_{name}(double x)\n{{ static {name}_state unit; {name}_reset(&unit);\n'
        (folder / "src" / "use.c").write_text(
            f"{use}return (double){name}_step(&unit, (dehyst_real)x, 1); }}\n"
        )
        for source in sorted((folder / "src").glob("*.c")):
            objects.append(f"{name}_{source.stem}.o")
            subprocess.run(["cc", "-c", source, "-o", objects[-1]], cwd=tmp_path, check=True)
    main = "#include <stdio.h>\ndouble use_left(double x); double use_right(double x);\n"
    main += (
        'int main(void) { printf("%.17g %.17g\\n", use_left(0.7), use_right(0.7)); return 0; }\n'
    )
    (tmp_path / "main.c").write_text(main)
    subprocess.run(["cc", "main.c", *objects, "-o", "program"], cwd=tmp_path, check=True)
    said = subprocess.run(
        ["./program"], cwd=tmp_path, capture_output=True, text=True, check=True
    ).stdout.split()
    want = dehyst.Block(play_model(), "inverse").step(0.7)
    assert float(said[0]) == want
    assert 0 < abs(float(said[1]) - want) < 1e-6


@pytest.mark.parametrize("order", [("left", "right"), ("right", "left")])
def test_a_file_that_finds_the_core_of_the_other_precision_is_refused_by_name(order, tmp_path):
    if shutil.which("cc") is None:
        pytest.skip("no cc; on Debian: apt-get install gcc")
    for name, real in (("left", "double"), ("right", "float")):
        export(subject_of(play_model(), name=name, real=real), "c", tmp_path / name)
    (tmp_path / "both.c").write_text("".join(f'#include "{name}.h"\n' for name in order))
    command = ["cc", "-c", "both.c", "-Ileft/src", "-Iright/src"]
    said = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert said.returncode != 0
    assert f"{order[1]}.h is in " in said.stderr


def test_double_is_refused_where_it_is_short(tmp_path):
    folder = export(subject_of(play_model(), name="unit_1"), "c", tmp_path / "out").folder
    assert "DBL_MANT_DIG < 53" in (folder / "src" / "dehyst_config.h").read_text()


@pytest.mark.parametrize(
    "text", ["???/", "????/", "**//", "/*/*/", "a" * 299 + "\\b", "a" * 298 + "\\\\b", "\\ \\"]
)
def test_no_text_ends_a_comment_or_goes_on_in_the_next_line(text):
    line = comment(text)
    assert not re.search(r"\*/|/\*|//|\?\?|\\$", line)
    assert len(line) <= 300


def test_a_range_of_next_to_nothing_is_refused():
    with pytest.raises(ParameterError, match="less than a millionth"):
        subject_of(play_model(), name="unit_1", range=(0.5, 0.5 + 1e-7))


@pytest.mark.slow
@pytest.mark.parametrize(
    "target", ["c", "c-header", "arduino", "simulink", "st", "fmu3", "rust", "ada"]
)
@pytest.mark.usefixtures("one_compiler")
def test_the_readme_says_near_its_top_what_identification_thought_of_the_model(target, tmp_path):
    for grade, verdict in (
        ("no", "bad: do not compensate with this model"),
        ("good", "good for compensation"),
    ):
        model = play_model(replace(CARD, provenance={"grade": grade, "verdict": verdict}))
        real = "float" if target == "arduino" else "double"
        folder = tmp_path / verdict[:3]
        export(subject_of(model, name="unit_1", real=real), target, folder)
        text = "\n".join((folder / "README.md").read_text(encoding="utf-8").splitlines()[:12])
        assert (verdict in text) == verdict.startswith("bad")
