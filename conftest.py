"""Settings of the whole suite, and the command line as a fixture."""

import gc
import os
import sys
from pathlib import Path

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

# Tests use the claims of other tests; each file has a name of its own.
ROOT = Path(__file__).resolve().parent
for folder in ("tests", *sorted(map(str, ROOT.glob("packages/*/tests/*")))):
    sys.path.append(str(ROOT / folder))

# Processes of pytest-xdist have a core each: threads of BLAS would only wait for each other's.
if "PYTEST_XDIST_WORKER" in os.environ:
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items):
    """Of a test with many cases the middle ones are exhaustive.

    What is left are the first and the last of a slow test, and those of `spread` that lie evenly between them.
    """
    cases = {}
    for item in items:
        if item.get_closest_marker("exhaustive"):
            item.add_marker("slow")
        elif item.get_closest_marker("slow") or item.get_closest_marker("spread"):
            slow = item.get_closest_marker("slow") is not None
            cases.setdefault((item.nodeid.partition("[")[0], slow), []).append(item)
    for of_one_test in cases.values():
        spread = of_one_test[0].get_closest_marker("spread")
        count = spread.args[0] if spread else 2
        last = len(of_one_test) - 1
        run = {round(last * k / (count - 1)) for k in range(count)}
        for place, item in enumerate(of_one_test):
            if place not in run:
                item.add_marker("exhaustive")
                item.add_marker("slow")


@pytest.hookimpl(hookwrapper=True)
def pytest_collection():
    """Modules and tests stay to the end: to look through them for garbage takes a third of the collection."""
    gc.disable()
    yield
    gc.freeze()
    gc.enable()


@pytest.fixture
def one_compiler():
    """`verify` and FMUs with one compiler at one level.

    All compilers are for test_export_fmu.py and test_rows_on_targets.py, zig's platforms for test_export_platforms.py.
    """
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
