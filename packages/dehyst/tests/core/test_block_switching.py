"""Blocks are switched without a bump, and what they remember does not depend on the switch."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from block_samples import LIMITED, inverse_block, sample, wishes
from dehyst import Block, PrandtlIshlinskii
from dehyst.errors import ParameterError

SEEDS = st.integers(0, 100_000)
MODEL = PrandtlIshlinskii([0.0, 0.2, 0.4], [0.6, 0.3, 0.3])


def switched(rng, samples):
    """Return switches that stay for a few samples each."""
    return np.repeat(rng.random(samples // 5 + 1) < 0.5, 5)[:samples]


def line(block, x):
    p = block.parameters
    taken = np.clip(x, p.input_low, p.input_high)
    return np.clip(p.line_offset + p.line_slope * taken, p.output_low, p.output_high)


@given(SEEDS)
def test_no_output_jumps_by_more_than_model_and_line_moved_and_a_ramps_share_of_their_distance(
    seed,
):
    block, _, _, rng = inverse_block(seed)
    x = wishes(block, rng)
    always, _ = block.run(x)
    block.reset()
    y, _ = block.run(x, switched(rng, x.size))
    straight = line(block, x)
    moved = np.maximum(np.abs(np.diff(always)), np.abs(np.diff(straight)))
    distance = np.maximum(np.abs(always - straight)[1:], np.abs(always - straight)[:-1])
    size = block.output.high - block.output.low
    assert np.all(np.abs(np.diff(y)) <= moved + distance / block.ramp + 1e-12 * size)
    low, high = np.minimum(always, straight), np.maximum(always, straight)
    assert np.all((y >= low - 1e-12 * size) & (y <= high + 1e-12 * size))


@given(SEEDS, st.booleans())
def test_states_and_flags_follow_the_input_whether_it_is_on_or_not(seed, forward):
    model, bounds, rng = sample(seed)
    direction = "forward" if forward else "inverse"
    on, other = Block(model, direction, bounds), Block(model, direction, bounds)
    x = wishes(on, rng)
    _, flags = on.run(x)
    _, other_flags = other.run(x, switched(rng, x.size))
    assert on.state.tobytes() == other.state.tobytes()
    assert np.array_equal(flags & LIMITED, other_flags & LIMITED)


@pytest.mark.parametrize("on", [True, False])
def test_the_first_good_sample_begins_where_it_is_told_to(on):
    block = Block(MODEL, range=(-1.0, 1.0), ramp=100)
    plain = MODEL.inverse().stepper("dense")
    for x in (float("nan"), 0.3):
        y = block.step(x, on)
    assert block.share == float(on)
    assert y == (plain(0.3) if on else line(block, 0.3))


def test_switching_takes_the_ramp_and_ends_with_the_bits_of_the_model():
    block = Block(MODEL, range=(-1.0, 1.0), ramp=10)
    plain = MODEL.inverse().stepper("dense")
    block.step(0.3, False)
    plain(0.3)
    shares = []
    for _ in range(12):
        y = block.step(0.3, True)
        shares.append(block.share)
    np.testing.assert_allclose(shares[:10], np.arange(1, 11) / 10, rtol=1e-14)
    assert shares[10:] == [1.0, 1.0]
    assert y == plain(0.3)
    for _ in range(12):
        y = block.step(0.3, False)
    assert block.share == 0.0
    assert y == line(block, 0.3)


def test_a_ramp_of_one_sample_switches_at_once():
    block = Block(MODEL, range=(-1.0, 1.0), ramp=1)
    shares = []
    for on in (True, False, True):
        block.step(0.1, on)
        shares.append(block.share)
    assert shares == [1.0, 0.0, 1.0]


@given(SEEDS, st.booleans())
def test_the_line_of_an_inverse_block_undoes_that_of_the_forward_block_and_joins_the_ends_of_the_loop(
    seed, forward
):
    model, (low, high), _ = sample(seed)
    there, back = (
        Block(model, "forward", (low, high)).parameters,
        Block(model, "inverse", (low, high)).parameters,
    )
    x = np.linspace(low, high, 5)
    y = there.line_offset + there.line_slope * x
    np.testing.assert_allclose(
        back.line_offset + back.line_slope * y, x, rtol=0, atol=1e-9 * (high - low)
    )
    step = model.stepper("dense")
    ends = [step(v) for v in (low, high, low)][:0:-1]
    np.testing.assert_allclose(y[[0, -1]], ends, rtol=0, atol=1e-12 * (abs(ends[0]) + abs(ends[1])))


@given(SEEDS, st.booleans())
def test_single_steps_have_the_bits_and_the_flags_of_a_run(seed, forward):
    model, bounds, rng = sample(seed)
    one, many = (
        Block(model, "forward" if forward else "inverse", bounds, ramp=7) for _ in range(2)
    )
    x = wishes(one, rng, 100)
    x[rng.random(x.size) < 0.1] = np.nan
    on = switched(rng, x.size)
    y, flags = many.run(x, on)
    for k, (v, switch) in enumerate(zip(x.tolist(), on.tolist(), strict=True)):
        assert one.step(v, switch) == y[k]
        assert one.flags == flags[k]
    assert one.last == many.last


@pytest.mark.parametrize("on", [True, 1, np.True_, np.float64(0.5)])
def test_a_step_takes_numbers_and_switches_of_every_kind(on):
    block = Block(MODEL, range=(-1.0, 1.0))
    assert block.step(np.float32(0.5), on) == MODEL.inverse().stepper("dense")(0.5)
    assert block.share == 1.0


@pytest.mark.parametrize(
    ("x", "on"), [("high", True), ([0.1, 0.2], True), (1j, True), (0.1, np.array([True, False]))]
)
def test_a_step_of_anything_else_is_refused_and_moves_nothing(x, on):
    block = Block(MODEL, range=(-1.0, 1.0))
    before = block.save()
    with pytest.raises(ParameterError, match="one number"):
        block.step(x, on)
    assert block.save().tobytes() == before.tobytes()
