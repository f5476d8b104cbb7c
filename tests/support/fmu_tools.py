"""What the tests of exported FMUs share."""

import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
from contextlib import contextmanager
from typing import ClassVar

import numpy as np
import pytest

from dehyst.export import compilers
from dehyst_targets.fmu import _sources as sources
from places import SUPPORT

HERE = SUPPORT
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
        patch.setattr(
            sources, "find_spec", lambda name: None
        )  # zig, which test_export_platforms.py tries
        patch.setattr(compilers, "COMPILERS", ("cc",))
        patch.setattr(compilers.found, "__defaults__", (("cc",),))
        patch.setattr(compilers, "LEVELS", ("-O1",))
        yield


class Importer:
    """An instance of an FMU in FMPy, whose variables are set and read by name; `time` is that of the next step."""

    loggers: ClassVar = []  # FMPy calls the one named last, even when its instance is gone

    def __init__(self, path):
        lib = fmpy()
        self.messages, self.time = [], 0.0
        description = lib.read_model_description(str(path))
        self.variables = {variable.name: variable for variable in description.modelVariables}
        self._second = description.fmiVersion == "2.0"
        with (
            tempfile.TemporaryDirectory() as folder
        ):  # a library that is loaded needs no file any more
            self.fmu = lib.instantiate_fmu(
                lib.extract(str(path), folder), description, logger=self._note
            )
        self.loggers.append(self.fmu.callbacks)

    def _note(self, *values):
        self.messages.append(values[-1].decode())

    def __enter__(self):
        return self

    def __exit__(self, *fault):
        self.fmu.freeInstance()

    def enter(self, start=0.0):
        self.time = start
        if self._second:
            self.fmu.setupExperiment(startTime=start)
        self.fmu.enterInitializationMode(**({} if self._second else {"startTime": start}))

    def exit(self):
        self.fmu.exitInitializationMode()

    def step(self, length):
        self.fmu.doStep(self.time, length)
        self.time += length

    def get(self, name):
        variable = self.variables[name]
        length = int(np.prod(variable.shape or 1))
        more = {} if self._second else {"nValues": length}
        return tuple(getattr(self.fmu, f"get{variable.type}")([variable.valueReference], **more))

    def set(self, name, values):
        variable = self.variables[name]
        getattr(self.fmu, f"set{variable.type}")([variable.valueReference], values)

    @contextmanager
    def refuses(self, call, words):
        """A block in which this call is refused, with a message that matches."""
        from fmpy.fmi1 import FMICallException

        with pytest.raises(FMICallException, match=call):
            yield
        assert re.search(words, self.messages[-1]), self.messages[-1]


def fmpy():
    """The package fmpy, or a skip with the line to type."""
    return pytest.importorskip("fmpy", reason="needs FMPy: pip install 'dehyst-targets[fmi]'")


def run_sequences(version, folder, work, *options, count=25_000):
    """Counts of random calls under ASan and UBSan of the sources in an exported folder: name -> number."""
    flags = [
        "-g",
        "-O1",
        "-fsanitize=address,undefined",
        "-fno-sanitize-recover=all",
        f"-DFMI={version}",
        *options,
    ]
    build = [
        CC,
        *flags,
        "-I",
        str(folder / "sources"),
        str(HERE / "fmu_sequences.c"),
        "-o",
        "run",
        "-lm",
    ]
    built = subprocess.run(build, cwd=work, capture_output=True, text=True, check=False)
    if "cannot find" in built.stderr:
        pytest.skip("this compiler has no sanitizers")
    assert built.returncode == 0, built.stderr
    count, seed = (
        os.environ.get("DEHYST_FMU_SEQUENCES", str(count)),
        os.environ.get("DEHYST_FMU_SEED", "1"),
    )
    done = subprocess.run(
        ["./run", count, seed], cwd=work, capture_output=True, text=True, check=False
    )
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
        done = subprocess.run(
            command, cwd=copy, env=where, capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, done.stderr
    assert len(lines) == 2
    assert done.stdout.startswith("largest differences: ")
    return [float(word) for word in done.stdout.split()[2:]]


def readme_simulation(folder, name, outputs):
    """FMPy's result of the simulation that the README of an exported folder shows, and the table packed beside it."""
    from fmpy import read_csv, simulate_fmu

    line = next(
        line for line in (folder / "README.md").read_text().splitlines() if "fmpy simulate" in line
    )
    step, stop = (
        float(re.search(rf"--{word} (\S+)", line)[1]) for word in ("output-interval", "stop-time")
    )
    given = read_csv(folder / "fmpy" / "input.csv")
    fmu = str(folder / f"{name}.fmu")
    result = simulate_fmu(fmu, input=given, output_interval=step, stop_time=stop, output=outputs)
    return result, read_csv(folder / "fmpy" / "expected.csv")
