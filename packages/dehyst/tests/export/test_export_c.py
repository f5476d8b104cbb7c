"""Exports to C: folders that check themselves, strict and self-contained code, refusals that lose nothing."""

import json
import platform
import re
import shutil
import subprocess
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import dehyst
from block_samples import operator_of
from dehyst.errors import ModelFileError, OutputError, ParameterError
from dehyst.export import TARGETS, compilers, core_files, export, subject_of
from dehyst.export._names import check_name, identifier
from dehyst.export._rendering import comment, string_literal
from dehyst.export._signal import from_csv, same_bits, to_csv
from dehyst.export._units import block_numbers
from dehyst.export.precision import in_real, inward, literal, pattern
from dehyst.models import Block
from dehyst_robot.control import JointControllerParameters, load_controller, save_controller
from dehyst_robot.export import joint_subject
from dehyst_robot.export._joint_run import joint_run
from export_samples import CARD, MODELS, large_model, mapped_model, play_model

C_TARGETS = ("c", "c-header")
REALS = ("double", "float")
KINDS = (
    ("inverse", "c"),
    ("joint-controller", "c"),
    ("joint-controller", "c-header"),
    ("inverse", "c-header"),
)
WARNINGS = ("-Wall", "-Wextra", "-Wconversion", "-Wpedantic", "-Werror")


def needs(*tools):
    for tool in tools:
        if shutil.which(tool) is None:
            pytest.skip(f"no {tool}; on Debian: apt-get install {tool}")


@cache
def subject(model="play", what="inverse", real="double"):
    if what == "joint-controller":
        return joint_subject(MODELS[model](), JointControllerParameters(), name="axis_1", real=real)
    return subject_of(MODELS[model](), what, name="unit_1", real=real, ramp=40)


def run(*command, cwd):
    said = subprocess.run(command, cwd=cwd, capture_output=True, text=True, check=False)
    assert said.returncode == 0, said.stdout + said.stderr
    return said.stdout


CASES = [
    ("play", "inverse", "double", "c"),
    ("mapped", "inverse", "double", "c-header"),
    ("mapped", "forward", "float", "c"),
    ("stop", "inverse", "float", "c-header"),
    ("falling", "forward", "double", "c"),
    ("play", "joint-controller", "double", "c"),
    ("play", "joint-controller", "float", "c-header"),
]


@pytest.mark.slow
@pytest.mark.parametrize(("model", "what", "real", "target"), CASES)
def test_a_folder_checks_itself_with_a_compiler_and_make_only(model, what, real, target, tmp_path):
    needs("make", "cc")
    folder = export(subject(model, what, real), target, tmp_path / "out").folder
    (tmp_path / "bin").mkdir()
    for tool in (
        "make",
        "cc",
        "as",
        "ld",
        "sh",
        "mkdir",
    ):  # nothing else is on the path, Python least of all
        (tmp_path / "bin" / tool).symlink_to(shutil.which(tool))
    said = run("env", "-i", f"PATH={tmp_path / 'bin'}", "make", "-s", "check", cwd=folder)
    assert said.splitlines()[-1] == "all checks passed"
    assert "FAILED" not in said


@pytest.mark.slow
@pytest.mark.parametrize(
    ("target", "what", "real"), [(t, w, r) for (w, t), r in zip(KINDS, REALS * 2, strict=True)]
)
@pytest.mark.parametrize("compiler", ["gcc", "clang"])
def test_it_compiles_without_a_warning_as_c99_c11_and_cpp17(target, what, real, compiler, tmp_path):
    needs(compiler)
    folder = export(subject("mapped", what, real), target, tmp_path / "out").folder
    sources = [path.relative_to(folder).as_posix() for path in sorted(folder.rglob("*.c"))]
    for language, standard in (("c", "c99"), ("c", "c11"), ("c++", "c++17")):
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
        run(compiler, *options, *sources, cwd=folder)


@pytest.mark.slow
@pytest.mark.parametrize(("what", "target"), KINDS)
@pytest.mark.parametrize("compiler", ["gcc", "clang"])
def test_no_symbol_outside_the_export_is_needed(target, what, compiler, tmp_path):
    needs(compiler, "nm")
    folder = export(subject("mapped", what), target, tmp_path / "out").folder
    if target == "c-header":
        (folder / "src").mkdir()
        (folder / "src" / "unit.c").write_text(f'#define {subject("mapped", what).name.upper()}_IMPLEMENTATION\n'
                                              f'#include "../{subject("mapped", what).name}.h"\n')  # fmt: skip
    sources = [path.name for path in sorted((folder / "src").glob("*.c"))]
    run(compiler, "-O2", "-ffp-contract=off", "-c", *sources, cwd=folder / "src")
    run("ld", "-r", "-o", "all.o", *[f"{name[:-2]}.o" for name in sources], cwd=folder / "src")
    undefined = set(re.findall(r"\bU (\w+)", run("nm", "all.o", cwd=folder / "src")))
    assert undefined <= {"memcpy", "memmove", "_GLOBAL_OFFSET_TABLE_"}


@pytest.mark.slow
def test_two_headers_live_in_one_file_and_in_one_program(tmp_path):
    needs("cc", "c++")
    for name, what in (("left", "inverse"), ("right", "forward")):
        one = subject_of(mapped_model(), what, name=name, ramp=40)
        folder = export(one, "c-header", tmp_path / name).folder
        shutil.copy(folder / f"{name}.h", tmp_path)
    both = '#define LEFT_IMPLEMENTATION\n#define RIGHT_IMPLEMENTATION\n#include "left.h"\n#include "right.h"\n'
    use = "int main(void) { static left_state l; static right_state r; left_reset(&l); right_reset(&r);\n"
    use += "return left_step(&l, right_step(&r, 0.25, 1), 1) < -9; }\n"
    (tmp_path / "both.c").write_text(both + use)
    (tmp_path / "one.c").write_text(
        '#define LEFT_IMPLEMENTATION\n#include "left.h"\n#include "right.h"\n' + use
    )
    (tmp_path / "other.c").write_text(
        '#define RIGHT_IMPLEMENTATION\n#include "right.h"\n#include "left.h"\n'
    )
    for command in (("cc", "-std=c99", *WARNINGS, "both.c"), ("cc", "-std=c99", *WARNINGS, "one.c", "other.c"),
                    ("c++", "-x", "c++", *WARNINGS, "both.c")):  # fmt: skip
        run(*command, "-o", "program", cwd=tmp_path)
        run("./program", cwd=tmp_path)


def test_headers_of_two_precisions_in_one_file_are_refused_by_name(tmp_path):
    needs("cc")
    for name, real in (("left", "double"), ("right", "float")):
        folder = export(
            subject_of(play_model(), name=name, real=real), "c-header", tmp_path / name
        ).folder
        shutil.copy(folder / f"{name}.h", tmp_path)
    (tmp_path / "both.c").write_text('#include "left.h"\n#include "right.h"\n')
    said = subprocess.run(
        ["cc", "-c", "both.c"], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert said.returncode != 0
    assert "right.h is in float precision" in said.stderr


@pytest.mark.slow
def test_cmake_builds_library_example_and_check(tmp_path):
    needs("cmake", "ctest", "make", "cc")
    for target in C_TARGETS:
        folder = export(subject(), target, tmp_path / target).folder
        run(
            "cmake",
            "-S",
            ".",
            "-B",
            "build",
            "-G",
            "Unix Makefiles",
            "-DCMAKE_BUILD_TYPE=Debug",
            cwd=folder,
        )
        run("cmake", "--build", "build", "-j2", cwd=folder)
        assert "100% tests passed" in run("ctest", "--test-dir", "build", cwd=folder)


@pytest.mark.slow
@pytest.mark.parametrize("what", ["forward", "joint-controller"])
def test_compiled_as_cpp_it_gives_the_same_bits(what, tmp_path):
    needs("g++")
    folder = export(subject("mapped", what), "c", tmp_path / "out").folder
    sources = [f"src/{path.name}" for path in sorted((folder / "src").glob("*.c"))]
    options = (
        "-x",
        "c++",
        "-std=c++17",
        "-O2",
        "-ffp-contract=off",
        "-Isrc",
        "-Icheck",
        "-o",
        "program",
    )
    run("g++", *options, "check/check.c", *sources, cwd=folder)
    assert run("./program", cwd=folder).splitlines()[-1] == "all checks passed"


@pytest.mark.slow
def test_with_fused_multiply_add_it_is_the_makefile_that_keeps_the_bits(tmp_path):
    needs("make", "gcc")
    folder = export(subject("mapped"), "c", tmp_path / "out").folder
    if "fma" not in Path("/proc/cpuinfo").read_text():
        pytest.skip("this processor has no fused multiply-add")
    assert "all checks passed" in run(
        "make", "-s", "check", "CC=gcc", "CFLAGS=-O3 -march=native", cwd=folder
    )


@pytest.mark.slow
def test_a_wrong_build_is_noticed_by_its_own_check(tmp_path):
    needs("make", "cc")
    folder = export(subject("mapped"), "c", tmp_path / "out").folder
    source = folder / "src" / "pi.c"
    source.write_text(source.read_text().replace("pi->offset + ", "pi->offset + 1e-6 + ", 1))
    checks = compilers.check_folder(folder)
    assert checks
    assert all(check.status == "failed" and "test signal" in check.detail for check in checks)
    said = subprocess.run(
        ["make", "-s", "check"], cwd=folder, capture_output=True, text=True, check=False
    )
    assert said.returncode != 0 and said.stdout.splitlines()[-1] == "FAILED: do not use this build"
    assert re.search(
        r"^saved and copied states +not judged", said.stdout, re.M
    )  # they cannot be right either
    assert 1e-9 < float(re.search(r"largest difference (\S+) of range", said.stdout)[1]) < 1e-3


@pytest.mark.slow
@pytest.mark.parametrize("what", ["inverse", "joint-controller"])
@pytest.mark.parametrize(
    ("flags", "cause"),
    [
        ("-O2 -mfpmath=387", "more digits"),
        ("-O3 -ffast-math", "-ffast-math"),
        ("-O3 -mfma", "-ffp-contract=off"),
    ],
)
def test_other_last_digits_are_told_from_a_wrong_unit_with_their_cause(
    what, flags, cause, tmp_path
):
    needs("make", "gcc")
    if platform.machine() != "x86_64" or (
        "fma" in flags and "fma" not in Path("/proc/cpuinfo").read_text()
    ):
        pytest.skip("this processor has no x87 arithmetic, or no fused multiply-add")
    folder = export(subject("mapped", what), "c", tmp_path / "out").folder
    contract = "CONTRACT=-ffp-contract=fast" if "mfma" in flags else "CONTRACT=-ffp-contract=off"
    said = run("make", "-s", "check", "CC=gcc", f"CFLAGS={flags}", contract, cwd=folder)
    last = said.splitlines()[-1]
    assert (
        re.fullmatch(r"other last digits \(\S+ of range\): usable, not bit-equal, because .*", last)
        and cause in last
    )
    assert "FAILED" not in said and float(re.search(r"\((\S+) of range", last)[1]) < 1e-9


@pytest.mark.slow
def test_clang_keeps_the_bits_without_an_option(tmp_path):
    needs("make", "clang")
    folder = export(subject("mapped"), "c", tmp_path / "out").folder
    flags = "-O3 -mfma" if "fma" in Path("/proc/cpuinfo").read_text() else "-O3"
    assert "all checks passed" in run(
        "make", "-s", "check", "CC=clang", f"CFLAGS={flags}", "CONTRACT=", cwd=folder
    )


@pytest.mark.slow
def test_under_fast_math_the_guard_and_the_limits_hold(tmp_path):
    needs("make", "gcc")
    folder = export(subject("mapped"), "c", tmp_path / "out").folder
    said = subprocess.run(
        ["make", "-s", "check", "CC=gcc", "CFLAGS=-Ofast"],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    ).stdout
    assert re.search(r"random bit patterns: .* ok", said)


# ---- What is in a folder.


def moved(numbers, h):
    """Return which operators (n,) arguments of the hysteresis (T,) move up and down: the definition, in NumPy."""
    r, z = np.asarray(numbers.model.threshold), np.asarray(numbers.model.start).copy()
    up, down = np.zeros(r.size, dtype=bool), np.zeros(r.size, dtype=bool)
    for x in h:
        new = np.maximum(x - r, np.minimum(x + r, z))
        up |= new > z
        down |= new < z
        z = new
    return up & down


def test_the_test_signal_moves_every_operator_both_ways_meets_limits_and_is_no_number_at_times():
    for name in MODELS:
        for what in ("inverse", "forward"):
            one = subject(name, what)
            step = operator_of(Block(one.model, what, ramp=40)).stepper("dense")
            x = np.clip(one.test.inputs[:, 0], one.block.input_low, one.block.input_high)
            arguments = x[np.isfinite(x)]
            before = one.block.model.before
            mapped = arguments if before is None else dehyst.MonotoneMap(*before)(arguments)
            assert moved(one.block, mapped - one.block.model.center).all(), (name, what)
            assert step.state.size == one.operators
            flags = one.test.flags
            assert {1, 4} <= {int(bit) for bit in (1, 4) if np.any(flags & bit)}
            assert 0 < one.test.switch.mean() < 1
            outputs = one.test.outputs[:, 0]
            assert outputs.min() >= one.block.output_low
            assert outputs.max() <= one.block.output_high


def test_a_recorded_run_of_a_controller_switches_bridges_faults_and_fails_safe():
    run_ = joint_run(JointControllerParameters(), play_model().inverse(), "double")
    raised = np.bitwise_or.reduce(run_.flags)
    assert raised & 0b11101111 == 0b11101111  # all but the limit of the pressures
    assert set(np.unique(run_.switch)) >= {0, 1, 3, 7}
    assert np.isfinite(run_.outputs).all()


def test_the_manifest_names_every_file_and_the_model(tmp_path):
    written = export(subject(), "c", tmp_path / "out")
    manifest = json.loads((written.folder / "manifest.json").read_text())
    on_disk = {
        path.relative_to(written.folder).as_posix()
        for path in written.folder.rglob("*")
        if path.is_file()
    }
    assert on_disk == {*manifest["files"], "manifest.json"} == set(written.files)
    model = dehyst.load(written.folder / "model.json")
    assert (
        manifest["model_sha256"]
        == json.loads((written.folder / "model.json").read_text())["sha256"]
    )
    assert model.weights.tolist() == play_model().weights.tolist()
    assert (manifest["input"]["unit"], manifest["output"]["unit"]) == ("deg", "bar")


def test_the_core_is_exported_as_it_is(tmp_path):
    folder = export(subject("mapped"), "c", tmp_path / "out").folder
    for path in (folder / "src").iterdir():
        if path.name not in ("unit_1.c", "unit_1.h", core_files.CONFIG):
            assert path.read_text() == core_files.core_files()[path.name]


def test_the_same_model_gives_the_same_files(tmp_path):
    a, b = (export(subject_of(play_model(), name="u"), "c", tmp_path / name) for name in "ab")
    same = {
        name for name in a.files if (a.folder / name).read_bytes() == (b.folder / name).read_bytes()
    }
    assert same >= set(a.files) - {"manifest.json"}  # which carries the date


@pytest.mark.slow
def test_text_of_a_log_cannot_leave_a_comment_or_a_string(tmp_path):
    needs("make", "cc")
    evil = 'a*/ int x; /*\\\n??/ "%s%n" é\u202e\x07'
    card = type(CARD)(
        type(CARD.input)(evil, evil, -1.0, 1.0),
        type(CARD.output)(evil, evil, -2.0, 2.0),
        {evil: evil},
    )
    folder = export(subject_of(play_model(card), name="unit_1"), "c", tmp_path / "out").folder
    run(
        "make",
        "-s",
        "check",
        "WARNINGS=-Wall -Wextra -Wcomment -Wformat -Werror -Wtrigraphs",
        cwd=folder,
    )
    run("make", "-s", "run", cwd=folder)
    assert "*/" not in comment(evil)
    assert '"' not in string_literal('"').replace('\\"', "")


# ---- Numbers.


@pytest.mark.parametrize(
    "value", [0.0, -0.0, 0.1, -3.0, 5e-324, 1.7976931348623157e308, 2**-1022, 1 / 3]
)
def test_a_constant_is_the_number_to_the_bit(value):
    assert same_bits(np.array([float.fromhex(literal(value, "double"))]), np.array([value]))
    assert int(pattern(value).rstrip("u"), 16) == int(np.float64(value).view(np.uint64))


def test_rounding_to_float_leaves_no_range_and_lets_nothing_out():
    rng = np.random.default_rng(0)
    for low, high in np.sort(
        rng.normal(size=(200, 2)) * 10.0 ** rng.integers(-6, 6, (200, 1)), axis=1
    ):
        below, above = inward(low, high, "float")
        assert low <= below <= above <= high
        assert np.float32(below) == below


def test_thresholds_that_become_one_in_float_are_refused():
    model = dehyst.PrandtlIshlinskii([0.0, 1.0, 1.0 + 1e-12], [1.0, 0.5, 0.5], card=CARD)
    subject_of(model, "forward", name="u")
    with pytest.raises(ParameterError, match=r"--real float.*--real double"):
        subject_of(model, "forward", name="u", real="float")


def test_a_table_is_read_back_to_the_bit():
    signal = subject("mapped").test
    again = from_csv(to_csv(signal), 1)
    assert same_bits(again.inputs, signal.inputs)
    assert same_bits(again.outputs, signal.outputs)
    assert np.array_equal(again.flags, signal.flags)


def test_numbers_of_a_block_are_those_that_the_extension_uses():
    block = Block(mapped_model())
    numbers = block_numbers(block)
    assert numbers.model.slope == tuple(block.parameters.slope)
    assert in_real(numbers.model, "float").slope == tuple(
        block.parameters.slope.astype(np.float32).astype(float)
    )


@pytest.mark.parametrize("what", ["inverse", "joint-controller", "tunable"])
@pytest.mark.parametrize("real", ["double", "float"])
def test_the_memory_that_is_printed_is_what_a_compiler_for_a_32_bit_target_takes(
    what, real, tmp_path
):
    needs("arm-none-eabi-gcc", "arm-none-eabi-nm", "arm-none-eabi-size")
    tunable = what == "tunable"
    one = (
        subject_of(mapped_model(), name="unit_1", real=real, tunable=True)
        if tunable
        else subject("mapped", what, real)
    )
    written = export(one, "c", tmp_path / "out")
    here = written.folder / "src"
    (here / "sizes.c").write_text(
        f'#include "{one.name}.h"\nchar state[sizeof({one.name}_state)], image[4 * {one.name.upper()}_IMAGE_WORDS];\n'
    )
    run(
        "arm-none-eabi-gcc",
        "-mcpu=cortex-m4",
        "-mthumb",
        "-O2",
        "-c",
        "sizes.c",
        f"{one.name}.c",
        cwd=here,
    )
    listed = re.findall(
        r"(?m)^\w+ (\w+) \w (\w+)$", run("arm-none-eabi-nm", "-S", "sizes.o", cwd=here)
    )
    sizes = {name: int(size, 16) for size, name in listed}
    sections = re.findall(
        r"(?m)^\.(?:ro)?data\S* +(\d+)", run("arm-none-eabi-size", "-A", f"{one.name}.o", cwd=here)
    )
    assert sizes == {"state": written.budget.state_bytes, "image": written.budget.image_bytes}
    assert sum(map(int, sections)) == written.budget.parameter_bytes


# ---- Refusals.


@pytest.mark.parametrize(
    "name",
    ["", "1a", "A", "a__b", "int", "while", "a-b", "dehyst_x", "pi", "block", "a" * 50, "_a"],
)
def test_names_that_would_not_compile_are_refused_with_one_that_would(name):
    with pytest.raises(ParameterError, match="--name"):
        check_name(name)
    check_name(identifier(name))


def test_a_folder_of_somebody_else_is_not_touched(tmp_path):
    mine = tmp_path / "thesis.tex"
    mine.write_text("years of work")
    with pytest.raises(OutputError, match=r"thesis.tex.*--overwrite"):
        export(subject(), "c", tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["thesis.tex"]


def test_an_export_is_replaced_but_not_an_edited_one(tmp_path):
    folder = export(subject(), "c", tmp_path / "out").folder
    export(subject("mapped"), "c-header", folder)
    assert (folder / "unit_1.h").exists()
    assert not (folder / "src").exists()
    (folder / "unit_1.h").write_text("mine")
    with pytest.raises(OutputError, match=r"unit_1\.h"):
        export(subject(), "c", folder)
    export(subject(), "c", folder, overwrite=True)
    assert [path.name for path in tmp_path.iterdir()] == ["out"]


@pytest.mark.parametrize(("place", "words"), [("file", "is a file"), ("no/such", "mkdir -p")])
def test_a_place_that_is_no_folder_is_refused(tmp_path, place, words):
    (tmp_path / "file").write_text("x")
    with pytest.raises(OutputError, match=words):
        export(subject(), "c", tmp_path / place)


def test_an_unknown_target_lists_all_there_are():
    with pytest.raises(ParameterError) as fault:
        export(subject(), "cobol", "nowhere")
    assert all(name in str(fault.value) for name in TARGETS)


def test_a_model_without_ranges_needs_one(tmp_path):
    with pytest.raises(ParameterError, match="range"):
        subject_of(play_model(card=dehyst.models.ModelCard()), name="u")
    subject_of(play_model(card=dehyst.models.ModelCard()), name="u", range=(-1.0, 1.0))


@pytest.mark.slow
def test_thousands_of_operators_can_be_exported(tmp_path):
    needs("make", "cc")
    folder = export(subject_of(large_model(), name="large"), "c", tmp_path / "out").folder
    assert "all checks passed" in run("make", "-s", "check", cwd=folder)


# ---- Files of controllers.


def test_a_controller_file_is_read_back_bit_for_bit(tmp_path):
    parameters = JointControllerParameters(pole=1 / 3, a=(0.1, 0.2))
    assert load_controller(save_controller(parameters, tmp_path / "c.json")) == parameters


@pytest.mark.parametrize(
    "change",
    [
        lambda t: t.replace('"pole": 6.0', '"pole": 7.0'),
        lambda t: t[:-40],
        lambda t: t.replace("dehyst-controller", "other"),
        lambda t: t.replace('"schema": 1', '"schema": 2'),
        lambda t: "[" * 100000,
        lambda t: "",
    ],
)
def test_a_controller_file_that_was_damaged_is_refused(tmp_path, change):
    path = save_controller(JointControllerParameters(), tmp_path / "c.json")
    path.write_text(change(path.read_text()))
    with pytest.raises(ModelFileError, match=r"c\.json"):
        load_controller(path)
