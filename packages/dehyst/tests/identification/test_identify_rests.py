"""Creep that no rest of a log was long enough for is told, with the rest to log."""

import re

import numpy as np
import pytest

import dehyst
from dehyst.identification._evidence import beyond_rests


def lagged(x, time, tau):
    """A lag of first order behind an input that is held."""
    level, out = x[0], np.empty(x.size)
    for k, step in enumerate(np.diff(time, prepend=time[0])):
        out[k] = level = x[k] + (level - x[k]) * np.exp(-step / tau)
    return out


def test_the_creep_beyond_the_longest_rest_is_that_of_a_lag_behind_a_relay():
    t = 0.02 * np.arange(6000)
    relay = np.where(t % 6.0 < 3.0, 1.0, -1.0)
    (told,) = beyond_rests(relay, t, lambda x, at: x + 0.5 * lagged(x, at, 20.0), 2.0)
    numbers = r"by ([\d.]+) % .* first ([\d.]+) s.* log a rest of ([\d.]+) s; .*--hold ([\d.]+)`"
    size, rest, least, hold = map(float, re.findall(numbers, told.message)[0])
    known = (
        25.0 * (1.0 + np.tanh(3.0 / 40.0)) * (np.exp(-3.0 / 20.0) - np.exp(-120.0 / 20.0))
    )  # steady oscillation
    assert told.code == "creep-beyond-rests" and rest == 3.0 and abs(size - known) < 0.5
    assert (
        hold == least and abs(least - 1.05 * (3.0 + 20.0 * np.log(10.0))) < 2.0
    )  # nine tenths of it, and a little


def test_creep_within_the_rests_and_motion_that_never_turns_are_not_told():
    t = 0.02 * np.arange(6000)
    relay = np.where(t % 6.0 < 3.0, 1.0, -1.0)
    assert not list(beyond_rests(relay, t, lambda x, at: x + 0.5 * lagged(x, at, 0.8), 2.0))
    assert not list(beyond_rests(t, t, lambda x, at: x + 0.5 * lagged(x, at, 20.0), 2.0))


@pytest.mark.slow
def test_short_cycles_of_an_actuator_that_creeps_slowly_are_told_and_long_rests_are_not():
    t = 0.05 * np.arange(4800)
    plays, noise = (
        dehyst.PrandtlIshlinskii([0.0, 0.4], [1.0, 0.4]),
        np.random.default_rng(3).standard_normal(t.size),
    )
    cycles = np.sin(0.5 * np.pi * t) * (1 - 0.3 * np.sin(0.05 * t))
    tips = np.array([0.0, 1.0, -0.6, 0.3, -1.0])[np.minimum(t // 48.0, 4).astype(int)]
    rests = np.convolve(np.concatenate([np.zeros(39), tips]), np.ones(40) / 40, "valid")
    for x, there in ((cycles, True), (rests, False)):
        y = plays.simulate(x)
        fit = dehyst.identify(
            dehyst.Recording(x, y + 0.4 * lagged(y, t, 12.0) + 1e-3 * noise, t), "creep-pi"
        )
        assert ("creep-beyond-rests" in {finding.code for finding in fit.warnings}) == there
