"""Valve, chamber and pressure loops against formulas of their own."""

import math
from dataclasses import asdict, replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dehyst_robot import _native
from dehyst_robot.control import (
    JointController,
    JointControllerParameters,
    JointReference,
    Pneumatics,
)
from joint_oracles import AMBIENT, PERIOD, RT, SUPPLY, Chamber, N, flow, opened, psi, quantised

AIR = asdict(Pneumatics())


@given(st.floats(1e-290, 1e100))
def test_the_root_is_that_of_the_library(x):
    assert abs(_native.root(x) - math.sqrt(x)) <= 2 * math.ulp(math.sqrt(x))


@pytest.mark.parametrize("x", [0.0, -1.0, -math.inf, math.inf, math.nan, 5e-324])
def test_the_root_of_what_has_none_is_zero(x):
    assert _native.root(x) == 0.0


@given(st.floats(-0.5, 1.5), st.floats(0.0, 0.9))
def test_the_flow_function_is_that_of_the_standard(ratio, critical):
    assert abs(_native.flow_function(ratio, critical) - psi(ratio, critical)) < 1e-9
    assert 0.0 <= _native.flow_function(ratio, critical) <= 1.0


@given(st.floats(0.0, 6.2e5), st.one_of(st.floats(0.0051, 1.0), st.floats(-1.0, -0.0051)))
def test_the_valve_inverse_undoes_the_valve(gauge, opening):
    p = gauge + AMBIENT
    wanted = flow(opening, p)
    if abs(wanted) > 0 and psi(p / SUPPLY if opening > 0 else AMBIENT / p) > 0.05:
        found = _native.valve_opening(AIR, wanted, p)
        assert abs(found - opening) < 1e-9
        command = _native.valve_command(AIR, found)
        assert abs(flow(opened(command), p) - wanted) <= 1e-9 * abs(wanted)


def test_the_dead_band_is_crossed_in_a_steep_straight_line():
    openings = np.linspace(-0.02, 0.02, 4001)
    commands = np.array([_native.valve_command(AIR, s) for s in openings])
    slopes = np.diff(commands) / np.diff(openings)
    assert np.all(slopes > 0)
    assert np.max(slopes) < 10  # no step: noise of a sensor does not throw the spool
    assert commands[2000] == 0.0
    np.testing.assert_allclose(commands, -commands[::-1], atol=1e-15)


def test_the_chamber_flow_makes_the_rate_that_was_asked_for():
    v, v_rate, p, rate = 7e-4, 3e-4, 4e5, 2e5
    mdot = _native.chamber_flow(AIR, v, v_rate, p, rate)
    assert N / v * (RT * mdot - p * v_rate) == pytest.approx(rate, rel=1e-12)


def track(frequency, parameters, volumes, noise):
    """Return the rms pressure error of both muscles [mbar] while 2 bar of dp and the joint swing together."""
    rng, w = np.random.default_rng(1), 2 * math.pi * frequency
    chambers = [Chamber(3e5, v, substeps=2) for v in volumes]
    controller = JointController(parameters)
    controller.reset(0.0, 3e5, 3e5)
    errors = []
    for k in range(round(2.0 / PERIOD)):
        wave, speed = math.sin(w * k * PERIOD), w * math.cos(w * k * PERIOD)
        readings = [c.p - AMBIENT + noise * rng.normal() for c in chambers]
        out = controller.step(
            quantised(0.366 * wave), *readings, JointReference(pressure_difference=2e5 * wave), 0
        )
        for chamber, command in zip(chambers, (out.valve_1, out.valve_2), strict=True):
            chamber.step(command, 0.366 * wave, 0.366 * speed)
        after = 1e5 * math.sin(w * (k + 1) * PERIOD)
        errors.append(
            (chambers[0].p - AMBIENT - 3e5 - after, chambers[1].p - AMBIENT - 3e5 + after)
        )
    return np.sqrt(np.mean(np.square(errors[1000:]))) / 100


@pytest.mark.parametrize(("frequency", "within", "without"), [(0.5, 3.0, 10.0), (1.0, 6.0, 20.0)])
def test_pressures_are_tracked_within_millibars_and_the_changing_volume_matters(
    frequency, within, without
):
    parameters = JointControllerParameters()
    ignorant = replace(parameters, volume=tuple(v[:1] for v in parameters.volume))
    assert track(frequency, parameters, parameters.volume, 250.0) < within
    assert track(frequency, ignorant, parameters.volume, 250.0) > without


def test_a_wrong_valve_and_a_wrong_air_cost_little():
    wrong = Pneumatics(conductance=2.4e-8, polytropic=1.4, dead_band=0.02)
    parameters = JointControllerParameters(pneumatics=wrong)
    assert track(0.5, parameters, parameters.volume, 250.0) < 25.0
