"""Kinds of strangers' logs that were answered wrongly: one wide loop, unlinked pieces, curves without memory."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
import numpy.typing as npt
import pytest

import dehyst

Array = npt.NDArray[np.float64]
Curve = Callable[[Array], Array]


def codes(fit: dehyst.Fit) -> set[str]:
    return {finding.code for finding in fit.warnings}


# --- one wide, clean loop, as a heating and cooling test or a magnetometer gives ------------------------------------

BRANCH = 150
FIRST = np.arange(2 * BRANCH - 1) < BRANCH


def stroke(begin: float, end: float) -> Array:
    """From begin to end and back, once."""
    return np.concatenate([np.linspace(begin, end, BRANCH), np.linspace(end, begin, BRANCH)[1:]])


def transition(x: Array, centre: float) -> Array:
    return np.asarray(1.3 / (1.0 + np.exp((x - centre) / 6.0)))


def alloy(begin: float, end: float) -> tuple[Array, Array]:
    """Strain of a shape memory alloy over its temperature: it changes 30 K higher while it is heated."""
    x = stroke(begin, end)
    cools = FIRST if begin > end else ~FIRST
    return x, np.where(cools, transition(x, 140.0), transition(x, 170.0))


def magnet(coercivity: float, width: float, slope: float) -> tuple[Array, Array]:
    """Moment over field, saturated at both ends."""
    x = stroke(1.0, -1.0)
    shift = np.where(FIRST, coercivity, -coercivity)
    return x, np.tanh((x + shift) / width) + slope * x


def played(x: Array, radius: float) -> Array:
    z = 0.0
    outputs = []
    for value in x.tolist():
        z = min(max(z, value - radius), value + radius)
        outputs.append(z)
    return np.array(outputs)


def plays() -> tuple[Array, Array]:
    """What every family of plays contains exactly."""
    x = stroke(1.0, -1.0)
    return x, np.sum([played(x, r) for r in (0.02, 0.2, 0.4, 0.6, 0.8)], axis=0)


ONE_LOOP = {
    "alloy, cooled first": (alloy(300.0, 40.0), 0.002),
    "alloy, heated first": (alloy(40.0, 300.0), 0.002),
    "magnet, narrow": (magnet(0.04, 0.08, 0.3), 0.001),
    "magnet, square": (magnet(0.3, 0.1, 0.0), 0.001),
    "plays": (plays(), 0.002),
}


def one_loop(name: str, loops: int = 1) -> dehyst.Recording:
    (x, y), noise = ONE_LOOP[name]
    x = np.concatenate([x, np.tile(x[1:], loops - 1)])
    y = np.concatenate([y, np.tile(y[1:], loops - 1)])
    return dehyst.Recording(x, y + noise * np.random.default_rng(1).standard_normal(x.size))


@pytest.mark.slow
@pytest.mark.parametrize("name", ONE_LOOP)
def test_one_wide_loop_is_hysteresis(name: str) -> None:
    fit = dehyst.identify(one_loop(name), train_fraction=1.0)
    assert fit.family != "static" and "no-hysteresis" not in codes(fit)
    assert fit.train.rmse < 0.7 * fit.static_train.rmse


@pytest.mark.parametrize("name", ["magnet, narrow", "magnet, square", "plays"])
def test_one_loop_of_a_kind_that_plays_can_show_is_met_to_its_noise(name: str) -> None:
    fit = dehyst.identify(one_loop(name), train_fraction=1.0)
    assert fit.train.rmse <= 1.2 * ONE_LOOP[name][1]


@pytest.mark.slow
@pytest.mark.parametrize("name", ONE_LOOP)
def test_the_same_loop_again_is_hysteresis_too(name: str) -> None:
    fit = dehyst.identify(one_loop(name, loops=2))
    assert fit.family != "static" and "no-hysteresis" not in codes(fit)
    assert fit.test is not None and fit.static_test is not None
    assert fit.test.rmse < 0.7 * fit.static_test.rmse


# --- pieces that nothing links --------------------------------------------------------------------------------------


def stopped(x: Array, radius: float) -> Array:
    z = last = 0.0
    outputs = []
    for value in x.tolist():
        z = min(max(z + value - last, -radius), radius)
        last = value
        outputs.append(z)
    return np.array(outputs)


def pieces(seed: int, count: int = 20, samples: int = 60) -> tuple[list[Array], list[Array]]:
    """Periods in their steady state, of five sizes: three stops on a cubic, as of a ferrite; 0.1 % noise."""
    rng = np.random.default_rng(seed)
    inputs, outputs = [], []
    for _ in range(count):
        size = rng.choice([0.05, 0.1, 0.2, 0.4, 1.0])
        periods = np.arange(samples) / samples * rng.choice([1, 2, 3])
        x = size * np.sin(2.0 * np.pi * (periods + rng.uniform()))
        thrice = np.tile(x, 3)
        stops = [w * stopped(thrice, r) for r, w in ((0.01, 6.0), (0.03, 3.0), (0.1, 1.5))]
        y = np.sum(stops, axis=0) + 0.5 * thrice + 2.0 * thrice**3
        inputs.append(x)
        outputs.append(y[-samples:])
    noise = 1e-3 * np.ptp(np.concatenate(outputs))
    return inputs, [y + noise * rng.standard_normal(samples) for y in outputs]


SEEDS = [
    *range(5),
    pytest.param(
        5,
        marks=pytest.mark.xfail(
            strict=True,
            reason="one piece of the largest size is fitted, and its memory is unknown: stop-sum, 9.24 % held out, "
            "where the curve misses 6.44 % and the same samples as 20 recordings 0.62 %",
        ),
    ),
]


@pytest.mark.slow
@pytest.mark.parametrize("seed", SEEDS)
def test_pieces_of_one_recording_are_followed_within_a_percent(seed: int) -> None:
    inputs, outputs = pieces(seed)
    ends = np.cumsum([x.size for x in inputs])[:-1].tolist()
    log = dehyst.Recording(np.concatenate(inputs), np.concatenate(outputs), breaks=ends)
    fit = dehyst.identify(log)
    assert fit.test is not None and fit.test.rmse_percent < 1.0
    assert fit.family != "static" and "no-hysteresis" not in codes(fit)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(6))
def test_pieces_as_recordings_are_followed_within_a_percent(seed: int) -> None:
    fit = dehyst.identify([dehyst.Recording(x, y) for x, y in zip(*pieces(seed), strict=True)])
    assert fit.test is not None and fit.test.rmse_percent < 1.0


# --- functions of the input, steep somewhere ------------------------------------------------------------------------

TURNS = (-1.0, 1.0, -1.0, 1.0, -1.0, 0.5, -0.7, 1.0, -1.0, 0.3, -0.3, 1.0, -0.5, 1.0, -1.0)


def strokes(samples: int = 60) -> Array:
    parts = [np.linspace(a, b, samples, endpoint=False) for a, b in pairwise(TURNS)]
    return np.concatenate([*parts, TURNS[-1:]])


CURVES: dict[str, Curve] = {
    "tanh(3x)": lambda x: np.tanh(3.0 * x),
    "tanh(10x)": lambda x: np.tanh(10.0 * x),
    "tanh(30x)": lambda x: np.tanh(30.0 * x),
    "tanh(30(x-0.4))": lambda x: np.tanh(30.0 * (x - 0.4)),
    "dead zone": lambda x: x - np.clip(x, -0.1, 0.1),
    "clipped": lambda x: np.clip(x, -0.5, 0.5),
    "log": lambda x: np.log10(1e-3 + (x + 1.0) / 2.0),
    "square root": lambda x: np.sqrt((x + 1.0) / 2.0),
    "fifth power": lambda x: x**5,
}


def without_memory(curve: Curve, seed: int, samples: int = 60) -> dehyst.Recording:
    """A function of the input with 0.1 % noise."""
    x = strokes(samples)
    y = curve(x)
    noise = 1e-3 * np.ptp(y) * np.random.default_rng(seed).standard_normal(x.size)
    time = np.arange(x.size) / 100.0
    return dehyst.Recording(x, y + noise, time)


@pytest.mark.slow
@pytest.mark.parametrize("name", CURVES)
def test_a_steep_function_of_the_input_is_no_hysteresis_and_no_rate(name: str) -> None:
    fit = dehyst.identify(without_memory(CURVES[name], 0))
    assert fit.family == "static" and "no-hysteresis" in codes(fit)
    assert fit.test is not None and fit.test.rmse_percent < 0.13
    assert "rate-dependent" not in codes(fit)


@pytest.mark.slow
@pytest.mark.parametrize("samples", [60, 120])
def test_a_straight_line_is_no_hysteresis(samples: int) -> None:
    for seed in range(3):
        fit = dehyst.identify(without_memory(lambda x: x, seed, samples))
        assert fit.family == "static"
