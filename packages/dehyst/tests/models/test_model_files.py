"""Model files: what is saved comes back bit for bit, and a failed save changes nothing."""

import json
import os
import stat
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from dehyst import (
    ModifiedPrandtlIshlinskii,
    MonotoneMap,
    PrandtlIshlinskii,
    StopOperatorModel,
    load,
)
from dehyst.errors import OutputError, ParameterError
from dehyst.models import ModelCard, SignalCard, StaticCurve, model_to_dict
from dehyst.models._storage import model_from_dict

one_file = settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
any_float = st.floats(-1e100, 1e100) | st.sampled_from(
    [0.0, -0.0, 5e-324, -5e-324, 1e-300, 2.2250738585072014e-308]
)
plain = st.recursive(
    st.none()
    | st.booleans()
    | st.integers(-(2**70), 2**70)
    | st.floats(allow_nan=False, allow_infinity=False)
    | st.text(st.characters(exclude_categories=["Cs"]), max_size=8),
    lambda inner: (
        st.lists(inner, max_size=3)
        | st.dictionaries(
            st.text(st.characters(exclude_categories=["Cs"]), max_size=5), inner, max_size=3
        )
    ),
    max_leaves=6,
)


@st.composite
def increasing(draw, least, first=None):
    values = draw(st.lists(any_float, min_size=least, max_size=7, unique_by=lambda v: v + 0.0))
    values = np.unique(np.array(values) + 0.0)
    return (
        values
        if first is None
        else np.concatenate([[first], np.unique(np.abs(values[values != first]))])
    )


@st.composite
def plays(draw):
    r = draw(increasing(0, first=draw(st.sampled_from([0.0, 0.0, -0.0]))))
    w = draw(st.lists(any_float, min_size=r.size, max_size=r.size))
    shares = np.array(draw(st.lists(st.floats(-0.9, 0.9), min_size=r.size, max_size=r.size)))
    state = (
        None
        if draw(st.booleans())
        else np.cumsum(np.concatenate([shares[:1], shares[1:] * np.diff(r)]))
    )
    if state is not None and np.max(np.abs(state)) > 1e100:
        state = np.zeros(r.size)
    return PrandtlIshlinskii(r, w, draw(any_float), state, draw(any_float))


@st.composite
def maps(draw):
    u, v = draw(increasing(2)), draw(increasing(2))
    n = min(u.size, v.size)
    return MonotoneMap(u[:n], v[:n] if draw(st.booleans()) else v[:n][::-1])


@st.composite
def stops(draw):
    play = draw(plays())
    s = np.array(
        draw(
            st.lists(st.floats(-1e90, 1e90), min_size=play.weights.size, max_size=play.weights.size)
        )
    )
    s[0] = 0.0
    return StopOperatorModel(
        play.thresholds, s, draw(st.floats(-1e90, 1e90)), play.offset, play.state, play.center
    )


def modified(inner, after, before, both):
    return ModifiedPrandtlIshlinskii(inner, after, before if both else None)


signals = st.builds(
    lambda name, unit, ends: SignalCard(name, unit, *(sorted(ends) if ends else (None, None))),
    st.text(st.characters(exclude_categories=["Cs"]), max_size=10),
    st.sampled_from(["", "bar", "°", "N·m", "µm"]),
    st.none() | st.tuples(any_float, any_float),
)
facts = st.dictionaries(st.sampled_from(["log", "date", "verdict", "grade"]), plain)
cards = st.builds(ModelCard, signals, signals, facts)
families = st.one_of(
    plays(),
    stops(),
    maps().map(StaticCurve),
    st.builds(modified, plays(), maps(), maps(), st.booleans()),
)


def bits(value):
    """Return all numbers of a model as bytes, by field."""
    if value is None or isinstance(value, (str, bool)):
        return value
    if isinstance(value, (float, np.ndarray)):
        return np.asarray(value, dtype=np.float64).tobytes()
    if isinstance(value, ModelCard):
        return (value.input, value.output, json.dumps(dict(value.provenance), sort_keys=True))
    return (
        type(value).__name__,
        {name: bits(getattr(value, name)) for name in value.__dataclass_fields__},
    )


@one_file
@given(families, cards)
def test_every_family_comes_back_bit_for_bit(tmp_path, model, card):
    model = model.with_card(card)
    path = tmp_path / "m.json"
    assert model.save(path) == path
    again = load(path)
    assert type(again) is type(model)
    assert bits(again) == bits(model)
    x = np.linspace(-2.0, 2.0, 9)
    assert again.simulate(x).tobytes() == model.simulate(x).tobytes()
    again.save(tmp_path / "again.json")
    assert (tmp_path / "again.json").read_bytes() == path.read_bytes()


def test_the_comparison_of_bits_sees_the_last_one():
    a = PrandtlIshlinskii([0.0, 1.0], [1.0, 2.0])
    assert bits(a) != bits(PrandtlIshlinskii([0.0, 1.0], [1.0, np.nextafter(2.0, 3.0)]))
    assert bits(a) != bits(PrandtlIshlinskii([0.0, 1.0], [1.0, 2.0], offset=-0.0))
    assert bits(a) != bits(a.with_card(ModelCard(SignalCard("p"))))


def test_inverses_are_models_that_can_be_saved(tmp_path):
    bend = MonotoneMap([0.0, 1.0, 3.0], [0.0, -2.0, -3.0])
    inner = PrandtlIshlinskii([0.0, 0.1, 0.7], [1e-3, 0.3, 0.1], 0.5, [0.1, 0.0, 0.2], -1.0)
    for model in (inner, ModifiedPrandtlIshlinskii(inner, after_map=bend), StaticCurve(bend)):
        inverse = model.inverse()
        inverse.save(tmp_path / "i.json")
        assert bits(load(tmp_path / "i.json")) == bits(inverse)


def test_a_file_is_plain_readable_json(tmp_path):
    card = ModelCard(
        SignalCard("pressure", "bar", 0.0, 4.0),
        SignalCard("angle", "°"),
        {"log": "a.csv", "n": [1, 2]},
    )
    PrandtlIshlinskii([0.0, 0.5], [1.0, 0.1], card=card).save(tmp_path / "m.json")
    text = (tmp_path / "m.json").read_text(encoding="utf-8")
    content = json.loads(text)
    assert content["format"] == "dehyst-model"
    assert content["schema"] == 1
    assert content["parameters"]["weights"] == [1.0, 0.1]
    assert content["input"] == {"name": "pressure", "unit": "bar", "low": 0.0, "high": 4.0}
    assert content["provenance"] == {"log": "a.csv", "n": [1, 2]}
    assert text.endswith("}\n")


def test_whitespace_and_the_order_of_keys_do_not_matter(tmp_path):
    model = PrandtlIshlinskii([0.0, 0.5], [1.0, 0.1])
    content = model_to_dict(model)
    turned = dict(reversed(content.items()))
    for text in (
        json.dumps(turned),
        json.dumps(content, indent=7),
        "\n\n " + json.dumps(content) + "\r\n\t",
    ):
        (tmp_path / "m.json").write_text(text, encoding="utf-8")
        assert bits(load(tmp_path / "m.json")) == bits(model)


def test_tuples_and_number_keys_in_the_provenance_come_back_as_json_has_them(tmp_path):
    card = ModelCard(provenance={"window": (1, 2), "counts": {10: 1, 9: 2}})
    PrandtlIshlinskii([0.0], [1.0], card=card).save(tmp_path / "m.json")
    again = load(tmp_path / "m.json").card.provenance
    assert again["window"] == [1, 2]
    assert again["counts"] == {"10": 1, "9": 2}


def loop():
    ring = {}
    ring["ring"] = ring
    return ring


def deep(levels):
    value = []
    for _ in range(levels):
        value = [value]
    return {"deep": value}


@pytest.mark.parametrize(
    "provenance",
    [
        {"x": np.nan},
        {"x": np.inf},
        {"x": object()},
        {"x": np.zeros(2)},
        {"x": b"raw"},
        {(1, 2): 3},
        {"x": {1, 2}},
        {"x": "\ud800"},
        {"\udfff": 1},
        loop(),
        deep(40),
        deep(100_000),
    ],
    ids=[
        "nan",
        "inf",
        "object",
        "array",
        "bytes",
        "tuple-key",
        "set",
        "surrogate",
        "surrogate-key",
        "loop",
        "deep",
        "bottomless",
    ],
)
def test_what_a_reader_would_refuse_is_not_saved(tmp_path, provenance):
    model = PrandtlIshlinskii([0.0], [1.0])
    path = model.save(tmp_path / "m.json")
    before = path.read_bytes()
    with pytest.raises(ParameterError):
        model.with_card(ModelCard(provenance=provenance)).save(path)
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize(
    "ends", [(1.0, 0.0), (np.nan, 1.0), (0.0, np.inf), (None, 1.0), ("a", "b")]
)
def test_a_range_that_is_none_is_not_saved(tmp_path, ends):
    card = ModelCard(SignalCard("p", "bar", *ends))
    with pytest.raises(ParameterError):
        PrandtlIshlinskii([0.0], [1.0], card=card).save(tmp_path / "m.json")
    assert not list(tmp_path.iterdir())


def test_a_disk_that_fails_leaves_the_old_file(tmp_path, monkeypatch):
    path = PrandtlIshlinskii([0.0], [1.0]).save(tmp_path / "m.json")
    before = path.read_bytes()

    def full(_):
        raise OSError(28, "No space left on device")

    for name in ("fsync",):
        monkeypatch.setattr(os, name, full)
        with pytest.raises(OutputError, match="No space left"):
            PrandtlIshlinskii([0.0], [2.0]).save(path)
        monkeypatch.undo()
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]  # and no litter


def test_a_save_that_cannot_replace_leaves_the_old_file(tmp_path, monkeypatch):
    path = PrandtlIshlinskii([0.0], [1.0]).save(tmp_path / "m.json")
    before = path.read_bytes()

    def denied(*_):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "replace", denied)
    monkeypatch.setattr(os, "replace", denied)
    with pytest.raises(OutputError, match="untouched"):
        PrandtlIshlinskii([0.0], [2.0]).save(path)
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("name", ["missing/m.json", ".", "a\0b.json", "x" * 4000 + ".json"])
def test_a_place_that_cannot_be_written_is_named(tmp_path, name):
    with pytest.raises(OutputError, match="cannot write"):
        PrandtlIshlinskii([0.0], [1.0]).save(f"{tmp_path}/{name}")
    assert not list(tmp_path.iterdir())


@pytest.mark.skipif(os.name != "posix", reason="permissions are those of POSIX")
def test_a_saved_file_is_readable_like_any_other(tmp_path):
    path = PrandtlIshlinskii([0.0], [1.0]).save(tmp_path / "m.json")
    (tmp_path / "other").write_text("")
    assert stat.S_IMODE(path.stat().st_mode) == stat.S_IMODE((tmp_path / "other").stat().st_mode)


def test_saving_replaces_an_earlier_file(tmp_path):
    path = PrandtlIshlinskii([0.0], [1.0]).save(tmp_path / "m.json")
    PrandtlIshlinskii([0.0], [2.0]).save(path)
    assert load(path).weights.tolist() == [2.0]


def test_dictionaries_are_models_without_a_file():
    model = PrandtlIshlinskii([0.0, 0.5], [1.0, 0.1])
    assert bits(model_from_dict(model_to_dict(model))) == bits(model)
