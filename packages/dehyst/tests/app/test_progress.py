"""What takes long says so on a terminal, with the time that has passed, and nowhere else."""

import io
import sys

import pytest

from dehyst.app import ask_progress


class Screen(io.StringIO):
    """An error stream that says whether it is a terminal."""

    def __init__(self, terminal):
        super().__init__()
        self.terminal = terminal

    def isatty(self):
        return self.terminal


@pytest.mark.parametrize(
    ("terminal", "quiet", "shown"),
    [(True, False, True), (True, True, False), (False, False, False)],
)
def test_a_terminal_sees_what_goes_on_and_for_how_long_and_a_pipe_nothing(
    monkeypatch, terminal, quiet, shown
):
    screen = Screen(terminal)
    monkeypatch.setattr(sys, "stderr", screen)
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setenv("COLUMNS", "80")
    with ask_progress("reading", quiet):
        pass
    text = screen.getvalue()
    assert ("reading ..." in text and "0:00:0" in text) == shown and bool(text) == shown
