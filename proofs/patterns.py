"""A thousand million random patterns of bits through a block's step, as compilers make it."""

from __future__ import annotations

import os
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path

from outcome import CORE, HERE, Failed, Proof, said, tool, version
from parameters import Block, inverse

CURE = "on Debian: apt-get install gcc clang"
STRICT = ("-O2", "-ffp-contract=off")
LEVELS = (STRICT, ("-Ofast",))


@dataclass(frozen=True)
class Count:
    """What a run of patterns.c printed."""

    samples: int
    rejected: int
    limited: int
    switched: int
    faults: int
    hash: str


def built(folder: Path, compiler: str, level: tuple[str, ...], block: Block, *defines: str) -> Path:
    """Compile the core with these options and the counting program without."""
    Path(folder, "parameters.h").write_text(
        '#include "dehyst.h"\n' + block.declarations(), encoding="utf-8"
    )
    options = ["-std=c11", f"-I{folder}", f"-I{CORE}", *(f"-D{define}" for define in defines)]
    objects = []
    for name in ("block", "model", "pi", "map", "guard"):
        objects.append(folder / f"{name}.o")
        said([compiler, *options, *level, "-c", CORE / f"{name}.c", "-o", objects[-1]])
    objects.append(folder / "patterns.o")
    said([compiler, *options, "-O2", "-c", HERE / "patterns" / "patterns.c", "-o", objects[-1]])
    program = folder / "patterns"
    said(
        [compiler, *objects, "-o", program]
    )  # linked without the level: -Ofast would let subnormal numbers vanish
    return program


def counted(program: Path, samples: int) -> list[Count]:
    """Run the program as often as there are cores, each with a part of the samples."""
    cores = min(len(os.sched_getaffinity(0)), 8)
    share = -(-samples // cores)
    running = [
        subprocess.Popen([program, str(core), str(share)], stdout=subprocess.PIPE, text=True)
        for core in range(cores)
    ]
    texts = [process.communicate()[0].split() for process in running]
    return [Count(*(int(cell) for cell in cells[:5]), cells[5]) for cells in texts]


def doubles(quick: bool) -> tuple[str, str, str]:
    """Both compilers, strict and fast; the strict ones must print the same hash."""
    samples = 10**7 if quick else 10**9
    names = [tool(CURE, name) for name in ("gcc", "clang")]
    hashes = set()
    lines = []
    for compiler in names:
        for level in LEVELS:
            with tempfile.TemporaryDirectory() as folder:
                counts = counted(built(Path(folder), compiler, level, inverse(14)), samples)
            _check(counts, f"{Path(compiler).name} {' '.join(level)}")
            if level is STRICT:
                hashes.add(tuple(count.hash for count in counts))
            lines.append(sum(count.rejected for count in counts) / samples)
    if len(hashes) != 1:
        raise Failed("the outputs of gcc and clang differ")
    return (
        _tools(names),
        f"{len(lines)} x {samples:.0e} samples, inverse of 14 operators".replace("e+0", "e"),
        (
            f"0 outputs out of range; {100 * lines[0]:.0f} % rejected; gcc and clang with -O2 agree in every bit"
        ),
    )


def floats(quick: bool) -> tuple[str, str, str]:
    """Every float there is, -Ofast."""
    samples = 2**24 if quick else 2**32
    gcc = tool(CURE, "gcc")
    with tempfile.TemporaryDirectory() as folder:
        counts = counted(
            built(Path(folder), gcc, ("-Ofast",), inverse(14), "DEHYST_FLOAT"), samples
        )
    _check(counts, "gcc -Ofast, float")
    share = "a 256th of the" if quick else "all"
    return (
        _tools([gcc]),
        f"{share} 2^32 patterns, inverse of 14 operators",
        "0 outputs out of range",
    )


def _check(counts: list[Count], how: str) -> None:
    faults = sum(count.faults for count in counts)
    if faults:
        raise Failed(f"{how}: {faults} outputs out of range")
    if not all(count.rejected and count.limited and count.switched for count in counts):
        raise Failed(f"{how}: nothing was rejected, limited or switched: the run says nothing")


def _tools(compilers: list[str]) -> str:
    return ", ".join(f"{Path(name).name} {version(name)}" for name in compilers)


PROOFS = (
    Proof(
        "patterns-double",
        "no output out of range for random 64-bit patterns, -O2 and -Ofast",
        doubles,
    ),
    Proof("patterns-float", "no output out of range for every 32-bit pattern, -Ofast", floats),
)
