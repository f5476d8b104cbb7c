"""What other packages add is found by their entry points; what is missing is named with what to type."""

import pytest

from dehyst import cli, plugins
from export_samples import play_model

COMMAND = """
from dataclasses import dataclass
from dehyst.app.command import Command
from dehyst.app.requests import argument


@dataclass(frozen=True, eq=False)
class GreetRequest:
    \"\"\"Greet somebody.\"\"\"

    name: str = argument("Who.")


def greet(request):
    print(f"hello {request.name}")


GREET = Command("stranger_commands:greet", GreetRequest)
"""


@pytest.fixture
def fresh(monkeypatch):
    """The command line as a new process has it: commands that a test adds go with it."""
    monkeypatch.setattr(cli.app, "registered_commands", list(cli.app.registered_commands))
    plugins.added.cache_clear()
    yield
    plugins.added.cache_clear()


def test_a_command_of_a_strangers_package_is_one_of_dehyst(fresh, run, tmp_path, monkeypatch):
    (tmp_path / "stranger_commands.py").write_text(COMMAND)
    about = tmp_path / "stranger-1.0.dist-info"
    about.mkdir()
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: stranger\nVersion: 1.0\n")
    (about / "entry_points.txt").write_text("[dehyst.commands]\ngreet = stranger_commands:GREET\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    status, out, _ = run("greet", "world")
    assert (status, out) == (0, "hello world\n")
    assert "greet" in run("--help")[1]


TARGET = """
from dehyst.export import c
from dehyst.export.compilers import check_folder
from dehyst.export.targets import Target


def files(subject):
    return {**c.files(subject), "STRANGER.txt": subject.title}


def verify(folder, subject):
    return check_folder(folder)


STRANGER = Target("stranger", "C with a note", "stranger_target")
"""


def test_a_target_of_a_strangers_package_is_exported(fresh, run, tmp_path, monkeypatch):
    (tmp_path / "stranger_target.py").write_text(TARGET)
    about = tmp_path / "stranger-1.0.dist-info"
    about.mkdir()
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: stranger\nVersion: 1.0\n")
    (about / "entry_points.txt").write_text("[dehyst.targets]\nstranger = stranger_target:STRANGER\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    play_model().save(tmp_path / "model.json")
    status, _, err = run("export", tmp_path / "model.json", "--target", "stranger", "--out", tmp_path / "out")
    assert status == 0, err
    assert "operators" in (tmp_path / "out" / "STRANGER.txt").read_text()
    status, _, err = run("export", tmp_path / "model.json", "--target", "nothing", "--out", tmp_path / "none")
    assert status == 2 and "stranger (C with a note)" in " ".join(err.split())


@pytest.mark.parametrize(
    ("words", "package"),
    [(("reproduce", "--quick"), "dehyst-robot"), (("rig", "check", "arm.toml"), "dehyst-robot")],
)
def test_a_command_of_a_package_that_is_missing_says_what_to_type(fresh, run, monkeypatch, words, package):
    monkeypatch.setattr(cli, "added", lambda group: {})
    names = {entry.callback.__name__: entry for entry in cli.app.registered_commands}
    kernel = {command.name for command in cli.COMMANDS}
    monkeypatch.setattr(cli.app, "registered_commands", [names[name] for name in names if name in kernel])
    status, out, err = run(*words)
    assert status == 2 and out == ""
    assert f"pip install {package}" in " ".join(err.split())


def test_a_kind_of_controller_whose_package_is_missing_says_what_to_type(run, tmp_path, monkeypatch):
    from dehyst.export import kinds

    monkeypatch.setattr(kinds, "added", lambda group: {})
    play_model().save(tmp_path / "model.json")
    (tmp_path / "controller.json").write_text("{}")
    line = ("export", tmp_path / "model.json", "--target", "c", "--out", tmp_path / "out", "--what", "joint-controller")
    status, _, err = run(*line, "--controller", tmp_path / "controller.json")
    assert status == 2
    assert "pip install dehyst-robot" in " ".join(err.split())


def test_every_name_of_a_package_that_is_installed_is_found():
    points = plugins.added("dehyst.commands") | plugins.added("dehyst.controllers")
    assert set(plugins.PACKAGES["dehyst-robot"]) <= set(points)
