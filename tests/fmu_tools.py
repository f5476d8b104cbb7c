"""What the tests of exported FMUs share."""

import os
import re
import shlex
import shutil
import subprocess
import sys
from contextlib import contextmanager
from pathlib import Path

import pytest

from dehyst.export import compilers
from dehyst.export.fmu import sources

HERE = Path(__file__).parent
CC = shutil.which("cc") or shutil.which("gcc")
NEEDS_COMPILER = pytest.mark.skipif(
    CC is None or sys.platform != "linux" or os.uname().machine != "x86_64",
    reason="needs a C compiler on x86-64 Linux",
)


COMPILED = {}  # libraries of this process: verify compiles again what export has compiled


@contextmanager
def quickly():
    """One compiler and no cross compiler, each text once: what else there is, one test tries."""
    compiled = sources._compiled

    def once(command, target, texts, library):
        key = (*command, *sources.OPTIONS, library, *sorted(texts.items()))
        if key not in COMPILED:
            COMPILED[key] = compiled(command, target, texts, library)
        return COMPILED[key]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sources, "_compiled", once)
        patch.setattr(sources, "TARGETS", (sources.LINUX,))
        patch.setattr(sources, "find_spec", lambda name: None)  # zig, which test_export_platforms.py tries
        patch.setattr(compilers, "COMPILERS", ("cc",))
        patch.setattr(compilers.found, "__defaults__", (("cc",),))
        patch.setattr(compilers, "LEVELS", ("-O1",))
        yield


def fmpy():
    """The package fmpy, or a skip with the line to type."""
    return pytest.importorskip("fmpy", reason="needs FMPy: pip install 'dehyst[fmi]'")


def run_sequences(version, folder, work, *options, count=25_000):
    """Counts of random calls under ASan and UBSan of the sources in an exported folder: name -> number."""
    flags = ["-g", "-O1", "-fsanitize=address,undefined", "-fno-sanitize-recover=all", f"-DFMI={version}", *options]
    build = [CC, *flags, "-I", str(folder / "sources"), str(HERE / "fmu_sequences.c"), "-o", "run", "-lm"]
    built = subprocess.run(build, cwd=work, capture_output=True, text=True, check=False)
    if "cannot find" in built.stderr:
        pytest.skip("this compiler has no sanitizers")
    assert built.returncode == 0, built.stderr
    count, seed = os.environ.get("DEHYST_FMU_SEQUENCES", str(count)), os.environ.get("DEHYST_FMU_SEED", "1")
    done = subprocess.run(["./run", count, seed], cwd=work, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    numbers = {name: int(number) for number, name in re.findall(r"(\d+) (\w+)", done.stdout)}
    assert numbers["sequences"] == int(count)
    assert 0.1 * numbers["calls"] < numbers["refused"] < 0.9 * numbers["calls"]
    assert numbers["steps"] > 0.02 * numbers["calls"]
    return numbers


def readme_commands(folder, work):
    """Run the two lines of an exported README, FMPy's and the comparison, on a copy; the differences they print."""
    copy = shutil.copytree(folder, work / "copy")
    lines = re.findall(r"`((?:fmpy simulate|python -c) .*)`", (copy / "README.md").read_text())
    where = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    for line in lines:
        words = shlex.split(line)
        command = [sys.executable, *(words[1:] if words[0] == "python" else ["-m", *words])]
        done = subprocess.run(command, cwd=copy, env=where, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
    assert len(lines) == 2
    assert done.stdout.startswith("largest differences: ")
    return [float(word) for word in done.stdout.split()[2:]]


def readme_simulation(folder, name, outputs):
    """FMPy's result of the simulation that the README of an exported folder shows, and the table packed beside it."""
    from fmpy import read_csv, simulate_fmu

    line = next(line for line in (folder / "README.md").read_text().splitlines() if "fmpy simulate" in line)
    step, stop = (float(re.search(rf"--{word} (\S+)", line)[1]) for word in ("output-interval", "stop-time"))
    given = read_csv(folder / "fmpy" / "input.csv")
    fmu = str(folder / f"{name}.fmu")
    result = simulate_fmu(fmu, input=given, output_interval=step, stop_time=stop, output=outputs)
    return result, read_csv(folder / "fmpy" / "expected.csv")
