"""Inverse kinematics: reaches every point, depends on the point alone, stays in the middle, says what it cannot do."""

from itertools import pairwise

import numpy as np
import pytest

import arm_oracle
from dehyst.errors import ParameterError
from dehyst_robot.arm import load_robot
from dehyst_robot.iso9283 import TestCube, test_path, timed

pytest.importorskip("mujoco")
pytest.importorskip("mink")

from dehyst_robot.arm._kinematics import InverseKinematics, joint_path

ROBOT = load_robot(conditions="kind")
CUBE = TestCube(ROBOT.path.cube, ROBOT.path.center)
PATH = test_path(CUBE, ROBOT.path.rounding)
RANGE = np.array([ROBOT.joint(n).range for n in range(1, 8)])
PNEUMATIC = np.array(ROBOT.pneumatic) - 1


def plane(n):
    """Points of the whole test plane, (n^2, 3)."""
    u, v, _ = CUBE.axes
    a, b = np.meshgrid(np.linspace(-1, 1, n), np.linspace(-1, 1, n))
    half = CUBE.edge / 2
    return CUBE.origin + half * (a.ravel()[:, None] * u + np.sqrt(2) * b.ravel()[:, None] * v)


@pytest.fixture(scope="module")
def joints():
    return joint_path(ROBOT, PATH)


def test_the_whole_test_plane_is_reached_within_three_quarters_of_every_muscle_joints_range():
    points = plane(7)
    q = InverseKinematics(ROBOT).solve(points)
    reached = np.array([arm_oracle.tool(ROBOT, row) for row in q])
    assert np.linalg.norm(reached - points, axis=1).max() < 1e-9
    assert (np.abs(q[:, PNEUMATIC]) / RANGE[PNEUMATIC]).max() < 0.75


def test_angles_depend_on_the_point_and_not_on_the_way_to_it():
    points = plane(4)
    there = InverseKinematics(ROBOT).solve(points)
    back = InverseKinematics(ROBOT).solve(points[::-1])[::-1]
    np.testing.assert_allclose(there, back, atol=1e-7)


def test_no_other_posture_reaches_the_point_with_less_excursion():
    weight = np.array(ROBOT.path.posture_weights) / RANGE**2
    for point in plane(3):
        q = InverseKinematics(ROBOT).solve(point[None])[0]
        slope = 2 * weight * q
        jacobian = arm_oracle.gradient(lambda x: arm_oracle.tool(ROBOT, x), q)
        multiplier = np.linalg.lstsq(jacobian.T, slope, rcond=None)[0]
        assert np.abs(slope - jacobian.T @ multiplier).max() < 1e-5 * max(1.0, np.abs(slope).max())


def test_far_points_are_reached_without_points_between():
    far = np.array([[0.3, 0.0, 0.5], [0.9, -0.25, 0.75], [0.5, 0.3, 0.3]])
    q = InverseKinematics(ROBOT).solve(far)
    np.testing.assert_allclose([arm_oracle.tool(ROBOT, row) for row in q], far, atol=1e-7)
    assert (np.abs(q) <= RANGE + 1e-12).all()


def test_a_point_out_of_reach_is_named_with_its_distance_and_the_cure():
    shoulder = np.array([0.0, 0.0, ROBOT.base.height])
    longest = sum(ROBOT.joint(n).link_length for n in range(1, 8))
    point = np.array([2.0, 0.5, 0.6])
    with pytest.raises(
        ParameterError, match=r"point 1 .*\(2\.000, 0\.500, 0\.600\).*path\.cube_m"
    ) as caught:
        InverseKinematics(ROBOT).solve(np.array([ROBOT.path.center, point]))
    least = np.linalg.norm(point - shoulder) - longest
    assert least <= caught.value.facts["distance"] < least + 0.3
    assert caught.value.facts["point"] == 1


def test_ends_of_ranges_that_stop_the_arm_are_named():
    stiff = ROBOT.with_changes({"joint.4.range_deg": 5.0, "joint.2.range_deg": 5.0})
    with pytest.raises(ParameterError) as caught:
        InverseKinematics(stiff).solve(CUBE.corner(1)[None])
    assert set(caught.value.facts["joints_at_end"]) & {2, 4}


@pytest.mark.parametrize(
    "points", [np.zeros((3, 2)), [[np.nan, 0, 0]], np.zeros(3).reshape(1, 1, 3)]
)
def test_what_is_no_path_is_refused(points):
    with pytest.raises(ParameterError, match="metres"):
        InverseKinematics(ROBOT).solve(points)


def test_between_the_knots_the_tool_stays_within_20_micrometres_of_its_path(joints):
    s = np.random.default_rng(1).uniform(0, PATH.length, 4000)
    reached = np.array([arm_oracle.tool(ROBOT, q) for q in joints.angles(s)])
    assert np.linalg.norm(reached - PATH.position(s), axis=1).max() < 20e-6
    assert joints.knots < 600


def test_the_path_moves_the_joints_that_it_shall_test_and_closes(joints):
    q = np.degrees(joints.angles(np.linspace(0, PATH.length, 2000)))
    half = (q.max(axis=0) - q.min(axis=0)) / 2
    assert half[0] > 12.0
    assert min(half[1], half[3]) > 8.0
    assert np.abs(q[0]).max() < 1e-3  # it begins in the zero pose
    np.testing.assert_allclose(q[0], q[-1], atol=1e-6)


@pytest.mark.slow
def test_angles_bend_as_the_inverse_kinematics_itself_and_not_more(joints):
    solver, h = InverseKinematics(ROBOT), 1e-4
    for start, end in pairwise(joints.rests):
        s = np.linspace(start + 2 * h, end - 2 * h, 120)
        before, here, after = (solver.solve(PATH.position(s + shift)) for shift in (-h, 0, h))
        bend = (before - 2 * here + after) / h**2
        assert np.abs(joints.angles(s, 2) - bend).max() < 0.03 * np.abs(bend).max()
        assert np.abs(joints.angles(s, 1) - (after - before) / (2 * h)).max() < 3e-3


def test_a_motion_has_the_velocities_and_accelerations_of_its_angles(joints):
    motion = timed(
        PATH, ROBOT.path.fast_speed, ROBOT.path.acceleration, ROBOT.path.jerk, ROBOT.path.rest
    )
    h = 1e-3
    along = motion.motion(np.arange(0, 20, h))
    q, qd, qdd = joints.motion(along.s, along.speed, along.acceleration)
    assert np.abs(qd).max() > 0.2
    np.testing.assert_allclose(np.gradient(q, h, axis=0)[1:-1], qd[1:-1], atol=2e-5)
    np.testing.assert_allclose(np.gradient(qd, h, axis=0)[1:-1], qdd[1:-1], atol=2e-2)


def test_a_path_without_legs_is_refused():
    class Nowhere:
        rests = np.array([0.0])

        def position(self, s):
            return np.zeros((len(s), 3))

    with pytest.raises(ParameterError, match="increasing arc lengths"):
        joint_path(ROBOT, Nowhere())
