"""Real time: one sample a call, rejected samples, saved states."""

import math
import struct
import warnings

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dehyst import (
    ModifiedPrandtlIshlinskii,
    MonotoneMap,
    PrandtlIshlinskii,
    StopOperatorModel,
    _native,
)
from dehyst.models import RejectedSamplesWarning, StaticCurve
from in_one import in_one
from oracles import random_thresholds, random_walk, random_weights

LIMIT = _native.INPUT_LIMIT


def from_bits(pattern):
    return struct.unpack("<d", struct.pack("<Q", pattern))[0]


BAD = {
    "quiet NaN": from_bits(0x7FF8000000000000),
    "signalling NaN": from_bits(0x7FF0000000000001),
    "negative NaN with payload": from_bits(0xFFFFDEADBEEF1234),
    "infinity": from_bits(0x7FF0000000000000),
    "negative infinity": from_bits(0xFFF0000000000000),
    "1e300": 1e300,
    "-1e300": -1e300,
    "largest double": from_bits(0x7FEFFFFFFFFFFFFF),
    "just above the limit": math.nextafter(LIMIT, math.inf),
}
GOOD = [0.0, -0.0, 5e-324, -5e-324, 2.2250738585072014e-308, 1.0, -1.0, 1e99, LIMIT, -LIMIT]


def models():
    rng = np.random.default_rng(0)
    inner = PrandtlIshlinskii(
        random_thresholds(rng, 9), random_weights(rng, 9, "mixed"), 0.25, None, 0.1
    )
    bend = MonotoneMap([-2.0, 0.0, 2.0], [-1.0, 0.0, 3.0])
    return {
        "pi": inner,
        "inverse": inner.inverse(),
        "modified": ModifiedPrandtlIshlinskii(inner, after_map=bend, before_map=bend),
        "stop": StopOperatorModel([0.0, 0.3, 0.6], [0.0, 1.0, 0.5], 0.5),
        "static": StaticCurve(bend),
    }


every_model = pytest.mark.parametrize("model", models().values(), ids=models().keys())


@pytest.mark.parametrize("value", BAD.values(), ids=BAD.keys())
def test_the_guard_refuses_by_bit_pattern(value):
    assert not _native.accept(value)


@pytest.mark.parametrize("value", GOOD)
def test_the_guard_accepts_every_physical_number(value):
    assert _native.accept(value)


@given(st.integers(0, 2**64 - 1).map(from_bits))
def test_the_guard_is_a_comparison_with_the_limit(value):
    assert _native.accept(value) == (abs(value) <= LIMIT)


@every_model
@in_one("value", BAD.values())
def test_a_rejected_sample_holds_the_output_and_leaves_the_state(model, value):
    step = model.stepper()
    good = [step(x) for x in (0.3, -0.8, 0.5)][-1]
    state = step.state
    assert not step.rejected
    assert not step.rejected_ever
    for _ in range(3):
        assert step(value) == good == step.output
        assert step.rejected
        assert step.rejected_ever
        assert step.state.tobytes() == state.tobytes()
    clean = model.stepper()
    expected = [clean(x) for x in (0.3, -0.8, 0.5, 0.1)][-1]
    assert step(0.1) == expected  # as if the bad samples had not been
    assert not step.rejected
    assert step.rejected_ever  # sticky until the reset
    step.reset()
    assert not step.rejected_ever


@every_model
def test_bad_first_samples_hold_the_output_of_the_start_state(model):
    step = model.stepper()
    before = step.output
    assert step(math.nan) == before
    assert math.isfinite(before)


def close(y, want):
    """Compare long signals, which the engine evaluates: it agrees with the core to rounding."""
    return np.abs(y - want).max() <= 1e-14 * np.abs(want).max()


@every_model
@pytest.mark.parametrize("samples", [64, 5000])
def test_batch_and_stepper_give_the_same_bits_or_in_long_signals_the_same_to_rounding(
    model, samples
):
    rng = np.random.default_rng(1)
    x = random_walk(rng, samples)
    x[[0, 7, 8, samples // 2, samples - 1]] = [math.nan, math.inf, 1e300, -math.inf, math.nan]
    with pytest.warns(RejectedSamplesWarning, match=f"5 of {samples} samples"):
        batch = model.simulate(x)
    step = model.stepper()
    one_by_one = np.array([step(v) for v in x.tolist()])
    assert batch.tobytes() == one_by_one.tobytes() if samples < 100 else close(batch, one_by_one)
    assert np.all(np.isfinite(batch))
    assert np.ptp(batch) > 0.1
    assert np.allclose(model.final_state(x), step.state, rtol=0, atol=1e-15)


@every_model
def test_a_long_signal_leaves_the_stepper_as_steps_would(model):
    x = random_walk(np.random.default_rng(11), 5000)
    x[-1] = math.nan
    batch, step = model.stepper(), model.stepper()
    y, rejected = batch.simulate(x)
    for v in x.tolist():
        step(v)
    assert rejected == 1
    assert batch.rejected
    assert batch.rejected_ever
    assert abs(batch.output - step.output) <= 1e-14 * np.abs(y).max()
    again = model.stepper()
    again.restore(batch.save())  # the held output belongs to the states, bit for bit
    more = random_walk(np.random.default_rng(12), 50)
    assert [again(v) for v in more] == [batch(v) for v in more]


@every_model
@pytest.mark.parametrize("samples", [64, 5000])
def test_rejected_samples_change_no_other_output(model, samples):
    rng = np.random.default_rng(2)
    x = random_walk(rng, samples)
    y = model.simulate(x)
    holes = np.sort(rng.choice(samples, 10, replace=False))
    dirty = np.insert(x, holes, rng.choice(list(BAD.values()), 10))
    where = np.delete(np.arange(samples + 10), holes + np.arange(10))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RejectedSamplesWarning)
        found = model.simulate(dirty)[where]
    assert np.array_equal(found, y) if samples < 100 else close(found, y)


def test_a_clean_signal_warns_of_nothing():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        models()["pi"].simulate(np.linspace(-1, 1, 50))


@every_model
def test_simulate_never_moves_the_models_own_state(model):
    x = random_walk(np.random.default_rng(3), 100)
    assert np.array_equal(model.simulate(x), model.simulate(x))


@every_model
def test_saved_states_continue_as_if_nothing_had_happened(model):
    x = random_walk(np.random.default_rng(4), 200).tolist()
    step = model.stepper()
    for v in [*x[:100], math.nan]:
        step(v)
    image = step.save()
    assert image.shape == (step.state.size + 2,)
    expected = [step(v) for v in x[100:]]
    other = model.stepper()
    other.restore(image)
    assert other.rejected
    assert other.rejected_ever
    assert other.output == image[-2]
    assert [other(v) for v in x[100:]] == expected
    step.restore(image)  # and back in time
    assert [step(v) for v in x[100:]] == expected


@every_model
def test_reset_returns_to_the_start_state_of_the_model(model):
    x = random_walk(np.random.default_rng(5), 100).tolist()
    step = model.stepper()
    start, first = step.save(), [step(v) for v in x]
    step(math.nan)
    step.reset()
    assert step.save().tobytes() == start.tobytes()
    assert [step(v) for v in x] == first


def test_states_handed_out_are_copies():
    step = models()["pi"].stepper()
    step(0.5)
    state, image = step.state, step.save()
    kept = step.state.copy()
    state[:] = 99.0
    image[:] = 99.0
    assert np.array_equal(step.state, kept)


@every_model
def test_hostile_images_are_refused_and_change_nothing(model):
    step = model.stepper()
    for v in (0.3, -0.8, 0.5):
        step(v)
    good = step.save()
    n = good.size - 2
    hostile = [good[:-1], np.append(good, 0.0), np.zeros(0), np.zeros(n)]
    for index in range(good.size):
        for value in (*BAD.values(), 1e99):
            image = good.copy()
            image[index] = value
            hostile.append(image)
    for flags in (1.0, 4.0, -1.0, 0.5, 1e9):
        image = good.copy()
        image[-1] = flags
        hostile.append(image)
    for image in hostile:
        with pytest.raises(ValueError, match="saved state"):
            step.restore(image)
        assert step.save().tobytes() == good.tobytes()
    with pytest.raises(TypeError):
        step.restore("not an array")


def test_an_image_of_another_model_is_refused():
    r = [0.0, 0.25, 0.5]
    image_of = PrandtlIshlinskii(r, [1.0, 1.0, 1.0]).stepper()
    image_of(0.7)
    with pytest.raises(ValueError, match="another model"):
        PrandtlIshlinskii(r, [1.0, 2.0, 1.0]).stepper().restore(image_of.save())


def test_inadmissible_states_are_refused_on_restore():
    step = PrandtlIshlinskii([0.0, 0.25], [1.0, 0.0]).stepper()
    step(0.5)
    with pytest.raises(ValueError, match="admissible"):
        step.restore(np.array([0.5, -4.0, 0.5, 0.0]))  # its output is right, its memory impossible


@pytest.mark.parametrize("sample", ["1.0", "x", [1.0], 1j, 10**400, np.zeros(2), {}])
def test_a_sample_that_is_no_number_is_a_type_error_that_says_so_and_moves_nothing(sample):
    step = models()["pi"].stepper()
    step(0.5)
    before = step.save()
    with pytest.raises(
        TypeError, match=f"a sample must be one number .* not a {type(sample).__name__}"
    ):
        step(sample)
    assert step.save().tobytes() == before.tobytes()


@every_model
def test_a_sensor_that_gives_none_is_a_rejected_sample(model):
    step = model.stepper()
    assert step(None) == step.output == model.stepper().output
    held = step(0.3)
    assert not step.rejected
    assert step(None) == held
    assert step.rejected
    assert step.rejected_ever
    clean = model.stepper()
    clean(0.3)
    assert step(-0.8) == clean(-0.8)  # as if it had not been
    assert not step.rejected


@pytest.mark.parametrize(
    "sample", [1, True, np.float64(1.0), np.float32(1.0), np.int64(1), np.array(1.0)]
)
def test_everything_that_is_one_number_is_a_sample(sample):
    assert models()["pi"].stepper()(sample) == models()["pi"].stepper()(1.0)


def test_outputs_have_the_shape_of_the_input():
    model = models()["pi"]
    for samples in (0, 1, 2, 100):
        assert model.simulate(np.zeros(samples)).shape == (samples,)
    assert model.simulate(np.arange(6, dtype=np.float32)[::2]).shape == (3,)
