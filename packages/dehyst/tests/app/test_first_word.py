"""On a terminal a command says that it starts before it loads what it needs, and leaves nothing of that word behind."""

import os
import subprocess
import sys

import pytest

pty = pytest.importorskip("pty")


def said_by(*typed: str) -> bytes:
    """What a command writes on a terminal, to the end."""
    ours, theirs = pty.openpty()
    with subprocess.Popen(
        [sys.executable, "-X", "importtime", "-m", "dehyst", *typed], stdout=theirs, stderr=theirs
    ):
        os.close(theirs)
        said = b""
        while True:
            try:
                part = os.read(ours, 65536)
            except OSError:  # the other end is closed
                return said
            if not part:
                return said
            said += part


def test_the_first_word_of_identify_comes_before_its_arithmetic_is_loaded(tmp_path):
    said = said_by("identify", str(tmp_path / "none.csv"), "--input", "a", "--output", "b")
    first = said.index(b"starting ...")
    assert first < said.index(b" numpy\r\n")
    assert b"\r            \r" in said[first:]


def test_nothing_is_said_where_nobody_looks(tmp_path):
    found = subprocess.run(
        [sys.executable, "-m", "dehyst", "identify", str(tmp_path / "none.csv"), "--input", "a", "--output", "b"],
        capture_output=True, check=False,
    )  # fmt: skip
    assert found.returncode == 2 and b"starting" not in found.stderr
