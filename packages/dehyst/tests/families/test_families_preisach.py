"""Preisach operator: sum of relays, Mayergoyz' two properties, reversal curves, decaying sweep, inverse, fit."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import dehyst
from dehyst import PrandtlIshlinskii, Recording
from dehyst.errors import InvertibilityError, ParameterError
from dehyst.families import STARTS, example
from dehyst.families._preisach import Preisach, _decay
from dehyst.identification._auto import fit_plays as identify_plays
from places import DATA

MODEL = Preisach.example()
SIZE = MODEL.knots.size - 1
signals = st.lists(st.floats(-1.5, 1.5), min_size=2, max_size=40).map(np.array)
seeds = st.integers(0, 10**6)


def relays(model, x, per_side):
    """Outputs from negative saturation by relays, per_side^2 of them in each cell; the diagonal is a curve."""
    knots, square = model.knots, np.zeros((model.knots.size - 1,) * 2)
    square[np.tril_indices(square.shape[0])] = model.masses
    place = (np.arange(per_side) + 0.5) / per_side
    up, down, mass = [], [], []
    for i, j in zip(*np.tril_indices(square.shape[0], -1), strict=True):
        a, b = (knots[k] + place * (knots[k + 1] - knots[k]) for k in (i, j))
        up.append(np.repeat(a, per_side))
        down.append(np.tile(b, per_side))
        mass.append(np.full(per_side**2, square[i, j] / per_side**2))
    up, down, mass = (np.concatenate(part) for part in (up, down, mass))
    state, outputs = -np.ones(mass.size), []
    curve = np.concatenate([[0.0], np.cumsum(np.diag(square))])
    for value in x:
        state[value >= up], state[value <= down] = 1.0, -1.0
        outputs.append(
            model.offset + mass @ state + 2.0 * np.interp(value, knots, curve) - curve[-1]
        )
    return np.array(outputs)


def random_model(seed):
    """Random grid, masses and offset, a quarter of the cells empty."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 9))
    knots = np.sort(np.concatenate([[-1.0, 1.0], rng.uniform(-0.98, 0.98, n - 1)]))
    masses = rng.exponential(size=n * (n + 1) // 2) * (rng.random(n * (n + 1) // 2) > 0.25)
    i, j = np.tril_indices(n)
    masses[i == j] += 0.02
    return Preisach.from_masses(knots * rng.uniform(1.0, 1.2), masses, float(rng.normal()))


def after(x, model=MODEL):
    """Output at the end of a signal from negative saturation."""
    return model.run(np.asarray(x, dtype=float), None, model.saturated())[0][-1]


def rich(seed, samples=3000):
    """Sweeps between random ends, some of them large."""
    rng = np.random.default_rng(seed)
    ends = rng.uniform(-1.0, 1.0, samples // 50) * rng.choice([1.0, 0.5], samples // 50)
    ends[:4] = 0.0, 1.0, -1.0, 1.0
    return np.interp(np.arange(samples), np.linspace(0, samples, ends.size), ends)


# ---- The operator


def test_it_is_the_sum_of_relays():
    rng = np.random.default_rng(1)
    on_knots = MODEL.knots[rng.integers(0, SIZE + 1, 300)]
    found = MODEL.run(on_knots, None, MODEL.saturated())[0]
    np.testing.assert_allclose(
        found, relays(MODEL, on_knots, 1), atol=1e-12
    )  # a cell is up or down as a whole
    anywhere = rng.uniform(-1, 1, 200)
    found = MODEL.run(anywhere, None, MODEL.saturated())[0]
    errors = [np.abs(found - relays(MODEL, anywhere, q)).max() for q in (4, 16)]
    assert errors[1] < 0.008 and errors[1] < 0.5 * errors[0]  # and constant measure within it


@given(seeds, signals)
@settings(max_examples=60, deadline=None)
def test_the_states_of_the_cells_give_the_output(seed, x):
    model = random_model(seed)
    inside = np.clip(x, -1, 1)
    for start in STARTS:
        begun = model.with_start(start)
        np.testing.assert_allclose(
            begun.offset + begun.states(inside) @ begun.masses,
            begun.simulate(inside),
            atol=1e-12 * model.table.max(),
        )


@given(seeds, signals, signals)
@settings(max_examples=60, deadline=None)
def test_a_passed_turn_is_wiped_out(seed, x, inner):
    model = random_model(seed)
    low, high = sorted((x[-1], x[-2]))
    # A little loop inside the last stroke, closed before going on: no trace of it, to the bit.
    detour = np.concatenate([x, np.clip(inner, low, high), [x[-2]], [x[-1]]])
    straight = np.concatenate([x, [x[-2]], [x[-1]]])
    with_it, without = (model.run(s, None, model.saturated())[1] for s in (detour, straight))
    assert np.array_equal(with_it, without)


def test_minor_loops_between_the_same_inputs_are_congruent():
    loop = np.concatenate([np.linspace(-0.2, 0.4, 31), np.linspace(0.4, -0.2, 31)])
    shapes, levels = [], []
    for past in ([-1, -0.2], [1, -0.2], [-1, 0.9, -0.8, 0.6, -0.2]):
        y = MODEL.run(np.array(past, dtype=float), None, MODEL.saturated())
        y = MODEL.run(np.tile(loop, 3), None, y[1])[0][31:]  # from the upper turn on
        assert np.allclose(y[:62], y[62:124], atol=1e-14)  # closed at once: return-point memory
        shapes.append(y[:62] - y[0])
        levels.append(y[0])
    assert np.ptp(levels) > 0.1  # they stand at different heights
    np.testing.assert_allclose(shapes[1:], [shapes[0]] * 2, atol=1e-14)


@given(seeds, st.floats(-1, 1), st.floats(-1, 1))
@settings(max_examples=60, deadline=None)
def test_half_the_output_difference_on_a_reversal_curve_is_the_everett_function(seed, one, other):
    model = random_model(seed)
    beta, alpha = min(one, other), max(one, other)
    half = 0.5 * (after([-1, alpha], model) - after([-1, alpha, beta], model))
    mirrored = 0.5 * (after([1, beta, alpha], model) - after([1, beta], model))
    np.testing.assert_allclose(mirrored, half, atol=1e-12 * model.table.max())
    i, j = (
        min(max(int(np.searchsorted(model.knots, v, "right")) - 1, 0), model.knots.size - 2)
        for v in (alpha, beta)
    )
    u, v = (
        (t - model.knots[k]) / (model.knots[k + 1] - model.knots[k])
        for t, k in ((alpha, i), (beta, j))
    )
    corner = model.table[i : i + 2, j : j + 2]
    bilinear = (
        (1 - u) * (1 - v) * corner[0, 0] + (1 - u) * v * corner[0, 1] + u * (1 - v) * corner[1, 0]
    )
    bilinear += u * v * corner[1, 1]
    wanted = (u - v) * model.table[i + 1, i] if i == j else bilinear
    np.testing.assert_allclose(half, wanted, atol=1e-12 * model.table.max())


@given(seeds, signals, st.integers(2, 5))
@settings(max_examples=40, deadline=None)
def test_only_the_order_of_turns_matters_not_how_fast(seed, x, times):
    model = random_model(seed)
    dense = np.concatenate([np.linspace(a, b, times + 1)[1:] for a, b in pairwise(x)])
    slow = model.simulate(np.concatenate([x[:1], dense]))[::times]
    np.testing.assert_allclose(slow, model.simulate(x), atol=1e-12 * model.table.max())


@given(seeds, signals)
@settings(max_examples=40, deadline=None)
def test_with_a_measure_that_depends_on_alpha_minus_beta_it_is_a_prandtl_ishlinskii_operator(
    seed, x
):
    weights = np.random.default_rng(seed).uniform(0, 1, 10)
    knots, radii = np.linspace(-1, 1, 11), np.arange(10) * 0.1
    i, j = np.tril_indices(10)
    model = Preisach.from_masses(knots, 0.1 * weights[i - j])
    on_knots = np.concatenate(
        [[1.0, -1.0], knots[np.round((np.clip(x, -1, 1) + 1) * 5).astype(int)]]
    )
    pi = PrandtlIshlinskii(radii, weights).simulate(on_knots)
    np.testing.assert_allclose(
        model.run(on_knots[1:], None, model.saturated())[0], pi[1:], atol=1e-12
    )


def test_beyond_the_grid_it_goes_on_without_memory():
    up, back = MODEL.run(np.array([1.0, 3.0, 1.0, 0.5]), None, MODEL.saturated())[0][[1, 2]]
    assert up == pytest.approx(
        back + 2.0 * MODEL.table[-1, 0]
    )  # two half ranges with the mean slope of the loop
    assert after([-1, 3, 0.2]) == after([-1, 1, 0.2])


# ---- Its state: what kept the operator out of a controller


def test_a_decaying_sweep_leaves_one_state_whatever_was_before():
    unknown = [after([end, 0.0]) for end in (1.0, -1.0)]
    assert (
        unknown[0] - unknown[1] > 0.4
    )  # the obstacle: at one input the output may be anywhere between
    sweep = _decay(-1.0, 1.0, SIZE)
    for past in ([-1.0], [1.0, 0.3], [-0.4, 0.9, -0.9, 0.1]):
        memory = MODEL.run(np.concatenate([past, np.clip(sweep, -1, 1)]), None, MODEL.saturated())[
            1
        ]
        assert np.array_equal(memory, MODEL.rest(0.0))
    # A sweep of one's own, with other steps, comes close to it.
    own = 1.3 * 0.97 ** np.arange(200) * (-1.0) ** np.arange(200)
    memory = MODEL.run(np.concatenate([[0.7], own]), None, MODEL.saturated())[1]
    x = rich(3, 500)
    assert np.abs(MODEL.run(x, None, memory)[0] - MODEL.with_start("zero").simulate(x)).max() < 0.01


def test_the_swept_state_of_a_symmetric_measure_is_in_the_middle():
    i, j = np.tril_indices(10)
    model = Preisach.from_masses(np.linspace(-1, 1, 11), 1.0 / (1 + (i - j)))
    assert model.simulate([0.0])[0] == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("start", STARTS)
def test_running_in_two_parts_is_running_once_to_the_bit(start):
    x = 1.1 * rich(5, 600)
    begun = MODEL.before(float(x[0]))
    once, end = MODEL.run(x, None, begun)
    first, memory = MODEL.run(x[:217], None, begun)
    second, last = MODEL.run(x[217:], None, memory)
    assert np.array_equal(once, np.concatenate([first, second])) and np.array_equal(end, last)


# ---- Its inverse


@given(seeds, signals, st.sampled_from(STARTS))
@settings(max_examples=200, deadline=None)
def test_the_inverse_undoes_it(seed, x, start):
    model = random_model(seed).with_start(start)
    again = model.inverse().simulate(model.simulate(x))
    np.testing.assert_allclose(again, x, atol=1e-10)


def test_the_inverse_goes_beyond_a_last_knot_that_rounding_misses():
    knots = np.array([-1.0, -0.49742415414537494])  # -1 + (knot + 1) is not the knot
    assert knots[0] + (knots[1] - knots[0]) != knots[1]
    model = Preisach(knots, np.array([0.3]))
    x = np.array([0.2, -0.4, -0.7, 1.3])
    y = model.run(x, None, model.saturated())[0]
    np.testing.assert_allclose(model.run_inverse(y, None, model.saturated())[0], x, atol=1e-12)


def test_a_measure_of_both_signs_has_an_inverse_if_the_reversible_part_outweighs_it():
    i, j = np.tril_indices(10)
    light, heavy = (
        Preisach.from_masses(np.linspace(-1, 1, 11), np.where(i == j, 1.0, -negative))
        for negative in (0.1, 0.2)
    )
    x = rich(7, 500)
    np.testing.assert_allclose(light.inverse().simulate(light.simulate(x)), x, atol=1e-10)
    with pytest.raises(InvertibilityError, match="outweighs"):
        heavy.inverse()


def test_without_a_reversible_part_there_is_no_inverse():
    with pytest.raises(InvertibilityError, match="does not follow"):
        Preisach.from_masses(np.array([-1.0, 0.0, 1.0]), np.array([0.1, 1.0, 0.0])).inverse()


def test_parameters_that_do_not_belong_together_are_refused():
    with pytest.raises(ParameterError, match="3 knots with 2 values"):
        Preisach(np.array([-1.0, 0.0, 1.0]), np.array([0.1, 0.9]))
    with pytest.raises(ParameterError, match="increasing"):
        Preisach(np.array([-1.0, 1.0, 0.0]), np.array([0.1, 0.9, 0.1]))


# ---- Its identification


def test_a_known_measure_is_found_again():
    i, j = np.tril_indices(10)
    place = -0.9 + 0.2 * np.arange(10)
    masses = np.exp(
        -4 * (place[i] + place[j]) ** 2 - 3 * (place[i] - place[j] - 0.4) ** 2
    ) + 0.5 * (i == j)
    truth = Preisach.from_masses(np.linspace(-1, 1, 11), masses / masses.sum()).with_start("zero")
    x = rich(11, 6000)
    fit = dehyst.identify(Recording(input=x, output=truth.simulate(x)), "preisach")
    assert fit.test.rmse_percent < 0.05
    assert fit.model.start == "zero" and fit.input_error.rms_percent < 0.5
    i, j = np.tril_indices(fit.model.knots.size - 1)
    for alpha, beta in ((0.8, -0.8), (0.4, -0.2), (0.2, 0.0), (1.0, -1.0), (0.0, -0.6)):
        values = [after([-1, alpha], m) - after([-1, alpha, beta], m) for m in (truth, fit.model)]
        assert values[1] * fit.model.scaling.amplitude == pytest.approx(values[0], abs=0.01)


@pytest.mark.slow
@pytest.mark.parametrize("start", ["zero", "rising", "falling"])
def test_the_start_state_is_found(start):
    quiet = 0.2 * np.sin(
        np.linspace(0.0, 20.0, 500)
    )  # far from both ends, its level tells the past
    x = np.concatenate([quiet, rich(17, 4000)])
    y = MODEL.with_start(start).simulate(x)
    fit = dehyst.identify(Recording(input=x, output=y), "preisach")
    assert fit.model.start == start and fit.test.rmse_percent < 0.5


@pytest.mark.slow
def test_clockwise_loops_get_a_measure_that_is_negative_off_the_diagonal():
    x = rich(13, 4000)
    y = x - 0.5 * PrandtlIshlinskii([0.1, 0.3, 0.5], [0.5, 0.6, 0.7]).simulate(x)
    fit = dehyst.identify(Recording(input=x, output=y), "preisach")
    i, j = np.tril_indices(fit.model.knots.size - 1)
    assert np.all(fit.model.masses[i != j] < 1e-9) and np.all(fit.model.masses[i == j] > 0.0)
    assert fit.test.rmse_percent < 1.0


def test_the_example_is_in_the_registry():
    assert isinstance(example("preisach"), Preisach)
    assert "preisach" in repr(example("preisach"))


@pytest.mark.slow
@pytest.mark.skipif(not (DATA / "piezo_dbo" / "data.csv.gz").is_file(), reason="no measured logs")
@pytest.mark.parametrize(
    ("log", "window", "better"),
    [
        (("piezo_dbo", "voltage_v", "displacement_um"), {"run": "model", "start": 2}, True),
        (("tendon_sheath_joint", "angle_cmd_deg", "angle_deg"), {"run": "config_030"}, True),
        (("cavatappi_muscle", "pressure_psi", "displacement_mm"), {"run": "300g_s3_t1"}, True),
        (
            ("pneumatic_arm_segment", "pressure_interp_psi", "tilt_rad"),
            {"run": "oct28_exp5", "start": 12},
            False,
        ),
    ],
    ids=["piezo", "tendon", "cavatappi", "arm"],
)
def test_on_measured_logs_it_is_better_than_plays_or_close(log, window, better):
    folder, x, y = log
    recording = dehyst.read_log(DATA / folder / "data.csv.gz", x, y, **window)
    plays = identify_plays(recording).test.rmse_percent
    fit = dehyst.identify(recording, "preisach")
    assert fit.test.rmse_percent < (1.0 if better else 1.15) * plays
    assert not fit.model.no_inverse
