"""What other packages add is found by their entry points; what is missing is named with what to type."""

import json
import sys

import numpy as np
import pytest

import dehyst
from dehyst import cli, families, plugins
from dehyst.errors import ParameterError
from dehyst.io import example_recording
from export_samples import play_model

COMMAND = """
from dataclasses import dataclass
from dehyst.app._command import Command
from dehyst.app.requests import argument


@dataclass(frozen=True, eq=False)
class GreetRequest:
    \"\"\"Greet somebody.\"\"\"

    name: str = argument("Who.")


def greet(request):
    print(f"hello {request.name}")


GREET = Command("stranger_commands:greet", GreetRequest)
"""


def install_stranger(folder, monkeypatch, group, points, module, source):
    """A stranger's package on the path, as pip would have installed it."""
    (folder / f"{module}.py").write_text(source)
    about = folder / "stranger-1.0.dist-info"
    about.mkdir()
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: stranger\nVersion: 1.0\n")
    lines = "".join(f"{name} = {value}\n" for name, value in points.items())
    (about / "entry_points.txt").write_text(f"[{group}]\n{lines}")
    monkeypatch.syspath_prepend(str(folder))
    monkeypatch.delitem(sys.modules, module, raising=False)


@pytest.fixture
def fresh(monkeypatch):
    """The command line as a new process has it: commands that a test adds go with it."""
    monkeypatch.setattr(cli.app, "registered_commands", list(cli.app.registered_commands))
    plugins.added.cache_clear()
    yield
    plugins.added.cache_clear()


def test_a_command_of_a_strangers_package_is_one_of_dehyst(fresh, run, tmp_path, monkeypatch):
    points = {"greet": "stranger_commands:GREET"}
    install_stranger(tmp_path, monkeypatch, "dehyst.commands", points, "stranger_commands", COMMAND)
    status, out, _ = run("greet", "world")
    assert (status, out) == (0, "hello world\n")
    assert "greet" in run("--help")[1]


def test_a_strangers_command_that_cannot_be_loaded_takes_no_other_with_it(
    fresh, run, tmp_path, monkeypatch
):
    points = {"greet": "stranger_commands:GREET", "stale": "stranger_commands:GONE"}
    install_stranger(tmp_path, monkeypatch, "dehyst.commands", points, "stranger_commands", COMMAND)
    assert run("greet", "world")[:2] == (0, "hello world\n")
    status, out, err = run("stale")
    assert (status, out) == (2, "")
    assert "its package stranger says 'stranger_commands:GONE'" in " ".join(err.split())


FAMILY = """
from dataclasses import dataclass, replace

from dehyst.families import Family, family

DAHL = family("dahl")
STRANGER = replace(DAHL, name="dahl-again", title="Dahl, once more")
"""


@pytest.mark.slow
def test_a_family_of_a_strangers_package_is_fitted_and_compared(fresh, tmp_path, monkeypatch):
    points = {"dahl-again": "stranger_family:STRANGER", "stale-family": "stranger_family:GONE"}
    install_stranger(tmp_path, monkeypatch, "dehyst.families", points, "stranger_family", FAMILY)
    assert "dahl-again" in families.names() and not families.is_family("nothing")
    log = example_recording()
    fit = dehyst.identify(log, "dahl-again")
    assert fit.model.parameters() == dehyst.identify(log, "dahl").model.parameters()
    table = dehyst.compare(log, ["static", "dahl-again"])
    assert table["dahl-again"].title.startswith("Dahl, once more")
    with pytest.raises(ParameterError, match="its package stranger says 'stranger_family:GONE'"):
        dehyst.identify(log, "stale-family")


def test_a_strangers_family_does_not_take_the_place_of_auto(fresh, tmp_path, monkeypatch):
    points = {"auto": "stranger_family:STRANGER"}
    install_stranger(tmp_path, monkeypatch, "dehyst.families", points, "stranger_family", FAMILY)
    x = np.sin(np.linspace(0.0, 12.0, 200))
    assert dehyst.identify(dehyst.Recording(x, 2.0 * x)).family == "static"


TARGET = """
from dehyst.export import c
from dehyst.export.kit import Target, Writer, check_folder


def _files(subject):
    return {**c.WRITER.files(subject), "STRANGER.txt": subject.title}


def _verify(folder, subject):
    return check_folder(folder)


WRITER = Writer(_files, _verify)
STRANGER = Target("stranger", "C with a note", "stranger_target")
"""


def test_a_target_of_a_strangers_package_is_exported(fresh, run, tmp_path, monkeypatch):
    points = {"stranger": "stranger_target:STRANGER"}
    install_stranger(tmp_path, monkeypatch, "dehyst.targets", points, "stranger_target", TARGET)
    play_model().save(tmp_path / "model.json")
    status, _, err = run(
        "export", tmp_path / "model.json", "--target", "stranger", "--out", tmp_path / "out"
    )
    assert status == 0, err
    assert "operators" in (tmp_path / "out" / "STRANGER.txt").read_text()
    status, _, err = run(
        "export", tmp_path / "model.json", "--target", "nothing", "--out", tmp_path / "none"
    )
    assert status == 2 and "stranger (C with a note)" in " ".join(err.split())


def test_doctor_lists_what_a_strangers_package_adds(fresh, run, tmp_path, monkeypatch):
    points = {"stranger": "stranger_target:STRANGER"}
    install_stranger(tmp_path, monkeypatch, "dehyst.targets", points, "stranger_target", TARGET)
    parts = json.loads(run("doctor", "--json")[1])["parts"]
    [row] = [part for part in parts if part["name"] == "stranger"]
    assert (row["found"], row["purpose"]) == ("stranger 1.0", "export: stranger")


def test_a_strangers_target_that_cannot_be_loaded_is_named_and_hides_no_other(
    fresh, run, tmp_path, monkeypatch
):
    points = {"stranger": "stranger_target:STRANGER", "stale": "stranger_target:GONE"}
    source = TARGET.replace('"stranger_target"', '"stranger_target.gone"')
    install_stranger(tmp_path, monkeypatch, "dehyst.targets", points, "stranger_target", source)
    play_model().save(tmp_path / "model.json")
    answers = {}
    for target in ("stranger", "stale", "nothing"):
        words = ("export", tmp_path / "model.json", "--target", target, "--out", tmp_path / target)
        status, _, err = run(*words)
        answers[target] = " ".join(err.split())
        assert status == 2, err
    assert "the package stranger_target is installed, but lacks this module" in answers["stranger"]
    assert "its package stranger says 'stranger_target:GONE'" in answers["stale"]
    assert (
        "There are: c (" in answers["nothing"] and "stranger (C with a note)" in answers["nothing"]
    )


@pytest.mark.parametrize(
    ("words", "package"),
    [(("reproduce", "--quick"), "dehyst-robot"), (("rig", "check", "arm.toml"), "dehyst-robot")],
)
def test_a_command_of_a_package_that_is_missing_says_what_to_type(
    fresh, run, monkeypatch, words, package
):
    monkeypatch.setattr(cli, "added", lambda group: {})
    names = {entry.callback.__name__: entry for entry in cli.app.registered_commands}
    kernel = {command.name for command in cli.COMMANDS}
    monkeypatch.setattr(
        cli.app, "registered_commands", [names[name] for name in names if name in kernel]
    )
    status, out, err = run(*words)
    assert status == 2 and out == ""
    assert f"pip install {package}" in " ".join(err.split())


def test_a_kind_of_controller_whose_package_is_missing_says_what_to_type(
    run, tmp_path, monkeypatch
):
    from dehyst.export import _kinds as kinds

    monkeypatch.setattr(kinds, "added", lambda group: {})
    play_model().save(tmp_path / "model.json")
    (tmp_path / "controller.json").write_text("{}")
    line = (
        "export",
        tmp_path / "model.json",
        "--target",
        "c",
        "--out",
        tmp_path / "out",
        "--what",
        "joint-controller",
    )
    status, _, err = run(*line, "--controller", tmp_path / "controller.json")
    assert status == 2
    assert "pip install dehyst-robot" in " ".join(err.split())


def test_every_name_of_a_package_that_is_installed_is_found():
    points = plugins.added("dehyst.commands") | plugins.added("dehyst.controllers")
    for table in (plugins.COMMANDS, plugins.EXPORTS):
        named = {name for name, package in table.items() if package == "dehyst-robot"}
        assert named and named <= set(points)


def test_a_target_whose_module_imports_a_name_that_is_not_there_says_which(
    fresh, tmp_path, monkeypatch
):
    source = """
from dehyst.export.kit import Target

BROKEN = Target("broken", "a target", "stranger_writer")
"""
    points = {"broken": "stranger_row:BROKEN"}
    install_stranger(tmp_path, monkeypatch, "dehyst.targets", points, "stranger_row", source)
    (tmp_path / "stranger_writer.py").write_text("from dehyst.export import no_such_name\n")
    from dehyst.export import export, subject_of

    with pytest.raises(ParameterError, match="module 'stranger_writer' says ImportError"):
        export(subject_of(play_model(), name="elbow"), "broken", tmp_path / "out")
    assert not (tmp_path / "out").exists()
