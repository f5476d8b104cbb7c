"""Every example in a docstring runs and prints what it shows, in the package as it is installed."""

import doctest
import importlib
import pkgutil

import pytest

import dehyst

MODULES = sorted(
    module.name
    for module in pkgutil.walk_packages(dehyst.__path__, prefix="dehyst.")
    if not module.name.endswith("._native")
)
FLAGS = doctest.NORMALIZE_WHITESPACE | doctest.ELLIPSIS


@pytest.mark.parametrize("name", ["dehyst", *MODULES])
def test_the_examples_in_the_docstrings_run(name: str) -> None:
    found = doctest.testmod(importlib.import_module(name), optionflags=FLAGS)
    assert found.failed == 0


def test_there_are_examples_to_run() -> None:
    finder = doctest.DocTestFinder(exclude_empty=True)
    examples = sum(len(test.examples) for name in MODULES for test in finder.find(importlib.import_module(name)))
    assert examples > 100
