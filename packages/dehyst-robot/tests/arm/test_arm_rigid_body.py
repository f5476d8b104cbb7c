"""The arm's rigid body agrees with mechanics done by hand, and steps from outside Python."""

import ctypes
import subprocess
import sys
from types import SimpleNamespace

import numpy as np
import pytest

import arm_oracle
from dehyst.errors import MissingExtraError, ParameterError
from dehyst_robot.arm import _rigid_body as rb
from dehyst_robot.arm import load_robot

mujoco = pytest.importorskip("mujoco")

ROBOT = load_robot(conditions="kind")
MODEL = rb.arm_model(ROBOT)
RNG = np.random.default_rng(7)
POSES = RNG.uniform(-0.6, 0.6, (12, 7))


def test_joints_and_tool_are_where_rotation_matrices_put_them():
    expected = np.array([arm_oracle.frames(ROBOT, q)[0] for q in POSES])
    np.testing.assert_allclose(rb.joint_positions(MODEL, POSES), expected, atol=1e-13)
    np.testing.assert_allclose(rb.tool_positions(MODEL, POSES), expected[:, 7], atol=1e-13)


def test_the_tool_stands_in_the_middle_of_the_test_cube_in_the_zero_pose():
    assert np.linalg.norm(arm_oracle.tool(ROBOT, np.zeros(7)) - ROBOT.path.center) < 2e-6


def test_joint_1_moves_the_tool_to_the_left_joint_2_down():
    at_rest, yaw, pitch = (
        arm_oracle.tool(ROBOT, q) for q in (np.zeros(7), 0.1 * np.eye(7)[0], 0.1 * np.eye(7)[1])
    )
    assert yaw[1] > at_rest[1]
    assert abs(yaw[2] - at_rest[2]) < 1e-12
    assert pitch[2] < at_rest[2]


@pytest.mark.parametrize("payload", [0.0, 2.5])
def test_holding_torque_is_the_slope_of_the_potential_energy(payload):
    model = rb.arm_model(ROBOT, payload=payload)
    expected = [
        arm_oracle.gradient(lambda x: arm_oracle.potential_energy(ROBOT, x, payload), q)
        for q in POSES
    ]
    np.testing.assert_allclose(rb.bias_torque(model, POSES), expected, atol=2e-7)


def test_inertia_is_that_of_the_kinetic_energy():
    expected = [np.diag(arm_oracle.mass_matrix(ROBOT, q)) for q in POSES]
    np.testing.assert_allclose(rb.joint_inertia(MODEL, POSES), expected, rtol=1e-6)
    assert rb.joint_inertia(MODEL).shape == (7,)


def test_inverse_dynamics_holds_inertia_gravity_and_bearing_once_each():
    q, qdd = POSES[:4], RNG.standard_normal((4, 7))
    still = rb.inverse_dynamics(MODEL, q, np.zeros((4, 7)), qdd)
    expected = [arm_oracle.mass_matrix(ROBOT, a) @ b for a, b in zip(q, qdd, strict=True)]
    np.testing.assert_allclose(still - rb.bias_torque(MODEL, q), expected, atol=1e-6)
    qd = RNG.standard_normal((4, 7))
    odd = rb.inverse_dynamics(MODEL, q, qd, qdd) - rb.inverse_dynamics(MODEL, q, -qd, qdd)
    damping = [ROBOT.joint(n).damping for n in range(1, 8)]
    np.testing.assert_allclose(odd / 2, qd * damping, atol=1e-12)


def test_torques_of_the_inverse_dynamics_make_the_physics_follow_the_motion():
    t = np.arange(2001)[:, None] * ROBOT.simulation.period
    amplitude, w = np.array([0.2, 0.1, 0.1, 0.15, 0.1, 0.1, 0.1]), 6.0
    q, qd, qdd = (
        amplitude * np.sin(w * t),
        w * amplitude * np.cos(w * t),
        -(w**2) * amplitude * np.sin(w * t),
    )
    torque = rb.inverse_dynamics(MODEL, q, qd, qdd)
    data = rb.new_data(MODEL)
    data.qvel[:] = qd[0]
    for row in torque[:-1]:
        data.qfrc_applied[:] = row
        mujoco.mj_step(MODEL, data)
    np.testing.assert_allclose(data.qpos, q[-1], atol=6e-3)  # first order in the period
    np.testing.assert_allclose(data.qpos[:4], q[-1, :4], atol=2e-3)


def test_without_bearings_and_drives_the_energy_stays():
    robot = ROBOT.with_changes({f"joint.{n}.damping_Nm_s": 0.0 for n in range(1, 8)})
    model = rb.arm_model(robot)
    model.opt.integrator = mujoco.mjtIntegrator.mjINT_RK4
    data = rb.new_data(model)
    start = arm_oracle.potential_energy(robot, np.zeros(7))
    for _ in range(1000):
        mujoco.mj_step(model, data)
    q, qd = data.qpos.copy(), data.qvel.copy()
    assert np.abs(qd).max() > 1.0
    kinetic = qd @ arm_oracle.mass_matrix(robot, q) @ qd / 2
    assert arm_oracle.potential_energy(robot, q) + kinetic == pytest.approx(
        start, abs=1e-4 * kinetic
    )


def test_locked_joints_stay_at_their_angle_and_leave_the_rest_alone():
    locked = {2: 0.2, 4: -0.3}
    model = rb.arm_model(ROBOT, moving=(1, 3, 5, 6, 7), locked=locked)
    q = POSES.copy()
    q[:, 1], q[:, 3] = 0.2, -0.3
    free = q[:, [0, 2, 4, 5, 6]]
    np.testing.assert_allclose(
        rb.tool_positions(model, free), rb.tool_positions(MODEL, q), atol=1e-13
    )
    expected = rb.bias_torque(MODEL, q)[:, [0, 2, 4, 5, 6]]
    np.testing.assert_allclose(rb.bias_torque(model, free), expected, atol=1e-9)
    assert rb.joint_positions(model, free).shape == (12, 6, 3)


def test_a_mass_error_scales_every_torque_of_gravity():
    lighter = rb.arm_model(ROBOT, mass_error=-0.2)
    np.testing.assert_allclose(rb.bias_torque(lighter, POSES), 0.8 * rb.bias_torque(MODEL, POSES))


def test_the_model_has_no_contacts_and_no_constraints_and_the_period_of_the_file():
    data = rb.new_data(MODEL)
    data.qpos[:] = 5.0
    mujoco.mj_step(MODEL, data)
    assert (data.ncon, data.nefc) == (0, 0)
    assert MODEL.opt.timestep == ROBOT.simulation.period


def test_steps_by_address_are_the_steps_of_mujoco_bit_for_bit():
    step = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p)(rb.mj_step_address())
    ours, theirs = rb.new_data(MODEL), rb.new_data(MODEL)
    for _ in range(50):
        step(MODEL._address, ours._address)
        mujoco.mj_step(MODEL, theirs)
    assert ours.time == pytest.approx(0.025)
    assert ours.qpos.tobytes() == theirs.qpos.tobytes()


def test_a_missing_library_is_named_with_the_cure(monkeypatch, tmp_path):
    (tmp_path / "libmujoco.so.9").write_bytes(b"not a library")
    fake = SimpleNamespace(__file__=str(tmp_path / "__init__.py"), __version__="9")
    monkeypatch.setattr(rb, "mujoco", lambda: fake)
    with pytest.raises(MissingExtraError, match=r"libmujoco\.so\.9.*pip install"):
        rb.mj_step_address.__wrapped__()


@pytest.mark.slow
def test_without_mujoco_the_rooms_import_and_say_what_to_install():
    code = """
import sys
sys.modules["mujoco"] = sys.modules["mink"] = None
from dehyst.errors import MissingExtraError
from dehyst_robot.arm import _rigid_body, load_robot
import dehyst_robot.arm._kinematics, dehyst_robot.arm._joints
for call in (lambda: _rigid_body.arm_model(load_robot(conditions="kind")), _rigid_body.mj_step_address):
    try:
        call()
    except MissingExtraError as fault:
        print(fault)
"""
    out = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    ).stdout
    assert out.count("pip install dehyst-robot") == 2


@pytest.mark.parametrize(
    "call",
    [
        lambda: rb.arm_model(ROBOT, moving=()),
        lambda: rb.arm_model(ROBOT, moving=(2, 1)),
        lambda: rb.arm_model(ROBOT, moving=(1, 8)),
        lambda: rb.arm_model(ROBOT, payload=-1.0),
        lambda: rb.arm_model(ROBOT, locked={1: 0.1}),
        lambda: rb.arm_model(ROBOT, moving=(1,), locked={2: np.nan}),
        lambda: rb.arm_model(ROBOT, mass_error=-1.0),
        lambda: rb.bias_torque(MODEL, np.zeros((3, 5))),
    ],
)
def test_what_is_no_arm_and_no_pose_is_refused(call):
    with pytest.raises(ParameterError):
        call()


def test_a_version_of_mujoco_that_fuses_links_wrongly_is_refused(monkeypatch):
    import mujoco

    monkeypatch.setattr(mujoco, "__version__", "3.9.0")
    with pytest.raises(MissingExtraError, match=r"pip install 'mujoco>=3\.14'"):
        rb.mujoco()
