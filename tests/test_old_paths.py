"""Modules under the paths they had before the two floors are gone; public names have not moved."""

import importlib
import subprocess
import sys

import pytest

import dehyst


@pytest.mark.parametrize("old", ["dehyst.plants", "dehyst.plant.arm", "dehyst.muscles.base", "dehyst.evaluation"])
def test_a_path_that_is_none_is_refused_as_python_refuses_it(old):
    with pytest.raises(ModuleNotFoundError, match=r"dehyst\."):
        importlib.import_module(old)


def test_public_names_warn_of_nothing():
    program = "import dehyst\nfor name in dehyst.__all__: getattr(dehyst, name)"
    subprocess.run([sys.executable, "-W", "error::DeprecationWarning", "-c", program], check=True)
    assert len(dehyst.__all__) > 60
