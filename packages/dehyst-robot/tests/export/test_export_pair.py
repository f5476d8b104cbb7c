"""A joint controller is exported with the model that it was made for, and with no other one."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest

from dehyst.cli import main
from dehyst.errors import ModelFileError
from dehyst.models import (
    DirectInverse,
    ModelCard,
    PrandtlIshlinskii,
    SignalCard,
    load,
    model_to_dict,
)
from dehyst_robot.control import (
    Adaptation,
    JointControllerParameters,
    load_adaptation,
    load_controller,
    load_partner,
    save_controller,
)
from dehyst_robot.export._kind import KIND
from export_samples import play_model

CARD = ModelCard(SignalCard("sheared", "bar", -3.0, 3.0), SignalCard("angle", "rad", -0.6, 0.6))
PLAYS = PrandtlIshlinskii([0.0, 0.5], [0.1, 0.2], card=CARD)
DIRECT = DirectInverse(
    radii=[0.1], stop_weights=[1.0], card=replace(CARD, input=SignalCard("torque", "Nm", -9.0, 9.0))
)
PLAIN = replace(CARD, input=SignalCard("pressure_difference", "bar", -3.0, 3.0))


@pytest.fixture
def place(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    PLAYS.save("plays.json")
    DIRECT.save("direct.json")
    return tmp_path


def command(monkeypatch, capsys, model, controller):
    words = (
        "export",
        model,
        "--target",
        "c",
        "--what",
        "joint-controller",
        "--controller",
        controller,
    )
    monkeypatch.setattr("sys.argv", ["dehyst", *words, "--out", "out", "--overwrite"])
    with pytest.raises(SystemExit) as end:
        main()
    return int(end.value.code or 0), capsys.readouterr()


@pytest.mark.parametrize(
    ("own", "other"), [("plays.json", "direct.json"), ("direct.json", "plays.json")]
)
def test_a_controller_of_another_model_is_refused_by_name_before_anything_is_written(
    place, monkeypatch, capsys, own, other
):
    save_controller(JointControllerParameters(shear=0.0), "controller.json", model=load(own))
    status, said = command(monkeypatch, capsys, other, "controller.json")
    told = " ".join(said.err.split())
    assert status == 2
    assert not (place / "out").exists()
    assert "another model" in told
    assert other in told
    assert str(model_to_dict(load(own))["sha256"])[:12] in told
    assert str(model_to_dict(load(other))["sha256"])[:12] in told
    assert "save_controller" in told
    assert command(monkeypatch, capsys, own, "controller.json")[0] == 0


@pytest.mark.parametrize(
    ("model", "shear", "warned"),
    [
        (PLAYS, 0.0, True),
        (PLAYS, 1e5, False),
        (DIRECT, 1e5, True),
        (DIRECT, 0.0, False),
        (PLAYS.with_card(PLAIN), 0.0, False),
    ],
)
def test_without_a_checksum_a_shear_that_does_not_go_with_the_model_is_named(
    place, model, shear, warned
):
    path = save_controller(JointControllerParameters(shear=shear), place / "controller.json")
    found = KIND.pair_findings(model, place / "model.json", path)
    assert [finding.code for finding in found] == ["pair-doubtful"] * warned


def test_a_warning_of_the_pair_is_printed_and_the_export_is_written(place, monkeypatch, capsys):
    save_controller(JointControllerParameters(shear=0.0), "controller.json")
    status, said = command(monkeypatch, capsys, "plays.json", "controller.json")
    assert status == 0
    assert "pair-doubtful" in said.out + said.err


def test_parameters_adaptation_and_partner_come_back(tmp_path):
    parameters, learning = JointControllerParameters(pole=7.0), Adaptation(rate=0.4)
    for given in (
        {},
        {"adaptation": learning},
        {"model": PLAYS},
        {"adaptation": learning, "model": PLAYS},
    ):
        path = save_controller(parameters, tmp_path / "controller.json", **given)
        assert json.loads(path.read_text())["schema"] == 1
        assert load_controller(path) == parameters
        assert load_adaptation(path) == given.get("adaptation")
        assert (load_partner(path) or ("",))[0] == (
            model_to_dict(PLAYS)["sha256"] if "model" in given else ""
        )


@pytest.mark.parametrize("change", [{"sha256": "0" * 64}, {"about": "another"}])
def test_a_partner_that_was_edited_is_refused(tmp_path, change):
    path = save_controller(JointControllerParameters(), tmp_path / "c.json", model=play_model())
    content = json.loads(path.read_text())
    content["model"] |= change
    path.write_text(json.dumps(content))
    with pytest.raises(ModelFileError, match="checksum"):
        load_partner(path)
