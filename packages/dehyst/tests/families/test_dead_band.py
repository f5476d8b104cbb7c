"""Dead band of a model: twice the smallest threshold that carries weight, at any scale, of any family that has one."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import dehyst
from dehyst.families import dead_band
from dehyst.models import ModelCard, SignalCard


def carded(model, low=0.0, high=10.0):
    """The model with a range of its input."""
    card = ModelCard(SignalCard("x", "bar", low, high), SignalCard("y", "mm", 0.0, 1.0))
    return model.with_card(card)


@given(st.floats(0.1, 2.0), st.floats(0.2, 5.0), st.floats(-50.0, 50.0), st.floats(1e-3, 1e3))
def test_it_is_twice_the_smallest_threshold_with_weight(first, weight, low, scale):
    r = scale * np.array([0.0, first, first + 0.5])
    model = dehyst.PrandtlIshlinskii(r, [1e-3 * weight, weight, weight])
    band = dead_band(carded(model, scale * low, scale * (low + 10.0)))
    # Half of the range has a thousand samples.
    assert band.width == pytest.approx(2 * scale * first, abs=scale * 0.011)
    assert band.percent == pytest.approx(20 * first, abs=0.11)


@pytest.mark.parametrize(
    "model",
    [
        dehyst.PrandtlIshlinskii([0.0, 1.0], [1.0, 1.0]),
        dehyst.PrandtlIshlinskii([0.04, 1.0], [1.0, 1.0]),  # below 1 % of the range
        dehyst.StopOperatorModel([0.0, 1.0], [0.0, 1.0], 0.0),
    ],
    ids=["a play without width", "a narrow play", "friction"],
)
def test_what_answers_at_once_has_none(model):
    assert dead_band(carded(model)) is None


def test_without_a_range_nobody_can_tell():
    assert dead_band(dehyst.PrandtlIshlinskii([1.0], [1.0])) is None


def test_a_play_wider_than_the_range_has_no_band_that_could_be_told():
    assert dead_band(carded(dehyst.PrandtlIshlinskii([8.0], [1.0]))) is None


def test_saturation_at_the_ends_is_no_dead_band():
    plays = dehyst.PrandtlIshlinskii([0.0, 0.5], [0.5, 0.5])
    flat = dehyst.MonotoneMap([0.0, 3.0, 7.0, 10.0], [0.0, 0.01, 0.99, 1.0])
    assert dead_band(carded(dehyst.ModifiedPrandtlIshlinskii(plays, after_map=flat))) is None
