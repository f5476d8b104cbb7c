"""Claims about an input whose sensor is at the end of its range, and about inputs that really rest there."""

import numpy as np
import pytest

import dehyst
from dehyst.data._clipping import clipped
from dehyst.io import example_recording, read_log, write_csv


def lagging(v, share):
    out, z = np.empty_like(v), float(v[0])
    for k, value in enumerate(v.tolist()):
        z += (value - z) * share
        out[k] = z
    return out


def actuator(rng, x):
    """Hysteresis, weak or strong; with creep, a lag or saturation; rising or falling; with noise."""
    strength = rng.choice([0.1, 0.3, 0.6])
    y = dehyst.PrandtlIshlinskii(
        [0.0, 0.1, 0.3, 0.8], [1.0, strength, strength, strength]
    ).simulate(x)
    kind = rng.integers(4)
    if kind == 1:
        y = y + 0.15 * lagging(y, 0.003)
    if kind == 2:
        y = lagging(y, rng.choice([0.1, 0.3]))
    if kind == 3:
        y = np.tanh(y)
    return rng.choice([-1.0, 1.0]) * y + rng.choice([0.0, 1e-3, 5e-3]) * np.ptp(y) * rng.normal(
        size=y.size
    )


def moving(rng, n):
    """Motions that never rest."""
    t = np.arange(n)
    wave = np.sin(t * 2.0 * np.pi / rng.uniform(150.0, 600.0))
    turns = rng.uniform(0.5, 1.0, n // 150) * np.resize([1.0, -1.0], n // 150)
    return [
        wave,
        wave * (0.75 + 0.25 * np.cos(t * 2.0 * np.pi / n * rng.uniform(0.5, 2.0))),
        np.interp(t, np.linspace(0, n - 1, turns.size), turns),
        0.6 * wave + 0.4 * np.sin(t * 2.0 * np.pi / rng.uniform(90.0, 250.0)),
    ][rng.integers(4)]


def resting(rng, n):
    """Motions that rest at their extremes: holds, steps, a staircase, an actuator that knows one side only."""
    wave = np.sin(np.arange(n) * 2.0 * np.pi / rng.uniform(150.0, 700.0))
    up = np.linspace(-1.0, 1.0, 80)
    hold = np.ones(rng.integers(20, 200))
    return [
        np.clip(rng.uniform(1.2, 3.0) * wave, -1.0, 1.0),
        np.sign(wave),
        np.maximum(0.0, wave),
        np.repeat(rng.choice([-1.0, -0.5, 0.0, 0.5, 1.0], n // 100), 100),
        np.round(4.0 * wave) / 4.0,
        np.resize(np.concatenate([up, hold, up[::-1], -hold]), n),
    ][rng.integers(6)]


def clip(rng, x):
    share, low, high = rng.uniform(0.05, 0.3) * np.ptp(x), x.min(), x.max()
    lower, upper = [(low + share, high), (low, high - share), (low + share, high - share)][
        rng.integers(3)
    ]
    return np.clip(x, lower, upper)


@pytest.mark.parametrize(
    "seeds", [range(40), pytest.param(range(1000, 1400), marks=pytest.mark.slow)]
)
def test_a_clipped_input_is_found_and_one_that_rests_is_left_alone(seeds):
    missed = []
    for seed in seeds:
        rng = np.random.default_rng(seed)
        n = int(rng.choice([1800, 6000]))
        x = moving(rng, n)
        y = actuator(rng, x)
        read = x + rng.choice([0.0, 1e-3]) * rng.normal(size=n)
        assert clipped(read, y) == (), seed
        missed += [seed] * (not clipped(clip(rng, read), y))
        held = resting(rng, n)
        assert clipped(held, actuator(rng, held)) == (), seed
    # Where a lag or a wide loop brings the output back after the input has left its end, it looks like a hold.
    assert len(missed) <= 0.15 * len(seeds)


@pytest.mark.parametrize("bounds", [(-3.5, 3.5), (-3.5, 99.0), (-99.0, 3.25)])
def test_both_doors_say_it_once(tmp_path, bounds):
    record = example_recording()
    x = np.clip(record.input, *bounds)
    log = write_csv(
        tmp_path / "log.csv", {"time_s": record.time, "pressure_bar": x, "angle_deg": record.output}
    )
    read = read_log(log, "pressure", "angle")
    for fit in (
        dehyst.identify(read, "pi", n=20),
        dehyst.identify(dehyst.Recording(x, record.output), "pi", n=20),
    ):
        [finding] = [finding for finding in fit.warnings if finding.code == "saturated-input"]
        for bound in bounds:
            assert (f" {bound:g} " in finding.message) == (abs(bound) < 4.0)


def test_the_example_is_not_saturated():
    record = example_recording()
    assert clipped(record.input, record.output) == ()
