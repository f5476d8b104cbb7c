"""Creep beside plays: the exact step, log(t), the explicit inverse and when it is stable, identification."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import dehyst
from dehyst import Recording
from dehyst.errors import DehystError, IdentificationError, InvertibilityError, ParameterError
from dehyst.families import example, identify_family
from dehyst.families.creep_pi import CreepPrandtlIshlinskii
from family_checks import (
    ARM,
    DAMPER,
    PIEZO,
    held_out,
    log,
    measured,
    noisy,
    round_trip,
    same_in_parts,
    steps_like_arrays,
    uneven,
    wander,
)

MODEL = example("creep-pi")


def creep_only(constants, thresholds=0.0):
    count = np.size(constants)
    return CreepPrandtlIshlinskii(
        weights=[0.0],
        creep_thresholds=np.full(count, thresholds),
        time_constants=constants,
        creep_weights=np.ones(count),
        start="zero",
    )


def test_without_creep_it_is_the_plain_operator():
    r, w = np.array([0.0, 0.2, 0.5]), np.array([0.4, 0.2, 0.3])
    plain = dehyst.PrandtlIshlinskii(thresholds=r, weights=w, offset=0.25)
    x = wander()
    mine = CreepPrandtlIshlinskii(thresholds=r, weights=w, offset=0.25, start="zero").simulate(x, uneven())
    assert np.max(np.abs(mine - plain.simulate(x))) < 1e-15


def test_a_linear_creep_is_a_lag_whatever_the_steps_of_time():
    time = np.concatenate([[0.0, 1e-3], np.cumsum(np.random.default_rng(5).uniform(1e-4, 3.0, 50)) + 1e-3])
    y = creep_only([2.0]).simulate(np.where(time > 0.0, 1.0, 0.0), time)
    assert np.max(np.abs(y[1:] - (1.0 - np.exp(-(time[1:] - 1e-3) / 2.0)))) < 1e-14


def test_equal_weights_on_a_geometric_row_give_one_unit_a_decade():
    time = np.concatenate([[0.0, 1e-9], np.geomspace(1.0, 1e4, 401) + 1e-9])  # a hundred samples a decade
    y = creep_only(10.0 ** np.arange(-2, 8)).simulate(np.where(time > 0.0, 1.0, 0.0), time)[2:]
    decade = y[100:] - y[:-100]
    assert np.max(np.abs(decade[:200] - 1.0)) < 2e-4  # the row ends at 1e7 s


def test_creep_with_a_threshold_stops_that_far_from_the_input():
    time = np.concatenate([[0.0], np.linspace(1.0, 100.0, 400)])
    y = creep_only([1.0], 0.3).simulate(np.where(time > 0.0, 1.0, 0.0), time)
    assert abs(y[-1] - 0.7) < 1e-12 and np.all(y <= 0.7 + 1e-15)


@given(st.integers(0, 10**6))
@settings(max_examples=20, deadline=None)
def test_the_explicit_inverse_undoes_it(seed):
    assert round_trip(MODEL, wander(400, seed), uneven(400, seed)) < 3e-15


def test_the_inverse_undoes_a_map_too():
    model = CreepPrandtlIshlinskii(
        [0.0, 0.3], [0.5, 0.3], [0.0], [0.5], [0.2], 0.1, [-2.0, -0.5, 0.4, 2.0], [-1.5, -0.8, 0.7, 1.2]
    )
    assert round_trip(model, wander(), uneven()) < 1e-14


def test_parts_and_steps_are_the_whole_bit_for_bit():
    x, time = wander(), uneven()
    assert same_in_parts(MODEL, x, np.diff(time, prepend=time[0]))
    assert steps_like_arrays(MODEL, x[:300], time[:300])


def test_creep_faster_than_the_sampling_has_no_inverse_and_says_so():
    fast = CreepPrandtlIshlinskii([0.0], [0.02], [0.0], [0.01], [0.9], period=0.01)
    with pytest.raises(InvertibilityError, match="creep is too fast"):
        fast.inverse()


def test_without_weight_of_the_input_there_is_no_inverse():
    with pytest.raises(InvertibilityError, match="does not move"):
        CreepPrandtlIshlinskii([0.1], [1.0]).inverse()


def test_the_inverse_of_an_identified_delay_does_not_oscillate():
    """Half of the output comes one sample late: a fit that looked at the output alone could not be undone."""
    x = wander(3000)
    late = 0.1 * x + 0.9 * np.concatenate([x[:1], x[:-1]])
    fit = identify_family(Recording(input=x, output=late, time=0.01 * np.arange(3000)), "creep-pi")
    rng = np.random.default_rng(0)
    disturbed = fit.model.inverse().simulate(late + 1e-3 * rng.standard_normal(3000), 0.01 * np.arange(3000))
    assert np.max(np.abs(disturbed - x)) < 0.2


def test_identification_recovers_a_known_model_from_noisy_data():
    recording = noisy(MODEL)
    fit = identify_family(recording, "creep-pi")
    assert fit.test.rmse_percent < 0.35  # the noise is 0.2 %
    assert fit.seed is None and fit.invertible
    x = wander(2000, 9)
    time = 0.01 * np.arange(2000)
    known, found = MODEL.simulate(x, time), fit.model.simulate(x, time)
    assert np.sqrt(np.mean((known - found) ** 2)) < 0.012 * np.ptp(known)


def test_several_recordings_are_fitted_together():
    fit = identify_family([noisy(MODEL, seed=3), noisy(MODEL, seed=4)], "creep-pi")
    assert len(fit.predictions) == 2 and fit.test.rmse_percent < 0.5


def test_loops_that_run_clockwise_are_refused():
    q = wander(2000)
    force = dehyst.families.example("maxwell-slip").simulate(q)
    with pytest.raises(IdentificationError, match="clockwise"):
        identify_family(Recording(input=q, output=force, time=0.01 * np.arange(2000)), "creep-pi")


def test_a_recording_without_time_is_refused():
    x = wander()
    with pytest.raises(DehystError, match="time"):
        identify_family(Recording(input=x, output=x**3 + x), "creep-pi")


@pytest.mark.parametrize(
    "parameters",
    [
        {"weights": [1.0, 2.0]},
        {"thresholds": [0.0, 0.0], "weights": [1.0, 1.0]},
        {"weights": [-1.0]},
        {"weights": [np.nan]},
        {"creep_thresholds": [0.0], "time_constants": [0.0], "creep_weights": [1.0]},
        {"creep_thresholds": [0.0], "time_constants": [1.0]},
        {"map_inner": [0.0, 1.0], "map_outer": [1.0, 0.0]},
        {"map_inner": [0.0], "map_outer": [1.0]},
    ],
    ids=["sizes", "equal-thresholds", "negative", "nan", "no-time", "creep-sizes", "falling-map", "one-point"],
)
def test_bad_parameters_are_named(parameters):
    with pytest.raises(ParameterError):
        CreepPrandtlIshlinskii(**parameters)


def test_bad_signals_are_named():
    with pytest.raises(ParameterError, match="not finite"):
        MODEL.simulate([0.0, np.nan], [0.0, 1.0])
    with pytest.raises(ParameterError, match="time"):
        MODEL.simulate([0.0, 1.0])


@measured
def test_on_measured_logs_it_betters_the_plain_families():
    for name, bound in ((ARM, 0.75), (PIEZO, 0.75)):
        recording = log(*name)
        assert held_out(recording, "creep-pi") < bound * dehyst.identify(recording).test.rmse_percent


@measured
def test_a_damper_is_refused_with_the_reason():
    with pytest.raises(IdentificationError, match="clockwise"):
        identify_family(log(*DAMPER), "creep-pi")


def test_a_file_keeps_the_model_bit_for_bit(tmp_path):
    x, time = wander(300), uneven(300)
    again = dehyst.load(MODEL.save(tmp_path / "model.json"))
    assert np.array_equal(again.simulate(x, time), MODEL.simulate(x, time))
