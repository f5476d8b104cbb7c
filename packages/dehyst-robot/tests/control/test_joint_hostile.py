"""Whatever comes in, what goes out is within limits: valves, pressures, and every other output finite."""

import math
from dataclasses import astuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dehyst import PrandtlIshlinskii, _native
from dehyst_robot import _native as _robot
from dehyst_robot.control import (
    Adaptation,
    JointController,
    JointControllerParameters,
    JointOutput,
    JointReference,
)

JOINT = JointControllerParameters()
MODEL = PrandtlIshlinskii([0.0, 0.3, 0.8], [0.6, 0.2, 0.1]).inverse()
ANY = st.one_of(
    st.floats(),
    st.sampled_from(
        [math.nan, math.inf, -math.inf, 1e300, -1e300, 1e100, -1e99, 5e-324, 0.0, -0.0]
    ),
    st.floats(-1, 1),
    st.floats(0, 6e5),
)
SAMPLE = st.tuples(ANY, ANY, ANY, st.tuples(*[ANY] * 7), st.integers(0, 7))


def check(out, low, high):
    values = astuple(out)
    assert all(_native.accept(x) for x in values)
    assert -1 <= out.valve_1 <= 1
    assert -1 <= out.valve_2 <= 1
    assert low <= out.desired_1 <= high
    assert low <= out.desired_2 <= high
    assert abs(out.pressure_difference) <= 4 * (high - low)


@pytest.mark.parametrize("guarded", [True, False])
@settings(max_examples=60)
@given(samples=st.lists(SAMPLE, min_size=1, max_size=30), start=st.tuples(ANY, ANY, ANY))
def test_limits_hold_for_every_input(samples, start, guarded):
    guards = {} if guarded else {"angle_jump": 0.0, "pressure_jump": 0.0, "hold_samples": 1000}
    controller = JointController(JointControllerParameters(**guards), MODEL)
    controller.reset(*start)
    for angle, p_1, p_2, reference, switches in samples:
        check(
            controller.step(angle, p_1, p_2, JointReference(*reference), switches),
            JOINT.pressure_low,
            JOINT.pressure_high,
        )


def after(readings):
    """Return the last output for these readings, each of them also the whole reference, then 3 s of plain ones."""
    controller = JointController(
        JointControllerParameters(angle_jump=0.0, pressure_jump=0.0, frozen_samples=0), MODEL
    )
    controller.reset(0.0, 3e5, 3e5)
    for x in readings:
        controller.step(x, x, x, JointReference(*[x] * 7), 7)
    for _ in range(6000):
        out = controller.step(0.0, 3e5, 3e5, JointReference(0.1), 5)
    return out


def test_the_controller_forgets_inputs_of_no_meaning():
    wild, tame = after([1e99, -1e99, 1e60, 0.0] * 5), after([0.0] * 20)
    assert wild.pressure_difference == pytest.approx(
        tame.pressure_difference, abs=3e4
    )  # plays remember extremes
    assert abs(wild.angle) < 1e-6
    assert abs(wild.velocity) < 1e-6
    assert wild.load == pytest.approx(tame.load, abs=1e-3)


LISTS = {"a", "b", "c", "volume", "pneumatics"}
FIELDS = sorted(set(JOINT.as_dict()) - LISTS - {"pressure_low", "pressure_high"})
NUMBER = st.one_of(
    st.sampled_from([0.0, -0.0, 1.0, -1.0, 1e-300, -1e-300, 1e99, -1e99]), st.floats(-1e100, 1e100)
)


@pytest.mark.slow
@given(st.data())
@settings(max_examples=100)
def test_limits_hold_for_every_finite_parameter(data):
    hostile = JOINT.as_dict()
    for name in data.draw(st.lists(st.sampled_from(FIELDS), max_size=4)):
        count = name in ("frozen_samples", "hold_samples")
        hostile[name] = data.draw(st.integers(0, 2**31 - 1)) if count else data.draw(NUMBER)
    for name in data.draw(st.lists(st.sampled_from(["a", "b", "c"]), max_size=2)):
        hostile[name] = data.draw(st.lists(NUMBER, min_size=1, max_size=8))
    if data.draw(st.booleans()):
        hostile["volume"] = [data.draw(st.lists(NUMBER, min_size=1, max_size=4)) for _ in range(2)]
    for name in data.draw(st.lists(st.sampled_from(list(hostile["pneumatics"])), max_size=3)):
        hostile["pneumatics"][name] = data.draw(NUMBER)
    controller = _robot.JointController(
        hostile, MODEL.stepper().parameters, None, Adaptation().as_dict()
    )
    rng = np.random.default_rng(0)
    controller.reset(0.0, 3e5, 3e5)
    for k in range(20):
        noise = rng.normal(size=3)
        reading = (1e-3 * noise[0], 3e5 + 250 * noise[1], 3e5 + 250 * noise[2])
        out = controller.step(*reading, (0.1, 0.2, 0.3, 4.0, 3e5, 1e5, 1e4), [7, 3, 0, 5][k // 5])
        check(JointOutput(*out), JOINT.pressure_low, JOINT.pressure_high)


@pytest.mark.parametrize("b", [(0.0,), (-3e-4,), (1e-15,)])
def test_a_vanishing_b_does_not_divide_by_zero(b):
    controller = JointController(JointControllerParameters(b=b))
    controller.reset(0.0, 3e5, 3e5)
    for k in range(100):
        out = controller.step(1e-3 * (k % 3), 3e5 + k, 3e5 - k, JointReference(0.1), 3)
        check(out, JOINT.pressure_low, JOINT.pressure_high)
