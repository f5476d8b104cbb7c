"""Thresholds that grow with the rate: the plain operator at rest, both inverses, and what identification finds."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import dehyst
from dehyst import Recording
from dehyst.errors import DehystError, IdentificationError, InvertibilityError, ParameterError
from dehyst.families import example, identify_family
from dehyst.families.rate_dependent_pi import RateDependentPrandtlIshlinskii
from family_checks import (
    CAVATAPPI,
    PIEZO,
    held_out,
    log,
    measured,
    noisy,
    plays,
    round_trip,
    same_in_parts,
    steps_like_arrays,
    uneven,
    wander,
)

MODEL = example("rate-dependent-pi")


def test_without_growth_it_is_the_plain_operator():
    plain = dehyst.PrandtlIshlinskii(thresholds=[0.0, 0.1, 0.4], weights=[0.4, 0.2, 0.3])
    mine = RateDependentPrandtlIshlinskii(0.4, [0.1, 0.4], [0.0, 0.0], [0.2, 0.3], start="zero")
    x = wander()
    assert np.max(np.abs(mine.simulate(x, uneven()) - plain.simulate(x))) < 1e-15


def test_thresholds_follow_the_low_passed_rate_of_the_samples_before():
    x, time = wander(), uneven()
    h, rate, rates = np.diff(time, prepend=time[0]), 0.0, []
    for k in range(x.size):
        rates.append(rate)
        if h[k] > 0.0:
            rate += (1.0 - np.exp(-h[k] / MODEL.lag)) * ((x[k] - x[k - 1]) / h[k] - rate)
    r = MODEL.thresholds + np.abs(rates)[:, None] * MODEL.growths
    y = MODEL.direct * x + plays(x, r, np.full(3, x[0])) @ MODEL.weights
    assert np.max(np.abs(MODEL.simulate(x, time) - y)) < 1e-13


@pytest.mark.parametrize("growths", [[0.05] * 4, [0.02, 0.04, 0.07, 0.1]], ids=["equal", "growing"])
def test_the_closed_inverse_with_the_true_rate_is_exact(growths):
    model = RateDependentPrandtlIshlinskii(0.5, [0.05, 0.2, 0.4, 0.7], growths, [0.3, 0.2, 0.1, 0.1])
    t = np.linspace(0.0, 20.0, 4000)
    v, rate = np.sin(t) + 0.3 * np.sin(3.0 * t), np.abs(np.cos(t) + 0.9 * np.cos(3.0 * t))
    y = 0.5 * v + plays(v, model.thresholds + rate[:, None] * model.growths, np.zeros(4)) @ model.weights
    direct, thresholds, growing, weights = model.closed_inverse()
    back = direct * y + plays(y, thresholds + rate[:, None] * growing, np.zeros(4)) @ weights
    assert np.max(np.abs(back - v)) < 3e-15
    at_rest = direct * y + plays(y, thresholds, np.zeros(4)) @ weights
    assert np.max(np.abs(at_rest - v)) > 0.03  # one that knows no rate leaves a loop


@given(st.integers(0, 10**6))
@settings(max_examples=20, deadline=None)
def test_the_explicit_inverse_undoes_it(seed):
    assert round_trip(MODEL, wander(400, seed), uneven(400, seed)) < 1e-13


def test_parts_and_steps_are_the_whole_bit_for_bit():
    x, time = wander(), uneven()
    assert same_in_parts(MODEL, x, np.diff(time, prepend=time[0]))
    assert steps_like_arrays(MODEL, x[:300], time[:300])


def test_loops_widen_with_the_rate():
    x = np.sin(np.linspace(0.0, 6.0 * np.pi, 3000))
    areas = [
        abs(np.trapezoid(MODEL.simulate(x, np.linspace(0.0, span, 3000))[1000:2001], x[1000:2001]))
        for span in (1000.0, 20.0, 5.0)
    ]
    assert areas[0] < areas[1] < areas[2]


def test_a_rate_that_is_faster_than_its_low_pass_has_no_inverse_and_says_so():
    fast = RateDependentPrandtlIshlinskii(0.1, [0.1], [0.5], [0.9], lag=0.1)
    with pytest.raises(InvertibilityError, match=r"delays the output by up to 0\.45 s"):
        fast.inverse()


def test_identification_recovers_a_known_model_from_noisy_data():
    recording = noisy(MODEL)
    fit = identify_family(recording, "rate-dependent-pi")
    assert fit.test.rmse_percent < 0.45 and fit.invertible and fit.seed is None
    x, time = wander(2000, 9), 0.01 * np.arange(2000)
    known, found = MODEL.simulate(x, time), fit.model.simulate(x, time)
    assert np.sqrt(np.mean((known - found) ** 2)) < 0.01 * np.ptp(known)


def test_two_runs_give_the_same_model():
    fits = [identify_family([noisy(MODEL, samples=1500), noisy(MODEL, seed=4)], "rate-dependent-pi") for _ in range(2)]
    assert fits[0].model.parameters() == fits[1].model.parameters()
    assert len(fits[0].predictions) == 2


def test_data_that_it_cannot_fit_are_refused():
    x, time = wander(2000), 0.01 * np.arange(2000)
    with pytest.raises(IdentificationError, match="clockwise"):
        force = example("maxwell-slip").simulate(x)
        identify_family(Recording(input=x, output=force, time=time), "rate-dependent-pi")
    with pytest.raises(DehystError, match="time"):
        identify_family(Recording(input=x, output=x), "rate-dependent-pi")


@pytest.mark.parametrize(
    "arguments",
    [
        (1.0, [0.0], [0.0], [1.0]),
        (1.0, [0.2, 0.1], [0.0, 0.0], [1.0, 1.0]),
        (1.0, [0.1], [-1.0], [1.0]),
        (1.0, [0.1], [0.0], [-1.0]),
        (1.0, [0.1], [0.0], [1.0], 0.0, 0.0),
        (float("nan"),),
    ],
    ids=["threshold-0", "order", "growth", "weight", "lag", "nan"],
)
def test_bad_parameters_are_named(arguments):
    with pytest.raises(ParameterError):
        RateDependentPrandtlIshlinskii(*arguments)


@measured
def test_on_measured_logs_it_is_no_worse_than_the_plain_families():
    for name, bound in ((PIEZO, 0.75), (CAVATAPPI, 1.1)):
        recording = log(*name)
        assert held_out(recording, "rate-dependent-pi") < bound * dehyst.identify(recording).test.rmse_percent


def test_a_file_keeps_the_model_bit_for_bit(tmp_path):
    x, time = wander(300), uneven(300)
    again = dehyst.load(MODEL.save(tmp_path / "model.json"))
    assert np.array_equal(again.simulate(x, time), MODEL.simulate(x, time))
