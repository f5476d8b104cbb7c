"""What a step of a block of elements costs: counted instructions, the same on a busy machine."""

import platform
import shutil
import sys

import pytest

from places import ROOT

sys.path.insert(0, str(ROOT / "benchmarks"))

import elements as benchmark

needs_callgrind = pytest.mark.skipif(
    shutil.which("valgrind") is None
    or shutil.which("gcc") is None
    or platform.machine() != "x86_64",
    reason="instructions are counted with valgrind for gcc's code on x86-64",
)


@pytest.fixture(scope="module")
def program(tmp_path_factory):
    return benchmark.build(tmp_path_factory.mktemp("elements"), "gcc")


@pytest.mark.slow
@needs_callgrind
@pytest.mark.parametrize("n", [10, 40])
@pytest.mark.parametrize("direction", ["forward", "inverse"])
def test_a_step_takes_no_more_instructions_than_its_budget(program, direction, n):
    for signal, most in zip(("sine", "white"), benchmark.INSTRUCTIONS[direction, n], strict=True):
        found = benchmark.instructions(program, direction, n, signal)
        assert 10 * n < found <= most  # it was the step that was counted


@pytest.mark.slow
@needs_callgrind
def test_a_step_of_four_times_the_elements_takes_no_more_than_four_times_the_instructions(program):
    cost = {n: benchmark.instructions(program, "forward", n, "sine") for n in (10, 40)}
    assert cost[40] <= 4 * cost[10]


def test_the_benchmark_can_miss_its_limits():
    row = {"step": "inverse", "n": 40, "signal": "sine", "ns": 999.0, "instructions": 15999.0}
    assert not benchmark.missed(
        [row, {**row, "signal": "white", "ns": 5000.0, "instructions": 26999.0}]
    )
    assert "40 elements, sine: 1001 ns > 1000" in benchmark.missed([{**row, "ns": 1001.0}])[0]
    assert (
        "instructions > 4900"
        in benchmark.missed([{**row, "n": 10, "ns": 5000.0, "instructions": 4901.0}])[0]
    )
