"""A direct inverse without a controller, exported as C: bits of its twin, limits, switching, what is refused."""

import ctypes
import json
import shutil
import subprocess

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dehyst.cli import main
from dehyst.errors import ParameterError
from dehyst.export import export, subject_of, verify
from dehyst.export.c import unit_files
from dehyst.export.core_files import needed
from dehyst.models import BLOCK_FLAGS, Block, DirectInverse, ModelCard, SignalCard
from direct_export_samples import direct_model, random_direct
from export_samples import needs_make

WITH_C = pytest.mark.skipif(not shutil.which("gcc"), reason="gcc is not installed")
PERIOD = 1e-3
CARD = ModelCard(SignalCard("pressure", "bar", -2.0, 2.0), SignalCard("stroke", "mm", -1.0, 1.0))


def compiled(subject, folder):
    """The unit's step as a function of Python, from the sources that are exported."""
    files = {**needed(subject.block.functions), **unit_files(subject)}
    for name, text in files.items():
        (folder / name).write_text(text)
    names = subject.block.given
    real = "float" if subject.real == "float" else "double"
    (folder / "run.c").write_text(
        f'#include "{subject.name}.h"\nstatic {subject.name}_state s;\n'
        f"void reset(void) {{ {subject.name}_reset(&s); }}\n"
        f"uint32_t flags(void) {{ return {subject.name}_flags(&s); }}\n"
        f"double step(const {real} *x, int on) {{ return (double){subject.name}_step(&s"
        + "".join(f", x[{k}]" for k in range(2 + len(names)))
        + ", on); }\n"
    )
    options = [
        "-std=c11",
        "-O2",
        "-ffp-contract=off",
        "-Wall",
        "-Wextra",
        "-Wconversion",
        "-Wpedantic",
        "-Werror",
    ]
    sources = sorted(folder.glob("*.c"))
    subprocess.run(
        ["gcc", *options, "-shared", "-fPIC", "-I", folder, *sources, "-o", folder / "u.so"],
        check=True,
    )
    library = ctypes.CDLL(str(folder / "u.so"))
    library.step.restype, library.flags.restype = ctypes.c_double, ctypes.c_uint32
    number = ctypes.c_float if real == "float" else ctypes.c_double

    def run(inputs, on):
        library.reset()
        rows = []
        for row, switch in zip(inputs, on, strict=True):
            rows.append((library.step((number * len(row))(*row), int(switch)), library.flags()))
        return np.array([row[0] for row in rows]), np.array([row[1] for row in rows])

    return run


def motion(model, rng, samples=400, hostile=True):
    """Random loops beyond the range, rates, scheduling variables, and patterns of bits of any kind."""
    columns = [0.5 * np.sin(np.cumsum(rng.uniform(-0.2, 0.4, samples))) * rng.uniform(0.3, 1.5)]
    columns.append(rng.normal(0, 1, samples))
    columns += [rng.uniform(s.low - 1, s.high + 1, samples) for s in model.outside]
    inputs = np.column_stack(columns)
    if hostile:
        places = rng.random(inputs.shape) < 0.02
        inputs[places] = np.frombuffer(rng.bytes(8 * int(places.sum())), np.float64)
    return inputs, (rng.random(samples) < 0.05).cumsum() % 2 == 0


def of_the_twin(block, inputs, on):
    block.reset()
    return block.answer(inputs, on)


@WITH_C
@pytest.mark.parametrize("seed", range(6))
def test_compiled_sources_have_the_bits_of_the_twin(seed, tmp_path):
    rng = np.random.default_rng(seed)
    model, ramp = random_direct(rng), int(rng.integers(1, 60))
    subject = subject_of(model, name="unit_under_test", period=PERIOD, ramp=ramp)
    inputs, on = motion(model, rng)
    u, flags = compiled(subject, tmp_path)(inputs, on)
    expected = of_the_twin(Block(model, period=PERIOD, ramp=ramp), inputs, on)
    assert u.tobytes() == expected[0].tobytes()
    assert np.array_equal(flags, expected[1]) and (flags & BLOCK_FLAGS["rejected"]).any()


@WITH_C
@pytest.mark.parametrize("past", ["unknown", "rest", "rising", "falling"])
def test_block_stepper_compensate_and_compiled_sources_begin_alike_to_the_bit(past, tmp_path):
    model = direct_model(past=past, schedules=0)
    y = 0.3 * np.sin(np.arange(50) / 5.0 + 1.0)
    # What the block is told is the rate that is taken from the samples.
    rate = np.gradient(y, PERIOD)
    rate[[0, -1]] = np.diff(y)[[0, -1]] / PERIOD
    inputs, on = np.column_stack([y, rate]), np.ones(50, bool)
    u, _ = of_the_twin(Block(model, period=PERIOD), inputs, on)
    compiled_u, _ = compiled(subject_of(model, name="unit", period=PERIOD), tmp_path)(inputs, on)
    assert compiled_u.tobytes() == u.tobytes()
    core = model.core_stepper(PERIOD)
    assert [core(*row) for row in inputs] == u.tolist()
    time = PERIOD * np.arange(50)
    np.testing.assert_allclose(model.inverse().simulate(y, time), u, atol=1e-9)
    assert model.inverse().stepper(PERIOD)(y[0]) == model.core_stepper(PERIOD)(y[0], 0.0)


@WITH_C
@pytest.mark.parametrize("seed", range(3))
def test_in_float_answers_are_within_a_hundred_thousandth_of_the_range(seed, tmp_path):
    rng = np.random.default_rng(seed)
    model = direct_model(seed, schedules=1 + seed % 2)
    subject = subject_of(model, name="unit_under_test", period=PERIOD, real="float", ramp=20)
    inputs, on = motion(model, rng, hostile=False)
    inputs = inputs.astype(np.float32).astype(np.float64)
    u, _ = compiled(subject, tmp_path)(inputs, on)
    expected, _ = of_the_twin(Block(model, period=PERIOD, ramp=20), inputs, on)
    assert np.abs(u - expected).max() <= 1e-5 * 120.0


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_no_input_leads_out_of_the_range_and_a_rejected_sample_holds(seed):
    rng = np.random.default_rng(seed)
    model = random_direct(rng)
    block = Block(model, period=PERIOD, range=(-7.0, 11.0), ramp=int(rng.integers(1, 20)))
    inputs = (
        np.frombuffer(rng.bytes(8 * 60 * (1 + len(block.given))), np.float64).reshape(60, -1).copy()
    )
    calm, on = motion(model, rng, 60)
    inputs = np.where(rng.random((60, 1)) < 0.5, inputs, calm)
    u, flags = of_the_twin(block, inputs, on)
    assert ((u >= -7.0) & (u <= 11.0)).all()
    rejected = (flags & BLOCK_FLAGS["rejected"]) != 0
    assert np.array_equal(rejected, ~(np.isfinite(inputs) & (np.abs(inputs) <= 1e100)).all(axis=1))
    held = np.flatnonzero(rejected[1:]) + 1
    assert np.array_equal(u[held], u[held - 1])


@pytest.mark.parametrize("seed", range(4))
def test_while_on_it_is_the_direct_inverse_begun_at_rest_at_the_first_good_sample(seed):
    rng = np.random.default_rng(seed)
    model = random_direct(rng)
    inputs, _ = motion(model, rng, hostile=False)
    inputs[0, 0] = np.nan
    block = Block(model, period=PERIOD, range=(-1e6, 1e6))
    u, _ = of_the_twin(block, inputs, np.ones(len(inputs), bool))
    step = model.core_stepper(PERIOD)
    step.reset(inputs[1, 0])
    plain = np.array([step(*row) for row in inputs[1:]])
    inside = np.abs(plain) < 180  # the stepper's own limit
    assert inside.any() and np.array_equal(u[1:][inside], plain[inside])


def test_switching_has_no_bump_and_ends_at_the_line_and_at_the_inverse():
    model = DirectInverse(radii=[0.5], stop_weights=[2.0], polynomial=[0.0, 1.0], card=CARD)
    block = Block(model, period=PERIOD, ramp=10)
    on = np.repeat([True, False, True], 30)
    u, _ = block.run(np.full(90, 0.4), on=on)
    assert np.abs(np.diff(u)).max() <= abs(u[29] - u[59]) / 10 + 1e-12
    block.reset()
    moved, _ = block.run(np.concatenate(([0.0], np.full(89, 0.4))), on=on)
    assert moved[20] == moved[-1] == pytest.approx(1.2) and moved[50] == pytest.approx(0.4)
    assert np.abs(np.diff(moved[1:])).max() <= 0.8 / 10 + 1e-12


@pytest.mark.slow
@needs_make
@pytest.mark.parametrize("target", ["c", "c-header"])
@pytest.mark.parametrize("real", ["double", "float"])
def test_an_export_is_verified_and_an_edited_one_is_not(target, real, tmp_path):
    subject = subject_of(direct_model(schedules=3), name="valve", period=PERIOD, real=real)
    export(subject, target, tmp_path / "out")
    checks = verify(tmp_path / "out")
    assert {check.status for check in checks} == {"passed"} and any(check.ran for check in checks)
    manifest = json.loads((tmp_path / "out" / "manifest.json").read_text())
    manifest["settings"]["period"] = 0.002
    (tmp_path / "out" / "manifest.json").write_text(json.dumps(manifest))
    assert "failed" in {check.status for check in verify(tmp_path / "out")}


@pytest.mark.slow
@needs_make
@pytest.mark.parametrize(
    "model",
    [
        direct_model(schedules=3),
        direct_model(stops=2, paths=0, creeps=0, past="rest"),
        direct_model(schedules=0, past="rising"),
        direct_model(schedules=0, past="falling"),
    ],
)
@pytest.mark.parametrize(
    ("target", "real"),
    [("st", "double"), ("st", "float"), ("fmu2", "float"), ("fmu3", "double"), ("simulink", "double"),
     ("arduino", "float")],
)  # fmt: skip
@pytest.mark.usefixtures("one_compiler")
def test_every_target_holds_it_and_answers_with_its_bits(target, real, model, tmp_path):
    subject = subject_of(model, name="valve", period=PERIOD, real=real, ramp=40, follow_offset=0.1)
    export(subject, target, tmp_path / "out")
    checks = [check for check in verify(tmp_path / "out") if "MATLAB" not in check.claim]
    assert {check.status for check in checks} <= {"passed", "skipped"}
    assert any(check.ran or target == "st" for check in checks)


@pytest.mark.slow
@needs_make
def test_a_wrong_answer_fails_the_generated_check(tmp_path):
    export(subject_of(direct_model(), name="valve", period=PERIOD), "c", tmp_path / "out")
    path = tmp_path / "out" / "check" / "expected.h"
    text = path.read_text()
    place = text.rindex(", 1, ")
    digit = place - 12  # a last one would be rounding
    path.write_text(text[:digit] + ("0" if text[digit] != "0" else "1") + text[digit + 1 :])
    run = subprocess.run(
        ["make", "-s", "-C", tmp_path / "out", "check"], capture_output=True, text=True, check=False
    )
    assert run.returncode != 0 and "FAILED" in run.stdout


@WITH_C
@pytest.mark.parametrize("compiler", ["gcc", "g++", "clang", "clang++"])
@pytest.mark.parametrize("real", ["double", "float"])
def test_sources_are_clean_under_strict_warnings_as_c_and_as_cpp(compiler, real, tmp_path):
    if not shutil.which(compiler):
        pytest.skip(f"{compiler} is not installed")
    subject = subject_of(direct_model(), name="valve", period=PERIOD, real=real)
    for name, text in {**needed(subject.block.functions), **unit_files(subject)}.items():
        (tmp_path / name).write_text(text)
    language = ["-x", "c++", "-std=c++17"] if "++" in compiler else ["-std=c11"]
    options = [
        "-Wall",
        "-Wextra",
        "-Wconversion",
        "-Wpedantic",
        "-Werror",
        "-fsyntax-only",
        "-I",
        tmp_path,
    ]
    files = [tmp_path / "valve.c", tmp_path / "direct_block.c"]
    subprocess.run([compiler, *language, *options, *files], check=True)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"period": 0.0}, "period"),
        ({"period": float("nan")}, "period"),
        ({"ramp": 0}, "ramp"),
        ({"range": (1.0, 1.0)}, "--range LO HI"),
        ({"ramp": 10**8, "real": "float"}, "--real double"),
        ({"real": "half"}, "--real"),
    ],
)
def test_settings_that_make_no_sense_are_refused(changes, words):
    with pytest.raises(ParameterError, match=words):
        subject_of(direct_model(), **{"name": "valve", "period": PERIOD, **changes})


def test_a_model_without_ranges_and_a_missing_scheduling_variable_are_refused():
    plain = DirectInverse(radii=[0.5], stop_weights=[2.0])
    with pytest.raises(ParameterError, match="no limits"):
        Block(plain, period=PERIOD)
    with pytest.raises(ParameterError, match="mean_pressure"):
        Block(direct_model(), period=PERIOD).step(0.0)


@pytest.fixture
def model_file(tmp_path):
    return DirectInverse(
        radii=[0.5],
        stop_weights=[1.0],
        time_constants=[0.5],
        creep_weights=[0.5],
        polynomial=[0.0, 1.0],
        card=CARD,
    ).save(tmp_path / "di.json")


def told(capsys, *words):
    """Exit status and what is written to the errors."""
    from unittest.mock import patch

    with patch("sys.argv", ["dehyst", *map(str, words)]):
        try:
            main()
            status = 0
        except SystemExit as end:
            status = end.code or 0
    return status, "".join(capsys.readouterr())


def test_the_command_line_writes_it_and_says_what_a_step_takes(model_file, tmp_path, capsys):
    out = tmp_path / "valve"
    status, text = told(
        capsys,
        "export",
        model_file,
        "--target",
        "c",
        "--period",
        "0.001",
        "--name",
        "valve",
        "--out",
        out,
    )
    assert status == 0, text
    assert "a step takes y, rate, on, every 0.001 s" in text and "2 stops and lags" in text
    assert (
        "dehyst_real valve_step(valve_state *self, dehyst_real y, dehyst_real rate, int on);"
        in (out / "src" / "valve.h").read_text()
    )


@pytest.mark.parametrize(
    ("words", "cure"),
    [
        (("--target", "c"), "--period 0.001"),
        (("--target", "st"), "--period 0.001"),
        (("--target", "c", "--period", "-1"), "above 0"),
        (("--target", "c", "--period", "0.001", "--what", "forward"), "--what forward"),
        (("--target", "c", "--period", "0.001", "--log", "x.csv", "--column", "y"), "--log"),
    ],
)
def test_what_cannot_be_exported_is_refused_with_what_to_type(
    words, cure, model_file, tmp_path, capsys
):
    status, text = told(capsys, "export", model_file, *words, "--out", tmp_path / "out")
    assert status == 2 and cure in " ".join(text.split()), text
    assert not (tmp_path / "out").exists()


def test_the_help_says_what_takes_no_log(run):
    _, out, _ = run("export", "--help")
    words = " ".join(out.split())
    assert (
        "an excerpt becomes part of the check; of a model or its inverse, which take one column."
        in words
    )
