"""libFuzzer with address and undefined-behaviour sanitizers: steps, images of states and parameters, the controller."""

from __future__ import annotations

import os
import re
import subprocess
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from outcome import CORE, HERE, Failed, Proof, said, sources, tool, version
from parameters import Block, inverse, mapped

CURE = "on Debian: apt-get install clang libclang-rt-14-dev (the number is that of clang)"
# Fuzzer -> its block, runs of a full proof, longest input.
FUZZERS: dict[str, tuple[Block, int, int]] = {
    "step": (mapped(inverse(4)), 1_500_000, 150),
    "restore": (mapped(inverse(4)), 3_500_000, 150),
    "load": (inverse(1), 3_500_000, 250),
    "joint": (inverse(4), 1_500_000, 150),
    "direct": (inverse(4), 1_500_000, 250),
    "elements": (inverse(1), 1_500_000, 300),
}
DONE = re.compile(r"Done (\d+) runs")
LET_IN = re.compile(r"let in (\d+) blocks of (\d+) operators")  # by the fuzzer of parameters, for each number


def built(folder: Path, name: str, block: Block) -> Path:
    """Compile a fuzzer."""
    Path(folder, "parameters.h").write_text('#include "dehyst.h"\n' + block.declarations(), encoding="utf-8")
    program = folder / name
    options = ["-std=c11", "-O2", "-g", "-fsanitize=fuzzer,address,undefined", "-fno-sanitize-recover=all"]
    said(
        [
            tool(CURE, "clang"),
            *options,
            f"-I{folder}",
            f"-I{CORE}",
            f"-I{HERE}",
            *sources(),
            HERE / "fuzz" / f"{name}.c",
            "-o",
            program,
        ]
    )
    return program


def plain_block(operators: int) -> bytes:
    """Return an input from which the fuzzer of parameters builds a block that is let in."""
    zero, one = 124, 188  # bytes of these reals
    thresholds, slopes = [zero, *[one] * operators], [one] * (operators + 1)
    centre_and_offset, ranges, line = [zero] * 3, [60, one, one] * 3, [zero] * 3
    head, fade, all_reals, steps = [7, operators - 1, 0, 0], 128, 1, [1, one, 1, zero]
    return bytes([*head, *thresholds, *slopes, *centre_and_offset, *ranges, *line, fade, all_reals, *steps])


def plain_sum(kind: int) -> bytes:
    """Return an input from which the fuzzer of elements builds the input beside one of a kind, and moves them."""
    zero, half, one = 124, 156, 188  # bytes of these reals
    maps, range_, schedules = [0, 0, zero], [60, one], [0, *[0, zero, one] * 3]
    elements = [0, 0, zero, zero, one, 0, kind, 0, half, half, half, 0]
    return bytes(
        [2, *maps, *range_, *schedules, *elements, 1, zero, *[zero, zero, half, 1, zero, zero, 60, 0, one] * 4]
    )


def fuzzed(name: str, runs: int, seed: int) -> int:
    """Build and run a fuzzer; return how many runs it made.

    Raises
    ------
    Failed
        If it found anything; the message has the input.
    """
    block, _, longest = FUZZERS[name]
    with tempfile.TemporaryDirectory() as folder:
        program = built(Path(folder), name, block)
        begin = Path(folder, "begin")
        begin.mkdir()
        for operators in range(1, 7) if name == "load" else ():
            (begin / str(operators)).write_bytes(plain_block(operators))
        for kind in range(8) if name == "elements" else ():
            (begin / str(kind)).write_bytes(plain_sum(kind))
        options = [f"-runs={runs}", f"-max_len={longest}", "-detect_leaks=0", f"-seed={seed}", "-print_final_stats=0"]
        done = subprocess.run([program, *options, begin], cwd=folder, capture_output=True, text=True, check=False)
    made = DONE.search(done.stderr)
    if done.returncode or not made:
        raise Failed(f"fuzzer {name} found something:\n{done.stderr[-1500:]}")
    for blocks, operators in LET_IN.findall(done.stderr):
        if not int(blocks):
            raise Failed(f"fuzzer {name} let in no block of {operators} operators: it proves nothing about them")
    return int(made[1])


def run(quick: bool) -> tuple[str, str, str]:
    """Run all fuzzers, as many at a time as there are cores."""
    tool(CURE, "clang")
    parts = [(name, runs // 100 if quick else runs) for name, (_, runs, _) in FUZZERS.items()]
    with ThreadPoolExecutor(max(1, len(os.sched_getaffinity(0)))) as pool:
        made = list(pool.map(lambda part: fuzzed(part[0], part[1], 1), parts))
    return (
        f"clang {version(tool(CURE, 'clang'))}, libFuzzer, ASan, UBSan",
        f"{', '.join(FUZZERS)}",
        (f"{sum(made):,} runs without a finding".replace(",", " ")),
    )


PROOFS = (Proof("fuzz", "no input, image or sequence of calls leads to undefined behaviour or out of a range", run),)
