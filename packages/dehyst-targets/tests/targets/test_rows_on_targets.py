"""Every row that `auto` can choose, and a direct inverse, on every target: the model's bits, in float to 1e-5.

All units of one precision are one program, so that a target costs one compilation. The table of
docs/explanation/rows-on-targets.md is the one that is made here.
"""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from dehyst.export import c, core_files, export
from dehyst.export._signal import same_bits
from dehyst.families import ROWS
from dehyst.identification._families import FAMILIES
from dehyst_targets.fmu import _sources as sources
from dehyst_targets.fmu import package
from dehyst_targets.fmu._verification import run_fmu
from fmu_tools import NEEDS_COMPILER, quickly
from places import ROOT
from row_samples import models, units, use_of

sys.path.insert(0, str(ROOT / "benchmarks"))
from target import machines

BOARD_SAMPLES = (
    250  # of the test signal: in that time is what is no number, and switching off and on
)
SURE = 3  # flags that no last digit turns: rejected
EXACT = ("-std=c99", "-ffp-contract=off")
PLACES = {  # triple of zig, packages of Debian, how it is started, byte order, environment
    "aarch64": (
        "aarch64-linux-gnu.2.17", "qemu-user libc6-arm64-cross",
        ("/usr/bin/qemu-aarch64", "-L", "/usr/aarch64-linux-gnu"), "<", {},
    ),
    "s390x": (
        "s390x-linux-gnu.2.17", "qemu-user libc6-s390x-cross", ("/usr/bin/qemu-s390x", "-L", "/usr/s390x-linux-gnu"),
        ">", {},
    ),
    "win64": (
        "x86_64-windows-gnu", "wine64", ("/usr/lib/wine/wine64",), "<",
        {"WINEPREFIX": os.environ.get("WINEPREFIX", str(Path.home() / ".wine")), "WINEDEBUG": "-all"},
    ),
}  # fmt: skip


COLUMNS = {  # of the table; what the words mean stands under it
    "C: gcc, clang, tcc": "both", "Cortex-M3, M4F, M7": "both", "ARM64, s390x": "both", "Windows": "both",
    "FMI 2.0, 3.0": "both", "Structured Text": "bits", "Rust": "bits", "Ada": "bits",
}  # fmt: skip
PAGE = ROOT / "docs" / "explanation" / "rows-on-targets.md"


def table():
    """The table of the page: which tests here cover which row on which target."""
    lines = ["| | exported | " + " | ".join(COLUMNS) + " |", "|---|---|" + "---|" * len(COLUMNS)]
    lines += [
        f"| `{name}` | {use_of(name)} | {' | '.join(COLUMNS.values())} |" for name in models()
    ]
    return "\n".join(lines)


def test_the_page_has_the_table_of_these_tests_and_every_row_that_can_be_chosen():
    assert table() in PAGE.read_text(encoding="utf-8"), table()
    plays = {"pi", "modified-pi", "stop"}
    assert {row.name for row in ROWS if row.chosen != "never"} | plays | {
        "direct-inverse"
    } == models().keys()
    assert set(FAMILIES) == {
        "pi",
        "pi-cumulative",
        "modified-pi",
        "stop",
    }  # pi-cumulative is pi, fitted otherwise


def image(real, folder):
    """Sources of all units in a precision with their core, and a program that runs the signals of a job."""
    made = units(real)
    for subject in made.values():
        for name, text in {**core_files.needed(subject.functions), **c.unit_files(subject)}.items():
            (folder / name).write_text(text)
    calls = "".join(
        f"    {{ static {name}_state unit; {name}_reset(&unit); io_read(&n, sizeof n);\n"
        f"      for (uint32_t k = 0; k < n; ++k) {{ io_read(x, {len(subject.block.inputs)} * sizeof x[0]); "
        f"io_read(&on, sizeof on);\n        dehyst_real y = {name}_step(&unit, "
        f"{', '.join(f'x[{i}]' for i in range(len(subject.block.inputs)))}, (int)on); "
        f"uint32_t flags = {name}_flags(&unit);\n"
        f"        io_write(&y, sizeof y); io_write(&flags, sizeof flags); }} }}\n"
        for name, subject in made.items()
    )
    heads = "".join(f'#include "{name}.h"\n' for name in made)
    variables = "    uint32_t n = 0, on = 0;\n    dehyst_real x[4];\n"
    program = f'#include "io.h"\n{heads}int main(void)\n{{\n{variables}{calls}    return 0;\n}}\n'
    (folder / "main").mkdir()
    (folder / "main" / "rows.c").write_text(program)
    return folder


def job(real, order="<", samples=None):
    """Signals of all units as a program reads them, in the byte order of its processor."""
    parts = []
    for subject in units(real).values():
        test, kind = subject.test, f"{order}f{8 if real == 'double' else 4}"
        rows = np.empty(
            min(test.samples, samples or test.samples),
            [("x", kind, test.inputs.shape[1]), ("on", f"{order}u4")],
        )
        with np.errstate(over="ignore", under="ignore"):
            rows["x"], rows["on"] = test.inputs[: rows.size], test.switch[: rows.size]
        parts += [np.array(rows.size, f"{order}u4").tobytes(), rows.tobytes()]
    return b"".join(parts)


def allowed(subject):
    """What float may differ by."""
    return 1e-5 * (subject.output.high - subject.output.low)


def wrong(real, content, order="<", samples=None):
    """Which units answer otherwise than their model, at which sample."""
    kind, at, found = f"{order}f{8 if real == 'double' else 4}", 0, {}
    for name, subject in units(real).items():
        test = subject.test
        n = min(test.samples, samples or test.samples)
        rows = np.frombuffer(content, [("y", kind), ("flags", f"{order}u4")], n, at)
        at += rows.nbytes
        y, due, flags = (
            rows["y"].astype(float),
            test.outputs[:n, 0],
            rows["flags"] ^ test.flags[:n].astype("u4"),
        )
        if real == "double":
            good = (y.view("u8") == due.view("u8")) & (flags == 0)
        else:
            good = (np.abs(y - due) <= allowed(subject)) & (flags & SURE == 0)
        if not good.all():
            found[name] = int(np.argmin(good))
    assert at == len(content)
    return found


@pytest.fixture(scope="module", params=["double", "float"])
def rows(request, tmp_path_factory):
    return request.param, image(request.param, tmp_path_factory.mktemp(request.param))


def ran(rows, command, runner=(), order="<", **env):
    """What all units answer, compiled by a command and started by a runner."""
    real, folder = rows
    program = folder / "rows.exe"
    files = [*sorted(folder.rglob("*.c")), machines.HERE / "host_io.c"]
    done = subprocess.run(
        [*command, f"-I{folder}", f"-I{machines.HERE}", *files, "-o", program],
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    (folder / "job.bin").write_bytes(job(real, order))
    subprocess.run([*runner, program], cwd=folder, check=True, env=os.environ | env, timeout=300)
    return wrong(real, (folder / "answer.bin").read_bytes(), order)


@pytest.mark.slow
@pytest.mark.parametrize(
    "compiler",
    [
        "gcc -O0",
        "gcc -O1",
        "gcc -O2",
        "gcc -O3",
        "clang -O0",
        "clang -O1",
        "clang -O2",
        "clang -O3",
        "tcc",
    ],
)
def test_c_of_every_row_is_the_model_by_every_compiler(rows, compiler):
    words = compiler.split()
    if shutil.which(words[0]) is None:
        pytest.skip(f"needs apt-get install {words[0]}")
    assert ran(rows, [*words, *EXACT[: 1 if words[0] == "tcc" else 2]]) == {}


@pytest.mark.slow
@pytest.mark.parametrize(
    "board", [name for name, machine in machines.MACHINES.items() if machine.board]
)
def test_every_row_is_the_model_on_a_microcontroller(rows, board):
    (real, folder), machine = rows, machines.MACHINES[board]
    if machine.missing():
        pytest.skip(
            f"no {machine.missing()}; on Debian: apt-get install gcc-arm-none-eabi qemu-system-arm"
        )
    program = machines.build(
        machine, folder, real, driver=str(folder / "main" / "rows.c"), core=folder
    )
    content = machines.run(machine, program, job(real, samples=BOARD_SAMPLES), folder)
    assert wrong(real, content, samples=BOARD_SAMPLES) == {}


@pytest.mark.exhaustive
@pytest.mark.parametrize("place", PLACES)
def test_every_row_is_the_model_on_other_processors_and_systems(rows, place):
    zig = pytest.importorskip("ziglang", reason="needs zig: pip install 'dehyst-targets[fmi]'")
    triple, needs, runner, order, env = PLACES[place]
    if not Path(runner[0]).exists() or (len(runner) > 1 and not Path(runner[-1]).is_dir()):
        pytest.skip(f"needs apt-get install {needs}")
    command = (
        Path(zig.__path__[0]) / "zig",
        "cc",
        "-target",
        triple,
        "-O1",
        *EXACT,
        "-fno-sanitize=undefined",
    )
    assert ran(rows, command, runner, order, **env) == {}


@pytest.mark.exhaustive
@NEEDS_COMPILER
@pytest.mark.parametrize("real", ["double", "float"])
@pytest.mark.parametrize("version", [2, 3])
def test_every_row_is_the_model_as_an_fmu(version, real, tmp_path, monkeypatch):
    monkeypatch.setattr(
        sources, "OPTIONS", tuple(word.replace("-O2", "-O0") for word in sources.OPTIONS)
    )
    with quickly():
        for name, subject in units(real).items():
            path = tmp_path / f"{name}.fmu"
            path.write_bytes(package(subject, version).fmu)
            outputs, _ = run_fmu(path, subject, subject.test)
            if real == "double":
                assert same_bits(outputs, subject.test.outputs), name
            assert np.abs(outputs - subject.test.outputs).max() <= allowed(subject), name


def exported(real, target, folder):
    for name, subject in units(real).items():
        export(subject, target, folder / name)
    (folder / "job.bin").write_bytes(job(real))
    return folder


def done(folder, *command):
    said = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    assert said.returncode == 0, said.stdout + said.stderr


@pytest.mark.exhaustive
@pytest.mark.skipif(shutil.which("cargo") is None, reason="needs apt-get install cargo gcc")
def test_every_row_is_the_model_in_rust(tmp_path):
    real, folder = "double", exported("double", "rust", tmp_path)
    needs = "".join(f'{name} = {{ path = "{name}" }}\n' for name in units(real))
    calls = "".join(
        f"    let mut unit = {name}::Unit::new();\n    for _ in 0..u32::from_le_bytes(next(&mut job)) {{\n"
        f"        let x = [{'f64::from_le_bytes(next(&mut job)), ' * len(subject.block.inputs)}];\n"
        f"        let on = u32::from_le_bytes(next(&mut job)) != 0;\n"
        f"        let y = unit.step({''.join(f'x[{i}], ' for i in range(len(subject.block.inputs)))}on);\n"
        f"        answer.extend(y.to_le_bytes());\n        answer.extend(unit.flags().to_le_bytes());\n    }}\n"
        for name, subject in units(real).items()
    )
    program = (
        "fn next<const N: usize>(job: &mut &[u8]) -> [u8; N] {\n    let (first, rest) = job.split_at(N);\n"
        "    *job = rest;\n    first.try_into().unwrap()\n}\n"
        'fn main() {\n    let all = std::fs::read("job.bin").unwrap();\n    let mut job = &all[..];\n'
        f'    let mut answer = Vec::new();\n{calls}    std::fs::write("answer.bin", answer).unwrap();\n}}\n'
    )
    (folder / "src").mkdir()
    (folder / "src" / "main.rs").write_text(program)
    (folder / "Cargo.toml").write_text(
        f'[package]\nname = "rows"\nversion = "0.1.0"\nedition = "2021"\n\n[dependencies]\n{needs}'
    )
    done(folder, "cargo", "run", "-q", "--offline")
    assert wrong(real, (folder / "answer.bin").read_bytes()) == {}


@pytest.mark.exhaustive
@pytest.mark.skipif(
    shutil.which("gprbuild") is None or shutil.which("gnatmake") is None,
    reason="needs apt-get install gnat gprbuild",
)
def test_every_row_is_the_model_in_ada(tmp_path):
    real, folder = "double", exported("double", "ada", tmp_path)
    calls = "".join(
        f"declare\nUnit : {name}.Unit;\nbegin\n{name}.Reset (Unit);\nRead (N'Address, 4);\nfor K in 1 .. N loop\n"
        f"Read (X'Address, {8 * len(subject.block.inputs)});\nRead (On'Address, 4);\n"
        f"{name}.Step (Unit, {', '.join(f'X ({i + 1})' for i in range(len(subject.block.inputs)))}, On /= 0, Y);\n"
        f"Flags := {name}.Flags (Unit);\nWrite (Y'Address, 8);\nWrite (Flags'Address, 4);\nend loop;\nend;\n"
        for name, subject in units(real).items()
    )
    heads = "".join(f"with {name};\n" for name in units(real))
    given = "(Place : System.Address; Bytes : Unsigned_32) with Import, Convention => C, External_Name =>"
    program = (
        f'{heads}with System;\nwith Interfaces; use Interfaces;\nprocedure Rows is\nprocedure Read {given} "io_read";\n'
        f'procedure Write {given} "io_write";\nN, On, Flags : Unsigned_32;\nX : array (1 .. 4) of Long_Float;\n'
        f"Y : Long_Float;\n"
        f"begin\n{calls}end Rows;\n"
    )
    (folder / "main").mkdir()
    (folder / "main" / "rows.adb").write_text(program)
    for name in ("host_io.c", "io.h"):
        shutil.copy(machines.HERE / name, folder / "main")
    projects = "".join(f'with "{name}/{name}.gpr";\n' for name in units(real))
    (folder / "rows.gpr").write_text(
        f'{projects}project Rows is\nfor Languages use ("Ada", "C");\nfor Source_Dirs use ("main");\n'
        f'for Main use ("rows.adb");\nend Rows;\n'
    )
    done(folder, "gprbuild", "-q", "-p", "-P", "rows.gpr")
    done(folder, "./rows")
    assert wrong(real, (folder / "answer.bin").read_bytes()) == {}
