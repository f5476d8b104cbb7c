"""Blocks in C with parameters of every size and inputs of every bit pattern, in both precisions, under -Ofast."""

import pytest

from places import SUPPORT
from test_core_build import CORE, PRECISIONS, SOURCES, run, tool

PROGRAM = SUPPORT.joinpath("block_random.c")
BLOCKS = 6000  # 60 steps each; 1 000 000 blocks without a finding when the numbers were chosen
BUILDS = {
    "plain": ["-O2", "-ffp-contract=off"],
    "fast": ["-Ofast"],
    "sanitized": ["-O1", "-fsanitize=address,undefined", "-fno-sanitize-recover=all"],
}


@pytest.mark.exhaustive
@PRECISIONS
@pytest.mark.parametrize("build", BUILDS)
def test_no_accepted_block_leaves_its_range_its_states_or_its_bits(build, precision, tmp_path):
    compiler = tool("gcc", "clang", "cc")
    binary = tmp_path / "block_random"
    run(
        compiler,
        "-std=c11",
        *BUILDS[build],
        *precision,
        f"-I{CORE}",
        PROGRAM,
        *SOURCES,
        "-lm",
        "-o",
        binary,
    )
    accepted = int(run(binary, BLOCKS, 1))
    assert accepted > BLOCKS // 3  # both the sane and the wild ones
