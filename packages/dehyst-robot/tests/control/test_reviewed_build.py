"""The reviewed controllers as C: clean for strict compilers, of the core's parts and tanh alone, and never exported."""

import re
import shutil
import subprocess

import pytest

from places import KERNEL, ROBOT, ROOT

REVIEWED, CORE = ROBOT / "reviewed", KERNEL / "core"
SOURCES = sorted(REVIEWED.glob("*.c"))
STRICT = [
    "-Wall",
    "-Wextra",
    "-Wconversion",
    "-Wpedantic",
    "-Wshadow",
    "-Werror",
    f"-I{REVIEWED}",
    f"-I{CORE}",
]
AS_C, AS_CXX = ["-std=c11"], ["-x", "c++", "-std=c++17"]
HELPERS = {
    "memcpy",
    "memset",
    "_GLOBAL_OFFSET_TABLE_",
    "__stack_chk_fail",
}  # that a compiler calls by itself


def run(*command):
    done = subprocess.run([str(c) for c in command], capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.parametrize("language", [AS_C, AS_CXX], ids=["C11", "C++17"])
@pytest.mark.parametrize("name", ["gcc", "clang"])
def test_the_reviewed_controllers_are_clean_and_call_the_core_and_tanh_only(
    name, language, tmp_path
):
    compiler = shutil.which(name)
    if not compiler or not shutil.which("nm"):
        pytest.skip(f"no {name} or no nm is installed: nothing can be compiled here")
    for source in SOURCES:
        run(compiler, "-O1", *language, *STRICT, "-c", source, "-o", tmp_path / f"{source.stem}.o")
    defined, undefined = set(), set()
    for line in run("nm", *sorted(tmp_path.glob("*.o"))).splitlines():
        symbol = re.fullmatch(r"[0-9a-f]*\s+([A-Za-z])\s+(\S+)", line.strip())
        if symbol:
            (undefined if symbol[1] == "U" else defined).add(symbol[2].lstrip("_"))
    assert "reviewed_step" in defined
    foreign = {one for one in undefined - defined if not one.startswith("dehyst_")}
    assert foreign <= {"tanh"} | {one.lstrip("_") for one in HELPERS}


def test_the_core_knows_nothing_of_them_and_neither_does_an_export():
    core = "".join(path.read_text(encoding="utf-8") for path in CORE.glob("*.[ch]"))
    export = "".join(
        path.read_text(encoding="utf-8")
        for path in (ROOT / "packages/dehyst/src/dehyst/export").rglob("*.py")
    )
    install = re.findall(
        r"install\([^)]*\)", (KERNEL / "CMakeLists.txt").read_text(encoding="utf-8")
    )
    assert (
        "reviewed" not in core
        and "reviewed" not in export
        and not any("reviewed" in one for one in install)
    )


def test_they_neither_allocate_nor_know_the_plant():
    text = "".join(path.read_text(encoding="utf-8") for path in REVIEWED.glob("*.[ch]"))
    assert set(re.findall(r"#include\s+(\S+)", text)) == {'"reviewed.h"', '"dehyst.h"', "<math.h>"}
    assert not re.search(r"\b(malloc|calloc|realloc|free)\b|plant_", text)
