"""Every example in a docstring runs and prints what it shows, in the installed package and in the benchmarks."""

import doctest
import importlib
import pkgutil
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest

from places import ROOT, SOURCES

BENCHMARKS = ROOT / "benchmarks"
sys.path.insert(0, str(BENCHMARKS))
PACKAGES = {
    **{name: [str(folder)] for name, folder in SOURCES.items()},
    **{name: [str(BENCHMARKS / name)] for name in ("oscillator", "studies")},
}
NAMES = [
    name
    for package, path in PACKAGES.items()
    for name in (
        package,
        *(module.name for module in pkgutil.walk_packages(path, prefix=f"{package}.")),
    )
]
FILES = {name: Path(find_spec(name).origin) for name in NAMES}
MODULES = [
    name
    for name, path in FILES.items()
    if path.suffix == ".py" and ">>>" in path.read_text(encoding="utf-8")
]
FLAGS = doctest.NORMALIZE_WHITESPACE | doctest.ELLIPSIS


ROOMS: dict[str, list[str]] = {}  # two parts of a name: dehyst.models
for _name in MODULES:
    ROOMS.setdefault(
        ".".join(_name.split(".")[: 3 if _name.startswith("dehyst_robot.") else 2]), []
    ).append(_name)


@pytest.mark.slow
@pytest.mark.spread(len(ROOMS))
@pytest.mark.parametrize("room", ROOMS)
def test_the_examples_in_the_docstrings_run(room: str, capsys: pytest.CaptureFixture[str]) -> None:
    failed = [
        name
        for name in ROOMS[room]
        if doctest.testmod(importlib.import_module(name), optionflags=FLAGS).failed
    ]
    assert not failed, (
        f"correct the examples of {', '.join(failed)}:\n{capsys.readouterr().out}"
    )  # with file and line


def test_there_are_examples_to_run() -> None:
    finder = doctest.DocTestFinder(exclude_empty=True)
    examples = sum(
        len(test.examples)
        for name in MODULES
        for test in finder.find(importlib.import_module(name))
    )
    assert examples > 100
