"""Files of direct inverses: bit for bit back, and refused when they are damaged, hostile, or of the other kind."""

import json

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import dehyst
from dehyst.errors import ModelFileError
from dehyst.models import DirectInverse, ModelCard, Schedule, SignalCard, model_to_dict
from dehyst.models._storage import model_from_dict
from effort import no_hang
from test_model_files_hostile import signed

CARD = ModelCard(
    SignalCard("pressure", "bar", 0.0, 4.0),
    SignalCard("angle", "deg", -10.0, 10.0),
    {"log": "a.csv"},
)
MODEL = DirectInverse(
    radii=[0.5, 2.0],
    stop_weights=[[0.1, 0.2], [0.3, 0.0], [0.0, 0.1], [0.1, 0.1]],
    path_lengths=[1.0],
    path_weights=[[0.1], [0.2], [0.0], [0.3]],
    time_constants=[4.0, 25.0],
    creep_weights=[[0.1, 0.1], [0.0, 0.2], [0.1, 0.0], [0.0, 0.0]],
    polynomial=[[0.0, 1.0], [0.1, 1.1], [0.0, 0.5], [0.2, 0.6]],
    viscous=[0.0, 0.1, 0.2, 0.0],
    center=0.1,
    schedules=(Schedule("output", -10.0, 10.0), Schedule("load", 0.0, 50.0, "N")),
    past="unknown",
    card=CARD,
)
PASTS = ("unknown", "rest", "rising", "falling")
number = st.floats(-1e100, 1e100) | st.sampled_from([0.0, -0.0, 5e-324, 1e-300])
weight = st.floats(0.0, 1e100)


def same(a, b):
    names = (
        "radii",
        "stop_weights",
        "path_lengths",
        "path_weights",
        "time_constants",
        "creep_weights",
        "polynomial",
    )
    arrays = all(getattr(a, n).tobytes() == getattr(b, n).tobytes() for n in (*names, "viscous"))
    return arrays and (a.center, a.schedules, a.past, a.card) == (
        b.center,
        b.schedules,
        b.past,
        b.card,
    )


@st.composite
def models(draw):
    scale = st.lists(st.floats(1e-6, 1e6), max_size=4, unique=True).map(sorted)
    schedules = draw(
        st.sampled_from([(), (Schedule("output", -1.0, 2.0),), (Schedule("load", 1.0, 2.0, "N"),)])
    )
    sets = max(1, 2 * len(schedules))
    scales = [draw(scale) for _ in range(3)]
    tables = [[[draw(weight) for _ in each] for _ in range(sets)] for each in scales]
    curve = [[draw(number) for _ in range(3)] for _ in range(sets)]
    return DirectInverse(
        scales[0], tables[0], scales[1], tables[1], scales[2], tables[2], curve, [draw(weight) for _ in range(sets)],
        draw(number), schedules, draw(st.sampled_from(PASTS)), CARD,
    )  # fmt: skip


@settings(
    suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=40, deadline=None
)
@given(models())
def test_a_direct_inverse_comes_back_bit_for_bit(tmp_path, model):
    again = dehyst.load(model.save(tmp_path / "m.json"))
    assert same(again, model)
    assert same(model_from_dict(json.loads(json.dumps(model_to_dict(model)))), model)


@pytest.mark.parametrize(("known", "past"), [(True, "rest"), (False, "unknown")])
def test_a_file_from_before_pasts_had_names_begins_as_it_did(tmp_path, known, past):
    content = model_to_dict(MODEL)
    del content["parameters"]["past"]
    content["parameters"]["known"] = known
    (tmp_path / "m.json").write_text(signed(content), encoding="utf-8")
    assert dehyst.load(tmp_path / "m.json").past == past


def places(value, path=()):
    """Paths to every part of a JSON value."""
    yield path
    children = (
        value.items()
        if isinstance(value, dict)
        else enumerate(value)
        if isinstance(value, list)
        else ()
    )
    for key, child in children:
        yield from places(child, (*path, key))


def changed(value, path, new):
    copy = json.loads(json.dumps(value))
    inner = copy
    for key in path[:-1]:
        inner = inner[key]
    inner[path[-1]] = new
    return copy


PARTS = [path for path in places(model_to_dict(MODEL)["parameters"]) if path]
HOSTILE = [None, True, "1", -1.0, 1e300, 10**400, [], {}, [[]], [1.0], [[1.0]], {"name": "x"}]


@pytest.mark.parametrize("new", HOSTILE, ids=lambda new: repr(new)[:12])
def test_a_signed_file_of_anything_is_a_model_or_refused_by_name(tmp_path, new):
    content = model_to_dict(MODEL)
    for path in PARTS:
        file = tmp_path / "m.json"
        file.write_text(signed(changed(content, ("parameters", *path), new)), encoding="utf-8")
        try:
            with no_hang(f"{path}: {new!r:.40}"):
                model = dehyst.load(file)
        except ModelFileError as fault:
            assert str(file) in str(fault)
            assert len(str(fault)) < 1000 + len(str(file))
        else:
            with np.errstate(all="ignore"):
                run = model.run([0.0, 1.0], [0.0, 1.0], given={s.name: 1.0 for s in model.outside})
            assert np.all(np.isfinite(run.u))


def test_a_missing_part_and_an_edited_number_are_refused(tmp_path):
    content, file = model_to_dict(MODEL), tmp_path / "m.json"
    for name in content["parameters"]:
        less = {
            **content,
            "parameters": {k: v for k, v in content["parameters"].items() if k != name},
        }
        file.write_text(signed(less))
        with pytest.raises(ModelFileError, match=name):
            dehyst.load(file)
    file.write_text(json.dumps(changed(content, ("parameters", "radii", 0), 0.6)))
    with pytest.raises(ModelFileError, match="checksum"):
        dehyst.load(file)
