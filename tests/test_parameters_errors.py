"""Faults in a parameter file: each is refused by name, with the cure, and never by a traceback."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dehyst.errors import ParameterError
from dehyst.robot.arm import load_robot
from dehyst.robot.arm.parameters import PACKAGED
from dehyst.robot.arm.validation import NAMED, SINGLE, keys_of, known_keys

ROBOT = load_robot()
PACKAGED_LINES = PACKAGED.read_text(encoding="utf-8").splitlines()
LIMITED = [
    (f"{name}.{key}", kind, spec)
    for name, table in [*SINGLE.items(), ("muscle.dmsp40", NAMED["muscle"]), ("valve.mpye", NAMED["valve"])]
    for key, (_, kind, spec) in keys_of(table).items()
    if kind in (int, float)
] + [(f"joint.1.{key}", kind, spec) for key, (_, kind, spec) in keys_of(NAMED["joint"]).items() if kind is float]


@pytest.mark.parametrize(("key", "kind", "spec"), LIMITED, ids=[key for key, _, _ in LIMITED])
def test_no_value_outside_its_physical_range_is_taken(key, kind, spec):
    for value in (spec.low - 1.0, spec.high + 1.0, math.nan, math.inf, True, "1", [1.0], None):
        with pytest.raises(ParameterError, match=key.replace(".", r"\.")):
            ROBOT.with_changes({key: value})


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"joint.1.radus_m": 0.05}, "joint.1.radius_m"),
        ({"joint.1.radius": 0.05}, "joint.1.radius_m"),
        ({"contoller.pole_1_s": 4.0}, "controller.pole_1_s"),
        ({"joint": {"1": {"radius_mm": 50.0}}}, "joint.1.radius_m"),
        ({"hysteresis.mechanism": "preisech"}, "'preisach'"),
        ({"muscle.dmsp40.map": "tondulopez"}, "'tondu-lopez'"),
        ({"joint.1.drive": "dmsp400"}, "'dmsp40'"),
        ({"joint.1.valve": "mpy"}, "'mpye'"),
        ({"joint.3.drive": "dmsp40"}, "valve, radius_m, contraction"),
        ({"joint.8": {"zero_deg": 0.0}}, "joints 1 to 7"),
        ({"joint.1.radius_m": 0.15}, "range_deg or radius_m"),
        ({"joint.1.contraction": 0.24}, "put contraction in the middle"),
        ({"controller.mean_pressure_bar": 6.5}, "pressure_high_bar = 6"),
        ({"air.supply_bar": 5.0}, "air.supply_bar = 5"),
        ({"path.rounding_m": 0.2}, "below 0.16"),
        ({"path.center_m": [0.7, 0.0]}, "2 numbers, not 3"),
        ({"simulation.substeps": 2.5}, "whole number"),
        ({"muscle.dmsp40.creep_time_s": [1.0]}, "one of each"),
        ({"map.tool.form": "geometric"}, "8 coefficients"),
        ({"muscle.new": {"length_m": 0.3}}, "muscle.new.viscous_force_N"),
        ({"joint": 3.0}, "joint"),
        ({"air": {"supply_bar": {"a": 1.0}}}, "air.supply_bar.a"),
        ({"name": ""}, "text in quotes"),
        ({"": 1.0}, "no such key"),
    ],
)
def test_the_cure_is_in_the_message(changes, says):
    with pytest.raises(ParameterError) as caught:
        ROBOT.with_changes(changes)
    assert says in str(caught.value)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (b"[joint.1]\nradius_m = 0.05\n", 'extends = "default"'),
        (b"", "air.ambient_bar"),
        (b'extends = "defualt"\n', "defualt"),
        (b'extends = "default"\njoint = 3\n', r"is not a table"),
        (b'extends = "default"\n[joint]\n1 = 3\n', r"write [joint.1]"),
        (b'extends = "default"\n[jiont.1]\nradius_m = 0.05\n', "'joint'"),
        (b"radius_m = \n", "is not TOML"),
        (b"\xff\xfe", "is not TOML"),
        (b"a = " + b"[" * 100_000, "is not TOML"),
        (b"#" * (2 << 20), "thousands"),
    ],
)
def test_a_damaged_file_is_an_error_with_a_cure(tmp_path, text, says):
    file = tmp_path / "mine.toml"
    file.write_bytes(text)
    with pytest.raises(ParameterError) as caught:
        load_robot(file)
    assert says in str(caught.value)


def test_a_file_that_is_not_there_is_named(tmp_path):
    with pytest.raises(ParameterError, match=r"nowhere\.toml"):
        load_robot(tmp_path / "nowhere.toml")
    with pytest.raises(ParameterError, match="cannot be read"):
        load_robot(tmp_path)


def test_an_incomplete_file_lists_what_is_missing(tmp_path):
    file = tmp_path / "mine.toml"
    values = "\n".join(line for line in PACKAGED_LINES if not line.startswith(("encoder_bits", "decay")))
    file.write_text(values, encoding="utf-8")
    with pytest.raises(ParameterError) as caught:
        load_robot(file)
    assert caught.value.facts["missing"] == ["homing.decay", "sensors.encoder_bits"]


anything = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=3),
    max_leaves=6,
)
keys = st.sampled_from([*known_keys(ROBOT.values), *SINGLE, *NAMED, "joint.1", "muscle.dmsp40"]) | st.text(max_size=8)


@given(st.dictionaries(keys, anything, min_size=1, max_size=3))
def test_whatever_is_changed_gives_a_robot_or_a_named_error(changes):
    try:
        robot = ROBOT.with_changes(changes)
    except ParameterError as fault:
        assert len(str(fault)) > 30
    else:
        assert robot.pneumatic
