"""Damaged and hostile model files: a ModelFileError within a second, whatever they hold."""

import copy
import hashlib
import json
import os
import signal
from pathlib import Path

import numpy as np
import pytest

from dehyst import (
    ModifiedPrandtlIshlinskii,
    MonotoneMap,
    PrandtlIshlinskii,
    StopOperatorModel,
    load,
)
from dehyst.errors import ModelFileError
from dehyst.models import HysteresisModel, ModelCard, SignalCard, StaticCurve, model_to_dict
from effort import no_hang

BEND = MonotoneMap([0.0, 1.0, 3.0], [0.0, 2.0, 3.0])
PLAY = PrandtlIshlinskii([0.0, 0.25, 0.5], [1.0, 0.5, 0.25], 0.5, [0.1, 0.0, 0.2], -1.0)
PROVENANCE = {"log": "a.csv", "rows": [2, 900]}
CARD = ModelCard(
    SignalCard("pressure", "bar", 0.0, 4.0), SignalCard("angle", "°", -1.0, 1.0), PROVENANCE
)
MODELS = {
    model.family: model.with_card(CARD)
    for model in (
        PLAY,
        ModifiedPrandtlIshlinskii(PLAY, after_map=BEND),
        StopOperatorModel([0.0, 0.25, 0.5], [0.0, 1.0, 0.5], 0.5, 0.1, [0.1, 0.0, 0.2]),
        StaticCurve(BEND),
    )
}


def refused(path, data):
    """Return the message of the refusal of these bytes, or None if they are a model."""
    if data is not None:
        path.write_bytes(data if isinstance(data, bytes) else data.encode("utf-8"))
    try:
        with no_hang():
            model = load(path)
    except ModelFileError as fault:
        message = str(fault)
        assert str(path) in message
        assert fault.facts["path"] == str(path)
        assert len(message) < 1000 + len(str(path))
        assert message.encode("utf-8")  # it can be printed
        return message
    assert isinstance(model, HysteresisModel)
    with np.errstate(all="ignore"):
        assert np.all(np.isfinite(model.simulate([0.0, 1.0, -1.0])))
    return None


def signed(content):
    """Return the file of a content with a checksum that fits it: only the parameters themselves can be at fault."""
    body = {key: value for key, value in content.items() if key != "sha256"}
    try:
        text = json.dumps(body, sort_keys=True, separators=(",", ":"))
        body["sha256"] = hashlib.sha256(text.encode("ascii")).hexdigest()
    except RecursionError:
        body["sha256"] = "0" * 64
    return json.dumps(body)


def test_the_signature_of_these_tests_is_that_of_the_files(tmp_path):
    for model in MODELS.values():
        content = model_to_dict(model)
        assert json.loads(signed(content)) == content
        assert refused(tmp_path / "m.json", signed(content)) is None


@pytest.mark.parametrize("family", MODELS)
def test_files_with_flipped_bytes_are_refused(family, tmp_path):
    rng = np.random.default_rng(list(MODELS).index(family))
    path = MODELS[family].save(tmp_path / "m.json")
    good = path.read_bytes()
    survivors = 0
    for _ in range(150):
        data = bytearray(good)
        for at in rng.integers(0, len(data), rng.integers(1, 4)):
            data[at] ^= 1 << int(rng.integers(0, 8))
        if refused(path, bytes(data)) is None:
            survivors += 1
            assert json.loads(bytes(data)) == json.loads(good)  # only white space was hit
    assert survivors < 75


@pytest.mark.parametrize("family", MODELS)
def test_files_with_edited_characters_are_refused(family, tmp_path):
    rng = np.random.default_rng(100 + list(MODELS).index(family))
    path = MODELS[family].save(tmp_path / "m.json")
    good = path.read_text(encoding="utf-8")
    for _ in range(60):
        at, end = np.sort(rng.integers(0, len(good), 2))
        piece = good[at:end]
        place = int(rng.integers(0, len(good)))
        for text in (
            good[:at] + good[end:],
            good[:place] + piece + good[place:],
            good[:at] + "9" + good[at:],
        ):
            if refused(path, text) is None:
                assert json.loads(text) == json.loads(good)


@pytest.mark.parametrize("family", MODELS)
def test_truncated_files_are_refused(family, tmp_path):
    path = MODELS[family].save(tmp_path / "m.json")
    good = path.read_bytes().rstrip()
    for length in range(0, len(good), max(1, len(good) // 40)):
        assert refused(path, good[:length])
    for start in range(1, len(good), max(1, len(good) // 20)):
        assert refused(path, good[start:])


def places(value, path=()):
    """Return the path of every node below a JSON value."""
    items = (
        value.items()
        if isinstance(value, dict)
        else enumerate(value)
        if isinstance(value, list)
        else ()
    )
    found = []
    for key, child in items:
        found += [(*path, key), *places(child, (*path, key))]
    return found


def changed(content, path, value):
    """Return a copy with another value at a path; value None with `drop` semantics is `without`."""
    other = copy.deepcopy(content)
    node = other
    for key in path[:-1]:
        node = node[key]
    node[path[-1]] = value
    return other


def without(content, path):
    other = copy.deepcopy(content)
    node = other
    for key in path[:-1]:
        node = node[key]
    del node[path[-1]]
    return other


WRONG = [
    "text",
    "",
    {},
    {"u": 1},
    [],
    [[]],
    [None],
    ["1"],
    [True],
    True,
    10**400,
    -(10**400),
    1e101,
    1e300,
    -7,
]


@pytest.mark.parametrize("family", MODELS)
def test_a_value_of_the_wrong_kind_is_refused_even_if_signed(family, tmp_path):
    content = model_to_dict(MODELS[family])
    path = tmp_path / "m.json"
    tried = 0
    for place in places(content):
        if place[0] in ("sha256", "provenance"):
            continue
        for value in [*WRONG, None]:
            tried += 1
            message = refused(path, signed(changed(content, place, value)))
            harmless = (
                (place[-1] in ("name", "unit") and isinstance(value, str))
                or (place[-1] in ("state", "after", "before") and value is None)
                or (
                    isinstance(value, (int, float))
                    and not isinstance(value, bool)
                    and abs(value) <= 1e300
                )
            )
            assert message or harmless, (place, value)
    assert tried > 200


@pytest.mark.parametrize("family", MODELS)
def test_numbers_that_no_model_can_hold_are_refused_even_if_signed(family, tmp_path):
    content = model_to_dict(MODELS[family])
    numbers = [
        p
        for p in places(content)
        if isinstance(p[-1], int) or p[-1] in ("offset", "center", "slope")
    ]
    numbers = [p for p in numbers if p[0] == "parameters"]
    assert len(numbers) >= 6
    for place in numbers:
        for value in ("text", None, True, [1.0], 10**400, 1e101, -1e300):
            assert refused(tmp_path / "m.json", signed(changed(content, place, value))), (
                place,
                value,
            )


@pytest.mark.parametrize("family", MODELS)
def test_a_missing_key_is_refused_even_if_signed(family, tmp_path):
    content = model_to_dict(MODELS[family])
    for place in places(content):
        if (
            isinstance(place[-1], int)
            or (place[0] == "provenance" and len(place) > 1)
            or place[-1] == "sha256"
        ):
            continue
        message = refused(tmp_path / "m.json", signed(without(content, place)))
        assert message, place


@pytest.mark.parametrize("family", MODELS)
def test_random_changes_of_signed_numbers_give_a_valid_model_or_a_refusal(family, tmp_path):
    rng = np.random.default_rng(list(MODELS).index(family))
    content = model_to_dict(MODELS[family])
    numbers = [p for p in places(content["parameters"]) if isinstance(p[-1], int)]
    outcomes = set()
    for _ in range(80):
        other = content
        for _ in range(int(rng.integers(1, 4))):
            place = ("parameters", *numbers[rng.integers(len(numbers))])
            value = (
                float(rng.choice([-1.0, 1.0]) * 10.0 ** rng.uniform(-320, 99))
                if rng.random() < 0.7
                else 0.0
            )
            other = changed(other, place, value)
        outcomes.add(refused(tmp_path / "m.json", signed(other)) is None)
    assert outcomes == {True, False} or family == "static"


NAMED = {
    "state that no input leaves": (("parameters", "state"), [0.0, 0.0, 9.0], "not admissible"),
    "state of another length": (("parameters", "state"), [0.0], "1 values for 3"),
    "unsorted thresholds": (("parameters", "thresholds"), [0.0, 0.5, 0.25], "increase strictly"),
    "negative threshold": (("parameters", "thresholds"), [-1.0, 0.5, 0.75], "negative"),
    "too few weights": (("parameters", "weights"), [1.0], "3 thresholds but 1 weights"),
    "weights as text": (("parameters", "weights"), "1 2 3", "weights is not a list"),
    "weights as truth values": (
        ("parameters", "weights"),
        [True, True, True],
        "weights is not a list",
    ),
    "no weights": (("parameters", "weights"), [], "shape"),
    "nested weights": (("parameters", "weights"), [[1.0], [2.0], [3.0]], "weights is not a list"),
    "huge weight": (("parameters", "weights"), [1.0, 1e300, 0.0], r"weights[1]"),
    "offset as text": (("parameters", "offset"), "0", "offset is not a number"),
    "unknown family": (("family",), "bouc-wen", "family 'bouc-wen'"),
    "family of another shape": (("family",), ["pi"], "family"),
    "schema of tomorrow": (("schema",), 2, "schema version 2"),
    "schema as text": (("schema",), "1", "schema version 1"),
    "schema as a real number": (("schema",), 1.0, "schema version 1.0"),
    "schema as truth": (("schema",), True, "schema version True"),
    "another format": (("format",), "onnx", "not a dehyst model"),
    "provenance as a list": (("provenance",), [], "provenance is not an object"),
    "signal without a name": (("input", "name"), 7, "does not name a signal"),
    "range upside down": (("input", "low"), 5.0, "no valid range"),
    "half a range": (("input", "low"), None, "no valid range"),
    "half a surrogate pair": (("input", "name"), "\ud800", "checksum"),
}


@pytest.mark.parametrize("case", NAMED)
def test_the_refusal_names_the_fault(case, tmp_path):
    place, value, words = NAMED[case]
    message = refused(
        tmp_path / "m.json", signed(changed(model_to_dict(MODELS["pi"]), place, value))
    )
    assert message is not None
    assert words in message


def test_a_wrong_checksum_is_named(tmp_path):
    content = model_to_dict(MODELS["pi"])
    for digest in (
        "0" * 64,
        "",
        None,
        5,
        content["sha256"].upper(),
        content["sha256"][:-1],
        [content["sha256"]],
    ):
        assert "checksum" in refused(tmp_path / "m.json", json.dumps({**content, "sha256": digest}))
    content["parameters"]["weights"][0] = 1.0000000000000002
    assert "checksum" in refused(tmp_path / "m.json", json.dumps(content))


def literal(text):
    """Return a model file with another literal in place of the first weight."""
    return json.dumps(model_to_dict(MODELS["pi"])).replace('"weights": [1.0', f'"weights": [{text}')


RAW = {
    "nothing": b"",
    "white space": b" \n\t ",
    "a null byte": b"\0",
    "a number": b"1",
    "a word": b"null",
    "an empty list": b"[]",
    "an empty object": b"{}",
    "not a number": literal("NaN"),
    "infinity": literal("Infinity"),
    "negative infinity": literal("-Infinity"),
    "1e999": literal("1e999"),
    "5000 digits": literal("1" + "0" * 5000),
    "4000 digits": literal("1" + "0" * 4000),
    "a million digits": literal("1" + "0" * 10**6),
    "a million decimals": literal("1." + "3" * 10**6),
    "huge exponent": literal("1e" + "9" * 1000),
    "hexadecimal": literal("0x1"),
    "comment": literal("1.0 /* one */"),
    "trailing comma": literal("1.0,").replace("[1.0,,", "[1.0, ,"),
    "two models": json.dumps(model_to_dict(MODELS["pi"])) * 2,
    "single quotes": str(model_to_dict(MODELS["pi"])),
    "100 000 lists": b"[" * 100_000,
    "100 000 closed lists": b"[" * 100_000 + b"]" * 100_000,
    "100 000 objects": b'{"a":' * 100_000 + b"1" + b"}" * 100_000,
    "deep provenance": '{"format":"dehyst-model","schema":1,"provenance":'
    + "[" * 500
    + "]" * 500
    + "}",
    "UTF-16": json.dumps(model_to_dict(MODELS["pi"])).encode("utf-16"),
    "UTF-32": json.dumps(model_to_dict(MODELS["pi"])).encode("utf-32"),
    "Latin-1": json.dumps(model_to_dict(MODELS["pi"]), ensure_ascii=False).encode("latin-1"),
    "pickle": b"\x80\x04\x95\x10\x00\x00\x00\x00\x00\x00\x00\x8c\x05posix\x94\x8c\x06system\x94\x93\x94.",
    "zip": b"PK\x03\x04" + bytes(range(256)) * 20,
    "key twice": json.dumps(model_to_dict(MODELS["pi"])).replace(
        '"schema": 1', '"schema": 1, "schema": 1'
    ),
    "inner key twice": json.dumps(model_to_dict(MODELS["pi"])).replace(
        '"offset": 0.5', '"offset": 7.0, "offset": 0.5'
    ),
    "many keys": "{" + ",".join(f'"{k}":0' for k in range(300_000)) + "}",
    "many keys, one twice": "{" + ",".join(f'"{k}":0' for k in range(300_000)) + ',"7":1}',
}


@pytest.mark.parametrize("case", RAW)
def test_what_is_no_model_file_is_refused(case, tmp_path):
    assert refused(tmp_path / "m.json", RAW[case])


def test_the_literals_above_do_reach_the_weights(tmp_path):
    assert refused(tmp_path / "m.json", literal("1.0")) is None


def test_random_bytes_are_refused(tmp_path):
    rng = np.random.default_rng(0)
    for size in (1, 10, 1000, 100_000):
        for _ in range(10):
            assert refused(tmp_path / "m.json", rng.bytes(size))
            assert refused(
                tmp_path / "m.json",
                bytes(rng.choice(list(b'{}[]",:0123456789.eE+-tfn \n'), size).tolist()),
            )


@pytest.mark.parametrize("filling", [b" ", b"\0", b"[1,", b"7"])
def test_a_file_of_40_megabytes_is_refused_unread(filling, tmp_path):
    assert "larger than" in refused(tmp_path / "m.json", filling * (40_000_000 // len(filling)))


@pytest.mark.parametrize(
    "filling", [b" ", b"1.5,", b"[],", b'{"a":1},', b'"\\u0041",', b"12345678901234567890,"]
)
def test_the_largest_file_that_is_read_is_judged_without_a_hang(filling, tmp_path):
    head = b'{"format":"dehyst-model","schema":1,"provenance":['
    body = filling * ((2 * 1024 * 1024 - 200) // len(filling))
    assert refused(tmp_path / "m.json", head + body + b'0],"sha256":"x"}')


def test_a_folder_is_no_model_file(tmp_path):
    assert "folder" in refused(tmp_path, None)


def test_a_missing_file_is_named(tmp_path):
    assert "does not exist" in refused(tmp_path / "none.json", None)
    assert refused(tmp_path / "none" / "none.json", None)
    assert refused(tmp_path / ("n" * 5000), None)
    (tmp_path / "file").write_text("x")
    assert refused(tmp_path / "file" / "m.json", None)
    with pytest.raises(ModelFileError):
        load(f"{tmp_path}/a\0b")


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="this system has no named pipes")
def test_a_named_pipe_does_not_hang(tmp_path):
    def hangs(*_):
        raise TimeoutError("load waits for a writer that never comes")

    os.mkfifo(tmp_path / "pipe")
    old = signal.signal(signal.SIGALRM, hangs)
    signal.alarm(5)
    try:
        assert "no regular file" in refused(tmp_path / "pipe", None)
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, old)


@pytest.mark.skipif(not Path("/dev/zero").exists(), reason="this system has no endless device")
def test_an_endless_device_is_no_model_file():
    with pytest.raises(ModelFileError, match="no regular file"):
        load("/dev/zero")


def test_links_in_a_circle_are_refused(tmp_path):
    a, b = tmp_path / "a", tmp_path / "b"
    try:
        a.symlink_to(b)
        b.symlink_to(a)
    except OSError:
        pytest.skip("this system allows no symbolic links")
    assert refused(a, None)


@pytest.mark.skipif(
    not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root may read everything"
)
def test_a_file_that_may_not_be_read_is_named(tmp_path):
    path = PLAY.save(tmp_path / "m.json")
    path.chmod(0)
    assert "cannot be read" in refused(path, None)
