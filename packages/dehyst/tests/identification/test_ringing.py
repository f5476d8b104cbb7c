"""A resonance is told where the output rings when it moves, and nowhere else."""

from dataclasses import replace

import numpy as np
import pytest

import dehyst
from dehyst import PrandtlIshlinskii
from dehyst.errors import ParameterError
from dehyst.identification._ringing import ringing
from dehyst.models import Resonance
from swings import second_order

PERIOD = 0.01
TIME = PERIOD * np.arange(6000)
LOOP = PrandtlIshlinskii([0.0, 0.2, 0.5], [1.0, 0.4, 0.2])
RING = (6.0, 0.03)
TRIANGLE = 2.0 * np.abs(2.0 * (0.25 * TIME % 1.0) - 1.0) - 1.0
MOTIONS = {
    "triangles": TRIANGLE,
    "strokes and rests": np.where(TIME % 8.0 < 4.0, np.sin(0.5 * np.pi * TIME), 0.0),
    "growing triangles": TRIANGLE * (0.5 + 0.5 * np.sin(0.05 * TIME)),
}


def rung(signal):
    return second_order(signal, *RING, PERIOD)


def disturbances(random, y):
    noise = random.standard_normal((3, TIME.size))
    return {
        "noise": 0.01 * noise[0],
        "hum": 0.01 * np.sin(2.0 * np.pi * 5.0 * TIME) + 0.003 * noise[1],
        "a floor that shakes": rung(0.03 * noise[2]) + 0.003 * noise[1],
        "steps of a sensor": np.round(y / 0.02) * 0.02 - y,
        "coarse steps": np.round(y / 0.1) * 0.1 - y,
    }


def resonance_of_log(x, y, error):
    log = dehyst.Recording(input=x, output=y + error, time=TIME)
    return ringing([log], [y], [np.ones(TIME.size, dtype=bool)])


@pytest.mark.parametrize("motion", MOTIONS)
@pytest.mark.parametrize("seed", range(2))
def test_what_rings_when_it_moves_has_its_frequency_within_two_percent(motion, seed):
    x = MOTIONS[motion]
    y = LOOP.simulate(x)
    noise = 0.0005 * np.random.default_rng(seed).standard_normal(TIME.size)
    shown = resonance_of_log(x, y, rung(y) - y + noise)
    assert shown is not None
    assert shown.resonance.frequency == pytest.approx(RING[0], rel=0.02)
    assert shown.resonance.damping == pytest.approx(RING[1], rel=0.6)


@pytest.mark.parametrize("motion", MOTIONS)
@pytest.mark.parametrize("seed", range(2))
def test_noise_a_hum_a_floor_that_shakes_and_steps_of_a_sensor_are_no_resonance(motion, seed):
    x = MOTIONS[motion]
    y = LOOP.simulate(x)
    for name, error in disturbances(np.random.default_rng(seed), y).items():
        assert resonance_of_log(x, y, error) is None, name


def test_a_log_without_time_or_too_short_tells_nothing():
    x = MOTIONS["triangles"]
    y = LOOP.simulate(x)
    rings = rung(y)
    untimed = dehyst.Recording(input=x, output=rings)
    assert ringing([untimed], [y], [np.ones(x.size, dtype=bool)]) is None
    short = dehyst.Recording(input=x[:200], output=rings[:200], time=TIME[:200])
    assert ringing([short], [y[:200]], [np.ones(200, dtype=bool)]) is None
    uneven = dehyst.Recording(
        input=x, output=rings, time=np.cumsum(np.where(TIME % 0.05 < 0.02, 0.02, 0.005))
    )
    assert ringing([uneven], [y], [np.ones(x.size, dtype=bool)]) is None


@pytest.fixture(scope="module")
def log():
    x = MOTIONS["strokes and rests"]
    noise = 0.002 * np.random.default_rng(0).standard_normal(TIME.size)
    return dehyst.Recording(
        input=x, output=rung(LOOP.simulate(x)) + noise, time=TIME, input_unit="V"
    )


@pytest.fixture(scope="module")
def fit(log):
    return dehyst.identify(log)


@pytest.mark.slow
def test_identify_says_the_resonance_once_and_its_model_knows_it(fit):
    assert fit.model.resonance.frequency == pytest.approx(RING[0], rel=0.02)
    codes = [finding.code for finding in fit.warnings]
    assert codes.count("resonance") == 1 and "spectral-peak" not in codes
    assert fit.as_dict()["resonance"] == {
        "frequency": fit.model.resonance.frequency,
        "damping": fit.model.resonance.damping,
    }
    assert not any(
        "No model of hysteresis follows it" in words for words in fit.residual.suggestions
    )


@pytest.mark.slow
def test_a_shaped_reference_takes_two_thirds_off_the_error_of_corners(fit):
    corners = 0.8 * (2.0 * np.abs(2.0 * (0.5 * TIME % 1.0) - 1.0) - 1.0)
    missed = {}
    for name, model in (("shaped", fit.model), ("plain", replace(fit.model, resonance=None))):
        demand = model.inverse().simulate(model.shaped(corners, TIME), TIME)
        missed[name] = np.sqrt(np.mean((rung(LOOP.simulate(demand)) - corners)[500:-100] ** 2))
    assert missed["shaped"] < missed["plain"] / 3.0


@pytest.mark.slow
def test_a_resonance_can_be_typed_or_left_out(log):
    assert dehyst.identify(log, resonance=None).model.resonance is None
    typed = dehyst.identify(log, "full-sum", resonance=(5.5, 0.1))
    assert typed.model.resonance == Resonance(5.5, 0.1)


def test_a_resonance_says_nothing_to_families_without_one_and_that_is_said(log):
    for family, settings in (("pi", {}), ("direct-inverse", {}), ("auto", {"n": 20})):
        with pytest.raises(ParameterError, match="for auto and the rows"):
            dehyst.identify(log, family, resonance=(5.0, 0.1), **settings)
    with pytest.raises(ParameterError, match="frequency in Hz"):
        dehyst.identify(log, resonance="loud")
