"""Position law, inverse characteristic, limits and anti-windup of the joint controller."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dehyst_robot.control import (
    FLAGS,
    SWITCHES,
    JointController,
    JointControllerParameters,
    JointReference,
)
from joint_oracles import PERIOD, Rig, closed_loop, column, reference_along

JOINT = JointControllerParameters(frozen_samples=0)  # sensors of ideal joints stand still
IDEAL = replace(
    JOINT, ramp=0.0, windup_gain=0.0
)  # pressures follow at once: what valves would need does not count
ON = SWITCHES["position"]
WITH_INTEGRATOR = ON | SWITCHES["integrator"]


def torque(parameters, q, mean, dp):
    a, b, c = (np.polynomial.Polynomial(x)(q) for x in (parameters.a, parameters.b, parameters.c))
    return a * mean + b * dp + c


def ideal(parameters, reference, switches, inertia, load=0.0, steps=3000):
    """Run the controller on an inertia whose pressures are the desired ones at once: (angles, outputs)."""
    controller = JointController(parameters)
    q = qd = 0.0
    p = (3e5, 3e5)
    controller.reset(q, *p)
    angles, outputs = [], []
    for k in range(steps):
        out = controller.step(q, *p, reference(k * PERIOD), switches)
        angles.append(q), outputs.append(out)
        p = (out.desired_1, out.desired_2)
        qdd = (torque(parameters, q, sum(p) / 2, p[0] - p[1]) - load) / inertia
        q, qd = q + PERIOD * qd + PERIOD**2 / 2 * qdd, qd + PERIOD * qdd
    return np.array(angles), outputs


@pytest.mark.parametrize("pole", [4.0, 6.0, 10.0])
def test_the_error_has_its_three_poles_at_minus_lambda(pole):
    # A step of the desired angle alone: (3 L^2 s + L^3)/(s + L)^3 gives 1 - exp(-x) (1 + x - x^2), x = L t.
    joint = replace(IDEAL, pole=pole)
    q, outputs = ideal(joint, lambda t: JointReference(angle=0.01), WITH_INTEGRATOR, joint.inertia)
    x = pole * PERIOD * np.arange(q.size)
    expected = 0.01 * (1 - np.exp(-x) * (1 + x - x**2))
    np.testing.assert_allclose(q, expected, atol=3e-4 * pole / 4 * 0.01 * 10)
    assert not (column(outputs, "flags") & ~FLAGS["valve-limit"]).any()


@pytest.mark.slow
def test_without_integrator_a_load_leaves_the_error_of_the_law():
    load, joint = 9.0, IDEAL  # e = load/(3 L^2 M), and with integrator none
    q, _ = ideal(joint, lambda t: JointReference(), ON, joint.inertia, load, steps=8000)
    assert q[-1] == pytest.approx(-load / (3 * 36 * joint.inertia), rel=1e-3)
    q, outputs = ideal(
        joint, lambda t: JointReference(), WITH_INTEGRATOR, joint.inertia, load, steps=8000
    )
    assert abs(q[-1]) < 1e-5
    assert outputs[-1].integrator == pytest.approx(load, rel=1e-3)
    q, _ = ideal(joint, lambda t: JointReference(load=load), ON, joint.inertia, load, steps=8000)
    assert np.max(np.abs(q[6000:])) < 1e-3 * load / (3 * 36 * joint.inertia)


@given(
    st.floats(-0.9, 0.9),
    st.floats(2.5e5, 3.5e5),
    st.floats(-20, 20),
    st.floats(-2, 2),
    st.sampled_from([0, SWITCHES["integrator"], SWITCHES["compensator"]]),
)
def test_without_gains_dp_is_the_inverse_characteristic(q, mean, load, acceleration, others):
    joint = replace(JOINT, pole=0.0, ramp=0.0)
    controller = JointController(joint)
    controller.reset(q, 3e5, 3e5)
    reference = JointReference(0.2, 0.5, acceleration, load, mean)
    controller.step(q, 3e5, 3e5, reference, ON | others)
    out = controller.step(q, 3e5, 3e5, reference, ON | others)
    held = min(
        max(out.angle, joint.angle_low), joint.angle_high
    )  # beyond the calibration it is held
    a, b, c = (sum(x * held**j for j, x in enumerate(p)) for p in (joint.a, joint.b, joint.c))
    wanted = joint.inertia * acceleration + load
    assert out.torque == pytest.approx(wanted, abs=1e-12)
    assert out.pressure_difference == pytest.approx(
        (wanted - a * mean - c) / b, rel=1e-12, abs=1e-7
    )


@given(st.floats(-2e6, 2e6), st.floats(-2e5, 1.2e6))
def test_desired_pressures_stay_within_limits_and_keep_dp_as_long_as_it_fits(dp, mean):
    controller = JointController(replace(JOINT, ramp=0.0))
    controller.reset(0.0, 3e5, 3e5)
    reference = JointReference(mean_pressure=mean, pressure_difference=dp)
    controller.step(0.0, 3e5, 3e5, reference, 0)
    out = controller.step(0.0, 3e5, 3e5, reference, 0)
    low, high = JOINT.pressure_low, JOINT.pressure_high
    assert low <= out.desired_1 <= high
    assert low <= out.desired_2 <= high
    assert out.desired_1 - out.desired_2 == pytest.approx(
        min(max(dp, low - high), high - low), abs=1e-6
    )
    fits = low <= mean - abs(dp) / 2 and mean + abs(dp) / 2 <= high
    if fits:
        assert (out.desired_1 + out.desired_2) / 2 == pytest.approx(mean, abs=1e-6)
    assert out.raised("pressure-limit") == (not fits)


def test_a_controller_starts_from_the_sensed_pressures():
    controller = JointController(JOINT)
    controller.reset(0.0, 2.2e5, 1.4e5)
    reference = JointReference(mean_pressure=3e5, pressure_difference=-1e5)
    outputs = [controller.step(0.0, 2.2e5, 1.4e5, reference, 0) for _ in range(1100)]
    p_1, p_2 = column(outputs, "desired_1"), column(outputs, "desired_2")
    assert (p_1[0], p_2[0]) == pytest.approx((2.2e5, 1.4e5))
    assert np.max(np.abs(np.diff(p_1))) <= 1.01 * PERIOD / JOINT.ramp * 2.1e5
    assert (p_1[-1], p_2[-1]) == pytest.approx((2.5e5, 3.5e5))


def run(windup, reference, load=lambda q: 0.0):
    joint = replace(JOINT, windup_gain=windup)
    return closed_loop(JointController(joint), Rig(joint, load=load), reference, WITH_INTEGRATOR)


def test_anti_windup_does_nothing_while_nothing_saturates():
    reference = reference_along(PERIOD * np.arange(3000))
    (q, outputs), (other, _) = run(0.0, reference), run(50.0, reference)
    limits = FLAGS["pressure-limit"] | FLAGS["valve-limit"]
    assert not (column(outputs, "flags") & limits).any()
    assert q.tobytes() == other.tobytes()


@pytest.mark.slow
def test_anti_windup_shortens_the_way_back_from_a_load_that_was_too_much():
    reference = np.zeros((7000, 7))
    reference[:, 4] = 3e5
    loads = iter(np.repeat([0.0, 400.0, 0.0], [500, 2500, 4000]))  # Nm; the muscles have about 200
    q, outputs = run(5.0, reference, load=lambda q: next(loads) - 600 * min(q + 0.6, 0.0) * -1)
    loads = iter(np.repeat([0.0, 400.0, 0.0], [500, 2500, 4000]))
    wound, others = run(0.0, reference, load=lambda q: next(loads) - 600 * min(q + 0.6, 0.0) * -1)
    assert column(outputs, "flags")[1000:3000].any()
    assert np.max(np.abs(column(outputs, "integrator"))) < 0.7 * np.max(
        np.abs(column(others, "integrator"))
    )
    assert np.sum(np.abs(q[3000:])) < 0.7 * np.sum(np.abs(wound[3000:]))
    assert math.isfinite(q[-1])


def test_the_closed_loop_follows_with_a_wrong_inertia_and_a_load():
    reference = reference_along(PERIOD * np.arange(6000))
    q, outputs = run(5.0, reference, load=lambda q: 10 + 20 * math.sin(q))
    error = np.degrees(reference[:, 0] - q)
    assert np.sqrt(np.mean(error[3000:] ** 2)) < 0.8
    assert np.max(np.abs(column(outputs, "angle") - q)) < 3e-4
    assert not column(outputs, "flags").any()
