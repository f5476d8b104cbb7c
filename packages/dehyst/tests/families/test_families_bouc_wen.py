"""Bouc-Wen: bound and closed form of the state, the benchmark's numbers, the inverse, the search."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dehyst import identify
from dehyst.errors import ParameterError
from dehyst.families import Dahl, example
from dehyst.families._bouc_wen import BoucWen
from family_samples import excitation, integrated, record


def element(beta, gamma, power, weight=1.0, curve=(0.0,)):
    return BoucWen(curve, [beta], [gamma], [power], [weight])


def test_the_virgin_curve_for_power_one_is_an_exponential():
    # Ikhouane and Rodellar 2007: z = L (1 - exp(-x/L)) with L = 1/(beta + gamma), n = 1.
    x = np.linspace(0.0, 3.0, 50)
    assert np.allclose(
        element(2.0, 1.5, 1.0).simulate(x), (1.0 - np.exp(-3.5 * x)) / 3.5, rtol=0.0, atol=1e-15
    )


def test_the_virgin_curve_for_power_two_is_a_hyperbolic_tangent():
    x = np.linspace(0.0, 3.0, 50)  # dz/dx = 1 - 9 z^2
    assert np.allclose(
        element(6.0, 3.0, 2.0).simulate(x), np.tanh(3.0 * x) / 3.0, rtol=0.0, atol=1e-8
    )


def test_unloading_for_power_two_with_gamma_above_beta_is_a_tangent_turned_hyperbolic():
    # From the limit z = L downwards with gamma = beta: dz/dx = 1 whatever z is, so the unloading line is straight.
    y = element(4.5, 4.5, 2.0).simulate([0.0, 30.0, 29.9, 29.8])
    assert np.allclose(y[1:], [1.0 / 3.0, 1.0 / 3.0 - 0.1, 1.0 / 3.0 - 0.2], rtol=0.0, atol=1e-8)


@settings(max_examples=60, deadline=None)
@given(
    st.lists(st.floats(-3.0, 3.0), min_size=1, max_size=25),
    st.floats(0.02, 2.0),
    st.floats(0.5, 4.0),
    st.floats(1.0, 6.0),
)
def test_the_state_never_leaves_its_bound(path, length, sigma, power):
    # |z| <= (A/(beta + gamma))^(1/n), A = 1 (Ikhouane and Rodellar 2007, class I: beta + gamma > 0, beta >= gamma).
    both = length**-power
    model = element(sigma * both, (1.0 - sigma) * both, power)
    assert model.lengths[0] == pytest.approx(length, rel=1e-12)
    z = model.states(np.array([0.0, *path]))
    assert np.all(np.abs(z) <= length * (1.0 + 1e-7))


@pytest.mark.parametrize(("power", "within"), [(1.0, 1e-9), (1.3, 5e-7), (2.0, 1e-7), (3.7, 1e-7)])
@pytest.mark.parametrize(("beta", "gamma"), [(6.0, 2.0), (3.0, 3.0), (5.0, -2.0)])
def test_the_engine_agrees_with_an_integrator_that_knows_nothing_of_it(power, within, beta, gamma):
    x = np.concatenate([[0.0], np.cumsum(0.4 * np.random.default_rng(3).normal(size=14))])
    wanted = integrated(
        lambda s, z, _: 1.0 - np.abs(z) ** power * (gamma + beta * s * np.sign(z)), x
    )
    assert np.max(np.abs(element(beta, gamma, power).simulate(x) - wanted)) < within


def test_the_benchmark_s_numbers_give_the_benchmark_s_loop():
    # Noel and Schoukens, Hysteretic benchmark with a dynamic nonlinearity, 2016: alpha 5e4 N/m, beta 1e3, gamma 0.8,
    # delta -1.1, nu 1: z' = alpha v - beta (gamma |v| z + delta v |z|). Here z is divided by alpha.
    alpha, beta, gamma, delta = 5e4, 1e3, 0.8, -1.1
    t = np.linspace(0.0, 3.0, 90)
    x = 1.5e-3 * np.sin(6.0 * t)
    rate = lambda s, z, _: alpha - beta * (gamma * s * z + delta * np.abs(z))  # noqa: E731
    wanted = integrated(rate, x)
    model = element(beta * gamma, beta * delta, 1.0, alpha)
    assert np.max(np.abs(model.simulate(x) - wanted)) < 1e-7 * np.max(np.abs(wanted))
    # beta + gamma < 0: it hardens without limit while it loads, and loses energy all the same.
    assert model.lengths[0] == np.inf and model.no_inverse == ""
    assert np.trapezoid(wanted, x) > 0.0


def test_a_state_that_hardens_without_limit_goes_to_infinity_at_once_where_the_equation_does():
    # dz/dx = 1 + 4 z^2: z = tan(2 x)/2, infinite at x = pi/4; with n = 1 it only grows exponentially.
    model = element(1.0, -5.0, 2.0)
    assert model.simulate([0.0, 0.7])[1] == pytest.approx(0.5 * np.tan(1.4), rel=1e-6)
    x = np.linspace(0.0, 30.0, 3000)
    far = model.run(x, None, model.rest(0.0))[0]
    assert np.isinf(far[-1]) and np.all(np.isfinite(far[:78]))
    with pytest.raises(ParameterError, match="diverge"):
        model.simulate(x)
    assert "turn" in element(1.0, -5.0, 2.0, -0.1, (0.0, 1.0)).no_inverse


def test_power_one_without_gamma_is_dahl():
    x = excitation(300)
    wanted = Dahl([0.0, 1.0], [0.25], [-0.4]).simulate(x)
    assert np.array_equal(element(4.0, 0.0, 1.0, -0.4, (0.0, 1.0)).simulate(x), wanted)


def test_many_small_moves_are_one_large_move():
    x = np.linspace(0.0, 1.7, 4000)
    for power in (1.0, 1.5, 4.0):
        model = element(3.0, 1.0, power)
        assert model.simulate(x)[-1] == pytest.approx(model.simulate(x[[0, -1]])[-1], abs=2e-7)


@pytest.mark.parametrize("power", [1.0, 2.5])
@pytest.mark.parametrize("weight", [0.7, -0.4])
def test_the_inverse_undoes_the_model(power, weight):
    model = element(5.0, 1.0, power, weight, (0.2, 1.0, 0.0, 0.1))
    x = excitation(400)
    assert model.no_inverse == ""
    assert np.max(np.abs(model.inverse().simulate(model.simulate(x)) - x)) < 1e-9


def test_the_inverse_is_refused_exactly_where_unloading_is_steeper_than_the_curve():
    # Unloading from the limit: dz/dx = 2 beta/(beta + gamma) = 1.5, so a slope of 0.6 and a weight of -0.4 just fail.
    for slope, exists in ((0.61, True), (0.59, False)):
        model = element(6.0, 2.0, 2.0, -0.4, (0.0, slope))
        assert (model.no_inverse == "") == exists
        y = model.simulate([0.0, 9.0, 9.0 - 1e-7])
        assert bool(y[2] < y[1]) == exists


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_model_is_recovered_from_its_noisy_data_whichever_way_its_loops_run(sign):
    # gamma < 0 and a power: neither is offered by Dahl's friction. The range of the input is scaled to +-1.
    x = excitation(1200)
    x = x / np.max(np.abs(x[:600]))
    truth = element(24.0, -6.0, 2.0, 0.5 * sign, (0.0, 1.6))
    fit = identify(record(truth, x, 0.002), "bouc-wen")
    assert fit.test.rmse_percent < 0.25
    k = int(np.argmax(np.abs(fit.model.weights) * fit.model.lengths))
    half = fit.model.scaling.half_range
    assert np.sign(fit.model.weights[k]) == sign
    assert half * fit.model.lengths[k] == pytest.approx(truth.lengths[0], rel=0.08)
    assert fit.model.power[k] == pytest.approx(2.0, rel=0.25)
    assert not fit.model.no_inverse and fit.settings["seed"] == 0


def test_several_runs_are_fitted_together():
    runs = [
        record(example("bouc-wen"), excitation(400, seed), 0.002, seed, name=f"run {seed}")
        for seed in range(2)
    ]
    fit = identify(runs, "bouc-wen")
    assert len(fit.predictions) == 2 and fit.test.rmse_percent < 0.4


@pytest.mark.parametrize(
    ("change", "word"),
    [
        ({"beta": [-1.0]}, "energy"),
        ({"power": [0.5]}, "at least 1"),
        ({"gamma": [1.0, 2.0]}, "one an element"),
        ({"beta": [np.inf]}, "finite"),
        ({"power": ["two"]}, "numbers"),
    ],
)
def test_parameters_without_a_meaning_are_refused(change, word):
    good = {"curve": [0.0, 1.0], "beta": [1.0], "gamma": [0.0], "power": [1.0], "weights": [0.1]}
    with pytest.raises(ParameterError, match=word):
        BoucWen(**{**good, **change})
