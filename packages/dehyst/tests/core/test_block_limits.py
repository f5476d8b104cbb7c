"""Blocks: the bits of the model while in range, bounded always, and exact again after every excursion."""

import struct

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from block_samples import LIMITED, REJECTED, inverse_block, operator_of, plain, sample, wishes
from dehyst import Block, PrandtlIshlinskii
from dehyst.models import BLOCK_FLAGS
from oracles import random_walk
from test_inverse import FAMILIES

SEEDS = st.integers(0, 100_000)
EXTREMES = [
    0.0,
    -0.0,
    5e-324,
    1e-308,
    1.0,
    1e99,
    1e100,
    1.0001e100,
    1e300,
    float("inf"),
    float("nan"),
]
EXTREMES += [-x for x in EXTREMES]


def number(bits):
    return struct.unpack("<d", bits.to_bytes(8, "little"))[0]


def tolerance(block):
    """1e-12 of the range, and a few roundings that first the inverse and then the model amplify: 1000-fold at most."""
    amplified = block.model.inverse_gain * operator_of(block).inverse_gain
    size = max(abs(block.input.low), abs(block.input.high))
    return 1e-12 * (block.input.high - block.input.low) + 4 * np.finfo(float).eps * amplified * size


@given(SEEDS)
def test_a_forward_block_in_range_has_the_bits_of_the_model(seed):
    model, bounds, rng = sample(seed)
    block = Block(model, "forward", bounds)
    x = np.interp(random_walk(rng, 300), [-1.0, 1.0], bounds)
    y, flags = block.run(x)
    expected, state = plain(model, x)
    assert y.tobytes() == expected.tobytes()
    assert not flags.any()
    assert block.state.tobytes() == state.tobytes()


@given(SEEDS)
def test_an_inverse_block_in_range_has_the_bits_of_the_inverse(seed):
    block, _, bounds, rng = inverse_block(seed)
    x = np.interp(random_walk(rng, 300), [-1.0, 1.0], [bounds[0] + 1e-6, bounds[1] - 1e-6])
    y, _ = plain(operator_of(block).inverse(), x)  # from where the actuator is
    needed, flags = block.run(y)
    expected, state = plain(operator_of(block), y)
    assert needed.tobytes() == expected.tobytes()
    assert not flags.any()
    assert block.state.tobytes() == state.tobytes()


@given(SEEDS)
def test_after_any_excursion_the_actuator_gives_the_reference_back_wherever_it_can_be_reached(seed):
    block, model, (low, high), rng = inverse_block(seed)
    wanted = wishes(block, rng)
    needed, flags = block.run(wanted)
    assert np.all((needed >= low) & (needed <= high))
    got, _ = plain(model, needed)
    free = (flags & LIMITED) == 0
    assert np.all(np.abs(got - wanted)[free] <= tolerance(block))
    # Where it is limited the actuator stands at its end, on the side of what is wanted, or that lies beyond all reach.
    at_end = np.minimum(needed - low, high - needed) <= 1e-14 * max(abs(low), abs(high), high - low)
    beyond = (wanted < block.input.low) | (wanted > block.input.high)
    assert np.all(at_end[~free] | beyond[~free])


@pytest.mark.parametrize("family", FAMILIES)
def test_excursions_happen_and_a_plain_inverse_errs_after_them(family):
    hits, erring = 0, 0
    for trial in range(8):
        block, model, (low, high), rng = inverse_block(
            FAMILIES.index(family) + len(FAMILIES) * trial
        )
        wanted = wishes(block, rng)
        _, flags = block.run(wanted)
        free = (flags & LIMITED) == 0
        hits += bool(np.any(free)) and bool(np.any(~free))
        cut, _ = plain(model, np.clip(plain(operator_of(block), wanted)[0], low, high))
        erring += bool(
            np.any(np.abs(cut - wanted)[free] > 1e-3 * (block.input.high - block.input.low))
        )
    assert hits >= 6
    assert erring >= 6 or family == "static"  # a curve remembers nothing


@given(SEEDS)
def test_states_of_a_block_are_those_of_the_inverse_of_the_actuator_it_drove(seed):
    block, model, _, rng = inverse_block(seed)
    needed, _ = block.run(wishes(block, rng))
    _, state = plain(model, needed)
    expected = model.with_state(state).inverse().stepper("dense").state
    if model.family == "static":
        return  # its one state is the last sample
    size = max(float(np.ptp(expected)), block.input.high - block.input.low)
    assert np.max(np.abs(block.state - expected)) <= 1e-11 * size


@given(SEEDS, st.lists(st.integers(0, 2**64 - 1), max_size=30), st.booleans())
@example(3, list(range(2**52 * 2047 - 3, 2**52 * 2047 + 3)), True)
def test_output_lies_within_its_range_for_every_bit_pattern(seed, patterns, forward):
    model, bounds, rng = sample(seed)
    block = Block(model, "forward" if forward else "inverse", bounds, ramp=4)
    x = [number(bits) for bits in patterns] + [float(v) for v in rng.permutation(EXTREMES)]
    y, flags = block.run(x, rng.random(len(x)) < 0.7)
    assert np.all((y >= block.output.low) & (y <= block.output.high))
    bad = ~(np.abs(x) <= 1e100)
    assert np.array_equal((flags & REJECTED) != 0, bad)
    assert np.all(np.isfinite(block.state))
    y, _ = block.run(wishes(block, rng))
    assert np.all((y >= block.output.low) & (y <= block.output.high))


def test_a_rejected_sample_holds_the_output_raises_a_flag_and_moves_no_state():
    block = Block(PrandtlIshlinskii([0.0, 0.3], [1.0, 0.5]), range=(-1.0, 1.0))
    held = [block.step(0.2), block.step(0.7)][1]
    state = block.state
    for x in (float("nan"), float("inf"), -1e101, None):
        assert block.step(x) == held
        assert block.flags == BLOCK_FLAGS["rejected"] | BLOCK_FLAGS["rejected-ever"]
        assert block.state.tobytes() == state.tobytes()
    block.step(0.6)
    assert block.flags == BLOCK_FLAGS["rejected-ever"]
    block.reset()
    assert block.flags == 0


def test_a_limited_sample_says_so_and_so_does_the_memory_of_it():
    block = Block(PrandtlIshlinskii([0.0, 0.2], [1.0, 1.0]), range=(0.0, 1.0))
    flags = block.run([0.5, 1.9, 1.9, 1.8, 1.0])[1].tolist()
    limited, ever = BLOCK_FLAGS["limited"], BLOCK_FLAGS["limited-ever"]
    assert flags == [0, limited | ever, limited | ever, ever, ever]


def test_a_model_started_beyond_the_range_begins_as_one_that_was_brought_into_it():
    model = PrandtlIshlinskii([0.0, 0.2, 0.5], [1.0, 0.7, 0.5])
    far = model.with_state(model.final_state([3.0]))
    block = Block(far, range=(-1.0, 1.0))
    assert block.last == pytest.approx(1.0, abs=1e-15)
    wanted = np.linspace(block.step(99.0) * 0 + block.input.high, block.input.low, 50)[1:]
    needed, flags = block.run(wanted)
    got, _ = plain(far, np.concatenate([[1.0], needed]))
    free = (flags & LIMITED) == 0
    assert np.sum(free) > 20
    np.testing.assert_allclose(got[1:][free], wanted[free], rtol=0, atol=1e-14)


def test_the_worked_example_of_an_excursion_by_hand():
    # y = play_0 + play_0.2, input 0..1: up to 1 it reaches 1.8; from there back, first only play_0 moves.
    block = Block(PrandtlIshlinskii([0.0, 0.2], [1.0, 1.0]), range=(0.0, 1.0))
    needed, _ = block.run([5.0, 1.8, 1.4, 1.2, 0.0, -7.0, 0.0, 0.3])
    np.testing.assert_allclose(needed, [1.0, 1.0, 0.6, 0.5, 0.0, 0.0, 0.0, 0.1], rtol=0, atol=1e-15)
