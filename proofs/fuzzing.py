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
    "element_block": (inverse(1), 1_500_000, 300),
    "pair": (inverse(1), 1_500_000, 300),
}
MINUS, ZERO, HALF, ONE = 60, 124, 156, 188  # bytes of the reals -1, 0, 0.5 and 1
DONE = re.compile(r"Done (\d+) runs")
LET_IN = re.compile(r"let in (\d+) (blocks .+)")  # by fuzzers of parameters, for each kind


def built(folder: Path, name: str, block: Block) -> Path:
    """Compile a fuzzer."""
    Path(folder, "parameters.h").write_text(
        '#include "dehyst.h"\n' + block.declarations(), encoding="utf-8"
    )
    program = folder / name
    options = [
        "-std=c11",
        "-O2",
        "-g",
        "-fsanitize=fuzzer,address,undefined",
        "-fno-sanitize-recover=all",
    ]
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


def plain_block(more: int) -> bytes:
    """Return an input from which the fuzzer of parameters builds a block that is let in, of 1 + `more` operators."""
    operators = 1 + more
    thresholds, slopes = [ZERO, *[ONE] * operators], [ONE] * (operators + 1)
    centre_and_offset, ranges, line = [ZERO] * 3, [MINUS, ONE, ONE] * 3, [ZERO] * 3
    head, fade, all_reals, steps = [7, operators - 1, 0, 0], 128, 1, [1, ONE, 1, ZERO]
    return bytes(
        [*head, *thresholds, *slopes, *centre_and_offset, *ranges, *line, fade, all_reals, *steps]
    )


def plain_sum(kind: int) -> bytes:
    """Return an input from which the fuzzer of elements builds the input beside one of a kind, and moves them."""
    nothing = [ZERO] * 3
    steps = [*nothing, HALF, 1, *nothing, MINUS, 0, ONE]
    return bytes([*sum_of(kind), 1, ZERO, *steps * 4])


def plain_element_block(kind: int) -> bytes:
    """Return an input from which the fuzzer of their blocks builds such a sum with a memory, and moves it."""
    solves, delay, start, free = kind % 2, 2 * (kind % 4), 8, 16 * (kind // 4)
    memory, scales = [ZERO, ZERO], [HALF, ZERO, ZERO, ONE, ZERO, ONE]
    ranges, line, fade = [MINUS, ONE] * 3, [HALF, ZERO], HALF
    nothing = [ZERO] * 3
    image = [225, 1, 130, HALF, 1]
    steps = [1, HALF, *nothing, 240, ONE, *nothing, MINUS, *nothing, *image, ONE, *nothing]
    steps += [200, HALF, *nothing, MINUS]
    return bytes(
        [
            solves + delay + start + free,
            *sum_of(kind),
            *memory,
            *scales,
            *ranges,
            *line,
            fade,
            *steps * 3,
        ]
    )


def plain_pair(kind: int) -> bytes:
    """Return an input from which the fuzzer of pairs builds the input beside one of a kind on each path."""
    scales = [ZERO, ONE, ZERO, ONE, ZERO]
    return bytes([*sum_of(0), *sum_of(kind), *scales * 2, *[HALF, ZERO, MINUS, ONE, 0, HALF] * 4])


def sum_of(kind: int) -> list[int]:
    """Return the bytes of a sum of the input and an element of a kind."""
    maps, range_, schedules = [0, 0, ZERO], [MINUS, ONE], [0, *[0, ZERO, ONE] * 3]
    return [2, *maps, *range_, *schedules, 0, 0, ZERO, ZERO, ONE, 0, kind, 0, HALF, HALF, HALF, 0]


PLAIN = {
    "pair": (plain_pair, 8),
    "load": (plain_block, 6),
    "elements": (plain_sum, 8),
    "element_block": (plain_element_block, 8),
}


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
        plain, count = PLAIN.get(name, (bytes, 0))
        for index in range(count):
            (begin / str(index)).write_bytes(plain(index))
        options = [
            f"-runs={runs}",
            f"-max_len={longest}",
            "-detect_leaks=0",
            f"-seed={seed}",
            "-print_final_stats=0",
        ]
        done = subprocess.run(
            [program, *options, begin], cwd=folder, capture_output=True, text=True, check=False
        )
    made = DONE.search(done.stderr)
    if done.returncode or not made:
        raise Failed(f"fuzzer {name} found something:\n{done.stderr[-1500:]}")
    for number, blocks in LET_IN.findall(done.stderr):
        if not int(number):
            raise Failed(f"fuzzer {name} let in no {blocks}: it proves nothing about them")
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


PROOFS = (
    Proof(
        "fuzz",
        "no input, image or sequence of calls leads to undefined behaviour or out of a range",
        run,
    ),
)
