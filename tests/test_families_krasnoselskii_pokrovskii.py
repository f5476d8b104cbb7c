"""Krasnosel'skii-Pokrovskii operator: its kernels, its neighbours Preisach and PI, inverse and identification."""

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import dehyst
from dehyst import PrandtlIshlinskii, Recording
from dehyst.errors import InvertibilityError, ParameterError
from dehyst.families import STARTS, example, identify_family
from dehyst.families.krasnoselskii_pokrovskii import KrasnoselskiiPokrovskii
from dehyst.families.preisach import Preisach

DATA = Path(__file__).parents[1].parent / "shared" / "data"
MODEL = KrasnoselskiiPokrovskii.example()
signals = st.lists(st.floats(-1.3, 1.3), min_size=2, max_size=40).map(np.array)
seeds = st.integers(0, 10**6)


def by_definition(model, x, states):
    """Outputs and states, kernel by kernel as the equation has it."""
    i, j = np.tril_indices(model.lines.size)
    z, outputs = np.array(states), []
    span = model.lines[-1] + model.ridge - model.lines[0]
    for value in x:
        r = np.clip(2.0 * (value - model.lines) / model.ridge - 1.0, -1.0, 1.0)
        z = np.maximum(r[i], np.minimum(r[j], z))
        over = value - np.clip(value, model.lines[0], model.lines[-1] + model.ridge)
        outputs.append(model.offset + model.weights @ z + 2.0 * np.sum(model.weights) / span * over)
    return np.array(outputs), z


def random_model(seed):
    """Random lines, ridge and weights; the ridges leave no gap."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 9))
    lines = np.sort(rng.uniform(-1.0, 0.6, n)) + 0.01 * np.arange(n)
    ridge = max([0.2, *np.diff(lines)]) * float(rng.uniform(1.0, 3.0))
    weights = rng.exponential(size=n * (n + 1) // 2) * (rng.random(n * (n + 1) // 2) > 0.25)
    i, j = np.tril_indices(n)
    weights[i == j] += 0.02
    return KrasnoselskiiPokrovskii(lines, ridge, weights, float(rng.normal()))


def rich(seed, samples=3000):
    """Sweeps between random ends, some of them large."""
    rng = np.random.default_rng(seed)
    ends = rng.uniform(-1.0, 1.0, samples // 50) * rng.choice([1.0, 0.5], samples // 50)
    ends[:4] = 0.0, 1.0, -1.0, 1.0
    return np.interp(np.arange(samples), np.linspace(0, samples, ends.size), ends)


@given(seeds, signals)
@settings(max_examples=60, deadline=None)
def test_it_does_what_its_equation_says(seed, x):
    model = random_model(seed)
    found, states = model.run(x, None, model.rest(0.2))
    wanted, z = by_definition(model, x, model.rest(0.2))
    size = np.sum(model.weights) + abs(model.offset)
    np.testing.assert_allclose(found, wanted, atol=1e-13 * size)
    np.testing.assert_allclose(states, z, atol=1e-14)


@given(seeds, signals)
@settings(max_examples=40, deadline=None)
def test_with_a_steep_ridge_it_is_a_sum_of_relays(seed, x):
    smooth = random_model(seed)
    steep = KrasnoselskiiPokrovskii(smooth.lines, 1e-9, smooth.weights)
    off = np.clip(x, -1.0, 0.95)
    off = off[np.min(np.abs(off[:, None] - steep.lines), axis=1) > 1e-6]  # not on a ridge
    i, j = np.tril_indices(steep.lines.size)
    state, relays = -np.ones(i.size), []
    for value in off:
        state[value >= steep.lines[i]], state[value <= steep.lines[j]] = 1.0, -1.0
        relays.append(steep.weights @ state)
    found = steep.run(off, None, -np.ones(i.size))[0]
    inside = (off > steep.lines[0]) & (off < steep.lines[-1])
    np.testing.assert_allclose(found[inside], np.array(relays)[inside], atol=1e-12 * np.sum(steep.weights))


def test_on_a_fine_grid_it_comes_close_to_the_preisach_operator():
    x = np.concatenate([[-1.0], rich(2, 1000)])
    errors = []
    for n in (10, 40):
        place = -1.0 + 2.0 / n * (np.arange(n) + 0.5)
        i, j = np.tril_indices(n)
        masses = np.exp(-4 * (place[i] + place[j]) ** 2 - 3 * (place[i] - place[j] - 0.4) ** 2)
        masses /= masses.sum()
        preisach = Preisach.from_masses(np.linspace(-1, 1, n + 1), masses)
        kernels = KrasnoselskiiPokrovskii(np.linspace(-1, 1, n + 1)[:-1], 2.0 / n, masses)
        y = preisach.run(x, None, preisach.saturated())[0]
        errors.append(np.abs(kernels.run(x, None, -np.ones(masses.size))[0] - y).max())
    assert errors[1] < 0.01 and errors[1] < 0.2 * errors[0]


@given(seeds, signals)
@settings(max_examples=40, deadline=None)
def test_with_weights_that_depend_on_i_minus_j_only_it_is_a_prandtl_ishlinskii_operator(seed, x):
    weights = np.random.default_rng(seed).uniform(0, 1, 10)
    i, j = np.tril_indices(10)
    model = KrasnoselskiiPokrovskii(np.linspace(-1, 1, 11)[:-1], 0.2, 0.1 * weights[i - j])
    pi = PrandtlIshlinskii(np.arange(10) * 0.1, weights)
    inside = np.clip(x, -1, 1)  # everywhere, not only on a grid; from the same demagnetised state
    expected = pi.simulate(np.concatenate([[0.0], inside]))[1:]
    np.testing.assert_allclose(model.run(inside, None, model.rest(0.0))[0], expected, atol=1e-12)


@given(seeds, signals, signals)
@settings(max_examples=40, deadline=None)
def test_a_passed_turn_is_wiped_out(seed, x, inner):
    model = random_model(seed)
    low, high = sorted((x[-1], x[-2]))
    detour = np.concatenate([x, np.clip(inner, low, high), [x[-2]], [x[-1]]])
    straight = np.concatenate([x, [x[-2]], [x[-1]]])
    with_it, without = (model.run(s, None, model.rest(0.0))[1] for s in (detour, straight))
    assert np.array_equal(with_it, without)


def test_minor_loops_between_the_same_inputs_are_congruent():
    loop = np.concatenate([np.linspace(-0.2, 0.4, 31), np.linspace(0.4, -0.2, 31)])
    shapes, levels = [], []
    for past in ([-1, -0.2], [1, -0.2], [-1, 0.9, -0.8, 0.6, -0.2]):
        memory = MODEL.run(np.array(past, dtype=float), None, MODEL.rest(0.0))[1]
        y = MODEL.run(np.tile(loop, 3), None, memory)[0][31:]
        assert np.allclose(y[:62], y[62:124], atol=1e-14)
        shapes.append(y[:62] - y[0])
        levels.append(y[0])
    assert np.ptp(levels) > 0.1
    np.testing.assert_allclose(shapes[1:], [shapes[0]] * 2, atol=1e-14)


@given(seeds, signals, st.integers(2, 5))
@settings(max_examples=40, deadline=None)
def test_only_the_order_of_turns_matters_not_how_fast(seed, x, times):
    model = random_model(seed)
    dense = np.concatenate([np.linspace(a, b, times + 1)[1:] for a, b in pairwise(x)])
    slow = model.simulate(np.concatenate([x[:1], dense]))[::times]
    np.testing.assert_allclose(slow, model.simulate(x), atol=1e-12 * (1.0 + np.sum(model.weights)))


def test_a_decaying_sweep_leaves_the_state_of_rest_whatever_was_before():
    sweep = 1.2 * 0.99 ** np.arange(900) * (-1.0) ** np.arange(900)
    ends = [MODEL.run(np.concatenate([past, sweep]), None, MODEL.rest(0.9))[1] for past in ([-1.0], [1.0, 0.4, 0.7])]
    assert np.array_equal(*ends)
    np.testing.assert_allclose(ends[0], MODEL.rest(0.0), atol=0.1)  # of -1..1, a sweep of steps of 1 %
    x = rich(3, 500)
    assert np.abs(MODEL.run(x, None, ends[0])[0] - MODEL.with_start("zero").simulate(x)).max() < 0.01


@pytest.mark.parametrize("start", STARTS)
def test_running_in_two_parts_is_running_once_to_the_bit(start):
    x = 1.1 * rich(5, 600)
    begun = MODEL.with_start(start).before(float(x[0]))
    once, end = MODEL.run(x, None, begun)
    first, memory = MODEL.run(x[:217], None, begun)
    second, last = MODEL.run(x[217:], None, memory)
    assert np.array_equal(once, np.concatenate([first, second])) and np.array_equal(end, last)


@given(seeds, signals, st.sampled_from(STARTS))
@settings(max_examples=100, deadline=None)
def test_the_inverse_undoes_it(seed, x, start):
    model = random_model(seed).with_start(start)
    again = model.inverse().simulate(model.simulate(x))
    np.testing.assert_allclose(again, x, atol=1e-10)


def test_ridges_with_a_gap_have_no_inverse():
    with pytest.raises(InvertibilityError, match="without gaps"):
        KrasnoselskiiPokrovskii(np.array([-1.0, 0.5]), 0.5, np.ones(3)).inverse()
    KrasnoselskiiPokrovskii(np.array([-1.0, 0.0]), 1.0, np.ones(3)).inverse()


def test_weights_of_both_signs_have_an_inverse_if_the_reversible_ones_outweigh():
    i, j = np.tril_indices(10)
    x = rich(7, 500)
    for wide in (1, 2):
        apart = 2.0 / (9 + wide)
        light, heavy = (
            KrasnoselskiiPokrovskii(
                -1.0 + apart * np.arange(10), wide * apart, np.where(i == j, 1.0, -negative)
            ) for negative in (0.1, 0.3)
        )  # fmt: skip
        np.testing.assert_allclose(light.inverse().simulate(light.simulate(x)), x, atol=1e-10)
        with pytest.raises(InvertibilityError, match="outweigh"):
            heavy.inverse()


def test_parameters_that_do_not_belong_together_are_refused():
    with pytest.raises(ParameterError, match="2 lines with 2 weights"):
        KrasnoselskiiPokrovskii(np.array([-1.0, 0.0]), 1.0, np.ones(2))
    with pytest.raises(ParameterError, match="increasing"):
        KrasnoselskiiPokrovskii(np.array([0.0, -1.0]), 1.0, np.ones(3))
    with pytest.raises(ParameterError, match="positive"):
        KrasnoselskiiPokrovskii(np.array([-1.0, 0.0]), 0.0, np.ones(3))


def test_known_weights_are_found_again():
    apart = 0.2
    lines = -1.0 + apart * np.arange(10)
    i, j = np.tril_indices(10)
    weights = np.exp(-((lines[i] + lines[j] + 0.2) ** 2) - 3 * (lines[i] - lines[j] - 0.4) ** 2) + 0.5 * (i == j)
    truth = KrasnoselskiiPokrovskii(lines, apart, weights / weights.sum()).with_start("zero")
    x = rich(11, 6000)
    fit = identify_family(Recording(input=x, output=truth.simulate(x)), "krasnoselskii-pokrovskii")
    assert fit.test.rmse_percent < 0.05
    assert fit.model.start == "zero" and fit.inverse_percent < 0.5
    if fit.model.lines.size == 10:
        scaled = fit.model.weights * fit.model.scaling.amplitude
        np.testing.assert_allclose(scaled, truth.weights, atol=0.2 * truth.weights.max())


def test_the_example_is_in_the_registry():
    assert isinstance(example("krasnoselskii-pokrovskii"), KrasnoselskiiPokrovskii)


@pytest.mark.skipif(not (DATA / "piezo_dbo" / "data.csv.gz").is_file(), reason="no measured logs")
@pytest.mark.parametrize(
    ("log", "window", "better"),
    [
        (("piezo_dbo", "voltage_v", "displacement_um"), {"run": "model", "start": 2}, True),
        (("cavatappi_muscle", "pressure_psi", "displacement_mm"), {"run": "300g_s3_t1"}, True),
        (("pneumatic_arm_segment", "pressure_interp_psi", "tilt_rad"), {"run": "oct28_exp5", "start": 12}, False),
    ],
    ids=["piezo", "cavatappi", "arm"],
)
def test_on_measured_logs_it_is_better_than_auto_or_close(log, window, better):
    folder, x, y = log
    recording = dehyst.read_log(DATA / folder / "data.csv.gz", x, y, **window)
    auto = dehyst.identify(recording, family="auto").test.rmse_percent
    fit = identify_family(recording, "krasnoselskii-pokrovskii")
    assert fit.test.rmse_percent < (1.0 if better else 1.15) * auto
    assert fit.invertible and fit.seconds < 4.0
