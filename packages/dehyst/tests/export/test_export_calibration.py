"""Calibration: A2L files that tools take, addresses that hold the model's numbers, tunable numbers that count whole."""

import re
import select
import shutil
import struct
import subprocess
import sys
import sysconfig
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from dehyst.errors import ParameterError
from dehyst.export import export, subject_of
from dehyst.families import example
from dehyst.models import Block, ModelCard, SignalCard
from dehyst_robot.control import JointControllerParameters
from dehyst_robot.export import joint_subject
from direct_export_samples import direct_model
from export_samples import MODELS, mapped_model, play_model
from test_export_c import WARNINGS, needs
from test_export_c import run as told

CARD = ModelCard(SignalCard("voltage", "V", -1.0, 1.0), SignalCard("travel", "mm", -2.0, 2.0))
FORMATS = {"FLOAT64_IEEE": "d", "FLOAT32_IEEE": "f", "ULONG": "I", "SLONG": "i"}
ITEM = re.compile(
    r'(?s)/begin (CHARACTERISTIC|AXIS_PTS|MEASUREMENT) (\S+) (.*?)SYMBOL_LINK "([^"]+)" 0 /\* (\d+) bytes'
)
HARNESS = """
#include <stdio.h>
#include "elbow.h"

static elbow_state unit;

/* "x on": one step; "0 N", N > 1: so many steps, and how many answers were no multiple of 1/1024 or refused a page. */
int main(void)
{
    double x;
    long on;
    elbow_reset(&unit);
    puts("ready");
    fflush(stdout);
    while (scanf("%lf %ld", &x, &on) == 2) {
        if (on < 2) {
            const double answer = elbow_step(&unit, x, (int)on);
            printf("%.17g %u\\n", answer, (unsigned)unit.page);
        } else {
            long torn = 0, switched = 0;
            for (long k = 0; k < on; ++k) {
                const uint32_t was = unit.page;
                const double answer = 1024 * elbow_step(&unit, (k % 200 - 100) * 0.03, 1);
                torn += answer < (double)(long)answer || answer > (double)(long)answer || unit.page == 2;
                switched += unit.page != was;
            }
            printf("%ld %ld\\n", torn, switched);
        }
        fflush(stdout);
    }
    return 0;
}
"""


def a2ltool():
    found = shutil.which("a2ltool", path=sysconfig.get_path("scripts")) or shutil.which("a2ltool")
    return found or pytest.skip("no a2ltool; pip install a2ltool")


def subjects():
    row = replace(example("mixed-sum"), card=CARD)
    joint = JointControllerParameters()
    yield subject_of(mapped_model(), name="elbow", ramp=40, tunable=True)
    yield subject_of(play_model(), "forward", name="elbow", real="float", follow_offset=0.1)
    yield subject_of(row, name="elbow", tunable=True)
    yield subject_of(direct_model(), name="elbow", period=1e-3, tunable=True)
    yield joint_subject(play_model(), joint, name="elbow")
    yield joint_subject(direct_model(), joint, name="elbow", real="float")


CASES = list(subjects())


def linked(folder, compiler="cc", *flags):
    """The example, with debug information; another compiler's runtime is not needed."""
    sources = sorted(path.relative_to(folder).as_posix() for path in folder.glob("src/*.c"))
    told(
        compiler,
        "-g",
        "-O2",
        "-Isrc",
        "-I.",
        *flags,
        "example/main.c",
        *sources,
        "-o",
        "program",
        cwd=folder,
    )
    return folder / "program"


def filled(folder, program, state="unit"):
    pytest.importorskip("elftools")
    made = folder / "filled.a2l"
    script = folder / "calibration" / "addresses.py"
    told(
        sys.executable, str(script), str(program), "--state", state, "--out", str(made), cwd=folder
    )
    return made


def items(path):
    """Symbol -> address, format and count of every item of an A2L file."""
    text, found = path.read_text(), {}
    layouts = dict(re.findall(r"RECORD_LAYOUT (\w+) \w+ 1 (\w+)", text))
    for kind, _, body, symbol, size in ITEM.findall(text):
        word = re.search(r'" (\w+)', body)[1] if kind == "MEASUREMENT" else ""
        data = word or layouts[re.search(r"0x\w+ (?:NO_INPUT_QUANTITY )?(\w+)", body)[1]]
        form = FORMATS[data]
        found[symbol] = (
            int(re.search(r"0x(\w+)", body)[1], 16),
            form,
            int(size) // struct.calcsize(form),
        )
    return found


def value(elf, address, form, count):
    """What lies at an address of a program that does not run."""
    for segment in elf.iter_segments("PT_LOAD"):
        begin = segment["p_vaddr"]
        if begin <= address < begin + segment["p_filesz"]:
            data = segment.data()[address - begin :][: count * struct.calcsize(form)]
            return struct.unpack("<" + count * form, data)
    raise AssertionError(f"nothing of the program is at {address:x}")


@pytest.mark.slow
@pytest.mark.parametrize("one", CASES, ids=lambda one: f"{one.what}-{one.numbers.core}-{one.real}")
@pytest.mark.parametrize("target", ["c", "c-header"])
def test_a_strict_parser_takes_the_file_and_finds_the_same_addresses(one, target, tmp_path):
    needs("cc")
    folder = export(one, target, tmp_path / "out").folder
    told(a2ltool(), "--strict", "--check", "calibration/elbow.a2l", cwd=folder)
    program = linked(folder, "cc", "-Wl,--no-gc-sections")
    made = filled(folder, program)
    own = (
        "--strict",
        "--check",
        "--elffile",
        str(program),
        "--update",
        "ADDRESSES",
        "--update-mode",
        "STRICT",
    )
    told(a2ltool(), str(made), *own, "-o", "theirs.a2l", cwd=folder)
    ours, theirs = (
        re.findall(r"0x([0-9A-Fa-f]{4,})", text)
        for text in (made.read_text(), (folder / "theirs.a2l").read_text())
    )
    assert len(ours) > 20 and [int(word, 16) for word in ours] == [int(word, 16) for word in theirs]


def expected(one):
    """Symbol -> numbers of the constants, from the record of the unit."""
    b, name = one.block, one.name
    limits = (
        "input_low",
        "input_high",
        "output_low",
        "output_high",
        "line_slope",
        "line_offset",
        "fade",
    )
    values = {f"{name}_block.{limit}": (getattr(b, limit),) for limit in limits}
    tables = {
        "threshold": b.model.threshold,
        "slope": b.model.slope,
        "loading": b.model.loading,
        "start": b.model.start,
    }
    for place in ("before", "after"):
        points = getattr(b.model, place)
        tables |= {f"{place}_u": points[0], f"{place}_v": points[1]} if points else {}
    values |= {f"{name}_{table}": numbers for table, numbers in tables.items()}
    page = (1.0, -0.0, b.output_low, b.output_high, b.fade)
    parts = ("scale", "offset", "output_low", "output_high", "fade")
    pages = {
        f"{name}_page[{k}].{part}": (number,)
        for k in (0, 1)
        for part, number in zip(parts, page, strict=True)
    }
    return values | (pages if one.tunable else {})


@pytest.mark.slow
@pytest.mark.parametrize("compiler", ["gcc", "clang", "arm-none-eabi-gcc"])
@pytest.mark.parametrize("real", ["double", "float"])
def test_each_address_holds_the_number_that_the_file_names(compiler, real, tmp_path):
    needs(compiler)
    elffile = pytest.importorskip("elftools.elf.elffile").ELFFile
    one = subject_of(mapped_model(), name="elbow", ramp=40, real=real, tunable=True)
    folder = export(one, "c", tmp_path / "out").folder
    bare = (
        ("-mcpu=cortex-m4", "-mthumb", "--specs=nosys.specs") if compiler.startswith("arm") else ()
    )
    program = linked(folder, compiler, *bare)
    found = items(filled(folder, program))
    with program.open("rb") as stream:
        elf = elffile(stream)
        for symbol, numbers in expected(one).items():
            address, form, count = found[symbol]
            held = value(elf, address, form, count)
            assert np.array(held).tobytes() == np.array(numbers, float).tobytes(), symbol
    assert found["unit.z"][2] == one.operators


@pytest.mark.slow
def test_a_program_that_does_not_hold_the_unit_is_refused_with_what_to_type(tmp_path):
    needs("cc")
    folder = export(subject_of(play_model(), name="elbow", ramp=40), "c", tmp_path / "out").folder
    other = export(
        subject_of(mapped_model(), name="elbow", ramp=40), "c", tmp_path / "other"
    ).folder
    pytest.importorskip("elftools")
    script = [sys.executable, "calibration/addresses.py", "--out", "x.a2l"]
    for made, flags, more, words in (
        (other, (), (), "another export of this unit"),
        (folder, (), ("--state", "motor"), "no variable called 'motor': compile"),
        (folder, ("-g0",), (), "with -g"),
    ):
        program = linked(made, "cc", *flags)
        said = subprocess.run(
            [*script, str(program), *more], cwd=folder, capture_output=True, text=True, check=False
        )
        assert said.returncode == 1 and words in said.stderr and not (folder / "x.a2l").exists()


@pytest.mark.parametrize(
    "one", [one for one in CASES if one.tunable], ids=lambda one: one.numbers.core
)
def test_tunable_sources_are_clean_as_c_and_as_cpp(one, tmp_path):
    needs("cc", "c++")
    for target in ("c", "c-header"):
        folder = export(one, target, tmp_path / target).folder
        sources = [path.relative_to(folder).as_posix() for path in sorted(folder.rglob("*.c"))]
        for language, standard in (("c", "c99"), ("c++", "c++17")):
            options = (
                "-x",
                language,
                f"-std={standard}",
                "-O2",
                "-fsyntax-only",
                *WARNINGS,
                "-I.",
                "-Isrc",
                "-Icheck",
            )
            told("cc", *options, *sources, cwd=folder)


class Running:
    """A program that steps a unit, and its memory through the addresses of an A2L file."""

    def __init__(self, one, folder):
        made = export(one, "c", folder / "out").folder
        (made / "example" / "main.c").write_text(HARNESS)
        program = linked(made, "cc", "-no-pie")
        self.at = items(filled(made, program))
        self.process = subprocess.Popen(
            [program], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, bufsize=1
        )
        assert self.process.stdout.readline() == "ready\n"
        try:
            self.memory = Path(f"/proc/{self.process.pid}/mem").open("r+b", buffering=0)  # noqa: SIM115 - of __exit__
        except OSError:
            self.process.kill()
            pytest.skip("this system lets nobody write the memory of a process")

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.stdin.close()
        self.process.wait(20)
        self.memory.close()

    def step(self, x, on=1):
        self.process.stdin.write(f"{x!r} {on}\n")
        answer, page = self.process.stdout.readline().split()
        return float(answer), int(page)

    @property
    def answered(self):
        """Whether there is a line to be read."""
        return bool(select.select([self.process.stdout], [], [], 0.0)[0])

    def write(self, symbol, number):
        address, form, _ = self.at[f"elbow_{symbol}"]
        self.memory.seek(address)
        self.memory.write(struct.pack(form, number))

    def read(self, symbol):
        address, form, count = self.at[f"unit.{symbol}"]
        self.memory.seek(address)
        return struct.unpack(count * form, self.memory.read(count * struct.calcsize(form)))

    def page(self, k, **numbers):
        for name, number in numbers.items():
            self.write(f"page[{k}].{name}", number)


def wandering(low, high, samples=300):
    rng = np.random.default_rng(3)
    x = 0.5 * (low + high) + 0.6 * (high - low) * np.sin(0.11 * np.arange(samples)) * rng.uniform(
        0.3, 1.0, samples
    )
    return [float(one) for one in x]


@pytest.mark.slow
def test_a_step_takes_a_tuned_page_whole_from_the_sample_on_that_finds_its_number(tmp_path):
    needs("cc")
    one = subject_of(mapped_model(), name="elbow", ramp=40, tunable=True)
    block = Block(mapped_model(), "inverse", ramp=40)
    x = wandering(0.2 * one.input.low, 0.2 * one.input.high)
    said = [block.step(each, True) for each in x]
    scale, offset, low, high = 0.5, 0.25, one.output.low, one.output.high
    with Running(one, tmp_path) as unit:
        for k, each in enumerate(x):
            if k == 100:
                unit.page(1, scale=scale)
            if k == 110:
                unit.page(1, offset=offset)
            if k == 120:
                unit.write("page_number", 1)
            if k == 200:
                unit.page(0, scale=float("nan"))
                unit.write("page_number", 0)
            answer, page = unit.step(each)
            tuned = 120 <= k < 200
            assert page == (1 if tuned else 0 if k < 120 else 2)
            assert answer == (
                min(max(offset + scale * said[k], low), high) if tuned else said[k]
            ), k
            assert unit.read("answer") == (answer,) and unit.read("page") == (page,)
            assert unit.read("block.output") == pytest.approx((said[k],), abs=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("name", list(MODELS))
def test_tuned_limits_hold_the_memory_back_as_a_block_of_these_limits_does(name, tmp_path):
    needs("cc")
    one = subject_of(MODELS[name](), name="elbow", ramp=40, tunable=True)
    low, high = one.output.low, one.output.high
    narrow = low + 0.3 * (high - low), low + 0.8 * (high - low)
    block = Block(MODELS[name](), "inverse", narrow, 40)
    with Running(one, tmp_path) as unit:
        unit.page(1, output_low=narrow[0], output_high=narrow[1])
        unit.write("page_number", 1)
        limited = 0
        for each in wandering(one.input.low, one.input.high):
            answer, _ = unit.step(each)
            assert answer == pytest.approx(block.step(each, True), abs=1e-9 * (high - low))
            limited += answer in narrow
        assert 30 < limited < 270
        assert unit.read("block.flags")[0] & 4 == 4 * (answer in narrow)


@pytest.mark.slow
def test_no_step_sees_half_of_a_page_while_another_process_writes(tmp_path):
    needs("cc")
    one = subject_of(play_model(), name="elbow", ramp=40, tunable=True)
    first, last = (int(1024 * end) for end in (one.output.low + 0.1, one.output.high - 0.1))
    with Running(one, tmp_path) as unit:
        unit.page(1, output_low=first / 1024, output_high=first / 1024)
        unit.write("page_number", 1)
        unit.step(0.0)
        unit.process.stdin.write("0 30000000\n")
        number, k = 1, first
        for _ in range(400):
            k = first + (k - first + 37) % (last - first)
            # On a busy machine the steps may end first.
            while unit.read("page")[0] != number and not unit.answered:
                pass
            if unit.answered:
                break
            number = 1 - number
            unit.page(number, output_low=k / 1024, output_high=k / 1024)
            unit.write("page_number", number)
        torn, switched = map(int, unit.process.stdout.readline().split())
    assert torn == 0 and switched >= 100


@pytest.mark.parametrize("target", ["simulink", "arduino", "st", "fmu3"])
def test_targets_without_calibration_refuse_tunable_numbers(target, tmp_path):
    one = subject_of(
        play_model(), name="elbow", real="float" if target == "arduino" else "double", tunable=True
    )
    with pytest.raises(ParameterError, match=r"no --tunable.*--target c"):
        export(one, target, tmp_path / "out")


def test_what_does_not_go_with_tunable_numbers_is_refused(tmp_path):
    with pytest.raises(
        ParameterError, match=r"--follow-offset 0.1: .* takes it away again .* leave --tunable out"
    ):
        subject_of(play_model(), name="elbow", follow_offset=0.1, tunable=True)


def test_without_the_option_an_export_has_no_line_of_it(tmp_path):
    folder = export(subject_of(mapped_model(), name="elbow"), "c", tmp_path / "out").folder
    for name in (
        "src/elbow.c",
        "src/elbow.h",
        "check/check.c",
        "calibration/elbow.a2l",
        "README.md",
    ):
        assert "page" not in (folder / name).read_text(), name


def test_the_command_refuses_tunable_numbers_of_a_controller_and_writes_those_of_a_unit(
    run, tmp_path
):
    model = play_model().save(tmp_path / "model.json")
    ask = (
        "export",
        model,
        "--target",
        "c",
        "--tunable",
        "--name",
        "elbow",
        "--out",
        tmp_path / "out",
    )
    status, _, err = run(*ask, "--what", "joint-controller", "--controller", "controller.json")
    said = " ".join(err.split())
    assert status == 2 and "--tunable belongs to --what inverse or forward: the numbers" in said
    assert (
        "--what joint-controller --controller controller.json --out" in said
        and "--overwrite" in said
    )
    assert (
        run(*ask)[0] == 0 and "elbow_page[2]" in (tmp_path / "out" / "src" / "elbow.h").read_text()
    )
