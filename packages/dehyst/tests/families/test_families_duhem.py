"""Duhem after Coleman and Hodgdon: closed forms, their condition for rising loops, the inverse, the convex fit."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dehyst import Recording, identify
from dehyst.errors import InvertibilityError, ParameterError
from dehyst.families import Dahl, example
from dehyst.families._duhem import Duhem, bernstein, bounded
from family_samples import excitation, integrated, record


def test_a_constant_loss_is_dahl_s_friction():
    x = np.concatenate([excitation(400), 3.0 * excitation(200, 1)])
    wanted = Dahl([0.0, 1.0], [0.25], [-0.4]).simulate(x)
    assert np.allclose(Duhem([0.0, 1.0], 4.0, [0.4]).simulate(x), wanted, rtol=0.0, atol=1e-14)


def test_bernstein_s_polynomials_are_a_partition_of_one():
    x = np.linspace(-1.0, 1.0, 7)
    for size in (1, 2, 6, 16):
        values = np.polynomial.polynomial.polyval(x, bernstein(size).T)
        assert np.allclose(values.sum(axis=0), 1.0) and np.min(values) > -1e-9


@pytest.mark.parametrize("loss", [[0.1, 0.9], [0.3, 0.0, 1.0, 0.2], [-0.5, -0.1, -0.4]])
def test_the_engine_agrees_with_an_integrator_of_the_published_equation(loss):
    # Coleman and Hodgdon 1987: y' = alpha |x'| (f(x) - y) + x' g(x), f = 1.5 x + 0.2 x^3, g = f' - h.
    alpha, f = 3.0, np.polynomial.Polynomial([0.0, 1.5, 0.0, 0.2])
    h = np.polynomial.Polynomial(np.array(loss) @ bernstein(len(loss)))
    x = 0.9 * np.tanh(
        np.concatenate([[0.0], np.cumsum(0.6 * np.random.default_rng(2).normal(size=14))])
    )
    wanted = integrated(lambda s, y, u: s * alpha * (f(u) - y) + f.deriv()(u) - h(u), x)
    assert np.max(np.abs(Duhem(f.coef, alpha, loss).simulate(x) - wanted)) < 1e-9


def test_the_steady_loop_is_the_closed_form():
    # h = 1 + x on [-1, 1], f = 3 x, alpha = 2, cycles of +-1. Upwards w = P + K e^(-2 (x + 1)), P = (1 + x)/2 - 1/4.
    x = np.tile(np.concatenate([np.linspace(-1, 1, 201), np.linspace(1, -1, 201)[1:-1]]), 12)
    y = Duhem([0.0, 3.0], 2.0, [0.0, 2.0]).simulate(x)[-400:]
    # Downwards w = Q + M e^(-2 (1 - x)), Q = -(1 + x)/2 - 1/4; periodic: both meet at the turns.
    e = np.exp(-4.0)
    k, m = np.linalg.solve([[e, -1.0], [1.0, -e]], [-1.25 - 0.75, -0.25 + 0.25])
    up = x[-400:-199]
    wanted = 3.0 * up - ((1.0 + up) / 2.0 - 0.25 + k * np.exp(-2.0 * (up + 1.0)))
    assert np.allclose(y[:201], wanted, rtol=0.0, atol=1e-12)
    down = x[-200:]
    wanted = 3.0 * down - (-(1.0 + down) / 2.0 - 0.25 + m * np.exp(-2.0 * (1.0 - down)))
    assert np.allclose(y[-199:], wanted[1:], rtol=0.0, atol=1e-12)
    assert np.trapezoid(y, x[-400:]) < 0.0  # it lags


@settings(max_examples=50, deadline=None)
@given(
    st.lists(st.floats(-2.5, 2.5), min_size=2, max_size=25),
    st.floats(0.3, 30.0),
    st.lists(st.floats(0.0, 1.0), min_size=1, max_size=6),
    st.sampled_from([1.0, -1.0]),
)
def test_the_least_slope_is_not_undercut_and_the_inverse_undoes_the_model(path, alpha, loss, sign):
    curve = np.array([0.1, 0.0, 0.0, 0.1])
    taken = -Duhem(curve, alpha, sign * np.array(loss)).least_slope
    curve[1] = max(taken, 0.0) + 0.05
    model = Duhem(curve, alpha, sign * np.array(loss))
    assert model.no_inverse == ""
    x = np.array(path)
    y = model.simulate(x)
    assert np.all(
        (np.diff(y) - (model.least_slope - 1e-6) * np.diff(x)) * np.sign(np.diff(x)) >= -1e-12
    )
    assert np.max(np.abs(model.inverse().simulate(y) - x)) < 1e-9


def test_the_inverse_is_refused_exactly_where_coleman_and_hodgdon_s_condition_fails():
    for slope, exists in (
        (0.81, True),
        (0.79, False),
    ):  # twice the loss at x = 1, after a long stroke
        model = Duhem([0.0, slope], 20.0, [0.1, 0.4])
        y = model.simulate([0.0, 9.0, 9.0 - 1e-7])
        assert bool(y[2] < y[1]) == exists == (model.no_inverse == "")
    with pytest.raises(InvertibilityError, match="loss"):
        model.inverse()


def test_least_squares_with_lower_limits_meet_their_optimality_conditions():
    rng = np.random.default_rng(4)
    for _ in range(20):
        columns, y = rng.normal(size=(40, 5)), rng.normal(size=40)
        above, least = rng.normal(size=(7, 5)), rng.normal(size=7) - 1.0
        c, offset, rms = bounded(columns, y, above, least)
        left = columns @ c + offset - y
        slack = above @ c - least
        assert np.min(slack) > -1e-8
        assert rms == pytest.approx(np.sqrt(np.mean(left**2)), rel=1e-6)
        active = slack < 1e-7
        gradient = (
            columns.T @ left
        )  # a combination of the active limits, with weights that are not negative
        if not active.any():
            assert np.max(np.abs(gradient)) < 1e-6
            continue
        weights = np.linalg.lstsq(above[active].T, gradient, rcond=None)[0]
        assert (
            np.allclose(above[active].T @ weights, gradient, atol=1e-5) and np.min(weights) > -1e-6
        )


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_model_is_recovered_from_its_noisy_data_whichever_way_its_loops_run(sign):
    x = excitation(1500)
    x = x / np.max(np.abs(x[:750]))
    truth = Duhem([0.0, 2.0, 0.0, 0.2], 5.0, sign * np.array([0.1, 0.2, 0.8]))
    fit = identify(record(truth, x, 0.002), "duhem")
    assert fit.test.rmse_percent < 0.3
    model, scaling = fit.model, fit.model.scaling
    assert model.alpha / scaling.half_range == pytest.approx(5.0, rel=0.1)
    at = np.array([-0.5, 0.0, 0.5])
    loss = np.polynomial.polynomial.polyval(at, model.loss @ bernstein(model.loss.size))
    wanted = np.polynomial.polynomial.polyval(at, truth.loss @ bernstein(3))
    assert np.allclose(loss * scaling.amplitude / scaling.half_range, wanted, atol=0.06)
    assert not fit.model.no_inverse
    # Wider on one side: a single Dahl element cannot, and says so by its error.
    assert fit.test.rmse_percent < identify(record(truth, x, 0.002), "dahl").test.rmse_percent


def test_several_runs_are_fitted_together_also_upside_down():
    truth = example("duhem")
    runs = [
        record(truth, excitation(500, seed), 0.002, seed, name=f"run {seed}") for seed in range(2)
    ]
    assert identify(runs, "duhem").test.rmse_percent < 0.35
    turned = [
        Recording(input=run.input, output=-2.0 * run.output + 1.0, name=run.name) for run in runs
    ]
    fit = identify(turned, "duhem")
    assert fit.test.rmse_percent < 0.35 and fit.model.scaling.amplitude < 0.0


@pytest.mark.parametrize(
    ("change", "word"),
    [
        ({"alpha": 0.0}, "forgets"),
        ({"loss": [1.0, -1.0]}, "one sign"),
        ({"loss": np.ones(17)}, "at most 16"),
        ({"curve": [np.nan]}, "finite"),
        ({"alpha": None}, "number"),
    ],
)
def test_parameters_without_a_meaning_are_refused(change, word):
    with pytest.raises(ParameterError, match=word):
        Duhem(**change)
