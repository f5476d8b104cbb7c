"""The core does what its text says, and keeps its bits, which exports in use have. And the soak, for a few seconds."""

import sys

import numpy as np
import pytest

from places import ROOT, SUPPORT
from test_core_build import CORE, SOURCES, run, tool

PROGRAM = SUPPORT.joinpath("core_bits.c")
RECORDED = PROGRAM.with_suffix(".txt").read_text(encoding="utf-8")
sys.path.insert(0, str(ROOT / "benchmarks"))


def bits(folder, *options, sources=SOURCES, compilers=("gcc", "clang", "cc")):
    compiler = tool(*compilers)
    run(
        compiler,
        "-std=c11",
        "-ffp-contract=off",
        *options,
        f"-I{CORE}",
        PROGRAM,
        *sources,
        "-o",
        folder / "bits",
    )
    return run(folder / "bits")


@pytest.mark.slow
@pytest.mark.parametrize("level", ["-O0", "-O3"])
def test_every_part_of_the_core_has_the_bits_that_were_recorded(level, tmp_path):
    assert bits(tmp_path, level) == RECORDED


@pytest.mark.slow
def test_clang_makes_the_same_bits(tmp_path):
    assert bits(tmp_path, "-O2", compilers=("clang",)) == RECORDED


@pytest.mark.slow
@pytest.mark.parametrize(
    "level", [["-O3"], ["-O1", "-fsanitize=address,undefined", "-fno-sanitize-recover=all"]]
)
def test_the_claims_of_the_core_hold(level, tmp_path):
    program = SUPPORT.joinpath("core_claims.c")
    options = ["-std=c11", "-Wall", "-Wextra", "-Werror", "-ffp-contract=off", *level]
    run(
        tool("gcc", "clang", "cc"),
        *options,
        f"-I{CORE}",
        program,
        *SOURCES,
        "-lm",
        "-o",
        tmp_path / "claims",
    )
    assert run(tmp_path / "claims") == "0 claims do not hold\n"


@pytest.mark.slow
def test_one_changed_sign_changes_them(tmp_path):
    changed = tmp_path / "learning.c"
    text = (CORE / "learning.c").read_text(encoding="utf-8")
    assert "error - dead_zone" in text
    changed.write_text(text.replace("error - dead_zone", "error + dead_zone"), encoding="utf-8")
    sources = [s for s in SOURCES if s.name != changed.name]
    assert bits(tmp_path, "-O1", sources=[*sources, changed]) != RECORDED


@pytest.mark.slow
def test_interrupted_machines_go_on_to_the_bit_as_their_twins_do():
    import soak

    found = soak.soak(0.05, seed=1)
    assert found["differing"] == []
    assert found["continued by a new object"] > 10 and found["taken back and led again"] > 10


@pytest.mark.parametrize("kind", [0, 1, 2, 3])
def test_the_soak_notices_a_machine_that_is_not_restored(kind, monkeypatch):
    import soak

    made = soak.KINDS[kind].fresh
    samples, calls = [], []

    class Forgetful:
        """Restores nothing once it is the second one."""

        def __init__(self, machine, forgets):
            self.machine, self.forgets = machine, forgets

        def __getattr__(self, name):
            return getattr(self.machine, name)

        def __call__(self, *x):
            return self.machine(*x)

        def restore(self, image):
            if not self.forgets:
                self.machine.restore(image)

    def fresh(case):
        calls.append(1)
        return Forgetful(made(case), len(calls) > 3)

    monkeypatch.setattr(soak.KINDS[kind], "fresh", fresh)
    for number in range(6):
        calls.clear()
        samples.append(
            soak.episode(soak.KINDS[kind], np.random.default_rng([9, number]), soak.Counter(), 1500)
        )
    assert any(s is not None for s in samples)
