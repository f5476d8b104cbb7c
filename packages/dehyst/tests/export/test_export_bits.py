"""Exported C gives the bits of the extension: the files that an export writes are what is compiled here.

Here some models; `make exports` runs 1 000 of them over 1 000 samples each, with every optimisation level.
"""

import shutil
import sys

import numpy as np
import pytest

from places import ROOT

sys.path.insert(0, str(ROOT / "benchmarks"))

import exports
from target import random_blocks

MODELS, SAMPLES = 30, 250


@pytest.fixture(scope="module", params=["double", "float"])
def compiled(request, tmp_path_factory):
    runs = random_blocks.trials(MODELS, SAMPLES, request.param, seed=23)
    folder = tmp_path_factory.mktemp(request.param)
    exports.write_sources(runs, folder)
    return runs, folder


@pytest.mark.slow
@pytest.mark.parametrize(
    ("compiler", "level", "standard"),
    [("gcc", "-O0", "c99"), ("gcc", "-O3", "c11"), ("clang", "-O2", "c99")],
)
def test_every_sample_of_random_models_is_that_of_the_extension(
    compiled, compiler, level, standard
):
    if shutil.which(compiler) is None:
        pytest.skip(f"no {compiler}; on Debian: apt-get install {compiler}")
    runs, folder = compiled
    found = exports.outcome(runs, folder, compiler, level, f"-std={standard}")
    assert found.wrong == 0
    assert found.worst == 0.0 if runs[0].real == "double" else found.worst <= exports.TOLERANCE


def test_the_comparison_is_not_vacuous(compiled):
    runs, _ = compiled
    limited = [np.mean(run.expected()[1] & 4 > 0) for run in runs]
    rejected = [np.mean(run.expected()[1] & 1 > 0) for run in runs]
    assert sum(0 < share < 1 for share in limited) > MODELS / 2
    assert max(rejected) > 0
    assert {run.block.direction for run in runs} == {"inverse", "forward"}
    assert any(run.case.block.model.before or run.case.block.model.after for run in runs)


@pytest.mark.slow
def test_one_changed_digit_is_noticed(compiled, tmp_path):
    runs, folder = compiled
    if runs[0].real == "float":
        pytest.skip("float has a tolerance; the digit is that of a double")
    if shutil.which("gcc") is None:
        pytest.skip("no gcc; on Debian: apt-get install gcc")
    shutil.copytree(folder, tmp_path, dirs_exist_ok=True)
    source = tmp_path / "unit_3.c"
    text = source.read_text()
    line = next(line for line in text.splitlines() if line.endswith("/* offset */"))
    value = float.fromhex(line.split()[0])
    source.write_text(
        text.replace(line, f"{np.nextafter(value, 2 * value + 1).hex()} /* offset */")
    )
    assert exports.outcome(runs, tmp_path, "gcc", "-O1").wrong == 1
