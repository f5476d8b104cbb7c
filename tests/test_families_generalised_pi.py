"""Plays between equal envelopes: the plain operator, the closed inverse, the published example, and identification."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import dehyst
from dehyst import Recording
from dehyst.errors import IdentificationError, InvertibilityError, ParameterError
from dehyst.families import example, identify_family
from dehyst.families.generalised_pi import GeneralisedPrandtlIshlinskii
from family_checks import (
    TENDON,
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

MODEL = example("generalised-pi")
POINTS = GeneralisedPrandtlIshlinskii(
    0.4, [0.1, 0.5], [0.3, 0.2], points_x=[-1.0, 0.0, 0.3, 1.0], points_g=[-0.5, -0.2, 0.4, 1.5], offset=0.1
)


def test_with_the_input_as_envelope_it_is_the_plain_operator():
    plain = dehyst.PrandtlIshlinskii(thresholds=[0.0, 0.1, 0.4], weights=[0.4, 0.2, 0.3], offset=-0.2)
    mine = GeneralisedPrandtlIshlinskii(0.4, [0.1, 0.4], [0.2, 0.3], offset=-0.2, start="zero")
    x = wander()
    assert np.max(np.abs(mine.simulate(x) - plain.simulate(x))) < 1e-15


def test_the_published_example_by_its_definition():
    """a0 = 6, a1 = 0.4, q = 0.4, r_j = 0.45 (j - 1), p_j = 0.65 exp(-7.75e-4 r_j), n = 7 (Al Janaideh)."""
    x = wander(800, 4, reach=7.0)
    g = 6.0 * np.tanh(0.4 * x)
    r = 0.45 * np.arange(7)
    z, rows = np.full(7, g[0]), []
    for value in g:  # between the envelopes g + r and g - r
        z = np.maximum(value - r, np.minimum(value + r, z))
        rows.append(z)
    y = 0.4 * g + np.array(rows) @ (0.65 * np.exp(-7.75e-4 * r))
    model = GeneralisedPrandtlIshlinskii.published()
    assert np.max(np.abs(model.simulate(x) - y)) < 1e-13
    assert round_trip(model, x) < 1e-11  # the tangent is flat at its ends: 1 - tanh(2.8)^2 = 0.015


@pytest.mark.parametrize("model", [MODEL, POINTS], ids=["tangent", "points"])
@given(seed=st.integers(0, 10**6))
@settings(max_examples=15, deadline=None)
def test_the_closed_inverse_undoes_it(model, seed):
    assert round_trip(model, wander(300, seed)) < 1e-13


@pytest.mark.parametrize("model", [MODEL, POINTS], ids=["tangent", "points"])
def test_parts_and_steps_are_the_whole_bit_for_bit(model):
    assert same_in_parts(model, wander())
    assert steps_like_arrays(model, wander(300))


def test_its_loops_close_and_only_turning_points_count():
    x = np.array([0.0, 0.8, -0.5, 0.3, -0.2, 0.3, -0.5, 0.8])
    y = MODEL.simulate(x)
    assert abs(y[3] - y[5]) < 1e-15 and abs(y[2] - y[6]) < 1e-15 and abs(y[1] - y[7]) < 1e-15
    fine = np.interp(np.linspace(0.0, 7.0, 7001), np.arange(8), x)
    assert np.max(np.abs(MODEL.simulate(fine)[::1000] - y)) < 1e-14


def test_an_output_beyond_saturation_asks_for_an_input_that_is_finite():
    asked = MODEL.inverse().simulate([0.0, 50.0, 0.0])
    assert np.all(np.isfinite(asked)) and asked[1] > 5.0


def test_without_weight_of_the_envelope_there_is_no_inverse():
    with pytest.raises(InvertibilityError, match="does not move"):
        GeneralisedPrandtlIshlinskii(0.0, [0.1], [1.0]).inverse()


@pytest.mark.parametrize("model", [MODEL, POINTS], ids=["tangent", "points"])
def test_identification_recovers_a_known_model_from_noisy_data(model):
    fit = identify_family(noisy(model), "generalised-pi")
    assert fit.test.rmse_percent < 0.6 and fit.invertible
    x = wander(2000, 9)
    known, found = model.simulate(x), fit.model.simulate(x)
    assert np.sqrt(np.mean((known - found) ** 2)) < 0.012 * np.ptp(known)


def test_a_seed_gives_the_same_model_and_is_reported():
    recording = noisy(MODEL, samples=1200)
    first, again = (identify_family(recording, "generalised-pi", seed=7) for _ in range(2))
    assert first.seed == 7 and first.model.parameters() == again.model.parameters()


def test_several_recordings_are_fitted_together():
    fit = identify_family([noisy(MODEL, seed=3, samples=1500), noisy(MODEL, seed=4, samples=1500)], "generalised-pi")
    assert len(fit.predictions) == 2 and fit.test.rmse_percent < 0.8


def test_loops_that_run_clockwise_are_refused():
    q = wander(2000)
    with pytest.raises(IdentificationError, match="clockwise"):
        identify_family(Recording(input=q, output=example("maxwell-slip").simulate(q)), "generalised-pi")


@pytest.mark.parametrize(
    "parameters",
    [
        {"thresholds": [0.1]},
        {"thresholds": [-0.1], "weights": [1.0]},
        {"shape": [1.0, -1.0, 0.0, 0.0]},
        {"shape": [1.0]},
        {"points_x": [0.0, 1.0], "points_g": [1.0, 0.0]},
        {"points_x": [0.0, 1.0], "points_g": [0.0, 1.0], "shape": [1.0, 1.0, 0.0, 0.0]},
        {"offset": float("inf")},
    ],
    ids=["sizes", "threshold", "falling-tangent", "short-shape", "falling-points", "both", "infinite"],
)
def test_bad_parameters_are_named(parameters):
    with pytest.raises(ParameterError):
        GeneralisedPrandtlIshlinskii(**parameters)


def test_the_plays_of_the_checks_are_plays():
    assert plays([0.0, 1.0, 0.0], [0.25], [0.0]).ravel().tolist() == [0.0, 0.75, 0.25]


@measured
def test_on_a_measured_log_it_is_near_the_best_plain_family():
    recording = log(*TENDON)
    assert held_out(recording, "generalised-pi") < 1.3 * dehyst.identify(recording).test.rmse_percent


def test_a_file_keeps_the_model_bit_for_bit(tmp_path):
    x, time = wander(300), uneven(300)
    again = dehyst.load(MODEL.save(tmp_path / "model.json"))
    assert np.array_equal(again.simulate(x, time), MODEL.simulate(x, time))
