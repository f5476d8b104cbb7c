"""Two muscles around a pulley: friction of both adds up, and becomes what the paper's compensator inverts."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dehyst import StopOperatorModel
from dehyst.errors import InvertibilityError, ParameterError, RecordingError
from dehyst_robot.muscles import (
    MuscleJoint,
    SlippingJoint,
    identify_slips,
    joint_characteristic,
    muscle,
    muscle_names,
)

RADIUS, START = 0.03, 0.10
SWEEP = 0.4 * np.r_[np.linspace(0, 1, 80), np.linspace(1, -0.6, 120), np.linspace(-0.6, 0.3, 90)]


def linear_muscle(**changes):
    """A Vo-Minh muscle whose pull does not depend on the contraction: B of its joint is constant."""
    return muscle("vo-minh", a=(2.5e-3,), b=(0.0, 2000.0), **changes)


def test_friction_of_both_muscles_adds_up():
    # one shortens while the other one lengthens: Q_h = -2 r h at h N each
    slipping, still = muscle("vo-minh"), muscle("vo-minh", slip_forces=(0.0,) * 10)
    path = np.linspace(-0.6, 0.6, 300)
    with_friction = MuscleJoint(slipping, slipping, RADIUS, START).torque(path, 4e5, 0.0)
    without = MuscleJoint(still, still, RADIUS, START).torque(path, 4e5, 0.0)
    assert (without - with_friction)[-1] == pytest.approx(2 * RADIUS * 20.0)


def test_at_balance_the_angle_is_a_prandtl_ishlinskii_operator_of_the_papers_signal():
    # dp - dp_nom is a sum of stops of the angle; x = k q + dp - dp_nom has the closed inverse q = H[x], sum w = 1/k
    slipping = linear_muscle()
    joint = MuscleJoint(slipping, slipping, RADIUS, START)
    nominal = joint_characteristic(slipping, RADIUS, START).balance(SWEEP, 3e5)
    difference = joint.difference(SWEEP, 3e5)
    gain = RADIUS * 2.5e-3
    strains, forces = np.array(slipping.slip_strains), np.array(slipping.slip_forces)
    stops = StopOperatorModel(
        np.r_[0.0, strains * slipping.length / RADIUS],
        np.r_[0.0, 2 * RADIUS * forces / (strains * slipping.length / RADIUS) / gain / 1e5],
        slope=1.0,
    )
    x = SWEEP + (difference - nominal) / 1e5  # 1 bar/rad, as in the paper
    np.testing.assert_allclose(x, stops.simulate(SWEEP), atol=1e-9)
    inverse = stops.inverse()
    np.testing.assert_allclose(inverse.simulate(x), SWEEP, atol=1e-9)
    assert inverse.weights.sum() == pytest.approx(1.0)  # as derived for k = 1
    assert np.all(inverse.weights >= 0)


def test_the_joint_of_vo_minh_is_that_of_his_muscles_where_friction_does_not_know_the_pressure():
    slipping = linear_muscle()
    muscles = MuscleJoint(slipping, slipping, RADIUS, START)
    joint = SlippingJoint.of_muscles(slipping, RADIUS, START)
    for mean in (2e5, 4e5):
        expected = muscles.torque(SWEEP, mean, 2e4)
        np.testing.assert_allclose(joint.torque(SWEEP, mean, 2e4), expected, atol=1e-6)
    np.testing.assert_allclose(
        joint.difference(SWEEP, 3e5), muscles.difference(SWEEP, 3e5), atol=1e-3
    )


def test_published_half_widths_of_a_joint_of_two_dmsp_40():
    # h = 80 N per muscle, r = 50 mm, l_0 = 0.4 m, 3 bar: 8 Nm, 0.229 bar, 2.4 degrees
    maker = joint_characteristic(muscle("maker"), 0.05, 0.11)
    slipping = replace(
        muscle("vo-minh"), slip_forces=tuple(4.0 * w for w in muscle("vo-minh").slip_forces)
    )
    joint = SlippingJoint(
        maker, slipping.slip_strains, tuple(2 * 0.05 * w for w in slipping.slip_forces)
    )
    assert joint.size == pytest.approx(8.0)
    width = (joint.difference([-0.7, 0.0], 3e5) - maker.balance(np.array([-0.7, 0.0]), 3e5))[
        1
    ] / 1e5
    assert width == pytest.approx(0.229, abs=0.001)
    assert width * np.degrees(0.184) == pytest.approx(2.4, abs=0.05)


@pytest.mark.parametrize("name", muscle_names())
@settings(max_examples=10)
@given(seed=st.integers(0, 2**32 - 1))
def test_the_pressure_difference_of_a_joint_gives_its_torque(name, seed):
    rng = np.random.default_rng(seed)
    model = muscle(name)
    joint = MuscleJoint(model, model, 0.02, 0.08)
    path = np.interp(np.linspace(0, 5, 60), np.arange(6), rng.uniform(-0.2, 0.2, 6))
    time = 0.1 * np.arange(60)
    torque = joint.torque(path, 4e5, 1e5 * np.sin(time), time)
    np.testing.assert_allclose(
        joint.torque(path, 4e5, joint.difference(path, 4e5, torque, time), time), torque, atol=1e-6
    )


def test_friction_of_a_slipping_joint_takes_energy():
    joint = SlippingJoint.of_muscles(muscle("vo-minh"), RADIUS, START)
    loop = np.r_[SWEEP, np.linspace(SWEEP[-1], SWEEP[0], 40)]
    assert np.sum(joint.friction(loop)[1:] * np.diff(loop)) > 0
    assert joint.friction([]).size == 0


def test_what_a_joint_cannot_do_is_named():
    model = muscle("maker")
    joint = MuscleJoint(model, model, 0.05, 0.11)
    with pytest.raises(InvertibilityError, match="Raise the mean pressure"):
        joint.difference([0.0], 1e5, 1e4)
    with pytest.raises(ParameterError, match="outside"):
        joint.torque([5.0], 3e5, 0.0)
    with pytest.raises(ParameterError, match="radius"):
        MuscleJoint(model, model, -0.05, 0.11)
    with pytest.raises(ParameterError, match="gauge"):
        joint.difference([0.0], -1e5)
    with pytest.raises(RecordingError, match="one for each"):
        joint.torque([0.0, 0.1], [3e5], 0.0)
    slips = SlippingJoint.of_muscles(muscle("vo-minh"), RADIUS, START)
    with pytest.raises(ParameterError, match="finite"):
        slips.friction([0.0, float("nan")])
    with pytest.raises(ParameterError, match="a torque of 0 or more"):
        SlippingJoint(slips.characteristic, (0.1, 0.2), (1.0,))
    with pytest.raises(InvertibilityError, match="stay within"):
        SlippingJoint(replace(slips.characteristic, b=(1e-5, -1e-4)), (0.1,), (1.0,)).difference(
            [0.5], 3e5
        )


def test_the_stepper_finds_the_pressures_of_the_batch_inverse():
    for name in ("vo-minh", "reynolds", "tondu-lopez", "sarosi"):
        model, path, force = muscle(name), 0.05 + 0.01 * np.sin(np.linspace(0, 9, 50)), 120.0
        step = model.stepper(path[0])
        found = [step.pressure(x, force, 0.1) for x in path.tolist()]
        expected = model.inverse(np.full(50, force), path, 0.1 * np.arange(50))
        np.testing.assert_allclose(found, expected, rtol=1e-7)


def test_slips_are_identified_exactly_where_they_are_of_the_class():
    true = SlippingJoint.of_muscles(muscle("vo-minh"), RADIUS, START)
    found = identify_slips(
        true.characteristic, SWEEP, 3e5, 2e4, true.torque(SWEEP, 3e5, 2e4), true.slip_angles
    )
    np.testing.assert_allclose(found.friction(SWEEP), true.friction(SWEEP), atol=1e-9)
    with pytest.raises(RecordingError, match="does not move"):
        identify_slips(true.characteristic, [0.1, 0.1], 3e5, 0.0)
