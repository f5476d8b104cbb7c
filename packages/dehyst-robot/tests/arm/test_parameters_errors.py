"""Faults in a parameter file: each is refused by name, with the cure, and never by a traceback."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dehyst.errors import ParameterError
from dehyst_robot.arm import Tables, load_robot
from dehyst_robot.arm._parameters import PACKAGED
from dehyst_robot.fields import dotted, entries

ROBOT = load_robot(conditions="kind")
PACKAGED_LINES = PACKAGED.read_text(encoding="utf-8").splitlines()


def entry_of(dotted_key):
    """What the tables declare of a key."""
    table, *members, name = dotted_key.split(".")
    kind = entries(Tables)[table].kind
    return entries(kind.__args__[1] if members else kind)[name]


NUMBERS = [
    key for key in dotted(Tables, ROBOT.values) if "." in key and entry_of(key).kind in (int, float)
]


@pytest.mark.parametrize("key", NUMBERS)
def test_no_value_outside_its_physical_range_is_taken(key):
    limits = entry_of(key).key
    for value in (
        limits.low - 1.0,
        limits.high + 1.0,
        math.nan,
        math.inf,
        True,
        "1",
        [1.0],
        None,
        10**400,
        10**5000,
    ):
        with pytest.raises(ParameterError, match=key.replace(".", r"\.")) as caught:
            ROBOT.with_changes({key: value})
        assert f"from {limits.low:g} to {limits.high:g}" in str(caught.value)


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"joint.1.radus_m": 0.05}, "joint.1.radius_m"),
        ({"joint.1.radius": 0.05}, "joint.1.radius_m"),
        ({"contoller.pole_1_s": 4.0}, "controller.pole_1_s"),
        ({"joint": {"1": {"radius_mm": 50.0}}}, "joint.1.radius_m"),
        ({"hysteresis.mechanism": "preisech"}, "Did you mean preisach?"),
        ({"muscle.dmsp40.map": "tondulopez"}, "Did you mean tondu-lopez?"),
        ({"joint.1.drive": "dmsp400"}, "Did you mean dmsp40?"),
        ({"joint.1.valve": "mpy"}, "Did you mean mpye?"),
        ({"joint.3.drive": "dmsp40"}, "valve, radius_m, contraction"),
        ({"joint.8": {"zero_deg": 0.0}}, "lacks joint.8.range_deg"),
        (
            {"joint.12": {"zero_deg": 0.0}},
            "no joint.12; [joint] has 1, 2, 3, 4, 5, 6, 7, 8, numbered",
        ),
        ({"joint.12.zero_deg": 0.0}, "Did you mean joint.2.zero_deg?"),
        ({"joint": {"": {"zero_deg": 0.0}}}, "[joint] has 1, 2"),
        ({"joint.5": {}}, "changes nothing"),
        ({"joint": {"5": {}}}, "changes nothing"),
        ({"muscle": {5: {"length_m": 0.3}}}, "a name is a text"),
        ({"air.supply_bar": 10**400}, "from 1 to 12 bar"),
        ({"path.center_m": [0.7, 10**400, 0.5]}, "path.center_m[1]"),
        ({"air.supply_bar": 1e5}, "the unit of the key"),
        ({"joint.1.radius_m": 0.15}, "range_deg or radius_m"),
        ({"joint.1.contraction": 0.24}, "put contraction in the middle"),
        ({"controller.mean_pressure_bar": 6.5}, "pressure_high_bar = 6"),
        ({"air.supply_bar": 5.0}, "air.supply_bar = 5"),
        ({"path.rounding_m": 0.2}, "below 0.16"),
        (
            {"path.center_m": [0.7, 0.0]},
            "a list [..., ...] of 3 values, each a number from -20 to 20 m",
        ),
        ({"simulation.substeps": 2.5}, "whole number"),
        ({"muscle.dmsp40.creep_time_s": [1.0]}, "one of each"),
        ({"map.tool.form": "geometric"}, "8 coefficients"),
        ({"muscle.new": {"length_m": 0.3}}, "muscle.new.viscous_force_N"),
        ({"joint": 3.0}, "write [joint]"),
        ({"joint.1": 3.0}, "write [joint.1]"),
        ({"air": {"supply_bar": {"a": 1.0}}}, "air.supply_bar = {'a': 1.0} is not a number"),
        ({"name": ""}, "text in quotes"),
        ({"": 1.0}, "no key"),
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
        (b'extends = "default"\n[jiont.1]\nradius_m = 0.05\n', "Did you mean joint.1.radius_m?"),
        (b"radius_m = \n", "is not TOML"),
        (b"\xff\xfe", "UTF-8"),
        (b"a = " + b"[" * 100_000, "is not TOML"),
        (b"#" * (2 << 20), "is larger than 1048576 bytes"),
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
    with pytest.raises(ParameterError, match="is a folder"):
        load_robot(tmp_path)


def test_an_incomplete_file_lists_what_is_missing(tmp_path):
    file = tmp_path / "mine.toml"
    values = "\n".join(
        line for line in PACKAGED_LINES if not line.startswith(("encoder_bits", "decay"))
    )
    file.write_text(values, encoding="utf-8")
    with pytest.raises(ParameterError) as caught:
        load_robot(file)
    assert caught.value.facts["missing"] == ["homing.decay", "sensors.encoder_bits"]


anything = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda inner: (
        st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=3)
    ),
    max_leaves=6,
)
keys = st.sampled_from(
    [*dotted(Tables, ROBOT.values), *entries(Tables), "joint.1", "muscle.dmsp40"]
) | st.text(max_size=8)


@given(st.dictionaries(keys, anything, min_size=1, max_size=3))
def test_whatever_is_changed_gives_a_robot_or_a_named_error(changes):
    try:
        robot = ROBOT.with_changes(changes)
    except ParameterError as fault:
        assert len(str(fault)) > 30
    else:
        assert robot.pneumatic
