"""Routing of muscles: arms from pulleys, levers, polynomials and tendons of a body; springs in place of muscles."""

import tomllib
from pathlib import Path

import numpy as np
import pytest
from numpy.polynomial import Polynomial
from numpy.polynomial.polynomial import polyval

from dehyst.errors import ParameterError
from dehyst_robot._native import PneumaticJoint
from dehyst_robot.arm import _rigid_body as rb
from dehyst_robot.arm import load_robot, pneumatic_joint_parameters, robot_of
from dehyst_robot.arm._joints import built_plant, run_pressures
from dehyst_robot.experiments import (
    RigLog,
    calibrate,
    controller_parameters,
    nominal_characteristic,
)
from dehyst_robot.experiments._plant_fit import respond
from dehyst_robot.experiments._rig import cautions, check_rig
from test_rigs import DRIVE, EXAMPLES, rig

PLAIN = {"hysteresis.mechanism": "none", "hysteresis.creep": 0.0}
RADIUS = "radius_m = 0.03"
LEVER = 'routing = "lever"\nlever_m = [0.28, 0.032]\nlever_angle_deg = 80.0'
CAM = 'routing = "polynomial"\nmoment_arm_m = [0.03, 0.008, -0.01]'
CAMS = f"{CAM}\nmoment_arm_2_m = [0.025, 0.004]"
SPRUNG = 'drives = ["dmsp20", "spring"]\nspring_N_m = 3000\nspring_preload_N = 260'
Q = np.radians(np.linspace(-25.0, 25.0, 201))


def routed(folder, routing, drive=DRIVE, changes=()):
    """One joint with this routing in the place of its pulley."""
    text = rig(folder).read_text(encoding="utf-8").replace(RADIUS, routing).replace(DRIVE, drive)
    return robot_of(tomllib.loads(text), "rig.toml", changes=dict(changes), conditions="kind")


def arms(robot, number=1, q=Q):
    return [polyval(q, arm) for arm in rb.moment_arms(robot, number)]


def test_a_round_pulley_is_force_times_radius_to_the_last_bit(tmp_path):
    q, p = 0.4 * np.sin(np.linspace(0.0, 9.0, 500)), np.linspace([1e5, 4e5], [4e5, 1e5], 500)
    robot = load_robot(rig(tmp_path), conditions="kind")  # tendons do not give
    course = run_pressures(pneumatic_joint_parameters(robot, 1, 0), q, p, 0.01)
    assert np.array_equal(course.torque, 0.03 * (course.force[:, 0] - course.force[:, 1]))
    reached = q[:-1] + np.diff(q) / 0.01 * 0.01  # as the plant moves
    for m, side in enumerate((1, -1)):
        assert np.array_equal(
            course.contraction[1:, m],
            0.07 + side * (0.03 * reached / robot.muscle("dmsp20").length),
        )
    same = routed(tmp_path, 'routing = "polynomial"\nmoment_arm_m = [0.03, 0.0, 0.0]')
    assert np.array_equal(
        run_pressures(pneumatic_joint_parameters(same, 1, 0), q, p, 0.01).torque, course.torque
    )
    plans = [nominal_characteristic(each, 1) for each in (robot, same)]
    assert np.array_equal(plans[0].b, plans[1].b) and np.array_equal(plans[0].c, plans[1].c)


def test_the_arm_of_a_lever_is_how_its_ends_near_each_other(tmp_path):
    first, second = arms(routed(tmp_path, LEVER))
    h = 1e-6

    def length(q):  # between a point at rest and one that turns
        seen = np.radians(80.0) - q
        return np.hypot(0.28 - 0.032 * np.cos(seen), 0.032 * np.sin(seen))

    exact = (length(Q - h) - length(Q + h)) / (2 * h)
    np.testing.assert_allclose(first, exact, atol=1e-4 * exact.max())
    np.testing.assert_allclose(second, -exact[::-1], atol=1e-4 * exact.max())


def test_the_arms_of_tendons_are_those_of_the_body():
    robot = load_robot(EXAMPLES / "tendon_arm.toml")
    model = rb.arm_model(robot)
    data = rb.new_data(model)

    def lengths(q):
        data.qpos[2] = q
        rb.mujoco().mj_fwdPosition(model, data)
        return np.array([data.tendon(name).length[0] for name in robot.joint(3).tendons])

    exact = np.array([(lengths(q - 1e-5) - lengths(q + 1e-5)) / 2e-5 for q in Q])
    np.testing.assert_allclose(np.transpose(arms(robot, 3)), exact, atol=1e-4 * np.abs(exact).max())
    assert np.ptp(exact[:, 1]) > 0.01 and exact[0, 0] == pytest.approx(
        0.03
    )  # a wrapped roll and a straight line


@pytest.mark.parametrize("drive", [DRIVE, SPRUNG])
@pytest.mark.parametrize("routing", [RADIUS, LEVER, CAM, CAMS])
def test_torque_is_the_virtual_work_of_the_muscles(tmp_path, routing, drive):
    robot = routed(tmp_path, routing, drive, PLAIN)
    course = run_pressures(
        pneumatic_joint_parameters(robot, 1, 0), Q, np.tile([3e5, 2e5], (201, 1)), 9.0
    )
    shorter = np.gradient(
        course.contraction * robot.muscle("dmsp20").length, Q, axis=0, edge_order=2
    )
    np.testing.assert_allclose(
        course.torque, (course.force * shorter).sum(axis=1), atol=2e-4 * np.ptp(course.torque)
    )


def test_muscles_move_at_arm_times_angular_velocity(tmp_path):
    robot = routed(tmp_path, CAMS, changes=PLAIN)
    parameters = pneumatic_joint_parameters(robot, 1, 0)
    slow, fast = (
        run_pressures(parameters, Q, np.full((201, 2), 3e5), period) for period in (1e-1, 1e-3)
    )
    muscle = robot.muscle("dmsp20")
    for m, arm in enumerate(arms(robot)):
        v = [arm[1:] * np.diff(Q) / period for period in (1e-1, 1e-3)]
        held = [muscle.viscous_force * each / (muscle.viscous_speed + np.abs(each)) for each in v]
        taut = (slow.force[1:, m] > 0) & (fast.force[1:, m] > 0)
        difference = (slow.force - fast.force)[1:, m]
        np.testing.assert_allclose(difference[taut], (held[1] - held[0])[taut], rtol=1e-6)
        assert taut.sum() > 100


def test_play_and_tendons_in_series_move_along_the_same_arms():
    changes = {"joint.1.routing": "polynomial", "joint.1.moment_arm_m": [0.05, 0.01, -0.01]}
    robot = load_robot(conditions="realistic", changes=changes)
    parameters = pneumatic_joint_parameters(robot, 1, 0)
    plant = PneumaticJoint(parameters, 0)
    plant.reset(0.0, 3e5, 3e5, 0)
    for k in range(3000):
        q, speed, period = 0.4 * np.sin(k / 500), 0.0, 5e-4
        torque = plant.step(q, speed, 0.3 * np.sin(k / 100), -0.3 * np.sin(k / 100), period)
    state, place = plant.state, q + plant.gap
    assert plant.gap != 0.0 and min(state["stretch"]) > 0.0
    assert torque == pytest.approx(
        sum(polyval(place, a) * f for a, f in zip(parameters["arm"], state["force"], strict=True))
    )
    for m, arm in enumerate(parameters["arm"]):
        one = parameters["muscle"][m]
        told = Polynomial(arm).integ()(place) + state["stretch"][m]
        assert state["contraction"][m] == pytest.approx(
            robot.joint(1).middle + one["shift"] + told / one["length"]
        )


def test_a_spring_pulls_by_its_law_whatever_the_pressure_and_never_pushes(tmp_path):
    robot = routed(tmp_path, RADIUS, SPRUNG.replace("260", "20"))
    physics = pneumatic_joint_parameters(robot, 1, 3)
    found = [run_pressures(physics, Q, np.tile([3e5, p], (201, 1)), 0.1) for p in (0.0, 5e5)]
    for course in found:
        np.testing.assert_allclose(
            course.force[:, 1], np.maximum(0.0, 20.0 + 3000 * 0.03 * Q), atol=1e-9
        )
        assert (course.friction[:, 1] == 0).all() and (course.force[:, 1] == 0).any()
    assert np.array_equal(found[0].torque, found[1].torque)


@pytest.mark.slow
def test_calibration_finds_that_one_muscle_against_a_spring_has_half_the_effect(tmp_path):
    short = {
        "mean_pressures_bar": [2.2, 3.8],
        "loads_bar": [-0.8, 0.8],
        "sweep_s": 8.0,
        "degree": 3,
        "range_share": 0.5,
    }
    both, one = (
        calibrate(routed(tmp_path, LEVER, drive, {**PLAIN, "calibration": short}), 1)
        for drive in (DRIVE, SPRUNG)
    )
    assert one.b[0] == pytest.approx(both.b[0] / 2, rel=0.1)
    assert one.a[0] == pytest.approx(
        2 * one.b[0], rel=0.1
    )  # p_m raises the pressure of muscle 1 twice as dp does


def test_the_controller_knows_the_volumes_of_muscles_with_another_arm(tmp_path):
    robot = routed(tmp_path, CAMS, SPRUNG)
    volumes = controller_parameters(robot, 1, nominal_characteristic(robot, 1)).volume
    muscle = robot.muscle("dmsp20")
    kappa = 0.07 + Polynomial([0.03, 0.008, -0.01]).integ()(Q) / muscle.length
    exact = muscle.length * polyval(kappa, muscle.volume) + muscle.dead_volume
    np.testing.assert_allclose(polyval(Q, volumes[0]), exact, rtol=1e-3)
    assert len(volumes[1]) == 1 or not np.any(volumes[1][1:])


def test_a_check_tells_both_ways_apart_and_a_weak_spring_is_told(tmp_path):
    robot = routed(tmp_path, LEVER, SPRUNG)
    check = check_rig(robot)[1]
    assert (
        check.holds
        and check.held < check.pulls[-1].min()
        and np.ptp(check.back, axis=0).max() == 0.0
    )
    weak = robot.with_changes({"joint.1.spring_preload_N": 1.0, "joint.1.spring_N_m": 0.0})
    assert any("cannot be held" in words for words in cautions(weak, check_rig(weak)))


def test_a_log_of_one_muscle_alone_knows_nothing_of_its_routing(tmp_path):
    log = RigLog("rest", "force", np.zeros(12), np.full((12, 2), 3e5), np.linspace(0.0, 0.15, 12))
    one, other = (respond(routed(tmp_path, *how), 1, log) for how in ((RADIUS,), (LEVER, SPRUNG)))
    np.testing.assert_allclose(other, one, rtol=1e-9)
    assert one.min() > 0.0


def test_mechanisms_of_one_s_own_go_to_muscles_only(tmp_path):
    class Constant:
        def reset(self, contraction):
            pass

        def force(self, contraction, pressure, period):
            return 7.0

    plant = built_plant(routed(tmp_path, RADIUS, SPRUNG), 1, 0, (Constant(), Constant()))
    plant.reset(0.0, 3e5, 3e5, 0)
    plant.impose(0.0, 0.0, 3e5, 3e5, 1e-3)
    assert plant.state["friction"] == (7.0, 0.0)


@pytest.mark.parametrize(
    ("routing", "drive", "says"),
    [
        ("", DRIVE, "lacks radius_m"),
        ('routing = "lever"\nlever_m = [0.28, 0.032]', DRIVE, "lacks lever_angle_deg"),
        (f"{RADIUS}\nlever_m = [0.28, 0.032]", DRIVE, "Write joint.1.routing = 'lever'"),
        ('routing = "lever"\nlever_m = [0.032, 0.031]\nlever_angle_deg = 26', DRIVE, "no polynomial of degree 7"),
        ('routing = "lever"\nlever_m = [0.28, 0.032]\nlever_angle_deg = 20', DRIVE, "moment arm of muscle 1 is"),
        ('routing = "polynomial"\nmoment_arm_m = [-0.03]', DRIVE, "must shorten muscle 1"),
        ('routing = "polynomial"\nmoment_arm_m = [0.08]', DRIVE, "range_deg or moment_arm_m smaller"),
        (f'routing = "polynomial"\nmoment_arm_m = {[0.03] * 9}', DRIVE, "1 to 8 values"),
        ('routing = "tendon"\ntendons = ["a", "b"]', DRIVE, "needs a [body]"),
        ('routing = "rope"', DRIVE, "one of pulley, lever, polynomial, tendon"),
        (RADIUS, 'drives = ["spring", "dmsp20"]', "joint.1.drives = 'spring' is not in the file"),
        (RADIUS, 'drives = ["dmsp20", "spring"]', "lacks spring_N_m, spring_preload_N"),
        (RADIUS, f"{SPRUNG}\n[muscle.spring]\n", "muscle.spring"),
    ],
)  # fmt: skip
def test_routings_that_are_none_are_refused_by_name(tmp_path, routing, drive, says):
    with pytest.raises(ParameterError) as caught:
        routed(tmp_path, routing, drive)
    assert says in str(caught.value)


@pytest.mark.parametrize(
    ("names", "change", "says"),
    [
        (
            ("triceps", "bicep"),
            ("", ""),
            "'bicep' is no spatial tendon of the body's file. Did you mean biceps?",
        ),
        (("biceps", "triceps"), ("", ""), "moment arm of muscle 1 is"),
        (
            ("triceps", "biceps"),
            ('<site site="biceps from"/>', '<site site="front frame"/>'),
            "joint 1 (turn) moves",
        ),
        (("triceps", "biceps"), (' sidesite="below the elbow"', ""), "'triceps': over the range"),
    ],
)
def test_tendons_that_are_no_muscles_of_their_joint_are_refused_by_name(
    tmp_path, names, change, says
):
    body = (EXAMPLES / "tendon_arm.xml").read_text(encoding="utf-8")
    assert change[0] in body
    (tmp_path / "tendon_arm.xml").write_text(body.replace(*change), encoding="utf-8")
    text = (EXAMPLES / "tendon_arm.toml").read_text(encoding="utf-8")
    Path(tmp_path / "rig.toml").write_text(text, encoding="utf-8")
    robot = load_robot(tmp_path / "rig.toml", {"joint.3.tendons": list(names)})
    with pytest.raises(ParameterError) as caught:
        check_rig(robot)
    assert says in str(caught.value)
