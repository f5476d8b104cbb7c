"""Files of families that are rows now: recorded answers of the code that wrote them, for each parameter they had."""

import copy
import json
from pathlib import Path

import numpy as np
import pytest

import dehyst
from dehyst.errors import ModelFileError
from dehyst.families import ROWS, old_families
from dehyst.families.elements import ElementModel
from dehyst.models.storage import signed
from family_checks import same_in_parts, steps_like_arrays, uneven, wander

RECORDED = Path(__file__).parent / "former"
CASES = [
    pytest.param(case, id=f"{path.stem}-{number}")
    for path in sorted(RECORDED.glob("*.json"))
    for number, case in enumerate(json.loads(path.read_text(encoding="utf-8")))
]


def loaded(content, tmp_path):
    path = tmp_path / "model.json"
    path.write_text(json.dumps(content), encoding="utf-8")
    return dehyst.load(path)


@pytest.mark.parametrize("case", CASES)
def test_an_old_file_answers_as_the_code_that_wrote_it(case, tmp_path):
    model = loaded(case["file"], tmp_path)
    assert model.family == case["file"]["family"] and model.family in ROWS
    time, wanted = np.array(case["time"]), np.array(case["output"])
    y = model.simulate(case["input"], time)
    assert np.max(np.abs(y - wanted)) < 1e-12 * np.ptp(wanted)
    if case["asked"] is not None:
        asked = np.array(case["asked"])
        x = model.inverse().simulate(case["demand"], time)
        assert np.max(np.abs(x - asked)) < 1e-12 * np.ptp(case["input"])
    back = model.inverse().simulate(y, time)
    assert np.max(np.abs(back - case["input"])) < 1e-10 * np.ptp(case["input"])
    again = dehyst.load(model.save(tmp_path / "again.json"))
    assert np.array_equal(again.simulate(case["input"], time), y)


@pytest.mark.parametrize("case", CASES)
def test_parts_and_steps_are_the_whole_bit_for_bit(case, tmp_path):
    model = loaded(case["file"], tmp_path)
    x, time = wander(900), uneven(900)
    dt = np.diff(time, prepend=time[0]) if model.rate_dependent else None
    assert same_in_parts(model, x, dt)
    outputs = model.simulate(model.scaling.center + model.scaling.half_range * x, time)[:60]
    assert steps_like_arrays(model, np.linspace(*np.sort(outputs)[[0, -1]], 60), time[:60])


def test_what_a_sum_of_elements_is_becomes_one_and_only_the_rest_stays_as_it_was(tmp_path):
    kept = {}
    for case in (parameter.values[0] for parameter in CASES):
        model = loaded(case["file"], tmp_path)
        kept.setdefault(model.family, []).append(isinstance(model, ElementModel))
    assert kept == {
        "creep-pi": [False, False, False],
        "rate-dependent-pi": [False, False, True],  # the last one's thresholds do not grow
        "generalised-pi": [False, False, True, True],  # the first two have a tangent
        "maxwell-slip": [True, True, False, False, False, True],  # dampers, and positions over a force
        "krasnoselskii-pokrovskii": [True] * 4,
    }


CREEP = next(p.values[0]["file"] for p in CASES if p.values[0]["file"]["family"] == "creep-pi")
RATE = next(p.values[0]["file"] for p in CASES if p.values[0]["file"]["family"] == "rate-dependent-pi")
SLIP = next(p.values[0]["file"] for p in CASES if p.values[0]["file"]["family"] == "maxwell-slip")
KERNELS = next(p.values[0]["file"] for p in CASES if p.values[0]["file"]["family"] == "krasnoselskii-pokrovskii")
PLANE = next(p.values[0]["file"] for p in CASES if p.values[0]["file"]["family"] == "generalised-pi")


def changed(content, **values):
    """The file with other values, signed again; None takes one away."""
    made = copy.deepcopy(content["parameters"])
    made["values"] |= {name: value for name, value in values.items() if value is not None}
    for name in (name for name, value in values.items() if value is None):
        del made["values"][name]
    card = old_families.ModelCard()
    return signed("dehyst-family", content["family"], made, card)


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (changed(CREEP, weights=[1.0, 2.0]), "3 values|2 values"),
        (changed(CREEP, time_constants=[0.0, 1.0, 1.0, 1.0]), "takes time"),
        (changed(CREEP, weights=[-1.0, 0.1, 0.1]), "from 0 on"),
        (changed(CREEP, map_inner=[0.0, 1.0], map_outer=[1.0, 0.0]), "map_outer"),
        (changed(CREEP, period=None), "parameters"),
        (changed(RATE, lag=0.0), "lag"),
        (changed(PLANE, shape=[1.0, -1.0, 0.0, 0.0]), "tangent"),
        (changed(SLIP, stiffness=-1.0), "stiffness"),
        (changed(SLIP, position="yes"), "position"),
        (changed(SLIP, extra=1.0), "parameters"),
        (changed(KERNELS, ridge=0.0), "ridge"),
        (changed(KERNELS, weights=[1.0]), "weights"),
    ],
)
def test_a_damaged_file_is_refused_with_the_reason(content, said, tmp_path):
    with pytest.raises(ModelFileError, match=said):
        loaded(content, tmp_path)


def test_what_cannot_be_undone_step_by_step_says_so(tmp_path):
    fast = changed(CREEP, thresholds=[0.0], weights=[0.02], creep_thresholds=[0.0], time_constants=[0.01],
                   creep_weights=[0.9], period=0.01)  # fmt: skip
    assert "creep is too fast" in loaded(fast, tmp_path).no_inverse
    late = changed(RATE, direct=0.1, thresholds=[0.1], growths=[0.5], weights=[0.9], lag=0.1)
    assert "delays the output by up to 0.45 s" in loaded(late, tmp_path).no_inverse
    assert "at once" in loaded(changed(CREEP, thresholds=[0.1, 0.2, 0.5]), tmp_path).no_inverse


@pytest.mark.parametrize("old", old_families.RENAMED)
def test_rows_that_had_another_name_keep_their_models(old, tmp_path):
    model = ElementModel(row=old_families.RENAMED[old])
    values = model.parameters() | {"row": old}
    scaling = {"center": 0.0, "half_range": 1.0, "level": 0.0, "amplitude": 1.0}
    content = signed(
        "dehyst-family", old, {"values": values, "scaling": scaling, "start": "rest"}, old_families.ModelCard()
    )
    assert loaded(content, tmp_path).parameters() == model.parameters()
