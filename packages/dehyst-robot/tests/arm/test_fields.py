"""The reader of parameter files: what a declaration takes and refuses, and that its JSON Schema says the same."""

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated, Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dehyst.errors import ModelFileError, ParameterError
from dehyst.files import document_of, text_of
from dehyst_robot.arm import Tables, load_robot
from dehyst_robot.fields import Key, checked_table, read, schema_of


@dataclass(frozen=True)
class Part:
    """A table."""

    angle: Annotated[float, Key("deg", -180.0, 180.0)]
    count: Annotated[int, Key("", 0, 9)] = 3


@dataclass(frozen=True)
class Whole:
    """A file with one key of every kind."""

    part: Part
    named: Annotated[Mapping[str, Part], Key(name="member")]
    fixed: Annotated[Mapping[int, Part], Key(choices=("1", "2"))]
    word: Annotated[str, Key(choices=("up", "down"))]
    tips: Annotated[tuple[float, ...], Key("bar", 0.0, 10.0, 1, 3)]
    pair: tuple[float, float]
    listed: tuple[Part, ...]
    seeds: Annotated[tuple[int, ...] | None, Key("", 0, 99, distinct=True)]
    text: Annotated[str, Key(most=5)] = "a"
    flag: bool = False
    free: Mapping[str, Any] = field(default_factory=dict)


GOOD = {
    "part": {"angle_deg": 180},
    "member": {"a": {"angle_deg": 90.0, "count": 4.0}},
    "fixed": {"1": {"angle_deg": 0.0}, "2": {"angle_deg": 1.0}},
    "word": "up",
    "tips_bar": [1, 2.5],
    "pair": [1.0, 2.0],
    "listed": [{"angle_deg": 0.0}, {"angle_deg": -1.0, "count": 0}],
}


def test_a_file_becomes_a_record_in_si():
    found = read(Whole, GOOD, "f.toml")
    assert found.part.angle == pytest.approx(3.141592653589793)
    assert found.named["a"].count == 4 and type(found.named["a"].count) is int
    assert found.tips == (1e5, 2.5e5) and found.pair == (1.0, 2.0)
    assert list(found.fixed) == [1, 2] and found.listed[1].count == 0
    assert (found.seeds, found.text, found.flag, found.free) == (None, "a", False, {})


WRONG = {
    "part": [
        ({}, "lacks part.angle_deg. Add it"), (3, "write [part]"), ({"angel_deg": 1.0}, "Did you mean part.angle_deg?"),
    ],
    "member": [({"a": 3}, "write [member.a]"), ({1: {"angle_deg": 0.0}}, "no member.1; a name is a text")],
    "fixed": [({"3": {"angle_deg": 0.0}}, "[fixed] has 1, 2"), ({"1": {"angle_deg": 0.0}}, "fixed.2.angle_deg")],
    "word": [("upp", "not one of up, down. Did you mean up?"), (1, "one of up, down"), (10**5000, "one of up, down")],
    "tips_bar": [
        ([], "a list [..., ...] of 1 to 3 values"), ([1.0, 11.0], "tips_bar[1] = 11.0 is not a number from 0 to 10"),
        ("1", "a list"), ([True], "tips_bar[0] = True"), ([float("nan")], "tips_bar[0] = nan"),
    ],
    "pair": [([1.0], "of 2 values"), ([1.0, 10**400], "pair[1]"), ([1.0, float("inf")], "a finite number")],
    "listed": [([], "write [[listed]]"), ([3], "listed[0]"), ([{}], "listed[0].angle_deg")],
    "seeds": [([1, 1], "different values"), ([0.5], "seeds[0]"), ([100], "from 0 to 99"), (None, "a list")],
    "text": [("", "of 1 to 5 letters"), ("abcdef", "1 to 5"), ("a\n", "printable"), (" ", "printable"), (1, "quotes")],
    "flag": [(1, "true or false"), ("true", "true or false")],
    "free": [(3, "write [free]")],
    "wrod": [("up", "no key 'wrod'. Did you mean word?")],
    "zzz": [({"word": 1}, "Known are: part, member, fixed")],
}  # fmt: skip


@pytest.mark.parametrize("key", WRONG)
def test_what_cannot_stand_at_a_key_is_refused_with_what_can(key):
    for value, says in WRONG[key]:
        with pytest.raises(ParameterError) as caught:
            read(Whole, {**GOOD, key: value}, "f.toml")
        assert str(caught.value).startswith("f.toml") and says in str(caught.value), (
            value,
            str(caught.value),
        )


def test_all_missing_keys_are_named_at_once():
    with pytest.raises(
        ParameterError, match=r"lacks \[\[listed\]\], fixed.1.angle_deg, .*, word. Add them, or go."
    ) as caught:
        read(Whole, {}, "f.toml", ", or go")
    assert len(caught.value.facts["missing"]) == 7


@pytest.mark.parametrize(
    "text", ["[1", '{"a": NaN}', '{"a": 1, "a": 2}', "[" * 100_000], ids=range(4)
)
def test_what_is_no_json_is_refused_by_the_error_of_its_kind(text):
    with pytest.raises(ModelFileError, match="is not JSON"):
        document_of(text, ModelFileError)


def test_what_is_no_small_text_file_is_refused(tmp_path):
    (tmp_path / "big").write_bytes(b"#" * 11)
    (tmp_path / "odd").write_bytes(b"\xff")
    for path, says in (
        ("big", "larger than 10"),
        ("odd", "UTF-8"),
        ("", "folder"),
        ("no", "not exist"),
        ("a\0", "not exist"),
    ):
        with pytest.raises(ModelFileError, match=says):
            text_of(tmp_path / path, ModelFileError, 10)


anything = st.recursive(
    st.none() | st.booleans() | st.integers(-200, 200) | st.floats(-200, 200).map(lambda x: round(x, 1))
    | st.sampled_from(["up", "a", "toolong", ""]),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.sampled_from(["1", "a", "angle_deg"]), inner),
    max_leaves=5,
)  # fmt: skip


@given(
    st.sampled_from([*GOOD, "seeds", "text", "flag", "free"]),
    anything,
    st.sampled_from([None, *GOOD]),
)
def test_the_json_schema_takes_what_the_reader_takes(key, value, dropped):
    jsonschema = pytest.importorskip("jsonschema")
    document = {
        name: one for name, one in {**GOOD, key: value}.items() if name != dropped or name == key
    }
    try:
        checked_table(Whole, document, "f.toml")
        taken = True
    except ParameterError:
        taken = False
    assert jsonschema.Draft202012Validator(schema_of(Whole)).is_valid(document) == taken


def test_the_schema_of_a_robot_is_plain_json_and_takes_the_packaged_arm():
    schema = schema_of(Tables)
    assert json.loads(json.dumps(schema)) == schema
    assert schema["properties"]["joint"]["properties"]["7"]["properties"]["axis"]["enum"] == [
        "yaw",
        "pitch",
        "roll",
    ]
    jsonschema = pytest.importorskip("jsonschema")
    values = load_robot(conditions="kind").values
    jsonschema.validate(values, schema)
    values["air"]["supply_bar"] = 13.0
    for wrong in (values, {"air": {}}):
        assert not jsonschema.Draft202012Validator(schema).is_valid(wrong)
    jsonschema.validate(
        {"air": {}, "joint": {"1": {"zero_deg": 1.0}}}, schema_of(Tables, partial=True)
    )
