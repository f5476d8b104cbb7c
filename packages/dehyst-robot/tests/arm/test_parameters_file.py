"""The parameter file: every number has a source, values arrive in SI, changes reach them."""

import json
import math
import pickle
import re
import tomllib

import pytest

from dehyst.errors import ParameterError
from dehyst_robot.arm import Tables, load_robot, sources
from dehyst_robot.arm._parameters import DEFAULT, PACKAGED, REALISTIC
from dehyst_robot.fields import UNITS, dotted

TEXT = PACKAGED.read_text(encoding="utf-8")
LISTED = set(
    re.findall(
        r"\[(\d+)\] [A-Za-z]", "\n".join(line for line in TEXT.splitlines() if line.startswith("#"))
    )
)


def has_source(comment):
    cited = re.findall(r"\[(\d+)\]", comment)
    return "assumption" in comment or (bool(cited) and set(cited) <= LISTED)


def numbers_without_source(text):
    """Return the lines that set a number and say neither where it is from nor that it is assumed."""
    found = []
    for line in text.splitlines():
        setting, _, comment = line.partition("#")
        value = setting.partition("=")[2]
        if re.search(r"\d", re.sub(r'"[^"]*"', "", value)) and not has_source(comment):
            found.append(line)
    return found


def test_every_number_has_a_source_or_is_called_an_assumption():
    assert len(LISTED) >= 10
    assert numbers_without_source(TEXT + REALISTIC.read_text(encoding="utf-8")) == []


@pytest.mark.parametrize(
    "line", ["a = 1.0", "a = 1.0 # bar", "a = [1, 2] # [99]", 'a = 3 # "assumed"']
)
def test_the_check_of_sources_finds_what_it_should(line):
    assert numbers_without_source(line) == [line]


def test_every_key_of_the_file_is_known_and_every_known_key_is_in_the_file():
    values = tomllib.loads(TEXT)
    more = tomllib.loads(REALISTIC.read_text(encoding="utf-8"))

    def leaves(table, prefix=""):
        for key, value in table.items():
            yield from (
                leaves(value, f"{prefix}{key}.") if isinstance(value, dict) else [f"{prefix}{key}"]
            )

    own = r"body\..*|reference\..*|"
    own += r"joint\..\.(body_joint|drives|parallel|routing|lever.*|moment_arm.*|tendons|spring.*)|"
    optional = re.compile(
        own
        + r"muscle\..*\.(model|set|parameters)|map\..*force_of_length|joint\.[35]\.(valve|radius_m|contraction)|"
        + r"joint\.[1-5]\.pole_1_s"
    )
    off = re.compile(r"sensors\.angle_drift.*|joint\.[35]\.backlash.*")  # in the realistic arm too
    said = [*leaves(values), *leaves(more)]
    assert {
        key for key in set(dotted(Tables, values)) ^ set(said) if not optional.fullmatch(key)
    } == {key for key in dotted(Tables, values) if off.fullmatch(key)}
    assert len(said) == len(set(said))  # what is off in the kind arm is not written there


@pytest.mark.parametrize(
    ("value", "si"),
    [
        (lambda r: r.air.supply, 7e5),
        (lambda r: r.joint(2).zero, -33.0 / 180.0 * math.pi),
        (lambda r: r.muscle("dmsp40").dead_volume, 6e-5),
        (lambda r: r.muscle("dmsp40").volume[1], 7.1981e-3),
        (lambda r: r.muscle("dmsp40").creep_pressure[0], 3.5e-5),
        (lambda r: r.valve("mpye").conductance, 2e-8),
        (lambda r: r.valve("mpye").frequency, 628.3185307179587),
        (lambda r: r.compensator.shear, 1e5),
        (lambda r: r.controller.pole, 6.0),
        (lambda r: r.calibration.mean_pressures[1], 3e5),
    ],
)
def test_values_arrive_in_si(value, si):
    assert value(load_robot(conditions="kind")) == pytest.approx(si, rel=1e-15)


def test_units_are_those_of_the_table_of_units():
    assert UNITS["l_s_bar"][0] == pytest.approx(1e-3 / 1e5)
    assert UNITS["deg"][0] * 180 == pytest.approx(math.pi)


def test_a_change_reaches_its_value_and_nothing_else():
    robot = load_robot(conditions="kind")
    changed = robot.with_changes({"joint.1.radius_m": 0.06, "path.center_m": (0.7, 0, 0.5)})
    assert changed.joint(1).radius == 0.06
    assert changed.path.center == (0.7, 0.0, 0.5)
    assert robot.joint(1).radius == 0.05
    values, expected = changed.values, robot.values
    expected["joint"]["1"]["radius_m"] = 0.06
    expected["path"]["center_m"] = [0.7, 0.0, 0.5]
    assert values == expected


def test_values_go_through_json_and_back_to_the_same_robot():
    robot = load_robot(conditions="kind", changes={"hysteresis.scale": 1.5})
    assert load_robot(conditions="kind", changes=json.loads(json.dumps(robot.values))) == robot


def test_values_handed_out_cannot_change_the_robot():
    robot = load_robot(conditions="kind")
    robot.values["joint"]["1"]["radius_m"] = 9.0
    assert robot == load_robot(conditions="kind")


def test_fingerprints_tell_robots_apart_and_only_those():
    robot = load_robot(conditions="kind")
    assert (
        robot.fingerprint
        == load_robot(conditions="kind", changes={"simulation.substeps": 4.0}).fingerprint
    )
    assert (
        robot.fingerprint
        != load_robot(conditions="kind", changes={"simulation.substeps": 5}).fingerprint
    )
    assert pickle.loads(pickle.dumps(robot)) == robot


def test_a_file_that_extends_the_default_needs_only_what_differs(tmp_path):
    file = tmp_path / "mine.toml"
    file.write_text(
        'extends = "default"\nname = "mine"\n[joint.1]\nradius_m = 0.04\n', encoding="utf-8"
    )
    robot = load_robot(file)
    assert (robot.name, robot.joint(1).radius) == ("mine", 0.04)
    assert robot == load_robot(changes={"name": "mine", "joint.1.radius_m": 0.04})


def test_the_packaged_file_alone_is_complete(tmp_path):
    file = tmp_path / "copy.toml"
    file.write_text(TEXT, encoding="utf-8")
    assert load_robot(file) == load_robot(conditions="kind")


def test_a_muscle_of_ones_own_can_be_added(tmp_path):
    file = tmp_path / "mine.toml"
    own = re.search(r"\[muscle\.dmsp40\]\n(.*?)\n\n", TEXT, re.S)[1]
    own = own.replace("length_m = 0.40", "length_m = 0.45")
    file.write_text(
        f'extends = "default"\n[joint.1]\ndrive = "long"\n[muscle.long]\n{own}\n', encoding="utf-8"
    )
    robot = load_robot(file)
    assert robot.muscle(robot.joint(1).drive).length == 0.45


def test_drives_can_be_exchanged_for_electric_ones():
    assert load_robot(conditions="kind", changes={"joint.6.drive": "electric"}).pneumatic == (
        1,
        2,
        4,
        7,
    )


def test_a_joint_or_muscle_that_is_not_there_is_named():
    robot = load_robot(conditions="kind")
    with pytest.raises(ParameterError, match="no joint 8"):
        robot.joint(8)
    with pytest.raises(ParameterError, match="dmsp20, dmsp40"):
        robot.muscle("dmsp10")


def test_the_packaged_arm_comes_kind_and_realistic(tmp_path):
    kind, realistic = load_robot(conditions="kind"), load_robot(conditions="realistic")
    assert load_robot() == {"kind": kind, "realistic": realistic}[DEFAULT]
    assert kind.simulation.command_delay == kind.tolerance.shape == kind.air.supply_volume == 0.0
    assert realistic.valve("mpye").delay == 0.001
    assert sources()["valve.mpye.hysteresis"].endswith("[4]")
    file = tmp_path / "mine.toml"
    file.write_text('extends = "realistic"\n[joint.1]\nradius_m = 0.04\n', encoding="utf-8")
    assert load_robot(file) == realistic.with_changes({"joint.1.radius_m": 0.04})
    assert load_robot(file, conditions="kind").valve("mpye").delay == 0.0
    file.write_text(TEXT, encoding="utf-8")
    with pytest.raises(ParameterError, match="those of the packaged arm"):
        load_robot(file, conditions="realistic")
    with pytest.raises(ParameterError, match="They are kind and realistic"):
        load_robot(conditions="real")


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"sensors.angle_delay_s": 0.05}, "remembers 62 periods, 31 ms"),
        ({"simulation.command_delay_s": 0.02, "valve.mpye.delay_s": 0.02}, "delay of 40 ms"),
        ({"joint.1.backlash_deg": 0.1}, "joint.1.backlash_damping_Nm_s is 0"),
        ({"muscle.dmsp40.tendon_N_m": 1e5}, "muscle.dmsp40.tendon_time_s is 0"),
        ({"valve.mpye.tube_length_m": 1.0}, "valve.mpye.tube_diameter_m is 0"),
        ({"sensors.pressure_drift_bar": 0.1}, "sensors.pressure_drift_time_s is 0"),
    ],
)
def test_half_an_effect_and_a_delay_that_cannot_be_remembered_are_refused(changes, message):
    with pytest.raises(ParameterError, match=re.escape(message)):
        load_robot(conditions="kind", changes=changes)
