"""Claims about one false value that comes again and again within the range of a signal, such as 0 of a lost packet."""

import numpy as np
import pytest

import dehyst
from dehyst.data import find_outliers

PLAYS = dehyst.PrandtlIshlinskii([0.0, 0.3, 0.8], [1.0, 0.5, 0.4])


def loops(rng, n):
    turns = rng.uniform(-1.0, 1.0, rng.integers(8, 25))
    turns[1::2] = -np.abs(turns[1::2])
    return np.interp(np.arange(n), np.linspace(0, n - 1, turns.size), turns)


def motion(rng, n):
    """A motion that passes 0, or rests there or at its ends."""
    t, period = np.arange(n), rng.uniform(200.0, 900.0)
    wave = np.sin(t * 2.0 * np.pi / period)
    return [
        lambda: wave * np.linspace(1.0, 0.3, n),
        lambda: loops(rng, n),
        lambda: wave * np.cos(t / rng.uniform(500.0, 3000.0)),
        lambda: np.maximum(0.0, wave),
        lambda: 1.0 + loops(rng, n),
        lambda: np.clip(1.5 * wave, -1.0, 1.0),
    ][rng.integers(6)]()


def signal(rng):
    """The motion or what it moves, with noise, in any unit, from a converter or not."""
    n = int(rng.choice([2000, 5000, 7200]))
    x = motion(rng, n)
    v = x if rng.random() < 0.5 else PLAYS.simulate(x)
    v = rng.choice([1.0, 4.2, 30.0, 1000.0]) * (
        v + rng.choice([0.0, 1e-3, 3e-3]) * np.ptp(v) * rng.normal(size=n)
    )
    if rng.random() < 0.4:
        step = np.ptp(v) / 2 ** rng.choice([8, 10, 12])
        v = np.round(v / step) * step
    return v


def with_false_values(rng, v):
    """The signal with runs of one value, evenly or not, and where they are."""
    n, length = v.size, int(rng.integers(1, 9))
    count = max(1, round(rng.choice([0.0005, 0.002, 0.006, 0.008, 0.01, 0.02]) * n / length))
    grid = np.arange(30, n - 20, length + 12)
    begins = (
        grid[:: max(1, grid.size // count)]
        if rng.random() < 0.5
        else rng.choice(grid, count, replace=False)
    )
    value = rng.choice(
        [0.0, rng.uniform(v.min(), v.max()), v.max(), 1.2 * np.abs(v).max(), 3.0 * np.abs(v).max()]
    )
    false = np.zeros(n, dtype=bool)
    for begin in begins:
        false[begin : begin + length] = True
    return np.where(false, value, v), false


def counts(seeds):
    """Signals in which a false value that is off by more than a twentieth of the range stays, or a true one is lost."""
    missed, lost, alarms = [], [], []
    for seed in seeds:
        rng = np.random.default_rng(seed)
        v = signal(rng)
        alarms += [seed] * bool(find_outliers(v).any())
        spoilt, false = with_false_values(rng, v)
        found = find_outliers(spoilt)
        felt = np.abs(spoilt - v) > 0.05 * np.ptp(v)
        missed += [seed] * bool(np.any(felt & ~found))
        lost += [seed] * bool(np.any(found & ~false))
    return missed, lost, alarms


@pytest.mark.parametrize(
    "seeds", [range(30), pytest.param(range(1000, 1600), marks=pytest.mark.slow)]
)
def test_false_values_are_found_and_signals_left_alone(seeds):
    missed, lost, alarms = counts(seeds)
    assert (lost, alarms) == ([], [])
    # One or two runs, or a value that few of them are far from, may be the signal: of these some are missed.
    assert len(missed) <= 0.12 * len(seeds)


@pytest.mark.spread(4)
@pytest.mark.parametrize("every", [300, 600, 900, 1800])
@pytest.mark.parametrize("role", ["input", "output"])
def test_runs_of_zeros_are_left_out_of_a_fit(every, role):
    t = np.arange(7200) * 0.02
    x = 4.2 * np.sin(0.6 * t) * np.cos(0.05 * t)
    parts = {"input": x, "output": 7.0 * PLAYS.simulate(x), "time": t}
    false = (np.arange(7200) % every < 5) & (np.arange(7200) > 50)
    spoilt = dehyst.Recording(**(parts | {role: np.where(false, 0.0, parts[role])}))
    fit = dehyst.identify(spoilt, "pi", n=20)
    assert "outlier" in [finding.code for finding in fit.warnings]
    clean = dehyst.identify(dehyst.Recording(**parts), "pi", n=20)
    error = np.sqrt(np.mean((fit.model.simulate(x) - clean.model.simulate(x)) ** 2)) / np.ptp(
        parts["output"]
    )
    assert error < 2e-3


def test_single_zeros_in_the_input_are_found():
    t = np.arange(7200) * 0.02
    x = 4.2 * np.sin(0.6 * t) * np.cos(0.05 * t)
    false = np.arange(7200) % 400 == 77
    found = find_outliers(np.where(false, 0.0, x))
    assert not (found & ~false).any()
    assert np.abs(x[false & ~found]).max(initial=0.0) < 0.1


def test_pulses_steps_and_rests_are_a_signal():
    t = np.arange(6000)
    rng = np.random.default_rng(3)
    pulses = np.where(t % 500 < 6, 5.0, 0.01 * rng.normal(size=t.size))
    kicks = np.where(t % 500 < 6, 5.0, np.floor(t / 500) * 0.02)  # before each step of a staircase
    steps = rng.choice([0.0, 1.0, 2.0, 3.0], 60).repeat(100)
    vented = np.where(t % 100 < 40, 0.0, steps)
    dead = np.where(
        np.abs(np.sin(t / 90)) < 0.4, 0.0, np.sin(t / 90)
    )  # a dead zone, with a jump at its ends
    for v in (pulses, kicks, steps, vented, dead):
        assert not find_outliers(v).any()
