"""The plant as C: clean for a strict compiler, nothing but the mathematics library, and apart from the core."""

import re
import shutil
import subprocess

import pytest

from places import KERNEL, ROBOT

PLANT = ROBOT / "plant"
SOURCES = sorted(PLANT.glob("*.c"))
STRICT = [
    "-std=c11",
    "-Wall",
    "-Wextra",
    "-Wconversion",
    "-Wpedantic",
    "-Wshadow",
    "-Werror",
    f"-I{PLANT}",
]
LIBRARY = {
    "cos",
    "cosh",
    "exp",
    "floor",
    "memset",
    "sin",
    "sinh",
    "sqrt",
    "_GLOBAL_OFFSET_TABLE_",
    "__stack_chk_fail",
}


def run(*command):
    done = subprocess.run([str(c) for c in command], capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.slow
@pytest.mark.parametrize("level", ["-O0", "-O3"])
def test_the_plant_is_clean_c11_and_calls_only_the_mathematics_library(level, tmp_path):
    compiler = shutil.which("gcc") or shutil.which("clang")
    if not compiler or not shutil.which("nm"):
        pytest.skip("no compiler or no nm is installed: the plant cannot be compiled here")
    for source in SOURCES:
        run(compiler, level, *STRICT, "-c", source, "-o", tmp_path / f"{source.stem}.o")
    defined, undefined = set(), set()
    for line in run("nm", *sorted(tmp_path.glob("*.o"))).splitlines():
        symbol = re.fullmatch(r"[0-9a-f]*\s+([A-Za-z])\s+(\S+)", line.strip())
        if symbol:
            (undefined if symbol[1] == "U" else defined).add(symbol[2].lstrip("_"))
    assert "plant_joint_step" in defined
    assert undefined - defined <= {name.lstrip("_") for name in LIBRARY}


def test_plant_and_core_know_nothing_of_each_other():
    plant = "".join(path.read_text(encoding="utf-8") for path in PLANT.glob("*.[ch]"))
    core = "".join(path.read_text(encoding="utf-8") for path in (KERNEL / "core").glob("*.[ch]"))
    assert set(re.findall(r"#include\s+(\S+)", plant)) <= {
        '"plant.h"',
        '"life.h"',
        '"parts.h"',
        '"sensors.h"',
        "<math.h>",
        "<stdint.h>",
        "<string.h>",
    }
    assert "dehyst_" not in plant
    assert "plant_" not in core
    assert not re.search(r"\b(malloc|calloc|realloc|free)\b", plant)
