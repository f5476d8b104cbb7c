"""Tab completion works in the shells that typer knows, and costs nothing."""

import os
import subprocess
import sys

import pytest

LINES = {
    "bash": {"COMP_WORDS": "dehyst comp", "COMP_CWORD": "1"},
    "zsh": {"_TYPER_COMPLETE_ARGS": "dehyst comp"},
    "fish": {"_TYPER_COMPLETE_ARGS": "dehyst comp", "_TYPER_COMPLETE_FISH_ACTION": "get-args"},
}


def complete(shell, **more):
    environment = os.environ | {"_DEHYST_COMPLETE": f"complete_{shell}"} | LINES[shell] | more
    command = [
        sys.executable,
        "-c",
        "import sys; sys.argv = ['dehyst']; from dehyst.cli import main; main()",
    ]
    return subprocess.run(command, env=environment, capture_output=True, text=True, check=False)


@pytest.mark.parametrize("shell", LINES)
def test_commands_are_completed(shell):
    done = complete(shell)
    assert "compare" in done.stdout
    assert "compensate" in done.stdout
    assert "identify" not in done.stdout.replace("Identify", "")
    assert done.stderr == ""


def test_options_are_completed():
    assert (
        "--initial-state"
        in complete("bash", COMP_WORDS="dehyst identify --in", COMP_CWORD="2").stdout
    )


def test_a_script_for_the_shell_is_shown(run, monkeypatch):
    monkeypatch.setenv(
        "_TYPER_COMPLETE_TEST_DISABLE_SHELL_DETECTION", "1"
    )  # else that of the parent counts
    status, out, _ = run("--show-completion", "bash")
    assert status == 0
    assert "complete_bash $1" in out


def test_completion_loads_nothing_that_help_does_without():
    """What completion adds to the modules of `dehyst --help`, with typer's own switch for it off and on."""
    line = (
        "import sys, contextlib, io; import dehyst.cli as cli; cli.app._add_completion = {on}; sys.argv = "
        "['dehyst', '--help']\nwith contextlib.redirect_stdout(io.StringIO()), contextlib.suppress(SystemExit): "
        "cli.main()\nprint(sorted(sys.modules))"
    )
    commands = [[sys.executable, "-c", line.format(on=on)] for on in (False, True)]
    off, on = (
        subprocess.run(each, capture_output=True, text=True, check=True).stdout for each in commands
    )
    assert on == off
