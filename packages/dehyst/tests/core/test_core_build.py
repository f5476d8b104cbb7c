"""The core as C: strict compilers, both precisions, no foreign symbols, and a guard that -ffast-math cannot delete."""

import re
import shutil
import struct
import subprocess

import numpy as np
import pytest

from dehyst import PrandtlIshlinskii
from oracles import random_thresholds, random_walk, random_weights
from places import KERNEL

CORE = KERNEL / "core"
SOURCES = sorted(CORE.glob("*.c"))
STRICT = ["-Wall", "-Wextra", "-Wconversion", "-Wpedantic", "-Wshadow", "-Werror", f"-I{CORE}"]
PRECISIONS = pytest.mark.parametrize("precision", [[], ["-DDEHYST_FLOAT"]], ids=["double", "float"])


def tool(*names):
    for name in names:
        if shutil.which(name):
            return name
    pytest.skip(f"none of {', '.join(names)} is installed: the core cannot be compiled here")


def run(*command, **options):
    done = subprocess.run(
        [str(c) for c in command], capture_output=True, text=True, timeout=600, **options
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_the_core_is_found():
    assert {s.name for s in SOURCES} >= {
        "guard.c",
        "inverse.c",
        "map.c",
        "model.c",
        "play.c",
        "stop.c",
    }


@pytest.mark.slow
@PRECISIONS
@pytest.mark.parametrize("level", ["-O0", "-O3"])
def test_the_core_is_clean_c11_and_calls_nothing_outside_itself(precision, level, tmp_path):
    compiler, lister = tool("gcc", "clang", "cc"), tool("nm")
    for source in SOURCES:
        run(
            compiler,
            "-std=c11",
            level,
            *STRICT,
            *precision,
            "-c",
            source,
            "-o",
            tmp_path / f"{source.stem}.o",
        )
    defined, undefined = set(), set()
    for line in run(lister, *sorted(tmp_path.glob("*.o"))).splitlines():
        symbol = re.fullmatch(r"[0-9a-f]*\s+([A-Za-z])\s+(\S+)", line.strip())
        if symbol:
            (undefined if symbol[1] == "U" else defined).add(symbol[2])
    assert "dehyst_model_step" in {name.lstrip("_") for name in defined}
    assert undefined <= defined


@pytest.mark.slow
@PRECISIONS
def test_the_core_is_clean_cplusplus_too(precision, tmp_path):
    compiler = tool("g++", "clang++", "c++")
    for source in SOURCES:
        run(
            compiler,
            "-x",
            "c++",
            "-std=c++17",
            *STRICT,
            *precision,
            "-c",
            source,
            "-o",
            tmp_path / "out.o",
        )


def test_the_core_allocates_nothing_and_includes_nothing_of_a_library():
    text = "".join(path.read_text(encoding="utf-8") for path in [*SOURCES, CORE / "dehyst.h"])
    assert set(re.findall(r"#include\s+(\S+)", text)) == {
        '"dehyst.h"',
        '"dehyst_config.h"',
        "<stdint.h>",
        "<stddef.h>",
    }
    assert not re.search(
        r"\b(malloc|calloc|realloc|free)\b|\bstatic\s+dehyst_real\s+\w+\s*[;=\[]", text
    )


PROGRAM = r"""
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include "dehyst.h"
/* Reads n, then thresholds, weights, states, then samples, all as little-endian doubles; prints outputs in bits. */
int main(void)
{
    static double r[200], w[200], z[200], start[200];
    double count, x;
    if (fread(&count, 8, 1, stdin) != 1) return 1;
    const int32_t n = (int32_t)count;
    if (fread(r, 8, (size_t)n, stdin) != (size_t)n) return 1;
    if (fread(w, 8, (size_t)n, stdin) != (size_t)n) return 1;
    if (fread(start, 8, (size_t)n, stdin) != (size_t)n) return 1;
    dehyst_model model;
    memset(&model, 0, sizeof model);
    model.hysteresis.n = n;
    model.hysteresis.threshold = r;
    static double slope[200], loading[200];
    dehyst_pi_tables(n, r, w, slope, loading);
    model.hysteresis.slope = slope;
    model.hysteresis.loading = loading;
    dehyst_state state;
    state.z = z;
    dehyst_model_reset(&model, &state, start);
    while (fread(&x, 8, 1, stdin) == 1) {
        const double y = dehyst_model_step(&model, &state, x);
        uint64_t bits;
        memcpy(&bits, &y, 8);
        printf("%llx %u\n", (unsigned long long)bits, (unsigned)state.flags);
    }
    return 0;
}
"""


def run_program(flags, tmp_path, model, x, sources=SOURCES):
    """Compile the core with a small main program, run it on x, and return outputs and flags."""
    compiler = tool("gcc", "clang", "cc")
    main = tmp_path / "main.c"
    main.write_text(PROGRAM, encoding="utf-8")
    binary = tmp_path / "main"
    run(compiler, "-std=c11", *flags, f"-I{CORE}", main, *sources, "-o", binary)
    parts = ([float(model.weights.size)], model.thresholds, model.weights, model.state, x)
    data = b"".join(np.asarray(part, dtype="<f8").tobytes() for part in parts)
    done = subprocess.run([binary], input=data, capture_output=True, timeout=600)
    assert done.returncode == 0
    rows = [line.split() for line in done.stdout.decode().splitlines()]
    y = np.array([struct.unpack("<d", int(bits, 16).to_bytes(8, "little"))[0] for bits, _ in rows])
    return y, np.array([int(flag) for _, flag in rows])


def example():
    rng = np.random.default_rng(0)
    n = 37
    model = PrandtlIshlinskii(random_thresholds(rng, n), random_weights(rng, n, "mixed"))
    model = model.with_state(model.final_state(random_walk(rng, 100)))
    return model, random_walk(rng, 400)


@pytest.mark.slow
@pytest.mark.parametrize(
    "flags", [["-Ofast"], ["-O2", "-ffast-math"], ["-O3", "-ffast-math", "-flto"]], ids=" ".join
)
def test_the_guard_survives_fast_math(flags, tmp_path):
    model, x = example()
    bad = np.array([np.nan, -np.nan, np.inf, -np.inf, 1e300])
    dirty = np.concatenate([bad, x[:200], bad, x[200:], bad])
    y, raised = run_program(flags, tmp_path, model, dirty)
    hit = np.isin(np.arange(dirty.size), [*range(5), *range(205, 210), *range(410, 415)])
    assert np.all(np.isfinite(y))
    assert np.array_equal(raised & 1, hit.astype(int))
    assert np.all(raised & 2)
    np.testing.assert_allclose(y[~hit], model.simulate(x), rtol=0, atol=1e-13)
    assert np.all(y[205:210] == y[204])
    assert np.all(y[410:] == y[409])


@pytest.mark.slow
def test_fast_math_does_delete_a_guard_by_isfinite(tmp_path):
    # Otherwise the test above would prove nothing about this compiler.
    naive = tmp_path / "guard.c"
    naive.write_text(
        '#include <math.h>\n#include "dehyst.h"\nint dehyst_accept(dehyst_real x) { return isfinite(x); }\n'
        "int dehyst_accept_given(const dehyst_real x[DEHYST_GIVEN]) { return isfinite(x[0] + x[1] + x[2]); }\n",
        encoding="utf-8",
    )
    sources = [naive, *(s for s in SOURCES if s.name != "guard.c")]
    model, x = example()
    y, _ = run_program(["-Ofast"], tmp_path, model, np.insert(x, 100, np.nan), sources)
    if np.all(np.isfinite(y)):
        pytest.skip("this compiler keeps isfinite under -Ofast: the guard is not needed here")
    assert np.isnan(y[100])


@pytest.mark.slow
@pytest.mark.parametrize("flags", [["-O0"], ["-O1"], ["-O3", "-ffp-contract=off"]], ids=" ".join)
def test_another_build_of_the_core_gives_the_bits_of_the_extension(flags, tmp_path):
    model, x = example()
    y, raised = run_program(flags, tmp_path, model, x)
    step = model.stepper()
    assert y.tobytes() == np.array([step(v) for v in x.tolist()]).tobytes()
    assert not raised.any()
