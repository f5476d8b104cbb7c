"""Every example in a docstring runs and prints what it shows, in the package as it is installed."""

import doctest
import importlib
import pkgutil
from importlib.util import find_spec
from pathlib import Path

import pytest

import dehyst

NAMES = ["dehyst", *(module.name for module in pkgutil.walk_packages(dehyst.__path__, prefix="dehyst."))]
FILES = {name: Path(find_spec(name).origin) for name in NAMES}
MODULES = [name for name, path in FILES.items() if path.suffix == ".py" and ">>>" in path.read_text(encoding="utf-8")]
FLAGS = doctest.NORMALIZE_WHITESPACE | doctest.ELLIPSIS


@pytest.mark.parametrize("name", MODULES)
def test_the_examples_in_the_docstrings_run(name: str) -> None:
    found = doctest.testmod(importlib.import_module(name), optionflags=FLAGS)
    assert found.failed == 0


def test_there_are_examples_to_run() -> None:
    finder = doctest.DocTestFinder(exclude_empty=True)
    examples = sum(len(test.examples) for name in MODULES for test in finder.find(importlib.import_module(name)))
    assert examples > 100
