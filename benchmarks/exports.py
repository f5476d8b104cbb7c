"""Exported C against the extension: random models, their generated parameter files compiled, every bit compared.

    python benchmarks/exports.py                    1 000 models x 1 000 samples, gcc -O0 .. -O3 and clang -O0 .. -O3
    python benchmarks/exports.py --models 50        fewer

All models of a run go into one program: each with the two files that `dehyst export` would write for it, the core
beside them as it is. In double every output and every flag must agree to the bit; in float outputs must lie within
1e-5 of the output's range.
"""

from __future__ import annotations

import argparse
import shutil
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent))

from target.random_blocks import Trial, trials

from dehyst.export import core_files, subject_of
from dehyst.export.c import unit_files

BUILDS = tuple(
    (compiler, level) for compiler in ("gcc", "clang") for level in ("-O0", "-O1", "-O2", "-O3")
)
TOLERANCE = 1e-5  # in float, of the output's range
FUNCTIONS = tuple(f"dehyst_block_{name}" for name in ("reset", "step", "save", "restore"))

UNIT = """
static void run_{name}(const dehyst_real *x, const unsigned char *on, dehyst_real *y, uint32_t *flags, long samples)
{{
    static {name}_state unit;
    {name}_reset(&unit);
    for (long k = 0; k < samples; ++k) {{
        y[k] = {name}_step(&unit, x[k], on[k]);
        flags[k] = {name}_flags(&unit);
    }}
}}
"""
MAIN = """
typedef void run_function(const dehyst_real *, const unsigned char *, dehyst_real *, uint32_t *, long);
static run_function *const units[] = {{{units}}};
enum {{ SAMPLES = {samples} }};
int main(void)
{{
    static dehyst_real x[SAMPLES], y[SAMPLES];
    static unsigned char on[SAMPLES];
    static uint32_t flags[SAMPLES];
    for (unsigned long u = 0; u < sizeof units / sizeof units[0]; ++u) {{
        if (fread(x, sizeof x, 1, stdin) != 1 || fread(on, sizeof on, 1, stdin) != 1) {{
            return 1;
        }}
        units[u](x, on, y, flags, SAMPLES);
        if (fwrite(y, sizeof y, 1, stdout) != 1 || fwrite(flags, sizeof flags, 1, stdout) != 1) {{
            return 1;
        }}
    }}
    return 0;
}}
"""


@dataclass(frozen=True)
class Outcome:
    """What one build answered.

    Attributes
    ----------
    build
        Compiler and level.
    models, samples
        How many, and how many of each.
    wrong
        Models with an output or a flag that is not that of the extension; in float, beyond the tolerance.
    worst
        Largest error, share of the output's range.
    seconds
        Of compiling and running.
    """

    build: str
    models: int
    samples: int
    wrong: int
    worst: float
    seconds: float


def write_sources(runs: list[Trial], folder: Path) -> None:
    """Write the core, the generated files of all models, and a program that runs them all."""
    real, samples = runs[0].real, runs[0].case.x.size
    for name, text in core_files.needed(FUNCTIONS).items():
        (folder / name).write_text(text, encoding="utf-8")
    names = [f"unit_{k}" for k in range(len(runs))]
    program = ["#include <stdio.h>"]
    for name, run in zip(names, runs, strict=True):
        low, high = (("output_low", "output_high"), ("input_low", "input_high"))[
            run.block.direction == "forward"
        ]
        bounds = getattr(run.block.parameters, low), getattr(run.block.parameters, high)
        block = run.block
        subject = subject_of(
            block.model, block.direction, name=name, real=real, range=bounds, ramp=block.ramp
        )
        for file, content in unit_files(subject).items():
            (folder / file).write_text(str(content), encoding="utf-8")
        program.append(f'#include "{name}.c"{UNIT.format(name=name)}')
    program.append(MAIN.format(units=", ".join(f"run_{name}" for name in names), samples=samples))
    (folder / "program.c").write_text("\n".join(program), encoding="utf-8")


def signals(runs: list[Trial]) -> bytes:
    """Return what the program reads: inputs and on/off of each model."""
    kind = np.float32 if runs[0].real == "float" else np.float64
    with np.errstate(over="ignore"):
        return b"".join(
            run.case.x.astype(kind).tobytes() + run.case.on.astype(np.uint8).tobytes()
            for run in runs
        )


def outcome(
    runs: list[Trial], folder: Path, compiler: str, level: str, standard: str = "-std=c99"
) -> Outcome:
    """Compile, run, compare."""
    begin = time.perf_counter()
    program = folder / f"program{compiler}{level}"
    core = sorted(
        str(folder / name) for name in core_files.needed(FUNCTIONS) if name.endswith(".c")
    )
    command = [
        compiler,
        standard,
        level,
        "-ffp-contract=off",
        "-I",
        str(folder),
        "-o",
        str(program),
    ]
    subprocess.run([*command, str(folder / "program.c"), *core], check=True)
    said = subprocess.run(
        [str(program)], input=signals(runs), capture_output=True, check=True
    ).stdout
    kind = np.dtype(np.float32 if runs[0].real == "float" else np.float64)
    wrong, worst, at = 0, 0.0, 0
    for run in runs:
        size = run.case.x.size
        y = np.frombuffer(said, kind, size, at).astype(float)
        flags = np.frombuffer(said, np.uint32, size, at + size * kind.itemsize)
        at += size * (kind.itemsize + 4)
        expected, raised = run.expected()
        error = float(np.max(np.abs(y - expected))) / run.range()
        worst = max(worst, error)
        if run.real == "double":
            wrong += not (
                np.array_equal(y.view(np.uint64), expected.view(np.uint64))
                and np.array_equal(flags, raised)
            )
        else:
            wrong += not (error <= TOLERANCE and np.array_equal(flags & 3, raised & 3))
    if at != len(said):
        raise ValueError(f"the program answered {len(said)} bytes, not {at}")
    return Outcome(
        f"{compiler} {level}", len(runs), size, wrong, worst, time.perf_counter() - begin
    )


def main() -> None:
    """Run all builds that this machine has, and print a table."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--models", type=int, default=1000)
    parser.add_argument("--samples", type=int, default=1000)
    arguments = parser.parse_args()
    bad = 0
    for real in ("double", "float"):
        runs = trials(arguments.models, arguments.samples, real, seed=17)
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            write_sources(runs, folder)
            for compiler, level in (
                BUILDS if real == "double" else (("gcc", "-O2"), ("clang", "-O2"))
            ):
                if shutil.which(compiler) is None:
                    print(f"{compiler} is not installed: skipped")
                    continue
                found = outcome(runs, folder, compiler, level)
                bad += found.wrong
                print(
                    f"{real:6} {found.build:10} {found.models} models x {found.samples} samples: {found.wrong} differ, "
                    f"largest error {found.worst:.1e} of the range, {found.seconds:.1f} s"
                )
    sys.exit(1 if bad else 0)


if __name__ == "__main__":
    main()
