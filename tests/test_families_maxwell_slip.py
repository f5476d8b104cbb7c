"""Springs with sliders: Masing, dissipation, the stop form, both ways round, dampers, what identification finds."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import dehyst
from dehyst import Recording
from dehyst.errors import InvertibilityError, ParameterError
from dehyst.families import UNSCALED, Stretch, Training, example, identify_family
from dehyst.families.maxwell_slip import MaxwellSlip, fit
from dehyst.identification.threads import single_blas
from family_checks import (
    CAVATAPPI,
    DAMPER,
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

MODEL = example("maxwell-slip")
SPRING = {"spring_places": [-0.5, 0.5], "spring_widths": [0.5, 0.5], "spring_stiffnesses": [0.2, 1.0]}
SLIDERS = {"thresholds": [0.05, 0.2, 0.5], "stiffnesses": [2.0, 1.0, 0.5]}
STIFFENING = MaxwellSlip(stiffness=0.3, **SPRING, **SLIDERS)
VISCOUS = MaxwellSlip(stiffness=0.3, **SLIDERS, speeds=[0.0, 0.5], dampings=[0.05, 0.4])
JOINT = MaxwellSlip(stiffness=0.5, **SPRING, **SLIDERS, position=True)
DAMPED_JOINT = MaxwellSlip(stiffness=0.5, **SLIDERS, speeds=[0.0], dampings=[0.05], position=True)


def stop_form():
    thresholds, stiffnesses = (np.insert(values, 0, 0.0) for values in (MODEL.thresholds, MODEL.stiffnesses))
    return dehyst.StopOperatorModel(thresholds, stiffnesses, MODEL.stiffness)


def test_it_is_the_stop_operator_model():
    x = wander()
    assert np.max(np.abs(MODEL.with_start("zero").simulate(x) - stop_form().simulate(x))) < 2e-15


def test_sliders_carry_their_coulomb_force():
    pulled = MODEL.simulate(np.linspace(0.0, 10.0, 101))[-1]
    assert abs(pulled - (MODEL.stiffness * 10.0 + MODEL.thresholds @ MODEL.stiffnesses)) < 1e-14


def test_curves_after_a_reversal_are_the_virgin_curve_doubled():
    """Masing's rule: from a turn at a to a - 2 b the force falls by twice what the virgin curve rises from 0 to b."""
    b = np.linspace(0.0, 0.8, 81)
    virgin = MODEL.simulate(b)
    down = MODEL.simulate(np.concatenate([b, 0.8 - 2.0 * b]))[81:]
    assert np.max(np.abs((virgin[-1] - down) - 2.0 * virgin)) < 1e-14


@given(st.lists(st.floats(-1.0, 1.0), min_size=2, max_size=12), st.sampled_from([MODEL, STIFFENING, VISCOUS]))
@settings(max_examples=40, deadline=None)
def test_closed_loops_cost_work(turns, model):
    way = [0.0, *turns, *turns, turns[0]]
    q = np.interp(np.linspace(0.0, len(way) - 1.0, 40 * len(way) - 39), np.arange(len(way)), way)
    f = model.simulate(q, 0.01 * np.arange(q.size))
    second = slice(40 * (1 + len(turns)), 40 * (1 + 2 * len(turns)) + 1)  # from turns[0] to turns[0] once more
    assert float(np.sum(f[second][1:] * np.diff(q[second]))) > -1e-12


@pytest.mark.parametrize("model", [MODEL, STIFFENING, VISCOUS, JOINT, DAMPED_JOINT], ids=str)
def test_it_is_undone_both_ways_round(model):
    x, time = wander(), uneven()
    assert round_trip(model, x, time) < (1e-12 if model.rate_dependent else 1e-14)
    assert same_in_parts(model, x, np.diff(time, prepend=time[0]) if model.rate_dependent else None)
    assert steps_like_arrays(model, x[:200], time[:200])


def test_a_position_without_dampers_is_the_inverse_of_the_stop_form():
    x = wander()
    joint = MaxwellSlip(stiffness=0.3, **SLIDERS, position=True, start="zero")
    assert np.max(np.abs(joint.simulate(x) - stop_form().inverse().simulate(x))) < 1e-13


def test_a_damper_saturates_at_its_speed():
    model = MaxwellSlip(stiffness=0.0, speeds=[2.0, 0.0], dampings=[1.0, 0.1])
    for speed, force in ((1.0, 1.1), (5.0, 2.5), (-5.0, -2.5)):
        assert abs(model.simulate([0.0, 0.1 * speed], [0.0, 0.1])[1] - force) < 1e-14
    assert not MODEL.rate_dependent and model.rate_dependent


def test_without_an_elastic_spring_there_is_no_inverse():
    with pytest.raises(InvertibilityError, match="no stiffness"):
        MaxwellSlip(stiffness=0.0, **SLIDERS).inverse()


@pytest.mark.parametrize("model", [MODEL, STIFFENING, VISCOUS], ids=["sliders", "spring", "dampers"])
def test_identification_recovers_a_known_force_from_noisy_data(model):
    found = identify_family(noisy(model), "maxwell-slip")
    assert not found.model.position and found.model.rate_dependent == model.rate_dependent
    assert found.test.rmse_percent < 0.6 and found.seed is None
    x, time = wander(2000, 9), 0.01 * np.arange(2000)
    known, found = model.simulate(x, time), found.model.simulate(x, time)
    assert np.sqrt(np.mean((known - found) ** 2)) < 0.012 * np.ptp(known)


@pytest.mark.parametrize("model", [JOINT, DAMPED_JOINT], ids=["sliders", "dampers"])
def test_identification_finds_a_position_over_a_force(model):
    found = identify_family(noisy(model, noise=1e-3), "maxwell-slip")
    assert found.model.position and found.test.rmse_percent < 3.0
    assert found.inverse_percent < 3.0


def test_several_recordings_without_time_are_fitted_together():
    signals = [wander(1000, 5), wander(1200, 6)]
    found = identify_family([Recording(input=x, output=MODEL.simulate(x)) for x in signals], "maxwell-slip")
    assert found.test.rmse_percent < 0.3 and not found.model.rate_dependent


def test_a_force_whose_wide_loop_seems_to_fall_is_found_with_its_sign():
    x, time = wander(2000), 0.01 * np.arange(2000)
    stretch = Stretch(x, -VISCOUS.simulate(x, time), np.diff(time, prepend=0.0), np.ones(2000, dtype=bool))
    training = Training((stretch,), UNSCALED, "counter-clockwise")
    with single_blas():
        model = fit(training)
    assert model.falling and training.rms(model) < 0.01
    with pytest.raises(InvertibilityError, match="other sign"):
        model.inverse()


@pytest.mark.parametrize("samples", [4, 6, 10])
@pytest.mark.filterwarnings("error")
def test_a_handful_of_samples_is_fitted_quietly(samples):
    x = np.sin(0.3 * np.arange(samples))
    late = np.sin(0.3 * np.arange(samples) - 0.1)
    found = identify_family(Recording(input=x, output=late, time=0.1 * np.arange(samples)), "maxwell-slip")
    assert np.isfinite(found.train.rmse)


@pytest.mark.parametrize(
    "parameters",
    [
        {"stiffness": -1.0},
        {"thresholds": [0.1]},
        {"thresholds": [0.1], "stiffnesses": [-1.0]},
        {"spring_places": [0.0]},
        {"offset": float("nan")},
    ],
    ids=["stiffness", "sizes", "negative", "spring-sizes", "nan"],
)
def test_bad_parameters_are_named(parameters):
    with pytest.raises(ParameterError):
        MaxwellSlip(**parameters)


@measured
def test_a_damper_on_a_shaking_table_is_its_case():
    recording = log(*DAMPER)
    assert held_out(recording, "maxwell-slip") < 0.45 * dehyst.identify(recording).test.rmse_percent


@measured
def test_a_fluidic_muscle_is_answered():
    found = identify_family(log(*CAVATAPPI), "maxwell-slip")
    assert found.test.rmse_percent < 15.0


def test_a_file_keeps_the_model_bit_for_bit(tmp_path):
    x, time = wander(300), uneven(300)
    again = dehyst.load(VISCOUS.save(tmp_path / "model.json"))
    assert np.array_equal(again.simulate(x, time), VISCOUS.simulate(x, time))
