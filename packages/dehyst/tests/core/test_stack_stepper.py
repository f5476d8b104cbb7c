"""The logarithmic stepper from Python: chosen by the model, guarded, saved, and as cheap to call as the dense one."""

import math
import pickle

import numpy as np
import pytest

from dehyst import (
    ModifiedPrandtlIshlinskii,
    MonotoneMap,
    PrandtlIshlinskii,
    StopOperatorModel,
    _native,
)
from dehyst._native import StackStepper, Stepper
from dehyst.errors import ParameterError
from dehyst.models import StaticCurve
from dehyst.models._policy import POLICY
from dehyst_robot import _native as _robot
from dehyst_robot.control import Adaptation, JointControllerParameters
from in_one import in_one
from oracles import random_thresholds, random_walk, random_weights

BAD = (
    math.nan,
    -math.nan,
    math.inf,
    -math.inf,
    1e300,
    -1e300,
    math.nextafter(_native.INPUT_LIMIT, math.inf),
)


def models():
    rng = np.random.default_rng(0)
    inner = PrandtlIshlinskii(
        random_thresholds(rng, 9), random_weights(rng, 9, "mixed"), 0.25, None, 0.1
    )
    bend = MonotoneMap([-2.0, 0.0, 2.0], [-1.0, 0.0, 3.0])
    visited = inner.with_state(inner.final_state(random_walk(rng, 60)))
    return {
        "pi": inner,
        "visited": visited,
        "inverse": visited.inverse(),
        "dead zone": PrandtlIshlinskii([0.2, 0.3, 0.7], [1.0, -0.25, 0.5], state=[0.1, 0.0, 0.3]),
        "modified": ModifiedPrandtlIshlinskii(inner, after_map=bend, before_map=bend),
        "stop": StopOperatorModel([0.0, 0.3, 0.6], [0.0, 1.0, 0.5], 0.5),
        "static": StaticCurve(bend),
        "many": PrandtlIshlinskii(np.arange(300) / 300, np.full(300, 0.01)),
    }


every_model = pytest.mark.parametrize("model", models().values(), ids=models().keys())


def logarithmic(model):
    step = model.stepper("logarithmic")
    assert isinstance(step, StackStepper)
    return step


@every_model
def test_method_chooses_the_stepper_and_auto_is_dense_for_few_operators(model):
    dense, fast, auto = model.stepper("dense"), model.stepper("logarithmic"), model.stepper()
    assert (dense.method, fast.method) == ("dense", "logarithmic")
    assert (type(dense), type(fast)) == (Stepper, StackStepper)
    assert auto.method == ("dense" if dense.state.size <= POLICY.dense_up_to else "logarithmic")
    assert fast.state.shape == dense.state.shape
    for a, b in zip(dense.parameters, fast.parameters, strict=True):
        assert np.array_equal(a, b)


def test_auto_changes_at_a_hundred_operators():
    for n, method in ((100, "dense"), (101, "logarithmic")):
        assert PrandtlIshlinskii(np.arange(n) / n, np.ones(n)).stepper("auto").method == method


@every_model
@in_one("method", ["Dense", "log", "", b"dense", ()])
def test_an_unknown_method_is_refused_by_name(model, method):
    with pytest.raises(ParameterError, match=r"'dense' .* 'logarithmic' .* 'auto'") as fault:
        model.stepper(method)
    assert fault.value.facts["method"] == method


@every_model
def test_a_period_in_its_place_changes_nothing(model):
    told, untold = model.stepper(0.01), model.stepper(None)
    assert type(told) is type(untold) is type(model.stepper())
    assert [told(x) for x in (0.1, 0.4, -0.2)] == [untold(x) for x in (0.1, 0.4, -0.2)]


@every_model
@in_one("value", BAD)
def test_a_rejected_sample_holds_the_output_and_leaves_the_state(model, value):
    step, clean = logarithmic(model), logarithmic(model)
    assert step(value) == clean.output  # as the first sample too
    for v in (0.3, -0.8, 0.5):
        good = step(v)
        clean(v)
    image = step.save()
    for _ in range(3):
        assert step(value) == good == step.output
        assert step.rejected
        assert step.rejected_ever
        assert step.save()[:-1].tobytes() == image[:-1].tobytes()
    assert step(0.1) == clean(0.1)  # as if the bad samples had not been
    assert not step.rejected
    assert step.rejected_ever
    assert not clean.rejected_ever
    step.reset()
    assert not step.rejected_ever
    assert step(None) == logarithmic(model).output
    assert step.rejected


@every_model
def test_a_signal_at_once_is_the_same_steps(model):
    x = random_walk(np.random.default_rng(1), 500)
    x[[0, 200, 499]] = math.nan
    batch, single = logarithmic(model), logarithmic(model)
    y, rejected = batch.simulate(x)
    assert rejected == 3
    assert y.tobytes() == np.array([single(v) for v in x.tolist()]).tobytes()
    assert batch.save().tobytes() == single.save().tobytes()
    assert np.max(np.abs(model.stepper("dense").simulate(x)[0] - y)) <= 1e-14 * np.max(np.abs(y))


@every_model
def test_saved_states_continue_to_the_bit(model):
    x = random_walk(np.random.default_rng(2), 400).tolist()
    step = logarithmic(model)
    for k, v in enumerate(x[:200]):
        step(v)
        if k % 20 == 0:
            other = logarithmic(model)
            other.restore(step.save())
            assert other.save().tobytes() == step.save().tobytes()
    step(math.nan)
    image = step.save()
    expected = [step(v) for v in x[200:]]
    other = logarithmic(model)
    other.restore(image)
    assert other.rejected
    assert other.output == image[-2]
    assert np.array_equal(other.state, image[: other.state.size])
    assert [other(v) for v in x[200:]] == expected
    assert other.save().tobytes() == step.save().tobytes()
    step.restore(image)  # and back in time
    assert [step(v) for v in x[200:]] == expected


@every_model
def test_reset_returns_to_the_start_state_of_the_model_also_after_a_restore(model):
    x = random_walk(np.random.default_rng(3), 100).tolist()
    step, far = logarithmic(model), logarithmic(model)
    start, first = step.save(), [step(v) for v in x]
    far(1.5)
    step.restore(far.save())
    step.reset()
    assert step.save().tobytes() == start.tobytes()
    assert [step(v) for v in x] == first


@every_model
def test_hostile_images_are_refused_and_change_nothing(model):
    step = logarithmic(model)
    for v in (0.9, -0.8, 0.5, -0.2, 0.1):
        step(v)
    good, n = step.save(), step.state.size
    hostile = [
        good[:-1],
        good[1:],
        np.append(good, 0.0),
        np.zeros(0),
        good[: n + 2],
        np.zeros(good.size),
    ]
    hostile += [np.concatenate([good[:n], np.tile(good[n : n + 2], 3 * n + 5), good[-2:]])]
    for index in range(0, good.size, 1 if good.size < 50 else 7):
        for value in (*BAD, 1e99):
            image = good.copy()
            image[index] = value
            hostile.append(image)
    for index in range(n + 1, good.size - 2, 2):  # ends of segments
        for value in (0.0, -0.0, 0.5, n + 2.0, -(n + 2.0), 3e9, -1e99, good[index] + 0.5):
            image = good.copy()
            image[index] = value
            hostile.append(image)
    for flags in (1.0, 4.0, -1.0, 0.5, 1e9):
        hostile.append(np.append(good[:-1], flags))
    for image in hostile:
        with pytest.raises(ValueError, match="saved state"):
            step.restore(image)
        assert step.save().tobytes() == good.tobytes()
    with pytest.raises(TypeError):
        step.restore("not an array")


def test_images_of_another_model_and_of_the_dense_stepper_are_refused():
    r = [0.0, 0.25, 0.5]
    image_of, other = (
        logarithmic(PrandtlIshlinskii(r, [1.0, 1.0, 1.0])),
        logarithmic(PrandtlIshlinskii(r, [1, 2, 1])),
    )
    dense = PrandtlIshlinskii(r, [1.0, 2.0, 1.0]).stepper("dense")
    image_of(0.7)
    dense(0.7)
    with pytest.raises(ValueError, match="another model"):
        other.restore(image_of.save())
    with pytest.raises(ValueError, match="dense stepper"):
        other.restore(dense.save())
    with pytest.raises(ValueError, match="number of operators"):
        dense.restore(image_of.save())


def test_an_impossible_memory_is_refused_even_if_its_output_is_right():
    step = logarithmic(PrandtlIshlinskii([0.0, 0.25], [1.0, 0.0]))
    step(0.1)
    image = step.save()
    image[1] = -4.0
    with pytest.raises(ValueError, match="admissible"):
        step.restore(image)


def test_a_stepper_takes_over_from_the_other_kind():
    rng = np.random.default_rng(4)
    model = PrandtlIshlinskii(random_thresholds(rng, 20), random_weights(rng, 20, "positive"))
    dense = model.stepper("dense")
    for v in random_walk(rng, 100).tolist():
        dense(v)
    fast = model.with_state(dense.state).stepper("logarithmic")
    assert fast.output == pytest.approx(dense.output, abs=1e-15)
    for v in random_walk(rng, 100).tolist():
        assert fast(v) == pytest.approx(dense(v), abs=1e-14)


def test_a_compensator_of_the_joint_controller_may_come_from_either():
    model = PrandtlIshlinskii([0.0, 0.3, 0.8], [0.6, 0.2, 0.1]).inverse()
    parameters = JointControllerParameters(frozen_samples=0).as_dict()
    controllers = [
        _robot.JointController(
            parameters, model.stepper(m).parameters, None, Adaptation().as_dict()
        )
        for m in ("dense", "logarithmic")
    ]
    runs = []
    for controller in controllers:
        controller.reset(0.0, 3e5, 3e5)
        run = [
            controller.step(0.02 * k, 3e5, 3e5, (0.02 * k, 0.1, 0.0, 0.0, 3e5, 0.0, 0.0), 7)
            for k in range(20)
        ]
        runs.append((run, controller.compensator_state.tolist()))
    assert runs[0] == runs[1]
    assert runs[0][1] != [0.0, 0.0, 0.0]


@pytest.mark.parametrize("kind", [Stepper, StackStepper])
def test_a_call_takes_what_is_one_number_and_nothing_else(kind):
    parameters = PrandtlIshlinskii([0.0], [2.0]).stepper().parameters
    step = kind(*parameters)
    for sample in (1, True, np.float64(1.0), np.float32(1.0), np.int64(1), np.array(1.0), 1.0):
        assert step(sample) == step(x=sample) == step.__call__(sample) == 2.0
    for sample in ("1.0", [1.0], 1j, {}, np.zeros(2)):
        with pytest.raises(
            TypeError, match=f"a sample must be one number .* not a {type(sample).__name__}"
        ):
            step(sample)
    for arguments, names in (
        ((), {}),
        ((1.0, 2.0, 3.0), {}),
        ((), {"y": 1.0}),
        ((1.0,), {"x": 1.0}),
    ):
        with pytest.raises(TypeError, match="__call__"):
            step(*arguments, **names)
    with pytest.raises(TypeError):
        pickle.dumps(step)


@pytest.mark.parametrize("kind", [Stepper, StackStepper])
def test_an_object_that_was_never_made_is_an_error_and_subclasses_are_called_as_written(kind):
    parameters = PrandtlIshlinskii([0.0], [2.0]).stepper().parameters
    with pytest.raises(TypeError):
        kind.__new__(kind)(1.0)

    class Twice(kind):
        def __call__(self, x):
            return 2.0 * super().__call__(x)

    class Same(kind):
        pass

    assert Twice(*parameters)(1.0) == 4.0
    assert Same(*parameters)(1.0) == 2.0
    assert [*map(kind(*parameters), [1.0, 2.0])] == [2.0, 4.0]


def test_the_binding_refuses_arrays_that_do_not_fit_together():
    none = np.zeros(0)
    for r, w, z in ((0, 0, 0), (2, 1, 2), (2, 2, 1), (1, 1, 2)):
        with pytest.raises(ValueError, match="differ in length"):
            StackStepper(np.zeros(r), np.zeros(w), 0.0, 0.0, none, none, none, none, np.zeros(z))
