"""The plugin dehyst.muscle is the plant's muscle inside any MuJoCo model."""

import copy
import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path
from xml.etree.ElementTree import fromstring

import mujoco
import numpy as np
import pytest
from mujoco import rollout

from dehyst.errors import MissingExtraError, ParameterError
from dehyst_robot import mujoco_plugin
from dehyst_robot.arm import JointBench, load_robot
from dehyst_robot.arm._joints import built_plant
from dehyst_robot.arm._mechanisms import BUILDERS, PLANTS
from dehyst_robot.arm._rigid_body import arm_mjcf
from dehyst_robot.mujoco_plugin import actuator_xml, load
from places import ROBOT, ROOT

PERIOD = 0.0005
ARM = """<mujoco><extension><plugin plugin="dehyst.muscle"/><plugin plugin="mujoco.pid"/></extension>
<option timestep="0.0005"/><worldbody><body><joint name="j" axis="0 1 0" damping="1"/>
<geom type="capsule" fromto="0 0 0 0 0 -.3" size=".04"/></body></worldbody><actuator>
<plugin plugin="mujoco.pid" joint="j" actdim="1"><config key="ki" value="1"/><config key="kp" value="1"/></plugin>
<plugin plugin="dehyst.muscle" joint="j" gear="-.05">{config}</plugin>
<plugin plugin="dehyst.muscle" joint="j" gear=".05"/></actuator></mujoco>"""

load()


def robot_of(mechanism):
    return load_robot(
        conditions="kind", changes={"hysteresis.mechanism": mechanism, "joint.1.range_deg": 30.0}
    )


def as_plugin(robot, drive, fused=True):
    radius = robot.joint(1).radius
    lines = [
        actuator_xml(robot, 1, m, joint="joint 1", gear=(-radius, radius)[m], drive=drive)
        for m in (0, 1)
    ]
    xml = arm_mjcf(robot, {1}, robot.payload.mass, 1.0, {}, fused=fused).replace(
        "<worldbody>", '<extension><plugin plugin="dehyst.muscle"/></extension><worldbody>'
    )
    model = mujoco.MjModel.from_xml_string(
        xml.replace("</mujoco>", f"<actuator>{''.join(lines)}</actuator></mujoco>")
    )
    return model, mujoco.MjData(model)


def valves(k):
    return 0.6 * np.sin(k * 0.004), -0.5 * np.sin(k * 0.0043)


# What a whole joint or arm has and a muscle has not, and draws of which a muscle of MuJoCo has its own.
ALONE = {"joint.1.backlash_deg": 0, "simulation.command_delay_s": 0, "simulation.command_jitter_s": 0,
         "air.supply_volume_l": 0, "hysteresis.scatter": 0}  # fmt: skip
REALISTIC = load_robot(changes={**ALONE, "joint.1.range_deg": 30.0}, conditions="realistic")


@pytest.mark.parametrize("mechanism", [*PLANTS, "realistic"])
def test_with_valves_it_moves_as_the_bench_does(mechanism):
    robot = REALISTIC if mechanism == "realistic" else robot_of(mechanism)
    bench, (model, data) = JointBench(robot, 1), as_plugin(robot, "valve")
    angles = []
    for k in range(6000):
        bench.step([valves(k)])
        data.ctrl[:] = valves(k)
        mujoco.mj_step(model, data)
        angles.append((bench.angles[0], data.qpos[0]))
    ours, theirs = np.array(angles).T
    assert np.ptp(ours) > 0.2
    np.testing.assert_allclose(theirs, ours, rtol=0, atol=1e-9)
    plant = bench._plants[1].state
    for m, at in enumerate(model.plugin_stateadr):
        expected = [plant[name][m] for name in ("pressure", "contraction", "force", "friction")]
        expected[0] -= robot.air.ambient
        np.testing.assert_allclose(data.plugin_state[at : at + 4], expected, rtol=1e-9)


@pytest.mark.parametrize("mechanism", BUILDERS)
def test_with_imposed_pressures_it_has_the_torque_of_the_plant(mechanism):
    robot = robot_of(mechanism)
    plant, (model, data) = built_plant(robot, 1, 0), as_plugin(robot, "pressure", fused=False)
    mean = robot.controller.mean_pressure
    plant.reset(0.0, mean, mean, 0)
    largest = 0.0
    for k in range(4000):
        pressure = 3e5 + 1.5e5 * np.sin(k * 0.003), 3e5 - 1.2e5 * np.sin(k * 0.0034)
        torque = plant.impose(data.qpos[0], data.qvel[0], *pressure, PERIOD)
        data.ctrl[:] = pressure
        mujoco.mj_step(model, data)
        largest = max(largest, abs(torque))
        assert data.qfrc_actuator[0] == pytest.approx(torque, abs=1e-9 * 120)
    assert largest > 20


def pushed(steps=400, config=""):
    model = mujoco.MjModel.from_xml_string(ARM.format(config=config))
    data = mujoco.MjData(model)
    forward(model, data, steps)
    return model, data


def forward(model, data, steps):
    for k in range(steps):
        data.ctrl[1:] = 0.3 * np.sin(0.02 * k), -0.2
        mujoco.mj_step(model, data)
    return data.qpos[0], *data.actuator_force, *data.plugin_state


def test_copies_and_saved_states_go_on_to_the_same_bits():
    model, data = pushed()
    spec = mujoco.mjtState.mjSTATE_FULLPHYSICS
    saved = np.empty(mujoco.mj_stateSize(model, spec))
    mujoco.mj_getState(model, data, saved, spec)
    copied, other = copy.copy(data), mujoco.MjData(model)
    mujoco.mj_setState(model, other, saved, spec)
    further = forward(model, data, 200)
    assert forward(model, copied, 200) == further
    assert forward(model, other, 200) == further


def test_a_rollout_in_threads_is_the_loop_of_steps():
    model, data = pushed(100)
    spec = mujoco.mjtState.mjSTATE_FULLPHYSICS
    start = np.empty((4, mujoco.mj_stateSize(model, spec)))
    mujoco.mj_getState(model, data, start[0], spec)
    start[1:] = start[0]
    control = np.zeros((4, 300, model.nu))
    control[..., 1] = np.linspace(-0.4, 0.4, 300)
    states, _ = rollout.rollout(model, [mujoco.MjData(model) for _ in range(2)], start, control)
    for row in control[0]:
        data.ctrl[:] = row
        mujoco.mj_step(model, data)
    assert np.all(states[:, -1, 1] == data.qpos[0])


@pytest.mark.parametrize("number", [0.0, 1e300, np.nan, 5e-324])
def test_a_state_that_is_none_of_a_muscle_is_refused(number):
    model, data = pushed(10)
    data.plugin_state[:] = number
    with pytest.raises(mujoco.FatalError, match="Call mj_resetData"):
        mujoco.mj_step(model, data)
    mujoco.mj_resetData(model, data)
    mujoco.mj_step(model, data)
    assert np.all(np.isfinite(data.actuator_force))


def test_a_reset_forgets_everything():
    model, data = pushed()
    again = pushed()[1]
    mujoco.mj_resetData(model, data)
    fresh = mujoco.MjData(model)
    assert forward(model, data, 400) == forward(model, fresh, 400)
    assert data.qpos[0] == again.qpos[0]


def test_asking_for_forces_moves_nothing():
    model, data = pushed()
    mujoco.mj_forward(model, data)
    force, state = data.actuator_force.copy(), data.plugin_state.copy()
    for _ in range(5):
        mujoco.mj_forward(model, data)
    assert np.array_equal(data.actuator_force, force)
    assert np.array_equal(data.plugin_state, state)


def test_a_muscle_starts_where_the_first_step_finds_it():
    model = mujoco.MjModel.from_xml_string(ARM.format(config=""))
    data = mujoco.MjData(model)
    data.qpos[0] = 0.3
    mujoco.mj_step(model, data)
    at = model.plugin_stateadr[1]
    assert data.plugin_state[at + 1] == pytest.approx(0.11 + 0.05 * 0.3 / 0.4, abs=1e-4)
    assert (
        abs(data.plugin_state[at + 3]) < 1.0
    )  # no hysteresis yet, which a jump from 0 would have left


@pytest.mark.parametrize(
    ("key", "value", "told"),
    [
        ("size", "-3", r"from 0 to 1e\+06.*leave the line out for 80"),
        ("size", "nan", "size=.nan. is not usable"),
        ("muscle", "dmsp10", "one of dmsp40, dmsp20"),
        ("mechanism", "coulomb", "preisach, dahl, braid, lugre, pinched, ageing"),
        ("volume", "1e-3 2e-3", "4 numbers"),
        ("coefficient", "1 2 3 4 5 6 7 8", "6 or, geometric, 8"),
        ("creep_force", "1 2", "as many as creep_time"),
        ("length", "12", r"\[m\], from 0.001 to 10"),
        ("creep_time", "1 2 3 4 5 6 7 8 9", "at most 8"),
        ("creep_time", "1 2 3 4 5 6 -7", "at most 8"),
        ("length", "0.4 m", r"\[m\], from 0.001 to 10"),
        ("ambient", "9e5", "not above supply"),
        ("lenght", "0.4", "unrecognized attribute"),
    ],
)
def test_a_wrong_config_is_refused_with_its_cure(key, value, told):
    with pytest.raises(ValueError, match=f"(?s){told}"):
        mujoco.MjModel.from_xml_string(ARM.format(config=f'<config key="{key}" value="{value}"/>'))


def test_one_instance_for_two_actuators_is_refused():
    shared = ARM.replace(
        '<plugin plugin="dehyst.muscle"/>',
        '<plugin plugin="dehyst.muscle"><instance name="i"/></plugin>',
    )
    for _ in range(2):
        shared = re.sub(
            r'<plugin plugin="dehyst.muscle" joint', '<plugin instance="i" joint', shared
        )
    with pytest.raises(ValueError, match="2 actuators share one instance"):
        mujoco.MjModel.from_xml_string(shared.format(config=""))


def test_commands_that_are_no_numbers_do_not_poison_the_state(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # MuJoCo logs its warning there
    for config in ("", '<config key="drive" value="pressure"/>'):
        model, data = pushed(10, config)
        data.ctrl[1] = np.nan
        mujoco.mj_step(model, data)
        data.ctrl[1] = 1e12
        mujoco.mj_step(model, data)
        mujoco.mj_forward(model, data)
        assert np.all(np.isfinite(data.actuator_force))
        assert data.plugin_state[model.plugin_stateadr[1]] <= 7e5 + 1


@pytest.mark.parametrize(
    ("number", "types"), [(1, ("dmsp40", "mpye")), (6, ("dmsp20", "mpye_small"))]
)
def test_named_muscles_and_valves_are_those_of_the_robot(number, types):
    robot = load_robot(conditions="kind", changes={"tolerance.force": 0, "tolerance.hysteresis": 0})
    text = (ROBOT / "native" / "named_muscles.inc").read_text(encoding="utf-8")
    rows = re.findall(r'\{"(\w*)", "(\w+)",\s*((?:"[^"]*"\s*)+)\}', text)
    named = {
        key: re.sub(r'"\s*"|^"|"\s*$', "", value)
        for kind, key, value in rows
        if kind in ("", *types)
    }
    assert named.pop("muscle") == "dmsp40" and named.pop("valve") == "mpye"
    written = {
        one.get("key"): one.get("value") for one in fromstring(actuator_xml(robot, number, 0))
    }
    assert named == written


def test_a_muscle_that_is_not_there_is_refused():
    with pytest.raises(ParameterError, match="0 and 1"):
        actuator_xml(load_robot(conditions="kind"), 1, 2)
    with pytest.raises(ParameterError, match="electric"):
        actuator_xml(load_robot(conditions="kind"), 3, 0)


def test_a_version_with_its_arrays_elsewhere_is_refused(monkeypatch):
    monkeypatch.setattr(mujoco_plugin, "_measured", lambda mujoco, size: [size])
    with pytest.raises(MissingExtraError, match="wrong memory"):
        load.__wrapped__()


def test_mujoco_loads_it_by_itself_where_it_knows_entry_points(tmp_path):
    if "mujoco.plugins" not in Path(mujoco.__file__).read_text(encoding="utf-8"):
        pytest.skip("this MuJoCo knows no entry points")
    points = tomllib.loads((ROBOT / "pyproject.toml").read_text(encoding="utf-8"))["project"][
        "entry-points"
    ]
    info = tmp_path / "alone-1.dist-info"
    info.mkdir()
    (info / "METADATA").write_text(
        "Metadata-Version: 2.1\nName: alone\nVersion: 1\n", encoding="utf-8"
    )
    (info / "entry_points.txt").write_text(
        f"[mujoco.plugins]\nown = {points['mujoco.plugins']['dehyst']}\n", encoding="utf-8"
    )
    (tmp_path / "arm.xml").write_text(ARM.format(config=""), encoding="utf-8")
    code = "import mujoco; print(mujoco.MjModel.from_xml_path('arm.xml').nplugin)"
    path = os.pathsep.join(
        [
            str(tmp_path),
            str(Path(mujoco_plugin.__file__).parents[2]),
            os.environ.get("PYTHONPATH", ""),
        ]
    )
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", code], cwd=tmp_path, env={**os.environ, "PYTHONPATH": path},
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.stdout.startswith("3"), done.stderr


def test_the_example_elbow_comes_to_rest_off_its_start():
    done = subprocess.run(
        [sys.executable, ROOT / "examples" / "muscle_in_mujoco.py"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    start, there, back, again = (float(x) for x in re.findall(r"(-?[\d.]+) deg", done.stdout))
    assert start == 0.0
    assert there < -3 and back > 3
    assert again != start
