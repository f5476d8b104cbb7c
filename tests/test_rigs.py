"""Rigs and arms of one's own: any number of joints, links from model files, references of the joints."""

import re

import numpy as np
import pytest

from dehyst.errors import ParameterError
from dehyst.robot.arm import load_robot
from dehyst.robot.arm import rigid_body as rb
from dehyst.robot.experiments.path import plan_path
from dehyst.robot.experiments.reference import Moves, drawn_moves, read_moves
from dehyst.robot.report.arm import plane_of

PACKAGED = load_robot()
JOINT = """
[joint.{n}]
drive = "dmsp20"
valve = "mpye_small"
axis = "pitch"
range_deg = 25.0
radius_m = 0.03
contraction = 0.07
damping_Nm_s = 0.1
pole_1_s = 25.0
link_length_m = 0.2
link_radius_m = 0.02
link_mass_kg = 0.4
"""
URDF = """<robot name="two"><link name="base"/>
<link name="upper"><inertial><origin xyz="0.1 0 0"/><mass value="1.0"/>
<inertia ixx="0.001" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/></inertial></link>
<link name="lower"><inertial><origin xyz="0.1 0 0"/><mass value="0.5"/>
<inertia ixx="0.001" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/></inertial></link>
<joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/><axis xyz="0 1 0"/>
<limit lower="-1" upper="2" effort="100" velocity="10"/><dynamics damping="0.3"/></joint>
<joint name="elbow" type="revolute"><parent link="upper"/><child link="lower"/><origin xyz="0.3 0 0"/>
<axis xyz="0 1 0"/><limit lower="0" upper="2" effort="100" velocity="10"/></joint></robot>"""
RNG = np.random.default_rng(3)


def rig(folder, joints=1, more="", first="", **keys):
    """A robot file with `joints` equal joints, and what `keys` say of all of them."""
    said = "".join(JOINT.format(n=n) for n in range(1, joints + 1))
    for key, value in keys.items():
        said = re.sub(rf"{key} = .*\n", f"{key} = {value}\n" if value is not None else "", said)
    file = folder / "rig.toml"
    file.write_text(f'extends = "parts"\nname = "rig"\n{first}{said}{more}', encoding="utf-8")
    return file


def of_a_body(folder, text, names, name="body.xml", more=""):
    """A robot whose links are those of a model file."""
    (folder / name).write_text(text, encoding="utf-8")
    joints = "".join(
        f'[joint.{n}]\ndrive = "electric"\nrange_deg = 60.0\nbody_joint = "{joint}"\n{more}\n'
        for n, joint in enumerate(names, 1)
    )
    file = folder / "rig.toml"
    file.write_text(f'extends = "parts"\nname = "rig"\n[body]\nfile = "{name}"\n{joints}', encoding="utf-8")
    return load_robot(file)


@pytest.mark.parametrize("joints", [1, 2, 12])
def test_a_robot_has_the_joints_of_its_file_and_no_other(tmp_path, joints):
    robot = load_robot(rig(tmp_path, joints))
    assert list(robot.joints) == list(robot.compensated) == list(robot.pneumatic) == list(range(1, joints + 1))
    model = rb.arm_model(robot)
    assert model.nv == joints
    straight = rb.joint_positions(model, np.zeros((1, joints)))[0]
    np.testing.assert_allclose(np.diff(straight[:, 0]), 0.2, atol=1e-12)


def test_the_joints_of_the_paper_that_are_compensated_are_the_large_ones():
    assert PACKAGED.compensated == (1, 2, 4)
    assert PACKAGED.with_changes({"joint.4.drive": "electric"}).compensated == (1, 2)


@pytest.mark.parametrize(
    ("joints", "more", "says"),
    [
        (1, JOINT.format(n=3), "[joint] has 1, 2, numbered without a gap up to 12"),
        (13, "", "no joint.13"),
        (0, "", "lacks joint.1.drive"),
        (2, "[path]\ncenter_m = [0.3, 0.0, 0.8]", "path.center_m"),
        (2, "[path]\nposture_weights = [1.0]", "one weight for each of the 2 joints"),
        (2, "[compensator]\njoints = [3]", "names joint 3; there are 1, 2"),
        (1, '[reference]\nfile = "none.csv"', "reference.file = 'none.csv' is not there"),
        (1, '[body]\nfile = "none.xml"', "body.file = 'none.xml' is not there"),
        (1, "[refrence]\nmoves = 3", "Did you mean reference?"),
    ],
)
def test_what_a_robot_cannot_be_is_refused_by_name(tmp_path, joints, more, says):
    with pytest.raises(ParameterError) as caught:
        load_robot(rig(tmp_path, joints, more))
    assert says in str(caught.value)


def test_a_chain_names_what_its_links_lack(tmp_path):
    with pytest.raises(ParameterError, match=r"lacks joint\.1\.axis, joint\.1\.link_mass_kg"):
        load_robot(rig(tmp_path, axis=None, link_mass_kg=None))


@pytest.mark.parametrize("fused", [False, True])
@pytest.mark.parametrize("moving", [None, (1, 2, 4), (6,)])
def test_the_paper_s_arm_from_its_own_mjcf_file_is_the_same_arm(tmp_path, moving, fused):
    text = rb.arm_mjcf(PACKAGED, set(PACKAGED.joints), 0.0, 1.0, {})
    twin = of_a_body(tmp_path, text, [f"joint {n}" for n in PACKAGED.joints])
    locked = {n: 0.1 * n for n in PACKAGED.joints if moving is not None and n not in moving}
    one, other = (
        rb.arm_model(robot, moving, payload=0.7, mass_error=-0.2, locked=locked, fused=fused)
        for robot in (PACKAGED, twin)
    )
    q = RNG.uniform(-0.4, 0.4, (5, one.nv))
    for ask in (rb.bias_torque, rb.joint_inertia, rb.tool_positions, rb.joint_positions):
        np.testing.assert_allclose(ask(other, q), ask(one, q), rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(other.dof_damping, one.dof_damping)


def test_a_urdf_is_read_its_bearings_kept_and_its_zero_moved(tmp_path):
    robot = of_a_body(tmp_path, URDF, ["shoulder", "elbow"], "two.urdf", "zero_deg = 30.0")
    model = rb.arm_model(robot)
    reach = 0.3 * np.cos(np.radians(30)) + 0.1 * np.cos(np.radians(60))
    np.testing.assert_allclose(rb.tool_positions(model, np.zeros((1, 2)))[0, 0], reach)  # no site: centre of mass
    weight = 9.81 * (1.0 * 0.1 * np.cos(np.radians(30)) + 0.5 * reach)
    np.testing.assert_allclose(-rb.bias_torque(model, np.zeros((1, 2)))[0, 0], weight)
    np.testing.assert_allclose(model.dof_damping, [0.3, 0.0])
    assert load_robot(tmp_path / "rig.toml") == robot and len(robot.fingerprint) == 16


def test_a_changed_body_file_is_another_robot(tmp_path):
    before = of_a_body(tmp_path, URDF, ["shoulder", "elbow"], "two.urdf").fingerprint
    assert of_a_body(tmp_path, URDF.replace("0.5", "0.6"), ["shoulder", "elbow"], "two.urdf").fingerprint != before


def test_joints_of_a_body_that_no_one_names_are_locked_where_the_file_has_them(tmp_path):
    model = rb.arm_model(of_a_body(tmp_path, URDF, ["elbow"], "two.urdf"))
    assert model.nv == 1
    np.testing.assert_allclose(rb.joint_positions(model, np.zeros((1, 1)))[0, 0], [0.3, 0.0, 0.0], atol=1e-12)


@pytest.mark.parametrize(
    ("names", "change", "says"),
    [
        (["shoulder", "elbo"], ("", ""), "no hinge of 'two.urdf'. Did you mean elbow?"),
        (["elbow", "shoulder"], ("", ""), "from the base outwards: shoulder, elbow"),
        (["shoulder"], ('type="revolute"', 'type="prismatic"'), "no hinge"),
        (["shoulder"], ("<robot", "<rowboat"), "MuJoCo cannot use the body file"),
    ],
)
def test_a_body_that_does_not_fit_its_robot_is_refused(tmp_path, names, change, says):
    with pytest.raises(ParameterError) as caught:
        rb.arm_model(of_a_body(tmp_path, URDF.replace(*change), names, "two.urdf"))
    assert says in str(caught.value)


def derivatives_agree(moves):
    t, h = np.linspace(0.1, moves.duration - 0.1, 50), 1e-4
    before, now, after = (moves.at(t + k * h) for k in (-1, 0, 1))
    np.testing.assert_allclose(now[1], (after[0] - before[0]) / (2 * h), atol=1e-5)
    np.testing.assert_allclose(now[2], (after[1] - before[1]) / (2 * h), atol=1e-2)


def test_drawn_moves_cover_each_joint_s_range_rest_and_come_back():
    moves = drawn_moves(PACKAGED)
    q, v, _ = moves.at(np.linspace(0.0, moves.duration, 3001)[:-1])
    reach = 0.6 * np.array([joint.range for joint in PACKAGED.joints.values()])
    assert (q.max(axis=0) > 0.75 * reach).all() and (q.min(axis=0) < -0.75 * reach).all()
    assert (np.abs(q) <= reach).all() and np.abs(q[[0, -1]]).max() < 1e-3
    assert (np.abs(v).max(axis=1) == 0).mean() > 0.1  # rests
    derivatives_agree(moves)
    derivatives_agree(moves.slower(3.0))


def test_a_reference_is_read_from_a_log_and_led_back_to_its_start(tmp_path):
    robot, t = load_robot(rig(tmp_path, 2)), np.linspace(5.0, 9.0, 81)
    rise = np.sin(np.pi * (t - 5.0) / 8.0) ** 2
    rows = "\n".join(f"{a:.3f},{20 * b:.6f},{-0.1 * b:.6f}" for a, b in zip(t, rise, strict=True))
    (tmp_path / "moves.csv").write_text(f"time_s,joint1_deg,joint2_rad\n{rows}\n")
    moves = read_moves(robot, tmp_path / "moves.csv")
    assert moves.duration == pytest.approx(4.0 + 2.5)
    np.testing.assert_allclose(np.degrees(moves.at([2.0])[0]), [[10.0, -np.degrees(0.05)]], atol=1e-3)
    np.testing.assert_allclose(moves.at([6.5 - 1e-9])[0], [[0.0, 0.0]], atol=1e-6)
    assert moves.cycle([6.4, 6.6]).tolist() == [0, 1]
    derivatives_agree(moves)
    (tmp_path / "moves.csv").write_text(f"time_s,joint1_deg,joint2_rad\n{rows.replace('20.0', '200.0')}\n")
    with pytest.raises(ParameterError, match="asks joint 1 for 200 deg, its range ends at 25 deg"):
        read_moves(robot, tmp_path / "moves.csv")


def test_moves_that_the_valves_cannot_follow_are_slowed_down(tmp_path):
    robot = load_robot(rig(tmp_path, 1, "[reference]\nmove_s = 0.05\n"))
    planned = plan_path(robot)
    assert isinstance(planned.timing, Moves) and planned.timing.factor > 1.5
    assert planned.start.tolist() == [0.0]


def test_the_plane_of_an_arc_is_found():
    turn = np.linspace(-0.5, 0.5, 20)
    right, up = plane_of(np.column_stack([np.cos(turn), 0 * turn, np.sin(turn)]))
    assert abs(right[1]) < 1e-9 and abs(up[1]) < 1e-9
