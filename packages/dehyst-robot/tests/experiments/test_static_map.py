"""A muscle of a robot file pulls with the static force of the muscle model that it names."""

import numpy as np
import pytest

from dehyst.errors import ParameterError
from dehyst_robot._native import muscle_force
from dehyst_robot.arm import JointBench, load_robot, pneumatic_joint_parameters
from dehyst_robot.arm._joints import FORMS, run_pressures
from dehyst_robot.arm._static_map import CONTRACTIONS, static_map
from dehyst_robot.commands import RigRequest
from dehyst_robot.commands._reproduce import QUICK
from dehyst_robot.commands._rig import run_rig
from dehyst_robot.experiments import Request, calibrate, identify_joint, reproduce
from dehyst_robot.mujoco_plugin import actuator_xml
from dehyst_robot.muscles import muscle, muscle_class, muscle_names
from places import ROOT

EXAMPLES = ROOT / "examples" / "rigs"
RNG = np.random.default_rng(5)
SETS = [(name, each) for name in muscle_names() for each in muscle_class(name).SETS]
SUPPLY = 7e5
ALONE = {
    "tolerance.force": 0.0,
    "tolerance.hysteresis": 0.0,
    "hysteresis.creep": 0.0,
    "hysteresis.scale": 0.0,
}
RIG = """extends = "parts"
name = "unlike"
{types}
[joint.1]
axis = "pitch"
zero_deg = 60
link_length_m = 0.25
link_radius_m = 0.02
link_mass_kg = 0.5
{drive}
valve = "mpye_small"
range_deg = 25
radius_m = 0.03
damping_Nm_s = 0.45
contraction = 0.07
pole_1_s = 27

[controller]
pressure_gain_1_s = 30
"""
OWN = """
[muscle.{name}]
model = "{model}"
length_m = 0.25
dead_volume_l = 0.03
volume_l_per_m = [0.31415, 1.79953, -3.17053, 1.05685]
viscous_force_N = 0.0
viscous_speed_m_s = 0.2
creep_time_s = []
creep_force_N = []
creep_pressure_N_bar = []
hysteresis_N = 20.0
"""


def looked_up(model, pressure, contraction):
    """Static force by the plant, of a model of whatever length."""
    told = pneumatic_joint_parameters(load_robot(), 1, seed=0)["muscle"][0]
    table = static_map(model, SUPPLY)
    grid = [
        each
        for axis in (table.pressure, table.contraction)
        for each in (axis[0], axis[1] - axis[0])
    ]
    told |= {
        "map": FORMS["table"],
        "coefficient": [1.0, 1.0, *map(float, grid)],
        "table": table.force,
    }
    return muscle_force(told, np.ascontiguousarray(pressure), np.ascontiguousarray(contraction))


@pytest.mark.parametrize(("name", "which"), SETS)
def test_the_plant_pulls_with_a_model_s_own_force_to_a_thousandth_of_the_full_one(name, which):
    model = muscle(name, which)
    low, high = static_map(model, SUPPLY).contraction[[0, -1]]
    assert low == max(model.limits[0], CONTRACTIONS[0]) and high > 0.2
    k, p = RNG.uniform(low, high, 20000), RNG.uniform(0.0, SUPPLY, 20000)
    off = looked_up(model, p, k) - model.static_force(k, p)
    assert np.abs(off).max() < 1e-3 * float(model.static_force(0.0, SUPPLY))


@pytest.mark.parametrize("name", muscle_names())
def test_beyond_its_ends_the_table_goes_on_in_a_line_and_pulls_no_more_where_the_muscle_is_shortest(
    name,
):
    model = muscle(name)
    low, high = static_map(model, SUPPLY).contraction[[0, -1]]
    for end, way in ((low, -1.0), (high, 1.0)):
        at, one, two = looked_up(model, np.full(3, 4e5), end + way * np.array([0.0, 0.05, 0.10]))
        assert two - one == pytest.approx(one - at, rel=1e-6, abs=1e-6)
        if way > 0:
            assert max(one, 0.0) <= max(at, 0.0) + 1e-3 * float(model.static_force(0.0, SUPPLY))
    in_it, on_it, above = looked_up(model, SUPPLY + np.array([-1e3, 0.0, 1e3]), np.full(3, 0.1))
    assert above - on_it == pytest.approx(on_it - in_it, rel=1e-6)


def unlike(folder, first, second, more=""):
    types = OWN.format(name="one", model=first) + OWN.format(name="two", model=second)
    file = folder / "rig.toml"
    file.write_text(
        RIG.format(types=types + more, drive='drives = ["one", "two"]'), encoding="utf-8"
    )
    return file


def test_a_joint_of_two_unlike_models_turns_by_the_difference_of_their_forces(tmp_path):
    robot = load_robot(unlike(tmp_path, "klute", "vo-minh"), ALONE, conditions="kind")
    angle = 0.3 * np.sin(np.linspace(0.0, 6.0, 301))
    pressure = 3e5 + 1e5 * np.sin(np.linspace(0.0, 9.0, 301))[:, None] * np.array([1.0, -1.0])
    course = run_pressures(pneumatic_joint_parameters(robot, 1, seed=0), angle, pressure, 0.01)
    forces = [
        muscle(name, length=0.25).static_force(
            0.07 + side * 0.03 * angle / 0.25, course.pressure[:, m], clamp=True
        )
        for m, (name, side) in enumerate((("klute", 1.0), ("vo-minh", -1.0)))
    ]
    np.testing.assert_allclose(
        course.torque[1:], 0.03 * (forces[0] - forces[1])[1:], atol=0.03 * 2 * 2.7
    )
    assert np.abs(course.torque).max() > 10.0


def test_muscles_side_by_side_and_tolerances_scale_the_table(tmp_path):
    file = unlike(tmp_path, "klute", "maker")
    one, two = (
        pneumatic_joint_parameters(load_robot(file, {"joint.1.parallel": n}), 1, 3)["muscle"]
        for n in (1, 2)
    )
    p, k = np.full(50, 3e5), np.linspace(-0.04, 0.2, 50)
    for m in (0, 1):
        np.testing.assert_allclose(
            muscle_force(two[m], p, k), 2.0 * muscle_force(one[m], p, k), rtol=1e-12
        )
    assert one[0]["coefficient"][0] != 1.0 != one[0]["coefficient"][1]  # drawn in the realistic arm


def test_a_spring_against_a_model_has_no_table(tmp_path):
    drive = 'drives = ["one", "spring"]\nspring_N_m = 3000\nspring_preload_N = 260'
    file = tmp_path / "sprung.toml"
    file.write_text(
        RIG.format(types=OWN.format(name="one", model="maker"), drive=drive), encoding="utf-8"
    )
    bench = JointBench(load_robot(file), 1)
    assert np.isfinite(bench.step([[0.0, 0.0]])).all()


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"model": "klutte"}, r"one of maker, sarosi, .*vo-minh\. Did you mean klute"),
        (
            {"model": "klute", "parameters": {"radius": 1.0}},
            "klute has no parameter 'radius'; it has: length, diameter",
        ),
        (
            {"model": "klute", "parameters": {"wall": -1.0}},
            "muscle.dmsp40.model = 'klute' cannot be used: wall",
        ),
        ({"model": "klute", "parameters": {"length": 0.1}}, "the length is length_m"),
        ({"model": "maker", "set": "DMSP-30"}, "there are: DMSP-40, DMSP-20, DMSP-10"),
        ({"model": "maker", "parameters": {"passive": 90.0}}, "bends too sharply"),
        ({"model": "sarosi", "parameters": {"a5": -0.01}}, "no muscle does"),
        ({"set": "DMSP-20"}, "muscle.dmsp40.set belongs to a model"),
        ({"parameters": {"wall": 1e-3}}, "muscle.dmsp40.parameters belongs to a model"),
    ],
)
def test_a_model_that_cannot_be_is_refused_with_a_cure(change, says):
    with pytest.raises(ParameterError, match=says):
        load_robot(changes={"muscle": {"dmsp40": change}})


def test_a_type_of_muscle_needs_a_map_or_a_model(tmp_path):
    file = unlike(
        tmp_path,
        "klute",
        "maker",
        OWN.format(name="three", model="maker").replace('model = "maker"', ""),
    )
    with pytest.raises(
        ParameterError,
        match=r"lacks muscle.three.map. Write one of the file's maps, .* models, maker",
    ):
        load_robot(file)


def test_parameters_reach_the_model_and_the_plant():
    changes = {"muscle": {"dmsp40": {"model": "maker", "parameters": {"force": 3000.0}}}, **ALONE}
    robot = load_robot(conditions="kind", changes=changes)
    told = pneumatic_joint_parameters(robot, 1, seed=0)["muscle"][0]
    found = muscle_force(told, np.array([6.2e5]), np.array([0.0]))
    assert found[0] == pytest.approx(3000.0, rel=1e-3)
    assert robot.fingerprint != load_robot(conditions="kind", changes=ALONE).fingerprint


def test_the_mujoco_plugin_refuses_a_model_by_its_name():
    with pytest.raises(
        ParameterError, match="klute: the plugin takes the maps tool, exponential, geometric"
    ):
        actuator_xml(
            load_robot(changes={"muscle.dmsp40.model": "klute"}), 1, 0, joint="elbow", gear=-0.05
        )


def test_a_check_shows_the_models(tmp_path, capsys):
    run_rig(RigRequest(action="check", file=unlike(tmp_path, "klute", "boblan-martens")))
    assert "klute" in (said := capsys.readouterr().out) and "boblan-martens" in said


def of_one_model(name, which, conditions, changes):
    """The packaged rig of one joint, its muscles of another model."""
    changes = {**changes, "muscle": {"dmsp20": {"model": name, "set": which}}}
    return load_robot(EXAMPLES / "one_joint.toml", changes, conditions=conditions)


@pytest.mark.slow
def test_a_rig_of_klute_s_muscles_is_calibrated_identified_and_accepted(tmp_path):
    short = {
        "mean_pressures_bar": [2.2, 3.8],
        "loads_bar": [-0.8, 0.8],
        "sweep_s": 8.0,
        "degree": 3,
    }
    robot = of_one_model(
        "klute", "bare", "kind", {"calibration": short, "identification.loop_s": 8.0}
    )
    assert identify_joint(robot, 1, calibrate(robot, 1), tmp_path).accepted


@pytest.mark.exhaustive
@pytest.mark.parametrize("conditions", ["kind", "realistic"])
@pytest.mark.parametrize(
    ("name", "which"),
    [
        ("klute", "triceps"),
        ("maker", "DMSP-20"),
        ("vo-minh", "DMSP-20"),
        ("sarosi", "DMSP-20-400N"),
    ],
)
def test_the_experiment_ends_accepted_on_a_rig_of_a_model_s_muscles(
    name, which, conditions, tmp_path
):
    robot = of_one_model(name, which, conditions, {**QUICK, "path.cycles_fast": 1})
    request = Request(
        plants=("preisach",), compensators=("best",), seeds=(0,), trials=("fast",), studies=False
    )
    plant = reproduce(robot, request, tmp_path).plants["preisach"]
    fast = plant.figures[0]["joints"]["1"]["trials"]["fast"]
    assert fast["best"]["rms_deg"] < 0.5 * fast["off"]["rms_deg"]
