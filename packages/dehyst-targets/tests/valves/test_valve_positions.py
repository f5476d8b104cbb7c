"""Positions of sticking valves, against closed forms and the models of examples/simulators/valve_loop.py."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dehyst_targets.valves import valve_positions
from dehyst_targets.valves._moves import read_off_valves
from simulated_loops import simulator


def wander(seed, size=400):
    """A controller output that turns at random."""
    rng = np.random.default_rng(seed)
    return 50.0 + np.cumsum(rng.normal(size=size))


def path(signal, dead_band, jump, **more):
    return valve_positions(signal, np.array([dead_band]), np.array([jump]), **more)[:, 0]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("model", "moves_on"), [("choudhury", True), ("kano", True), ("he", False)]
)
@given(seed=st.integers(0, 200))
def test_after_a_large_swing_a_valve_is_that_of_the_literature(model, moves_on, seed):
    # A ramp up and down by more than the dead band forgets how each began.
    signal = np.concatenate(
        (np.linspace(50.0, 90.0, 301), np.linspace(90.0, 30.0, 451), wander(seed) - 20.0)
    )
    valve = simulator()["VALVES"][model](4.0, 1.5, 1.0, 50.0)
    theirs = np.array([valve.step(float(u)) for u in signal])
    ours = path(signal, 4.0, 1.5, moves_on=moves_on)
    assert np.allclose(ours[400:], theirs[400:], atol=1e-9)


@pytest.mark.slow
@given(seed=st.integers(0, 200), dead_band=st.floats(0.0, 6.0))
def test_without_a_jump_it_is_a_play_of_the_width_of_the_dead_band(seed, dead_band):
    signal = wander(seed)
    play = np.empty(signal.size)
    x = signal[0]
    for k, u in enumerate(signal):
        x = min(max(x, u - 0.5 * dead_band), u + 0.5 * dead_band)
        play[k] = x
    for moves_on in (True, False):
        assert np.allclose(path(signal, dead_band, 0.0, moves_on=moves_on), play, atol=1e-9)


@pytest.mark.slow
@given(seed=st.integers(0, 200), ratio=st.floats(0.0, 1.0))
def test_friction_never_holds_more_than_static_friction(seed, ratio):
    signal = wander(seed)
    for moves_on in (True, False):
        force = signal - path(signal, 4.0, 4.0 * ratio, moves_on=moves_on)
        assert np.abs(force).max() <= 2.0 * (1.0 + ratio) + 1e-9


def test_a_ramp_that_turns_goes_the_dead_band_before_the_valve_jumps():
    up, down = np.arange(0.0, 20.0, 0.01), np.arange(20.0, 10.0, -0.01)
    moved = path(np.concatenate((up, down)), 4.0, 1.5)[up.size :]
    first = int(np.flatnonzero(np.diff(moved))[0]) + 1
    assert 20.0 - down[first] == pytest.approx(4.0, abs=0.02)
    assert moved[first - 1] - moved[first] == pytest.approx(1.5, abs=0.02)


@pytest.mark.slow
@pytest.mark.parametrize("moves_on", [True, False])
@pytest.mark.parametrize("gain", [1.0, -0.16])
@given(seed=st.integers(0, 200), share=st.floats(0.2, 1.0))
def test_moves_tell_dead_band_and_jump_whatever_the_unit_of_the_position(
    moves_on, gain, seed, share
):
    signal = 50.0 + 8.0 * np.sin(0.05 * np.arange(2500)) + 0.1 * (wander(seed, 2500) - 50.0)
    position = gain * path(signal, 5.0, 5.0 * share, moves_on=moves_on) + 4.0
    valves = read_off_valves(signal, position)
    assert len(valves) == 2
    # A single sample is right even where the valve goes on after its jump.
    assert valves[1] == pytest.approx((5.0, 5.0 * share), abs=0.25)


def test_a_valve_that_seldom_moves_tells_nothing():
    signal = np.linspace(40.0, 60.0, 500)
    assert read_off_valves(signal, path(signal, 15.0, 10.0)) == []
