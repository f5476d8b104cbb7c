"""Dahl's friction: the law of 1968 in closed form, its limits, its inverse, and the convex fit."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dehyst import Recording, identify
from dehyst.errors import DehystError, ExcitationError, ParameterError
from dehyst.families import Dahl, example
from family_samples import excitation, record

ONE = Dahl(curve=[0.0], lengths=[0.3], weights=[2.0])


def test_the_virgin_curve_is_the_exponential_of_dahl_1968():
    # P. R. Dahl 1968, exponent 1: F = F_c (1 - exp(-sigma x / F_c)) from rest, F_c = 2.0 * 0.3, sigma = 2.0.
    x = np.linspace(0.0, 4.0, 60)
    assert np.allclose(ONE.simulate(x), 0.6 * (1.0 - np.exp(-2.0 * x / 0.6)), rtol=0.0, atol=1e-14)
    assert np.allclose(ONE.simulate(-x), -ONE.simulate(x), rtol=0.0, atol=1e-15)


def test_the_stiffness_after_a_turn_from_slipping_is_twice_that_from_rest():
    y = ONE.simulate([0.0, 50.0, 50.0 - 1e-6])
    assert y[1] == pytest.approx(0.6, abs=1e-12)
    assert (y[1] - y[2]) / 1e-6 == pytest.approx(4.0, rel=1e-4)


def test_a_cycle_of_slipping_loses_four_times_friction_times_stroke_less_the_turns():
    # Work of one cycle between +-a in the limit: F_c * 4 a - 4 F_c^2 / sigma * tanh-like turns, here by exact integral.
    a, limit, length = 1.0, 0.6, 0.3
    turn = limit * np.tanh(a / length)  # of the steady loop, from F(a) = -F(-a)
    x = np.concatenate(
        [np.tile(np.concatenate([np.linspace(-a, a, 4001), np.linspace(a, -a, 4001)[1:]]), 3)]
    )
    y = ONE.with_start("zero").simulate(x)
    one = slice(-8001, None)
    assert np.max(y[one]) == pytest.approx(turn, abs=1e-12)
    lost = np.trapezoid(y[one], x[one])
    assert lost == pytest.approx(4.0 * limit * (a - length * np.tanh(a / length)), rel=1e-6)


@settings(max_examples=60, deadline=None)
@given(
    st.lists(st.floats(-3.0, 3.0), min_size=2, max_size=30),
    st.lists(st.tuples(st.floats(0.01, 5.0), st.floats(-1.0, 1.0)), min_size=1, max_size=4),
)
def test_no_force_exceeds_the_friction_and_the_inverse_undoes_the_model(path, elements):
    lengths, weights = np.array(elements).T
    model = Dahl([0.0, 0.05 + 2.0 * np.sum(np.abs(weights))], lengths, weights)
    x = np.array(path)
    assert np.all(np.abs(model.states(x)) <= lengths * (1.0 + 1e-12))
    assert model.no_inverse == ""
    assert np.max(np.abs(model.inverse().simulate(model.simulate(x)) - x)) < 1e-9


def test_the_inverse_is_refused_exactly_where_a_turn_moves_the_output_back():
    for slope, exists in ((0.81, True), (0.79, False)):
        model = Dahl([0.0, slope], [0.2], [-0.4])
        assert (model.no_inverse == "") == exists
        y = model.simulate([0.0, 9.0, 9.0 - 1e-7])
        assert bool(y[2] < y[1]) == exists


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_model_is_recovered_from_its_noisy_data_whichever_way_its_loops_run(sign):
    truth = Dahl([0.1, 1.2, 0.0, 0.2], [0.08, 0.5], [0.3 * sign, 0.25 * sign])
    x = excitation()
    fit = identify(record(truth, x, 0.003), "dahl")
    assert fit.test.rmse_percent < 0.35
    force = np.sum(
        np.abs(fit.model.weights) * fit.model.lengths
    )  # all friction, in half ranges of input and output
    scaling = fit.model.scaling
    wanted = np.sum(np.abs(truth.weights) * truth.lengths)
    assert np.all(np.sign(fit.model.weights) == sign)
    assert scaling.amplitude * force == pytest.approx(wanted, rel=0.15)
    assert not fit.model.no_inverse and "seed" not in fit.settings
    back = fit.model.inverse().simulate(fit.model.simulate(x))
    assert np.max(np.abs(back - x)) < 1e-9


def test_several_runs_are_fitted_together():
    truth = example("dahl")
    runs = [
        record(truth, excitation(600, seed), 0.002, seed, name=f"run {seed}") for seed in range(3)
    ]
    fit = identify(runs, "dahl")
    assert len(fit.predictions) == 3 and fit.test.rmse_percent < 0.3


def test_a_falling_curve_is_fitted_upside_down():
    x = excitation()
    y = -3.0 * example("dahl").simulate(x) + 8.0
    fit = identify(Recording(input=x, output=y), "dahl")
    assert fit.model.scaling.amplitude < 0.0 and fit.test.rmse_percent < 0.1


@pytest.mark.parametrize(
    ("change", "word"),
    [
        ({"lengths": [0.0, 1.0]}, "above 0"),
        ({"lengths": [1.0]}, "one of each"),
        ({"weights": [np.nan, 1.0]}, "finite"),
        ({"curve": []}, "shape"),
        ({"weights": [[1.0, 2.0]]}, "shape"),
    ],
)
def test_parameters_without_a_meaning_are_refused(change, word):
    good = {"curve": [0.0, 1.0], "lengths": [0.1, 1.0], "weights": [0.1, 0.1]}
    with pytest.raises(ParameterError, match=word):
        Dahl(**{**good, **change})


def test_a_log_that_does_not_move_is_refused():
    with pytest.raises(ExcitationError):
        identify(Recording(input=np.ones(50), output=np.arange(50.0)), "dahl")
    with pytest.raises(DehystError):
        identify(Recording(input=np.arange(3.0), output=np.ones(3)), "dahl")
