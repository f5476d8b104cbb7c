"""Excitations: tips, holds, ends, rates, and that validation loops are not those of the fit."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dehyst.design import UNSEEN_TIPS, decaying_cycles, loops, triangle_sweep
from dehyst.errors import ParameterError
from dehyst_robot.arm import load_robot

PERIODS = st.sampled_from([0.001, 0.005, 0.01])


def turning_values(value):
    """Return the extrema of a signal, holds counted once."""
    steps = np.diff(value)
    moving = np.flatnonzero(np.abs(steps) > 1e-12)
    turns = moving[:-1][np.sign(steps[moving[:-1]]) != np.sign(steps[moving[1:]])]
    return value[turns + 1]


TIPS = st.lists(st.floats(-1.0, 1.0).map(lambda x: round(x, 2)), min_size=1, max_size=8).filter(
    lambda t: all(a != b for a, b in itertools.pairwise([0.0, *t, 0.0]))
)
STEEPEST = 35.0 / 16.0  # of a septic from 0 to 1


@given(tips=TIPS, loop=st.floats(2.0, 9.0), hold=st.floats(0.0, 0.8), period=PERIODS)
def test_loops_pass_their_tips_at_a_bounded_rate_and_end_at_zero(tips, loop, hold, period):
    time, value = loops(tips, loop, hold, period)
    stroke = loop / 2 - hold
    for k, tip in enumerate(tips):  # a hold begins after every stroke
        at = min(round(((k + 1) * stroke + k * hold) / period), value.size - 1)
        assert abs(value[at] - tip) < 200 * (period / stroke) ** 4 + 1e-12
    assert (
        value[0] == 0.0
        and value[-1] == 0.0
        and np.abs(value).max() <= np.abs(tips).max() * (1 + 1e-12)
    )
    longest = np.abs(np.diff([0.0, *tips, 0.0])).max()
    assert np.abs(np.diff(value)).max() / period <= STEEPEST * longest / stroke * (1 + 1e-9)
    assert np.allclose(np.diff(time), period) and time.shape == value.shape


def test_strokes_begin_and_end_without_acceleration_so_that_nothing_rings():
    _, value = loops([1.0], loop_s=8.0, hold_s=2.0, period=0.001)
    acceleration = np.diff(value, 2) / 0.001**2
    assert np.abs(acceleration[[0, 1999]]).max() < 0.01 * np.abs(acceleration).max()


def test_loops_hold_at_both_tips_for_as_long_as_asked():
    _, value = loops([1.0, -1.0, 0.5, -0.5], loop_s=10.0, hold_s=2.0, period=0.01)
    for tip in (1.0, -1.0, 0.5, -0.5):
        assert abs((np.abs(value - tip) < 1e-9).sum() * 0.01 - 2.0) <= 0.1


@given(decay=st.floats(0.3, 0.95), cycles=st.integers(1, 12), period=PERIODS)
def test_homing_dies_out_by_the_ratio_asked_for(decay, cycles, period):
    time, value = decaying_cycles(cycles, decay, 3.0, period)
    expected = np.sqrt(decay) ** np.arange(2 * cycles)
    found = turning_values(value)
    assert np.allclose(np.abs(found), expected, rtol=0, atol=(4 * period / 1.5) ** 2)
    assert (np.sign(found) == (-1.0) ** np.arange(2 * cycles)).all()
    assert value[0] == value[-1] == 0.0 and math.isclose(
        time[-1], 3.0 * cycles, abs_tol=1.001 * period
    )
    assert np.abs(np.diff(value)).max() / period <= STEEPEST * 2 / 1.5


@given(
    low=st.floats(-3, 0),
    span=st.floats(0.1, 4),
    rounding=st.floats(0.02, 0.5),
    start=st.floats(-3, 3),
)
def test_a_sweep_has_its_rate_and_no_corner(low, span, rounding, start):
    high, sweep, period = low + span, 40.0, 0.01
    _, value = triangle_sweep(sweep, period, low, high, rounding)
    rate = np.diff(value) / period
    peak = 2 * span / (sweep * (1 - rounding))
    assert (
        value[0] == value[-1] == low
        and np.isclose(value.max(), high)
        and value.min() >= low - 1e-12
    )
    assert np.abs(rate).max() <= peak * (1 + 1e-6)
    # raised cosine: the rate rises by v pi/(2 share T) a second at most
    assert (
        np.abs(np.diff(rate)).max() / period
        <= peak * np.pi / (2 * rounding * sweep / 2) * (1 + 1e-3) + 1e-6
    )
    share = np.mean(np.abs(np.abs(rate) - peak) < 1e-6 * peak)
    assert abs(share - (1 - 2 * rounding)) < 0.02
    if abs(start - low) > 0.1:
        _, way = triangle_sweep(sweep, period, low, high, rounding, start=start)
        assert way[0] == way[-1] == start
        assert np.abs(np.diff(way)).max() / period <= peak * (1 + 1e-6)


def test_up_and_down_of_a_sweep_mirror_each_other():
    _, value = triangle_sweep(10.0, 0.01, -1.0, 2.0)
    assert np.allclose(value, value[::-1], atol=1e-12)


def test_loops_for_the_test_of_a_fit_are_not_those_of_the_identification():
    settings = load_robot(conditions="kind").identification
    first = np.array([0.0, *settings.tips, 0.0])
    seen = [
        tuple(sorted(pair))
        for scale in (1.0, settings.second_share)
        for pair in itertools.pairwise(scale * first)
    ]
    tips = np.array(UNSEEN_TIPS)
    for pair in itertools.pairwise(tips):
        assert min(np.abs(np.subtract(sorted(pair), other)).max() for other in seen) > 0.02
    mids, halves = (tips[1:] + tips[:-1]) / 2, np.abs(np.diff(tips)) / 2
    assert mids.max() > 0.3 and mids.min() < -0.3  # biased to both sides
    assert halves.min() < 0.15 and halves.max() > 0.6  # minor and long ones
    assert np.unique(tips).size == tips.size and np.abs(tips).max() < 1


@pytest.mark.parametrize(
    ("call", "cure"),
    [
        (lambda: loops([], 4, 1, 0.1), "within -1..1"),
        (lambda: loops([1, math.nan], 4, 1, 0.1), "within -1..1"),
        (lambda: loops([1], 4, 2, 0.1), "more than 4 s"),
        (lambda: loops([1], 4, -1, 0.1), "zero or more"),
        (lambda: loops([1], 4, 1, 0), "period = 0"),
        (lambda: loops([1], 4, 1, 1.9), "shorter period"),
        (lambda: decaying_cycles(3, 1.0, 1, 0.01), "between 0 and 1"),
        (lambda: decaying_cycles(0, 0.5, 1, 0.01), "whole number"),
        (lambda: decaying_cycles(3, 0.5, -1, 0.01), "positive number"),
        (lambda: triangle_sweep(10, 0.1, 1, 1), "low < high"),
        (lambda: triangle_sweep(10, 0.1, 0, 1, 0.6), "share in"),
        (lambda: triangle_sweep(10, 0.1, 0, 1, start=math.inf), "finite"),
        (lambda: loops([1.2], 8, 0, 0.1), "within -1..1"),
        (lambda: loops([0.5, 0.5], 8, 0, 0.1), "two different ends"),
    ],
)
def test_what_excites_nothing_is_refused_with_the_cure(call, cure):
    with pytest.raises(ParameterError, match=cure):
        call()
