"""The engine against the definition: a C driver on random short signals, per instruction set, compiler and machine."""

import shutil
import subprocess

import pytest

from places import KERNEL, SUPPORT

TESTS = SUPPORT
STRICT = [
    "-std=c11",
    "-Wall",
    "-Wextra",
    "-Wconversion",
    "-Wpedantic",
    "-Werror",
    "-ffp-contract=off",
]
INCLUDE = [f"-I{KERNEL / 'engine'}", f"-I{KERNEL / 'core'}"]
FLAGS = {
    "portable": ["-DLANES_LEVEL=0"],
    "avx2": ["-DLANES_LEVEL=1", "-mavx2", "-mfma"],
    "avx512": ["-DLANES_LEVEL=2", "-mavx512f", "-mavx512dq", "-mavx512vl", "-mfma"],
}
SIGNALS = 350_000  # a level: a million in all


def run(*command):
    return subprocess.run([str(c) for c in command], capture_output=True, text=True, timeout=600)


def tool(*names):
    for name in names:
        if shutil.which(name):
            return name
    return pytest.skip(f"none of {', '.join(names)} is installed")


def compiled(compiler, folder, levels, *options, driver="engine_differential.c"):
    """Compile the engine, the core's arithmetic of models and the driver; return the program."""
    has = [f"-DENGINE_HAS_{level.upper()}" for level in levels]
    jobs = [(s, [*has], s.stem) for s in sorted((KERNEL / "engine").glob("*.c"))]
    jobs += [
        (s, FLAGS[v], f"{s.stem}_{v}")
        for s in sorted((KERNEL / "engine" / "lanes").glob("*.c"))
        for v in levels
    ]
    jobs += [(s, [], f"core_{s.stem}") for s in sorted((KERNEL / "core").glob("*.c"))]
    jobs += [(TESTS / driver, ["-O3"], "driver")]
    objects = []
    for source, flags, name in jobs:
        objects.append(folder / f"{name}.o")
        done = run(compiler, *STRICT, *INCLUDE, *options, *flags, "-c", source, "-o", objects[-1])
        assert done.returncode == 0, done.stderr
    program = folder / "differential"
    done = run(compiler, *options, *objects, "-lm", "-o", program)
    assert done.returncode == 0, done.stderr
    return program


def host_levels(compiler, folder):
    """Return the levels that this compiler can build for."""
    empty = folder / "empty.c"
    empty.write_text("int nothing;\n", encoding="utf-8")
    return [
        v
        for v, f in FLAGS.items()
        if run(compiler, *f, "-c", empty, "-o", folder / "empty.o").returncode == 0
    ]


@pytest.fixture(scope="module")
def driver(tmp_path_factory):
    folder = tmp_path_factory.mktemp("engine")
    compiler = tool("gcc", "clang", "cc")
    return compiled(
        compiler, folder, host_levels(compiler, folder), "-O1", "-DENGINE_STREAM_SAMPLES=40"
    )


@pytest.mark.exhaustive
@pytest.mark.parametrize("level", [0, 1, 2], ids=list(FLAGS))
def test_every_method_follows_the_definition_on_random_signals(driver, level):
    done = run(driver, level, 1, SIGNALS)
    if done.returncode == 2:
        pytest.skip("this processor has no such instructions")
    assert done.returncode == 0, done.stdout


@pytest.mark.slow
def test_the_portable_engine_needs_no_vector_instructions(tmp_path):
    compiler = tool("gcc", "clang", "cc")
    done = run(compiled(compiler, tmp_path, ["portable"], "-O1", "-DLANES_PLAIN"), 0, 4, 5000)
    assert done.returncode == 0, done.stdout


@pytest.mark.exhaustive
def test_the_engine_stays_within_its_memory(tmp_path):
    compiler = tool("gcc", "clang")
    options = [
        "-O1",
        "-g",
        "-fsanitize=address,undefined",
        "-fno-sanitize-recover=all",
        "-DENGINE_STREAM_SAMPLES=40",
    ]
    empty = tmp_path / "empty.c"
    empty.write_text("int main(void) { return 0; }\n", encoding="utf-8")
    if (
        run(compiler, *options, empty, "-o", tmp_path / "empty").returncode
        or run(tmp_path / "empty").returncode
    ):
        pytest.skip("no sanitizers here")
    done = run(compiled(compiler, tmp_path, ["portable"], *options), 0, 5, 3000)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.slow
def test_clang_compiles_the_engine_without_a_warning(tmp_path):
    clang = tool("clang")
    done = run(compiled(clang, tmp_path, host_levels(clang, tmp_path), "-O0"), 0, 2, 500)
    assert done.returncode == 0, done.stdout


def test_the_portable_engine_runs_on_another_architecture(tmp_path):
    compiler, machine = tool("aarch64-linux-gnu-gcc"), tool("qemu-aarch64", "qemu-aarch64-static")
    done = run(machine, compiled(compiler, tmp_path, ["portable"], "-O1", "-static"), 0, 3, 3000)
    assert done.returncode == 0, done.stdout
