"""The core's step in O(log n): the same outputs as the definition, and a cost with a bound."""

import platform
import re
import shutil
import subprocess
import sys
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dehyst import (
    ModifiedPrandtlIshlinskii,
    MonotoneMap,
    PrandtlIshlinskii,
    StopOperatorModel,
    _native,
)
from dehyst.models import StaticCurve
from oracles import exact, random_thresholds, random_walk, random_weights
from places import KERNEL, ROOT, SUPPORT

sys.path.insert(0, str(ROOT / "benchmarks"))

import step as benchmark

CORE = sorted((KERNEL / "core").glob("*.c"))
KINDS = ("positive", "negative", "paper", "mixed")


def outputs(step, x):
    return np.array([step(v) for v in np.asarray(x).tolist()])


def both(model, x):
    """Return the outputs of the dense and of the logarithmic step."""
    return outputs(model.stepper("dense"), x), outputs(model.stepper("logarithmic"), x)


def relative(y, want):
    return float(np.max(np.abs(y - want)) / np.max(np.abs(want)))


def exact_by_slopes(x, thresholds, weights, state):
    """Return sum_i S_i (z_i - z_{i+1}) + S_n z_n as rationals; the S_i are the sums that the core forms."""
    slopes, r, z = exact(np.cumsum(weights)), exact(thresholds), exact(state)
    out = []
    for s in exact(x):
        z = [max(s - a, min(s + a, b)) for a, b in zip(r, z, strict=True)]
        below = [*z[1:], Fraction(0)]
        out.append(sum(slope * (a - b) for slope, a, b in zip(slopes, z, below, strict=True)))
    return out


def shrinking(n, around=0.0, by=1):
    """Return an oscillation that shrinks by one threshold i/n a half swing, so that the stack grows to n segments."""
    size = np.arange(n, 0, -by) / n * (1 + 1e-9)
    return np.concatenate(
        [[around + 1.0], around + size * np.where(np.arange(size.size) % 2, 1.0, -1.0)]
    )


def long_double(x, thresholds, weights, every):
    """Return outputs at every so many samples by the definition in extended precision, from the state zero."""
    r, slopes = thresholds.astype(np.longdouble), np.cumsum(weights).astype(np.longdouble)
    z, out = np.zeros(r.size, np.longdouble), []
    for k, s in enumerate(x.astype(np.longdouble)):
        z = np.maximum(s - r, np.minimum(s + r, z))
        if k % every == 0:
            out.append(np.sum(slopes * (z - np.append(z[1:], 0))))
    return np.array(out)


@pytest.fixture(scope="module", params=["double", "float"])
def differential(request, tmp_path_factory):
    compiler = next((name for name in ("gcc", "clang", "cc") if shutil.which(name)), None)
    if compiler is None:
        pytest.skip("there is no C compiler")
    program = tmp_path_factory.mktemp("stack") / request.param
    flags = [
        "-O3",
        "-std=c11",
        "-ffp-contract=off",
        "-Wall",
        "-Wextra",
        "-Wconversion",
        "-Wpedantic",
        "-Werror",
    ]
    flags += ["-DDEHYST_FLOAT"] if request.param == "float" else []
    sources = [SUPPORT / "stack_differential.c", *CORE]
    subprocess.run(
        [compiler, *flags, f"-I{KERNEL / 'core'}", *map(str, sources), "-o", str(program)],
        check=True,
    )
    return request.param, program


@pytest.mark.slow
def test_two_hundred_thousand_random_models_step_as_the_dense_step_does(differential):
    precision, program = differential
    done = subprocess.run(
        [program, "200000", "40", "1"], capture_output=True, text=True, timeout=600
    )
    assert done.returncode == 0, "the stack left its memory"
    error, play_error = map(float, done.stdout.split())
    unit = 2.0**-53 if precision == "double" else 2.0**-24
    assert error <= 90 * unit  # 1e-14
    assert play_error <= 90 * unit


@pytest.mark.slow
@settings(max_examples=200, deadline=None)
@given(
    st.lists(st.integers(1, 3), min_size=1, max_size=12),
    st.integers(0, 2),
    st.lists(st.integers(-25, 25), min_size=1, max_size=60),
    st.data(),
)
def test_on_a_grid_of_integers_it_is_exact(gaps, first, x, data):
    r = np.cumsum([first, *gaps]).astype(float)
    w = np.array(data.draw(st.lists(st.integers(-4, 4), min_size=r.size, max_size=r.size)), float)
    z = [float(data.draw(st.integers(-9, 9)))]
    for gap in reversed(gaps):
        z.insert(0, z[0] + data.draw(st.integers(-gap, gap)))
    model = PrandtlIshlinskii(r, w, state=z)
    dense, fast = model.stepper("dense"), model.stepper("logarithmic")
    assert fast.output == dense.output
    for v in x:
        assert fast(v) == dense(v)
        assert np.array_equal(fast.state, dense.state)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("inverted", [False, True], ids=["model", "inverse"])
def test_outputs_are_those_of_exact_arithmetic_also_where_dense_sums_lose_digits(kind, inverted):
    rng = np.random.default_rng(KINDS.index(kind))
    for n in (1, 2, 3, 7, 14, 40):
        model = PrandtlIshlinskii(random_thresholds(rng, n), random_weights(rng, n, kind))
        model = model.with_state(model.final_state(random_walk(rng, 60)))
        x = random_walk(rng, 100)
        if inverted:  # w_1 = 1000 for "paper"
            model, x = model.inverse(), model.simulate(x)
        want = exact_by_slopes(x, model.thresholds, model.weights, model.stepper().state)
        got = exact(outputs(model.stepper("logarithmic"), x))
        assert max(abs(a - b) for a, b in zip(got, want, strict=True)) <= Fraction(2e-15) * max(
            map(abs, want)
        )


@pytest.mark.parametrize("n", [1000, 10000])
@pytest.mark.parametrize("kind", ["positive", "mixed"])
def test_thousands_of_operators_agree_with_the_dense_step(n, kind):
    rng = np.random.default_rng(n)
    model = PrandtlIshlinskii(random_thresholds(rng, n), random_weights(rng, n, kind))
    signals = {
        "walk": random_walk(rng, 1000),
        "white": rng.uniform(-1, 1, 1000),
        "wiped": np.concatenate(
            [shrinking(n, by=n // 500), [1.1], shrinking(n, by=n // 200), [-1.1, 0.2]]
        ),
    }
    for name, x in signals.items():
        dense, fast = both(model, x)
        assert relative(fast, dense) <= 1e-14, name


@pytest.mark.slow
@pytest.mark.skipif(np.finfo(np.longdouble).nmant < 63, reason="no extended precision here")
@pytest.mark.parametrize(("around", "by"), [(0.0, 1), (0.8, 1), (3.0, 2)])
def test_errors_do_not_add_up_over_thousands_of_segments(around, by):
    n = 4000
    model = PrandtlIshlinskii(
        np.arange(n) / n, random_weights(np.random.default_rng(1), n, "mixed")
    )
    x, every = shrinking(n, around, by), 61
    want = long_double(x, model.thresholds, model.weights, every)
    step = model.stepper("logarithmic")
    assert relative(outputs(step, x)[::every], want) <= 5e-15
    assert step.save().size > 2 * n // by  # so many segments there were


@pytest.mark.parametrize(("n", "most"), [(1000, 1e-14), (10000, 3e-14)])
def test_model_after_inverse_gives_the_reference_back(n, most):
    rng = np.random.default_rng(2)
    model = PrandtlIshlinskii(
        np.arange(n) / n, np.concatenate([[0.5], rng.uniform(0, 3 / n, n - 1)])
    )
    x = np.concatenate([random_walk(rng, 2000), rng.uniform(-1, 1, 500)])
    y = outputs(model.stepper("logarithmic"), x)
    assert relative(outputs(model.inverse().stepper("logarithmic"), y), x) <= most


def test_a_first_threshold_above_zero_is_a_dead_zone():
    model = PrandtlIshlinskii(
        [0.3, 0.5, 1.0], [1.0, -0.25, 2.0], offset=0.5, state=[0.1, 0.2, 0.0], center=0.1
    )
    x = random_walk(np.random.default_rng(3), 400, amplitude=1.6)
    dense, fast = both(model, x)
    assert relative(fast, dense) <= 1e-15
    step = model.stepper("logarithmic")
    assert [step(v) for v in (0.1, 0.3, -0.1)] == [
        step.output
    ] * 3  # within the dead zone around z_1
    assert step.state.shape == (3,)


@pytest.mark.parametrize("falling", [False, True])
def test_maps_before_and_after_are_those_of_the_dense_step(falling):
    rng = np.random.default_rng(4)
    bend = MonotoneMap([-2.0, 0.0, 2.0], [3.0, 0.0, -1.0] if falling else [-1.0, 0.0, 3.0])
    inner = PrandtlIshlinskii(
        random_thresholds(rng, 30), random_weights(rng, 30, "mixed"), 0.25, None, 0.1
    )
    x = random_walk(rng, 500, amplitude=2.0)
    models = [
        ModifiedPrandtlIshlinskii(inner, before_map=bend, after_map=bend),
        ModifiedPrandtlIshlinskii(inner, after_map=bend).inverse(),
        StopOperatorModel([0.0, 0.3, 0.6], [0.0, 1.0, 0.5], 0.5),
        StaticCurve(bend),
    ]
    for model in models:
        dense, fast = both(model, x)
        assert relative(fast, dense) <= 3e-15


def test_a_map_that_makes_infinity_of_a_good_sample_rejects_it():
    steep = MonotoneMap([0.0, 1e-300, 1.0], [0.0, 1.0, 2.0])
    huge = MonotoneMap([-1.0, 0.0, 1e-300], [-2.0, -1.0, 1e90])
    model = ModifiedPrandtlIshlinskii(PrandtlIshlinskii([0.0, 0.5], [1.0, 1.0]), before_map=huge)
    step = model.stepper("logarithmic")
    before = step(-0.5)
    assert step(1.0) == before
    assert step.rejected
    assert np.isfinite(step(-0.25))
    assert not step.rejected
    assert (
        ModifiedPrandtlIshlinskii(model.hysteresis, before_map=steep).stepper("logarithmic")(0.5)
        == 2.5
    )


def test_noise_below_the_first_threshold_makes_no_segments():
    model = PrandtlIshlinskii(np.arange(100) / 100, np.full(100, 0.01))
    step = model.stepper("logarithmic")
    for v in (1.0, 0.0):
        step(v)
    size = step.save().size
    for v in np.random.default_rng(5).uniform(-0.004, 0.004, 1000).tolist():
        step(v)
    assert step.save().size <= size + 2


def test_events_on_the_edge_of_the_window_are_taken_once_and_for_all():
    # Window and searches round differently: a sample that is handed back to the window would come again for ever.
    rng = np.random.default_rng(6)
    r = np.cumsum(rng.uniform(0.01, 0.1, 20)) - 0.01
    model = PrandtlIshlinskii(r - r[0], rng.uniform(0, 1, 20))
    x = [0.0]
    for _ in range(3000):
        edge = x[-1] + rng.choice([-2.0, 2.0]) * model.thresholds[rng.integers(20)]
        x.append(
            float(np.nextafter(edge, rng.choice([-np.inf, edge, np.inf]))) if abs(edge) < 2 else 0.0
        )
    dense, fast = both(model, x)
    assert relative(fast, dense) <= 2e-15


needs_callgrind = pytest.mark.skipif(
    shutil.which("valgrind") is None
    or shutil.which("gcc") is None
    or platform.machine() != "x86_64",
    reason="instructions are counted with valgrind for gcc's code on x86-64",
)


@pytest.fixture(scope="module")
def program(tmp_path_factory):
    return benchmark.build(tmp_path_factory.mktemp("step"), "gcc")


@pytest.mark.slow
@needs_callgrind
@pytest.mark.parametrize("n", [100, 1000])
@pytest.mark.parametrize("signal", ["noisy", "white", "wiped", "torn"])
def test_no_step_takes_more_than_300_instructions(program, n, signal):
    found = benchmark.instructions(program, "logarithmic", n, signal, 2 * n + 500)
    assert found["most"] <= benchmark.INSTRUCTIONS
    assert found["mean"] > 100  # it was the step that was counted


@pytest.mark.slow
@needs_callgrind
def test_ten_times_the_operators_cost_a_few_rounds_of_bisection(program):
    cost = {
        n: benchmark.instructions(program, "logarithmic", n, "torn", 2 * n)["most"]
        for n in (100, 1000)
    }
    dense = benchmark.instructions(program, "dense", 1000, "sine", 50)["mean"]
    assert cost[1000] <= cost[100] + 60
    assert dense > 15 * cost[1000]


def test_the_benchmark_can_miss_its_limits():
    row = {"method": "logarithmic", "n": 10000, "signal": "white", "worst": 199.0}
    assert not benchmark.missed([row, {**row, "method": "dense", "worst": 9000.0}])
    assert "white: worst step 201 ns" in benchmark.missed([{**row, "worst": 201.0}])[0]
    assert "301 instructions" in benchmark.missed([{**row, "n": 1000, "most": 301}])[0]


def test_the_header_says_what_every_field_of_the_stack_is():
    text = (KERNEL / "core" / "dehyst.h").read_text(encoding="utf-8")
    for body in re.findall(r"typedef struct dehyst_stack_\w+ \{(.*?)\n\}", text, re.DOTALL):
        fields = [line for line in body.splitlines() if line.strip()]
        assert len(fields) > 4
        assert all("/*" in line and line.rstrip().endswith("*/") for line in fields)
    assert _native.StackStepper.__name__ == "StackStepper"
