"""What every hysteresis family promises, whoever wrote it: asked of each name of the registry."""

import dataclasses
import importlib
import json

import numpy as np
import pytest

import dehyst
from dehyst import families
from dehyst.errors import DehystError, InvertibilityError, ParameterError
from dehyst.families import STARTS, LoopModel, Scaling, example, family, names

T = 240
TIME = 0.02 * np.arange(T)
PATH = np.sin(2.1 * TIME * (1.0 + 0.3 * TIME)) * np.linspace(1.0, 0.3, T) + 0.1 * np.sin(
    17.0 * TIME
)
SCALING = Scaling(center=3.0, half_range=2.0, level=-5.0, amplitude=7.0)


def scaled(name, start="zero"):
    return dataclasses.replace(example(name), scaling=SCALING, start=start)


def inputs(path=PATH):
    return SCALING.center + SCALING.half_range * path


@pytest.mark.parametrize("name", names())
def test_a_run_cut_in_pieces_is_the_same_run_bit_for_bit(name):
    model = example(name)
    dt = np.diff(TIME, prepend=TIME[:1]) if model.rate_dependent else None
    whole, last = model.run(PATH, dt, model.rest(float(PATH[0])))
    memory, parts = model.rest(float(PATH[0])), []
    for part in (slice(0, 1), slice(1, 2), slice(2, 100), slice(100, T)):
        kept = memory.copy()
        y, after = model.run(
            np.ascontiguousarray(PATH[part]), None if dt is None else dt[part].copy(), memory
        )
        assert np.array_equal(memory, kept), "the memory that was given has changed"
        parts.append(y)
        memory = after
    assert np.array_equal(np.concatenate(parts), whole)
    assert np.array_equal(memory, last)


@pytest.mark.parametrize("name", [n for n in names() if not example(n).no_inverse])
def test_an_inverse_cut_in_pieces_is_the_same_inverse_bit_for_bit(name):
    model = example(name)
    dt = np.diff(TIME, prepend=TIME[:1]) if model.rate_dependent else None
    start = model.rest(float(PATH[0]))
    y = model.run(PATH, dt, start)[0] + 0.01 * np.random.default_rng(3).normal(size=T)
    for inverse in (model.run_inverse, lambda *given: LoopModel.run_inverse(model, *given)):
        whole, last = inverse(y, dt, start)
        memory, parts = start, []
        for part in (slice(0, 1), slice(1, 2), slice(2, 100), slice(100, T)):
            x, memory = inverse(
                np.ascontiguousarray(y[part]), None if dt is None else dt[part].copy(), memory
            )
            parts.append(x)
        assert np.array_equal(np.concatenate(parts), whole)
        assert np.array_equal(memory, last)


@pytest.mark.parametrize("name", names())
@pytest.mark.parametrize("start", STARTS)
def test_every_start_state_gives_finite_outputs(name, start):
    y = scaled(name, start).simulate(inputs(), TIME)
    assert y.shape == (T,) and np.all(np.isfinite(y))
    assert np.ptp(y) > 0.0


@pytest.mark.parametrize("name", names())
def test_an_unknown_start_is_refused(name):
    with pytest.raises(ParameterError, match="rising"):
        scaled(name, "somewhere").simulate(inputs(), TIME)


@pytest.mark.parametrize("name", names())
@pytest.mark.parametrize("start", ["rest", "zero", "falling"])
def test_the_inverse_undoes_the_model_or_its_absence_is_explained(name, start):
    model = scaled(name, start)
    if model.no_inverse:
        with pytest.raises(InvertibilityError) as fault:
            model.inverse()
        assert model.no_inverse in str(fault.value) and len(model.no_inverse) > 30
        return
    x = inputs()
    back = model.inverse().simulate(model.simulate(x, TIME), TIME)
    assert np.max(np.abs(back - x)) < 1e-9 * np.ptp(x)
    assert model.inverse().inverse() is model


@pytest.mark.parametrize("name", names())
def test_the_stepper_is_the_simulation_sample_by_sample(name):
    model = scaled(name)
    x = inputs()[:80]
    step = model.stepper()
    steps = np.diff(TIME[:80], prepend=0.0)
    y = model.simulate(x, TIME[:80])
    for _ in range(2):
        seen = np.array([step(value, dt) for value, dt in zip(x, steps, strict=True)])
        assert np.allclose(seen, y, rtol=0.0, atol=1e-9 * np.ptp(y))
        assert step(float("nan")) == seen[-1]
        step.reset()
    if not model.no_inverse:
        back = model.inverse().stepper()
        seen = np.array([back(value, dt) for value, dt in zip(y, steps, strict=True)])
        assert np.max(np.abs(seen - x)) < 1e-9 * np.ptp(x)


@pytest.mark.parametrize("name", names())
def test_parameters_are_plain_values(name):
    parameters = example(name).parameters()
    assert parameters and not {"scaling", "start", "card"} & set(parameters)
    assert json.loads(json.dumps(parameters, allow_nan=False)) == parameters


@pytest.mark.parametrize("name", names())
def test_a_model_cannot_be_changed(name):
    model = example(name)
    for field in dataclasses.fields(model):
        with pytest.raises(dataclasses.FrozenInstanceError):
            setattr(model, field.name, getattr(model, field.name))
        value = getattr(model, field.name)
        if isinstance(value, np.ndarray):
            assert not value.flags.writeable, field.name


@pytest.mark.parametrize("name", names())
def test_a_sample_that_is_no_number_is_refused_with_a_cure(name):
    x = inputs().copy()
    x[7] = np.nan
    with pytest.raises(ParameterError, match="index 7") as fault:
        scaled(name).simulate(x, TIME)
    assert "Drop" in str(fault.value)
    assert scaled(name).simulate([], []).size == 0


@pytest.mark.parametrize("name", [n for n in names() if example(n).rate_dependent])
def test_a_rate_dependent_family_asks_for_time(name):
    for time in (None, TIME[:-1], TIME[::-1]):
        with pytest.raises(ParameterError, match="time"):
            scaled(name).simulate(inputs(), time)


@pytest.mark.parametrize("name", names())
def test_the_output_keeps_the_units_of_the_log(name):
    f = dataclasses.replace(example(name), start="zero").simulate(PATH, TIME)
    y = scaled(name).simulate(inputs(), TIME)
    assert np.allclose(y, SCALING.level + SCALING.amplitude * f, rtol=0.0, atol=1e-9 * np.ptp(y))


@pytest.mark.parametrize("name", names())
def test_a_family_says_what_it_is(name):
    found, model = family(name), example(name)
    assert found.name == model.family == name
    assert isinstance(model, found.model) and name in repr(model)
    assert found.title and len(found.source) > 10
    assert model.free_parameters >= 1
    text = (
        importlib.import_module(families.MODULES.get(name, "dehyst.families._rows")).__doc__ or ""
    )
    assert "::" in text, "no equation"
    assert "Cannot show" in text and "Source" in text


@pytest.mark.slow
@pytest.mark.parametrize("name", names())
def test_a_family_recovers_its_own_example_or_says_why_not(name):
    model = scaled(name)
    t = 0.02 * np.arange(900)
    x = inputs(np.sin(1.7 * t) * np.linspace(1.0, 0.4, t.size) + 0.05 * np.sin(9.0 * t))
    y = model.simulate(x, t) + 1e-3 * np.random.default_rng(1).normal(size=t.size)
    record = dehyst.Recording(input=x, output=y, time=t)
    try:
        first = dehyst.identify(record, name)
    except DehystError as fault:
        assert len(str(fault)) > 60
        return
    assert first.test.rmse_percent < 5.0
    second = dehyst.identify(record, name)
    assert second.model.parameters() == first.model.parameters(), "the same seed gave another model"
    assert ("seed" not in first.settings) == family(name).convex
    assert first.model.free_parameters >= 1
