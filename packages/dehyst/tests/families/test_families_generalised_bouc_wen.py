"""Generalised Bouc-Wen: the classical element within it, the six phases, bounds, inverse, search."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dehyst import identify
from dehyst.errors import ParameterError
from dehyst.families import UNSCALED, example
from dehyst.families._bouc_wen import BoucWen
from dehyst.families._generalised_bouc_wen import GeneralisedBoucWen, shaped
from family_samples import excitation, integrated, record


def element(beta, power=1.0, weight=1.0, curve=(0.0,)):
    return GeneralisedBoucWen(curve, beta, power, [weight])


def psi(b, s, z, x):
    """Equation (9) of Song and Der Kiureghian 2006, written out: an oracle for the table of the engine."""
    s, z, x = np.sign(s), np.sign(z), np.sign(x)
    return b[0] * s * z + b[1] * x * s + b[2] * x * z + b[3] * s + b[4] * z + b[5] * x


@pytest.mark.parametrize("power", [1.0, 2.5])
def test_with_beta_one_alone_it_is_bouc_wen_without_gamma(power):
    x = excitation(400)
    wanted = BoucWen([0.0], [7.0], [0.0], [power], [1.0]).simulate(x)
    assert np.allclose(
        element([7.0, 0, 0, 0, 0, 0], power).simulate(x), wanted, rtol=0.0, atol=1e-7
    )


@pytest.mark.parametrize("power", [1.0, 2.0])
def test_on_the_phases_of_a_steady_loop_it_holds_bouc_wen_with_gamma(power):
    # Where not (x' z < 0 and x x' > 0): 1 = sgn(x' z) - sgn(x x') + sgn(x z), so gamma is b1 = -b2 = b3.
    beta, gamma = 6.0, 3.0
    x = 0.8 * np.sin(np.linspace(0.0, 20.0, 900))  # large cycles about 0 stay in the six phases
    classical = BoucWen([0.0], [beta], [gamma], [power], [1.0])
    x = x[(x != 0.0)]
    general = element([beta + gamma, -gamma, gamma, 0, 0, 0], power)
    assert np.allclose(general.simulate(x), classical.simulate(x), rtol=0.0, atol=1e-7)
    small = 0.5 + 0.2 * np.sin(np.linspace(0.0, 20.0, 900))  # beside 0 they do not, and it shows
    assert np.max(np.abs(general.simulate(small) - classical.simulate(small))) > 1e-3


@pytest.mark.parametrize("power", [1.0, 1.7, 3.0])
def test_the_engine_agrees_with_an_integrator_of_the_published_equation(power):
    b = [9.0, -1.0, 0.7, 1.2, -0.8, 0.5]
    x = np.concatenate([[0.0], np.cumsum(0.35 * np.random.default_rng(5).normal(size=14))])
    wanted = integrated(lambda s, z, u: 1.0 - np.abs(z) ** power * psi(b, s, z, u), x)
    assert np.max(np.abs(element(b, power).simulate(x) - wanted)) < 2e-6


def test_each_loading_phase_goes_to_its_own_limit():
    b = np.array([9.0, -1.0, 0.7, 1.2, -0.8, 0.5])
    model = element(b)
    # From far below slowly up: at x < 0 and at x > 0 the limits differ, and so they do on the way back.
    x = np.concatenate(
        [np.linspace(0, -20, 500), np.linspace(-20, 20, 8001), np.linspace(20, -20, 8001)]
    )
    z = model.simulate(x)
    for at, s in ((500 + 3900, 1.0), (500 + 8000, 1.0), (8501 + 3900, -1.0), (8501 + 8000, -1.0)):
        assert z[at] == pytest.approx(s / psi(b, s, s, x[at]), rel=1e-9)


@settings(max_examples=60, deadline=None)
@given(
    st.lists(st.floats(0.05, 1.0), min_size=4, max_size=4),
    st.floats(0.6, 3.0),
    st.floats(0.6, 3.0),
    st.floats(1.0, 4.0),
    st.lists(st.floats(-2.0, 2.0), min_size=2, max_size=25),
)
def test_the_state_stays_within_limits_that_are_promised_and_slopes_within_their_range(
    lengths, one, two, power, path
):
    model = shaped([np.log([*lengths, one, two, power])], UNSCALED, "rest")
    low, high = model.limits
    if not np.isfinite(high - low):
        return
    x = np.array([0.0, *path])
    z = model.states(x)[:, 0]
    assert np.all(z >= low * (1.0 + 1e-6)) and np.all(z <= high * (1.0 + 1e-6))
    least, most = (float(v[0]) for v in model.slope_ranges())
    slope = np.diff(z) / np.where(np.diff(x) == 0.0, 1.0, np.diff(x))
    assert np.all(slope >= least - 1e-6) and np.all(slope <= most + 1e-6 * most)


@pytest.mark.parametrize("weight", [-0.5, 0.5])
def test_the_inverse_undoes_the_model(weight):
    model = element([6.0, -1.0, 1.0, 1.0, 0.5, 0.5], 2.0, weight, (0.0, 2.0, 0.3))
    x = excitation(400)
    assert model.no_inverse == ""
    assert np.max(np.abs(model.inverse().simulate(model.simulate(x)) - x)) < 1e-9


def test_an_element_that_nothing_bounds_has_no_inverse():
    model = element([-1.0, 0, 0, 0, 0, 0], 1.0, -0.1, (0.0, 1.0))
    assert np.all(np.isinf(model.limits)) and "turn" in model.no_inverse


@pytest.mark.slow
@pytest.mark.parametrize("weight", [0.5, -0.5])
def test_an_asymmetric_model_is_recovered_from_its_noisy_data_better_than_by_bouc_wen(weight):
    x = excitation(1000)
    x = x / np.max(np.abs(x[:500]))
    truth = element([20.0, 0.0, 2.0, 8.0, 1.0, 2.0], 1.5, weight, (0.0, 1.6))
    log = record(truth, x, 0.001)
    fit, classical = (identify(log, name) for name in ("generalised-bouc-wen", "bouc-wen"))
    assert fit.test.rmse_percent < 0.25
    assert fit.test.rmse_percent < classical.test.rmse_percent
    model, scaling = fit.model, fit.model.scaling
    width = scaling.amplitude * model.weights[0] * np.ptp(model.limits)
    assert width == pytest.approx(weight * np.ptp(truth.limits), rel=0.15)


def test_several_runs_are_fitted_together():
    truth = example("generalised-bouc-wen")
    runs = [
        record(truth, excitation(400, seed), 0.002, seed, name=f"run {seed}") for seed in range(2)
    ]
    assert identify(runs, "generalised-bouc-wen").test.rmse_percent < 0.6


@pytest.mark.parametrize(
    ("change", "word"),
    [
        ({"beta": [1.0]}, "six"),
        ({"power": 0.3}, "at least 1"),
        ({"weights": [1.0, 2.0]}, "one"),
        ({"power": "x"}, "number"),
    ],
)
def test_parameters_without_a_meaning_are_refused(change, word):
    with pytest.raises(ParameterError, match=word):
        GeneralisedBoucWen(**change)
