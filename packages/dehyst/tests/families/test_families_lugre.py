"""LuGre: break-away, Stribeck's curve, passivity after Barabanov and Ortega, the quasi-static limit, the fit."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dehyst import Recording, identify
from dehyst.errors import IdentificationError, InvertibilityError, ParameterError
from dehyst.families import Dahl, example
from dehyst.families._lugre import LuGre
from family_samples import excitation, record

# Canudas de Wit et al. 1995, table I: sigma_0 1e5 N/m, sigma_1 sqrt(1e5) N s/m, sigma_2 0.4 N s/m, F_c 1 N, F_s 1.5 N,
# v_s 0.001 m/s.
PUBLISHED = LuGre([0.0], [1e5, np.sqrt(1e5), 0.4], length=1.0 / 1e5, ratio=1.5, stribeck=0.001)


def test_the_published_friction_breaks_away_at_the_published_static_force():
    t = np.linspace(0.0, 2000.0, 20001)
    x = 1e-7 * t  # 0.1 micrometres a second: far below v_s
    assert np.max(PUBLISHED.simulate(x, t)) == pytest.approx(1.5, rel=1e-3)


@pytest.mark.parametrize("v", [1e-5, 5e-4, 1e-3, 3e-3, 0.1, -2e-3])
def test_at_constant_speed_the_force_is_stribeck_s_curve(v):
    t = np.linspace(0.0, 200.0 * 1e-5 / abs(v), 2001)
    wanted = (
        np.sign(v) * (1.0 + 0.5 * np.exp(-((v / 0.001) ** 2))) + 0.4 * v
    )  # the paper's equation (6)
    assert PUBLISHED.simulate(v * t, t)[-1] == pytest.approx(wanted, rel=1e-9)
    assert PUBLISHED.friction(v) == pytest.approx(wanted, rel=1e-12)


@settings(max_examples=50, deadline=None)
@given(
    st.lists(st.tuples(st.floats(-2.0, 2.0), st.floats(1e-3, 3.0)), min_size=1, max_size=30),
    st.floats(1.0, 4.0),
    st.floats(0.01, 1.0),
    st.floats(0.0, 0.5),
)
def test_bristles_stay_below_the_static_limit_and_a_passive_friction_never_gives_back_more_than_it_stored(
    moves, ratio, stribeck, damping
):
    # Barabanov and Ortega 2000: passive if and only if sigma_2 >= sigma_1 (F_s - F_c)/F_c.
    model = LuGre([0.0], [1.0, damping, damping * (ratio - 1.0)], 0.2, ratio, stribeck)
    assert model.passive
    step, period = np.array(moves).T
    fine = 40  # samples a move
    x = np.concatenate([[0.0], np.cumsum(np.repeat(step / fine, fine))])
    t = np.concatenate([[0.0], np.cumsum(np.repeat(period / fine, fine))])
    z = model.states(x, np.diff(t, prepend=0.0))[:, 0]
    assert np.all(np.abs(z) <= 0.2 * ratio * (1.0 + 1e-12))
    # At the end of a sample friction is at least its mean over it less what z moved: bound the quadrature by that.
    force, dx = model.simulate(x, t), np.diff(x)
    slack = np.sum(np.abs(dx) * (np.abs(np.diff(z)) + damping * np.abs(np.diff(z)) / np.diff(t)))
    assert np.sum(force[1:] * dx) >= -slack - 1e-12


def test_with_less_viscous_friction_it_gives_back_more_than_it_stored():
    # Loaded slowly to z = L_s, then pulled so fast that the bristles have no time to relax, over much less than L.
    given_back = []
    for viscous in (0.9, 2.1):
        model = LuGre([0.0], [1.0, 1.0, viscous], 0.2, 3.0, 0.1)
        slow, fast = np.linspace(0.0, 5.0, 3000), 5.0 + np.linspace(0.0, 0.02, 401)[1:]
        x, t = np.concatenate([slow, fast]), np.concatenate([slow * 1e5, 5e5 + (fast - 5.0) * 1e-3])
        force = model.simulate(x, t)
        given_back.append(float(np.sum(force[3000:] * np.diff(x)[2999:])))
        stored = 0.5 * 0.6**2
        assert model.passive == (given_back[-1] > -stored)
    assert given_back[0] < -0.18 < 0.0 < given_back[1]


def test_a_move_without_time_is_the_slowest_one():
    model = LuGre([0.1, 1.0], [2.0, 0.3, 0.2], 0.2, 2.0, 0.5)
    x = excitation(200)
    still = model.run(x, np.zeros(x.size), model.rest(x[0]))[0]
    slow = model.run(x, np.full(x.size, 1e9), model.rest(x[0]))[0]
    assert np.allclose(still, slow, rtol=0.0, atol=1e-8)


def test_without_stribeck_and_damping_it_is_dahl():
    x = excitation(300)
    t = np.cumsum(np.random.default_rng(0).random(300) + 0.1)
    dahl = Dahl([0.0, 1.0], [0.3], [0.8]).simulate(x)
    assert np.allclose(
        LuGre([0.0, 1.0], [0.8, 0.0, 0.0], 0.3, 1.0, 1.0).simulate(x, t), dahl, rtol=0.0, atol=1e-13
    )


@settings(max_examples=40, deadline=None)
@given(
    st.sampled_from([1.0, 1.05, 1.3]),
    st.floats(0.0, 0.2),
    st.floats(0.05, 2.0),
    st.lists(st.tuples(st.floats(-1.5, 1.5), st.floats(1e-3, 5.0)), min_size=2, max_size=25),
    st.booleans(),
)
def test_where_an_inverse_is_promised_it_undoes_the_model_at_any_speed(
    ratio, damping, stribeck, samples, lag
):
    sigma = [-0.3, 0.0, 0.0] if lag else [1.0, damping, 2.0 * damping]
    model = LuGre([0.0, 2.0], sigma, 0.2, ratio, stribeck)
    assert model.no_inverse == ""
    x, period = np.array(samples).T
    t = np.cumsum(period)
    assert np.max(np.abs(model.inverse().simulate(model.simulate(x, t), t) - x)) < 1e-9


@pytest.mark.parametrize(
    ("sigma", "ratio", "word"),
    [
        ([-0.2, 0.0, -0.1], 1.0, "falls behind"),
        ([1.0, 0.0, 0.0], 5.0, "more than its curve rises"),
        ([0.1, 0.5, 0.0], 1.0, "bristles"),
    ],
)
def test_an_inverse_that_cannot_be_promised_is_refused_with_the_reason(sigma, ratio, word):
    with pytest.raises(InvertibilityError, match=word):
        LuGre([0.0, 1.0], sigma, 0.2, ratio, 0.5).inverse()


@pytest.mark.parametrize("stiffness", [3.0, -0.5])
def test_a_model_is_recovered_from_its_noisy_data_whichever_way_its_loops_run(stiffness):
    x = excitation(2000)
    x = x / np.max(np.abs(x[:1000]))
    t = np.linspace(0.0, 60.0, x.size)
    truth = LuGre([0.0, 1.5], [stiffness, 0.0, 0.1 * stiffness], 0.12, 2.0, 0.3)
    fit = identify(record(truth, x, 0.001, time=t), "lugre")
    assert fit.test.rmse_percent < 0.3
    model, scaling = fit.model, fit.model.scaling
    friction = scaling.amplitude * model.sigma[0] * model.length
    assert friction == pytest.approx(0.12 * stiffness, rel=0.1)
    assert model.ratio == pytest.approx(2.0, rel=0.15)
    assert model.stribeck * scaling.half_range == pytest.approx(0.3, rel=0.2)
    assert scaling.amplitude / scaling.half_range * model.sigma[2] == pytest.approx(
        0.1 * stiffness, rel=0.15
    )
    assert (
        identify(record(truth, x, 0.001, time=t), "lugre").model.parameters() == model.parameters()
    )


def test_several_runs_are_fitted_together():
    t = np.linspace(0.0, 30.0, 700)
    runs = [
        record(example("lugre"), excitation(700, k), 0.002, k, t, name=f"run {k}") for k in range(2)
    ]
    fit = identify(runs, "lugre")
    assert len(fit.predictions) == 2 and fit.test.rmse_percent < 0.4


def test_a_log_without_time_is_refused_with_a_cure():
    x = excitation(300)
    with pytest.raises(IdentificationError, match="time"):
        identify(Recording(input=x, output=Dahl().simulate(x)), "lugre")


@pytest.mark.parametrize(
    ("change", "word"),
    [
        ({"sigma": [1.0, -1.0, 0.0]}, "leads"),
        ({"sigma": [1.0]}, "sigma"),
        ({"ratio": 0.9}, "at least 1"),
        ({"length": 0.0}, "positive"),
        ({"stribeck": np.nan}, "finite"),
    ],
)
def test_parameters_without_a_meaning_are_refused(change, word):
    with pytest.raises(ParameterError, match=word):
        LuGre(**change)
