"""The observer of angle, velocity and load: where its poles are, and that it ends without a bias."""

import math
from dataclasses import replace

import numpy as np
import pytest

from dehyst_robot.control import JointController, JointControllerParameters, JointReference
from joint_oracles import PERIOD

# Q = B dp exactly, so that the torque is known and the load is all that is left to be found.
PLAIN = JointControllerParameters(
    a=(0.0,), b=(3e-4,), c=(0.0,), angle_low=-50, angle_high=50, angle_jump=0, frozen_samples=0
)


def observe(parameters, q, pressures, load=0.0):
    """Return observed angle, velocity, load (T, 3) for true angles and pressures (T, 2)."""
    controller = JointController(parameters)
    controller.reset(q[0], *pressures[0])
    reference = JointReference(load=load)
    outputs = [controller.step(a, *p, reference, 0) for a, p in zip(q, pressures, strict=True)]
    return np.array([(o.angle, o.velocity, o.load) for o in outputs])


def level(samples, dp=1e5):
    return np.tile([3e5 + dp / 2, 3e5 - dp / 2], (samples, 1))


def test_a_constant_load_is_found_and_leaves_no_bias():
    # M qdd = B dp - load from a moving start: angle, velocity and load are all wrong at first.
    t = PERIOD * np.arange(2000)
    load, torque = 17.0, 3e-4 * 1e5
    acceleration = (torque - load) / PLAIN.inertia
    q = 0.1 + 0.3 * t + acceleration * t**2 / 2
    seen = observe(PLAIN, q, level(t.size))
    assert abs(seen[0, 2] - load) > 10  # it did not know
    np.testing.assert_allclose(seen[1000:, 0], q[1000:], atol=1e-9)
    np.testing.assert_allclose(seen[1000:, 1], (0.3 + acceleration * t)[1000:], atol=1e-8)
    np.testing.assert_allclose(seen[1000:, 2], load, atol=1e-5)


def test_the_load_of_the_reference_is_not_observed_again():
    q = np.full(1000, 0.2)
    seen = observe(PLAIN, q, level(q.size), load=12.0)
    np.testing.assert_allclose(
        seen[:, 2], 30.0 - 12.0, atol=1e-9
    )  # at rest: known from the first sample
    np.testing.assert_allclose(seen[:, 0], 0.2, atol=1e-15)


def test_a_pendulum_is_observed_without_bias():
    m, q, qd = PLAIN.inertia, 0.6, 0.0
    angles = []
    for _ in range(12000):
        angles.append(q)
        for _ in range(4):  # semi-implicit Euler, four substeps
            qd += PERIOD / 4 * (3e-4 * 1e5 - 80 * math.sin(q) - 30) / m
            q += PERIOD / 4 * qd
    angles = np.array(angles)
    seen = observe(PLAIN, angles, level(12000))
    upward = np.flatnonzero((angles[2000:-1] < 0) & (angles[2001:] >= 0)) + 2000
    whole = slice(upward[0], upward[-1])  # whole swings: what is left of the mean is bias
    error, load = angles[whole] - seen[whole, 0], 80 * np.sin(angles[whole]) + 30
    assert np.ptp(angles) > 1.0
    assert np.max(np.abs(error)) < 3e-4  # rate of the load/(M w^3)
    assert abs(np.mean(error)) < 2e-6
    assert np.sqrt(np.mean((load - seen[whole, 2]) ** 2)) < 0.3 * np.std(load)


@pytest.mark.parametrize("pole", [20.0, 60.0, 200.0])
def test_its_three_poles_are_where_they_should_be(pole):
    # A load that appears at t = 0 is answered by the error d/M t^2/2 exp(-w t) of the angle.
    t = PERIOD * np.arange(1, 2001)
    d = 8.0
    q = np.concatenate([np.zeros(500), -d / PLAIN.inertia * t**2 / 2])
    seen = observe(replace(PLAIN, observer_pole=pole), q, level(q.size, 0.0))[500:, 0]
    expected = -d / PLAIN.inertia * t**2 / 2 * np.exp(-pole * t)
    np.testing.assert_allclose(
        q[500:] - seen, expected, atol=max(0.06, pole * PERIOD * 1.6) * np.max(np.abs(expected))
    )


@pytest.mark.parametrize("share", [0.01, 0.1, 0.5, 2.0, 20.0])
def test_it_is_stable_for_every_product_of_pole_and_period(share):
    q = np.concatenate([np.zeros(10), np.full(3000, 0.1)])
    seen = observe(replace(PLAIN, observer_pole=share / PERIOD), q, level(q.size, 0.0))
    assert np.all(np.abs(seen[:, 0]) < 0.2)
    np.testing.assert_allclose(seen[-1], [0.1, 0.0, 0.0], atol=1e-6)
