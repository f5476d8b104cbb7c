"""The path of the arm: joint angles that are the tool's path, within what pressures and valves can do."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.polynomial.polynomial import polyval

from arm_oracle import tool
from dehyst.errors import ParameterError
from dehyst_robot.arm import arm_model, load_robot
from dehyst_robot.arm._rigid_body import inverse_dynamics
from dehyst_robot.experiments import controller_parameters, nominal_characteristic, plan_path
from experiment_samples import path

HURRIED = {"path.fast_speed_m_s": 2.0, "path.acceleration_m_s2": 50.0, "path.jerk_m_s3": 2000.0}


@settings(max_examples=60)
@given(share=st.floats(0.0, 1.0), slower=st.sampled_from([1.0, 4.0, 10.0]))
def test_the_tool_is_on_the_iso_path_to_20_um_at_any_time(share, slower):
    motion = path().timing.slower(slower)
    t = np.array([share * motion.duration])
    angles = path().motion(motion, t)[0][0]
    there = tool(load_robot(conditions="kind"), angles)  # forward kinematics by matrices, no MuJoCo
    assert np.linalg.norm(there - motion.position(t)[0]) < 20e-6


@settings(max_examples=40)
@given(share=st.floats(0.001, 0.999))
def test_velocities_and_accelerations_are_derivatives_of_the_angles(share):
    h = 1e-4
    t = share * path().timing.duration + h * np.array([-1.0, 0.0, 1.0])
    q, v, a = path().motion(path().timing, t)
    np.testing.assert_allclose(
        v[1], (q[2] - q[0]) / (2 * h), atol=2e-3
    )  # jerk is limited, acceleration continuous
    np.testing.assert_allclose(a[1], (v[2] - v[0]) / (2 * h), atol=0.1)


def test_every_joint_stays_within_its_range_with_room():
    robot = load_robot(conditions="kind")
    q = path().motion(path().timing, np.linspace(0, path().timing.duration, 2000))[0]
    used = np.abs(q).max(axis=0) / [robot.joint(n).range for n in range(1, 8)]
    assert (used < 0.75).all()
    assert np.degrees(np.ptp(q[:, 0])) > 10  # joint 1 is asked for something


def needs(planned, robot):
    """Largest share of pressures and of valve flow along a planned motion, from the nominal model, joint by joint."""
    t = np.linspace(0.0, planned.timing.duration, 4001)
    q, v, a = planned.motion(planned.timing, t)
    torque = inverse_dynamics(arm_model(robot), q, v, a)
    mean, ambient = 3e5, 1.013e5
    pressure_use, flow_use = 0.0, 0.0
    for n in robot.pneumatic:
        plan = nominal_characteristic(robot, n)
        air, told = (
            controller_parameters(robot, n, plan).pneumatics,
            controller_parameters(robot, n, plan),
        )
        x = q[:, n - 1]
        dp = (torque[:, n - 1] - polyval(x, plan.a) * mean - polyval(x, plan.c)) / polyval(
            x, plan.b
        )
        for side, volume in zip((1, -1), told.volume, strict=True):
            p = mean + side * dp / 2
            pressure_use = max(
                pressure_use, (p.max() - mean) / (6e5 - mean), (mean - p.min()) / (mean - 0.2e5)
            )
            chamber, p = polyval(x, volume), p + ambient
            mass_rate = (
                chamber**-0.26 * np.gradient(p * chamber**1.26, t) / (1.26 * air.gas_temperature)
            )
            up = np.where(mass_rate > 0, air.supply, p)
            ratio = np.where(mass_rate > 0, p, ambient) / up
            psi = np.sqrt(1 - np.clip((ratio - air.ratio) / (1 - air.ratio), 0, 1) ** 2)
            largest = air.conductance * 1.185 * up * psi
            flow_use = max(flow_use, float(np.max(np.abs(mass_rate) / largest)))
    return pressure_use, flow_use


def test_the_planned_motion_leaves_room_in_pressures_and_valves():
    assert max(needs(path(), load_robot(conditions="kind"))) <= 1.0 and path().timing.factor == 1.0


def test_a_speed_set_too_high_is_slowed_down_to_what_the_valves_can_do():
    robot = load_robot(conditions="kind", changes=HURRIED)
    planned = plan_path(robot)
    assert planned.timing.factor > 1.5
    assert 0.7 < max(needs(planned, robot)) <= 1.0  # no slower than needed


def test_a_fast_speed_alone_is_kept_by_the_acceleration():
    planned = plan_path(load_robot(conditions="kind", changes={"path.fast_speed_m_s": 2.0}))
    assert planned.timing.duration < path().timing.duration
    assert max(needs(planned, load_robot(conditions="kind"))) <= 1.0


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"path.center_m": [1.5, 0.0, 0.5]}, r"cannot be reached.*path\.center_m"),
        ({"path.cube_m": 0.7}, r"cannot be reached.*path\.cube_m"),
        ({"payload.mass_kg": 20.0}, "it is the load and the posture"),
    ],
    ids=str,
)
def test_a_cube_out_of_reach_or_a_load_too_large_is_refused_with_its_cure(changes, words):
    with pytest.raises(ParameterError, match=words):
        plan_path(load_robot(conditions="kind", changes=changes))
