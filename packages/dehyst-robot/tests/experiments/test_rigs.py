"""Rigs and arms of one's own: any number of joints, links from model files, references of the joints."""

import json
import re
import tomllib
from pathlib import Path

import numpy as np
import pytest

from dehyst.errors import ColumnError, OutputError, ParameterError
from dehyst_robot.arm import _rigid_body as rb
from dehyst_robot.arm import load_robot, pneumatic_joint_parameters, robot_of, sources
from dehyst_robot.arm._drawn import drawn_mjcf
from dehyst_robot.arm._joints import run_pressures
from dehyst_robot.commands import RigRequest
from dehyst_robot.commands._reproduce import QUICK
from dehyst_robot.commands._rig import run_rig
from dehyst_robot.experiments import (
    Request,
    controller_parameters,
    equip,
    nominal_characteristic,
    plan_path,
    reproduce,
    run_trial,
)
from dehyst_robot.experiments._gains import steady_pole
from dehyst_robot.experiments._reference import Moves, drawn_moves, read_moves
from dehyst_robot.experiments._rig import cautions, check_rig, new_rig
from dehyst_robot.report import write_reproduction_report
from dehyst_robot.report._arm import plane_of
from effort import no_hang
from places import ROOT

PACKAGED = load_robot(conditions="kind")
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
DRIVE = 'drive = "dmsp20"'
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
    file.write_text(
        f'extends = "parts"\nname = "rig"\n[body]\nfile = "{name}"\n{joints}', encoding="utf-8"
    )
    return load_robot(file)


@pytest.mark.parametrize("joints", [1, 2, 12])
def test_a_robot_has_the_joints_of_its_file_and_no_other(tmp_path, joints):
    robot = load_robot(rig(tmp_path, joints))
    assert (
        list(robot.joints)
        == list(robot.compensated)
        == list(robot.pneumatic)
        == list(range(1, joints + 1))
    )
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
        (0, "", "lacks joint.1.range_deg"),
        (2, "[path]\ncenter_m = [0.3, 0.0, 0.8]", "path.center_m"),
        (2, "[path]\nposture_weights = [1.0]", "one weight for each of the 2 joints"),
        (2, "[compensator]\njoints = [3]", "names joint 3; there are 1, 2"),
        (1, '[reference]\nfile = "none.csv"', "reference.file = 'none.csv' is not there"),
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
    np.testing.assert_allclose(
        rb.tool_positions(model, np.zeros((1, 2)))[0, 0], reach
    )  # no site: centre of mass
    weight = 9.81 * (1.0 * 0.1 * np.cos(np.radians(30)) + 0.5 * reach)
    np.testing.assert_allclose(-rb.bias_torque(model, np.zeros((1, 2)))[0, 0], weight)
    np.testing.assert_allclose(model.dof_damping, [0.3, 0.0])
    assert load_robot(tmp_path / "rig.toml") == robot and len(robot.fingerprint) == 16


def test_a_body_file_that_is_not_there_is_named(tmp_path):
    of_a_body(tmp_path, URDF, ["shoulder", "elbow"], "two.urdf")
    (tmp_path / "two.urdf").unlink()
    with pytest.raises(ParameterError, match=r"body.file = 'two.urdf' is not there"):
        load_robot(tmp_path / "rig.toml")


def test_a_changed_body_file_is_another_robot(tmp_path):
    before = of_a_body(tmp_path, URDF, ["shoulder", "elbow"], "two.urdf").fingerprint
    assert (
        of_a_body(
            tmp_path, URDF.replace("0.5", "0.6"), ["shoulder", "elbow"], "two.urdf"
        ).fingerprint
        != before
    )


def test_joints_of_a_body_that_no_one_names_are_locked_where_the_file_has_them(tmp_path):
    model = rb.arm_model(of_a_body(tmp_path, URDF, ["elbow"], "two.urdf"))
    assert model.nv == 1
    np.testing.assert_allclose(
        rb.joint_positions(model, np.zeros((1, 1)))[0, 0], [0.3, 0.0, 0.0], atol=1e-12
    )


@pytest.mark.parametrize(
    ("names", "change", "says"),
    [
        (["shoulder", "elbo"], ("", ""), "no hinge of 'two.urdf'. Did you mean elbow?"),
        (["elbow", "shoulder"], ("", ""), "from the base outwards: shoulder, elbow"),
        (["shoulder"], ('type="revolute"', 'type="prismatic"'), "no hinge"),
        (["shoulder"], ("<robot", "<rowboat"), "MuJoCo cannot use the body file"),
        (
            ["elbow"],
            ('<mass value="1.0"', '<mass value="0"'),
            "Give each link that moves an <inertial>",
        ),
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
    np.testing.assert_allclose(
        np.degrees(moves.at([2.0])[0]), [[10.0, -np.degrees(0.05)]], atol=1e-3
    )
    np.testing.assert_allclose(moves.at([6.5 - 1e-9])[0], [[0.0, 0.0]], atol=1e-6)
    assert moves.cycle([6.4, 6.6]).tolist() == [0, 1]
    derivatives_agree(moves)
    (tmp_path / "moves.csv").write_text(
        f"time_s,joint1_deg,joint2_rad\n{rows.replace('20.0', '200.0')}\n"
    )
    with pytest.raises(ParameterError, match="asks joint 1 for 200 deg, its range ends at 25 deg"):
        read_moves(robot, tmp_path / "moves.csv")
    (tmp_path / "moves.csv").write_text(f"time_s,joint1_deg,knee_deg\n{rows}\n")
    with pytest.raises(ColumnError, match="has no joint 2 column 'joint2'"):
        read_moves(robot, tmp_path / "moves.csv")


@pytest.mark.parametrize(
    ("rows", "says"),
    [
        ("0,0\n1,1\n1,2\n2,3\n3,4\n4,5\n5,6\n6,7", "share the time stamp"),
        ("6,0\n5,1\n4,2\n3,3\n2,4\n1,5\n0,6", "newest row first"),
        ("0,0\n1,1\n2,2\n0.5,3\n4,4\n5,5\n6,6\n7,7\n8,7\n9,7\n10,7", "time"),
    ],
)
def test_a_reference_whose_time_repeats_or_runs_back_is_refused(tmp_path, rows, says):
    file = _written(tmp_path / "moves.csv", f"time_s,joint1_deg\n{rows}\n")
    with pytest.raises(
        ParameterError, match=rf"moves.csv is no reference: .*{says}.*each time once"
    ):
        read_moves(load_robot(rig(tmp_path)), file)


def test_radians_in_degrees_and_milliseconds_in_seconds_are_warned_of_and_what_is_right_is_not(
    tmp_path, recwarn
):
    robot, t = load_robot(rig(tmp_path)), np.linspace(0.0, 4.0, 41)

    def read(angle, time, head="time_s,joint1_deg"):
        rows = "\n".join(f"{a:.6f},{b:.6f}" for a, b in zip(time, angle, strict=True))
        read_moves(robot, _written(tmp_path / "moves.csv", f"{head}\n{rows}\n"))

    angle = 20.0 * np.sin(t)
    read(angle, t)
    read(np.radians(angle), t, "time_s,joint1_rad")
    read(angle, 1e3 * t, "time_ms,joint1_deg")
    assert not recwarn.list
    with pytest.warns(
        UserWarning, match=r"by more than 0.349 deg, as if radians stood in a column of degrees"
    ):
        read(np.radians(angle), t)
    with pytest.warns(
        UserWarning, match=r"a row every 100 s, as if milliseconds stood in a column of seconds"
    ):
        read(angle, 1e3 * t)


@pytest.mark.parametrize(
    ("more", "first", "says"),
    [
        (
            'routing = "lever"\nlever_m = [0.28, 0.032]\nlever_angle_deg = 80\n',
            "",
            "routing = 'lever' has no pulley",
        ),
        ('body_joint = "shoulder"\n', '[body]\nfile = "two.urdf"\n', r"\[body\] has the links"),
    ],
)
def test_keys_that_would_do_nothing_are_refused_by_name(tmp_path, more, first, says):
    _written(tmp_path / "two.urdf", URDF)
    with pytest.raises(
        ParameterError, match=rf"joint.1.(radius_m|axis|link_\w+) = .* would do nothing: {says}"
    ):
        load_robot(rig(tmp_path, 1, more, first))


def test_moves_that_the_valves_cannot_follow_are_slowed_down(tmp_path):
    robot = load_robot(rig(tmp_path, 1, "[reference]\nmove_s = 0.05\n"))
    planned = plan_path(robot)
    assert isinstance(planned.timing, Moves) and planned.timing.factor > 1.5
    assert planned.start.tolist() == [0.0]


def test_the_plane_of_an_arc_is_found():
    turn = np.linspace(-0.5, 0.5, 20)
    right, up = plane_of(np.column_stack([np.cos(turn), 0 * turn, np.sin(turn)]))
    assert abs(right[1]) < 1e-9 and abs(up[1]) < 1e-9


EXAMPLES = ROOT / "examples" / "rigs"
SHORT = {
    "path.cycles_fast": 1,
    "homing.cycles": 3,
    "homing.period_s": 2.0,
    "reference": {"moves": 2, "move_s": 1.0},
}


def off(robot):
    """The fast trial with what data sheets tell."""
    kit = equip(robot, {n: nominal_characteristic(robot, n) for n in robot.pneumatic}, {})
    return run_trial(robot, plan_path(robot), kit, "fast", "off")[0]


def test_the_one_joint_rig_follows_its_reference_to_two_degrees():
    run = off(load_robot(EXAMPLES / "one_joint.toml", SHORT))
    assert run.angle.shape[1] == 1 and run.frames.shape[1:] == (2, 3) and run.figures == ("moves",)
    assert np.degrees(np.abs(run.error)).max() < 2.0 < 0.2 * np.degrees(np.ptp(run.desired))
    np.testing.assert_allclose(np.linalg.norm(run.tool - run.frames[0, 0], axis=1), 0.25, atol=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "left", "plant"),
    [
        ("one_joint", 0.5, "realistic"),
        ("planar_arm", 0.5, "realistic"),
        ("tendon_arm", 0.65, "realistic"),  # 0.60 in joint 3, as slow as all stand together
        ("lever_joint", 0.65, "kind"),  # 0.70 on the realistic plant, as the page says
    ],
)
def test_dehyst_reproduces_on_the_example_and_best_lowers_every_error(name, left, plant, tmp_path):
    robot = load_robot(
        EXAMPLES / f"{name}.toml", {**QUICK, "path.cycles_fast": 1}, conditions=plant
    )
    request = Request(
        plants=("preisach",), compensators=("best",), seeds=(0,), trials=("fast",), studies=False
    )
    result = reproduce(robot, request, tmp_path)
    joints = result.plants["preisach"].figures[0]["joints"]
    assert list(joints) == [str(n) for n in robot.pneumatic]
    for one in joints.values():
        assert (
            one["trials"]["fast"]["best"]["rms_deg"]
            < left * one["trials"]["fast"]["off"]["rms_deg"]
        )
    page = write_reproduction_report(result, tmp_path / "report.html").read_text(encoding="utf-8")
    assert "Errors of the tool" in page and 'id="arm"' in page and "By ISO 9283" not in page


@pytest.mark.parametrize(
    "joints", [1, *(pytest.param(count, marks=pytest.mark.slow) for count in (3, 12))]
)
def test_a_new_rig_can_be_loaded_holds_its_weight_and_says_what_is_assumed(tmp_path, joints):
    file = tmp_path / "new.toml"
    file.write_text(new_rig(file, joints), encoding="utf-8")
    robot = load_robot(file)
    found = check_rig(robot)
    assert list(found) == list(range(1, joints + 1))
    assert not any("cannot be held" in words for words in cautions(robot, found))
    own = {
        key: said
        for key, said in sources(file).items()
        if key.startswith("joint.") and not key.endswith("axis")
    }
    assert own and all("assumption" in said or "weak" in said for said in own.values())


@pytest.mark.slow
def test_a_new_rig_takes_joints_and_the_middle_of_their_ranges_from_a_model_file(tmp_path):
    (tmp_path / "two.urdf").write_text(URDF, encoding="utf-8")
    file = tmp_path / "new.toml"
    file.write_text(new_rig(file, body=tmp_path / "two.urdf"), encoding="utf-8")
    robot = load_robot(file)
    assert [joint.body_joint for joint in robot.joints.values()] == ["shoulder", "elbow"]
    np.testing.assert_allclose(
        [joint.zero for joint in robot.joints.values()], [0.5, 1.0], rtol=1e-3
    )
    with pytest.raises(
        ParameterError, match=r"has no hinge that a muscle could move: no joints at all"
    ):
        new_rig(file, body=_written(tmp_path / "none.xml", "<mujoco/>"))


MESH = '<collision><geometry><mesh filename="package://arm/{}"/></geometry></collision><inertial>'


def test_a_new_rig_locks_what_no_muscle_can_move_and_says_so(tmp_path):
    slides = URDF.replace('name="elbow" type="revolute"', 'name="elbow" type="prismatic"')
    slides = slides.replace("<inertial>", MESH.format("lost.dae"), 1)
    text = new_rig(tmp_path / "new.toml", body=_written(tmp_path / "two.urdf", slides))
    assert text.count("\n[joint.") == 1 and "# Locked there: elbow slides.\n" in text
    led = URDF.replace('upper="2" effort="100" velocity="10"/></joint></robot>', 'upper="2" effort="1" velocity="1"/>'
                       '<mimic joint="shoulder"/></joint></robot>')  # fmt: skip
    assert "elbow follows shoulder" in new_rig(
        tmp_path / "new.toml", body=_written(tmp_path / "two.urdf", led)
    )
    mesh = MESH.format("lost.stl").removesuffix("<inertial>")
    bare = re.sub("<inertial>.*?</inertial>", mesh, URDF, count=1, flags=re.DOTALL)
    with pytest.raises(
        ParameterError,
        match=r"link 'upper' of 'two.urdf' has no <inertial>, and the mesh 'package:",
    ):
        new_rig(tmp_path / "new.toml", body=_written(tmp_path / "two.urdf", bare))


@pytest.mark.parametrize(
    ("limits", "drive"),
    [((-1.0, 1.0), "dmsp20"), ((3.0, 6.0), "dmsp20"), ((-0.2, 0.2), "dmsp20"), (None, "dmsp20")],
)
def test_a_new_rig_turns_as_far_as_its_body_s_joint(tmp_path, limits, drive):
    name = 'say "knee" é'
    ends = (
        f'<limit lower="{limits[0]}" upper="{limits[1]}" effort="1" velocity="1"/>'
        if limits
        else ""
    )
    kind = "revolute" if limits else "continuous"
    body = f"""<robot name="r"><link name="base"/><link name="leg"><inertial>
<origin xyz="0.1 0 0"/><mass value="0.5"/><inertia ixx="0.001" ixy="0" ixz="0"
iyy="0.001" iyz="0" izz="0.001"/></inertial></link><joint name="{{}}" type="{kind}">
<parent link="base"/><child link="leg"/><axis xyz="0 1 0"/>{ends}</joint></robot>"""
    body = body.format(name.replace('"', "&quot;"))
    file = tmp_path / "new.toml"
    robot = load_robot(_written(file, new_rig(file, body=_written(tmp_path / "leg.urdf", body))))
    joint = robot.joint(1)
    assert joint.body_joint == name and joint.driven == (drive, drive)
    if limits:
        assert joint.zero == pytest.approx(sum(limits) / 2, abs=1e-3)
    reach = min((limits[1] - limits[0]) / 2 if limits else np.radians(25.0), np.radians(120.0))
    assert joint.range == pytest.approx(max(reach, np.radians(1.0)), rel=1e-3)
    assert not cautions(robot, check_rig(robot))


def test_joints_that_are_too_light_or_too_heavy_for_muscles_get_a_servo_and_a_reason(tmp_path):
    body = """<mujoco><worldbody><body><joint name="arm" axis="0 1 0"/>
<geom type="capsule" fromto="0 0 0 0.5 0 0" size="0.03" mass="{}"/></body></worldbody></mujoco>"""
    for mass, why in ((1e-4, "too stiff for this small inertia"), (300.0, "too weak for gravity")):
        text = new_rig(
            tmp_path / "new.toml", body=_written(tmp_path / "arm.xml", body.format(mass))
        )
        assert 'drive = "electric"' in text and why in text


def test_joints_in_frames_are_locked_where_they_are(tmp_path):
    body = """<mujoco><worldbody><frame pos="0 0 1" euler="0 0 90"><frame euler="30 0 0"><body pos="0.1 0 0">
<joint name="a" axis="0 1 0" ref="20"/><geom size="0.1"/><body pos="0.3 0 0"><joint name="b" axis="0 1 0"/>
<geom size="0.1" pos="0.2 0 0"/></body></body></frame></frame></worldbody></mujoco>"""
    both, alone = (
        of_a_body(tmp_path, body, names, "arm.xml", "zero_deg = 20.0")
        for names in (["a", "b"], ["b"])
    )
    angles = np.radians([[10.0, 5.0]])
    turned = rb.tool_positions(rb.arm_model(both), angles)
    held = rb.arm_model(both, moving=(2,), locked={1: angles[0, 0]})
    np.testing.assert_allclose(rb.tool_positions(held, angles[:, 1:]), turned, atol=1e-12)
    np.testing.assert_allclose(  # where the file has it: at 20 deg, which is its zero
        rb.tool_positions(rb.arm_model(alone), angles[:, 1:]), rb.tool_positions(rb.arm_model(both), angles * [0, 1]),
        atol=1e-12,
    )  # fmt: skip


@pytest.mark.exhaustive
def test_poles_that_joints_together_do_not_stand_are_told_with_those_that_they_do(tmp_path):
    file = tmp_path / "new.toml"
    chosen = load_robot(_written(file, new_rig(file, 2)), conditions="realistic")
    assert not cautions(chosen, check_rig(chosen)) and steady_pole(chosen) == np.inf
    fast = chosen.with_changes({f"joint.{n}.pole_1_s": 60.0 for n in (1, 2)})
    most = steady_pole(fast)
    assert 2.0 < most < 60.0
    assert steady_pole(fast, dict.fromkeys((1, 2), most)) == np.inf
    assert steady_pole(fast, dict.fromkeys((1, 2), 1.3 * most)) < np.inf
    assert (
        f"joint.1.pole_1_s = joint.2.pole_1_s = {np.floor(10 * most) / 10:g} or less"
        in cautions(fast, check_rig(fast))[0]
    )


@pytest.mark.parametrize("name", [None, "planar_arm", "tendon_arm"])
def test_drawn_muscles_move_with_their_moment_arms_and_pull_nothing(name):
    robot = PACKAGED if name is None else load_robot(EXAMPLES / f"{name}.toml")
    mujoco, plain = rb.mujoco(), rb.arm_model(robot)
    model = mujoco.MjModel.from_xml_string(drawn_mjcf(robot))
    assert model.nu == 0 and model.ntendon == 2 * len(
        robot.pneumatic
    )  # those of the file itself among them
    np.testing.assert_allclose(model.dof_damping, plain.dof_damping)
    q = RNG.uniform(-0.3, 0.3, (4, model.nv))
    np.testing.assert_allclose(
        rb.bias_torque(model, q), rb.bias_torque(plain, q), rtol=1e-4, atol=1e-4
    )
    data = mujoco.MjData(model)
    for row, (number, joint) in enumerate(robot.joints.items()):
        for muscle in (1, 2) if joint.pneumatic and joint.routing == "pulley" else ():
            tendon, lengths = model.tendon(f"muscle {number}.{muscle}").id, []
            for angle in (-1e-5, 1e-5):
                data.qpos[:] = 0.0
                data.qpos[row] = angle
                mujoco.mj_forward(model, data)
                lengths.append(data.ten_length[tendon])
            arm = (lengths[0] - lengths[1]) / 2e-5
            assert arm == pytest.approx((1.5 - muscle) * 2 * joint.radius, rel=1e-4)


def test_two_joints_on_one_hinge_of_the_body_are_refused_by_its_name(tmp_path):
    with pytest.raises(
        ParameterError, match=r"2 joints have body_joint = 'elbow'.*shoulder, elbow"
    ):
        rb.arm_model(of_a_body(tmp_path, URDF, ["elbow", "elbow"], "two.urdf"))


def _written(file, text):
    file.write_text(text, encoding="utf-8")
    return file


def test_torques_of_a_check_are_force_times_radius_and_its_frequency_that_of_a_spring(tmp_path):
    robot = load_robot(rig(tmp_path))
    check = check_rig(robot)[1]
    assert (np.diff(check.pulls, axis=0) >= 0).all() and (
        np.diff(check.pulls, axis=1) <= 1e-9
    ).all()
    assert check.frequency == pytest.approx(np.sqrt(check.stiffness / check.inertia) / (2 * np.pi))
    heavy, slow = (
        {"joint.1.link_mass_kg": 30.0},
        {"joint.1.pole_1_s": 8.0, "joint.1.damping_Nm_s": 0.4},
    )
    for changes, says in ((heavy, "cannot be held"), (slow, "softer than its own muscles")):
        changed = robot.with_changes({**changes, "controller.pressure_gain_1_s": 30.0})
        assert says in cautions(changed, check_rig(changed))[0]


@pytest.mark.slow
def test_the_command_writes_checks_and_refuses(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    run_rig(RigRequest("new", Path("rig.toml"), joints=2))
    run_rig(RigRequest("check", Path("rig.toml"), figure=Path("rig.svg"), mjcf=Path("rig.xml")))
    printed = capsys.readouterr().out
    assert (
        "natural" in printed
        and "numbers are assumptions" in printed
        and Path("rig.svg").stat().st_size > 1000
    )
    assert '<spatial name="muscle 2.1"' in Path("rig.xml").read_text()
    run_rig(RigRequest("check", Path("rig.toml"), json=True))
    assert json.loads(capsys.readouterr().out)["joints"]["2"]["drives"] == ["dmsp20", "dmsp20"]
    for request, says in (
        (RigRequest("weld", Path("rig.toml")), "Type one of: new, check"),
        (RigRequest("new", Path("other.toml"), joints=13), "1 to 12"),
        (
            RigRequest("new", Path("other.toml"), joints=1, from_urdf=Path("a.urdf")),
            "Type one of them",
        ),
        (RigRequest("new", Path("other.toml"), from_urdf=Path("a.urdf")), "is not there"),
    ):
        with pytest.raises(ParameterError, match=says):
            run_rig(request)
    with pytest.raises(OutputError, match="exists already"):
        run_rig(RigRequest("new", Path("rig.toml")))


def test_two_muscles_side_by_side_are_twice_one_in_force_loop_and_air(tmp_path):
    robot = load_robot(rig(tmp_path))
    twice = robot.with_changes({"joint.1.parallel": 2})
    q = 0.3 * np.sin(np.linspace(0.0, 12.0, 400))
    p = np.full((400, 2), 2e5)
    one, two = (
        run_pressures(pneumatic_joint_parameters(each, 1, 0), q, p, 0.05) for each in (robot, twice)
    )
    np.testing.assert_allclose(two.torque, 2 * one.torque, rtol=1e-9)
    np.testing.assert_allclose(two.friction, 2 * one.friction, rtol=1e-9)
    plan = [nominal_characteristic(each, 1) for each in (robot, twice)]
    np.testing.assert_allclose(plan[1].b, 2 * plan[0].b)
    volumes = [controller_parameters(each, 1, plan[0]).volume for each in (robot, twice)]
    np.testing.assert_allclose(volumes[1], 2 * np.array(volumes[0]))


def test_each_muscle_of_a_joint_has_its_own_type(tmp_path):
    robot = load_robot(rig(tmp_path))
    mixed = robot_of(
        tomllib.loads(
            (tmp_path / "rig.toml").read_text().replace(DRIVE, 'drives = ["dmsp20", "dmsp40"]')
        ),
        "mixed.toml",
    )
    q, p = np.linspace(-0.3, 0.3, 20), np.full((20, 2), 2e5)
    first, both = (
        run_pressures(pneumatic_joint_parameters(each, 1, 0), q, p, 9.0) for each in (robot, mixed)
    )
    np.testing.assert_allclose(both.force[:, 0], first.force[:, 0])
    assert (both.force[:, 1] > 2 * first.force[:, 1]).all()
    assert [len(check.pulls) for check in check_rig(mixed).values()] == [6]


@pytest.mark.parametrize(
    ("said", "says"),
    [
        ("", "lacks joint.1.drive"),
        ('drives = ["dmsp20", "electric"]', "joint.1.drives"),
        ('drives = ["dmsp20"]', "of 2"),
        ('drive = "dmsp20"\ndrives = ["dmsp20", "dmsp20"]', "has both drives and joint.1.drive"),
    ],
)
def test_drives_that_are_none_are_refused(tmp_path, said, says):
    text = rig(tmp_path).read_text().replace(DRIVE, said)
    with pytest.raises(ParameterError) as caught:
        robot_of(tomllib.loads(text), "rig.toml")
    assert says in str(caught.value)


def chain(joints):
    """A URDF file of a chain."""
    inertia = '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
    links = "".join(f'<link name="l{k}">{inertia}</link>' for k in range(joints + 1))
    return f"<robot name='r'>{links}" + "".join(
        f'<joint name="j{k}" type="revolute"><parent link="l{k}"/><child link="l{k + 1}"/><axis xyz="0 0 1"/>'
        f'<origin xyz="0.1 0 0"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>'
        for k in range(joints)
    ) + "</robot>"  # fmt: skip


COPIED = """<mujoco><worldbody><replicate count="100000"><replicate count="1000"><geom size="1"/></replicate>
</replicate></worldbody></mujoco>"""
FLAT = "<mujoco><worldbody>" + '<body><geom size="1"/></body>' * 1200 + "</worldbody></mujoco>"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (chain(1499), "has 1499 joints; dehyst reads body files of up to 120"),
        (COPIED, r"asks for 1e\+08 copies"),
        (FLAT, "has 1201 bodies"),
    ],
)
def test_a_body_file_that_is_too_large_is_counted_before_any_work(tmp_path, text, words):
    file = tmp_path / ("arm.urdf" if text.startswith("<robot") else "arm.xml")
    file.write_text(text)
    with no_hang(words), pytest.raises(ParameterError, match=words):
        new_rig(tmp_path / "rig.toml", body=file)
