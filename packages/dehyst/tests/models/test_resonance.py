"""A shaped reference leaves no swing behind, never leaves its range, and is not late in the mean."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dehyst.errors import ParameterError
from dehyst.families import example
from dehyst.models import Resonance, load
from swings import second_order

PERIOD = 1e-3


def test_the_oracle_settles_and_overshoots_as_the_formula_says():
    y = second_order(np.r_[0.0, np.ones(4000)], 10.0, 0.1, PERIOD)
    assert y[-1] == pytest.approx(1.0, abs=1e-9)
    assert y.max() == pytest.approx(1.0 + np.exp(-np.pi * 0.1 / np.sqrt(0.99)), abs=1e-3)


@pytest.mark.parametrize("damping", [0.0, 0.02, 0.2, 0.5])
@pytest.mark.parametrize("samples", [4, 25, 50])
def test_two_swings_cancel(samples, damping):
    frequency = 0.5 / (
        samples * PERIOD * np.sqrt(1.0 - damping**2)
    )  # half a swing is whole samples
    resonance = Resonance(frequency, damping)
    step = np.r_[np.zeros(10), np.ones(600)]
    time = PERIOD * np.arange(step.size)
    plain = second_order(step, frequency, damping, PERIOD)
    shaped = second_order(resonance.shaped(step, time, 0.0), frequency, damping, PERIOD)
    after = slice(10 + samples + 2, None)
    swing = max(np.ptp(plain[after]), 1e-3)
    assert np.abs(shaped[after] - 1.0).max() < 1e-9 * swing + 1e-12


@pytest.mark.parametrize("off", [0.9, 1.1])
def test_a_frequency_that_is_a_tenth_off_leaves_a_sixth_of_the_swing(off):
    """Singer and Seering: the residual of two impulses is |cos(pi f / 2 f0)| without damping."""
    step = np.r_[np.zeros(10), np.ones(600)]
    time = PERIOD * np.arange(step.size)
    shaped = Resonance(10.0, 0.0).shaped(step, time, 0.0)
    left = np.abs(second_order(shaped, 10.0 * off, 0.0, PERIOD)[200:] - 1.0).max()
    assert left == pytest.approx(abs(np.cos(0.5 * np.pi * off)), abs=0.01)
    assert left < 0.16


@given(
    st.lists(st.floats(-1e6, 1e6), min_size=2, max_size=60),
    st.floats(1.0, 400.0),
    st.floats(0.0, 0.69),
)
def test_a_shaped_reference_stays_within_its_range(values, frequency, damping):
    reference = np.array(values)
    shaped = Resonance(frequency, damping).shaped(reference, PERIOD * np.arange(reference.size))
    slack = 1e-9 * max(1.0, np.abs(reference).max())
    assert reference.min() - slack <= shaped.min() and shaped.max() <= reference.max() + slack


@pytest.mark.parametrize("damping", [0.0, 0.1, 0.4])
def test_a_ramp_is_not_late(damping):
    time = PERIOD * np.arange(1000)
    shaped = Resonance(12.5, damping).shaped(3.0 * time, time)
    np.testing.assert_allclose(shaped[100:-100], 3.0 * time[100:-100], atol=1e-9)


def test_with_fewer_than_two_samples_in_half_a_swing_nothing_is_shaped():
    reference, time = np.array([0.0, 0.0, 1.0, 1.0, 0.0]), PERIOD * np.arange(5)
    assert Resonance(400.0, 0.0).samples(PERIOD) == 0
    assert np.array_equal(Resonance(400.0, 0.0).shaped(reference, time), reference)


@pytest.mark.parametrize(
    "pair", [(0.0, 0.1), (-1.0, 0.1), (5.0, 0.7), (5.0, -0.1), (np.nan, 0.1), (5.0, np.inf)]
)
def test_what_does_not_ring_is_refused(pair):
    with pytest.raises(ParameterError):
        Resonance(*pair)


@pytest.mark.parametrize("value", [5.0, "5", (5.0,), (1.0, 2.0, 3.0), object()])
def test_a_resonance_that_is_no_pair_is_refused_with_what_to_pass(value):
    with pytest.raises(ParameterError, match="frequency in Hz and its damping"):
        replace(example("full-sum"), resonance=value)


def test_a_resonance_is_saved_with_its_model_and_loaded_to_the_bit(tmp_path):
    model = replace(example("full-sum"), resonance=(7.3, 0.031))
    model.save(tmp_path / "m.json")
    assert load(tmp_path / "m.json").resonance == Resonance(7.3, 0.031)
    example("full-sum").save(tmp_path / "plain.json")
    assert load(tmp_path / "plain.json").resonance is None


def test_lead_is_the_dead_time_and_half_of_half_a_swing():
    model = replace(example("full-sum"), resonance=(5.0, 0.0), dead_time=0.1, period=0.01)
    assert model.lead(0.01) == pytest.approx(0.1 + 0.05)
    assert model.lead(0.1) == pytest.approx(0.1)  # too slow to shape
    reference = np.r_[np.zeros(50), np.ones(50)]
    assert np.array_equal(
        model.shaped(reference), model.resonance.shaped(reference, 0.01 * np.arange(100))
    )
    assert replace(model, resonance=None).shaped(reference) is reference
