"""Exported Structured Text, unchanged, compiled by others: matiec writes C, STruC++ writes C++, and both give our bits.

MATIEC and STRUCPP name the folders where they were built; else their archives are looked for in ../shared/tools beside
the project, and built once into the user's cache.
"""

import ctypes
import fcntl
import os
import shutil
import subprocess
import tempfile
from pathlib import Path

import numpy as np
import pytest

from dehyst_targets import st as target
from places import ROOT
from row_samples import units
from st_samples import subjects

pytestmark = pytest.mark.slow
ARCHIVES = ROOT.parent / "shared" / "tools"
BUILDS = {  # programs that a build needs, its commands
    "matiec": (
        "autoreconf flex bison gcc",
        'autoreconf -i && ./configure CXXFLAGS="-O0 -w" && make',
    ),
    "strucpp": ("node npm g++", "npm install && npm run build"),
}
COMMANDS = {
    "matiec": "{tool}/iec2c -I {tool}/lib -T . all.st && gcc -w -O0 -I {tool}/lib/C",
    "strucpp": "node {tool}/dist/node/cli.js all.st -o all.cpp && g++ -w -O0 -std=c++17 -I {tool}/src/runtime/include",
}
HEADS = {
    "matiec": '#include <string.h>\n#include "iec_std_lib.h"\nTIME __CURRENT_TIME;\nBOOL __DEBUG;\n'
    '#include "POUS.h"\n#include "POUS.c"\n',
    "strucpp": '#include "all.cpp"\n#include <memory>\nusing namespace strucpp;\n#define restrict\nextern "C" {\n',
}
NEW = {
    "matiec": "static {0} b; memset(&b, 0, sizeof b); {0}_init__(&b, 0);",
    "strucpp": "auto kept = std::make_unique<{0}>(); {0} &b = *kept;",
}
CALL = {"matiec": "{0}_body__(&b);", "strucpp": "b();"}
SET = {"matiec": "b.{0}.value = {1};", "strucpp": "b.{0} = {1};"}
GET = {"matiec": "b.{0}.value", "strucpp": "b.{0}.get()"}


def tool(name):
    """The folder in which a compiler was built, or a skip that says what is missing."""
    if found := os.environ.get(name.upper()):
        return Path(found)
    archive = ARCHIVES / f"{name}.tar.gz"
    if not archive.exists():
        pytest.skip(
            f"{name}: no {name.upper()} in the environment and no ../shared/tools/{archive.name}"
        )
    needs, commands = BUILDS[name]
    if missing := [need for need in needs.split() if shutil.which(need) is None]:
        pytest.skip(f"{name}: its build needs {', '.join(missing)}")
    cache = Path.home() / ".cache" / "dehyst-tests"
    built = cache / f"{name}-{archive.stat().st_size}"
    cache.mkdir(parents=True, exist_ok=True)
    with (cache / f"{name}.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not built.exists():
            with tempfile.TemporaryDirectory(dir=cache) as folder:
                commands = f"tar xf {archive} && cd {name} && {commands}"
                made = subprocess.run(
                    commands, shell=True, cwd=folder, capture_output=True, text=True
                )
                if made.returncode:
                    pytest.skip(
                        f"{name}: its build fails: {(made.stderr or made.stdout).strip()[-300:]}"
                    )
                Path(folder, name).rename(built)
    return built


def driver(compiler, subjects):
    """C or C++ that runs the signal of each block, twice with a restart between, and its own test."""
    text = HEADS[compiler]
    for name, subject in subjects.items():
        ports, upper = target.ports_of(subject), name.upper()
        m, p = len(ports.inputs), len(ports.outputs)
        values = {word: f"x[k * {m} + {j}]" for j, word in enumerate(ports.inputs)}
        values |= {word: f"(on[k] & {bit}) != 0" for word, bit in ports.switches.items()} | {
            "Restart": "r && !k"
        }
        given = " ".join(
            SET[compiler].format(word.upper(), value) for word, value in values.items()
        )
        taken = " ".join(
            f"y[(r * n + k) * {p} + {j}] = {GET[compiler].format(word.upper())};"
            for j, word in enumerate(ports.outputs)
        )
        text += (
            f"void run_{name}(int n, const double *x, const long long *on, double *y, long long *flags) {{\n"
            f"{NEW[compiler].format(upper)}\nfor (int r = 0; r < 2; ++r) for (int k = 0; k < n; ++k) {{\n{given}\n"
            f"{CALL[compiler].format(upper)}\n{taken} flags[r * n + k] = {GET[compiler].format('FLAGWORD')};\n}}\n}}\n"
            f"int test_{name}(int n) {{\n{NEW[compiler].format(upper + '_TEST')}\n"
            f"for (int k = 0; k < n; ++k) {{ {CALL[compiler].format(upper + '_TEST')} }}\n"
            f"return {GET[compiler].format('PASSED')} ? -1 : {GET[compiler].format('FIRSTMISMATCH')};\n}}\n"
        )
    return text + ("}\n" if compiler == "strucpp" else "")


def wrong(library, name, subject):
    """What a compiled block and its own test do otherwise than the model."""
    ports, signal = target.ports_of(subject), subject.test
    n = signal.samples
    x, on = np.ascontiguousarray(signal.inputs), signal.switch.astype(np.int64)
    y, flags = np.empty((2 * n, len(ports.outputs))), np.empty(2 * n, dtype=np.int64)
    pointers = [ctypes.c_void_p(array.ctypes.data) for array in (x, on, y, flags)]
    getattr(library, f"run_{name}")(n, *pointers)
    expected, told = np.tile(signal.outputs, (2, 1)), np.tile(signal.flags, 2)
    if subject.real == "double":
        good = (y.view(np.uint64) == expected.view(np.uint64)).all(axis=1) & (flags == told)
    else:
        good = (np.abs(y - expected) <= subject.tolerances).all(axis=1) & (
            (flags ^ told) & ports.sure == 0
        )
    if not good.all():
        k = int(np.argmin(good))
        yield f"{name}, sample {k} of {n}: {y[k]}, flags {flags[k]}; the model {expected[k]}, flags {told[k]}"
    first = getattr(library, f"test_{name}")(target.plc_signal(subject).samples)
    if first >= 0:
        yield f"{name}, its own test: sample {first}"


@pytest.mark.parametrize("compiler", BUILDS)
@pytest.mark.exhaustive
def test_every_export_has_the_bits_of_the_model_in_a_compiler_of_others(compiler, tmp_path):
    folder, made = (
        tool(compiler),
        subjects() | {target.block_name(row): row for row in units("double").values()},
    )
    texts = []
    for name, subject in made.items():
        files = target.WRITER.files(subject)
        texts += [files[f"{name}.st"], files[f"{name}_Test.st"]]
    first = next(iter(made))
    broken = (
        "\n".join(texts[:2])
        .replace(first, "Broken")
        .replace("Present - Threshold", "Present + Threshold")
    )
    (tmp_path / "all.st").write_text("\n".join([*texts, broken]), encoding="ascii")
    made["Broken"] = made[first]
    head = tmp_path / ("driver.c" if compiler == "matiec" else "driver.cpp")
    head.write_text(driver(compiler, made))
    command = (
        COMMANDS[compiler].format(tool=folder)
        + f" -ffp-contract=off -fPIC -shared {head} -o all.so"
    )
    done = subprocess.run(command, shell=True, cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, (done.stdout + done.stderr)[:3000]
    library = ctypes.CDLL(str(tmp_path / "all.so"))
    found = {name: list(wrong(library, name, subject)) for name, subject in made.items()}
    assert len(found.pop("Broken")) == 2
    assert "\n".join(line for lines in found.values() for line in lines) == ""
