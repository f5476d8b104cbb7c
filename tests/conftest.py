"""Settings of the whole suite, and the command line as a fixture."""

import os
import sys

import pytest
from hypothesis import HealthCheck, settings

# Two cores, several suites at once: a slow example is not a failure, and a failure must come back tomorrow. `make
# machines` tries three times as many examples.
settings.register_profile(
    "dehyst",
    deadline=None,
    derandomize=True,
    max_examples=int(os.environ.get("EXAMPLES", "40")),
    suppress_health_check=[HealthCheck.too_slow],
)
settings.load_profile("dehyst")


@pytest.fixture
def one_compiler():
    """`verify` and FMUs with one compiler at one level: all of them are for tests/test_export_fmu.py and
    test_rows_on_targets.py, zig's platforms for test_export_platforms.py."""
    from fmu_tools import quickly

    with quickly():
        yield


@pytest.fixture
def run(monkeypatch, capsys):
    """Run one command line in this process; return exit status, stdout, stderr."""

    from dehyst import cli  # not for every test: it has to be quick to begin

    def command(*arguments):
        monkeypatch.setattr(sys, "argv", ["dehyst", *map(str, arguments)])
        capsys.readouterr()
        try:
            cli.main()
            status = 0
        except SystemExit as end:
            status = end.code or 0
        out, err = capsys.readouterr()
        assert "Traceback" not in out + err
        return status, out, err

    return command
