"""Families with absurd parameters, from records and signed files, end with a cure: no traceback, no infinities."""

import copy
import dataclasses
import json

import numpy as np
import pytest

from dehyst import load
from dehyst.errors import ModelFileError, ParameterError
from dehyst.families import Scaling, example, names
from dehyst.models._storage import signed
from in_one import in_one

T = 120
TIME = 0.01 * np.arange(T)
PATH = np.sin(0.15 * np.arange(T))


@pytest.mark.parametrize(
    "value", [0.0, float("nan"), float("inf"), 1e308, 1e-308, "x", None, [1.0, 2.0]]
)
@pytest.mark.parametrize("name", ["half_range", "amplitude"])
def test_a_scaling_that_makes_one_point_of_a_signal_is_refused(name, value):
    with pytest.raises(ParameterError, match=name):
        Scaling(**{name: value})


@pytest.mark.parametrize("name", names())
@in_one(
    "bad", [{"scaling": None}, {"scaling": 2.0}, {"start": []}, {"start": ["rest"]}, {"start": 3}]
)
def test_a_scaling_or_start_of_another_kind_is_refused(name, bad):
    with pytest.raises(ParameterError, match=next(iter(bad))):
        dataclasses.replace(example(name), **bad).simulate(PATH, TIME)


ARRAYS = [
    (name, entry.name)
    for name in names()
    for entry in dataclasses.fields(example(name))
    if isinstance(getattr(example(name), entry.name), np.ndarray)
]


@pytest.mark.parametrize(("name", "key"), ARRAYS)
@in_one("value", [None, "x", {}, [[1.0, 2.0], [3.0]], [float("nan")], [1j], [1e200, 2e200]])
def test_an_array_of_parameters_that_holds_no_numbers_is_refused_by_name(name, key, value):
    with pytest.raises(ParameterError, match=key):
        dataclasses.replace(example(name), **{key: value})


@pytest.mark.parametrize(("name", "power"), [("bouc-wen", [1e6]), ("generalised-bouc-wen", 1e6)])
def test_a_power_that_would_take_minutes_is_refused(name, power):
    with pytest.raises(ParameterError, match="power"):
        dataclasses.replace(example(name), power=power)


def test_a_model_that_diverges_says_so_instead_of_infinities():
    model = dataclasses.replace(
        example("generalised-bouc-wen"), beta=[-6.0, 1.0, -1.0, -1.0, -0.5, -0.5]
    )
    with pytest.raises(ParameterError, match="diverge"):
        model.simulate(50.0 * PATH)


@pytest.mark.parametrize("name", names())
@pytest.mark.parametrize("part", ["start", "values", "scaling"])
def test_what_a_hostile_file_holds_is_not_printed_at_length(name, part, tmp_path):
    model = example(name)
    path = model.save(tmp_path / "m.json")
    content = json.loads(path.read_text())
    parameters = copy.deepcopy(content["parameters"])
    parameters[part] = (
        {f"key{k}": 1.0 for k in range(2000)} if part != "start" else list(range(2000))
    )
    path.write_text(json.dumps(signed("dehyst-family", name, parameters, model.card)))
    with pytest.raises(ModelFileError) as fault:
        load(path)
    assert len(str(fault.value)) < 1000 + len(str(path))
