"""Lines to type arrive as they were meant, in POSIX shells and on Windows, and are the same wherever they can be."""

import os
import re
import shlex
import shutil
import subprocess

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dehyst.shell import quoted, typed
from places import SOURCES

WORDS = st.text(st.characters(min_codepoint=32, exclude_categories=["Cs", "Cc"]), max_size=20)
ASCII = st.text(st.sampled_from(list(map(chr, range(32, 127)))), max_size=12)
COMMON = st.text(st.sampled_from(list(" abc[]()%#,;&|<>'^*?~{}@=-+./:0")), max_size=12)


def windows_words(line):
    """Take a line apart as programs on Windows do (CommandLineToArgvW): the oracle, by the documented rules."""
    words, word, inside, begun, k = [], "", False, False, 0
    while k < len(line):
        slashes = len(re.match(r"\\*", line[k:])[0])
        k += slashes
        if k < len(line) and line[k] == '"':
            word, begun = word + "\\" * (slashes // 2), True
            if slashes % 2:
                word += '"'
            else:
                inside = not inside
            k += 1
            continue
        word, begun = word + "\\" * slashes, begun or slashes > 0
        if k < len(line):
            if line[k] == " " and not inside:
                words += [word] if begun else []
                word, begun = "", False
            else:
                word, begun = word + line[k], True
            k += 1
    return words + ([word] if begun else [])


@given(st.lists(st.one_of(WORDS, ASCII), max_size=4))
def test_words_arrive_in_a_posix_shell(words):
    assert shlex.split(typed(words)) == words


@pytest.mark.parametrize("shell", ["sh", "bash", "dash", "zsh"])
def test_words_arrive_in_the_shells_of_this_machine(shell):
    if shutil.which(shell) is None:
        pytest.skip(f"no {shell}")

    @given(ASCII)
    def arrives(word):
        done = subprocess.run(
            [shell, "-c", f"printf '%s' {quoted(word)}"], capture_output=True, text=True, check=True
        )
        assert done.stdout == word

    arrives()


@given(st.lists(st.one_of(WORDS, ASCII), max_size=4))
def test_words_arrive_on_windows(words):
    with pytest.MonkeyPatch.context() as windows:
        windows.setattr(os, "name", "nt")
        line = typed(words)
    assert windows_words(line) == words


@given(COMMON)
def test_what_no_shell_reads_between_double_quotes_is_the_same_everywhere(word):
    with pytest.MonkeyPatch.context() as windows:
        windows.setattr(os, "name", "nt")
        there = quoted(word)
    assert there == quoted(word)
    assert "'" not in there.replace(word, "")


def test_there_is_one_place_that_quotes():
    sources = [path for folder in SOURCES.values() for path in folder.rglob("*.py")]
    assert [path.name for path in sources if "shlex" in path.read_text(encoding="utf-8")] == [
        "shell.py"
    ]
